"""B5: whether stated deviations hold

Of the errors on body angles, so many should lie within one and within 1.96 stated deviations: 68 and 95 %.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TypeVar

import numpy as np

from .beyond_common import ABOUT_PROBLEMS, CELLS, LEVELS, PROBLEMS, adaptive_tries, cell_name, in_parallel
from .beyond_gaps import ABOUT, AT_REST, KINDS, TRIED, coverage_in
from .common import Findings, Table

Key = TypeVar("Key")


def run(mocap: Path, pictures: Path) -> Findings:
    """Coverage by cell, by problem, and in gaps."""
    tries = adaptive_tries(mocap)
    by_cell = {
        (level, cell): _mean(t.within[level] for t in tries if t.cell == cell) for level in LEVELS for cell in CELLS
    }
    by_problem = {
        (level, name): _mean(t.within[level] for t in tries if t.problem == name)
        for level in LEVELS
        for name in PROBLEMS
    }
    cases = [(problem, kind) for problem in TRIED for kind in KINDS]
    measured = dict(zip(cases, in_parallel(partial(coverage_in, mocap), cases), strict=True))
    in_gaps, in_moving = (
        {
            (level, kind): _mean(found[level + which] for case, found in measured.items() if case[1] == kind)
            for level in LEVELS
            for kind in KINDS
        }
        for which in ("", " moving")
    )
    values = {}
    for level in LEVELS:
        for name, table in (("cells", by_cell), ("gaps", in_gaps), ("moving", in_moving)):
            shares = [100 * share for (one, _), share in table.items() if one == level]
            values |= {f"{name}_{level}_low": min(shares), f"{name}_{level}_high": max(shares)}
            values[f"{name}_{level}"] = float(np.mean(shares))
    return Findings(
        values=values,
        notes=(ABOUT_PROBLEMS, "Gaps: those of B6 in all clips of its problems, missing samples only."),
        tables=(
            _table("Errors within the interval, mean over clips, by noise and outliers", by_cell, CELLS, cell_name),
            _table("The same by problem, mean over cells", by_problem, tuple(PROBLEMS), str),
            _table("In gaps", in_gaps, KINDS, ABOUT.__getitem__),
            _table(
                f"In gaps of channels that stray by more than {AT_REST} degrees", in_moving, KINDS, ABOUT.__getitem__
            ),
        ),
    )


def _table(
    title: str, shares: Mapping[tuple[str, Key], float], keys: Sequence[Key], name: Callable[[Key], str]
) -> Table:
    rows = tuple((name(key), *(f"{100 * shares[level, key]:.1f} %" for level in LEVELS)) for key in keys)
    return Table(title, ("", *(f"{level} %" for level in LEVELS)), rows)


def _mean(shares: Iterable[float]) -> float:
    return float(np.mean(list(shares)))
