"""From pairs of recordings to samples in standard form, and from those to what a corrector knows."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Bools, Floats
from ..bodies.postures import Postures
from ..errors import MismatchError
from ..numerics import factors as process
from ..numerics.factors import Factors, fit_factors
from .anatomy import Anatomy, anatomy, matched
from .level import level
from .normalise import Placement, Standard, bone_lengths, placed, sizes
from .pairing import Pair
from .reliability import Detector
from .spatial import mirrored_postures

STEP_SECONDS = 0.2  # steps of time longer than this say nothing of speed
STRANGE = 6.0  # robust standard deviations from the usual offset: the sensor failed, or the truth did

LEAST_STRANGE = 0.3  # standard metres; offsets less than this are learned in any case, if with little weight

MISFITS = (0.003, 0.006, 0.01, 0.015, 0.02, 0.03, 0.04, 0.06)  # standard metres, of people not seen in training
HELD_OUT = 60  # frames of each third of the recordings that are looked at
UNSEEN = 0.12  # standard metres, of a coordinate in movements of which none was shown
MOVEMENT_SECONDS = 2.5  # in which one is shown
MOVING = 0.9  # share of joints and bones that are steadier than those that move much
RESTING = 5.0  # movements after which a quarter of what is usual of a joint is still that of those that move


@dataclass(frozen=True, eq=False)
class Lesson:
    """One pair in standard form.

    Attributes
    ----------
    standard : (T, J, 3) the sensor's posture.
    offsets : (T, J, 3) truth less sensor, NaN = not known.
    times : (T,) s.
    placement : where it lay.
    raw : (T, J, 3) m the sensor's posture, upright.
    """

    standard: Floats
    offsets: Floats
    times: Floats
    placement: Placement
    raw: Floats


def model_anatomy(pairs: Sequence[Pair]) -> Anatomy:
    """The joint set that a model is learned on: the one most of the pairs have.

    Raises
    ------
    MismatchError : no pairs.
    """
    if not pairs:
        raise MismatchError("a corrector is learned from pairs of recordings, came none")
    commonest, _ = Counter(pair.sensor.names for pair in pairs).most_common(1)[0]  # the first of several
    return anatomy(commonest)


def in_joints_of(body: Anatomy, postures: Postures) -> Floats:
    """(T, J, 3) a recording's positions by the model's joints, NaN where it has none."""
    source = matched(postures.names, body.names)
    return np.where((source >= 0)[None, :, None], postures.positions[:, source], np.nan)


def lessons(pairs: Sequence[Pair], body: Anatomy) -> tuple[list[Lesson], Standard]:
    """All pairs in standard form, and the standard body: the median of the people seen.

    Raises
    ------
    MismatchError : no frame shows a whole trunk.
    """
    raws = []
    for pair in pairs:
        sensor = in_joints_of(body, pair.sensor)
        turn = level(sensor, body)
        raws.append((sensor @ turn.T, in_joints_of(body, pair.truth) @ turn.T, pair.sensor.times))
    medians = [_medians(bone_lengths(raw, body)) for raw, _, _ in raws]
    usual = _medians(np.stack(medians))
    usual = np.where(np.isfinite(usual), usual, np.nanmean(usual) if np.isfinite(usual).any() else 1.0)
    standard = Standard(usual, np.zeros((len(body.names), 3)))
    places = []
    for _ in range(2):  # the trunk's mean places need placements, which need the trunk
        places = [_placed(raw, standard, body) for raw, _, _ in raws]
        every = np.concatenate([place.inward(raw) for place, (raw, _, _) in zip(places, raws, strict=True)])
        if not np.isfinite(every).any():
            raise MismatchError("the pairs' sensor recordings hold no positions: give others")
        mean = np.nan_to_num(_medians(np.concatenate([every, mirrored_postures(every, body)])))
        standard = Standard(usual, mean - mean[body.trunk].mean(axis=0))
    places = [_placed(raw, standard, body) for raw, _, _ in raws]
    taught = []
    for place, (raw, truth, times) in zip(places, raws, strict=True):
        taught.append(Lesson(place.inward(raw), place.turned(truth - raw), times, place, raw))
    return taught, standard


def _placed(raw: Floats, standard: Standard, body: Anatomy) -> Placement:
    present = np.asarray(np.isfinite(raw).all(axis=2))
    weights = np.asarray(present, dtype=np.float64)
    lengths = bone_lengths(raw, body)
    scale = np.full(len(raw), sizes(lengths, standard, np.isfinite(lengths)))
    return placed(raw, weights, scale, standard, body)


def going_well(taught: Sequence[Lesson], least: float = 0.06) -> list[Bools]:
    """(T, J) for each lesson: True unless the offset is far from the joint's usual one.

    Where the truth is not known the joint is taken to go well.

    Parameters
    ----------
    least : standard metres; nothing nearer than this is a failure.
    """
    offsets = np.concatenate([one.offsets for one in taught])
    centre = np.nan_to_num(_medians(offsets))
    away = np.sqrt(((offsets - centre) ** 2).sum(axis=2))
    known = np.isfinite(away)
    usual = np.array([np.median(away[known[:, j], j]) if known[:, j].any() else 1.0 for j in range(away.shape[1])])
    limit = np.maximum(STRANGE * usual / 1.54, least)  # median of a chi(3)
    found = []
    for one in taught:
        distance = np.sqrt(((one.offsets - centre) ** 2).sum(axis=2))
        found.append(~(distance > limit))
    return found


def offset_samples(taught: Sequence[Lesson]) -> tuple[Floats, Floats]:
    """Postures (N, J, 3) and offsets (N, J, 3) of the frames to learn offsets from, standard units.

    All of the sensor's joints are there and none is so far off that the posture must be wrong.
    """
    samples, offsets = [], []
    for one, well in zip(taught, going_well(taught, LEAST_STRANGE), strict=True):
        known = np.asarray(np.isfinite(one.standard).all(axis=(1, 2))) & np.isfinite(one.offsets).any(axis=(1, 2))
        samples.append(one.standard[known & well.all(axis=1)])
        offsets.append(one.offsets[known & well.all(axis=1)])
    return np.concatenate(samples), np.concatenate(offsets)


def learned_factors(taught: Sequence[Lesson], good: Sequence[Bools], body: Anatomy) -> Factors:
    """Factors of the sensor's postures and of the same people in a mirror, from frames in which all joints go well.

    What factors leave open is larger in people who were not seen in training: as large as makes the joints of some of
    the recordings likeliest, each from all others, given factors of the rest. Recordings that are all alike know
    nothing of other movements: what those may hold shrinks only with the time that was shown.

    Raises
    ------
    MismatchError : too few frames.
    """
    whole = _factors(taught, good, body)
    if whole is None:
        raise MismatchError(
            "wanted frames in which the sensor has all joints near the truth, came none: check the pairs' offsets"
        )
    unseen = UNSEEN**2 / (1.0 + movements(taught) ** 2)
    if len(taught) < 3:
        return replace(whole, noise=whole.noise + max(MISFITS[3] ** 2, unseen))
    scores = np.zeros(len(MISFITS))
    for apart in np.array_split(np.arange(len(taught)), 3):  # recordings of one person mostly stand together
        rest = [k for k in range(len(taught)) if k not in apart]
        known = _factors([taught[k] for k in rest], [good[k] for k in rest], body)
        frames = np.concatenate([taught[k].standard[_complete(taught[k], good[k])] for k in apart])
        if known is None or not len(frames):
            continue
        some = frames[np.linspace(0, len(frames) - 1, min(len(frames), HELD_OUT)).astype(int)]
        for m, misfit in enumerate(MISFITS):
            scores[m] += _likelihood(replace(known, noise=known.noise + misfit**2), some)
    return replace(whole, noise=whole.noise + max(MISFITS[int(np.argmax(scores))] ** 2, unseen))


def movements(taught: Sequence[Lesson]) -> float:
    """How many movements may have been shown in the time that was."""
    seconds = [float(np.minimum(np.maximum(np.diff(one.times), 0.0), STEP_SECONDS).sum()) for one in taught]
    return sum(seconds) / MOVEMENT_SECONDS


def _complete(one: Lesson, well: Bools) -> Bools:
    return np.asarray(well.all(axis=1) & np.asarray(np.isfinite(one.standard).all(axis=(1, 2))))


def _factors(taught: Sequence[Lesson], good: Sequence[Bools], body: Anatomy) -> Factors | None:
    samples, steps, seconds = [], [], []
    for one, well in zip(taught, good, strict=True):
        whole = _complete(one, well)
        samples.append(one.standard[whole])
        passed = np.diff(one.times)
        pair = whole[1:] & whole[:-1] & (passed > 0) & (passed < STEP_SECONDS)
        steps.append((one.standard[1:] - one.standard[:-1])[pair])
        seconds.append(passed[pair])
    both, moved = np.concatenate(samples), np.concatenate(steps)
    if len(both) < 2:
        return None
    return fit_factors(
        np.concatenate([both, mirrored_postures(both, body)]),
        np.concatenate([moved, mirrored_postures(moved, body)]),
        np.tile(np.concatenate(seconds), 2),
    )


def _likelihood(factors: Factors, frames: Floats) -> float:
    """Log-likelihood of every joint of every frame (T, J, 3) given the other joints."""
    total = 0.0
    precision = 1.0 / factors.noise
    for frame in frames:
        belief = process.seen(factors, process.start(factors), frame - factors.mean, precision)
        there, cov = process.expected(factors, belief)
        far, volume = process.left_out(frame - factors.mean - there, cov, factors.noise, precision)
        total -= 0.5 * float((np.minimum(far, 10.0) ** 2 + volume).sum())
    return total


def usual_unsteadiness(taught: Sequence[Lesson], good: Sequence[Bools], body: Anatomy) -> Detector:
    """How unsteady bones and joints are while all goes well, and evidence weighed by experience with sensors."""
    spread, jerk = [], []
    for one, well in zip(taught, good, strict=True):
        lengths = np.log(np.maximum(bone_lengths(one.raw, body), 1e-6))
        fine = well[:, body.bones[:, 0]] & well[:, body.bones[:, 1]]
        lengths = np.where(fine, lengths, np.nan)
        spread.append(lengths - _medians(lengths))
        bent = one.standard[2:] - 2.0 * one.standard[1:-1] + one.standard[:-2]
        size = np.sqrt((bent**2).sum(axis=2))
        jerk.append(np.where(well[2:], size, np.nan))
    off, sizes_ = np.concatenate(spread), np.concatenate(jerk)
    shown = movements(taught)
    return Detector(
        np.array([2.0, 0.5, 0.7, 0.7, 1.5, 1.0, 4.0, -0.5, -11.0]),
        _as_unsteady(np.maximum(_filled(_medians(np.abs(off)) / 0.6745), 0.01), shown),
        _as_unsteady(np.maximum(_filled(_medians(sizes_)), 0.001), shown),
    )


def _as_unsteady(usual: Floats, shown: float) -> Floats:
    """Usual sizes (N,) of joints or bones, the less of their own the less was shown: what rested may yet move, and is
    then as unsteady as what moved."""
    moving = float(np.quantile(usual, MOVING)) if len(usual) else 0.0
    share = (RESTING / (RESTING + shown)) ** 2
    return np.sqrt((1.0 - share) * usual**2 + share * moving**2)


def _medians(values: Floats) -> Floats:
    """Medians along the first axis; NaN where there is none."""
    flat = values.reshape(len(values), -1)
    found = np.full(flat.shape[1], np.nan)
    some = np.isfinite(flat).any(axis=0)
    if some.any():
        found[some] = np.nanmedian(flat[:, some], axis=0)
    return found.reshape(values.shape[1:])


def _filled(values: Floats) -> Floats:
    some = values[np.isfinite(values)]
    return np.where(np.isfinite(values), values, float(np.median(some)) if len(some) else 0.05)
