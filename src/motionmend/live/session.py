"""One client's correction: a hello opens it, each frame gives an answer and the session after it."""

import time
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, final

import numpy as np

from ..bodies.postures import NOT_TRACKED
from .messages import Answer, Frame, Hello, MessageError

if TYPE_CHECKING:
    from ..correct import CorrectorModel

BACK = 1.0  # s; a clock that goes back farther starts a recording anew
STILL = 1e-6  # s; the least step between two frames
_EPOCH = time.time() - time.perf_counter()


def now() -> float:
    """Unix time in s that never goes back while the process runs."""
    return _EPOCH + time.perf_counter()


@final
@dataclass(frozen=True, eq=False)
class Session:
    """A client after its hello: what it said, the corrector's state, and the time of its last frame in s."""

    hello: Hello
    state: Any
    last: float | None = None


def opened(model: "CorrectorModel", hello: Hello) -> Session:
    """A session at its start.

    Raises
    ------
    MessageError : the model knows none of the client's joints.
    """
    from ..errors import MotionMendError

    try:
        return Session(hello, model.start(hello.names, hello.fps))
    except MotionMendError as error:
        raise MessageError(str(error)) from None


def answered(model: "CorrectorModel", session: Session, frame: Frame, t_in: float) -> tuple[Session, Answer]:
    """The session after a frame, and the answer to it.

    Frames at the same time, or a little before the last, are taken as the next instant. A clock that goes back by more
    than a second is a recording that begins anew: the state does so too, and the answer is flagged `restarted`.

    Parameters
    ----------
    model : the corrector.
    session : after the frame before.
    frame : as the client sent it.
    t_in : s, `now()` when it came.

    Raises
    ------
    MessageError : the frame cannot be corrected; the session then stays as it was.
    """
    flags: tuple[str, ...] = ()
    if session.last is not None and frame.t < session.last - BACK:
        session = replace(opened(model, session.hello), last=None)
        flags = ("restarted",)
    time_of = frame.t if session.last is None else max(frame.t, session.last + STILL)
    if session.last is None and not np.isfinite(frame.joints).any():
        raise MessageError("joints: somebody was wanted in the first frame, all joints are missing", frame.seq)
    state, corrected = model.step(session.state, frame.joints, _states(frame), time_of)
    answer = Answer(
        frame.seq,
        t_in,
        now(),
        corrected.positions,
        corrected.reliability,
        corrected.std,
        (*flags, *corrected.flags),
    )
    return Session(session.hello, state, time_of), answer


def _states(frame: Frame) -> Any:
    """What the client says of its joints; joints without a position are not tracked, whoever says so."""
    missing = ~np.isfinite(frame.joints).all(axis=1)
    if frame.state is None or not missing.any():
        return frame.state
    return np.where(missing, NOT_TRACKED, frame.state).astype(np.uint8)


def leaving(answer: Answer, *flags: str) -> Answer:
    """The answer as it leaves the server now, with some flags more."""
    return replace(answer, t_out=now(), flags=(*answer.flags, *flags))
