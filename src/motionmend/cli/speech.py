"""How a command speaks: results on stdout, all else on stderr."""

import json
import math
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ..errors import one_line


def say(line: str) -> None:
    """A line for the person in front of the terminal; it stays one whatever the names in it hold."""
    print(one_line(line), file=sys.stderr, flush=True)


def json_line(facts: Mapping[str, Any]) -> str:
    """One JSON object on one line; numbers that JSON lacks become null."""
    return json.dumps(plain(facts), allow_nan=False)


def plain(value: Any) -> Any:
    """The same with numpy's numbers and arrays as Python's, NaN and infinities as None, paths as text."""
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, str | bool | int) or value is None:
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Path):
        return str(value)
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    return [plain(entry) for entry in value]


@contextmanager
def progress(total: int) -> Iterator[Callable[[], None]]:
    """A bar on stderr while several items are worked on, when stderr is a terminal; call once for each item."""
    if total < 2 or not sys.stderr.isatty():
        yield lambda: None
        return
    from rich.console import Console
    from rich.progress import Progress

    shared = sys.stdout.isatty()  # else what goes to stdout must stay there and not come out above the bar
    with Progress(console=Console(stderr=True), transient=True, redirect_stdout=shared) as bar:
        line = bar.add_task("", total=total)
        yield lambda: bar.advance(line)
