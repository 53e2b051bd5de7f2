"""One HTML file that plays recordings, shows where every sample comes from, and asks nothing of a network."""

import json
import re
from base64 import b64encode
from collections.abc import Mapping, Sequence
from html import escape
from importlib.resources import files
from pathlib import Path
from types import MappingProxyType
from typing import Any

from ..bodies.motion import Repaired
from ..errors import UsageError
from ..io.atomic import atomic
from .payload import Named, alike, index_before, index_of, payload
from .tables import channel_tables, counts_line, facts_table, guesses_card, recordings_table, warnings_card

Picture = tuple[str, bytes]

_SCRIPTS = ("data.js", "scene.js", "plot.js", "timeline.js", "player.js")


def html_report(
    path: str | Path,
    recordings: Sequence[Named],
    *,
    repaired: Repaired[Any] | None = None,
    facts: Mapping[str, str] = MappingProxyType({}),
    pictures: Sequence[Picture] = (),
) -> None:
    """Write a self-contained page: a 3D player, curves, the origin of every sample, and tables.

    The page holds its data (positions and angles in steps of 0.1 mm and 0.006 degrees), loads nothing and
    works from a file. Recordings may differ in kind, rate, length and axes; each keeps its own time, starting
    at 0 s. Up to 3,600 frames are all drawn; of a longer recording at most 60 frames a second and 36,000 in
    all, which the page says. The same input gives the same bytes.

    In the page, `window.report.setFrame(n)` draws frame n of the repaired (or first) recording and
    `window.report.state()` returns what is shown.

    Parameters
    ----------
    path : file to write, replaced whole or not at all.
    recordings : (name, recording) pairs in the order of the legend; up to about six stay readable.
    repaired : what a repair made. Its recording is taken as the one of `recordings` that is the same object;
        otherwise it is added at the end as "repaired". What it was made from is the recording alike whose gaps
        agree best, the nearest before it in the list.
    facts : further lines for the table of facts, e.g. the model's name.
    pictures : (words, PNG) pairs, shown below the player: what a camera saw.

    Raises
    ------
    UsageError : when there is nothing to show.
    """
    named = [(str(name), recording) for name, recording in recordings]
    if repaired is not None and index_of(named, repaired) is None:
        named.append(("repaired", repaired.recording))
    if not named:
        raise UsageError("a report needs at least one recording, came none: name the recordings to show")
    for name, recording in named:
        if recording.frames == 0:
            raise UsageError(f"a report needs frames to draw, {name!r} has none: leave it out")
    page = _page(named, repaired, facts, pictures)
    with atomic(path) as temporary:  # file names need not be UTF-8: their other bytes stand in it as on the screen
        Path(temporary).write_text(page, encoding="utf-8", errors="backslashreplace", newline="\n")


def _page(
    named: Sequence[Named], repaired: Repaired[Any] | None, facts: Mapping[str, str], pictures: Sequence[Picture]
) -> str:
    """The template with its slots filled in one pass, so that no name can be taken for a slot."""
    after, before = index_of(named, repaired), index_before(named, repaired)
    data = payload(named, repaired, before)
    blocks = data["recordings"]
    names = ", ".join(name for name, _ in named)
    pair = (before, after) if before is not None and after is not None else _first_and_last(named, repaired)
    shown = after if after is not None else len(named) - 1
    slots = {
        "title": escape(names),
        "counts": counts_line(repaired),
        "recordings": recordings_table(named, [block["colour"] for block in blocks]),
        "facts": facts_table(named, repaired, facts, blocks),
        "warnings": warnings_card(named, repaired),
        "guesses": guesses_card(named),
        "channels": channel_tables(named, repaired, pair, shown),
        "pictures": _pictures_card(pictures),
        "style": _asset("player.css"),
        "script": "".join(_asset(name) for name in _SCRIPTS),
        "data": _script_safe(json.dumps(data, ensure_ascii=True, allow_nan=False, separators=(",", ":"))),
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda slot: slots[slot[1]], _asset("player.html"))


def _pictures_card(pictures: Sequence[Picture]) -> str:
    """What a camera saw, frame by frame; empty when there is nothing."""
    figures = "".join(
        f'<figure><img alt="{escape(words)}" src="data:image/png;base64,{b64encode(png).decode("ascii")}">'
        f"<figcaption>{escape(words)}</figcaption></figure>"
        for words, png in pictures
    )
    said = "depth with its edges, the joints drawn over it, and the same from the camera's right"
    return (
        f'<section class="card"><h2>What the camera saw <small>{said}</small></h2>'
        f'<div class="seen">{figures}</div></section>'
        if pictures
        else ""
    )


def _first_and_last(named: Sequence[Named], repaired: Repaired[Any] | None) -> tuple[int, int] | None:
    """Without a repair the first recording is compared with the last, where they are alike."""
    if repaired is None and len(named) > 1 and alike(named[0][1], named[-1][1]):
        return 0, len(named) - 1
    return None


def _script_safe(text: str) -> str:
    """JSON that no HTML parser takes for the end of its script, whatever the names hold."""
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _asset(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")
