"""One client's correction: messages in, replies out, and the session after each."""

import math
import time
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, final

import numpy as np

from ..arrays import Floats
from ..io.kinect_table import LARGEST_BODY
from .messages import (
    Answer,
    Frame,
    Hello,
    MessageError,
    decode,
    encode_answer,
    encode_error,
    is_end,
    is_hello,
    read_frame,
    read_hello,
    whole_number,
)

if TYPE_CHECKING:
    from ..correct import Corrected, CorrectorModel

BACK = 1.0  # s; a clock that goes back farther starts a recording anew
HASTE = (
    300.0  # times as long as the hello's rate has it: steps between frames in other units than s are a thousand or more
)
SLOW = 5.0  # Hz; a hello of less promises frames that are as far apart as their numbers
COUNTED = 1.0  # s; steps of whole numbers by just that count frames
STRANGE = 3  # steps on end that no clock in s makes
STILL = 1e-6  # s; the least step between two frames
EARLY = 0.9  # of a step at the hello's rate; who stamps frames as they come in has them come in together
AHEAD = 0.2  # s, by which what frames are taken for may be ahead of their stamps
NO_HELLO = "a hello {v, skeleton, fps, units} was wanted before the first frame"
_EPOCH = time.time() - time.perf_counter()


def now(epoch: float = _EPOCH) -> float:
    """Unix time in s that never goes back while the process runs."""
    return epoch + time.perf_counter()


@final
@dataclass(frozen=True, eq=False)
class Session:
    """A client after its hello: what it said, the corrector's state, and in s what its last frame was taken for, and
    the latest of its own times.

    `online` says whether the corrector learns from the client's frames, `look_ahead` for how many s of frames an answer
    waits, and `latency_ms` how long that is in whole frames; `owed` are the frames not answered yet, the oldest first;
    `strange` counts the steps on end that no clock in s makes, up to the frame `before`.
    """

    hello: Hello
    state: Any
    last: float | None = None
    latest: float = -math.inf
    online: bool = False
    look_ahead: float = 0.0
    latency_ms: float = 0.0
    owed: tuple["Owed", ...] = ()
    strange: int = 0
    before: Frame | None = None


@final
@dataclass(frozen=True, eq=False)
class Owed:
    """A frame that waits for its answer: when it came in s, and the flags to be added to the answer's."""

    frame: Frame
    t_in: float
    flags: tuple[str, ...]


@final
@dataclass(frozen=True, eq=False)
class Reply:
    """What is to be done about a message.

    Attributes
    ----------
    data : to be sent back; None after a hello, and for a frame whose answer waits.
    hello : of a session that has just begun.
    frame, answer : what `data` answers, and with what, where that was asked for.
    error : whether `data` is one.
    before : replies to be given before this one.
    """

    data: bytes | str | None
    hello: Hello | None = None
    frame: Frame | None = None
    answer: Answer | None = None
    error: bool = False
    before: tuple["Reply", ...] = ()

    @property
    def plain(self) -> bool:
        """Whether it is data to be sent back and nothing else."""
        return self.data is not None and not (self.hello or self.frame or self.error or self.before)


