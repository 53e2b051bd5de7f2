"""The tracking room: one body followed through one depth and colour stream (section 3 of the dissertation)."""

from importlib import import_module
from typing import Any

_HOME = {
    "Estimate": "tracker",
    "TrackSettings": "settings",
    "TrackState": "tracker",
    "Tracked": "recording",
    "TrackerModel": "model",
    "empty_scene": "foreground",
    "follow": "recording",
    "measure_person": "measure",
    "pose_from_joints": "first_pose",
    "settings_of": "settings",
    "start": "tracker",
    "step": "tracker",
}

__all__ = list(_HOME)


def __getattr__(name: str) -> Any:
    # the room is opened when something in it is first used: a command's help needs none of it
    if name in _HOME:
        return getattr(import_module(f".{_HOME[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
