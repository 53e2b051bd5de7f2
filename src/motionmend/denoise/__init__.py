"""The denoising room: clean clips teach it, spoiled recordings come out repaired (section 2 of the dissertation)."""

from importlib import import_module
from typing import Any

__all__ = ["CLASSIC_METHODS", "METHODS", "Denoiser", "DenoiserModel", "repair_classic"]


def __getattr__(name: str) -> Any:
    # the room is opened when something in it is first used: a command's help needs none of it
    if name in __all__:
        return getattr(import_module(".model", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
