"""What the page's script is given: recordings packed small, with their bones, channels and provenance."""

from collections.abc import Sequence
from math import isclose
from typing import Any

import numpy as np

from ..arrays import Bytes, Floats
from ..bodies.joint_sets import parents
from ..bodies.motion import Markers, Motion, Origin, Repaired
from ..bodies.skeleton import positions
from .edges import are_joints, rigid_edges
from .packed import pack, pack_bytes

Named = tuple[str, Motion | Markers]

SHORT = 3600  # frames up to which every frame is drawn
SMOOTH = 60.0  # Hz, the rate a longer recording is drawn at, at most
MOST = 36000  # frames drawn of one recording, at most (10 minutes at 60 Hz)
_FLOOR = 0.25  # m, a lowest point this near the height 0 means that 0 is the floor


def payload(named: Sequence[Named], repaired: Repaired[Any] | None, before: int | None) -> dict[str, Any]:
    """The JSON object the page is drawn from.

    Parameters
    ----------
    named : recordings with their names; where `repaired` is given, its recording is one of them.
    repaired : the repair whose provenance is shown.
    before : index of the recording that was repaired.
    """
    after = index_of(named, repaired)
    points = [points_of(recording) for _, recording in named]
    edges = _marker_edges(named, points, after)
    colours = _colours(len(named), after, before)
    return {
        "reference": after if after is not None else 0,
        "ground": _ground(named, points),
        "recordings": [
            _recording(name, recording, points[i], edges.get(recording.channels, []))
            | {"colour": colours[i], "repaired": i == after, "before": i == before}
            | _provenance(recording, repaired if i == after else None)
            for i, (name, recording) in enumerate(named)
        ],
    }


def index_of(named: Sequence[Named], repaired: Repaired[Any] | None) -> int | None:
    """Where the repair's own recording stands in the list."""
    if repaired is None:
        return None
    return next((i for i, (_, recording) in enumerate(named) if recording is repaired.recording), None)


