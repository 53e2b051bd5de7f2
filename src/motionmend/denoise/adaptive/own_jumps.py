"""Rejected samples that are a recording's own: where outliers are rare, what jumps is as likely the motion.

Even a clean recording holds samples that nothing before or after them explains: steps and claps seen at 30 Hz, skin
that slips over a bone, a solver that turns two joints against each other. The search takes some of them for outliers,
and from those it reads how common outliers are. Outliers lie anywhere, whatever the channel does else; a recording's
own jumps are seldom many times as sharp as its motion. Joints that meet jump together, and outliers come one by one
where they are of channels, all angles of a joint at once where it is the joint that was solved wrongly. How many of the
rejected samples are of either kind, and how many of either come in company, is told by all of them together.
"""

import numpy as np
from scipy.ndimage import binary_closing, binary_opening, label
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ...arrays import Bools, Floats, Ints
from ...bodies.skeleton import ROTATION, Skeleton
from ..noise.level import LEAST_NOISE
from .histories import OUTLIER_SPAN

TAIL = 1.5  # what is sharper than the sharpest of the calm motion is x times as sharp, or more, at x ** -1.5
FEWEST = 8  # second differences that tell how sharply a channel moves
ROUNDS = 30
HOLE, LONGEST = 0.2, 0.25  # s; rejected samples no further apart than the one are a burst if they last for the other
LIMB = 5  # channels: of 715 own jumps in 40 clean CMU clips at 30 Hz 8 have as many, and an arm has 8
SEVERAL, SLIGHT = 6, 10.0  # frames on end and degrees or cm, off by less than which so long they are no outliers
ONE_SIDE = 0.9  # of how far they are off that their mean is
HALF = 0.5  # sample of either kind that is taken for granted
# Of outliers those that come with others of their joint, before anything is known, and as many outliers as say as much.
# Where fewer than these do, what comes together is as likely a jump of its own: they are taken for less, to this power.
SPOILT, SAYS, MOSTLY, FURTHER = 0.1, 5.0, 0.5, 3.0
LIKE_AXES = 0.5  # cosine: joints that hang on one turn the same way about them
AS_FAR = 0.1  # of how far two jumps are off: by which those of joints beside each other differ at most
BRIEF = 2  # frames on end; a joint that is solved wrongly for longer has passed to another set of angles
HALF_TURN = 180.0  # degrees
AT_AN_END = 2  # rejected samples on end before which, or after which, none is believed
_NOTHING = 1e-12


def own_jumps(
    measured: Floats, outlier: Bools, values: Floats, linked: Bools, fps: float, beside: Bools | None = None
) -> Bools:
    """Rejected samples that are more likely the recording's own than outliers.

    Parameters
    ----------
    measured : (T, C) degrees and centimetres, NaN = missing.
    outlier : (T, C) rejected.
    values : (T, C) the repair of an earlier round.
    linked : (C, C) channels that jump together: `channels_that_meet`.
    fps : Hz.
    beside : (C, C) `channels_beside`; None = there are none.

    Returns
    -------
    (T, C) True where a rejected sample is no outlier. Exact zeros and half turns are: so is written what is not known.
    So are bursts, and what a whole limb does at once: it was lost. What stays off by little is the recording's own,
    however long it lasts: so solvers turn two joints against each other.

    Source
    ------
    Two kinds of samples, their shares found by expectation and maximisation: Dempster, Laird and Rubin, Journal of the
    Royal Statistical Society B 39(1), 1977.
    """
    lost = _limbs_lost(outlier, linked)
    back = _slight(measured - values, outlier & ~lost)
    seen = np.isfinite(measured).any(axis=1)
    if seen.sum() < FEWEST + 2:  # nothing tells how sharply it moves, nor that an end is the wrong one of two parts
        back[seen] |= _at_an_end((outlier & ~lost)[seen]) & (measured[seen] % HALF_TURN != 0.0)
        return back
    bend = np.abs(values[:-2] - 2.0 * values[1:-1] + values[2:])
    calm = ~(outlier[:-2] | outlier[1:-1] | outlier[2:])
    # a lone sample that is off by so much bends twice as sharply
    sharpest = np.maximum(0.5 * np.where(calm, bend, 0.0).max(axis=0, initial=0.0), LEAST_NOISE)
    frames, channels = np.nonzero(outlier & ~lost & (calm.sum(axis=0) >= FEWEST) & (measured % HALF_TURN != 0.0))
    if not len(frames):
        return back
    width = sharpest[channels]
    away = np.maximum(np.abs(measured[frames, channels] - values[frames, channels]) / width, 1.0)
    # density of either kind at this size: even up to the sharpest, then a power; even over the whole span
    likelier = TAIL / (1.0 + TAIL) * away ** -(TAIL + 1.0) / width * OUTLIER_SPAN
    together = (outlier[frames] & linked[channels]).any(axis=1)
    partners = linked.sum(axis=0)[channels]
    brief = ~binary_opening(outlier, np.ones((BRIEF + 1, 1), dtype=np.bool_))[frames, channels]
    own, joined, spoilt, samples = HALF, HALF, SPOILT, int(np.isfinite(measured).sum())
    for _ in range(ROUNDS):
        rate = ((1.0 - own) * len(frames) + HALF) / (samples + 2.0 * HALF)
        by_chance = np.clip(1.0 - (1.0 - rate) ** partners, _NOTHING, 1.0 - _NOTHING)
        believed = spoilt * min(1.0, spoilt / MOSTLY) ** FURTHER
        company = np.where(brief, believed + (1.0 - believed) * by_chance, by_chance)  # of an outlier
        odds = own / (1.0 - own) * likelier
        odds *= np.where(together, joined / company, (1.0 - joined) / (1.0 - company))
        share = odds / (1.0 + odds)
        own = (share.sum() + HALF) / (len(frames) + 2.0 * HALF)
        joined = ((share * together).sum() + HALF) / (share.sum() + 2.0 * HALF)
        alien = brief * (1.0 - share)
        meant = alien * together * spoilt / (spoilt + (1.0 - spoilt) * by_chance)
        spoilt = (meant.sum() + SPOILT * SAYS) / (alien.sum() + SAYS)
    # what two joints say of it says nothing of the others that are rejected
    odds *= _leapt_as_far(measured - values, outlier, beside)[frames, channels]
    back[frames, channels] |= (odds > 1.0) & ~_bursts(outlier, fps)[frames, channels]
    return back


