"""Section 2.4, future work: bases from the noisy data itself, joint limits

Neither is part of this version; this is what happens without them.
"""

from pathlib import Path

import numpy as np

import motionmend as mm

from .common import FPS, SPLITS, Findings, Table, body, body_error, model_of, motion, reduced, spoiled

NOISE, OUTLIERS = 3.0, 0.1


def run(mocap: Path, pictures: Path) -> Findings:
    """Bases fitted to the spoiled clip as if it were clean, and samples outside the skeleton's limits."""
    split = SPLITS["walking"]
    model = model_of(mocap, split.learn)
    clean_bases, own_bases, outside = [], [], []
    for clip in split.test:
        truth = reduced(motion(mocap, clip))
        noisy = spoiled(truth, noise=NOISE, outliers=OUTLIERS)
        repaired = model.repair(noisy, "paper").recording
        clean_bases.append(body_error(truth, repaired))
        own_bases.append(body_error(truth, mm.Denoiser(fps=FPS).fit([noisy]).repair(noisy, "paper").recording))
        outside.append([beyond_limits(one) for one in (truth, noisy, repaired)])
    shares = np.mean(outside, axis=0)
    return Findings(
        values={
            "clean_bases": float(np.mean(clean_bases)),
            "own_bases": float(np.mean(own_bases)),
            "own_over_clean": float(np.mean(own_bases) / np.mean(clean_bases)),
            "outside_limits": float(100 * shares[2]),
            "outside_limits_truth": float(100 * shares[0]),
        },
        notes=(f"Walking, {NOISE:g} degrees of noise, {100 * OUTLIERS:g} % outliers.",),
        tables=(
            Table(
                "Body angles outside the limits of the .asf",
                ("truth", "spoiled", "filtered"),
                (tuple(f"{100 * share:.2f} %" for share in shares),),
            ),
        ),
    )


def beyond_limits(recording: mm.Motion) -> float:
    """Share of the body angles that lie outside the skeleton's limits."""
    low, high = recording.skeleton.limits.T
    out = (recording.q < low) | (recording.q > high)
    return float(out[:, body(recording)].mean())
