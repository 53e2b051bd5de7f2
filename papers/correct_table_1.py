"""Table 1 in kind: what it costs to take in one more sample"""

from pathlib import Path
from time import perf_counter

import numpy as np

from motionmend.kernels.learning import extend
from motionmend.numerics.local_gp import Hyper, factor

from .common import Findings, Table

SIZES = (25, 50, 100, 200, 400)
INPUTS = 12
ROUNDS = 15


def run(mocap: Path, pictures: Path) -> Findings:
    """Time of extending the Cholesky factor by one sample against factoring anew, and the difference."""
    del mocap, pictures
    rng = np.random.default_rng(0)
    hyper = Hyper(1.0, 0.5, 0.3, 0.01)
    rows, ratio, apart = [], [], 0.0
    for size in SIZES:
        x = rng.normal(size=(size + 1, INPUTS))
        lower, given = np.zeros((size + 1, size + 1)), np.array(hyper)
        lower[:-1, :-1] = factor(x[:-1], hyper)
        extend(x, lower, given, size)  # compiles
        quick = min(
            _seconds(lambda x=x, lower=lower, given=given: extend(x, lower, given, len(x) - 1)) for _ in range(ROUNDS)
        )
        anew = min(_seconds(lambda x=x: factor(x, hyper)) for _ in range(ROUNDS))
        apart = max(apart, float(np.abs(lower - factor(x, hyper)).max()))
        ratio.append(anew / quick)
        rows.append((str(size), f"{1e6 * quick:.0f}", f"{1e6 * anew:.0f}", f"{anew / quick:.1f}"))
    return Findings(
        {"apart": apart, "faster_50": ratio[SIZES.index(50)], "faster_400": ratio[-1]},
        ("Covariances of random inputs; the fewest microseconds of several rounds.",),
        (Table("One more sample", ("samples", "extended, µs", "anew, µs", "times faster"), tuple(rows)),),
    )


def _seconds(work: object) -> float:
    start = perf_counter()
    work()  # type: ignore[operator]
    return perf_counter() - start
