"""Stick figures side by side, before and after."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import Bools, Floats, Ints
from ..errors import MismatchError, UsageError
from .style import FAINT, GHOST, colours_of, figure_at


def skeleton_figure(
    path: str | Path,
    rows: Mapping[str, Floats],
    parents: Ints,
    *,
    frames: Sequence[int],
    fps: float,
    up: Floats,
    ghost: Floats | None = None,
    marked: Mapping[str, Bools] | None = None,
    title: str = "",
) -> None:
    """Draw a strip of stick figures for each recording, seen at a slant from the side of the way they go.

    Parameters
    ----------
    path : PNG to write.
    rows : (T, J, 3) m, joint positions by name of the recording.
    parents : (J,) index of the parent, -1 = root.
    frames : which frames to draw, left to right.
    fps : frames per second, Hz, for the times under the figures.
    up : (3,) unit vector against gravity.
    ghost : (T, J, 3) m, drawn thin and grey behind every row: the truth.
    marked : (T, J) by name, joints to ring.

    Raises
    ------
    UsageError : without recordings, frames or a single position.
    MismatchError : when the recordings do not have the same shape.
    """
    if not rows or not len(frames):
        raise UsageError("a figure of skeletons needs at least one recording and one frame")
    everything = [*rows.values(), *([] if ghost is None else [ghost])]
    if any(p.shape != everything[0].shape for p in everything):
        raise MismatchError(f"recordings side by side need one shape, came {[p.shape for p in everything]}")
    lead = ghost if ghost is not None else next(iter(rows.values()))
    if not np.isfinite(lead).any():
        raise UsageError("a figure of skeletons needs a recording with positions, came one that has none")
    view = _slant(lead, up)
    chosen = list(frames)
    placed = {name: p[chosen] @ view.T for name, p in rows.items()}
    behind = None if ghost is None else ghost[chosen] @ view.T
    centre = np.array([_middle(one) for one in (behind if behind is not None else placed[next(iter(rows))])])
    size = np.nanpercentile(np.abs((lead @ view.T)[:, :, :2] - _middles(lead @ view.T)[:, None]), 98, axis=(0, 1))
    across, down = 2.1 * size[0] + 0.12, 2.1 * size[1] + 0.32
    colours = colours_of(list(rows))
    wide = 7.2
    tall = wide * (down * len(rows) + 0.25) / (across * len(chosen)) + (0.45 if title else 0.2)
    with figure_at(path, wide, min(tall, 8.0), title) as figure:
        axes = figure.add_subplot()
        for r, (name, one) in enumerate(placed.items()):
            level = -r * down
            axes.text(-0.5 * across, level + 0.5 * down - 0.02, name, color=colours[name], weight="bold", va="top")
            for i in range(len(chosen)):
                move = np.array([i * across, level]) - centre[i]
                if behind is not None:
                    _stick(axes, behind[i], parents, move, GHOST, 0.8)
                _stick(axes, one[i], parents, move, colours[name], 1.7)
                ring = None if marked is None or name not in marked else marked[name][chosen[i]]
                if ring is not None and ring.any():
                    at = one[i][ring, :2] + move
                    axes.scatter(at[:, 0], at[:, 1], s=34, facecolors="none", edgecolors="#e69f00", lw=1.2, zorder=9)
        if behind is not None:
            right = (len(chosen) - 0.5) * across
            axes.text(right, 0.5 * down - 0.02, "thin: truth", color=FAINT, ha="right", va="top")
        for i, frame in enumerate(chosen):
            below = -(len(rows) - 0.5) * down
            axes.text(i * across, below, f"{frame / fps:.2f} s", ha="center", va="top", color=FAINT)
        axes.set_xlim(-0.52 * across, (len(chosen) - 0.48) * across)
        axes.set_ylim(-(len(rows) - 0.5) * down - 0.2, 0.5 * down)
        axes.set_aspect("equal")
        axes.axis("off")


def _slant(positions: Floats, up: Floats) -> Floats:
    """Rotation (3, 3) to across, up and towards the eye: from the side of the way, a little in front and above."""
    up = up / np.linalg.norm(up)
    middles = np.array([[float(np.nanmedian(axis)) if np.isfinite(axis).any() else np.nan for axis in one.T]
                        for one in positions[:: max(1, len(positions) // 50)]])  # fmt: skip
    seen = middles[np.isfinite(middles).all(axis=1)]
    way = seen[-1] - seen[0] if len(seen) else np.zeros(3)
    way = way - (way @ up) * up
    if np.linalg.norm(way) < 0.3:
        way = np.cross(up, np.eye(3)[int(np.argmin(np.abs(up)))])
    across = way / np.linalg.norm(way)
    towards = np.cross(across, up)
    turn, tilt = np.radians(28.0), np.radians(10.0)
    across, towards = np.cos(turn) * across + np.sin(turn) * towards, np.cos(turn) * towards - np.sin(turn) * across
    return np.array([across, np.cos(tilt) * up - np.sin(tilt) * towards, np.sin(tilt) * up + np.cos(tilt) * towards])


def _middle(pose: Floats) -> Floats:
    """Centre (2,) of what a pose (J, 3) covers in the picture; 0 where nothing is left of it."""
    there = pose[np.isfinite(pose).all(axis=1), :2]
    return (there.min(axis=0) + there.max(axis=0)) / 2 if len(there) else np.zeros(2)


def _middles(poses: Floats) -> Floats:
    return np.array([_middle(pose) for pose in poses])


def _stick(axes: Any, pose: Floats, parents: Ints, move: Floats, colour: str, thick: float) -> None:
    """One pose (J, 3) as bones, the far ones paler and thinner."""
    flat, depth = pose[:, :2] + move, pose[:, 2]
    if not np.isfinite(depth).any():
        return
    low, high = float(np.nanmin(depth)), float(np.nanmax(depth))
    bones = [(j, int(p)) for j, p in enumerate(parents) if p >= 0]
    for j, p in sorted(bones, key=lambda bone: float(depth[bone[0]] + depth[bone[1]])):
        if np.isfinite(pose[[j, p]]).all():
            near = ((depth[j] + depth[p]) / 2 - low) / max(high - low, 1e-6)
            axes.plot(*flat[[p, j]].T, color=colour, lw=thick * (0.75 + 0.35 * near), alpha=0.5 + 0.5 * near)
