"""motionmend: recover clean, complete full-body motion from noisy, gappy and ambiguous capture.

The public face: names only. Each is loaded when first used, so that the import itself costs little.
"""

from importlib import import_module
from typing import Any

from .rooms import opened_late

__version__ = "0.1.0"

_HOME = {
    "MotionMendError": "errors",
    "FileError": "errors",
    "MismatchError": "errors",
    "UsageError": "errors",
    "Skeleton": "bodies.skeleton",
    "Motion": "bodies.motion",
    "Markers": "bodies.motion",
    "Origin": "bodies.motion",
    "Repaired": "bodies.motion",
    "Postures": "bodies.postures",
    "Camera": "bodies.camera",
    "DepthFrame": "bodies.camera",
    "read": "io",
    "read_postures": "io.sensor",
    "read_truth": "io.truth",
    "read_depth": "io.depth",
    "write": "io",
    "Denoiser": "denoise",
    "DenoiserModel": "denoise",
    "repair_without_model": "denoise",
    "Corrector": "correct",
    "CorrectorModel": "correct",
    "Pair": "correct",
    "TrackerModel": "track",
    "load_model": "models",
    "save_model": "models",
    "corrupt": "evaluate",
    "compare": "evaluate",
}

_ROOMS = ("correct", "denoise", "evaluate", "io", "report", "samples", "track")

__all__ = ["__version__", *_HOME, *_ROOMS]

_named = opened_late(__name__, _HOME)


def __getattr__(name: str) -> Any:
    if name in _ROOMS:
        return import_module(f".{name}", __name__)
    return _named(name)


def __dir__() -> list[str]:
    return sorted(__all__)
