"""A person's body, .json: lengths and widths found once and used again."""

import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from ..bodies.performer import BONES, LANDMARKS, TIPS, Performer
from ..bodies.solids import Solids
from ..errors import FileError, MismatchError
from .atomic import atomic

KIND = "motionmend body"
VERSION = 1
_SOLIDS = ("bone", "kind", "center", "turn", "size", "taper")
_DIGITS = 9  # significant


def write_body(path: str | os.PathLike[str], performer: Performer) -> None:
    """Write a body; the file is whole or not there.

    Parameters
    ----------
    path : the .json.
    performer : lengths in m.

    Raises
    ------
    FileError : the file cannot be written.
    """
    solids = {name: _plain(getattr(performer.solids, name)) for name in _SOLIDS}
    facts = {
        "kind": KIND,
        "version": VERSION,
        "lengths_m": dict(zip(BONES, _plain(performer.lengths), strict=True)),
        "offsets": dict(zip(BONES, _plain(performer.offsets), strict=True)),
        "landmarks": dict(zip(LANDMARKS, _plain(performer.landmark_place), strict=True)),
        "tips": dict(zip(TIPS, _plain(performer.tip_place), strict=True)),
        "solids": solids,
    }
    entries = [f"  {json.dumps(name)}: {json.dumps(value)}" for name, value in facts.items()]
    with atomic(path) as temporary:
        temporary.write_text("{\n" + ",\n".join(entries) + "\n}\n", "utf-8")


def read_body(path: str | os.PathLike[str]) -> Performer:
    """Read a body that `write_body` wrote.

    Raises
    ------
    FileError : not there, no such file, or damaged.
    """
    name = str(path)
    try:
        facts = json.loads(Path(path).read_text("utf-8-sig"))
    except OSError as failure:
        raise FileError(f"{name}: wanted a body, cannot open it: {failure.strerror}; check the path") from None
    except ValueError:
        raise FileError(f"{name}: wanted a body as JSON, this is none; name another file with --body") from None
    if not isinstance(facts, dict) or facts.get("kind") != KIND:
        raise FileError(f"{name}: wanted a body that `motionmend track --body` wrote, came other JSON")
    if facts.get("version") != VERSION:
        raise FileError(f"{name}: wanted a body of version {VERSION}, came {facts.get('version')}: update motionmend")
    try:
        solids = Solids(*(np.array(facts["solids"][one]) for one in _SOLIDS))
        offsets, landmarks, tips = (
            np.array([facts[part][key] for key in keys], dtype=np.float64)
            for part, keys in (("offsets", BONES), ("landmarks", LANDMARKS), ("tips", TIPS))
        )
        performer = Performer(offsets, landmarks, tips, solids)
        stated = np.array([facts["lengths_m"][bone] for bone in BONES], dtype=np.float64)
    except (KeyError, TypeError, ValueError, MismatchError) as failure:
        raise FileError(f"{name}: this body is damaged ({failure}); calibrate it again without this file") from None
    if not all(np.isfinite(part).all() for part in (offsets, landmarks, tips)):
        raise FileError(f"{name}: this body has lengths that are no numbers; calibrate it again without this file")
    if not np.isin(solids.bone, range(len(BONES))).all():
        raise FileError(f"{name}: this body has solids on bones that it lacks; calibrate it again without this file")
    other = np.flatnonzero(~np.isclose(stated, performer.lengths, rtol=1e-6))
    if len(other):
        bone = BONES[other[0]]
        found = performer.lengths[other[0]]
        raise FileError(
            f"{name}: {bone} is {stated[other[0]]:g} m in lengths_m and {found:g} m by offsets and landmarks, which "
            "count: change these or neither"
        )
    return performer


def _plain(values: Any) -> Any:
    """Nested lists of numbers with 9 significant digits."""
    if isinstance(values, np.ndarray):
        return _plain(values.tolist())
    if isinstance(values, list):
        return [_plain(value) for value in values]
    return float(f"{values:.{_DIGITS}g}") if isinstance(values, float) else values
