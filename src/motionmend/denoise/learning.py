"""What a model learns from: clean clips as channels at the model's own rate."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from ..arrays import Floats
from ..bodies.motion import Markers, Motion
from ..bodies.skeleton import ROTATION
from ..numerics.ssa import whole_stretches
from .channels import Layout, kind_of, to_channels

BRIDGED = 0.2  # s; gaps this short in a training clip are bridged by a spline, longer ones cut the clip
GLITCH = np.radians(30.0)  # a joint that falls to exact zeros by a jump this large was lost, not held


@dataclass(frozen=True, eq=False)
class Examples:
    """A clip made ready to learn from.

    Attributes
    ----------
    series : each (T', C) at the model's rate, NaN where the clip is cut; one for each phase of the clip's rate.
    notes : one sentence for each thing that was left out or bridged.
    """

    series: tuple[Floats, ...]
    notes: tuple[str, ...]


def examples(recording: Motion | Markers, layout: Layout, model_fps: float) -> Examples:
    """Channels of a clean clip at the model's rate.

    A clip at a multiple of the model's rate gives one series for each phase, so that all its frames teach; a
    clip at another rate is resampled by cubic splines.

    Parameters
    ----------
    recording : a clean clip.
    layout : of the model.
    model_fps : Hz.
    """
    notes: list[str] = []
    if isinstance(recording, Motion):
        recording, lost = without_glitches(recording)
        if lost:
            notes.append(f"{lost} samples of joints that fall to exact zeros were left out")
    values = to_channels(recording, layout).values
    limit = max(1, round(BRIDGED * recording.fps))
    values, bridged = _bridged(values, limit)
    if bridged:
        word = "channel samples" if kind_of(recording) == "motion" else "marker coordinates"
        notes.append(f"{bridged} {word} in gaps of up to {BRIDGED} s were bridged by splines")
    return Examples(tuple(_phases(values, recording.fps, model_fps)), tuple(notes))


def without_glitches(motion: Motion) -> tuple[Motion, int]:
    """The motion with every joint missing where it drops to exact zeros by a jump, and how many samples that is.

    Capture software writes zeros for a joint it could not solve. A joint that is zero throughout, or that comes
    to zero smoothly, is left alone.
    """
    skeleton, q = motion.skeleton, motion.q
    cleaned = q.copy()
    for joint in range(len(skeleton.names)):
        rows = skeleton.dofs_of(joint)
        rows = rows[skeleton.dof_kind[rows] == ROTATION]
        if len(rows) == 0:
            continue
        zero = (q[:, rows] == 0.0).all(axis=1)
        if not zero.any() or zero.all():
            continue
        jump = np.abs(np.diff(q[:, rows], axis=0)).max(axis=1, initial=0.0) > GLITCH
        edges = np.flatnonzero(np.diff(np.concatenate([[0], zero.astype(np.int8), [0]])))
        for start, stop in edges.reshape(-1, 2):
            if (start > 0 and jump[start - 1]) or (stop < len(q) and jump[stop - 1]):
                cleaned[start:stop, rows] = np.nan
    lost = int(np.isnan(cleaned).sum() - np.isnan(q).sum())
    return (motion.with_q(cleaned), lost) if lost else (motion, 0)


def _bridged(values: Floats, limit: int) -> tuple[Floats, int]:
    """Fill inner gaps of at most `limit` frames by cubic splines; returns how many samples were filled."""
    filled, count = values, 0
    frames = np.arange(len(values))
    for c in np.flatnonzero(np.isfinite(values).any(axis=0) & ~np.isfinite(values).all(axis=0)):
        known = np.isfinite(values[:, c])
        if known.sum() < 4:
            continue
        edges = np.flatnonzero(np.diff(np.concatenate([[0], (~known).astype(np.int8), [0]])))
        runs = [(a, b) for a, b in edges.reshape(-1, 2) if a > 0 and b < len(values) and b - a <= limit]
        if not runs:
            continue
        if filled is values:
            filled = values.copy()
        curve = CubicSpline(frames[known], values[known, c])
        for start, stop in runs:
            filled[start:stop, c] = curve(frames[start:stop])
            count += int(stop - start)
    return filled, count


def _phases(values: Floats, fps: float, model_fps: float) -> list[Floats]:
    """The series at the model's rate, one for each phase."""
    ratio = fps / model_fps
    steps = max(1, round(ratio))
    if abs(ratio - steps) > 1e-3 * ratio:
        values = _resampled(values, fps, model_fps * steps)
    return [np.ascontiguousarray(values[phase::steps]) for phase in range(steps)]


def _resampled(values: Floats, fps: float, target: float) -> Floats:
    """Cubic splines through each whole stretch, read at `target` Hz; frames outside whole stretches are NaN."""
    times = np.arange(int(np.floor((len(values) - 1) / fps * target + 1e-9)) + 1) / target
    result = np.full((len(times), values.shape[1]), np.nan)
    for start, stop in whole_stretches(values):
        if stop - start < 4:
            continue
        inside = (times >= start / fps - 1e-9) & (times <= (stop - 1) / fps + 1e-9)
        result[inside] = CubicSpline(np.arange(start, stop) / fps, values[start:stop], axis=0)(times[inside])
    return result
