"""Pairs of a sensor's recording and the truth: when they belong together, where, joint by joint, and whether at all.

The two systems have clocks and axes of their own. For each trial offset of time the truth is brought to the sensor's
frame by one rigid motion for the whole episode, never a mirroring; the offset with which the joints then move most
alike is taken. What the joints keep between them is the sensor's bias, which is to be learned and must not count here.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Floats, Ints
from ..bodies.joint_sets import correspondence, meanings, mirrored
from ..bodies.postures import Postures
from ..bodies.rigid import rigid_fit
from ..errors import MismatchError
from .pairing import Pair

FEWEST_JOINTS = 4  # that a sensor and a truth must have in common
_OVERLAP = 0.6  # of the shorter recording, at least, in every trial
_STEP = 1 / 30  # s between trials at first
_FINE = 1 / 300  # s between trials at last
_MOST_FRAMES = 240  # looked at in a trial
_ASTRAY = 0.15  # s; a given offset further from the best is questioned
_MOVED = 1.25  # times the cost of the best offset, when another one is surely wrong
_MIRRORED = 0.7  # of the error: so much less when left and right are swapped, and they are
_STRANGE = 3.5  # robust standard deviations above the usual error of an episode, on a log scale
_FINE_ERROR = 0.12  # m; no episode with a mean error below is strange
_LOST = 0.30  # m; an episode with a mean error above is not of the same movement
_MANY = 8  # episodes that make a usual error


@dataclass(frozen=True, eq=False)
class Matched:
    """A pair of recordings brought together.

    Attributes
    ----------
    sensor : as it came.
    truth : of the same joints, axes, place and times; NaN for joints without a counterpart.
    offset : s; the sensor's time + offset = the truth's time.
    error : (J,) m, mean distance of each of the sensor's joints from the truth; NaN without a counterpart.
    mirrored_error : m, mean distance when left and right of the truth are swapped.
    warnings : one sentence each.
    """

    sensor: Postures
    truth: Postures
    offset: float
    error: Floats
    mirrored_error: float
    warnings: tuple[str, ...] = ()

    @property
    def mean_error(self) -> float:
        """Mean over the joints that have a counterpart, m."""
        return float(np.nanmean(self.error))

    @property
    def pair(self) -> Pair:
        """To be learned from."""
        return Pair(self.sensor, self.truth, fitted=True)


@dataclass(frozen=True, eq=False)
class _Points:
    """Which points of both recordings are compared: rows of the truth's joints, and the sensor's joints in whose
    middle each lies."""

    truth: Ints
    sensor: tuple[Ints, ...]

    def of_sensor(self, positions: Floats) -> Floats:
        """(T, K, 3) of positions (T, J, 3)."""
        return np.stack([positions[:, joints].mean(axis=1) for joints in self.sensor], axis=1)


def match(sensor: Postures, truth: Postures, offset: float | None = None) -> Matched:
    """Bring the truth to the sensor's times, frame and joints.

    Parameters
    ----------
    sensor : T frames.
    truth : with joints of the same meanings or names, at any rate.
    offset : s, sensor's time + offset = truth's time; estimated when None, else checked.

    Raises
    ------
    MismatchError : too few joints in common, or no time in which both see the person.
    """
    points = _common(sensor.names, truth.names)
    seen = points.of_sensor(sensor.positions)
    warnings: tuple[str, ...] = ()
    if offset is None:
        offset, warnings = _offset(seen, sensor.times, truth.positions[:, points.truth], truth.times)
    else:
        warnings = _checked(offset, seen, sensor.times, truth.positions[:, points.truth], truth.times)
    there = at_times(truth.positions[:, points.truth], truth.times, sensor.times + offset)
    both = np.asarray((np.isfinite(there) & np.isfinite(seen)).all(axis=2))
    if both.any(axis=1).sum() < 2:
        raise MismatchError(
            f"wanted frames in which both the sensor and the truth see the person, came {int(both.any(axis=1).sum())} "
            f"at an offset of {offset:g} s: give the right offset_s or leave it out"
        )
    rotation, shift = rigid_fit(there.reshape(-1, 3), seen.reshape(-1, 3))
    here = there @ rotation.T + shift
    other = _swapped(truth.names, points)
    turned, moved = rigid_fit(there[:, other].reshape(-1, 3), seen.reshape(-1, 3))
    swapped = np.linalg.norm(there[:, other] @ turned.T + moved - seen, axis=2)
    placed = np.full(sensor.positions.shape, np.nan)
    error = np.full(len(sensor.names), np.nan)
    distance = np.linalg.norm(here - seen, axis=2)
    for k, joints in enumerate(points.sensor):
        placed[:, joints] = here[:, k, None] + sensor.positions[:, joints] - seen[:, k, None]
        if np.isfinite(distance[:, k]).any():
            error[joints] = np.nanmean(distance[:, k])
    together = replace(truth, names=sensor.names, positions=placed, times=sensor.times, state=None, std=None)
    return Matched(sensor, replace(together, reliability=None), offset, error, float(np.nanmean(swapped)), warnings)


def strange(matched: Sequence[Matched]) -> tuple[str, ...]:
    """Why each pair is not to be learned from; "" for those that are.

    A pair is left out when left and right were surely confused, when the two are not of the same movement at all, or
    when its joints are much further from the truth than in the other pairs, in the mean or a single joint.

    Parameters
    ----------
    matched : all pairs that a model is to be learned from.
    """
    errors = np.array([one.mean_error for one in matched])
    joints = [one.error for one in matched]
    usual = _limit(errors)
    said = []
    for k, one in enumerate(matched):
        worst = int(np.nanargmax(one.error))
        others = [
            error[worst]
            for error, other in zip(joints, matched, strict=True)
            if other.sensor.names == one.sensor.names and np.isfinite(error[worst])
        ]
        where = one.sensor.names[worst]
        if one.mirrored_error < _MIRRORED * errors[k]:
            said.append(
                f"left and right are confused: {100 * errors[k]:.1f} cm from the truth, "
                f"{100 * one.mirrored_error:.1f} cm when they are swapped"
            )
        elif errors[k] > usual:
            said.append(f"{100 * errors[k]:.1f} cm from the truth, above {100 * usual:.1f} cm: another movement?")
        elif one.error[worst] > max(_LOST, _limit(np.array(others))):
            said.append(f"{where} is {100 * one.error[worst]:.1f} cm from the truth: another limb?")
        else:
            said.append("")
    return tuple(said)


def at_times(positions: Floats, times: Floats, wanted: Floats) -> Floats:
    """(N, K, 3) positions (T, K, 3) at other times, between frames on a straight line; NaN before the first, behind
    the last, and beside what is missing.

    Parameters
    ----------
    positions : m.
    times : (T,) s; frames whose time does not rise are passed over.
    wanted : (N,) s.
    """
    rising = np.concatenate([[True], times[1:] > np.maximum.accumulate(times)[:-1]])
    positions, times = positions[rising], times[rising]
    if len(times) < 2:
        return np.full((len(wanted), *positions.shape[1:]), np.nan)
    after = np.clip(np.searchsorted(times, wanted, side="right"), 1, len(times) - 1)
    share = ((wanted - times[after - 1]) / (times[after] - times[after - 1]))[:, None, None]
    between = (1 - share) * positions[after - 1] + share * positions[after]
    slack = 1e-9 + 1e-6 * float(np.median(np.diff(times)))
    outside = (wanted < times[0] - slack) | (wanted > times[-1] + slack)
    between[outside] = np.nan
    return np.asarray(between)


def _common(sensor: Sequence[str], truth: Sequence[str]) -> _Points:
    """The joints that both have. A head without a top of its own in the truth is the middle of the sensor's two."""
    found = correspondence(truth, sensor)
    named = meanings(sensor)
    groups: list[tuple[int, list[int]]] = [(int(row), [k]) for k, row in enumerate(found) if row >= 0]
    if "head" in named and "head_top" in named:
        head, top = named.index("head"), named.index("head_top")
        if found[head] >= 0 and found[top] < 0:
            groups = [(row, [head, top] if joints == [head] else joints) for row, joints in groups]
    if len(groups) < FEWEST_JOINTS:
        raise MismatchError(
            f"wanted {FEWEST_JOINTS} joints that the sensor ({', '.join(sensor[:4])}, ...) and the truth "
            f"({', '.join(truth[:4])}, ...) have in common, came {len(groups)}: rename the truth's joints"
        )
    return _Points(
        np.array([row for row, _ in groups], dtype=np.int64),
        tuple(np.array(joints, dtype=np.int64) for _, joints in groups),
    )


