"""Figures as PNG: curves, stick figures, error against a condition, robust estimators.

Matplotlib is loaded when the first figure is drawn, without a window; the same arrays give the same bytes.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import Bools, Floats, runs
from ..errors import UsageError
from .stick import skeleton_figure
from .style import COLOURS, FAINT, GAP, check_lengths, colours_of, figure_at

__all__ = ["Panel", "curves_figure", "lines_figure", "robust_figure", "skeleton_figure"]

_DASHES: tuple[Any, ...] = ("-", (0, (4, 1.6)), (0, (1.2, 1.2)))
_LEGEND: dict[str, Any] = {
    "ncols": 10,
    "frameon": False,
    "handlelength": 1.1,
    "handletextpad": 0.5,
    "columnspacing": 1.3,
    "borderaxespad": 0.3,
    "labelcolor": FAINT,
}


@dataclass(frozen=True, eq=False)
class Panel:
    """One row of `curves_figure`.

    Attributes
    ----------
    title : the channel's name.
    unit : of all values, e.g. "°" or "m".
    series : (T,) values by name, NaN = missing; the first is drawn at the bottom.
    std : (T,) standard deviations of some of the series, by name.
    gaps : (T,) True where the recording had no sample.
    """

    title: str
    unit: str
    series: Mapping[str, Floats]
    std: Mapping[str, Floats] = field(default_factory=dict)
    gaps: Bools | None = None


def curves_figure(path: str | Path, times: Floats, panels: Sequence[Panel], *, title: str = "") -> None:
    """Draw channels over time, one below the other, with bands of one standard deviation and shaded gaps.

    Parameters
    ----------
    path : PNG to write.
    times : (T,) s.
    panels : the channels; a series keeps its colour through all of them.
    title : over the whole figure.

    Raises
    ------
    UsageError : without panels. MismatchError : when a series is not as long as `times`.
    """
    if not panels:
        raise UsageError("a figure of curves needs at least one panel, came none")
    colours = colours_of([name for panel in panels for name in panel.series])
    with figure_at(path, 7.2, 0.5 + 1.55 * len(panels), title) as figure:
        rows = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
        for axes, panel in zip(rows, panels, strict=True):
            check_lengths(len(times), panel.series)
            check_lengths(len(times), panel.std)
            if panel.gaps is not None:
                for first, stop in runs(panel.gaps):
                    axes.axvspan(times[first], times[stop - 1], color=GAP, alpha=0.13, lw=0)
            for name, values in panel.series.items():
                rough = name == "noisy"
                axes.plot(times, values, color=colours[name], lw=0.7 if rough else 1.4, alpha=0.75 if rough else 1)
                if name in panel.std:
                    band = values - panel.std[name], values + panel.std[name]
                    axes.fill_between(times, *band, color=colours[name], alpha=0.2, lw=0)
            axes.set_title(f"{panel.title}, {panel.unit}")
            axes.set_ylim(*_limits(list(panel.series.values())))
            axes.margins(x=0)
            axes.spines["left"].set_visible(False)
        rows[-1].set_xlabel("time, s")
        drawn = {name: colours[name] for panel in panels for name in panel.series}
        shaded = any(panel.gaps is not None and bool(panel.gaps.any()) for panel in panels)
        legend = rows[0].legend(handles=_handles(drawn, shaded), loc="lower right", bbox_to_anchor=(1, 1), **_LEGEND)
        legend.set_in_layout(False)  # it stands on the title's line


def lines_figure(
    path: str | Path,
    x: Floats,
    lines: Mapping[str, Floats],
    *,
    xlabel: str,
    ylabel: str,
    spread: Mapping[str, Floats] | None = None,
    leading: Sequence[str] = (),
    log: str = "",
    title: str = "",
) -> None:
    """Draw one line per method against a condition (error against noise), named at its end.

    Parameters
    ----------
    path : PNG to write.
    x : (X,) the condition.
    lines : (X,) values by method, NaN where there is none.
    spread : (X,) half width of a band about some of the lines, by method.
    leading : methods drawn thicker than the rest.
    log : "x", "y" or "xy" for logarithmic axes.

    Raises
    ------
    UsageError : without lines. MismatchError : when a line is not as long as `x`.
    """
    if not lines:
        raise UsageError("a figure of lines needs at least one line, came none")
    check_lengths(len(x), lines)
    check_lengths(len(x), spread or {})
    with figure_at(path, 5.6, 3.5, title) as figure:
        axes = figure.add_subplot()
        if "x" in log:
            axes.set_xscale("log")
        if "y" in log:
            axes.set_yscale("log")
        ends = []
        for i, (name, y) in enumerate(lines.items()):
            colour, dash = COLOURS[i % len(COLOURS)], _DASHES[i // len(COLOURS) % len(_DASHES)]
            thick = 2.2 if name in leading else 1.2
            axes.plot(x, y, color=colour, lw=thick, ls=dash, marker="o", ms=2.2 + thick, mew=0, clip_on=False)
            if spread and name in spread:
                axes.fill_between(x, y - spread[name], y + spread[name], color=colour, alpha=0.14, lw=0)
            there = np.flatnonzero(np.isfinite(y))
            if there.size:
                weight = "bold" if name in leading else "normal"
                ends.append((float(x[there[-1]]), float(y[there[-1]]), name, colour, weight))
        axes.set_xlabel(xlabel)
        axes.set_ylabel(ylabel)
        axes.spines["left"].set_visible(False)
        _name_ends(figure, axes, ends)


def robust_figure(
    path: str | Path, residuals: Floats, estimators: Mapping[str, tuple[Floats, Floats, Floats]], *, title: str = ""
) -> None:
    """Draw rho, influence and weight of robust estimators side by side.

    Parameters
    ----------
    path : PNG to write.
    residuals : (R,) in units of the scale.
    estimators : rho, influence and weight, each (R,), by name.

    Raises
    ------
    UsageError : without estimators. MismatchError : when a curve is not as long as `residuals`.
    """
    if not estimators:
        raise UsageError("a figure of estimators needs at least one, came none")
    with figure_at(path, 7.2, 2.7, title) as figure:
        row = figure.subplots(1, 3)
        for k, (axes, what) in enumerate(zip(row, ("rho", "influence", "weight"), strict=True)):
            curves = {name: three[k] for name, three in estimators.items()}
            check_lengths(len(residuals), curves)
            for i, values in enumerate(curves.values()):
                axes.plot(residuals, values, color=COLOURS[i % len(COLOURS)], lw=1.5)
            # The steepest curve may leave the picture, so that the bounded ones can be told apart.
            tops = sorted(float(np.nanmax(np.abs(v))) for v in curves.values())
            top = 1.12 * tops[-2 if len(tops) > 1 else -1]
            axes.set_ylim(-top if np.nanmin([np.nanmin(v) for v in curves.values()]) < 0 else 0.0, top)
            axes.set_title(what)
            axes.set_xlabel("residual / scale")
            axes.margins(x=0)
            axes.spines["left"].set_visible(False)
        named = {name: COLOURS[i % len(COLOURS)] for i, name in enumerate(estimators)}
        legend = figure.legend(
            handles=_handles(named), loc="upper right" if title else "outside upper right", **_LEGEND
        )
        legend.set_in_layout(not title)  # it stands on the title's line where there is one


def _limits(series: Sequence[Floats]) -> tuple[float, float]:
    """Bounds that hold nearly all values: an outlier may leave the picture, the curves fill it."""
    values = np.concatenate([v[np.isfinite(v)] for v in series])
    if not values.size:
        return -1.0, 1.0
    low, high = np.percentile(values, [0.5, 99.5])
    room = max(0.15 * (high - low), 1e-6)
    return float(low - room), float(high + room)


def _handles(colours: Mapping[str, str], gaps: bool = False) -> list[Any]:
    """A short line for each named curve and, where there are gaps, a patch of their shade."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    lines: list[Any] = [Line2D([], [], color=c, lw=1.8, label=name) for name, c in colours.items()]
    return [*lines, Patch(color=GAP, alpha=0.2, lw=0, label="missing")] if gaps else lines


