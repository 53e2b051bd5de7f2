"""The correcting room: pairs of a sensor's postures and the truth teach it; live and recorded ones come out right."""

from importlib import import_module
from typing import Any

_HOME = {
    "METHODS": "corrector",
    "Corrected": "corrector",
    "Corrector": "corrector",
    "CorrectorModel": "corrector",
    "CorrectorState": "corrector",
    "Pair": "pairing",
    "match": "pairs",
    "strange": "pairs",
}

__all__ = list(_HOME)


def __getattr__(name: str) -> Any:
    # the room is opened when something in it is first used: a command's help needs none of it
    if name in _HOME:
        return getattr(import_module(f".{_HOME[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
