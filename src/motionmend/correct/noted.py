"""What was noted about a recording's frames while correcting them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Bytes, frozen
from .watching import Sight

REFUSED, SWAPPED = 1, 2


@dataclass(frozen=True, eq=False)
class Noted:
    """The recording's own source, and flags (T,) of its frames: bits named by `flag_names`, the first one lowest.

    refused : sides may have been confused, too unsurely to change anything.
    swapped : sides were confused and changed back.
    """

    source: Any
    flags: Bytes
    flag_names: tuple[str, ...] = ("refused", "swapped")


def noted(source: Any, sights: Sequence[Sight]) -> Noted:
    """What the sights of a recording's frames say of them."""
    flags = [REFUSED * one.refused + SWAPPED * bool(one.swapped.any()) for one in sights]
    return Noted(source, frozen(np.array(flags, dtype=np.uint8), np.uint8))
