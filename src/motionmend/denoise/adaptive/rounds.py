"""The adaptive repair: no noise is told; the library helps where it can and is left where it cannot.

Each round asks the bases what they make of the samples believed so far, finds the outliers as the likeliest history of
each channel, smooths all channels at once and reads noise, outlier rates and the liveliness of the motion off the
result.
"""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from ...arrays import Bools, Bytes, Floats, Ints
from ...numerics.coupled import lone_step_variance, smooth_coupled
from ..bases.repair import interpolated
from ..bases.support import Support, as_alike_for_long, bridged, ends_alone, line_support, support, supported
from ..dynamics.steady import mixed_in, smooth_steadily
from ..gaps.likeliest import Process
from ..gaps.moved import excess, gaps_of, hidden_by, laid_elsewhere
from ..gaps.never_seen import never_seen
from ..gaps.shares import fillings, mixed, shares, unsure
from ..library.local_prior import Prior
from ..noise.kept_distances import noise_by_distances
from ..noise.lasting import Lasting
from ..noise.level import first_noise, next_follow, next_held, next_noise, next_rate, overlooked
from ..noise.passing import loudness, without_floor
from ..noise.rattling import but_for_poses, rattles
from ..outliers.bursts import long_runs
from ..outliers.moved_away import moved_away
from ..outliers.poles import bends_of
from .liveliness import LEAST_LIVELY, MOST_LIVELY, liveliness_of, lively_around

ROUNDS = 3
# Where outliers come in bursts each round finds more of every burst, and so how long they are: it goes on meanwhile.
MOST_ROUNDS, RISES = 6, 1.1
HISTORIES = 14  # kept side by side for each channel
# Motion is calm, bursts or jumps: factors on the variance of its second differences, how common each is and how
# likely a burst or jump goes on. Wide on purpose: which factors exactly hardly matters, that there are three does.
FACTORS = np.array([1.0, 25.0, 1000.0])
COMMON = np.array([0.96, 0.035, 0.005])
GOES_ON = 0.7
OUTLIER_SPAN = 80.0  # degrees or cm over which an outlier may lie
# before anything is known: the share of outliers, and that of samples after one, 1/30 s on, that are off by as much
FIRST_RATE, FIRST_HELD = 0.08, 0.12
UNCOUPLED = 0.1  # share of the covariance of second differences that is not believed
BEND = 0.03  # degrees or cm a frame at 30 Hz: second differences no smaller count as motion
STILL = 0.1  # times that where it was seen how little a channel moves
LEAST_BELIEVED = 0.1  # of a channel's samples
_NOTHING = 1e-300
AT_REST = 1.0  # degrees or cm; channels that stray less tell nothing of how far a repair errs
# Variances come from a model told its own noise, outliers and liveliness; being found, they add this much doubt.
DOUBT = 1.12
# Markers go together more than the covariance of second differences has it, more than that of other clips, and err
# less.
DOUBT_OF_MARKERS_ALONE, DOUBT_OF_MARKERS_TAUGHT = 0.82, 0.95
ONE_DISTANCE = 0.2  # of its samples, as many as a marker's distances alone say of its noise; all markers' say more
FEW = 6.0  # frames; a recording of n of them that has no library adds FEW / n to the variance
# s; a sample is never surer than the mean of those about it for so long: how smooth motion is was itself told in noise
AVERAGED_ALONE, AVERAGED_TAUGHT = 1.0, 10.0
VAGUE = 400.0  # square of channel units: where a channel begins, beside how far it strays


@dataclass(frozen=True, eq=False)
class Adapted:
    """What the adaptive repair finds. (T, C) each where nothing else is said, channel units.

    Attributes
    ----------
    values : the smoothed channels.
    variance : of the errors that are to be expected.
    outlier : True where a sample is rejected.
    noise : (C,) standard deviations, the root mean square over all frames.
    rate : (C,) share of outliers.
    supported : what the library says, or without one the straight lines across gaps.
    unseen_bends : (C,) mean variance of the second differences that the samples leave open.
    tried : the values, but where gaps were laid elsewhere as they were filled there.
    leaps : how far samples leap that were rejected at first, and then taken for the recording's own; 0 elsewhere.
    steps : of conjugate gradients, all rounds together.
    """

    values: Floats
    variance: Floats
    outlier: Bools
    noise: Floats
    rate: Floats
    supported: Support
    unseen_bends: Floats
    tried: Floats
    leaps: Floats
    steps: int


