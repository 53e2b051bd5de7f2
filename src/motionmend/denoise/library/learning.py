"""What a model learns from: clean clips as channels, in pieces that fit in memory, at any rate."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ...arrays import Floats, Ints, runs
from ...bodies.motion import Markers, Motion
from ...bodies.put_before import rest_frames
from ...bodies.skeleton import ROTATION
from ...numerics.ssa import whole_stretches
from ..channels.bare_names import called_barely
from ..channels.layout import Layout
from ..channels.recording import to_channels
from ..channels.rotation_order import in_order_of
from ..channels.thinning import MOST_VALUES, first_number

LEAST_PIECE = 4096  # frames
BRIDGED = 0.2  # s; gaps this short in a training clip are bridged by a spline, longer ones cut the clip
GLITCH = np.radians(30.0)  # a joint that falls to exact zeros by a jump this large was lost, not held
MARGIN = 4.0  # s on each side of a piece; the travelling frame, smooth over a second, does not see further


@dataclass(frozen=True, eq=False)
class Example:
    """A clip, or a piece of a long one, made ready to learn from.

    Attributes
    ----------
    values : (T + tail, C) degrees and centimetres, NaN where the clip is cut.
    frames : T, this piece's own; those after them are the next piece's and complete the windows that begin here.
    fps : Hz, the clip's own.
    number : where the numbering of the piece's frames begins, for samples.
    lost : samples left out of joints that fall to exact zeros, and of a rest pose put before the clip.
    bridged : samples in short gaps that were bridged.
    """

    values: Floats
    frames: int
    fps: float
    number: int
    lost: int
    bridged: int


def examples(recording: Motion | Markers, layout: Layout, tail: float) -> Iterator[Example]:
    """A clean clip as channels: whole, or in pieces of some 65,000 frames that need no more memory than one.

    Parameters
    ----------
    recording : a clean clip.
    layout : of the model.
    tail : s of the next piece that go with a piece.
    """
    gaps = glitches(recording) if isinstance(recording, Motion) else []
    margin, after = round(MARGIN * recording.fps), int(np.ceil(tail * recording.fps - 1e-6))
    limit = max(1, round(BRIDGED * recording.fps))
    count = -(-recording.frames // max(LEAST_PIECE, MOST_VALUES // max(layout.columns, 1)))
    edges = np.linspace(0, recording.frames, max(count, 1) + 1).astype(np.int64)
    for start, stop in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        first, last = max(0, start - margin), min(recording.frames, stop + max(margin, after))
        raw = _piece(recording, first, last, gaps)
        ordered = in_order_of(called_barely(raw), layout.names) if isinstance(raw, Motion) else raw
        values, own = to_channels(ordered, layout).values, slice(start - first, stop - first)
        filled = _bridged(values, limit)
        yield Example(
            values=filled[own.start : own.stop + after],
            frames=stop - start,
            fps=recording.fps,
            number=first_number(recording.values[start:stop]),
            lost=sum(len(gap.rows) * max(0, min(gap.stop, stop) - max(gap.start, start)) for gap in gaps),
            bridged=int((np.isnan(values[own]) & np.isfinite(filled[own])).sum()),
        )


@dataclass(frozen=True, eq=False)
class Glitch:
    """Rows of a joint's angles that are lost from frame `start` to before frame `stop`."""

    rows: Ints
    start: int
    stop: int


def glitches(motion: Motion) -> list[Glitch]:
    """Where joints drop to exact zeros by a jump, and a rest pose put before the clip.

    Capture software writes zeros for a joint it could not solve. A joint that is zero throughout, or that comes
    to zero smoothly, is left alone.
    """
    skeleton, q = motion.skeleton, motion.q
    rested = rest_frames(motion)
    found = [Glitch(np.arange(q.shape[1]), 0, rested)] if rested else []
    for joint in range(len(skeleton.names)):
        rows = skeleton.dofs_of(joint)
        rows = rows[skeleton.dof_kind[rows] == ROTATION]
        if len(rows) == 0:
            continue
        angles = q[:, rows]
        zero = (angles == 0.0).all(axis=1)
        if not zero.any() or zero.all():
            continue
        jump = np.abs(np.diff(angles, axis=0)).max(axis=1, initial=0.0) > GLITCH
        for start, stop in runs(zero):
            if stop > rested and ((start > 0 and jump[start - 1]) or (stop < len(q) and jump[stop - 1])):
                found.append(Glitch(rows, max(start, rested), stop))
    return found


def _piece(recording: Motion | Markers, start: int, stop: int, gaps: list[Glitch]) -> Motion | Markers:
    """Frames of a recording, with glitches missing."""
    if isinstance(recording, Markers):
        return replace(recording, positions=recording.positions[start:stop], residuals=None)
    inside = [gap for gap in gaps if gap.start < stop and gap.stop > start]
    if not inside and stop - start == recording.frames:
        return recording
    q = recording.q[start:stop].copy()
    for gap in inside:
        q[max(gap.start - start, 0) : max(gap.stop - start, 0), gap.rows] = np.nan
    return recording.with_q(q)


def _bridged(values: Floats, limit: int) -> Floats:
    """Inner gaps of at most `limit` frames filled by cubic splines."""
    from scipy.interpolate import CubicSpline

    filled = values
    frames = np.arange(len(values))
    for c in np.flatnonzero(np.isfinite(values).any(axis=0) & ~np.isfinite(values).all(axis=0)):
        known = np.isfinite(values[:, c])
        if known.sum() < 4:
            continue
        short = [(a, b) for a, b in runs(~known) if a > 0 and b < len(values) and b - a <= limit]
        if not short:
            continue
        if filled is values:
            filled = values.copy()
        curve = CubicSpline(frames[known], values[known, c])
        for start, stop in short:
            filled[start:stop, c] = curve(frames[start:stop])
    return filled


def at_rate(values: Floats, fps: float, target: float) -> list[Floats]:
    """Channels at another rate, one series for each phase, so that all frames teach.

    Values at a multiple of the rate are only dealt out; at other rates they are resampled by cubic splines first.

    Parameters
    ----------
    values : (T, C) at `fps` Hz, NaN where the clip is cut.
    target : Hz; above `fps` nothing is added.
    """
    ratio = fps / target
    steps = max(1, round(ratio))
    if abs(ratio - steps) > 1e-3 * ratio:
        values = _resampled(values, fps, target * steps)
    return [np.ascontiguousarray(values[phase::steps]) for phase in range(steps)]


def _resampled(values: Floats, fps: float, target: float) -> Floats:
    """Cubic splines through each whole stretch, read at `target` Hz; frames outside whole stretches are NaN."""
    from scipy.interpolate import CubicSpline

    times = np.arange(int(np.floor((len(values) - 1) / fps * target + 1e-9)) + 1) / target
    result = np.full((len(times), values.shape[1]), np.nan)
    for start, stop in whole_stretches(values):
        if stop - start < 4:
            continue
        inside = (times >= start / fps - 1e-9) & (times <= (stop - 1) / fps + 1e-9)
        result[inside] = CubicSpline(np.arange(start, stop) / fps, values[start:stop], axis=0)(times[inside])
    return result
