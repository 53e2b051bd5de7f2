"""Section 2.2.5: missing joint angles filled

Joints go missing in bursts of 0.1 to 2 s; the error is over the missing body angles alone.
"""

from pathlib import Path

import numpy as np

from .common import SEEDS, SPLITS, Findings, Table, body_error, model_of, motion, reduced, spoiled

SHARES = (0.05, 0.1, 0.2, 0.4)
METHODS = ("paper", "linear", "spline")


def run(mocap: Path, pictures: Path) -> Findings:
    """RMS error in the gaps for each share of missing samples and each method."""
    split = SPLITS["walking"]
    model = model_of(mocap, split.learn)
    errors = {method: [] for method in METHODS}
    for share in SHARES:
        found = {method: [] for method in METHODS}
        for clip in split.test:
            truth = reduced(motion(mocap, clip))
            for seed in SEEDS:
                gappy = spoiled(truth, gaps=share, seed=seed)
                filled = {method: model.repair(gappy, method).recording for method in METHODS}
                # gaps at a clip's ends, which the two curves leave open, are counted for nobody
                inner = ~gappy.present & filled["linear"].present & filled["spline"].present
                for method in METHODS:
                    found[method].append(body_error(truth, filled[method], inner))
        for method in METHODS:
            errors[method].append(float(np.mean(found[method])))
    rows = tuple(
        (f"{100 * share:g} %", *(f"{errors[method][i]:.2f}" for method in METHODS)) for i, share in enumerate(SHARES)
    )
    at = SHARES.index(0.1)
    return Findings(
        values={f"{method}_at_10": errors[method][at] for method in METHODS}
        | {"worst_ratio": max(a / min(b, c) for a, b, c in zip(*(errors[m] for m in METHODS), strict=True))},
        notes=(
            f"Walking of one subject at 30 fps, {len(split.test)} clips held out, {len(SEEDS)} draws each; "
            "gaps at the ends of a clip, which linear and spline leave open, are not counted.",
        ),
        tables=(Table("RMS error of the missing body angles, degrees", ("missing", *METHODS), rows),),
    )
