"""What the scripts measured, kept beside the report: a run of some claims renews theirs and leaves the rest as it was."""

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from motionmend.errors import FileError

from .common import Findings, Table

NAME = "measured.json"


def load(folder: Path) -> dict[str, Findings]:
    """Findings by script, as an earlier run into `folder` left them; none when there was none.

    Raises
    ------
    FileError : the file is there and is not what `save` writes.
    """
    path = folder / NAME
    if not path.is_file():
        return {}
    try:
        entries = json.loads(path.read_text(encoding="utf-8"))
        return {script: _findings(entry) for script, entry in entries.items()}
    except (ValueError, KeyError, TypeError, AttributeError) as problem:
        raise FileError(f"{path} was to hold earlier measurements, it does not ({problem}): remove it") from None


def save(folder: Path, found: Mapping[str, Findings]) -> None:
    """Write findings by script; the same findings give the same bytes."""
    entries = {script: asdict(findings) for script, findings in sorted(found.items())}
    (folder / NAME).write_text(json.dumps(entries, indent=1, sort_keys=True) + "\n", encoding="utf-8")


def _findings(entry: Mapping[str, Any]) -> Findings:
    return Findings(
        {name: float(value) for name, value in entry["values"].items()},
        tuple(entry["notes"]),
        tuple(Table(t["title"], tuple(t["head"]), tuple(map(tuple, t["rows"]))) for t in entry["tables"]),
        tuple((name, caption) for name, caption in entry["figures"]),
        tuple(entry["machine"]),
    )
