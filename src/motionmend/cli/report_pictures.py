"""Pictures of depth recordings for the report, with the joints that were found in them."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ..arrays import Floats, Ints
from ..bodies.camera import DepthFrame
from ..bodies.joint_sets import parents
from ..bodies.postures import Postures
from ..errors import FileError
from ..io.depth import read_depth
from ..io.depth_recording import DepthRecording, without_color
from ..report.camera_views import camera_view

SHOWN = 8  # frames of one recording, spread evenly; the least sure ones are added
WORST = 4
_APART = 5  # frames between those of the least sure that are shown
_WAYS = ((1.0, 1.0, 1.0), (1.0, -1.0, 1.0), (-1.0, -1.0, 1.0))  # cameras, UTD-MHAD, the Kinects' own camera space
_TRIED = 5  # frames
_HALF = 0.5  # of a frame; joints whose time is off by more belong to no image


def pictures_of(path: Path, tables: Mapping[str, Postures]) -> tuple[list[tuple[str, bytes]], tuple[str, ...]]:
    """Some frames of a depth recording with the joints of tables drawn over them, as (words, PNG), and what is to be
    said of images that are damaged: one of colour is done without, one of depth is not shown.

    Parameters
    ----------
    path : a depth folder or file.
    tables : joints in the axes of the camera, by name; a table without a row at a frame's time is not drawn there.

    Raises
    ------
    FileError : the recording, or all of the images that would be shown, cannot be read.
    """
    recording = read_depth(path)
    tables = {name: _as_the_camera_sees(recording, table) for name, table in tables.items()}
    rows = {name: _rows(table, recording.times) for name, table in tables.items()}
    above = {name: parents(table.names) for name, table in tables.items()}
    found, damaged = [], []
    for number in _chosen(recording.frames, tables, rows):
        frame, why = _readable(recording, number)
        damaged += [why] if why else []
        if frame is None:
            continue
        poses = []
        words = [f"{path.name}, frame {number}, {frame.time:.2f} s"]
        for name, table in tables.items():
            row = int(rows[name][number])
            if row < 0:
                poses.append((np.full((len(table.names), 3), np.nan), above[name], None))
                continue
            std = None if table.std is None else table.std[row]
            poses.append((table.positions[row], above[name], std))
            if not table.present[row].any():
                words.append(f"{name}: nobody")
            elif std is not None and np.isfinite(std).any():
                worst = int(np.nanargmax(std))
                mean, most = 100 * float(np.nanmean(std)), 100 * float(std[worst])
                words.append(f"{name}: deviation {mean:.1f} cm, largest {most:.1f} ({table.names[worst]})")
        found.append((", ".join(words), camera_view(frame, poses)))
    if not found and damaged:
        raise FileError(f"no image can be shown, as of the first: {damaged[0]}")
    return found, tuple(damaged)


def _readable(recording: DepthRecording, number: int) -> tuple[DepthFrame | None, str]:
    """What can be read of a frame, and why not all of it."""
    try:
        return recording.frame(number), ""
    except FileError as error:
        why = str(error)
    try:
        return without_color(recording).frame(number), f"frame {number} is shown without colour: {why}"
    except FileError:
        return None, f"frame {number} is not shown: {why}"


def _as_the_camera_sees(recording: DepthRecording, table: Postures) -> Postures:
    """The joints with y down, and x to the image's right: of the ways sensors have it the one that meets the depth."""
    rows = _rows(table, recording.times)
    numbers = np.flatnonzero(rows >= 0)
    numbers = numbers[np.unique(np.linspace(0, len(numbers) - 1, min(len(numbers), _TRIED)).astype(int))]
    images = [
        (_readable(without_color(recording), int(number))[0], table.positions[rows[number]]) for number in numbers
    ]
    frames = [(frame, joints) for frame, joints in images if frame is not None]
    best = max(_WAYS, key=lambda way: sum(_met(frame, joints * np.array(way)) for frame, joints in frames))
    return table.with_positions(table.positions * np.array(best))


def _met(frame: DepthFrame, joints: Floats) -> int:
    """How many joints lie behind a pixel with depth."""
    height, width = frame.depth.shape
    pixel = frame.camera.project(joints)
    pixel = np.rint(pixel[np.flatnonzero(np.isfinite(pixel).all(axis=1))]).astype(int)
    pixel = pixel[np.flatnonzero(((pixel >= 0) & (pixel < (width, height))).all(axis=1))]
    return int(np.isfinite(frame.depth[pixel[:, 1], pixel[:, 0]]).sum())


def _rows(table: Postures, times: Floats) -> Ints:
    """(T,) which row of a table belongs to each image; -1 for none."""
    if table.frames == len(times):
        return np.arange(len(times))
    step = float(np.median(np.diff(times))) if len(times) > 1 else 1.0
    near = np.abs(table.times[None, :] - times[:, None])
    row = near.argmin(axis=1)
    return np.where(near[np.arange(len(times)), row] <= _HALF * step, row, -1)


def _chosen(frames: int, tables: Mapping[str, Postures], rows: Mapping[str, Ints]) -> list[int]:
    """Frames spread evenly, and those in which the joints are least sure or not there."""
    chosen = set(np.unique(np.linspace(0, frames - 1, min(frames, SHOWN)).astype(int)).tolist())
    for name, table in tables.items():
        if table.std is None:
            continue
        unsure = np.where(rows[name] >= 0, np.nan_to_num(table.std.max(axis=1), nan=np.inf)[rows[name]], -np.inf)
        added = 0
        for number in np.argsort(-unsure, kind="stable").tolist():
            if added == WORST or unsure[number] == -np.inf:
                break
            if all(abs(number - other) >= _APART for other in chosen):
                chosen.add(number)
                added += 1
    return sorted(chosen)
