"""The page's tables: readable without a script, every name escaped."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from html import escape
from typing import Any

import numpy as np

from ..arrays import Floats, Ints
from ..bodies.motion import Markers, Motion, Origin, Repaired
from ..errors import MismatchError
from .edges import are_joints
from .payload import Named, states, stride

_SHOWN = 10  # channels in the short table
WORDS = {
    Origin.MEASURED: "measured",
    Origin.REPAIRED: "repaired",
    Origin.FILLED: "filled",
    Origin.LEFT_OPEN: "left open",
}


@dataclass(frozen=True)
class Change:
    """How far one channel or marker moved between two recordings.

    Attributes
    ----------
    rms, largest : rad or m over the samples both have, NaN where there is none.
    frame : where the largest change is.
    """

    rms: float
    largest: float
    frame: int


def changes(one: Motion | Markers, other: Motion | Markers) -> list[Change]:
    """One `Change` per channel (joint angles and lengths) or marker (distance) of two recordings alike."""
    apart = _apart(one, other)
    found = []
    for column in apart.T:
        there = np.isfinite(column)
        if there.any():
            frame = int(np.argmax(np.where(there, column, -1.0)))
            found.append(Change(float(np.sqrt(np.mean(column[there] ** 2))), float(column[frame]), frame))
        else:
            found.append(Change(float("nan"), float("nan"), 0))
    return found


def counts_line(repaired: Repaired[Any] | None) -> str:
    """The page's headline: how many samples were measured, repaired, filled and left open."""
    if repaired is None:
        return ""
    counts = repaired.counts()
    total = max(1, repaired.origin.size)
    parts = [
        f'<li class="{o.name.lower()}"><b>{counts[o.name.lower()]:,}</b> {WORDS[o]} '
        f"<small>{_percent(counts[o.name.lower()] / total)}</small></li>"
        for o in Origin
    ]
    return f'<ul class="counts" aria-label="samples by origin">{"".join(parts)}</ul>'


def recordings_table(named: Sequence[Named], colours: Sequence[int]) -> str:
    """One row per recording: kind, frames, rate, duration, channels, share missing."""
    rows = []
    for (name, recording), colour in zip(named, colours, strict=True):
        missing = 1.0 - float(recording.present.mean()) if recording.present.size else 0.0
        rows.append(
            f'<tr><th scope="row"><i class="swatch c{colour}"></i>{escape(name)} '
            f"<small>{len(recording.channels)} {_word(recording)}s</small></th>"
            f"<td>{recording.frames:,}</td><td>{recording.fps:g} Hz</td>"
            f"<td>{(recording.frames - 1) / recording.fps:.2f} s</td><td>{_percent(missing)}</td></tr>"
        )
    head = _head("recording", "frames", "rate", "length", "missing")
    return f'<div class="wide"><table class="numbers">{head}<tbody>{"".join(rows)}</tbody></table></div>'


def facts_table(
    named: Sequence[Named],
    repaired: Repaired[Any] | None,
    facts: Mapping[str, str],
    blocks: Sequence[Mapping[str, Any]],
) -> str:
    """What was done and how, then the caller's own facts, then how finely the page draws."""
    rows: list[tuple[str, str]] = []
    if repaired is not None:
        rows.append(("method", repaired.method))
        if repaired.iterations:
            rows.append(("iterations", f"{repaired.iterations}{'' if repaired.converged else ', not converged'}"))
        if repaired.cost.size > 1:
            rows.append(("cost", f"{repaired.cost[0]:.4g} to {repaired.cost[-1]:.4g}"))
    rows += facts.items()
    rows.append(("stored in steps of", _steps(blocks)))
    drawn: dict[str, list[str]] = {}
    for name, recording in named:
        if (step := stride(recording)) > 1:
            drawn.setdefault(
                f"one frame in {step}, {recording.fps / step:.3g} a second. Marks and strips show the worst state "
                f"among each {step} frames; tables count every frame.",
                [],
            ).append(name)
    rows += [(f"drawn of {', '.join(names)}", how) for how, names in drawn.items()]
    body = "".join(f'<tr><th scope="row">{escape(k)}</th><td>{escape(v)}</td></tr>' for k, v in rows)
    return f'<table class="facts"><tbody>{body}</tbody></table>'