def adapt(
    measured: Floats,
    prior: Prior,
    fps: float,
    *,
    closer: Callable[[Floats], Prior | None] | None = None,
    process: Process | None = None,
    together: int = 1,
    vouched: Bools | None = None,
    as_pose: Callable[[Floats, Bools, Floats], Bools] | None = None,
    own_leaps: Callable[[Floats, Bools, Floats], Bools] | None = None,
    rounding: Floats | None = None,
    joints: Ints | None = None,
    lasting: Lasting | None = None,
) -> Adapted:
    """Find outliers, noise and the motion beneath.

    Parameters
    ----------
    measured : (T, C) in degrees and centimetres, NaN = missing; T >= 3 and at least a window of the bases.
    prior : what clean motion is like at `fps`.
    fps : Hz.
    closer : a prior nearer to a first estimate (T, C); None, or what gives None, keeps the first.
    process : of clean motion, for gaps; None = nothing is known of them.
    together : G, neighbouring columns that are outliers together: 1 for angles, 3 for markers.
    vouched : (T, C) True where a sample is no outlier and what bends there may bend as it will, as at
        `poles.pole_crossings`; None = nowhere.
    as_pose : of measured, rejected and values, what is no outlier for the pose: `as_pose.smoother_as_pose`; None =
        nothing.
    own_leaps : of the same, what leaps like the recording itself: `own_jumps.own_jumps`; None = nothing.
    rounding : (T, C) variance of what rounding took from the samples; None = nothing.
    joints : (C,) a number for each joint, alike where columns are angles of one; None = each has one of its own.
    lasting : noise that lasts; None = it is new in every frame.
    """
    channels = measured.shape[1]
    nowhere, leaps = np.zeros(measured.shape, dtype=bool), np.zeros(measured.shape)
    vouched = nowhere if vouched is None else vouched
    rattle = but_for_poses(rattles(measured, fps, together), measured, vouched, as_pose)
    shaken = rattle > 0
    if prior.bases is not None and not prior.own:  # clips tell more of what is missing than such samples do
        measured, rattle = np.where(shaken, np.nan, measured), np.zeros(measured.shape)
    present = np.isfinite(measured)
    calm = _calm(prior, fps)
    filled = np.where(present, measured, 0.0)
    loud = loudness(measured, fps, together, joints)
    level, rate = first_noise(measured, loud), np.full(channels, FIRST_RATE)
    louder = np.maximum(without_floor(loud, level, together), rattle / level)
    least = np.zeros(measured.shape) if rounding is None else np.sqrt(np.nan_to_num(rounding))
    if lasting is not None:
        least = np.sqrt(np.square(least) + lasting.in_band)
    noise = np.maximum(level * louder, least)
    stays = FIRST_HELD ** (30.0 / fps)  # a slip lasts for a time, whatever the rate
    follow = 1.0 - (1.0 - FIRST_RATE) * (1.0 - stays)
    held = first_held = stays / follow
    outlier, liveliness, alone = nowhere, np.ones(measured.shape), np.diag(calm)
    values: Floats | None = None
    averaged = np.ones(measured.shape)  # samples' worth of each frame's estimate
    left, steps = measured, 0  # without the bursts that are so long that they are gaps
    turn, last = 0, False
    while not last:
        nearer = closer(values) if closer is not None and values is not None and turn == 1 else None
        if nearer is not None:
            before, prior = np.diag(calm), nearer
            calm = _calm(prior, fps)
            liveliness = np.clip(liveliness * before / np.diag(calm), LEAST_LIVELY, MOST_LIVELY)
        told = _told(measured, outlier, values, values, prior, noise, fps)
        pull = np.zeros(measured.shape) if values is None else _pull(values, calm, np.sqrt(liveliness))
        outlier, mode = _histories(
            measured,
            told.values,
            told.verdict if prior.own else ends_alone(told.verdict, rate),
            pull,
            alone * lively_around(liveliness, calm),
            np.square(noise),
            rate,
            follow,
            held,
            np.diag(calm),
            together,
            vouched,
        )
        if values is not None:
            moved, moving = moved_away(measured - values, outlier, noise, fps, together)
            vouched, outlier = vouched | moved, outlier & ~moved
            mode = np.where(bends_of(moving), len(FACTORS) - 1, mode)
            back = nowhere if as_pose is None else as_pose(measured, outlier, values)
            if own_leaps is not None:
                own = own_leaps(measured, outlier & ~back, values)
                leaps, back = np.where(own, np.abs(measured - values), leaps), back | own
            if back.any():
                vouched, outlier = vouched | back, outlier & ~back
                mode = np.where(bends_of(back), len(FACTORS) - 1, mode)
        found = next_follow(outlier, present)
        turn, rising, follow = turn + 1, found > RISES * follow, found
        last = turn >= ROUNDS and not (rising and turn < MOST_ROUNDS)
        # not before the last search: what is taken for a gap no longer speaks for itself (markers are filled elsewhere)
        if last and together == 1 and (gone := long_runs(outlier | ~present, fps) & outlier).any():
            left = np.where(gone, np.nan, measured)
            told = _told(left, outlier, values, values, prior, noise, fps)
        liveliness = np.clip(liveliness * FACTORS[mode], LEAST_LIVELY, MOST_LIVELY)
        weight = np.where(present & ~outlier, 1.0 / np.square(noise), 0.0)
        told = as_alike_for_long(told, averaged)
        everything, goal = _joined(filled, weight, told)
        for again in (True, False):
            values, taken = smooth_coupled(goal, everything, calm, np.sqrt(liveliness), values)
            steps += taken
            alone = lone_step_variance(everything, calm)
            variance, doubt = _certainty(everything, alone * liveliness)
            if again:
                liveliness = liveliness_of(values, np.diag(calm), doubt, fps)
        averaged = np.square(noise) / variance
        spread = 4.0 * np.square(noise) + np.diag(calm) * liveliness  # of noise twice, and of what the repair is off
        off = filled - values
        held = next_held(off, outlier, spread, OUTLIER_SPAN**-together, together, held, first_held)
        taken_up = weight * variance
        freedom = np.where(weight > 0, 1.0 - np.minimum(taken_up, 1.0), 0.0).sum(axis=0)
        square = np.where(weight > 0, np.square(off / louder), 0.0).sum(axis=0)
        if together > 1:
            kept, tells = noise_by_distances(measured, present & ~outlier, louder)
            # what moves fast keeps its distances: no motion is misread for noise by them
            worth = ONE_DISTANCE * tells
            kept = np.square(next_noise(np.sqrt(kept), worth * kept, worth, misread=0.0))
            square, freedom = square + tells * kept, freedom + tells
        level = next_noise(level, square, freedom)
        louder = np.maximum(without_floor(loud, level, together), rattle / level)
        noise = np.maximum(level * louder, least)
        rate = next_rate(outlier, present, rate if turn > 1 else None)
    assert values is not None
    unseen = (np.diag(calm) * liveliness * doubt).mean(axis=0)
    if together == 1:
        values, variance = _with_dynamics(measured, outlier, values, variance, process, noise, fps)
    if lasting is not None:
        variance = lasting.left_by(variance)
    variance = _doubted(
        overlooked(measured, values, outlier, noise) * variance,
        np.square(noise),
        fps,
        taught=prior.bases is not None and not prior.own,
        still=prior.still,
        markers=together > 1,
        frames=int(present.any(axis=1).sum()),
    )
    tried = values
    if together == 1:
        values, variance, tried, taken = _in_gaps(
            left, outlier & np.isfinite(left), values, variance, liveliness, calm, prior, process, noise, fps
        )
        steps += taken
        if prior.bases is not None and not prior.own:
            away = never_seen(measured, outlier, values, prior.bases, prior.stride, joints, fps)
            variance = np.maximum(variance, away)
    return Adapted(
        values,
        variance,
        outlier | shaken,  # next to nothing is left of these either
        level * np.sqrt(np.square(louder).mean(axis=0)),
        rate,
        told,
        unseen,
        tried,
        leaps,
        steps,
    )


