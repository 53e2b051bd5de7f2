"""Section 2.4, future work: bases from the noisy data itself, joint limits

The dissertation leaves both to the future. Here the adaptive method without a library learns bases from its own first
repair, and what a repair makes up is held within the skeleton's limits where the recording itself keeps them.
"""

from pathlib import Path

import numpy as np

import motionmend as mm
from motionmend.arrays import Bools

from .common import FPS, SPLITS, Findings, Table, body, body_error, model_of, motion, reduced, spoiled

NOISE, OUTLIERS = 3.0, 0.1
ROUNDED = np.radians(1.0)  # limits are written in whole degrees


def run(mocap: Path, pictures: Path) -> Findings:
    """Errors by bases of the spoiled clip itself, and made-up samples outside the skeleton's limits."""
    split = SPLITS["walking"]
    model = model_of(mocap, split.learn)
    errors, outside = [], []
    for clip in split.test:
        truth = reduced(motion(mocap, clip))
        noisy = spoiled(truth, noise=NOISE, outliers=OUTLIERS)
        library = model.repair(noisy, "adaptive")
        alone = mm.repair_without_model(noisy, "adaptive")
        plain = mm.Denoiser(fps=FPS).fit([noisy]).repair(noisy, "paper")
        paper, filtered = model.repair(noisy, "paper"), mm.repair_without_model(noisy, "kalman")
        errors.append([body_error(truth, one.recording) for one in (library, alone, paper, plain, filtered)])
        keeps = body(truth) & ~beyond_limits(truth).any(axis=0)
        made_up = (library.origin == mm.Origin.REPAIRED) & keeps
        outside.append([float(beyond_limits(one)[made_up].mean()) for one in (noisy, paper.recording)])
        outside[-1].append(float(beyond_limits(library.recording)[made_up].mean()))
        outside[-1].append(float((beyond_limits(truth)[:, body(truth)] > 0).any(axis=0).mean()))
    library_error, alone_error, paper_error, plain_error, filter_error = np.mean(errors, axis=0)
    shares = 100 * np.mean(outside, axis=0)
    return Findings(
        values={
            "clean_bases": float(library_error),
            "own_bases": float(alone_error),
            "own_over_clean": float(alone_error / library_error),
            "filter_error": float(filter_error),
            "own_over_filter": float(alone_error / filter_error),
            "plain_over_clean": float(plain_error / paper_error),
            "outside_limits": float(shares[2]),
            "limits_broken_by_truth": float(shares[3]),
        },
        notes=(
            f"Walking, {NOISE:g} degrees of noise, {100 * OUTLIERS:g} % outliers.",
            "Limits: samples that the adaptive method rejects, of the body angles whose limits the true clip keeps, more "
            f"than a degree outside. The true clips break the limits of {shares[3]:.0f} % of the body angles.",
        ),
        tables=(
            Table(
                "RMS error over the body angles, degrees",
                (
                    "adaptive, library",
                    "adaptive, its own bases",
                    "paper, library",
                    "paper, bases of the clip",
                    "kalman",
                ),
                (tuple(f"{error:.2f}" for error in np.mean(errors, axis=0)),),
            ),
            Table(
                "Rejected samples outside the limits of the .asf",
                ("spoiled", "paper", "adaptive"),
                (tuple(f"{share:.2f} %" for share in shares[:3]),),
            ),
        ),
    )


def beyond_limits(recording: mm.Motion) -> Bools:
    """(T, D) True where a value lies outside of the skeleton's limits."""
    low, high = recording.skeleton.limits.T
    return np.asarray((recording.q < low - ROUNDED) | (recording.q > high + ROUNDED))
