"""The tracking room: one body followed through one depth and colour stream (section 3 of the dissertation)."""

from ..rooms import opened_late

_HOME = {
    "Estimate": "outcome",
    "TrackSettings": "settings",
    "TrackState": "state",
    "Tracked": "recording",
    "TrackerModel": "model",
    "empty_scene": "person.foreground",
    "follow": "recording",
    "measure_person": "measure.first_seconds",
    "pose_from_joints": "starting.first_pose",
    "settings_of": "settings",
    "start": "tracker",
    "step": "tracker",
    "told_beforehand": "person.company",
}

__all__ = list(_HOME)

__getattr__ = opened_late(__name__, _HOME)
