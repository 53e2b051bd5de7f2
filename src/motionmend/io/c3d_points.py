"""Which points of a C3D file are markers, and which are computed or without a label.

A C3D file keeps everything with three coordinates in one list: markers, unidentified reflections, and what a model
computed from the markers (joint centres, segment axes, angles, forces). A point is taken as computed when any of
these holds:

1. POINT:ANGLES, FORCES, MOMENTS, POWERS, SCALARS, REACTIONS, or a parameter that POINT:TYPE_GROUPS names, lists it;
2. its label has the form of a model's output: `...Angles`, `...Moment`, `...JC` (joint centre), `CentreOfMass...`,
   or four labels differ in a last letter O, A, L, P (origin and axes of a segment);
3. the file records which cameras saw a point or how well (camera masks, residuals above zero), and this point,
   although it has positions, was never seen in any frame and stands after the last point that was. Model outputs
   are appended to the list of points, and a point no camera ever saw is no marker.

A point that an earlier repair of ours filled is a marker whatever rule 3 says.
"""

import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Bools
from .c3d_layout import Layout

_LISTS = ("ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS", "REACTIONS")
_UNLABELLED = re.compile(r"\*|$|(uname|unnamed|unlabel|unidentified)", re.IGNORECASE)
_OUTPUT = re.compile(r"\w(Angles?|Forces?|Moments?|Powers?)$|^[A-Z]*JC$|^Cent(re|er)OfMass")
_AXES = "OALP"


@dataclass(frozen=True)
class Sorted:
    """Places in the file's list of points, and what there is to say about them."""

    markers: tuple[int, ...]
    computed: tuple[int, ...]
    unlabelled: tuple[int, ...]
    guesses: tuple[str, ...]


def sort_points(
    layout: Layout, labels: Sequence[str], present: Bools, seen: Bools, ours: Collection[int] = ()
) -> Sorted:
    """Tell markers from computed and unlabelled points.

    Parameters
    ----------
    layout : of the file, for its parameters.
    labels : (P,) one for each point, "" where the file gives none.
    present : (P,) whether the point has a position in any frame.
    seen : (P,) whether any frame states a camera or a residual above zero.
    ours : places of points that an earlier repair filled.

    Returns
    -------
    sorted : places in ascending order; every point is in one of the three.
    """
    bare = [_bare(label) for label in labels]
    unlabelled = {k for k, label in enumerate(bare) if _UNLABELLED.match(label)}
    listed = _listed(layout)
    stated = {k for k, label in enumerate(labels) if k not in unlabelled and (label in listed or bare[k] in listed)}
    stated |= {k for k, label in enumerate(bare) if _OUTPUT.search(label)} | _axes(bare)
    last_seen = int(np.flatnonzero(seen)[-1]) if seen.any() else len(labels)
    unseen = {
        k for k in range(last_seen + 1, len(labels)) if present[k] and k not in ours and k not in stated | unlabelled
    }
    computed = (stated | unseen) - unlabelled
    guesses = []
    if stated - unlabelled:
        guesses.append(_sentence(stated - unlabelled, labels, "computed by a model, say the file's lists and labels"))
    if unseen:
        guesses.append(_sentence(unseen, labels, "computed by a model: no camera saw them in any frame"))
    if unlabelled:
        guesses.append(_sentence(unlabelled, labels, "without a label"))
    return Sorted(
        markers=tuple(k for k in range(len(labels)) if k not in computed | unlabelled),
        computed=tuple(sorted(computed)),
        unlabelled=tuple(sorted(unlabelled)),
        guesses=tuple(guesses),
    )


def _bare(label: str) -> str:
    """The label without its subject."""
    return label.rsplit(":", 1)[-1].strip()


def _listed(layout: Layout) -> set[str]:
    groups = {*_LISTS, *(row.upper() for row in layout.texts("POINT", "TYPE_GROUPS"))} - {"", "LABELS", "DESCRIPTIONS"}
    return {label for group in groups for label in layout.texts("POINT", group)} - {""}


def _axes(bare: Sequence[str]) -> set[int]:
    known = set(bare)
    return {
        k
        for k, label in enumerate(bare)
        if len(label) > 2 and label[-1] in _AXES and all(label[:-1] + axis in known for axis in _AXES)
    }


def _sentence(places: Collection[int], labels: Sequence[str], why: str) -> str:
    first = ", ".join(labels[k] or "''" for k in sorted(places)[:3])
    more = ", ..." if len(places) > 3 else ""
    return f"{len(places)} of {len(labels)} points set aside as {why} ({first}{more}); a .c3d keeps them as they are"
