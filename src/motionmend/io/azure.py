"""Azure Kinect bodies in JSON, as the offline processor of the body tracking samples writes them.

`joint_names`, `bone_list` and `frames`, each with `timestamp_usec` and `bodies`: `body_id`, `joint_positions` (mm;
x right, y down, z forward) and, from some recorders, confidence levels (0 none, 1 low, 2 medium,
3 high) under one key or another. Source:
microsoft/Azure-Kinect-Samples, body-tracking-samples/offline_processor.
"""

import json
import os
from typing import Any

import numpy as np

from ..arrays import Bytes, Floats
from ..bodies.joint_sets import AZURE32
from ..bodies.postures import Postures
from ..errors import FileError, counted
from .number_rows import unpacked
from .sensor_source import SensorSource, even_times, seconds_of, spread_states, with_absent
from .several_bodies import Body, one_person

WANTED = "Azure Kinect bodies in JSON"
_MM = 1e-3


def read_azure(path: str | os.PathLike[str], fps: float | None = None) -> Postures:
    """Read the person who is seen longest; frames without them are empty.

    Parameters
    ----------
    path : the .json.
    fps : Hz, of a file without time stamps; 30 when not given.

    Raises
    ------
    FileError : not there, not such a file, cut off, or nobody in it.
    """
    name = str(path)
    try:
        content = json.loads(unpacked(path, WANTED))
    except ValueError as failure:
        raise FileError(
            f"{name}: wanted {WANTED}, this is no whole JSON text ({failure}); get a complete copy"
        ) from None
    if not starts_as_azure(content):
        raise FileError(f"{name}: wanted {WANTED} with `frames` that hold `bodies`; check the file")
    try:
        return _postures(content, name, fps)
    except KeyError as lacking:
        raise FileError(f"{name}: wanted {WANTED}, a frame or body lacks {lacking}; repair it") from None
    except (TypeError, ValueError, AttributeError, OverflowError) as failure:
        raise FileError(f"{name}: wanted {WANTED}, a frame is not as it should be ({failure!r}); repair it") from None


def starts_as_azure(content: Any) -> bool:
    """Whether a JSON value is the offline processor's."""
    if not isinstance(content, dict) or not isinstance(content.get("frames"), list):
        return False
    frames = content["frames"]
    known = not frames or any(isinstance(frame, dict) and "bodies" in frame for frame in frames)
    return known and all(isinstance(frame, dict) and isinstance(_bodies(frame), list) for frame in frames)


def _bodies(frame: dict[str, Any]) -> Any:
    """The bodies of a frame; where it holds none, some recorders leave them out."""
    return frame.get("bodies") if frame.get("num_bodies", 0) or frame.get("bodies") is not None else []


def _postures(content: dict[str, Any], name: str, fps: float | None) -> Postures:
    frames = [{**frame, "bodies": _bodies(frame)} for frame in content["frames"]]
    names = tuple(str(one) for one in content.get("joint_names", AZURE32.names))
    if not any(one["bodies"] for one in frames):
        raise FileError(f"{name}: wanted a body in some frame, the file holds none in {counted(len(frames), 'frame')}")
    warnings: tuple[str, ...] = ()
    guesses: tuple[str, ...] = ()
    if any("timestamp_usec" in one for one in frames):
        stamps = np.array([one.get("timestamp_usec", np.nan) for one in frames], dtype=np.float64)
        times, _, warnings = seconds_of(stamps, "microseconds")
    else:
        times, guesses = even_times(len(frames), fps)
    bodies = [
        [Body(body.get("body_id", k), _places(body, len(names), t, name)) for k, body in enumerate(one["bodies"])]
        for t, one in enumerate(frames)
    ]
    chosen, said = one_person(bodies, times)
    positions = np.full((len(frames), len(names), 3), np.nan)
    confidence = np.zeros((len(frames), len(names)))
    stated = False
    for frame in np.flatnonzero(chosen >= 0).tolist():
        positions[frame] = bodies[frame][chosen[frame]].positions
        one = frames[frame]["bodies"][chosen[frame]]
        levels = next((one[key] for key in one if "confidence" in key and isinstance(one[key], list)), None)
        if levels is not None:
            confidence[frame] = np.array(levels, dtype=np.float64).reshape(len(names))  # some wrap each in a list
            stated = True
    state: Bytes | None = np.clip(confidence, 0, 2).astype(np.uint8) if stated else None
    positions, nowhere = with_absent(positions, state)
    skipped = [int(one["num_bodies"]) - len(one["bodies"]) for one in frames if "num_bodies" in one]
    if any(skipped):
        warnings = (*warnings, f"{sum(map(bool, skipped))} frames hold fewer bodies than they promise")
    return Postures(
        names,
        positions,
        times,
        state=spread_states(np.isfinite(positions[:, :, 0]), state),
        source=SensorSource("Azure Kinect joints"),
        guesses=(*guesses, *said),
        warnings=(*warnings, *nowhere),
    )


def _places(body: dict[str, Any], joints: int, frame: int, name: str) -> Floats:
    """(J, 3) m of a body in a frame."""
    values = np.array(body["joint_positions"], dtype=np.float64)
    if values.shape != (joints, 3):
        raise FileError(f"{name}: wanted {joints} joints in frame {frame}, came {values.shape}; repair it")
    return np.asarray(values * _MM)
