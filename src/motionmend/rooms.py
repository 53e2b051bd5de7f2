"""How a room is opened when something in it is first used: a command's help needs none of it."""

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any


def opened_late(room: str, home: Mapping[str, str]) -> Callable[[str], Any]:
    """The `__getattr__` of a package whose names are loaded when they are asked for.

    Parameters
    ----------
    room : the package's name.
    home : the module in it that each public name lives in.
    """

    def found(name: str) -> Any:
        if name in home:
            return getattr(import_module(f".{home[name]}", room), name)
        raise AttributeError(f"module {room!r} has no attribute {name!r}")

    return found
