"""Several people in a recording, one after another: by the time nobody is there, by leaps, and by how large they are;
or at once, a row of one and then of another: by where they are.

A person's bones keep their lengths, two people's do not have the same. Live, who comes after two seconds of nobody, or
leaps as nobody can, is met as a stranger. Where all of a recording is at hand their bones tell whether it is one: in
real recordings of walkers who leave and come back the median bone of a second or more is within 10 % of the one before,
or some bones are longer and others shorter. A recorder that writes a row for everybody it sees, and not whose it is,
has somebody leap from one row to the next and back again, all the time.
"""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy.ndimage import median_filter

from ..arrays import Floats, Ints
from ..bodies.postures import Postures
from ..errors import counted, few
from ..kernels import sighting as kernel
from .anatomy import Anatomy
from .joining import joined
from .normalise import bone_lengths
from .noted import Noted
from .sight import rows_of

STRANGER_SECONDS = 2.0  # who comes after nobody was there for so long may be another
LEAST_SECONDS = 1.0  # of a person, that tell their size
LARGER, FAR_LARGER = 0.12, 0.2  # in logarithms of bones' lengths, who may be another, and who anybody else must be
TOGETHER = 0.8  # of the bones, at least, that are then longer, or shorter
FEWEST = 4  # bones that tell a size
OFTEN = 0.2  # of the steps, that leap where people take turns
MOST_PEOPLE = 6  # as many as sensors follow at once


def by_person(correct: Callable[[Postures], Postures], postures: Postures, body: Anatomy) -> Postures:
    """A recording corrected, each of the people in it on their own, and what was supposed of them.

    Parameters
    ----------
    correct : one person's recording.
    body : the model's.
    """
    rows = rows_of(joined(postures.names, body).to_model, postures.positions)
    whose = taking_turns(rows, postures.times)
    if not whose.any():
        return _one_after_another(correct, postures, rows, body)
    frames = [np.flatnonzero(whose == one) for one in range(whose.max() + 1)]
    parts = [_one_after_another(correct, _some(postures, own), rows[own], body) for own in frames]
    notes: list[Noted] = [part.source for part in parts]
    order = np.argsort(np.concatenate(frames), kind="stable")
    warnings = [f"rows of {len(parts)} people who are there at once take turns: each is corrected on their own"]
    for k, (own, note) in enumerate(zip(frames, notes, strict=True)):
        warnings += [f"person {k + 1}, from frame {own[0]} on: {one}" for one in note.warnings]
    flags = np.concatenate([one.flags for one in notes])[order]
    return replace(
        postures,
        positions=np.concatenate([one.positions for one in parts])[order],
        std=np.concatenate([np.asarray(one.std) for one in parts])[order],
        reliability=np.concatenate([np.asarray(one.reliability) for one in parts])[order],
        source=replace(notes[0], source=postures.source, flags=flags, warnings=tuple(warnings)),
    )


def taking_turns(rows: Floats, times: Floats) -> Ints:
    """(T,) the person of each frame, 0 throughout where one is seen at a time.

    Each goes with whoever of those seen so far is nearest, and with nobody from whom it would have leapt. Who is seen
    in less than a second's frames is nobody to be told apart, and then nobody is.

    Parameters
    ----------
    rows : (T, J, 3) m by the model's joints, NaN = missing.
    times : (T,) s.
    """
    rows, whose = np.ascontiguousarray(rows), np.zeros(len(rows), dtype=np.int64)
    there = np.flatnonzero(np.isfinite(rows).any(axis=(1, 2)))
    away = np.diff(times[there])
    leapt = sum(kernel.leapt(rows[b], rows[a], float(s)) for a, b, s in zip(there, there[1:], away, strict=False))
    if leapt <= OFTEN * max(len(away), 1):
        return whose
    last: list[int] = []
    for t in there.tolist():
        at_hand = [k for k, a in enumerate(last) if not kernel.leapt(rows[t], rows[a], float(times[t] - times[a]))]
        far = [float(np.nanmedian(np.square(rows[t] - rows[last[k]]))) for k in at_hand]
        own = at_hand[int(np.argmin(far))] if far else len(last)
        last[own : own + 1] = [t]
        whose[t] = own
        if len(last) > MOST_PEOPLE:
            return np.zeros_like(whose)
    least = np.bincount(whose[there], minlength=len(last)).min() * len(last) / len(there)
    told = least * float(times[there[-1]] - times[there[0]]) >= LEAST_SECONDS
    return whose if told else np.zeros_like(whose)


