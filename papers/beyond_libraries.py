"""B3, B4: small, large and mixed libraries, and wrong ones

Section 2.3.3 finds that large and mixed databases are worse than small ones and that a wrong one spoils the result. The
adaptive method is to lose nothing by either.
"""

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np

import motionmend as mm

from .beyond_common import Cell, cell_name, in_parallel, spoilt, truth_of
from .common import SPLITS, Findings, Table, body_error, model_of
from .sec_2_3_3_priors import ABOUT, databases

RIGHT = ("small", "large", "mixed", "strangers")
CELLS: tuple[Cell, ...] = ((1.0, 0.0), (3.0, 0.0), (3.0, 0.1))
FILTERS = ("kalman", "gaussian", "savgol", "butterworth")
ALONE = "adaptive, no library"
WITHOUT = (ALONE, *FILTERS)  # methods that use no library
WRONG = {  # library, clips tried
    "jumps by walks": (SPLITS["walking"].learn, SPLITS["jumping"].test),
    "dance by walks": (SPLITS["walking"].learn, SPLITS["dance"].test),
    "walks by dance": (SPLITS["dance"].learn, SPLITS["walking"].test),
    "walks by runs": (databases()["running"], SPLITS["walking"].test),
}
OWN = {  # the right library for the same clips
    "jumps by walks": SPLITS["jumping"].learn,
    "dance by walks": SPLITS["dance"].learn,
    "walks by dance": SPLITS["walking"].learn,
    "walks by runs": SPLITS["walking"].learn,
}
DOUBT = "the library misses this recording"  # in the words of the warning


def run(mocap: Path, pictures: Path) -> Findings:
    """Errors of the adaptive method by library."""
    jobs = [(databases()[name], SPLITS["walking"].test) for name in RIGHT]
    jobs += [job for name, (library, clips) in WRONG.items() for job in ((library, clips), (OWN[name], clips))]
    measured = in_parallel(partial(tried, mocap), jobs)
    right, wrong = measured[: len(RIGHT)], measured[len(RIGHT) :]
    values = _right_values(right)
    rows = tuple(
        (ABOUT[name], *(f"{errors['adaptive', cell]:.2f}" for cell in CELLS), f"{100 * doubted:.0f} %")
        for name, (errors, doubted) in zip(RIGHT, right, strict=True)
    )
    tables = [Table("Noisy walks by library, degrees", ("library", *map(cell_name, CELLS), "warned"), rows)]
    ratios, doubts, own_doubts, lines = [], [], [], []
    for name, (errors, doubted), (own, own_doubted) in zip(WRONG, wrong[::2], wrong[1::2], strict=True):
        doubts.append(doubted)
        own_doubts.append(own_doubted)
        for cell in CELLS:
            best = min(WITHOUT, key=lambda method, at=cell, of=errors: of[method, at])
            ratios.append(errors["adaptive", cell] / errors[best, cell])
            lines.append(
                (
                    name,
                    cell_name(cell),
                    f"{errors['adaptive', cell]:.2f}",
                    f"{own['adaptive', cell]:.2f}",
                    f"{errors[best, cell]:.2f} ({best})",
                    f"{errors['paper', cell]:.2f}",
                    f"{100 * doubted:.0f} % ({100 * own_doubted:.0f} %)",
                )
            )
    values |= {
        "wrong_over_best": max(ratios),
        "wrong_over_best_mean": float(np.mean(ratios)),
        "wrong_doubted": min(doubts),
        "right_doubted": max(own_doubts),
    }
    head = ("", "noise, outliers", "adaptive", "with the right library", "best without", "paper", "warned (right one)")
    tables.append(Table("Wrong libraries, degrees", head, tuple(lines)))
    return Findings(
        values=values,
        notes=(
            "Clips held out at 30 fps, at most their middle five seconds, each with a draw of its own in every cell.",
            f"Warned: share of the repairs with the warning that {DOUBT}.",
        ),
        tables=tuple(tables),
    )


def tried(mocap: Path, job: tuple[tuple[str, ...], Sequence[str]]) -> tuple[dict[tuple[str, Cell], float], float]:
    """Mean errors by method and cell with one library, and the share of the adaptive repairs that came with a doubt."""
    library, clips = job
    model = model_of(mocap, library)
    errors: dict[tuple[str, Cell], list[float]] = {}
    doubts = []
    for seed, clip in enumerate(clips):
        truth = truth_of(mocap, clip)
        for cell in CELLS:
            bad = spoilt(truth, cell, seed).recording
            outcomes = {name: model.repair(bad, name) for name in ("adaptive", "paper", *FILTERS)}
            outcomes[ALONE] = mm.repair_without_model(bad, "adaptive")
            doubts.append(any(DOUBT in warning for warning in outcomes["adaptive"].warnings))
            for name, outcome in outcomes.items():
                assert isinstance(outcome.recording, mm.Motion)
                errors.setdefault((name, cell), []).append(body_error(truth, outcome.recording))
    return {key: float(np.mean(each)) for key, each in errors.items()}, float(np.mean(doubts))


def _right_values(right: Sequence[tuple[dict[tuple[str, Cell], float], float]]) -> dict[str, float]:
    """Errors at 3 degrees and 10 %, and how far the worst library is behind the best, in any cell."""
    values = {f"{name}_3_10": errors["adaptive", (3.0, 0.1)] for name, (errors, _) in zip(RIGHT, right, strict=True)}
    known = [errors for name, (errors, _) in zip(RIGHT, right, strict=True) if name != "strangers"]
    worst = [max(e["adaptive", cell] for e in known) / min(e["adaptive", cell] for e in known) for cell in CELLS]
    values["library_spread"] = max(worst) - 1.0
    return values
