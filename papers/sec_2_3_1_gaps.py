"""Section 2.3.1: markers with real gaps

The gaps are the capture's own. Since nobody knows the truth inside a real gap, gaps of the same lengths are also cut
where the markers were seen. Bases come from what is left of the take, or from its other two thirds alone.
"""

from pathlib import Path

import numpy as np

import motionmend as mm
from motionmend.arrays import Bools

from .common import Findings, Table, distances, markers, stretch

# take, frames that are scored: the squats themselves, without the setting up before and after them
TAKES = {"skip": ("sfu_0005_SideSkip001", 0, 1085), "squat": ("gt_squat", 639, 2277)}
OWN = ("paper", "linear", "spline", "pca")
LONG, LONGEST = 24, 120  # frames at 120 Hz: gaps of 0.2 s and more are scored on their own, none is longer than 1 s
HIDDEN = 27  # gaps at a time, as many as the side skip has itself
DRAWS = 3
THIRDS = ((0.0, 1 / 3), (1 / 3, 2 / 3), (2 / 3, 1.0))
FINE = 0.999  # of the energy
NAMES = {
    "paper": "paper",
    "fine": f"paper, {100 * FINE:g} % energy",
    "thirds": "paper, bases of the other two thirds",
    "linear": "linear",
    "spline": "spline",
    "pca": "pca",
}


def run(mocap: Path, pictures: Path) -> Findings:
    """What was filled, and the error on hidden samples for each method."""
    values, tables, notes = {}, [], []
    for key, (take, first, last) in TAKES.items():
        recording = markers(mocap, take)
        repaired = mm.Denoiser().fit([recording]).repair(recording, "paper")
        counts, lengths = repaired.counts(), gap_lengths(recording.present)
        inside = repaired.std[repaired.origin == mm.Origin.FILLED]
        notes.append(
            f"{take}: {len(recording.names)} markers, {recording.frames} frames at {recording.fps:g} Hz, "
            f"{len(lengths)} real gaps of 1 to {max(lengths)} frames. Filled {counts['filled']} samples (standard deviation "
            f"{100 * np.median(inside):.1f} cm in the middle, {100 * inside.max():.1f} cm at most), left open "
            f"{counts['left_open']}, replaced as outliers {100 * counts['repaired'] / recording.present.sum():.0f} %."
            + "".join(f" Warning: {warning}." for warning in repaired.warnings)
        )
        values[f"{key}_left_open"] = float(counts["left_open"])
        scored = mm.Markers(recording.names, recording.positions[first:last], recording.fps, up=recording.up)
        errors = score(scored, lengths)
        rows = []
        for name, title in NAMES.items():
            cells = []
            for length in ("short", "long"):
                away = np.concatenate(errors[name, length])
                values[f"{key}_{name}_{length}"] = float(away.mean()) if away.size else float("nan")
                cells.append(f"{away.mean():.2f}" if away.size else "none")
            rows.append((title, *cells))
        title = f"{take}, frames {first} to {last}: mean error on hidden samples, cm"
        head = ("method", f"gaps under {LONG / 120:g} s", f"gaps of {LONG / 120:g} to {LONGEST / 120:g} s")
        tables.append(Table(title, head, tuple(rows)))
    notes.append(
        f"{HIDDEN} gaps are hidden at a time, {DRAWS} times, of lengths drawn from the take's own; at 120 Hz a spline "
        "through neighbouring frames is hard to beat in a short gap."
    )
    return Findings(values=values, notes=tuple(notes), tables=tuple(tables))


def score(recording: mm.Markers, lengths: list[int]) -> dict[tuple[str, str], list[np.ndarray]]:
    """Error in cm of every hidden sample, for each method and for short and long gaps."""
    errors: dict[tuple[str, str], list[np.ndarray]] = {}

    def note(name: str, filled: mm.Markers, truth: mm.Markers, short: Bools, long: Bools) -> None:
        for length, where in (("short", short), ("long", long)):
            errors.setdefault((name, length), []).append(distances(truth.positions, filled.positions, where))

    for draw in range(DRAWS):
        cut, short, long = with_hidden_gaps(recording, lengths, draw)
        own = mm.Denoiser().fit([cut])
        for method in OWN:
            note(method, own.repair(cut, method).recording, recording, short, long)
        note("fine", mm.Denoiser(energy=FINE).fit([cut]).repair(cut, "paper").recording, recording, short, long)
    for start, stop in THIRDS:
        positions = recording.positions.copy()
        positions[round(start * recording.frames) : round(stop * recording.frames)] = np.nan
        others = mm.Denoiser().fit([recording.with_positions(positions)])
        third = stretch(recording, start, stop)
        for draw in range(DRAWS):
            cut, short, long = with_hidden_gaps(third, lengths, draw)
            note("thirds", others.repair(cut, "paper").recording, third, short, long)
    return errors


def with_hidden_gaps(recording: mm.Markers, lengths: list[int], draw: int) -> tuple[mm.Markers, Bools, Bools]:
    """The recording with gaps like its own, and which samples (T, M) are hidden in short and in long ones."""
    rng = np.random.default_rng(draw)
    present = recording.present
    short, long, taken = np.zeros_like(present), np.zeros_like(present), ~present
    for length in sorted(np.minimum(rng.choice(lengths, HIDDEN), LONGEST), reverse=True):
        for _ in range(1000):
            marker = int(rng.integers(present.shape[1]))
            start = int(rng.integers(1, len(present) - length))
            # one sample more on both sides, so that gaps neither meet nor reach the ends
            if not taken[start - 1 : start + length + 1, marker].any():
                (long if length >= LONG else short)[start : start + length, marker] = True
                taken[start : start + length, marker] = True
                break
    hidden = (short | long)[:, :, None]
    return recording.with_positions(np.where(hidden, np.nan, recording.positions)), short, long


def gap_lengths(present: Bools) -> list[int]:
    """Lengths in frames of all gaps of all markers."""
    lengths = []
    for column in present.T:
        edges = np.flatnonzero(np.diff(np.concatenate([[0], (~column).astype(np.int8), [0]])))
        lengths.extend((edges[1::2] - edges[::2]).tolist())
    return lengths
