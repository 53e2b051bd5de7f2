"""Files as sensors' recorders write them, made from postures: the plain twins of the readers."""

import gzip
import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from motionmend.arrays import Floats
from motionmend.bodies.joint_sets import AZURE32, KINECT25, UIPRMD22, JointSet


def standing(joints: JointSet, frames: int, seed: int = 0) -> Floats:
    """(T, J, 3) m: a person-like tree of joints that sways; every bone keeps its length."""
    rng = np.random.default_rng(seed)
    bones = rng.normal(size=(len(joints.names), 3)) * [0.1, 0.2, 0.05]
    places = np.zeros((frames, len(joints.names), 3))
    done: set[int] = set()
    while len(done) < len(joints.names):
        for k, parent in enumerate(joints.parents):
            if k not in done and (parent < 0 or parent in done):
                places[:, k] = [0.1, 0.9, 2.5] if parent < 0 else places[:, parent] + bones[k]
                done.add(k)
    sway = np.sin(np.arange(frames) / 5)[:, None, None] * rng.normal(scale=0.02, size=places.shape[1:])
    return np.asarray(places + sway)


def table(
    path: Path,
    places: Floats,
    states: Floats | None,
    stamps: Sequence[float] | None,
    titles: Sequence[str] | None = None,
    separator: str = ",",
    tail: str = "",
) -> Path:
    """A Kinect table; `titles` are the joints' names in the order in which they are written above the columns."""
    lines = []
    if titles is not None:
        axes = ("X", "Y", "Z") if states is None else ("X", "Y", "Z", "tracked")
        first = [] if stamps is None else ["timestamp"]
        lines.append(separator.join([*first, *(f"{name}_{axis}" for name in titles for axis in axes)]))
    for t, row in enumerate(places):
        cells = [] if stamps is None else [repr(stamps[t])]
        for k, xyz in enumerate(row):
            cells += [repr(float(value)) for value in xyz]
            cells += [] if states is None else [str(int(states[t, k]))]
        lines.append(separator.join(cells) + tail)
    path.write_text("\n".join(lines) + "\n", "utf-8")
    return path


def ntu(path: Path, bodies: dict[str, tuple[Floats, Floats]], frames: int) -> Path:
    """An NTU .skeleton; of each body positions (T, 25, 3) and states (T, 25), not written where x of joint 0 is NaN."""
    lines = [str(frames)]
    for t in range(frames):
        there = {name: one for name, one in bodies.items() if np.isfinite(one[0][t, 0, 0])}
        lines.append(str(len(there)))
        for name, (places, states) in there.items():
            lines += [f"{name} 0 1 1 1 1 0 0.01 -0.02 2", "25"]
            for xyz, state in zip(places[t], states[t], strict=True):
                lines.append(" ".join(repr(float(v)) for v in xyz) + f" 250.1 180.2 960.3 540.4 1 0 0 0 {int(state)}")
    path.write_text("\n".join(lines) + "\n", "utf-8")
    return path


def azure(path: Path, bodies: dict[int, Floats], stamps: Sequence[int]) -> Path:
    """Azure Kinect bodies; positions (T, 32, 3) m, not written where x of joint 0 is NaN."""
    frames = []
    for t, stamp in enumerate(stamps):
        there = {name: one for name, one in bodies.items() if np.isfinite(one[t, 0, 0])}
        frames.append(
            {
                "frame_id": t,
                "timestamp_usec": stamp,
                "num_bodies": len(there),
                "bodies": [
                    {"body_id": name, "joint_positions": (1000 * one[t]).tolist(), "joint_orientations": []}
                    for name, one in there.items()
                ],
            }
        )
    content = {"k4abt_sdk_version": "1.1.0", "joint_names": list(AZURE32.names), "bone_list": [], "frames": frames}
    path.write_text(json.dumps(content, indent=4), "utf-8")
    return path


def uiprmd(folder: Path, local: Floats, angles: Floats, zipped: bool = True) -> Path:
    """UI-PRMD positions (T, 22, 3) cm and angles (T, 22, 3) degrees, in sibling folders; returns the positions."""
    for kind, values in (("positions", local), ("angles", angles)):
        under = folder / "Kinect" / kind.capitalize()
        under.mkdir(parents=True, exist_ok=True)
        text = "".join(",".join(f"{v:.6f}" for v in row) + "\n" for row in values.reshape(len(values), -1))
        name = under / f"m01_s01_e01_{kind}.txt"
        if zipped:
            name.with_name(name.name + ".gz").write_bytes(gzip.compress(text.encode()))
        else:
            name.write_text(text, "utf-8")
    end = "positions.txt.gz" if zipped else "positions.txt"
    return folder / "Kinect" / "Positions" / f"m01_s01_e01_{end}"


def places_of(local: Floats, angles: Floats) -> Floats:
    """(22, 3): one frame of UI-PRMD by homogeneous matrices, joint by joint; the plain twin of `joints_in_room`."""
    frames: list[Floats] = []
    for joint, parent in enumerate(UIPRMD22.parents):
        x, y, z = angles[joint]
        about_x = np.array([[1, 0, 0], [0, np.cos(x), -np.sin(x)], [0, np.sin(x), np.cos(x)]])
        about_y = np.array([[np.cos(y), 0, np.sin(y)], [0, 1, 0], [-np.sin(y), 0, np.cos(y)]])
        about_z = np.array([[np.cos(z), -np.sin(z), 0], [np.sin(z), np.cos(z), 0], [0, 0, 1]])
        here = np.eye(4)
        here[:3, :3] = about_z @ about_x @ about_y
        here[:3, 3] = local[joint]
        frames.append(here if parent < 0 else frames[parent] @ here)
    return np.array([frame[:3, 3] for frame in frames])


__all__ = ["KINECT25", "azure", "ntu", "places_of", "standing", "table", "uiprmd"]
