"""The adaptive repair: no noise is told; the library helps where it can and is left where it cannot.

Each round asks the bases what they make of the samples believed so far, finds the outliers as the likeliest history of
each channel, smooths all channels at once and reads noise, outlier rates and the liveliness of the motion off the
result.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ...arrays import Bools, Bytes, Floats
from ...numerics.coupled import lone_step_variance, smooth_coupled
from ..bases.support import Support, as_alike_for_long, ends_alone
from ..gaps.likeliest import Process
from ..gaps.never_seen import never_seen
from ..library.local_prior import Prior
from ..noise.kept_distances import noise_by_distances
from ..noise.level import next_follow, next_held, next_noise, next_rate, overlooked
from ..noise.said_twice import loudest
from ..outliers.bursts import long_runs
from ..outliers.moved_away import moved_away
from ..outliers.one_ended import begins_or_ends
from ..outliers.poles import bends_of
from .beliefs import Asked, Beliefs, Heard, as_they_were, bursts, first_beliefs, heard_of, with_prior
from .filling import DOUBT, in_gaps, with_dynamics
from .given_back import given_back
from .histories import FACTORS, OUTLIER_SPAN, likeliest_histories, pulled
from .liveliness import LEAST_LIVELY, MOST_LIVELY, liveliness_of, lively_around
from .smoothing import certainty, joined, told_by_library
from .traits import UNKNOWN, Traits

ROUNDS = 3
# Where outliers come in bursts each round finds more of every burst, and so how long they are: it goes on meanwhile.
MOST_ROUNDS, RISES = 6, 1.1
# Markers go together more than the covariance of second differences has it, more than that of other clips, and err
# less.
DOUBT_OF_MARKERS_ALONE, DOUBT_OF_MARKERS_TAUGHT = 0.82, 0.95
ONE_DISTANCE = 0.2  # of its samples, as many as a marker's distances alone say of its noise; all markers' say more
FEW = 6.0  # frames; a recording of n of them that has no library adds FEW / n to the variance
# s; a sample is never surer than the mean of those about it for so long: how smooth motion is was itself told in noise
AVERAGED_ALONE, AVERAGED_TAUGHT = 1.0, 10.0


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
    swings, pace : (C,) root mean square of what was taken for noise at first and given back, and about how many Hz.
    steps : of conjugate gradients, all rounds together.
    heard, ended : of the samples, and the beliefs at the end, for whoever repairs them again.
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
    swings: Floats
    pace: Floats
    steps: int
    heard: Heard | None = None
    ended: Beliefs | None = None


@dataclass(frozen=True, eq=False)
class _Search:
    """What a search for outliers found. (T, C) where nothing else is said.

    Attributes
    ----------
    outlier, mode : rejected samples, and which of `FACTORS` the motion has.
    vouched, follow, leaps : as of `Beliefs`.
    told : what the library says, or without one the straight lines across gaps.
    left : the samples, without outliers for so long that they are gaps.
    last : no further round is needed.
    """

    outlier: Bools
    mode: Bytes
    vouched: Bools
    follow: float
    leaps: Floats
    told: Support
    left: Floats
    last: bool


@dataclass(frozen=True, eq=False)
class _Smooth:
    """The channels smoothed: values, variance of their errors and of their second differences (`doubt`), all (T, C);
    weights of the samples, liveliness and `alone` as of `Beliefs`, and steps of conjugate gradients."""

    values: Floats
    variance: Floats
    doubt: Floats
    weight: Floats
    liveliness: Floats
    alone: Floats
    steps: int


def adapt(
    measured: Floats,
    prior: Prior,
    fps: float,
    *,
    traits: Traits = UNKNOWN,
    closer: Callable[[Floats], Prior | None] | None = None,
    process: Process | None = None,
    rounding: Floats | None = None,
    whole: tuple[bool, bool] = (True, True),
    heard: Heard | None = None,
) -> Adapted:
    """Find outliers, noise and the motion beneath.

    Parameters
    ----------
    measured : (T, C) in degrees and centimetres, NaN = missing; T >= 3 and at least a window of the bases.
    prior : what clean motion is like at `fps`.
    fps : Hz.
    traits : what the channels are.
    closer : a prior nearer to a first estimate (T, C); None, or what gives None, keeps the first.
    process : of clean motion, for gaps; None = nothing is known of them.
    rounding : (T, C) variance of what rounding took from the samples; None = nothing.
    whole : whether the recording begins, and ends, with these frames.
    heard : of these samples, or of these and a few more, by who repaired them before; None = nobody did. With beliefs
        it takes a last round, and another prior is not asked.
    """
    taught = prior.bases is not None and not prior.own
    if heard is None or taught:
        heard = heard_of(measured, fps, traits, taught=taught)
    vouched = np.zeros(measured.shape, dtype=bool) if heard.vouched is None else heard.vouched
    rattle, loud = np.zeros(measured.shape) if heard.rattle is None else heard.rattle, heard.loud
    shaken = rattle > 0
    if taught:  # clips tell more of what is missing than such samples do
        measured, rattle = np.where(shaken, np.nan, measured), np.zeros(measured.shape)
    least = np.zeros(measured.shape) if rounding is None else np.sqrt(np.nan_to_num(rounding))
    if traits.lasting is not None:
        least = np.sqrt(np.square(least) + traits.lasting.in_band)
    asked = Asked(measured, shaken, rattle, loud, least, fps, traits, closer, process, whole)
    beliefs = first_beliefs(asked, prior, vouched) if heard.ended is None else as_they_were(asked, heard.ended)
    steps, turn, last = 0, 0 if heard.ended is None else ROUNDS - 1, False
    while not last:
        if closer is not None and beliefs.values is not None and turn == 1:
            beliefs = with_prior(beliefs, closer(beliefs.values), fps)
        turn += 1
        search = _searched(asked, beliefs, turn)
        smooth = _smoothed(asked, beliefs, search)
        beliefs = _read_off(asked, beliefs, search, smooth, turn)
        steps, last = steps + smooth.steps, search.last
    return replace(_finished(asked, beliefs, search, smooth, steps), heard=heard, ended=beliefs)


def _searched(asked: Asked, beliefs: Beliefs, turn: int) -> _Search:
    """Outliers as the likeliest histories have them, but for what the recording itself gives back."""
    measured, present, fps, values = asked.measured, asked.present, asked.fps, beliefs.values
    prior, calm, noise = beliefs.prior, beliefs.calm, beliefs.noise
    vouched, leaps = beliefs.vouched, beliefs.leaps
    told = told_by_library(measured, beliefs.outlier, values, values, prior, noise, fps)
    outlier, mode = likeliest_histories(
        measured,
        told.values,
        told.verdict if prior.own else ends_alone(told.verdict, beliefs.rate),
        np.zeros(measured.shape) if values is None else pulled(values, calm, np.sqrt(beliefs.liveliness)),
        beliefs.alone * lively_around(beliefs.liveliness, calm),
        np.square(noise),
        beliefs.rate,
        beliefs.follow,
        beliefs.held,
        np.diag(calm),
        asked.traits.together,
        vouched,
    )
    if values is not None:
        moved, moving = moved_away(measured - values, outlier, noise, fps, asked.traits.together)
        vouched, outlier = vouched | moved, outlier & ~moved
        mode = np.where(bends_of(moving), len(FACTORS) - 1, mode)
        if asked.traits.together == 1:
            one_sided, leap = begins_or_ends(measured, outlier, asked.whole)
            vouched, outlier = vouched | leap, outlier & ~one_sided
            mode = np.where(bends_of(leap), len(FACTORS) - 1, mode)
            leaps = np.where(leap, np.abs(measured - values), leaps)
        back = np.zeros(outlier.shape, dtype=bool)
        if asked.traits.as_pose is not None:
            back = asked.traits.as_pose(measured, outlier, values)
        if asked.traits.own_leaps is not None:
            own = asked.traits.own_leaps(measured, outlier & ~back, values)
            leaps, back = np.where(own, np.abs(measured - values), leaps), back | own
        if back.any():
            vouched, outlier = vouched | back, outlier & ~back
            mode = np.where(bends_of(back), len(FACTORS) - 1, mode)
    follow = next_follow(outlier, present)
    rising = follow > RISES * beliefs.follow
    last = turn >= ROUNDS and not (rising and turn < MOST_ROUNDS)
    left = measured
    # not before the last search: what is taken for a gap no longer speaks for itself (markers are filled elsewhere)
    if last and asked.traits.together == 1 and (gone := long_runs(outlier | ~present, fps) & outlier).any():
        left = np.where(gone, np.nan, measured)
        told = told_by_library(left, outlier, values, values, prior, noise, fps)
    return _Search(outlier, mode, vouched, follow, leaps, told, left, last)


def _smoothed(asked: Asked, beliefs: Beliefs, search: _Search) -> _Smooth:
    """All channels at once, twice: the first time tells how lively the motion is."""
    calm, values, steps = beliefs.calm, beliefs.values, 0
    liveliness = np.clip(beliefs.liveliness * FACTORS[search.mode], LEAST_LIVELY, MOST_LIVELY)
    present = asked.present
    weight = np.where(present & ~search.outlier, 1.0 / np.square(beliefs.noise), 0.0)
    told = as_alike_for_long(search.told, beliefs.averaged)
    everything, goal = joined(np.where(present, asked.measured, 0.0), weight, told)
    alone = lone_step_variance(everything, calm)
    for again in (True, False):
        values, taken = smooth_coupled(goal, everything, calm, np.sqrt(liveliness), values)
        steps += taken
        variance, doubt = certainty(everything, alone * liveliness)
        if again:
            liveliness = liveliness_of(values, np.diag(calm), doubt, asked.fps)
    assert values is not None
    return _Smooth(values, variance, doubt, weight, liveliness, alone, steps)


def _read_off(asked: Asked, beliefs: Beliefs, search: _Search, smooth: _Smooth, turn: int) -> Beliefs:
    """What the next round begins with: noise and outliers as this one leaves them."""
    present, together, louder = asked.present, asked.traits.together, beliefs.louder
    # of noise twice, and of what the repair is off
    spread = 4.0 * np.square(beliefs.noise) + np.diag(beliefs.calm) * smooth.liveliness
    off = np.where(present, asked.measured, 0.0) - smooth.values
    density = OUTLIER_SPAN**-together
    held = next_held(off, search.outlier, spread, density, together, beliefs.held, bursts(asked.fps)[1])
    believed = smooth.weight > 0
    taken_up = smooth.weight * smooth.variance
    freedom = np.where(believed, 1.0 - np.minimum(taken_up, 1.0), 0.0).sum(axis=0)
    square = np.where(believed, np.square(off / louder), 0.0).sum(axis=0)
    if together > 1:
        kept, tells = noise_by_distances(asked.measured, present & ~search.outlier, louder)
        # what moves fast keeps its distances: no motion is misread for noise by them
        worth = ONE_DISTANCE * tells
        kept = np.square(next_noise(np.sqrt(kept), worth * kept, worth, misread=0.0))
        square, freedom = square + tells * kept, freedom + tells
    level = next_noise(beliefs.level, square, freedom)
    if asked.traits.beside is not None:
        level = np.minimum(level, loudest(asked.measured, believed, louder, asked.traits.beside))
    louder = asked.louder(level)
    return replace(
        beliefs,
        level=level,
        louder=louder,
        noise=np.maximum(level * louder, asked.least),
        rate=next_rate(search.outlier, present, beliefs.rate if turn > 1 else None),
        follow=search.follow,
        held=held,
        vouched=search.vouched,
        outlier=search.outlier,
        values=smooth.values,
        liveliness=smooth.liveliness,
        alone=smooth.alone,
        averaged=np.square(beliefs.noise) / smooth.variance,
        leaps=search.leaps,
    )


def _finished(asked: Asked, beliefs: Beliefs, search: _Search, smooth: _Smooth, steps: int) -> Adapted:
    """What is found, with learned dynamics and gaps filled, and as sure as it is."""
    measured, fps, process = asked.measured, asked.fps, asked.process
    prior, noise, calm = beliefs.prior, beliefs.noise, beliefs.calm
    outlier, values, variance, level = search.outlier, smooth.values, smooth.variance, beliefs.level
    swings = pace = np.zeros(len(level))
    taught, markers = prior.bases is not None and not prior.own, asked.traits.together > 1
    if not markers:
        values, variance = with_dynamics(measured, outlier, values, variance, process, noise, fps)
        # noise that lasts is no whiter in what is left of it
        believed = asked.present & ~outlier
        if asked.traits.lasting is None and (back := given_back(measured, believed, values, beliefs.louder, fps)):
            values, variance = values + back.motion, variance + back.variance
            level, noise = back.quieter * level, back.quieter * noise
            swings, pace = np.sqrt(np.square(back.motion).mean(axis=0)), back.about
    if asked.traits.lasting is not None:
        variance = asked.traits.lasting.left_by(variance)
    variance = _doubted(
        overlooked(measured, values, outlier, noise) * variance,
        np.square(noise),
        fps,
        taught=taught,
        still=prior.still,
        markers=markers,
        frames=int(asked.present.any(axis=1).sum()),
    )
    tried = values
    if not markers:
        left = search.left
        values, variance, tried, taken = in_gaps(
            left, outlier & np.isfinite(left), values, variance, smooth.liveliness, calm, prior, process, noise, fps
        )
        steps += taken
        if prior.bases is not None and taught:
            away = never_seen(measured, outlier, values, prior.bases, prior.stride, asked.traits.joints, fps)
            variance = np.maximum(variance, away)
    return Adapted(
        values=values,
        variance=variance,
        outlier=outlier | asked.shaken,  # next to nothing is left of these either
        noise=level * np.sqrt(np.square(beliefs.louder).mean(axis=0)),
        rate=beliefs.rate,
        supported=search.told,
        unseen_bends=(np.diag(calm) * smooth.liveliness * smooth.doubt).mean(axis=0),
        tried=tried,
        leaps=search.leaps,
        swings=swings,
        pace=pace,
        steps=steps,
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
