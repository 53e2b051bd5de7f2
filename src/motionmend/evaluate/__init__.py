"""Spoil recordings on purpose and measure how close another recording comes to the truth."""

from .corrupt import Corrupted, corrupt
from .joints import JointComparison, compare_joints
from .metrics import Comparison, body_channels, bone_drift, compare, jitter, position_error, rms_angle
from .skeletons import SkeletonComparison, compare_skeletons

__all__ = [
    "Comparison",
    "Corrupted",
    "JointComparison",
    "SkeletonComparison",
    "body_channels",
    "bone_drift",
    "compare",
    "compare_joints",
    "compare_skeletons",
    "corrupt",
    "jitter",
    "position_error",
    "rms_angle",
]
