"""Section 2.4: when outliers become too many

Outliers come one sample at a time, and in bursts in which a channel stays off by the same angle.
"""

from pathlib import Path

import numpy as np

import motionmend as mm
from motionmend.report.figures import lines_figure

from .common import SEEDS, SPLITS, Findings, Table, body_error, model_of, motion, reduced, spoiled

SHARES = (0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4)
KINDS = ("walking", "running", "jumping")
NOISE = 1.0  # degrees
BURST = (3, 15)  # frames at 30 fps
OFF = (15.0, 55.0)  # degrees, as far as the single outliers


def run(mocap: Path, pictures: Path) -> Findings:
    """Error by share of outliers for three kinds of motion and both kinds of outliers."""
    curves: dict[str, np.ndarray] = {}
    for kind in KINDS:
        split = SPLITS[kind]
        model = model_of(mocap, split.learn)
        for manner, spoil in (("single", single), ("bursts", bursts)):
            found = []
            for share in SHARES:
                errors = []
                for clip in split.test:
                    truth = reduced(motion(mocap, clip))
                    for seed in SEEDS:
                        noisy = spoil(truth, share, seed)
                        errors.append(body_error(truth, model.repair(noisy, "paper").recording))
                found.append(float(np.mean(errors)))
            curves[f"{kind}, {manner}"] = np.array(found)
    lines_figure(
        pictures / "sec_2_4.png",
        100 * np.array(SHARES),
        curves,
        xlabel="outliers, %",
        ylabel="RMS error, degrees",
        leading=("walking, single",),
    )
    at = SHARES.index(0.15)
    growth = {name: curve[-1] / curve[at] for name, curve in curves.items()}
    walk = curves["walking, single"]
    rows = tuple((name, *(f"{error:.2f}" for error in curve)) for name, curve in curves.items())
    return Findings(
        values={
            "walk_at_0": float(walk[0]),
            "walk_at_15": float(walk[at]),
            "walk_at_40": float(walk[-1]),
            "bursts_at_40": float(curves["walking, bursts"][-1]),
            "most_growth": float(max(growth.values())),
        },
        notes=(
            f"{NOISE:g} degree of noise, method paper, clips held out of the same person at 30 fps, {len(SEEDS)} draws "
            "each. Swimming is not in the data.",
            f"A burst lasts {BURST[0]} to {BURST[1]} frames and stays {OFF[0]:g} to {OFF[1]:g} degrees off.",
        ),
        tables=(Table("RMS error over body angles, degrees", ("outliers", *(f"{100 * s:g} %" for s in SHARES)), rows),),
        figures=(("sec_2_4.png", "Error of the paper's method against the share of outliers."),),
    )


def single(truth: mm.Motion, share: float, seed: int) -> mm.Motion:
    """Outliers in samples drawn one by one."""
    return spoiled(truth, noise=NOISE, outliers=share, seed=seed)


def bursts(truth: mm.Motion, share: float, seed: int) -> mm.Motion:
    """Outliers in runs of frames of one channel, all off by the same; translations by a centimetre for a degree."""
    rng = np.random.default_rng(seed)
    q = spoiled(truth, noise=NOISE, seed=seed).q.copy()
    hit = np.zeros(q.shape, dtype=bool)
    rotation = truth.skeleton.dof_kind == 0
    while hit.mean() < share:
        channel, start = int(rng.integers(q.shape[1])), int(rng.integers(len(q)))
        frames = slice(start, start + int(rng.integers(BURST[0], BURST[1] + 1)))
        off = rng.uniform(*OFF) * rng.choice([-1.0, 1.0])
        if not hit[frames, channel].any():
            q[frames, channel] += np.radians(off) if rotation[channel] else off / 100
            hit[frames, channel] = True
    return truth.with_q(q)
