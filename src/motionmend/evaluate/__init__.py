"""Spoil recordings on purpose and measure how close another recording comes to the truth."""

from .corrupt import Corrupted, corrupt
from .joints import JointComparison, compare_joints
from .metrics import Comparison, body_channels, bone_drift, compare, jitter, position_error, rms_angle

__all__ = [
    "Comparison",
    "Corrupted",
    "JointComparison",
    "body_channels",
    "bone_drift",
    "compare",
    "compare_joints",
    "corrupt",
    "jitter",
    "position_error",
    "rms_angle",
]
