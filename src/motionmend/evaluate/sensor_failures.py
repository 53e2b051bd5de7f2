"""Let a depth sensor fail on purpose, in the ways sensors do, and say where.

A limb that the sensor does not see is guessed: drawn toward the trunk and shaking, marked as inferred where the
recording has states. Limbs of the two sides are taken for each other. Both last from a third of a second to a few
seconds.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Bools, Floats, Ints, frozen
from ..bodies.joint_sets import meanings, mirrored
from ..bodies.postures import INFERRED, TRACKED, Postures
from ..errors import UsageError

LIMBS = {
    "arm": ("elbow", "wrist", "hand", "hand_tip", "thumb"),
    "hand": ("wrist", "hand", "hand_tip", "thumb"),
    "leg": ("knee", "ankle", "heel", "foot", "toe_tip"),
    "foot": ("ankle", "heel", "foot", "toe_tip"),
}
TRUNK = ("pelvis", "spine", "chest", "neck_base")


@dataclass(frozen=True, eq=False)
class Failed:
    """A recording with failures.

    Attributes
    ----------
    postures : as the sensor would have given it.
    affected : (T, J) True where a joint is not where the sensor had it.
    swapped : (T, J) True where that is because sides were confused.
    """

    postures: Postures
    affected: Bools
    swapped: Bools

    def __post_init__(self) -> None:
        for name in ("affected", "swapped"):
            object.__setattr__(self, name, frozen(getattr(self, name), np.bool_))


def fail(
    postures: Postures,
    *,
    share: float = 0.25,
    seconds: tuple[float, float] = (0.3, 3.0),
    jitter: tuple[float, float] = (0.03, 0.08),
    pull: tuple[float, float] = (0.5, 1.0),
    swaps: float = 0.25,
    states: bool = True,
    seed: int = 0,
) -> Failed:
    """Make a sensor fail.

    Parameters
    ----------
    postures : T frames of joints with limbs on both sides.
    share : of the frames that each fail in some limb, about.
    seconds : least and most that a failure lasts.
    jitter : m, least and most standard deviation of a guessed joint's shaking, one per failure.
    pull : least and most share of the way to the trunk that a guessed joint is drawn, one per failure.
    swaps : share of the failures that confuse sides instead.
    states : say which joints are guessed (inferred); False leaves the recording without states.
    seed : of everything.

    Raises
    ------
    UsageError : a share out of [0, 1], or joints among which no limb is known.
    """
    if not 0 <= share <= 1 or not 0 <= swaps <= 1:
        raise UsageError(f"shares lie in [0, 1], came share={share} and swaps={swaps}")
    rng = np.random.default_rng(seed)
    limbs = _limbs(postures.names)
    if not limbs:
        raise UsageError(f"no arm or leg is known among the joints {', '.join(postures.names[:6])}, ...")
    positions = np.array(postures.positions)
    told = np.full(positions.shape[:2], TRACKED, dtype=np.uint8) if postures.state is None else postures.state.copy()
    affected = np.zeros(positions.shape[:2], dtype=np.bool_)
    swapped = np.zeros(positions.shape[:2], dtype=np.bool_)
    other = mirrored(postures.names)
    trunk = _trunk(postures)
    fps = postures.fps if np.isfinite(postures.fps) else 30.0
    busy = np.zeros(postures.frames, dtype=np.bool_)
    for _ in range(20 * postures.frames):
        if busy.mean() >= share or not postures.frames:
            break
        length = max(int(rng.uniform(*seconds) * fps), 2)
        first = int(rng.integers(-length // 2, max(postures.frames - length // 2, 1)))
        spell = slice(max(first, 0), min(first + length, postures.frames))
        limb = limbs[int(rng.integers(len(limbs)))]
        both = np.concatenate([limb, other[limb]])
        if spell.stop <= spell.start or affected[spell][:, both].any():
            continue
        if rng.random() < swaps and (other[limb] != limb).all():
            positions[spell, both] = postures.positions[spell][:, other[both]]
            affected[spell, both] = swapped[spell, both] = True
        else:
            way, shaking = rng.uniform(*pull), rng.uniform(*jitter)
            here = positions[spell][:, limb]
            noise = shaking * rng.standard_normal(here.shape)
            positions[spell, limb] = here + way * (trunk[spell, None] - here) + noise
            affected[spell, limb] = True
            told[spell, limb] = INFERRED
        busy[spell] = True
    spoilt = replace(postures, positions=positions, state=told if states else None)
    return Failed(spoilt, affected, swapped)


def _limbs(names: tuple[str, ...]) -> list[Ints]:
    place = {meaning: k for k, meaning in enumerate(meanings(names)) if meaning}
    found = []
    for side in ("l", "r"):
        for parts in LIMBS.values():
            joints = [place[f"{side}_{part}"] for part in parts if f"{side}_{part}" in place]
            if joints:
                found.append(np.array(joints, dtype=np.int64))
    return found


def _trunk(postures: Postures) -> Floats:
    """(T, 3) the middle of the trunk."""
    meant = meanings(postures.names)
    joints = [k for k, meaning in enumerate(meant) if meaning in TRUNK] or list(range(len(meant)))
    with np.errstate(invalid="ignore"):
        return np.asarray(np.nanmean(postures.positions[:, joints], axis=1))