def _name_ends(figure: Any, axes: Any, ends: Sequence[tuple[float, float, str, str, str]]) -> None:
    """Write each line's name to the right of the axes at the height of its end, pushed apart where they meet."""
    if not ends:
        return
    figure.draw_without_rendering()
    height = axes.get_window_extent().height
    heights = axes.transAxes.inverted().transform(axes.transData.transform([(x, y) for x, y, *_ in ends]))[:, 1]
    least = 12.5 / 72 * figure.dpi / height  # a line of text, as a share of the axes
    order = np.argsort(heights, kind="stable")
    spread = _apart(heights[order], least)
    for at, i in zip(spread, order, strict=True):
        _, _, name, colour, weight = ends[i]
        axes.annotate(
            name,
            (1.0, at),
            (9, 0),
            xycoords="axes fraction",
            textcoords="offset points",
            va="center",
            color=colour,
            weight=weight,
        )


def _apart(heights: Floats, least: float) -> Floats:
    """Rising heights moved as little as needed to stand `least` apart: pools of neighbours about their mean."""
    pools: list[list[float]] = []
    for height in heights:
        pools.append([float(height)])
        while len(pools) > 1 and _low(pools[-1], least) < _low(pools[-2], least) + least * len(pools[-2]):
            last = pools.pop()
            pools[-1] += last
    return np.array([_low(pool, least) + least * i for pool in pools for i in range(len(pool))])


def _low(pool: Sequence[float], least: float) -> float:
    """Where the lowest of a pool goes when the pool is spread about its mean."""
    return sum(pool) / len(pool) - least * (len(pool) - 1) / 2