def _swapped(truth: Sequence[str], points: _Points) -> Ints:
    """(K,) for each point the one on the other side of the truth's body."""
    place = {int(row): k for k, row in enumerate(points.truth)}
    other = mirrored(truth)
    return np.array([place.get(int(other[row]), k) for k, row in enumerate(points.truth)], dtype=np.int64)


def _offset(seen: Floats, times: Floats, truth: Floats, truth_times: Floats) -> tuple[float, tuple[str, ...]]:
    """The offset with which the points move most alike, and a sentence when the movement does not tell it."""
    first, last = _span(times, truth_times)
    trials = np.arange(first, last + _STEP, _STEP)
    costs = np.array([_cost(one, seen, times, truth, truth_times) for one in trials])
    if not np.isfinite(costs).any():
        raise MismatchError("no time was found in which both the sensor and the truth see the person")
    best = float(trials[np.nanargmin(costs)])
    near = np.arange(best - _STEP, best + _STEP + _FINE / 2, _FINE)
    fine = np.array([_cost(one, seen, times, truth, truth_times) for one in near])
    best = float(near[np.nanargmin(fine)])
    away = costs[(np.abs(trials - best) > _ASTRAY) & np.isfinite(costs)]
    if away.size and float(np.median(away)) < _MOVED * float(np.nanmin(fine)):
        return best, (f"the movement hardly tells the offset of time: {best:.3f} s was taken",)
    return best, ()


