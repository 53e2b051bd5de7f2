"""Section 2.2.1: filter bases from the grand lag covariance

The covariance is summed without ever building a trajectory matrix; here it is held against one that is built.
"""

from pathlib import Path

import numpy as np

from motionmend.denoise.channels.layout import learn_layout
from motionmend.denoise.channels.recording import to_channels
from motionmend.numerics.ssa import eigenbases, lag_covariance, sum_covariances

from .common import SPLITS, Findings, body, model_of, motions, reduced

WINDOW = 20


def run(mocap: Path, pictures: Path) -> Findings:
    """Eigenvalues of one and of many clips against a plain singular value decomposition of eq. 2.1-2.2."""
    clips = [reduced(clip) for clip in motions(mocap, SPLITS["walking"].learn)]
    layout = learn_layout(clips)
    series = [np.ascontiguousarray(to_channels(clip, layout).values[:, body(clip)]) for clip in clips]
    one = _away_from_plain(series[:1])
    many = _away_from_plain(series)
    model = model_of(mocap, SPLITS["walking"].learn)
    flat = model.bases.vectors.reshape(model.bases.count, -1)
    return Findings(
        values={
            "one_clip_away": one,
            "many_clips_away": many,
            "away_from_orthonormal": float(np.abs(flat @ flat.T - np.eye(model.bases.count)).max()),
            "energy": model.bases.energy,
            "k99": float(model.bases.count),
        },
        notes=(
            f"{len(clips)} walking clips of one subject at 30 fps, window {WINDOW}: {model.bases.count} bases of "
            f"{model.bases.window} frames x {flat.shape[1] // model.bases.window} channels hold "
            f"{100 * model.bases.energy:.2f} % of the variation about the mean window.",
            "The mean window is taken out first: with the mean pose left in (eq. 2.3 as printed) the first pattern is "
            "the mean pose itself, it alone holds most of the energy and 99 % keeps too few patterns.",
        ),
    )


def _away_from_plain(series: list[np.ndarray]) -> float:
    """Largest difference of the eigenvalues from those of the trajectory matrix itself, as a share of the largest."""
    rows = np.concatenate([np.lib.stride_tricks.sliding_window_view(s, WINDOW, axis=0) for s in series])
    trajectory = rows.transpose(0, 2, 1).reshape(len(rows), -1)  # eq. 2.1-2.2
    singular = np.linalg.svd(trajectory - trajectory.mean(axis=0), compute_uv=False)
    plain = singular**2 / len(trajectory)
    bases = eigenbases(sum_covariances(lag_covariance(s, WINDOW) for s in series), 0.9999)
    return float(np.abs(bases.values - plain[: bases.count]).max() / plain[0])
