"""What a skeleton file does not say, supposed from its rest pose: the unit of length and the way up."""

from collections.abc import Iterable, Sequence

import numpy as np

from ..arrays import Floats

SHORTEST, TALLEST = 1.2, 2.3  # m; a rest pose outside is not taken for a person
HEADS = ("head", "neck")
FEET = ("foot", "toe", "ankle", "feet")
LEGS = (*FEET, "heel", "leg", "knee", "thigh", "shin", "calf", "femur", "tibia")
UPPER = (*HEADS, "shoulder", "arm", "elbow", "wrist", "hand", "clav", "collar", "humerus", "chest", "spine", "thorax")


def length_unit(height: float, candidates: Iterable[tuple[float, str]], otherwise: float) -> tuple[float, str]:
    """Metres per unit of length: the first candidate that makes a person of the rest pose.

    Parameters
    ----------
    height : of the rest pose in the file's unit.
    candidates : (metres per unit, its name), the likeliest first.
    otherwise : metres per unit when no candidate fits.

    Returns
    -------
    metres : per unit.
    guess : what was taken and why, for `Motion.guesses`.
    """
    for metres, name in candidates:
        if SHORTEST <= height * metres <= TALLEST:
            return metres, (
                f"took 1 unit of length = {metres:.6g} m ({name}), "
                f"which makes the rest pose {height * metres:.2f} m tall"
            )
    return otherwise, (
        f"took 1 unit of length = {otherwise:.6g} m, which makes the rest pose {height * otherwise:.3g} m tall; "
        "no likely unit makes it a person's height, lengths may be wrong"
    )


def is_half(names: Sequence[str]) -> bool:
    """Whether joints of these names are a part of a person: legs alone, or arms and trunk without any legs."""
    lower = [name.lower() for name in names]
    return bool(_having(lower, LEGS)) != bool(_having(lower, UPPER))


def up_axis(names: Sequence[str], rest: Floats) -> tuple[Floats, str]:
    """The axis of the file that points from the feet to the head in the rest pose.

    Parameters
    ----------
    names : (J,) joint names.
    rest : (J, 3) positions in any unit.

    Returns
    -------
    up : (3,) unit vector along an axis.
    guess : the sentence for `Motion.guesses`.
    """
    up = np.array([0.0, 1.0, 0.0])
    lower = [name.lower() for name in names]
    top = next((found for word in HEADS if (found := _having(lower, (word,)))), [])
    bottom = _having(lower, FEET)
    if not top or not bottom:
        return up, "no up axis in the file and no head or feet by name: took +y"
    rise = rest[top].mean(axis=0) - rest[bottom].mean(axis=0)
    axis = int(np.argmax(np.abs(rise)))
    if abs(rise[axis]) < 1e-9:
        return up, "no up axis in the file and head and feet lie together at rest: took +y"
    sign = float(np.sign(rise[axis]))
    up = sign * np.eye(3)[axis]
    letter = f"{'+' if sign > 0 else '-'}{'xyz'[axis]}"
    return up, f"no up axis in the file: took {letter}, along which the head is above the feet at rest"


def _having(names: Sequence[str], words: tuple[str, ...]) -> list[int]:
    return [j for j, name in enumerate(names) if any(word in name for word in words)]
