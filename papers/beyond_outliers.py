"""B2: outliers found, and the noise read off the recording"""

from pathlib import Path

import numpy as np
from scipy.stats import norm

from .beyond_common import ABOUT_PROBLEMS, NOISES, PROBLEMS, SHARES, adaptive_tries
from .beyond_verdicts import oracle_verdicts
from .common import Findings, Table

SHARE = 0.1
OFF = (15.0, 55.0)  # degrees by which outliers are off
NEARLY = 0.5  # of the noise


def best_f1(noise: float, off: float = 0.0) -> float:
    """F1 of the best threshold on the distance of each sample from an estimate of the truth.

    Parameters
    ----------
    noise : standard deviation, degrees.
    off : standard deviation of the estimate's error as a share of the noise; 0 = the truth itself is told.
    """
    spread = noise * np.hypot(1.0, off)
    outlier, threshold = np.linspace(*OFF, 801), np.linspace(0.1, OFF[1], 1101)[:, None]
    hits = SHARE * (norm.sf((threshold - outlier) / spread) + norm.cdf((-threshold - outlier) / spread)).mean(axis=1)
    false = (1.0 - SHARE) * 2.0 * norm.sf(threshold[:, 0] / spread)
    return float((2.0 * hits / (hits + false + SHARE)).max())


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
    judged = oracle_verdicts(mocap)
    for level in NOISES:
        values[f"f1_oracle_{level:g}"] = float(np.mean([one.f1 for one in judged if one.cell == (level, SHARE)]))
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
    told = ", ".join(f"{best_f1(level):.3f}" for level in NOISES)
    nearly = ", ".join(f"{best_f1(level, NEARLY):.3f}" for level in NOISES)
    return Findings(
        values=values,
        notes=(
            ABOUT_PROBLEMS,
            "Outliers are 15 to 55 degrees off, with random sign, before the noise is added: at 5 degrees of noise 15 are "
            "three standard deviations. The best threshold there is, on the distance from the truth itself and told the "
            f"noise and the share of outliers, reaches F1 {told} at {', '.join(f'{n:g}' for n in NOISES)} degrees; on the "
            f"distance from an estimate that is off by {NEARLY:g} of the noise, {nearly}. The smoothers of B1's oracle, told "
            "the noise and, of every other sample, whether it is an outlier, by the best threshold for each problem: "
            + ", ".join(f"{values[f'f1_oracle_{level:g}']:.3f}" for level in NOISES)
            + " (`papers/beyond_verdicts.py`).",
            "Noise: median over body angles of the standard deviation the repair states for each channel.",
        ),
        tables=(Table(f"Outliers found at {100 * SHARE:g} %, and noise found in degrees", head, tuple(rows)),),
    )
