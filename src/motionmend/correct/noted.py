"""What was noted about a recording's frames while correcting them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Bytes, frozen
from .watching import Sight

REFUSED, SWAPPED = 1, 2
FOREIGN = 0.5  # probability of being the sensor that was learned from below which it is said that it is another


@dataclass(frozen=True, eq=False)
class Noted:
    """The recording's own source, and flags (T,) of its frames: bits named by `flag_names`, the first one lowest.

    refused : sides may have been confused, too unsurely to change anything.
    swapped : sides were confused and changed back.
    warnings : one sentence each.
    """

    source: Any
    flags: Bytes
    flag_names: tuple[str, ...] = ("refused", "swapped")
    warnings: tuple[str, ...] = ()


def noted(source: Any, sights: Sequence[Sight], kin: float) -> Noted:
    """What the sights of a recording's frames say of them.

    Parameters
    ----------
    kin : probability that the sensor is the one that was learned from.
    """
    flags = [REFUSED * one.refused + SWAPPED * bool(one.swapped.any()) for one in sights]
    foreign = (
        f"bones are not as in the recordings that were learned from: another sensor? {100 * kin:.0f} % of the learned "
        "offsets were applied"
    )
    return Noted(
        source, frozen(np.array(flags, dtype=np.uint8), np.uint8), warnings=(foreign,) if kin < FOREIGN else ()
    )