def _leapt_as_far(off: Floats, outlier: Bools, beside: Bools | None) -> Floats:
    """(T, C) by how much a jump of the recording's own is likelier than an outlier since a channel beside jumps as far.

    Outliers are as far off as each other by chance alone; hand and thumb are often turned by one marker.
    """
    likelier = np.ones(off.shape)
    if beside is None:
        return likelier
    for c in np.flatnonzero(outlier.any(axis=0) & beside.any(axis=0)):
        own, others = off[:, [c]], np.where(outlier[:, beside[c]], off[:, beside[c]], np.nan)
        far = np.maximum(np.abs(own), np.abs(others))
        alike = (outlier[:, [c]] & (np.abs(own - others) < AS_FAR * far)).any(axis=1)
        likelier[alike, c] = np.maximum(OUTLIER_SPAN / (2.0 * AS_FAR * np.abs(off[alike, c])), 1.0)
    return likelier


def _slight(off: Floats, outlier: Bools) -> Bools:
    """(T, C) True where rejected samples of a channel, some on end, are off by little, all to the same side."""
    several = binary_opening(outlier, np.ones((SEVERAL, 1), dtype=np.bool_))
    part, count = label(several, np.array([[0, 1, 0]] * 3))
    if not count:
        return several
    away = np.where(several, off, 0.0)
    total, size = (np.bincount(part.ravel(), one.ravel()) for one in (away, np.abs(away)))
    slight = (size < SLIGHT * np.bincount(part.ravel())) & (np.abs(total) > ONE_SIDE * size)
    return np.asarray(several & slight[part])


def _at_an_end(outlier: Bools) -> Bools:
    """(T, C) True where rejected samples, some on end, begin or end a channel."""
    first, last = np.logical_and.accumulate(outlier), np.logical_and.accumulate(outlier[::-1])[::-1]
    return np.asarray((first & (first.sum(axis=0) >= AT_AN_END)) | (last & (last.sum(axis=0) >= AT_AN_END)))


def _bursts(outlier: Bools, fps: float) -> Bools:
    """(T, C) True where rejected samples come in long bursts, with others between them or not."""
    hole, length = (max(2, round(seconds * fps) + 1) for seconds in (HOLE, LONGEST))
    joined = binary_closing(np.pad(outlier, ((hole, hole), (0, 0))), np.ones((hole, 1), dtype=np.bool_))[hole:-hole]
    return np.asarray(binary_opening(joined, np.ones((length, 1), dtype=np.bool_)))


def _limbs_lost(outlier: Bools, linked: Bools) -> Bools:
    """(T, C) True where `LIMB` rejected samples of a frame or more are linked, one through the other."""
    lost = np.zeros(outlier.shape, dtype=bool)
    frames, channels = np.nonzero(outlier)
    number = np.zeros(outlier.shape, dtype=np.int64)
    number[frames, channels] = np.arange(len(frames))
    one, other = np.nonzero(np.triu(linked))
    frame, pair = np.nonzero(outlier[:, one] & outlier[:, other])
    if len(frame):  # all frames in one graph, whose parts lie within a frame each
        ends = number[frame, one[pair]], number[frame, other[pair]]
        graph = coo_array((np.ones(len(frame)), ends), shape=(len(frames), len(frames)))
        part = connected_components(graph, directed=False)[1]
        lost[frames, channels] = np.bincount(part)[part] >= LIMB
    return lost


def channels_that_meet(skeleton: Skeleton, columns: Ints) -> Bools:
    """(C, C) True for two channels of one joint, or of a joint and its parent.

    Parameters
    ----------
    skeleton : of the motion.
    columns : (C,) rows of the skeleton, -1 = a channel it does not have.
    """
    joint = np.where(columns >= 0, skeleton.dof_joint[columns], -1)
    parent = np.where(joint >= 0, skeleton.parents[joint], -1)
    above = (joint[:, None] == parent) & (joint[:, None] >= 0)
    met: Bools = above | above.T | (joint[:, None] == joint) & (joint >= 0)
    np.fill_diagonal(met, val=False)
    return met


def channels_beside(skeleton: Skeleton, columns: Ints) -> Bools:
    """(C, C) True for two angles about like axes of different joints that hang on one; as `channels_that_meet`."""
    joint = np.where((columns >= 0) & (skeleton.dof_kind[columns] == ROTATION), skeleton.dof_joint[columns], -1)
    parent = np.where(joint >= 0, skeleton.parents[joint], -1)
    axis = skeleton.dof_axis[columns]
    like = (axis @ axis.T) > LIKE_AXES
    beside: Bools = like & (parent[:, None] == parent) & (parent >= 0) & (joint[:, None] != joint)
    return beside
