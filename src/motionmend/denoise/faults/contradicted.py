"""What markers say that those about them contradict, in places that make it doubtful: beside gaps, and on lines."""

from dataclasses import dataclass

import numpy as np

from ...arrays import Bools
from ...bodies.motion import Markers, Motion, Origin, Repaired
from .drawn_lines import drawn_lines
from .held import named
from .strayed import strayed


@dataclass(frozen=True, eq=False)
class Contradicted:
    """(T, C) samples of markers that strayed beside a gap, and that lie on lines somebody filled a gap with."""

    beside: Bools
    drawn: Bools

    def said(self, recording: Motion | Markers) -> tuple[str, ...]:
        """A sentence for each kind that there is, with the markers of the recording."""
        of_kinds = (
            (self.beside, "stray beside a gap from where the markers about them have them"),
            (
                self.drawn,
                "lie on straight lines, as programs fill gaps, and not where the markers about them have them",
            ),
        )
        return tuple(
            f"{int(some.sum())} samples {what}, and were taken as missing: {named(recording, some)}"
            for some, what in of_kinds
            if some.any()
        )


def contradicted(recording: Motion | Markers, outcome: Repaired[Motion] | Repaired[Markers]) -> Contradicted:
    """Samples that are not where a first repair of the recording has their neighbours have them; none of angles.

    Parameters
    ----------
    recording : T frames, as recorded. outcome : of its first repair.
    """
    nothing = np.zeros(recording.present.shape, dtype=np.bool_)
    if not isinstance(recording, Markers) or not isinstance(outcome.recording, Markers):
        return Contradicted(nothing, nothing)
    believed = (outcome.origin == Origin.MEASURED)[..., None]
    places, std = np.where(believed, outcome.recording.positions, np.nan), outcome.std.astype(np.float64)
    beside = strayed(places, std, ~recording.present, recording.fps)
    return Contradicted(beside, drawn_lines(recording, places, std))