def _doubted(
    variance: Floats, noise_var: Floats, fps: float, *, taught: bool, still: Bools | None, markers: bool, frames: int
) -> Floats:
    """(T, C) variance of the errors to be expected, from what it were (T, C) if all of the model were known."""
    doubt = DOUBT if not markers else DOUBT_OF_MARKERS_TAUGHT if taught else DOUBT_OF_MARKERS_ALONE
    few = 1.0 if taught else 1.0 + FEW / max(1, frames)
    averaged = np.full(variance.shape[1], AVERAGED_TAUGHT if taught else AVERAGED_ALONE)
    if still is not None:
        averaged[still] = AVERAGED_TAUGHT  # how little those bend at most is taken, doubt and all
    return np.asarray(doubt * few * variance + noise_var / (averaged * fps))


def _told(
    measured: Floats,
    outlier: Bools,
    begin: Floats | None,
    smooth: Floats | None,
    prior: Prior,
    noise: Floats,
    fps: float,
) -> Support:
    """What the library says of a recording, or without one the lines across gaps; the fit begins at `begin`."""
    present, believed = np.isfinite(measured), np.where(outlier, np.nan, measured)
    bases = prior.bases
    if bases is None:
        return line_support(believed, present)
    begin = interpolated(believed, bases.mean.mean(axis=0)) if begin is None else begin
    values = supported(believed, begin, bases, prior.stride)
    return support(measured, present & ~outlier, smooth, values, bases, noise, fps, own=prior.own)


