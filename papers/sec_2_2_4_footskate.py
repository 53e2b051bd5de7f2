"""Section 2.2.4, post processing: foot skate cleaned after filtering"""

from pathlib import Path

import numpy as np

import motionmend as mm

from .common import SPLITS, Findings, Table, model_of, motion, spoiled

NOISE = 3.0  # degrees


def run(mocap: Path, pictures: Path) -> Findings:
    """Speed of the feet while they are on the ground, before and after, and what it costs in the pose."""
    split = SPLITS["walking"]
    model = model_of(mocap, split.learn)
    rows, before, after, true, moved = [], [], [], [], []
    for clip in split.test:
        truth = motion(mocap, clip)
        noisy = spoiled(truth, noise=NOISE)
        plain = mm.compare(truth, model.repair(noisy, "paper").recording)
        clean = mm.compare(truth, model.repair(noisy, "paper", footskate=True).recording)
        before.append(plain.foot_skate_cm_s["other"])
        after.append(clean.foot_skate_cm_s["other"])
        true.append(plain.foot_skate_cm_s["truth"])
        moved.append(clean.mean_cm - plain.mean_cm)
        rows.append(
            (
                clip,
                f"{true[-1]:.1f}",
                f"{before[-1]:.1f}",
                f"{after[-1]:.1f}",
                f"{plain.mean_cm:.2f}",
                f"{clean.mean_cm:.2f}",
            )
        )
    head = ("clip", "truth, cm/s", "filtered, cm/s", "cleaned, cm/s", "joint error, cm", "cleaned, cm")
    return Findings(
        values={
            "skate_truth": float(np.mean(true)),
            "skate_before": float(np.mean(before)),
            "skate_after": float(np.mean(after)),
            "skate_ratio": float(np.mean(after) / np.mean(before)),
            "joint_error_added": float(np.mean(moved)),
        },
        notes=(f"Walking at the files' 120 Hz, {NOISE:g} degrees of noise, method paper.",),
        tables=(Table("Foot skate while in contact", head, tuple(rows)),),
    )
