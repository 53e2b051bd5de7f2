"""Figure 2.3: the robust estimators

Cost, influence and weight of a residual (section 2.2.2, eq. 2.8-2.9).
"""

from pathlib import Path

import numpy as np

from motionmend.numerics.robust import ESTIMATORS
from motionmend.report.figures import robust_figure

from .common import Findings

SCALE = 3.0  # p
FAR = 15.0  # degrees, the smallest outlier of the simulated data


def run(mocap: Path, pictures: Path) -> Findings:
    """Draw the curves and measure what the text says of them."""
    residuals = np.linspace(-15.0, 15.0, 601)
    welsch, square = ESTIMATORS["welsch"], ESTIMATORS["square"]
    written = SCALE**2 / 2 * (1 - np.exp(-(residuals**2) / SCALE**2))  # eq. 2.9 as printed
    slope = np.gradient(welsch.rho(residuals, SCALE), residuals)
    inner = slice(1, -1)
    far = np.array([FAR])
    robust_figure(
        pictures / "fig_2_3.png",
        residuals / SCALE,
        {
            "least squares" if name == "square" else name: (
                one.rho(residuals, SCALE),
                one.influence(residuals, SCALE),
                one.weight(residuals, SCALE),
            )
            for name, one in ESTIMATORS.items()
        },
    )
    return Findings(
        values={
            "away_from_formula": float(np.abs(welsch.rho(residuals, SCALE) - written).max()),
            "away_from_slope": float(np.abs(welsch.influence(residuals, SCALE) - slope)[inner].max()),
            "weight_of_outlier": float(welsch.weight(far, SCALE)[0]),
            "influence_of_outlier": float(welsch.influence(far, SCALE)[0]),
            "square_influence_of_outlier": float(square.influence(far, SCALE)[0]),
        },
        notes=(
            f"Residuals in degrees, p = 3. The cost of a residual of {FAR:g} degrees is "
            f"{welsch.rho(far, SCALE)[0]:.2f} by Welsch and {square.rho(far, SCALE)[0]:.1f} by least squares.",
            "Tukey, Huber and Student-t can be chosen in place of Welsch.",
        ),
        figures=(("fig_2_3.png", "Cost, influence and weight of a residual, p = 3."),),
    )
