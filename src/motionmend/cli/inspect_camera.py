"""What `inspect` finds in recordings of depth cameras and in joints over time."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import Floats
from ..errors import counted

if TYPE_CHECKING:
    from ..bodies.postures import Postures

LOOKED_AT = 60  # depth images, spread evenly over the recording
_NEAR, _FAR = 0.3, 15.0  # m; most depth sensors see nothing beyond
FAST = 15.0  # m/s; no joint of a person goes so fast


def depth_facts(path: Path) -> dict[str, Any]:
    """Facts about a depth folder or a depth file; at most 60 of its images are read.

    Raises
    ------
    FileError : it is not what it should be.
    """
    from ..io.depth import read_depth

    recording = read_depth(path)
    numbers = np.unique(np.linspace(0, recording.frames - 1, min(recording.frames, LOOKED_AT)).astype(int))
    images = [recording.frame(int(number)).depth for number in numbers]
    present = np.array([np.isfinite(image).mean() for image in images])
    some = np.concatenate([image[np.isfinite(image)][::17] for image in images])
    span: list[float] = np.quantile(some, (0.01, 0.99)).tolist() if some.size else []
    camera = recording.camera
    warnings = [*recording.warnings, *_lapses(recording.times)]
    empty = int((present == 0).sum())
    if empty:
        warnings.append(f"{empty} of {len(numbers)} depth images looked at hold no return at all")
    if span and (span[1] < _NEAR or span[0] > _FAR):
        warnings.append(f"depths go from {span[0]:.3g} to {span[1]:.3g} m: is depth_scale right?")
    return {
        "input": path,
        "kind": "depth",
        "format": "folder" if path.is_dir() else "mat",
        "fps": recording.fps,
        "frames": recording.frames,
        "duration": float(recording.times[-1] - recording.times[0]) + 1 / recording.fps,
        "units": {"length": "m", "duration": "s", "camera": "px"},
        "camera": {name: getattr(camera, name) for name in ("width", "height", "fx", "fy", "cx", "cy")},
        "color": recording.has_color,
        "depth_range": span or None,
        "looked_at": len(numbers),
        "share_missing": float(1 - present.mean()),
        "missing": {},
        "jumps": [],
        "suspicious": [],
        "warnings": warnings,
        "guesses": recording.guesses,
    }


def joint_facts(path: Path, fps: float | None) -> dict[str, Any]:
    """Facts about joints over time: a table of joints, or what a sensor reports.

    Raises
    ------
    FileError : it is not what it should be.
    """
    from ..io.joint_table import read_joint_table
    from ..io.sensor import kind_of, read_postures
    from ..io.truth import read_truth
    from .findings import leaps, listed

    kind = kind_of(path)
    if kind == "joints":
        postures = read_joint_table(path)
    elif kind in ("uiprmd markers", "keraal bodies"):
        postures = read_truth(path, fps=fps)
    else:
        postures = read_postures(path, fps=fps)
    present = postures.present
    share = 1.0 - present.mean(axis=0) if postures.frames else np.zeros(len(postures.names))
    beside = [name for name in ("std", "reliability", "state") if getattr(postures, name) is not None]
    warnings = [*postures.warnings, *_lapses(postures.times)]
    nobody = int((~present.any(axis=1)).sum())
    if nobody:
        warnings.append(f"{counted(nobody, 'frame')} without any joint")
    rate = float(f"{postures.fps:.7g}") if np.isfinite(postures.fps) else None  # times in files are rounded
    return {
        "input": path,
        "kind": "joints",
        "format": path.suffix.lower().removeprefix("."),
        "fps": rate,
        "frames": postures.frames,
        "duration": float(postures.times[-1] - postures.times[0]) + (1 / rate if rate else 0.0),
        "units": {"length": "m", "duration": "s"},
        "joints": postures.names,
        "beside": beside,
        **_sensed(postures),
        "share_missing": float(1 - present.mean()) if present.size else 0.0,
        "missing": dict(zip(postures.names, share.tolist(), strict=True)),
        "jumps": listed(leaps(postures.names, postures.positions, postures.times, FAST)),
        "suspicious": _fast(postures.names, postures.positions, postures.times),
        "warnings": warnings,
        "guesses": postures.guesses,
    }


def _sensed(postures: "Postures") -> dict[str, Any]:
    """What the recording is, how much of it was inferred, how its bones vary, and where sides change places."""
    from ..bodies.sensed import bone_variation, side_changes

    names, lengths, variation = bone_variation(postures)
    seen = np.isfinite(variation)
    state = postures.state
    return {
        "sensor": getattr(postures.source, "kind", None),
        "share_inferred": None if state is None else float((state == 1).mean()),
        "share_not_tracked": None if state is None else float((state == 0).mean()),
        "bone_variation": float(np.median(variation[seen])) if seen.any() else None,
        "bones": {
            name: {"length": float(length), "variation": float(share)}
            for name, length, share in zip(names, lengths, variation, strict=True)
            if np.isfinite(share)
        },
        "swaps": side_changes(postures),
    }


def _lapses(times: Floats) -> list[str]:
    """Sentences about steps in time that are far from the usual one."""
    if len(times) < 3:
        return [f"{len(times)} frame: nothing moves in it"] if len(times) < 2 else []
    steps = np.diff(times)
    usual = float(np.median(steps))
    long = int((steps > 1.5 * usual).sum())
    back = int((steps <= 0).sum())
    said = []
    if long:
        longer = f"{counted(long, 'step')} in time longer than 1.5 frames, up to {steps.max():.3g} s"
        said.append(f"{longer}: frames were dropped")
    if back:
        said.append(f"{counted(back, 'step')} in time not forward")
    return said


def _fast(names: tuple[str, ...], positions: Floats, times: Floats) -> list[dict[str, str]]:
    """Joints that go faster than people do."""
    step = np.diff(times)
    with np.errstate(divide="ignore", invalid="ignore"):
        speed = np.linalg.norm(np.diff(positions, axis=0), axis=2) / np.where(step > 0, step, np.nan)[:, None]
    found = []
    for j, name in enumerate(names):
        fast = speed[:, j] > FAST
        if fast.any():
            most = float(np.nanmax(speed[:, j]))
            detail = f"{counted(int(fast.sum()), 'frame')}, {most:.0f} m/s"
            found.append({"name": name, "what": "extreme speed", "detail": detail})
    return found
