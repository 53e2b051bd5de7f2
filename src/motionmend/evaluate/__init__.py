"""Spoil recordings on purpose and measure how close another recording comes to the truth."""

from .corrupt import Corrupted, corrupt
from .metrics import Comparison, body_channels, bone_drift, compare, jitter, position_error, rms_angle

__all__ = [
    "Comparison",
    "Corrupted",
    "body_channels",
    "bone_drift",
    "compare",
    "corrupt",
    "jitter",
    "position_error",
    "rms_angle",
]