def warnings_card(named: Sequence[Named], repaired: Repaired[Any] | None) -> str:
    """What may be wrong with the files, and what the repair warns of; empty when there is nothing."""
    lines = _of_files([(name, recording.warnings) for name, recording in named])
    return _card("Warnings", lines + ([] if repaired is None else [escape(w) for w in repaired.warnings]))


def guesses_card(named: Sequence[Named]) -> str:
    """What the files did not say and their readers supposed, each once; empty when there is nothing."""
    lines = _of_files([(name, recording.guesses) for name, recording in named])
    return _card("Supposed, for want of a word in the files", lines)


def _of_files(said: Sequence[tuple[str, tuple[str, ...]]]) -> list[str]:
    """Each sentence once, with the names of the files of which it is said."""
    names: dict[str, list[str]] = {}
    for name, sentences in said:
        for sentence in sentences:
            names.setdefault(sentence, []).append(name)
    return [f"{escape(sentence)} <small>({escape(', '.join(of))})</small>" for sentence, of in names.items()]


def _card(title: str, lines: Sequence[str]) -> str:
    items = "".join(f"<li>{line}</li>" for line in lines)
    return f'<section class="card"><h2>{title}</h2><ul class="warnings">{items}</ul></section>' if lines else ""


def channel_tables(
    named: Sequence[Named], repaired: Repaired[Any] | None, pair: tuple[int, int] | None, shown: int
) -> str:
    """The most changed channels and, folded, all channels with their counts.

    Parameters
    ----------
    pair : indices of the recordings compared, None when there are not two alike.
    shown : index of the recording whose counts are given.
    """
    recording = named[shown][1]
    word = _word(recording)
    table = _ChannelTable(recording, shown, _counts(recording, repaired))
    channels = list(range(len(recording.channels)))
    parts = []
    if pair is not None:
        found = changes(named[pair[0]][1], named[pair[1]][1])
        table = replace(table, changes=found)
        order = sorted((c for c in channels if found[c].rms > 0), key=lambda c: (-found[c].rms, c))[:_SHOWN]
        equal = "<p>The two are equal wherever both have a sample.</p>"
        what = f"from {escape(named[pair[0]][0])} to {escape(named[pair[1]][0])}"
        parts.append(
            f'<section class="card"><h2>Most changed {word}s <small>{what}</small></h2>'
            f"{table.html(order, measured=False) if order else equal}</section>"
        )
    parts.append(
        f'<details class="card"><summary><h2>All {len(channels)} {word}s '
        f"<small>of {escape(named[shown][0])}</small></h2></summary>{table.html(channels)}</details>"
    )
    return "".join(parts)


def _word(recording: Motion | Markers) -> str:
    """What one of its channels is called."""
    if isinstance(recording, Markers):
        return "joint" if are_joints(recording.names) else "marker"
    return "channel"


def _counts(recording: Motion | Markers, repaired: Repaired[Any] | None) -> dict[str, Ints]:
    """How many samples of each channel (C,) are in each state, by the column's heading; measured last."""
    origin = states(recording, repaired)
    count = {o: np.asarray((origin == o).sum(axis=0)) for o in Origin}
    if repaired is None:
        return {"missing": count[Origin.LEFT_OPEN], "measured": count[Origin.MEASURED]}
    return {
        "repaired": count[Origin.REPAIRED],
        "filled": count[Origin.FILLED],
        "open": count[Origin.LEFT_OPEN],
        "measured": count[Origin.MEASURED],
    }


