"""One client's correction: messages in, replies out, and the session after each."""

import time
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, final

import numpy as np

from .messages import (
    Answer,
    Frame,
    Hello,
    MessageError,
    decode,
    encode_answer,
    encode_error,
    is_hello,
    read_frame,
    read_hello,
)

if TYPE_CHECKING:
    from ..correct import CorrectorModel

BACK = 1.0  # s; a clock that goes back farther starts a recording anew
STILL = 1e-6  # s; the least step between two frames
NO_HELLO = "a hello {v, skeleton, fps, units} was wanted before the first frame"
_EPOCH = time.time() - time.perf_counter()


def now(epoch: float = _EPOCH) -> float:
    """Unix time in s that never goes back while the process runs."""
    return epoch + time.perf_counter()


@final
@dataclass(frozen=True, eq=False)
class Session:
    """A client after its hello: what it said, the corrector's state, and the time of its last frame in s.

    `online` says whether the corrector learns from the client's frames.
    """

    hello: Hello
    state: Any
    last: float | None = None
    online: bool = False


@final
@dataclass(frozen=True, eq=False)
class Reply:
    """What is to be done about a message.

    Attributes
    ----------
    data : to be sent back; None after a hello.
    hello : of a session that has just begun.
    frame, answer : what `data` answers, and with what, where that was asked for.
    error : whether `data` is one.
    """

    data: bytes | str | None
    hello: Hello | None = None
    frame: Frame | None = None
    answer: Answer | None = None
    error: bool = False


def replied(
    model: "CorrectorModel",
    session: Session | None,
    message: bytes | str,
    t_in: float,
    flags: tuple[str, ...] = (),
    whole: bool = False,
    online: bool = False,
) -> tuple[Session | None, Reply]:
    """The session after a message, and the reply to it.

    Parameters
    ----------
    model : the corrector.
    session : after the message before; None before a hello.
    message : as it came.
    t_in : s, `now()` when it came.
    flags : to be added to an answer's.
    whole : whether the reply shall hold frame and answer, too.
    online : whether a session that begins learns from its client's frames.
    """
    text = isinstance(message, str)
    try:
        fields, _ = decode(message)
        if is_hello(fields):
            session = None  # whatever comes of it, the one before has ended
            session = opened(model, read_hello(fields), online)
            return session, Reply(None, hello=session.hello)
        if session is None:
            raise MessageError(NO_HELLO, fields["seq"] if type(fields.get("seq")) is int else None)
        frame = read_frame(fields, session.hello, text)
        session, answer = answered(model, session, frame, t_in, flags)
        data = encode_answer(answer, frame.form)
        return session, Reply(data, frame=frame, answer=answer) if whole else Reply(data)
    except MessageError as error:
        return session, Reply(encode_error(error, text), error=True)
    except Exception as error:  # a defect must not reach the other clients of this process
        said = MessageError(
            f"unexpected {type(error).__name__} in this frame, the next goes on: a defect of motionmend"
        )
        return session, Reply(encode_error(said, text), error=True)


def opened(model: "CorrectorModel", hello: Hello, online: bool = False) -> Session:
    """A session at its start; `online` as of `replied`.

    Raises
    ------
    MessageError : the model knows none of the client's joints.
    """
    from ..errors import MotionMendError

    try:
        return Session(hello, model.start(hello.names, hello.fps, online), online=online)
    except MotionMendError as error:
        raise MessageError(str(error)) from None


def answered(
    model: "CorrectorModel", session: Session, frame: Frame, t_in: float, flags: tuple[str, ...] = ()
) -> tuple[Session, Answer]:
    """The session after a frame, and the answer to it.

    Frames at the same time, or a little before the last, are taken as the next instant. A clock that goes back by more
    than a second is a recording that begins anew: the state does so too, and the answer is flagged `restarted`.

    Parameters
    ----------
    model, session, t_in, flags : as of `replied`.
    frame : as the client sent it.

    Raises
    ------
    MessageError : the frame cannot be corrected; the session then stays as it was.
    """
    if session.last is not None and frame.t < session.last - BACK:
        session = opened(model, session.hello, session.online)
        flags = (*flags, "restarted")
    if session.last is None:
        if not np.isfinite(frame.joints).any():
            raise MessageError("joints: somebody was wanted in the first frame, all joints are missing", frame.seq)
        time_of = frame.t
    else:
        time_of = max(frame.t, session.last + STILL)
    state, corrected = model.step(session.state, frame.joints, frame.state, time_of)
    answer = Answer(
        frame.seq,
        t_in,
        max(now(), t_in),
        corrected.positions,
        corrected.reliability,
        corrected.std,
        (*flags, *corrected.flags),
    )
    return replace(session, state=state, last=time_of), answer
