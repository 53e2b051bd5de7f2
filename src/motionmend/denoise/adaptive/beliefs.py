"""What is believed of the channels from round to round of the adaptive repair, and from one repair to the next."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ...arrays import Bools, Floats, Singles
from ..gaps.likeliest import Process
from ..library.local_prior import Prior
from ..noise.level import first_noise
from ..noise.passing import loudness, without_floor
from ..noise.rattling import but_for_poses, rattles
from ..noise.said_twice import rattles_once
from .liveliness import LEAST_LIVELY, MOST_LIVELY
from .smoothing import calm_bends
from .traits import Traits

# before anything is known: the share of outliers, and that of samples after one, 1/30 s on, that are off by as much
FIRST_RATE, FIRST_HELD = 0.08, 0.12


@dataclass(frozen=True, eq=False)
class Asked:
    """What is asked: the channels, and what is known of them before the first round. (T, C) where nothing else is said.

    Attributes
    ----------
    measured : NaN = missing; what rattles counts as missing where a library tells more.
    shaken, rattle : True where samples rattle, and by how much where they still count, 0 elsewhere.
    loud : the noise, by its channel's level.
    least : no noise is smaller.
    fps, traits, closer, process, whole : as of `adapt`.
    """

    measured: Floats
    shaken: Bools
    rattle: Floats
    loud: Floats
    least: Floats
    fps: float
    traits: Traits
    closer: Callable[[Floats], Prior | None] | None
    process: Process | None
    whole: tuple[bool, bool]

    @property
    def present(self) -> Bools:
        """(T, C) True where there is a sample."""
        return np.isfinite(self.measured)

    def louder(self, level: Floats) -> Floats:
        """(T, C) times the level (C,) of its channel that the noise is at each moment."""
        return np.maximum(without_floor(self.loud, level, self.traits.together), self.rattle / level)


@dataclass(frozen=True, eq=False)
class Beliefs:
    """What a round begins with. (T, C) where nothing else is said, channel units.

    Attributes
    ----------
    prior, calm : of the motion, and (C, C) the covariance of its second differences when calm.
    level, louder, noise : (C,) of the noise, times that at each moment, and both together.
    rate : (C,) share of outliers.
    follow, held : share of the samples after one that are some as well, and of these that are off by as much.
    vouched : True where a sample is no outlier.
    outlier : of the round before.
    values : smoothed in the round before; None before the first.
    liveliness, alone : factors on `calm`, and (C,) what of it the other channels leave open.
    averaged : samples' worth of each frame's estimate.
    leaps : as of `Adapted`.
    """

    prior: Prior
    calm: Floats
    level: Floats
    louder: Floats
    noise: Floats
    rate: Floats
    follow: float
    held: float
    vouched: Bools
    outlier: Bools
    values: Floats | None
    liveliness: Floats
    alone: Floats
    averaged: Floats
    leaps: Floats


@dataclass(frozen=True, eq=False)
class Ended:
    """Beliefs with which a repair ended, in half the memory: (T, C) values, liveliness and `averaged`, and the others
    but for what these and the samples tell."""

    others: Beliefs
    values: Singles
    liveliness: Singles
    averaged: Singles


@dataclass(frozen=True, eq=False)
class Heard:
    """What samples tell of their noise before any repair, alike for all that repair them. (T, C) each.

    Attributes
    ----------
    vouched : True where a sample is no outlier; None = nowhere.
    rattle : the standard deviation of the noise where a channel rattles, 0 elsewhere; None = nowhere.
    loud : the noise at each moment, by its channel's level.
    ended : the beliefs with which a repair of them ended; None = another begins anew.
    """

    vouched: Bools | None
    rattle: Floats | None
    loud: Floats
    ended: Ended | None = None


def heard_of(measured: Floats, fps: float, traits: Traits, *, taught: bool) -> Heard:
    """What samples tell of their noise.

    Parameters
    ----------
    measured : (T, C) in degrees and cm, NaN = missing.
    fps : Hz.
    traits : what the channels are.
    taught : whether clips tell of the motion: samples that rattle count for nothing then.
    """
    vouched = np.zeros(measured.shape, dtype=bool) if traits.leaping is None else traits.leaping(measured)
    rattle = rattles_once(rattles(measured, fps, traits.together), measured, traits.beside)
    rattle = but_for_poses(rattle, measured, vouched, traits.as_pose, traits.joints, traits.limb)
    left = np.where(rattle > 0, np.nan, measured) if taught else measured
    loud = loudness(left, fps, traits.together, traits.joints)
    return Heard(vouched if vouched.any() else None, rattle if rattle.any() else None, loud)


def bursts(fps: float) -> tuple[float, float]:
    """Share of the samples after an outlier that are some as well, and of these that are off by as much, before any is
    known."""
    stays = FIRST_HELD ** (30.0 / fps)  # a slip lasts for a time, whatever the rate
    follow = 1.0 - (1.0 - FIRST_RATE) * (1.0 - stays)
    return follow, stays / follow


def first_beliefs(asked: Asked, prior: Prior, vouched: Bools) -> Beliefs:
    """What is supposed before the first round."""
    shape, calm = asked.measured.shape, calm_bends(prior, asked.fps)
    level = first_noise(asked.measured, asked.loud)
    louder = asked.louder(level)
    follow, held = bursts(asked.fps)
    return Beliefs(
        prior=prior,
        calm=calm,
        level=level,
        louder=louder,
        noise=np.maximum(level * louder, asked.least),
        rate=np.full(shape[1], FIRST_RATE),
        follow=follow,
        held=held,
        vouched=vouched,
        outlier=np.zeros(shape, dtype=bool),
        values=None,
        liveliness=np.ones(shape),
        alone=np.diag(calm),
        averaged=np.ones(shape),
        leaps=np.zeros(shape),
    )


def in_short(beliefs: Beliefs) -> Ended:
    """Beliefs after a round, but for what `as_they_were` works out again."""
    assert beliefs.values is not None
    kept = (one.astype(np.float32) for one in (beliefs.values, beliefs.liveliness, beliefs.averaged))
    no = np.empty((0, 0))
    return Ended(replace(beliefs, louder=no, noise=no, leaps=no, values=None, liveliness=no, averaged=no), *kept)


def as_they_were(asked: Asked, ended: Ended) -> Beliefs:
    """The beliefs with which a repair of much the same samples ended; no leap is known of them."""
    level = ended.others.level
    louder = asked.louder(level)
    return replace(
        ended.others,
        louder=louder,
        noise=np.maximum(level * louder, asked.least),
        leaps=np.zeros(louder.shape),
        values=ended.values.astype(np.float64),
        liveliness=ended.liveliness.astype(np.float64),
        averaged=ended.averaged.astype(np.float64),
    )


def with_prior(beliefs: Beliefs, prior: Prior | None, fps: float) -> Beliefs:
    """What is believed with another prior, under which the motion bends as much as before; None = the one there is."""
    if prior is None:
        return beliefs
    calm = calm_bends(prior, fps)
    liveliness = np.clip(beliefs.liveliness * np.diag(beliefs.calm) / np.diag(calm), LEAST_LIVELY, MOST_LIVELY)
    return replace(beliefs, prior=prior, calm=calm, liveliness=liveliness)