@dataclass(frozen=True, eq=False)
class _ChannelTable:
    """A table with one row per channel; its buttons tell the player where to go."""

    recording: Motion | Markers
    index: int
    counts: Mapping[str, Ints]
    changes: Sequence[Change] | None = None

    def html(self, channels: Sequence[int], *, measured: bool = True) -> str:
        """The rows of `channels` in that order, with all counts, or without the measured ones and columns of zeros."""
        counts = {k: v for k, v in self.counts.items() if measured or (k != "measured" and v[list(channels)].any())}
        head = _head("name", *(["RMS", "largest"] if self.changes is not None else []), *counts)
        rows, names = [], _of_one_subject(self.recording.channels)
        for c in channels:
            cells = [f'<th scope="row">{self._jump(c, escape(names[c]))}</th>']
            cells += self._change(c)
            cells += [f"<td>{int(n[c]):,}</td>" if n[c] else '<td class="none">0</td>' for n in counts.values()]
            rows.append(f"<tr>{''.join(cells)}</tr>")
        return f'<div class="wide"><table class="numbers">{head}<tbody>{"".join(rows)}</tbody></table></div>'

    def _change(self, channel: int) -> list[str]:
        if self.changes is None:
            return []
        change = self.changes[channel]
        if not np.isfinite(change.rms):
            return ["<td>no pair</td>", "<td></td>"]
        rms, largest = (_measured(self.recording, channel, size) for size in (change.rms, change.largest))
        return [f"<td>{rms}</td>", f"<td>{self._jump(channel, largest, change.frame)}</td>"]

    def _jump(self, channel: int, text: str, frame: int | None = None) -> str:
        there = "" if frame is None else f' data-frame="{frame}" title="go to frame {frame}"'
        place = f'data-recording="{self.index}" data-channel="{channel}"'
        return f'<button type="button" class="jump" {place}{there}>{text}</button>'


def _of_one_subject(names: Sequence[str]) -> Sequence[str]:
    """Names without the subject's before the colon, where all have the same: it takes the columns' room."""
    subjects = {name.rpartition(":")[0] for name in names}
    return [name.rpartition(":")[2] for name in names] if len(subjects) == 1 else names


def _apart(one: Motion | Markers, other: Motion | Markers) -> Floats:
    """(T, C) distance between the samples of two recordings alike, rad or m."""
    if isinstance(one, Markers) and isinstance(other, Markers):
        return np.asarray(np.linalg.norm(one.positions - other.positions, axis=2))
    if isinstance(one, Motion) and isinstance(other, Motion):
        return np.abs(one.q - other.q)
    raise MismatchError("only two motions or two recordings of markers can be compared sample by sample")


def _measured(recording: Motion | Markers, channel: int, size: float) -> str:
    """Degrees of so many rad, or millimetres of so many metres; from a metre on metres."""
    if isinstance(recording, Motion) and recording.skeleton.dof_kind[channel] == 0:
        return f"{np.degrees(size):.3g}°"
    return f"{1000.0 * size:.3g} mm" if size < 1.0 else f"{size:.3g} m"


def _steps(blocks: Sequence[Mapping[str, Any]]) -> str:
    """The coarsest steps of positions and angles, as the page states them."""
    length = max(max(b["positions"]["step"], default=0.0) for b in blocks) * 1000
    said = f"{length:.3g} mm"
    turns = [s for b in blocks if "values" in b for s, a in zip(b["values"]["step"], b["angular"], strict=True) if a]
    return f"{said} and {np.degrees(max(turns)):.2g}°" if turns else said


def _head(*columns: str) -> str:
    return f"<thead><tr>{''.join(f'<th scope=col>{escape(c)}</th>' for c in columns)}</tr></thead>"


def _percent(share: float) -> str:
    if 0 < share < 0.001:
        return "&lt;0.1%"
    return f"{share:.1%}" if share < 0.9995 or share == 1 else "&gt;99.9%"
