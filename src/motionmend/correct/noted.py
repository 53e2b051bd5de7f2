"""What was noted about a recording's frames while correcting them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Bools, Bytes, Floats, frozen
from ..bodies.joint_sets import mirrored
from ..bodies.postures import Postures
from ..errors import counted
from .joining import Joining
from .level import tilted
from .sight import Sight
from .still import LONGEST

REFUSED, SWAPPED = 1, 2
FOREIGN = 0.5  # probability of being the sensor that was learned from below which it is said that it is another
MOSTLY = 0.5  # of the frames; sides that are confused for longer are said to be


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


def noted(
    joining: Joining, postures: Postures, corrected: Floats, sights: Sequence[Sight], kin: float, again: Bools
) -> Noted:
    """What a recording and the sights of its frames say of it.

    Parameters
    ----------
    joining : of the recording's joints and the model's.
    postures, corrected : as the sensor gave it, and (T, J, 3) m what came of it.
    kin : probability that the sensor is the one that was learned from.
    again : (T,) frames in which the sensor goes on to say an earlier posture, of `repeated`.
    """
    flags = [REFUSED * one.refused + SWAPPED * bool(one.swapped.any()) for one in sights]
    foreign = (
        f"bones are not as in the recordings that were learned from: another sensor? {100 * kin:.0f} % of the learned "
        "offsets were applied"
    )
    displaced = (
        f"{', '.join(joining.displaced)}: elsewhere along the spine than in the recordings that were learned from, as "
        f"another sensor has them: {100 * kin:.0f} % of the learned offsets were applied"
    )
    pictured = (
        "joints are those of what estimates poses in pictures, not of the sensor that was learned from: "
        f"{100 * kin:.0f} % of the learned offsets were applied, and what they do there is not known"
    )
    speaks = (bool(joining.displaced), displaced), (kin < FOREIGN, foreign), (joining.other_kind, pictured)
    warnings = (
        *_tilted(sights),
        *[said for against, said in speaks if against][:1],
        *_untold(postures),
        *_repeated(again),
        *_exchanged(joining, sights),
        *_never_seen(postures, corrected),
    )
    return Noted(postures.source, frozen(np.array(flags, dtype=np.uint8), np.uint8), warnings=warnings)


def _tilted(sights: Sequence[Sight]) -> tuple[str, ...]:
    """A sentence about a sensor that looks up, down or aside."""
    turn = sights[-1].upright
    by = 0.0 if turn is None else tilted(turn)
    said = "who stands here leans by {:.0f}° in the sensor's axes: it is tilted, and levelled while correcting"
    return (said.format(by),) if by > 1.0 else ()


def _untold(postures: Postures) -> tuple[str, ...]:
    """A sentence about states that say of no joint, in any frame, that it was tracked or inferred."""
    if postures.state is None or postures.state.any() or not postures.present.any():
        return ()
    return ("every joint is said not to be tracked, in all frames: states were not used",)


def _repeated(again: Bools) -> tuple[str, ...]:
    """A sentence about frames in which the whole body stands still to the last digit."""
    if not again.any():
        return ()
    return (
        f"in {counted(int(again.sum()), 'frame')} the sensor says the posture before again, all joints to the last "
        f"digit and for more than {LONGEST} s: nobody was measured there, and where they are then is not known",
    )


def _exchanged(joining: Joining, sights: Sequence[Sight]) -> tuple[str, ...]:
    """A sentence about joints whose sides were changed back in more than half of the frames that show somebody."""
    changed = np.stack([one.swapped for one in sights if np.isfinite(one.rows).any()] or [sights[0].swapped])
    often = changed.mean(axis=0) > MOSTLY
    names = [joining.names[joining.to_model[k]] for k in np.flatnonzero(often & (joining.to_model >= 0))]
    if not names:
        return ()
    sided = mirrored(joining.names)[joining.to_model[joining.common]] != joining.to_model[joining.common]
    whose = ", ".join(names) if len(names) < sided.sum() else "the whole body"
    frames = int(changed[:, often].any(axis=1).sum())
    return (
        f"left and right of {whose} were changed back in {frames} of {counted(len(changed), 'frame')}: "
        "is the recording mirrored, or do its names mean the other side?",
    )


def _never_seen(postures: Postures, corrected: Floats) -> tuple[str, ...]:
    """A sentence about joints that were filled in every frame."""
    never = np.asarray(~postures.present.any(axis=0) & np.isfinite(corrected).all(axis=2).any(axis=0))
    if not never.any():
        return ()
    names = ", ".join(name for name, one in zip(postures.names, never, strict=True) if one)
    said = "in no frame: put where the learned people have them, who may sit, stand or hold them otherwise"
    return (f"{names} {'are' if never.sum() > 1 else 'is'} {said}",)