def _with_dynamics(
    measured: Floats,
    outlier: Bools,
    values: Floats,
    variance: Floats,
    process: Process | None,
    noise: Floats,
    fps: float,
) -> tuple[Floats, Floats]:
    """(T, C) values and variance once learned dynamics, run on what was cleaned, have their share."""
    if process is None or process.dynamics is None or round(fps / process.fps) != 1:
        return values, variance
    present = np.isfinite(measured)
    believed = present & ~outlier
    # what replaces a sample tells nothing; the noisier one is than usual, the nearer it is brought to the repair
    usual = 1.0 / np.sqrt(np.square(1.0 / noise).mean(axis=0))
    tells = np.where(believed, np.square(usual / noise), 0.0)
    thinned = usual / np.sqrt(np.maximum(tells.mean(axis=0), LEAST_BELIEVED))
    seen = values + np.minimum(tells, 1.0) * np.where(believed, measured - values, 0.0)
    steady, sure = smooth_steadily(process.dynamics, seen, thinned, values[:2])
    return mixed_in(steady, sure, values, variance, present)


def _in_gaps(
    measured: Floats,
    outlier: Bools,
    values: Floats,
    variance: Floats,
    liveliness: Floats,
    calm: Floats,
    prior: Prior,
    process: Process | None,
    noise: Floats,
    fps: float,
) -> tuple[Floats, Floats, Floats, int]:
    """(T, C) the channels with gaps filled as the recording's own say, their variance, `Adapted.tried`, and steps.

    The gaps are laid elsewhere and filled once more, by all that was found but what is hidden now; outliers stay
    what they are, so that no history has to be searched again.
    """
    present = np.isfinite(measured)
    gaps = gaps_of(present)
    if not gaps:
        return values, variance, values, 0
    moved = laid_elsewhere(gaps, present)
    hidden = hidden_by(moved, measured.shape)
    left = np.where(hidden, np.nan, measured)
    begin = bridged(np.where(hidden, np.nan, values))
    blind = prior if prior.elsewhere is None else replace(prior, bases=prior.elsewhere)
    told = _told(left, outlier, begin, values, blind, noise, fps)  # of `values` only what is believed is looked at
    weight = np.where(np.isfinite(left) & ~outlier, 1.0 / np.square(noise), 0.0)
    everything, goal = _joined(np.nan_to_num(left), weight, told)
    lively = np.exp(bridged(np.where(hidden, np.nan, np.log(liveliness))))
    filled, steps = smooth_coupled(goal, everything, calm, np.sqrt(lively), begin)
    sure = DOUBT * _certainty(everything, lone_step_variance(everything, calm) * lively)[0]
    telling = present & ~outlier & (values.std(axis=0) > AT_REST)
    tried, own = fillings(filled, hidden | ~present, process, fps)
    counts = shares(gaps + moved, moved, tried - values, telling)
    found, sure_here = fillings(values, ~present, process, fps)
    best = mixed(found, counts)
    if not moved:
        return best, variance, best, steps
    there = mixed(tried, counts)
    away = np.sqrt(np.square(there - values) + variance)  # they are not the truth themselves
    beyond = excess(gaps, moved, away, unsure(tried, counts, sure, own), telling)
    return best, unsure(found, counts, variance, sure_here) * beyond, np.where(hidden, there, best), steps