def _checked(offset: float, seen: Floats, times: Floats, truth: Floats, truth_times: Floats) -> tuple[str, ...]:
    """A sentence when the movement speaks clearly for another offset than the one given."""
    trials = offset + np.arange(-15, 16) * 2 * _STEP
    first, last = _span(times, truth_times)
    trials = trials[((trials >= first) & (trials <= last)) | (trials == offset)]
    costs = np.array([_cost(one, seen, times, truth, truth_times) for one in trials])
    if not np.isfinite(costs).any():
        return ()
    best, given = int(np.nanargmin(costs)), int(np.flatnonzero(trials == offset)[0])
    clear = not np.isfinite(costs[given]) or costs[given] > _MOVED * costs[best]
    if abs(trials[best] - offset) > _ASTRAY and clear:
        return (f"offset_s says {offset:g} s, the movement says {trials[best]:.2f} s: took the one given",)
    return ()


def _span(times: Floats, truth_times: Floats) -> tuple[float, float]:
    """The least and the largest offset with which the recordings overlap enough, s."""
    length = _OVERLAP * min(times[-1] - times[0], truth_times[-1] - truth_times[0])
    return float(truth_times[0] - times[-1] + length), float(truth_times[-1] - times[0] - length)


def _cost(offset: float, seen: Floats, times: Floats, truth: Floats, truth_times: Floats) -> float:
    """Mean distance in m that remains at an offset after one rigid motion and a constant bias of each point; NaN where
    the recordings overlap too little."""
    every = max(1, len(times) // _MOST_FRAMES)
    here = seen[::every]
    there = at_times(truth, truth_times, times[::every] + offset)
    both = np.asarray((np.isfinite(there) & np.isfinite(here)).all(axis=2))
    used = np.asarray(both.any(axis=1))
    if used.sum() < 3 or both.sum() < 2 * both.shape[1]:
        return float("nan")
    there, here, both = there[used], here[used], both[used]
    whole = bool(both.all())
    rotation, shift = rigid_fit(there.reshape(-1, 3), here.reshape(-1, 3))
    rest = there @ rotation.T + shift - here
    if whole:
        rest = rest - rest.mean(axis=0)
        return float(np.sqrt((rest**2).sum(axis=2)).mean())
    rest = np.where(both[:, :, None], rest, 0.0)
    rest = rest - rest.sum(axis=0) / np.maximum(both.sum(axis=0), 1)[:, None]
    return float(np.sqrt((rest**2).sum(axis=2))[both].mean())


def _limit(errors: Floats) -> float:
    """Error above which an episode is strange among these, m."""
    if len(errors) < _MANY:
        return _LOST
    logs = np.log(np.maximum(errors, 1e-9))
    middle = float(np.median(logs))
    spread = 1.4826 * float(np.median(np.abs(logs - middle)))
    return float(np.clip(np.exp(middle + _STRANGE * spread), _FINE_ERROR, _LOST))