def _one_after_another(
    correct: Callable[[Postures], Postures], postures: Postures, rows: Floats, body: Anatomy
) -> Postures:
    """A recording in which one is seen at a time, as of `by_person`; rows (T, J, 3) by the model's joints."""
    begins, said = people(rows, postures.times, body)
    ends = [*begins[1:], postures.frames]
    parts = [correct(_cut(postures, a, b)) for a, b in zip(begins, ends, strict=True)]
    if len(parts) == 1 and not said:
        return parts[0]
    notes: list[Noted] = [one.source for one in parts]
    warnings = [*said]
    for a, note in zip(begins, notes, strict=True):
        since = "" if len(parts) == 1 else f"from {postures.times[a] - postures.times[0]:.2f} s on: "
        warnings += [f"{since}{one}" for one in note.warnings]
    flags = np.concatenate([one.flags for one in notes])
    return replace(
        postures,
        positions=np.concatenate([one.positions for one in parts]),
        std=np.concatenate([np.asarray(one.std) for one in parts]),
        reliability=np.concatenate([np.asarray(one.reliability) for one in parts]),
        source=replace(notes[0], source=postures.source, flags=flags, warnings=tuple(warnings)),
    )


def people(rows: Floats, times: Floats, body: Anatomy) -> tuple[list[int], tuple[str, ...]]:
    """The frames from which on somebody else is there, 0 first, and what is to be said of it.

    Parameters
    ----------
    rows : (T, J, 3) m by the model's joints, NaN = missing.
    times : (T,) s.
    """
    there = np.flatnonzero(np.isfinite(rows).any(axis=(1, 2)))
    rows = np.ascontiguousarray(rows)
    with np.errstate(divide="ignore"):
        lengths = np.log(np.maximum(bone_lengths(rows[there], body), 1e-6))
    usual = float(np.median(np.diff(times))) if len(times) > 1 else 0.0
    second = max(round(LEAST_SECONDS / usual), 1) if usual > 0.0 else len(there)
    if len(there) < 2 * second:
        return [0], ()
    away = np.diff(times[there], prepend=times[there[0]])
    gone = np.flatnonzero(away > STRANGER_SECONDS)
    leapt = [k for k in range(1, len(there)) if kernel.leapt(rows[there[k]], rows[there[k - 1]], float(away[k]))]
    limits = dict.fromkeys(_steps(lengths, second), FAR_LARGER) | dict.fromkeys([*leapt, *gone.tolist()], LARGER)
    begins, others, same = [0], [], []
    cuts = [*sorted(limits), len(there)]
    for cut, end in pairwise(cuts):
        if cut - begins[-1] < second or end - cut < second:
            continue
        ratio = _ratio(lengths[begins[-1] : cut], lengths[cut:end])
        at = f"{times[there[cut]] - times[0]:.2f} s"
        if abs(np.log(ratio)) > limits[cut]:
            others.append(f"{at} (bones {ratio:.2f} times as long)")
            begins.append(cut)
        elif cut in gone:
            same.append(at)
    said = []
    if others:
        parts = counted(len(others) + 1, "part")
        said.append(f"somebody else is there from {', '.join(others)} on: corrected in {parts}, each on its own")
    if same:
        which = "the one before, whose bones are as long"
        said.append(f"who comes at {few(same, 3)}, after more than 2 s of nobody, was taken for {which}")
    return [0, *(int(there[k]) for k in begins[1:])], tuple(said)


def _steps(lengths: Floats, second: int) -> list[int]:
    """Frames about which the person becomes far larger or smaller, of logarithms of lengths (T, B)."""
    size = _medians(lengths - _medians(lengths.T))
    size = np.where(np.isfinite(size), size, 0.0)
    calm = median_filter(size, second, mode="nearest")
    reach = second // 2 + 1
    step = np.zeros(len(size))
    step[reach:-reach] = np.abs(calm[2 * reach :] - calm[: -2 * reach])
    large = step > FAR_LARGER
    edges = np.flatnonzero(np.diff(np.concatenate([[False], large, [False]]).astype(int)))
    found = []
    for a, b in zip(edges[::2], edges[1::2], strict=True):
        near = slice(max(a - reach, 0), b + reach)  # the frame between two people is the one with the largest change
        found.append(int(near.start + 1 + np.argmax(np.abs(np.diff(size[near])))))
    return found


def _ratio(before: Floats, after: Floats) -> float:
    """How many times as long bones are, of logarithms of lengths (T, B); 1 where they do not change together."""
    change = _medians(after.T) - _medians(before.T)
    change = change[np.isfinite(change)]
    if len(change) < FEWEST:
        return 1.0
    middle = float(np.median(change))
    return float(np.exp(middle)) if (change * middle > 0).mean() >= TOGETHER else 1.0


def _medians(values: Floats) -> Floats:
    """(N,) medians of rows; NaN where there is none."""
    found = np.full(len(values), np.nan)
    some = np.isfinite(values).any(axis=1)
    if some.any():
        found[some] = np.nanmedian(values[some], axis=1)
    return found


def _cut(postures: Postures, begin: int, end: int) -> Postures:
    """The frames of a part; all of it as it is where that is the whole."""
    if end - begin == postures.frames:
        return postures
    return _some(postures, np.arange(begin, end))


def _some(postures: Postures, some: Ints) -> Postures:
    """Some of the frames."""
    state = None if postures.state is None else postures.state[some]
    return replace(postures, positions=postures.positions[some], times=postures.times[some], state=state)
