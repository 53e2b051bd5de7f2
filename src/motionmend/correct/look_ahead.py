"""Live frames given out a little late, when it is known what came after them: a fixed-lag estimate.

A failure that begins is seen for what it is only a few frames on, and a limb that comes back shows where it must have
been. Both are asked of the frames that wait; those before them have been given out and are not touched again.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Bools, Floats, Ints
from ..errors import UsageError
from ..kernels.following import MET_SECONDS, STRANGER
from ..numerics import factors as process
from ..numerics.factors import Belief, Factors
from . import spikes
from .hindsight import judged_again, less_own, trusted
from .joining import Joining
from .sight import Sight
from .thrown_about import Believed
from .watching import PATIENCE

BELIEVED = 0.5  # a joint is, that fails less likely
LONGEST, MOST = 1.0, 60  # s and frames; more helps no more, and a frame costs more the farther it looks


@dataclass(frozen=True, eq=False)
class Waiting:
    """Frames that were seen and not given out yet.

    Attributes
    ----------
    frames : how many frames are looked at after the one that is given out.
    sights : of the frames that wait, the oldest first.
    given : their positions (J, 3) m, as the client sent them, and how far those are believed.
    belief : of the factors, after the last frame that was given out; None before the first.
    time : s, of that frame.
    past : the latest frames that were given out, as many as a joint may be thrown away for.
    """

    frames: int
    sights: tuple[Sight, ...] = ()
    given: tuple[Believed, ...] = ()
    belief: Belief | None = None
    time: float = -np.inf
    past: tuple[Sight, ...] = ()

    @property
    def full(self) -> bool:
        """Whether the oldest frame has waited for as many as it should."""
        return len(self.sights) > self.frames

    def with_frame(self, sight: Sight, given: Believed) -> "Waiting":
        """One more frame waits."""
        return replace(self, sights=(*self.sights, sight), given=(*self.given, given))

    def without_first(self, belief: Belief) -> "Waiting":
        """The oldest has been given out; `belief` is that after it."""
        first, *sights = self.sights
        past = (*self.past, first)[-spikes.LONGEST :]
        return replace(
            self, sights=tuple(sights), given=self.given[1:], belief=belief, time=float(_time(first)), past=past
        )


def frames_in(seconds: float, fps: float) -> int:
    """Frames to look ahead, at least one unless the time is 0, at most `MOST`; the latency is that many frames.

    Parameters
    ----------
    seconds : from 0 to `LONGEST`.
    fps : Hz.

    Raises
    ------
    UsageError : another time.
    """
    if not 0.0 <= seconds <= LONGEST:
        raise UsageError(f"a look-ahead from 0 to {LONGEST:g} s was wanted, came {seconds}")
    return min(max(round(seconds * fps), 1), MOST) if seconds > 0 else 0


def first_of(factors: Factors, waiting: Waiting, mirror: Ints) -> tuple[Floats, Floats, Floats, Belief]:
    """The oldest frame that waits, by all that came before it and the frames that wait behind it.

    Parameters
    ----------
    mirror : (J,) the joint's other side, or itself.

    Returns
    -------
    The posture (J, 3) in standard form, the standard deviation (J,) of a coordinate, the probability (N, J) that the
    sensor's joint fails in each frame that waits, and the belief of the factors after this frame and those before it.
    """
    sights = waiting.sights
    failing = np.where(_thrown(waiting, mirror), 1.0, judged_again(sights))
    trust = trusted(sights, failing)
    own = sights[0].followed.own
    values = less_own(factors, sights, np.broadcast_to(own, (len(sights), *own.shape)))
    gaps = np.maximum(np.diff(np.array([_time(one) for one in sights]), prepend=waiting.time), 0.0)
    gaps = np.where([one.other for one in sights], np.inf, gaps)
    beliefs: list[Belief] = []
    before = waiting.belief
    for t, gap in enumerate(gaps):
        goes_on = before if gap <= PATIENCE else None
        forecast = process.start(factors) if goes_on is None else process.ahead(factors, goes_on, float(gap))
        precision = np.where(trust[t] > 0.02, trust[t], 0.0) / _open(factors, sights[t])
        before = process.seen(factors, forecast, values[t], precision)
        beliefs.append(before)
    later = beliefs[-1]
    for t in range(len(sights) - 2, -1, -1):
        goes_on = gaps[t + 1] <= PATIENCE
        later = process.backward(factors, later, beliefs[t], float(gaps[t + 1])) if goes_on else beliefs[t]
    there, cov = process.expected(factors, later)
    share = trust[0][:, None]
    posture = share * values[0] + (1.0 - share) * there
    unsure = np.sqrt(np.trace(cov, axis1=1, axis2=2) / 3.0 + _open(factors, sights[0]))
    return posture + factors.mean + own, (1.0 - trust[0]) * unsure, failing, beliefs[0]


def going_on(joining: Joining, waiting: Waiting, failing: Floats, placed: Floats) -> tuple[Floats, Floats]:
    """Where the oldest frame's joints, corrected (J, 3) m, go in the frames that wait behind it: as the sensor has it.

    Parameters
    ----------
    failing : (N, J of model) of the frames that wait.

    Returns
    -------
    (N - 1, J, 3) m, NaN where the sensor does not say or is not believed, and (N - 1,) s, each since the one before.
    """
    first, *sights = waiting.sights
    turn = np.eye(3) if first.upright is None else first.upright
    there = np.full((len(sights), *placed.shape), np.nan)
    common = joining.common
    for k, one in enumerate(sights):
        if one.other:  # nor is anything known of who was there before
            break
        believed = np.maximum(failing[0], failing[k + 1])[common] < BELIEVED
        steps = np.where(believed[:, None], (one.rows - first.rows)[common] @ turn, np.nan)
        there[k, joining.to_model[common]] = placed[joining.to_model[common]] + steps
    return there, np.diff(np.array([_time(one) for one in waiting.sights]))


def _thrown(waiting: Waiting, mirror: Ints) -> Bools:
    """(N, J) which joints of the frames that wait were thrown away and were back in those that came since."""
    sights = (*waiting.past, *waiting.sights)
    rows, times = np.stack([one.rows for one in sights]), np.array([_time(one) for one in sights])
    return spikes.thrown_and_back(rows, times, mirror)[len(waiting.past) :]


def _open(factors: Factors, sight: Sight) -> Floats:
    """(J,) variance of a coordinate that the factors leave open: more of joints that were hardly met yet."""
    return factors.noise + STRANGER**2 * np.exp(-sight.followed.met / MET_SECONDS)


def _time(sight: Sight) -> float:
    return np.nan if sight.time is None else sight.time
