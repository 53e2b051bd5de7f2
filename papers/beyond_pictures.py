"""A heat map with a number in every field."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from motionmend.arrays import Floats
from motionmend.report.style import INK, figure_at

EVEN = 1.0  # the value that stays white
FAR = 1.3  # and its inverse: the strongest colours


def heat_figure(path: Path, values: Floats, *, rows: Sequence[str], columns: Sequence[str], label: str) -> None:
    """Ratios as colours, blue below 1 and red above.

    Parameters
    ----------
    values : (R, C) above 0.
    rows, columns : their names.
    label : of the colours.
    """
    with figure_at(path, 8.6, 0.32 * len(rows) + 1.1, "") as figure:
        axes = figure.add_subplot()
        shown = np.log(values / EVEN)
        picture = axes.imshow(shown, cmap="RdBu_r", vmin=-np.log(FAR), vmax=np.log(FAR), aspect="auto")
        for (row, column), value in np.ndenumerate(values):
            strong = abs(shown[row, column]) > 0.7 * np.log(FAR)
            axes.text(
                column, row, f"{value:.2f}", ha="center", va="center", fontsize=7, color="white" if strong else INK
            )
        axes.set_xticks(range(len(columns)), columns, fontsize=7, rotation=30, ha="right")
        axes.set_yticks(range(len(rows)), rows, fontsize=7)
        axes.grid(visible=False)
        bar = figure.colorbar(picture, ax=axes, ticks=np.log([1 / FAR, 1.0, FAR]), shrink=0.9)
        bar.ax.set_yticklabels([f"{1 / FAR:.2f}", "1", f"{FAR:g}"], fontsize=7)
        bar.set_label(label, fontsize=8)
