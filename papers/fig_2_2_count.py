"""Figure 2.2: error against the number of bases

Leave one clip out: bases from all other walking clips of the subject, windows of the clip left out projected onto
the first K of them (eq. 2.7).
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from motionmend.arrays import Bools, Floats
from motionmend.denoise.channels.layout import learn_layout
from motionmend.denoise.library.learning import at_rate, examples
from motionmend.numerics.ssa import Eigenbases, eigenbases, lag_covariance, sum_covariances, whole_stretches
from motionmend.report.figures import lines_figure

from .common import FPS, SPLITS, Findings, Table, body, motions

WINDOW = 20
COUNTS = (0, 1, 2, 3, 5, 7, 10, 15, 20, 30, 40, 50, 60, 80, 100, 150, 200)


def run(mocap: Path, pictures: Path) -> Findings:
    """Error by number of bases, for the body angles and for all 62 channels."""
    clips = motions(mocap, SPLITS["walking"].learn + SPLITS["walking"].test)
    layout = learn_layout(clips)
    is_body = body(clips[0])
    whole = [
        [s for piece in examples(clip, layout, 0.0) for s in at_rate(piece.values, piece.fps, FPS)] for clip in clips
    ]
    small = [[np.ascontiguousarray(s[:, is_body]) for s in series] for series in whole]
    angles = clips[0].skeleton.dof_kind == 0
    (body_errors,), body_count = cross_validate(small, [np.ones(int(is_body.sum()), dtype=bool)])
    (joint_errors, all_errors), joint_count = cross_validate(whole, [is_body, angles])
    at = {count: i for i, count in enumerate(COUNTS)}
    explained = 1.0 - (body_errors[at[50]] / body_errors[0]) ** 2
    lines_figure(
        pictures / "fig_2_2.png",
        np.array(COUNTS, dtype=float),
        {
            "44 body angles": body_errors,
            "body, bases of 62": joint_errors,
            "all, bases of 62": all_errors,
        },
        xlabel="number of bases K",
        ylabel="RMS error, degrees",
        leading=("44 body angles",),
    )
    rows = tuple(
        (str(count), f"{body_errors[i]:.2f}", f"{joint_errors[i]:.2f}", f"{all_errors[i]:.2f}")
        for i, count in enumerate(COUNTS)
    )
    return Findings(
        values={
            "k99_body": body_count,
            "k99_all": joint_count,
            "explained_at_50": float(explained),
            "error_at_10": float(body_errors[at[10]]),
            "error_at_50": float(body_errors[at[50]]),
            "error_at_200": float(body_errors[-1]),
            "all_error_at_50": float(all_errors[at[50]]),
        },
        notes=(
            f"{len(clips)} walking clips of one subject, window 20 at 30 fps, each clip left out once; the mean window is "
            "taken out first (K = 0).",
            f"99 % of the energy takes {body_count:.0f} bases of the body angles in the mean, {joint_count:.0f} of all 62 "
            "channels: thumbs, fingers, hands and the root's place take bases of their own.",
        ),
        tables=(Table("RMS error in degrees", ("K", "body angles", "body, bases of 62", "all, bases of 62"), rows),),
        figures=(("fig_2_2.png", "Error of held-out walking windows against the number of bases, window 20."),),
    )


def cross_validate(series: list[tuple[Floats, ...]], counted: Sequence[Bools]) -> tuple[Floats, float]:
    """RMS error by set of counted channels and by K of `COUNTS`, and the mean K that holds 99 % of the energy."""
    parts = [sum_covariances(lag_covariance(s, WINDOW) for s in clip) for clip in series]
    squares, samples, counts = np.zeros((len(counted), len(COUNTS))), np.zeros(len(counted)), []
    for out, clip in enumerate(series):
        covariance = sum_covariances(part for i, part in enumerate(parts) if i != out)
        bases = eigenbases(covariance, 1.0, most=max(COUNTS))
        counts.append(int(np.argmax(np.cumsum(bases.values) >= 0.99 * bases.total)) + 1)
        windows = np.concatenate([windows_of(s[a:b]) for s in clip for a, b in whole_stretches(s) if b - a >= WINDOW])
        for i, channels in enumerate(counted):
            squares[i] += projection_squares(windows, bases, channels)
            samples[i] += len(windows) * WINDOW * int(channels.sum())
    return np.sqrt(squares / samples[:, None]), float(np.mean(counts))


def windows_of(series: Floats) -> Floats:
    """(S, M, C) every window of a series (T, C)."""
    return np.lib.stride_tricks.sliding_window_view(series, WINDOW, axis=0).transpose(0, 2, 1)


def projection_squares(windows: Floats, bases: Eigenbases, counted: Bools) -> Floats:
    """Sum of squared errors of the windows (S, M, C) over the counted channels for each of `COUNTS`."""
    flat = (windows - bases.mean).reshape(len(windows), -1)
    vectors = bases.vectors.reshape(bases.count, -1)
    coefficients = flat @ vectors.T  # eq. 2.7
    columns = np.tile(counted, WINDOW)
    left, before, squares = flat[:, columns], 0, []
    for count in COUNTS:
        left = left - coefficients[:, before:count] @ vectors[before:count][:, columns]
        squares.append(float(np.square(left).sum()))
        before = count
    return np.array(squares)
