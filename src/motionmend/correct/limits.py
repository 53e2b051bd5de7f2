"""How far joints bend: learned from the truth, kept in what is put out.

The energy of section 4.5 knows no limits: a limb that the sensor does not see may come out bent as no limb bends. The
angle between the two bones at a joint is therefore held within what all truth that was learned from shows, and a margin
for people who bend farther. A sensor that is believed entirely may say otherwise.
"""

from dataclasses import dataclass

import numpy as np

from ..arrays import Bools, Floats, Ints
from ..kernels import hinges as kernel
from .anatomy import Anatomy, following

MARGIN = np.deg2rad(10.0)  # beyond the truth, of people who bend farther than those who taught
BELIEVED = 0.5  # reliability up to which a sensor changes no limit; at 1 it knows none


@dataclass(frozen=True, eq=False)
class Hinges:
    """The joints of a recording that have limits.

    Attributes
    ----------
    joints : (H, 3) upper end, the joint, lower end; from the root outward.
    limits : (H, 2) rad, least and most angle between the two bones.
    below : (H, J) the lower end and what hangs on it.
    """

    joints: Ints
    limits: Floats
    below: Bools

    def kept(self, positions: Floats, trust: Floats) -> Floats:
        """Positions (T, J, 3) bent back where they are beyond the limits and not trusted, trust (T, J)."""
        if not len(self.joints):
            return positions
        bent = kernel.bend_back(positions, trust, self.joints, self.limits, self.below, BELIEVED)
        return np.asarray(bent)


def bends(positions: Floats, joints: Ints) -> Floats:
    """(T, H) rad, the angles at the middle ones of joints (H, 3) in postures (T, J, 3); NaN where one is missing."""
    upper = positions[:, joints[:, 0]] - positions[:, joints[:, 1]]
    lower = positions[:, joints[:, 2]] - positions[:, joints[:, 1]]
    size = np.sqrt((upper**2).sum(axis=2) * (lower**2).sum(axis=2))
    cosine = (upper * lower).sum(axis=2) / np.where(size > 1e-12, size, np.nan)
    return np.asarray(np.arccos(np.clip(cosine, -1.0, 1.0)))


def learned_limits(samples: Floats, offsets: Floats, paired: Bools, body: Anatomy) -> Floats:
    """(J, 2) rad, least and most angle at each joint's parent, between the bones to the joint and to the grandparent.

    NaN where there is no grandparent, or too little truth.

    Parameters
    ----------
    samples : (N, J, 3) what the sensor said where it went well, in standard form.
    offsets : (N, J, 3) truth less that, NaN where it is not known.
    paired : (J,) joints of which truth is known; the others go where their neighbours go.
    body : the joint set.
    """
    limits = np.full((len(body.names), 2), np.nan)
    chains = _chains(body.parents)
    shown = np.asarray(np.isfinite(offsets[:, paired]).all(axis=(1, 2)))
    if not paired.any() or not shown.any() or not len(chains):
        return limits
    moved = samples[shown] + following(body.names, paired) @ np.where(paired[:, None], offsets[shown], 0.0)
    angles = bends(moved, chains)
    limits[chains[:, 2]] = np.stack([angles.min(axis=0) - MARGIN, angles.max(axis=0) + MARGIN], axis=1)
    return np.asarray(np.clip(limits, 0.0, np.pi))


def hinges_of(limits: Floats, body: Anatomy, to_model: Ints, bones: Ints, count: int) -> Hinges:
    """The limits of the model's joints, for a recording.

    Parameters
    ----------
    limits : (J of model, 2) of `learned_limits`.
    body : of the model.
    to_model : (J of model,) the recording's joint of each, -1 = none.
    bones : (B, 2) of the recording, from the root outward.
    count : J, joints of the recording.
    """
    chains = _chains(body.parents)
    chains = chains[np.isfinite(limits[chains[:, 2]]).all(axis=1)]
    above = np.full(count, -1)
    above[bones[:, 1]] = bones[:, 0]
    place = {int(child): b for b, (_, child) in enumerate(bones)}
    found: list[tuple[int, Ints, Floats]] = []
    for chain in chains:
        upper, joint, lower = to_model[chain]
        if min(upper, joint, lower) >= 0 and above[lower] == joint and above[joint] == upper:
            found.append((place[int(lower)], np.array([upper, joint, lower]), limits[chain[2]]))
    found.sort(key=lambda one: one[0])
    below = np.zeros((len(found), count), dtype=np.bool_)
    for h, (_, chain, _) in enumerate(found):
        below[h, chain[2]] = True
        for parent, child in bones:
            below[h, child] |= below[h, parent]
    return Hinges(
        np.array([chain for _, chain, _ in found], dtype=np.int64).reshape(-1, 3),
        np.array([limit for _, _, limit in found], dtype=np.float64).reshape(-1, 2),
        below,
    )


def _chains(parents: Ints) -> Ints:
    """(H, 3) grandparent, parent and joint."""
    found = [(int(parents[p]), int(p), k) for k, p in enumerate(parents) if p >= 0 and parents[p] >= 0]
    return np.array(found, dtype=np.int64).reshape(-1, 3)
