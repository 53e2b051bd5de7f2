"""B2: outliers found, and the noise read off the recording"""

from pathlib import Path

import numpy as np

from .beyond_common import ABOUT_PROBLEMS, NOISES, PROBLEMS, SHARES, adaptive_tries
from .common import Findings, Table

SHARE = 0.1


def run(mocap: Path, pictures: Path) -> Findings:
    """F1 of the rejected samples at 10 % outliers, and estimated against true noise, by noise and problem."""
    tries = adaptive_tries(mocap)
    values: dict[str, float] = {}
    found: dict[tuple[str, float], float] = {}
    noise: dict[tuple[str, float, float], float] = {}
    for problem in PROBLEMS:
        for level in NOISES:
            here = [one for one in tries if one.problem == problem and one.cell[0] == level]
            found[problem, level] = float(np.mean([one.found for one in here if one.cell[1] == SHARE]))
            for share in SHARES:
                noise[problem, level, share] = float(np.mean([one.noise for one in here if one.cell[1] == share]))
    for level in NOISES:
        values[f"f1_{level:g}"] = float(np.mean([found[problem, level] for problem in PROBLEMS]))
        values[f"noise_{level:g}"] = float(np.mean([noise[problem, level, SHARE] for problem in PROBLEMS]))
    values["f1_worst"] = min(found.values())
    off = {key: abs(estimate / key[1] - 1.0) for key, estimate in noise.items()}
    values["noise_off_mean"] = float(np.mean(list(off.values())))
    values["noise_off_worst"] = max(off.values())
    rows = [
        (
            problem,
            *(f"{found[problem, level]:.3f}" for level in NOISES),
            *(f"{noise[problem, level, share]:.2f}" for level in NOISES for share in (0.0, SHARE)),
        )
        for problem in PROBLEMS
    ]
    head = (
        "problem",
        *(f"F1, {level:g}°" for level in NOISES),
        *(f"noise found, {level:g}°, {100 * share:g} %" for level in NOISES for share in (0.0, SHARE)),
    )
    return Findings(
        values=values,
        notes=(
            ABOUT_PROBLEMS,
            "Outliers are 15 to 55 degrees off, with random sign, before the noise is added: at 5 degrees of noise some lie "
            "within three standard deviations of the truth, and no method can tell them.",
            "Noise: median over body angles of the standard deviation the repair states for each channel.",
        ),
        tables=(Table(f"Outliers found at {100 * SHARE:g} %, and noise found in degrees", head, tuple(rows)),),
    )