def stride(recording: Motion | Markers) -> int:
    """Every which frame is drawn: 1 up to 3,600 frames, then at most 60 a second and 36,000 in all."""
    if recording.frames <= SHORT:
        return 1
    return max(1, int(np.ceil(recording.fps / SMOOTH - 1e-9)), -(-recording.frames // MOST))


def states(recording: Motion | Markers, repaired: Repaired[Any] | None) -> Bytes:
    """(T, C) of `Origin`; without a repair a sample is MEASURED or, where it is missing, LEFT_OPEN."""
    if repaired is not None:
        return repaired.origin
    return np.where(recording.present, Origin.MEASURED, Origin.LEFT_OPEN).astype(np.uint8)


def _recording(name: str, recording: Motion | Markers, points: Floats, edges: list[list[int]]) -> dict[str, Any]:
    """Everything about one recording that does not depend on a repair."""
    step = stride(recording)
    drawn = points[::step]
    common = {
        "name": name,
        "fps": recording.fps,
        "frames": recording.frames,
        "stride": step,
        "channels": list(recording.channels),
        "positions": pack(drawn.reshape(len(drawn), -1)),
    }
    if isinstance(recording, Markers):
        return common | {
            "kind": "markers",
            "points_are": "joints" if are_joints(recording.names) else "markers",
            "view": _view(recording.up).tolist(),
            "points": list(recording.names),
            "lines": edges,
        }
    skeleton = recording.skeleton
    return common | {
        "kind": "motion",
        "view": _view(skeleton.up).tolist(),
        "points": list(skeleton.names),
        "lines": [[int(p), j] for j, p in enumerate(skeleton.parents) if p >= 0],
        "channelPoint": skeleton.dof_joint.tolist(),
        "angular": (skeleton.dof_kind == 0).tolist(),
        "values": pack(recording.q[::step]),
    }


def _provenance(recording: Motion | Markers, repaired: Repaired[Any] | None) -> dict[str, Any]:
    """Where each drawn sample comes from, the worst of the frames it stands for, and how sure the repair is."""
    step = stride(recording)
    origin = states(recording, repaired)
    worst = np.maximum.reduceat(origin, np.arange(0, len(origin), step), axis=0)  # Origin rises with severity
    std = None if repaired is None else pack(repaired.std[::step])
    return {"state": pack_bytes(worst), "std": std}


def points_of(recording: Motion | Markers) -> Floats:
    """(T, P, 3) m: what is drawn of a recording, its markers or its joints."""
    if isinstance(recording, Markers):
        return recording.positions
    return positions(recording.skeleton, recording.q)


def _marker_edges(
    named: Sequence[Named], points: Sequence[Floats], after: int | None
) -> dict[tuple[str, ...], list[list[int]]]:
    """Lines of every set of markers, the same for all that share the names: from the repaired, else the first."""
    edges: dict[tuple[str, ...], list[list[int]]] = {}
    for i in sorted(range(len(named)), key=lambda i: i != after):
        recording = named[i][1]
        if isinstance(recording, Markers) and recording.names not in edges:
            edges[recording.names] = lines_of(recording.names, points[i])
    return edges


def lines_of(names: tuple[str, ...], points: Floats) -> list[list[int]]:
    """Bones between joints, or lines between markers of one bone: pairs of rows of `points` (T, P, 3)."""
    if are_joints(names):
        return [[int(above), joint] for joint, above in enumerate(parents(names)) if above >= 0]
    return [[int(one), int(other)] for one, other in rigid_edges(names, points)]


def _view(up: Floats) -> Floats:
    """Rotation (3, 3) from the recording's axes to the page's: rows are right, forward, up."""
    up = up / np.linalg.norm(up)
    right = np.eye(3)[0 if abs(up[0]) < 0.9 else 1]
    right = right - (right @ up) * up
    right = right / np.linalg.norm(right)
    return np.round(np.array([right, np.cross(up, right), up]), 9) + 0.0


def _ground(named: Sequence[Named], points: Sequence[Floats]) -> float:
    """Height of the floor, m: 0 where the lowest points lie near it, else the lowest percent of all points."""
    heights = []
    for (_, recording), place in zip(named, points, strict=True):
        up = recording.up if isinstance(recording, Markers) else recording.skeleton.up
        height = place @ (up / np.linalg.norm(up))
        heights.append(height[np.isfinite(height)])
    every = np.concatenate(heights)
    if not every.size:
        return 0.0
    low = float(np.percentile(every, 1))
    return 0.0 if abs(low) < _FLOOR else round(low, 3)


def _colours(count: int, after: int | None, before: int | None) -> list[int]:
    """Index into the page's palette: the repaired is blue (0), what was repaired vermillion (1)."""
    if after is None:
        return [i % 6 for i in range(count)]
    rest = iter(2 + i % 4 for i in range(count))
    return [0 if i == after else 1 if i == before else next(rest) for i in range(count)]


def index_before(named: Sequence[Named], repaired: Repaired[Any] | None) -> int | None:
    """Which recording was repaired: of those alike (kind, channels, frames, rate) the one whose gaps agree best.

    Where several agree as well, the one listed last before the repaired wins, then the first after it.
    """
    after = index_of(named, repaired)
    if repaired is None or after is None:
        return None
    was_missing = repaired.origin >= Origin.FILLED
    order = [*range(after - 1, -1, -1), *range(after + 1, len(named))]
    fit = [i for i in order if alike(named[i][1], repaired.recording)]
    return min(fit, key=lambda i: int((was_missing == named[i][1].present).sum()), default=None)


def alike(one: Motion | Markers, other: Motion | Markers) -> bool:
    """Whether two recordings can be compared sample by sample."""
    if type(one) is not type(other) or one.channels != other.channels:
        return False
    return one.frames == other.frames and isclose(one.fps, other.fps, rel_tol=1e-4)  # times are written rounded