def _calm(prior: Prior, fps: float) -> Floats:
    """(C, C) covariance of second differences in the calm mode: somewhat uncoupled, and nowhere nothing."""
    bends, least = prior.bends, np.full(len(prior.bends), least_bend(fps))
    if prior.still is not None:
        least[prior.still] *= STILL**2
    return np.asarray((1.0 - UNCOUPLED) * bends + np.diag(UNCOUPLED * np.diag(bends) + least))


def least_bend(fps: float) -> float:
    """Variance of second differences at `fps` Hz, in channel units, up to which nothing counts as motion."""
    return float((BEND * (30.0 / fps) ** 2) ** 2)


def _joined(filled: Floats, weight: Floats, told: Support) -> tuple[Floats, Floats]:
    """Weights (T, C) of samples and library together, and the values they weigh."""
    library = 1.0 / told.variance
    total = weight + library
    return total, (weight * filled + library * told.values) / np.maximum(total, _NOTHING)


def _pull(values: Floats, calm: Floats, scale: Floats) -> Floats:
    """(T, C) second difference of each channel that those of the others let expect."""
    bend = (values[:-2] - 2.0 * values[1:-1] + values[2:]) / scale[2:]
    precision = np.linalg.inv(calm)
    pull = np.zeros(values.shape)
    pull[2:] = (bend - bend @ precision / np.diag(precision)) * scale[2:]
    return pull


def _certainty(weight: Floats, step_var: Floats) -> tuple[Floats, Floats]:
    from ...kernels.banded import walk_certainty

    vague = np.full(weight.shape[1], VAGUE)
    return walk_certainty(np.ascontiguousarray(weight), np.ascontiguousarray(step_var), vague, vague)


def _histories(
    measured: Floats,
    expected: Floats,
    doubt: Floats,
    pull: Floats,
    step_var: Floats,
    noise_var: Floats,
    rate: Floats,
    follow: float,
    held: float,
    calm: Floats,
    together: int,
    vouched: Bools,
) -> tuple[Bools, Bytes]:
    """Outliers and modes (T, C) of the likeliest history of every channel or group of channels."""
    from ...kernels.search import likeliest_history

    channels = measured.shape[1]
    goes_on = np.where(np.arange(len(COMMON)) > 0, GOES_ON, 0.0)[:, None]
    log_modes = np.log(goes_on * np.eye(len(COMMON)) + (1.0 - goes_on) * COMMON)
    known = np.isfinite(measured)
    begin = np.array([np.median(measured[known[:, c], c]) if known[:, c].any() else 0.0 for c in range(channels)])
    strays = np.where(known, np.square(measured - begin), 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
    density, at_pole = OUTLIER_SPAN**-together, bends_of(vouched)

    def history(first: int) -> tuple[Bytes, Bytes]:
        own = slice(first, first + together)
        return likeliest_history(
            np.ascontiguousarray(measured[:, own]),
            np.ascontiguousarray(expected[:, own]),
            np.ascontiguousarray(doubt[:, own]),
            np.ascontiguousarray(pull[:, own]),
            np.ascontiguousarray(step_var[:, own]),
            np.ascontiguousarray(noise_var[:, own]),
            float(rate[own].mean()),
            max(follow, float(rate[own].mean())),
            density,
            held,
            FACTORS,
            log_modes,
            HISTORIES,
            begin[own],
            VAGUE + strays[own],
            50.0 * calm[own] + 1.0,
            np.ascontiguousarray(vouched[:, own].any(axis=1)),
            np.ascontiguousarray(at_pole[:, own].any(axis=1)),
        )

    found = _in_threads(history, list(range(0, channels, together)))
    outlier = np.stack([o for o, _ in found], axis=1).repeat(together, axis=1).astype(bool)
    mode = np.stack([m for _, m in found], axis=1).repeat(together, axis=1)
    return outlier & known, mode


def _in_threads(task: Callable[[int], tuple[Bytes, Bytes]], items: list[int]) -> list[tuple[Bytes, Bytes]]:
    """The task of every item, in order; the kernels let threads run side by side."""
    first = [task(items[0])]  # compiles it once
    with ThreadPoolExecutor(max_workers=min(4, os.cpu_count() or 1)) as pool:
        return first + list(pool.map(task, items[1:]))