def replied(
    model: "CorrectorModel",
    session: Session | None,
    message: bytes | str,
    t_in: float,
    flags: tuple[str, ...] = (),
    whole: bool = False,
    online: bool = False,
    look_ahead: float = 0.0,
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
    look_ahead : s of frames for which an answer of a session that begins waits.
    """
    text = isinstance(message, str)
    try:
        fields, _ = decode(message)
        if is_hello(fields):
            # Whatever comes of it, the one before has ended, and what it owed is answered first.
            owed = () if session is None else tuple(_reply(*one, whole) for one in rested(model, session)[1])
            session = None
            try:
                session = opened(model, read_hello(fields), online, look_ahead)
            except MessageError as error:
                return None, Reply(encode_error(error, text), error=True, before=owed)
            return session, Reply(None, hello=session.hello, before=owed)
        if is_end(fields):
            if session is None:
                return session, Reply(None)
            session, answers = rested(model, session)
            return session, Reply(None, before=tuple(_reply(*one, whole) for one in answers))
        if session is None:
            raise MessageError(NO_HELLO, whole_number(fields.get("seq")))
        frame = read_frame(fields, session.hello, text)
        session, answers = answered(model, session, frame, t_in, flags)
        *before, last = [_reply(*one, whole) for one in answers] or [Reply(None)]
        return session, replace(last, before=tuple(before)) if before else last
    except MessageError as error:
        return session, Reply(encode_error(error, text), error=True)
    except Exception as error:  # a defect must not reach the other clients of this process
        said = MessageError(
            f"unexpected {type(error).__name__} in this frame, the next goes on: a defect of motionmend"
        )
        return session, Reply(encode_error(said, text), error=True)


def _reply(frame: Frame, answer: Answer, whole: bool) -> Reply:
    data = encode_answer(answer, frame.form)
    return Reply(data, frame=frame, answer=answer) if whole else Reply(data)


def opened(model: "CorrectorModel", hello: Hello, online: bool = False, look_ahead: float = 0.0) -> Session:
    """A session at its start; `online` and `look_ahead` as of `replied`.

    Raises
    ------
    MessageError : the model knows none of the client's joints.
    """
    from ..correct.look_ahead import frames_in
    from ..errors import MotionMendError

    try:
        frames = frames_in(look_ahead, hello.fps)
        state = model.start(hello.names, online, frames)
        return Session(
            hello, state, online=online, look_ahead=look_ahead, latency_ms=round(1000.0 * frames / hello.fps, 3)
        )
    except MotionMendError as error:
        raise MessageError(str(error)) from None


def answered(
    model: "CorrectorModel", session: Session, frame: Frame, t_in: float, flags: tuple[str, ...] = ()
) -> tuple[Session, list[tuple[Frame, Answer]]]:
    """The session after a frame, and what can be answered now: this frame, or the one that has waited for it.

    Frames that come together, or at the same time, are taken as evenly as their rate has them, as far as their
    times allow; those from a little before the last as the next instant. A clock that goes back by more than a
    second is a recording that begins anew: the state does so too, and the answer is flagged `restarted`. What was
    owed until then is answered first. Times that contradict the hello's rate frame after frame, as milliseconds do,
    stand still or count frames are flagged `clock`.

    Parameters
    ----------
    model, session, t_in, flags : as of `replied`.
    frame : as the client sent it.

    Raises
    ------
    MessageError : the frame cannot be corrected; the session then stays as it was.
    """
    reach = _reach(frame.joints)
    if reach > LARGEST_BODY:
        came = f"came a body half of which is {reach:.3g} and more from its middle"
        raise MessageError(f"joints: metres were wanted, {came}: is it centimetres?", frame.seq)
    answers: list[tuple[Frame, Answer]] = []
    if frame.t < session.latest - BACK:
        _, answers = rested(model, session)
        session = opened(model, session.hello, session.online, session.look_ahead)
        flags = (*flags, "restarted")
    strange = session.strange + 1 if _no_clock(session.before, frame, session.hello.fps) else 0
    flags = (*flags, "clock") if strange >= STRANGE else flags
    time_of = _taken(session, frame.t)
    state, corrected = model.feed(session.state, frame.joints, frame.state, time_of)
    owed = (*session.owed, Owed(frame, t_in, flags))
    if corrected is not None:
        answers.append(_answer(session, owed[0], corrected))
        owed = owed[1:]
    latest = max(session.latest, frame.t)
    after = replace(session, state=state, last=time_of, latest=latest, owed=owed, strange=strange, before=frame)
    return after, answers


def _taken(session: Session, t: float) -> float:
    """s, when a frame was taken that says it was at `t`: not much sooner after the last one than the rate has it.

    One that was overtaken by a later one is old: it is taken for the next instant. A hello of a few frames a second
    says little of when they were taken.
    """
    if session.last is None:
        return t
    fps = session.hello.fps
    usual = EARLY / fps if t >= session.latest and fps > SLOW else 0.0
    return max(t, min(session.last + usual, t + AHEAD), session.last + STILL)


def _reach(joints: Floats) -> float:
    """How far the median joint of a frame (J, 3) is from their middle; 0 where that is surely no more than anybody's.

    A few joints that are thrown far off make no giant. Joints at the sensor itself, where some put what they miss, are
    not asked.
    """
    seen = joints[np.isfinite(joints).all(axis=1) & joints.any(axis=1)]
    about = seen - seen.sum(axis=0) / max(len(seen), 1)
    if np.vdot(about, about) <= len(seen) * (LARGEST_BODY / 2) ** 2:  # then the median joint is within, by Chebyshev
        return 0.0
    return float(np.median(np.linalg.norm(seen - np.median(seen, axis=0), axis=1)))


def _no_clock(before: Frame | None, frame: Frame, fps: float) -> bool:
    """Whether no clock in s steps so: as far as in other units, not at all while joints move, or to the next number."""
    if before is None:
        return False
    step = frame.t - before.t
    if step == 0.0:
        return not np.array_equal(frame.joints, before.joints, equal_nan=True)
    return step * fps > HASTE or (step == COUNTED and frame.t.is_integer() and fps > SLOW)


def rested(model: "CorrectorModel", session: Session) -> tuple[Session, list[tuple[Frame, Answer]]]:
    """The session once nothing is owed, and the answers that were."""
    state, found = model.rest(session.state)
    answers = [_answer(session, one, corrected) for one, corrected in zip(session.owed, found, strict=True)]
    return replace(session, state=state, owed=()), answers


def _answer(session: Session, owed: Owed, corrected: "Corrected") -> tuple[Frame, Answer]:
    return owed.frame, Answer(
        owed.frame.seq,
        owed.t_in,
        max(now(), owed.t_in),
        corrected.positions,
        corrected.reliability,
        corrected.std,
        (*owed.flags, *corrected.flags),
        session.latency_ms,
    )
