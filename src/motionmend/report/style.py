"""What all figures share: colours, a plain style, and a file written whole."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import Floats
from ..errors import MismatchError
from ..io.atomic import atomic

INK, FAINT, LINE, GHOST, GAP = "#16191d", "#5b636d", "#dde1e6", "#9aa2ab", "#7b5cc9"
COLOURS = ("#0072b2", "#d55e00", "#00845f", "#b5608f", "#86690a", "#5d6670")
KNOWN = {"repaired": COLOURS[0], "noisy": COLOURS[1], "truth": COLOURS[2]}  # as in the page of html_report
STYLE = {
    "font.size": 9,
    "text.color": INK,
    "axes.labelcolor": FAINT,
    "axes.edgecolor": "#aeb5bd",
    "axes.linewidth": 0.7,
    "axes.titlesize": 9.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": LINE,
    "grid.linewidth": 0.7,
    "xtick.color": FAINT,
    "ytick.color": FAINT,
    "xtick.major.width": 0.7,
    "ytick.major.width": 0.0,
    "lines.solid_capstyle": "round",
    "savefig.dpi": 160,
}


@contextmanager
def figure_at(path: str | Path, wide: float, tall: float, title: str) -> Iterator[Any]:
    """A matplotlib Figure, `wide` by `tall` inches, written as PNG when the block ends.

    The user's own matplotlib settings do not reach it, and the file holds no date and no version.
    """
    from matplotlib import style
    from matplotlib.figure import Figure

    with style.context(["default", STYLE]):
        figure = Figure(figsize=(wide, tall), layout="constrained")
        if title:
            figure.suptitle(title, x=0.012, ha="left", weight="bold", fontsize=11)
        yield figure
        with atomic(path) as temporary:
            figure.savefig(temporary, format="png", metadata={"Software": None})


def colours_of(names: Sequence[str]) -> dict[str, str]:
    """A colour for each name: the known ones as in the page, the rest in order."""
    left = [c for c in COLOURS if c not in {KNOWN.get(name) for name in names}]
    colours: dict[str, str] = {}
    for name in names:
        if name not in colours:
            colours[name] = KNOWN.get(name) or left[sum(n not in KNOWN for n in colours) % len(left)]
    return colours


def check_lengths(wanted: int, series: Mapping[str, Floats]) -> None:
    """Raise MismatchError naming the first curve that does not have `wanted` values."""
    for name, values in series.items():
        if np.shape(values) != (wanted,):
            raise MismatchError(f"{name}: a curve here has {wanted} values, came {np.shape(values)}")
