"""Repair while the recording is still being made: every frame is given out a fixed time after it came in.

The adaptive repair is done again and again on the latest frames. Those older than the lag are given out and never
change. State goes in and comes out, so that streams can be stopped, kept and gone on with.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Generic

import numpy as np

from ..arrays import Bytes, Floats
from ..bodies.motion import Markers, Motion, Recording, Repaired
from ..errors import MismatchError, UsageError
from .outcome import left_open

if TYPE_CHECKING:
    from .model import DenoiserModel


@dataclass(frozen=True)
class FixedLag:
    """How late frames are given out, and how much a repair sees.

    Attributes
    ----------
    lag : s of frames after a frame that are waited for at least; 0 asks the past alone.
    memory : s of frames before those given out that a repair sees.
    hop : s of frames given out together; one frame at least. A repair takes about as long for few frames as for many,
        so that half the hop doubles the work.
    """

    lag: float = 0.5
    memory: float = 2.0
    hop: float = 0.25

    def __post_init__(self) -> None:
        if not (np.isfinite(self.lag) and self.lag >= 0):
            raise UsageError(f"a lag of 0 s or more was wanted, came {self.lag}")
        if not (np.isfinite(self.memory) and self.memory > 0):
            raise UsageError(f"a memory above 0 s was wanted, came {self.memory}")
        if not (np.isfinite(self.hop) and self.hop >= 0):
            raise UsageError(f"a hop of 0 s or more was wanted, came {self.hop}")

    def frames(self, fps: float) -> tuple[int, int, int]:
        """Lag, memory and hop in frames at `fps` Hz."""
        return round(self.lag * fps), max(1, round(self.memory * fps)), max(1, round(self.hop * fps))

    def latency(self, fps: float) -> float:
        """Seconds after which the last frame of a hop has waited longest: lag and hop less one frame, at `fps` Hz."""
        lag, _, hop = self.frames(fps)
        return (lag + hop - 1) / fps


@dataclass(frozen=True, eq=False)
class Live(Generic[Recording]):
    """A repair under way.

    Attributes
    ----------
    settings : lag, memory and hop.
    model : that repairs.
    recent : the latest frames as they came in.
    seen : frames that came in so far.
    given : frames given out so far.
    """

    settings: FixedLag
    model: "DenoiserModel"
    recent: Recording
    seen: int = 0
    given: int = 0


def start(model: "DenoiserModel", like: Recording, settings: FixedLag | None = None) -> Live[Recording]:
    """A repair that has seen nothing yet.

    Parameters
    ----------
    model : fitted on recordings of this kind.
    like : any recording with the channels and rate of the frames to come; its frames are not looked at.
    settings : lag, memory and hop; None for the usual ones.
    """
    return Live(settings or FixedLag(), model, _part(like, slice(0, 0)))


def step(state: Live[Recording], frames: Floats) -> tuple[Live[Recording], tuple[Repaired[Recording], ...]]:
    """Take in one frame or several; give out what is finished.

    Parameters
    ----------
    state : of `start` or of the step before; it stays as it was.
    frames : (D,) or (n, D) rad and m for motions, (M, 3) or (n, M, 3) m for markers; NaN = missing.

    Returns
    -------
    The next state, and the finished frames, oldest first: every frame once and in order. A frame is given out when
    `lag` to `lag + hop - 1` frames more have come in, and depends on none after these. How the frames are dealt out
    over the calls changes nothing.

    Raises
    ------
    MismatchError : frames of other channels.
    """
    lag, memory, hop = state.settings.frames(state.recent.fps)
    finished = []
    for frame in _frames(state.recent, frames):
        latest = np.concatenate([state.recent.values, frame[None]])[-(memory + lag + hop) :]
        state = replace(state, recent=state.recent.with_values(latest), seen=state.seen + 1)
        due = state.seen - lag
        if due > 0 and due % hop == 0:
            finished.append(_finished(state, due))
            state = replace(state, given=due)
    return state, tuple(finished)


def finish(state: Live[Recording]) -> Repaired[Recording] | None:
    """The frames that still wait, when no more come; None where none does."""
    return _finished(state, state.seen) if state.seen > state.given else None


def repair_with_lag(
    model: "DenoiserModel", recording: Recording, settings: FixedLag | None = None
) -> Repaired[Recording]:
    """What a live repair would have given out for a whole recording.

    Parameters
    ----------
    model : fitted on recordings of this kind.
    recording : of the model's channels.
    settings : lag, memory and hop; None for the usual ones.

    Raises
    ------
    MismatchError : the recording is of another kind or channel set.
    """
    if recording.frames == 0:
        return model.repair(recording, "adaptive")
    finished: tuple[Repaired[Recording], ...]
    state, finished = step(start(model, recording, settings), recording.values)
    last = finish(state)
    pieces = list(finished)
    if last is not None:
        pieces.append(last)
    return joined(recording, pieces)


def joined(recording: Recording, pieces: Sequence[Repaired[Recording]]) -> Repaired[Recording]:
    """Finished frames, all of a recording's and in order, as its repair.

    Of the pieces' warnings those are kept that at least half of them give, numbers aside.
    """
    values = np.concatenate([piece.recording.values for piece in pieces])
    origin: Bytes = np.concatenate([piece.origin for piece in pieces])
    frames = [piece.recording.frames for piece in pieces]
    noises = [piece.noise for piece in pieces if piece.noise is not None]
    return Repaired(
        recording=recording.with_values(values),
        origin=origin,
        std=np.concatenate([piece.std for piece in pieces]),
        weights=np.concatenate([piece.weights for piece in pieces]),
        method=pieces[0].method,
        iterations=sum(piece.iterations for piece in pieces),
        warnings=(*_mostly_said(pieces), *left_open(origin)),
        noise=_median(noises, frames) if len(noises) == len(pieces) else None,
    )


def _finished(state: Live[Recording], due: int) -> Repaired[Recording]:
    """The repair of the frames that come next, up to `due` and without it."""
    outcome: Repaired[Recording] = state.model.repair(state.recent, "adaptive", whole=False)
    first = state.seen - state.recent.frames
    own = slice(state.given - first, due - first)
    about_the_window = left_open(outcome.origin)
    return replace(
        outcome,
        recording=_part(outcome.recording, own),
        origin=outcome.origin[own],
        std=outcome.std[own],
        weights=outcome.weights[own],
        warnings=tuple(said for said in outcome.warnings if said not in about_the_window),
    )


def _frames(like: Motion | Markers, frames: Floats) -> Floats:
    """(n, ...) frames of one or several."""
    frames = np.asarray(frames, dtype=np.float64)
    one = like.values.shape[1:]
    if frames.shape == one:
        return frames[None]
    if frames.shape[1:] != one:
        raise MismatchError(f"a frame of {one} values was wanted, or several, came {frames.shape}")
    return frames


def _part(recording: Recording, frames: slice) -> Recording:
    """Some of the frames; what else the file held stays behind."""
    if isinstance(recording, Markers):
        return replace(recording, positions=recording.positions[frames], residuals=None, source=None)
    return replace(recording, q=recording.q[frames], source=None)


def _mostly_said(pieces: Sequence[Repaired[Any]]) -> tuple[str, ...]:
    """What at least half of the pieces say, numbers aside, as the last of them says it."""
    said: dict[str, list[str]] = {}
    for piece in pieces:
        for sentence in piece.warnings:
            said.setdefault(re.sub(r"\d+(\.\d+)?", "#", sentence), []).append(sentence)
    return tuple(sentences[-1] for sentences in said.values() if 2 * len(sentences) >= len(pieces))


def _median(noises: Sequence[Floats], frames: Sequence[int]) -> Floats:
    """(C,) median of the noise over all frames."""
    by_frame = np.repeat(np.stack(noises), frames, axis=0)
    return np.asarray(np.median(by_frame, axis=0))
