"""Corrected joints made a body's: steady from frame to frame, with bones that keep their lengths.

A whole recording is made steady first (`steadying.py`); live each joint is followed by a Kalman filter. The lengths are
the person's own: the median of the recording, or live what the first moments showed.

Both ends of a bone give way to its length, but slowly: what a body's bones ask of a joint changes with its posture, so
it is smoothed in time, and only what is left is taken up from the root outward. A foot that a sensor throws about for a
frame then leaves the planted ankle where it is.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Floats, Ints
from ..bodies.joint_sets import parents
from ..kernels import bones as kernel
from ..kernels.bones import LOOSE, ROUNDS, STILL
from ..kernels.steadying import STATE, told
from .limits import Hinges
from .steadying import BREAK_STEPS, smoothed, steadied

COURSE = (
    1.0  # weight of second differences by that of the values, at 30 Hz, of where a joint is going: 5 Hz passes half
)
SLOW = 33.0, 528.0  # the same of how joints give way, of those that move: half passes at 2 Hz, and at rest: 1 Hz
OFFSET = 2.3, 1437.0  # and of learned offsets: 4 and 0.8 Hz
OFFSET_SECONDS = 0.04, 0.2  # live, of joints that move (4 Hz) and at rest (0.8 Hz)
FASTER = 0.8  # of usual steps of time: frames that come faster
SHORTER, FOLLOWED = 0.4, 0.1  # how much of the time of such a frame, and of others, is followed
TURNS = 2  # of relaxing and smoothing


@dataclass(frozen=True, eq=False)
class Body:
    """Of one person while frames come: what was last put out, and bone lengths so far.

    Attributes
    ----------
    last, earlier : (J, 3) m, the frames put out before; NaN = none.
    time, before : s, of those; NaN = none.
    lengths : (2, B) so far in m, and s for which they were seen.
    yielded : (J, 3) m, how far joints gave way to their bones.
    step : s, usual time between frames; NaN = not known.
    motion : (J, 13) where joints are and go, of `kernels.steadying.steady_frame`.
    calm : (J, 3) m, `last` before joints gave way to their bones.
    """

    last: Floats
    earlier: Floats
    time: float
    before: float
    lengths: Floats
    yielded: Floats
    step: float
    motion: Floats
    calm: Floats


def unborn(joints: int, bones: int) -> Body:
    """Before the first frame."""
    nothing = np.full((joints, 3), np.nan)
    return Body(
        nothing,
        nothing,
        np.nan,
        np.nan,
        np.zeros((2, bones)),
        nothing,
        np.nan,
        np.full((joints, STATE), np.nan),
        nothing,
    )


def bones_outward(names: Sequence[str]) -> Ints:
    """(B, 2) parent and child, from the root outward."""
    above = parents(names)
    found: list[tuple[int, int]] = []
    front = [int(k) for k in np.flatnonzero(above < 0)]
    while front:
        found += [(parent, int(k)) for parent in front for k in np.flatnonzero(above == parent)]
        front = [int(k) for parent in front for k in np.flatnonzero(above == parent)]
    return np.array(found, dtype=np.int64).reshape(-1, 2)


def settled_recording(
    positions: Floats, times: Floats, trust: Floats, bones: Ints, hinges: Hinges | None = None, size: float = 1.0
) -> Floats:
    """A whole recording made steady, then its bones made constant, and limbs bent back that bend too far.

    Parameters
    ----------
    positions : (T, J, 3) m, corrected; NaN = missing.
    times : (T,) s.
    trust : (T, J) in [0, 1].
    bones : (B, 2) of `bones_outward`.
    hinges : joints that have limits.
    size : of the person, by that of a usual one: what is large or quick goes by it.
    """
    if not len(positions):
        return positions
    steady = size * steadied(positions / size, times, trust)
    lengths = _lengths(steady, bones)
    usual = np.full(len(bones), np.nan)
    for b, (parent, child) in enumerate(bones):
        for least in (0.5, 0.0):
            some = np.isfinite(lengths[:, b]) & (np.minimum(trust[:, parent], trust[:, child]) >= least)
            if some.any():
                usual[b] = np.median(lengths[some, b])
                break
    wanted = np.repeat(usual[None], len(positions), axis=0)
    mobility = _mobility(trust)
    placed = steady
    for _ in range(TURNS):
        relaxed = kernel.settle(placed, bones, wanted, mobility, ROUNDS)
        placed = steady + gently(relaxed - steady, steady, times, SLOW)
    settled = kernel.settle(placed, bones, wanted, mobility, 0)
    return settled if hinges is None else hinges.kept(settled, trust)


def settled_frame(
    body: Body,
    positions: Floats,
    time: float,
    trust: Floats,
    bones: Ints,
    prior: Floats,
    hinges: Hinges | None = None,
    belief: float = 1.0,
    later: tuple[Floats, Floats] | None = None,
    shaking: float = 0.0,
) -> tuple[Body, Floats]:
    """One live frame made steady, its bones kept, and limbs bent back that bend too far.

    Parameters
    ----------
    body : after the frame before.
    positions : (J, 3) m, corrected; NaN = missing.
    time : s.
    trust : (J,) in [0, 1].
    bones : (B, 2) of `bones_outward`.
    prior : (B,) m, lengths to begin with; NaN = not known.
    hinges : joints that have limits.
    belief : in [0, 1], in `prior`.
    later : (N, J, 3) m, the same joints in the frames after it, NaN = not known; and (N,) s, each since the one before.
    shaking : m, deviation of a coordinate by which all joints shake.
    """
    if not np.isfinite(positions).any():
        return body, positions  # what was put out last still is when somebody is seen again
    first, second = time - body.time, body.time - body.before
    step, passed = _steps(body.step, first, second)
    after, steps = later or (np.empty((0, *positions.shape)), np.empty(0))
    placed, lengths, yielded, motion, calm = kernel.settle_frame(
        positions,
        trust,
        bones,
        prior,
        belief,
        first,
        second,
        body.last,
        body.earlier,
        body.lengths,
        body.yielded,
        passed,
        body.motion,
        after,
        steps,
        shaking,
    )
    if hinges is not None:
        placed = hinges.kept(placed[None], trust[None])[0]
    return Body(placed, body.last, time, body.time, lengths, yielded, step, motion, calm), placed


def _steps(usual: float, first: float, second: float) -> tuple[float, float]:
    """Usual s between frames, and s since the frame before in such steps, as frames do not come as evenly as they are
    taken; NaN where it says nothing, so long or so short beside the one before.

    Parameters
    ----------
    usual : so far; NaN = not known. first, second : since the frame before, and from the one before that; NaN = none.
    """
    if not told(first) or first > BREAK_STEPS * second or second > BREAK_STEPS * first:
        return usual, np.nan
    if np.isnan(usual):
        return first, first
    steps = max(round(first / usual), 1)
    usual += (SHORTER if first < FASTER * usual else FOLLOWED) * (first / steps - usual)
    return usual, steps * usual


def gently(shifts: Floats, positions: Floats, times: Floats, weights: tuple[float, float]) -> Floats:
    """Shifts of joints smoothed, and more where a joint rests: what others do is then no reason to tremble.

    Parameters
    ----------
    shifts : (T, J, 3) m; NaN = missing.
    positions : (T, J, 3) m, of the joints in the same axes; NaN = missing.
    times : (T,) s.
    weights : as of `smoothed`, of joints that move and at rest.
    """
    moving, resting = smoothed(shifts, times, weights[0]), smoothed(shifts, times, weights[1])
    return np.asarray(moving + _resting(positions, times)[..., None] * (resting - moving))


def _resting(positions: Floats, times: Floats) -> Floats:
    """(T, J) how far joints rest: 1 if they stay, half at `STILL` m/s."""
    usual = float(np.median(np.diff(times))) if len(times) > 1 else 0.0
    if usual <= 0:
        return np.ones(positions.shape[:2])
    steps = np.full((len(positions) + 1, *positions.shape[1:]), np.nan)
    steps[1:-1] = np.diff(smoothed(positions, times, COURSE), axis=0)
    around = np.stack([steps[:-1], steps[1:]])  # who is not seen before or after a frame is asked of the other side
    known = np.isfinite(around)
    going = np.where(known, around, 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1) / usual
    speed = np.sqrt((going * going).sum(axis=2))
    return np.asarray(1.0 / (1.0 + (speed / STILL) ** 4))


def _lengths(positions: Floats, bones: Ints) -> Floats:
    apart = positions[:, bones[:, 1]] - positions[:, bones[:, 0]]
    return np.asarray(np.sqrt((apart * apart).sum(axis=2)))


def _mobility(trust: Floats) -> Floats:
    return np.ascontiguousarray(1.0 + LOOSE * (1.0 - trust))
