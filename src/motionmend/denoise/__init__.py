"""The denoising room: clean clips teach it, spoiled recordings come out repaired (section 2 of the dissertation)."""

from importlib import import_module
from typing import Any

_HOME = {
    "CLASSIC_METHODS": "model",
    "MODEL_FREE_METHODS": "model",
    "METHODS": "model",
    "Denoiser": "model",
    "DenoiserModel": "model",
    "repair_without_model": "model",
    "FixedLag": "fixed_lag",
    "repair_with_lag": "fixed_lag",
}

__all__ = list(_HOME)


def __getattr__(name: str) -> Any:
    # the room is opened when something in it is first used: a command's help needs none of it
    if name in _HOME:
        return getattr(import_module(f".{_HOME[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
