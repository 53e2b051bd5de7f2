"""C3D files that tests share: real ones by name, made-up markers and repairs, and what other readers say of a file."""

import warnings
from pathlib import Path

import ezc3d
import numpy as np

from motionmend.bodies.motion import Markers, Origin, Repaired

FILES = (
    "cmu_02_01",
    "cmu_02_05",
    "cmu_05_13",
    "cmu_135_02",
    "emory_SoccerHeader",
    "gt_squat",
    "hdm05_bd_01-02_01_120",
    "hdm05_bd_05-01_01_120",
    "sfu_0005_SideSkip001",
    "sfu_0018_Moonwalk001",
)
STORES_INTEGERS = "cmu_05_13"
PY_C3D_REFUSES = ("cmu_05_13",)  # "inconsistent analog rate": it asks for a rate of channels that are not there
SHORT = ("cmu_02_01", "cmu_05_13", "emory_SoccerHeader", "sfu_0005_SideSkip001")


def real(data: Path, name: str) -> Path:
    return data / "mocap" / "c3d" / f"{name}.c3d"


def markers(positions: np.ndarray, fps: float = 100.0, **other) -> Markers:
    return Markers(tuple(f"M{k}" for k in range(positions.shape[1])), positions, fps, **other)


def some_markers(rng: np.random.Generator, frames: int = 20, count: int = 5) -> Markers:
    positions = rng.normal(size=(frames, count, 3)) * 0.3 + [0.0, 0.0, 1.0]
    positions[rng.random((frames, count)) < 0.1] = np.nan
    return markers(positions)


def repaired(recording: Markers, origin: np.ndarray, method: str = "paper") -> Repaired[Markers]:
    shape = origin.shape
    return Repaired(recording, origin, np.zeros(shape), np.ones(shape), method)


def gap_and_fill(source: Markers, rng: np.random.Generator) -> tuple[Markers, Repaired[Markers]]:
    """A made-up repair: gaps filled, some samples replaced, some left open; every other sample moved by a hair."""
    positions = source.positions + rng.normal(size=source.positions.shape) * 1e-4
    origin = np.where(source.present, Origin.MEASURED, Origin.FILLED)
    origin[rng.random(origin.shape) < 0.01] = Origin.REPAIRED
    origin[5:9, 1] = Origin.LEFT_OPEN
    positions[~np.isfinite(positions)] = 0.5
    positions[origin == Origin.LEFT_OPEN] = np.nan
    changed = source.with_positions(positions)
    return changed, repaired(changed, origin)


def values_of(c3d: ezc3d.c3d, group: str, name: str) -> np.ndarray:
    """An INTEGER or REAL parameter as ezc3d gives it, with its continuations, 16 bits without sign."""
    parts, k = [], 1
    while (title := name if k == 1 else f"{name}{k}") in c3d["parameters"][group]:
        parts.append(np.atleast_2d(c3d["parameters"][group][title]["value"]))
        k += 1
    return np.concatenate(parts, axis=1).astype(np.int64) % 65_536


def py_c3d(path: Path) -> np.ndarray:
    """(T, P, 5) of the second reader: x, y, z in the file's unit, residual, cameras."""
    import c3d

    with warnings.catch_warnings(), path.open("rb") as handle:
        warnings.simplefilter("ignore")
        return np.array([points for _, points, _ in c3d.Reader(handle).read_frames()])


def written_by_ezc3d(path: Path, points: np.ndarray, labels: list[str], unit: str = "mm", **lists: list[str]) -> Path:
    """A file from the other library; (T, P, 3) points in its unit."""
    c3d = ezc3d.c3d()
    c3d["parameters"]["POINT"]["UNITS"]["value"] = [unit]
    c3d["parameters"]["POINT"]["RATE"]["value"] = [100.0]
    c3d["parameters"]["POINT"]["LABELS"]["value"] = labels[:255]
    if len(labels) > 255:
        c3d.add_parameter("POINT", "LABELS2", labels[255:])
    for name, listed in lists.items():
        c3d.add_parameter("POINT", name, listed)
    four = np.ones((4, points.shape[1], points.shape[0]))
    four[:3] = points.T
    c3d["data"]["points"] = four
    c3d.write(str(path))
    return path
