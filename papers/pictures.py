"""Pictures that only this report needs: a grid of small ones, and bones between markers."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from motionmend.arrays import Floats, Ints
from motionmend.bodies.skeleton import Skeleton
from motionmend.report.style import COLOURS, figure_at

Curves = Mapping[str, tuple[Floats, Mapping[str, Floats]]]  # by title: x (N,) and the curves (N,) over it


def grid_figure(path: Path, rows: Mapping[str, Curves], *, ylabel: str, leading: str) -> None:
    """Many small pictures of the same curves, one row for each label of the horizontal axis.

    Parameters
    ----------
    rows : pictures by label of their horizontal axis; what follows ` | ` in a label tells rows apart and is not drawn.
    ylabel : of all.
    leading : the curve drawn thicker than the rest.
    """
    columns = max(len(row) for row in rows.values())
    with figure_at(path, 8.6, 1.75 * len(rows) + 0.4, "") as figure:
        axes = figure.subplots(len(rows), columns, squeeze=False)
        for line, (label, row) in zip(axes, rows.items(), strict=True):
            for one, (title, (x, curves)) in zip(line, row.items(), strict=True):
                for colour, (name, y) in zip(COLOURS, curves.items(), strict=False):
                    one.plot(x, y, color=colour, lw=2.0 if name == leading else 1.2, marker="o", ms=2.5, label=name)
                one.set_title(title, fontsize=8)
                one.set_xlabel(label.partition(" | ")[0], fontsize=8)
                one.set_ylim(bottom=0)
                one.tick_params(labelsize=7)
            line[0].set_ylabel(ylabel, fontsize=8)
        handles, names = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles, names, loc="outside upper center", ncols=len(names), frameon=False)


def shrink(path: Path) -> None:
    """Rewrite a PNG with a palette of 64 colours: these pictures need no more, and take a third of the room."""
    from PIL import Image

    with Image.open(path) as image:
        small = image.convert("RGB").quantize(64)
    small.save(path, optimize=True)


def parents_within(skeleton: Skeleton, names: Sequence[str]) -> Ints:
    """(N,) for each of some joints the nearest joint above it that is also among them, -1 for none."""
    parents = []
    for name in names:
        above = int(skeleton.parents[skeleton.names.index(name)])
        while above >= 0 and skeleton.names[above] not in names:
            above = int(skeleton.parents[above])
        parents.append(names.index(skeleton.names[above]) if above >= 0 else -1)
    return np.array(parents, dtype=np.int64)


def parents_along(edges: Ints, count: int) -> Ints:
    """(count,) the points of a graph (E, 2) as trees: each point's neighbour on the way to its tree's first point."""
    parents = np.full(count, -1, dtype=np.int64)
    reached = np.zeros(count, dtype=bool)
    for start in range(count):
        ahead = [] if reached[start] else [start]
        reached[start] = True
        while ahead:
            here = ahead.pop(0)
            for one in edges[(edges == here).any(axis=1)]:
                other = int(one.sum()) - here
                if not reached[other]:
                    reached[other], parents[other] = True, here
                    ahead.append(other)
    return parents
