"""One person of the several bodies in a file, whose numbers a sensor may have changed, exchanged or given twice.

A sensor numbers bodies anew after losing sight of them, and takes people who pass each other for one another. People do
not change places within a frame, so places tell who is who wherever numbers and places disagree.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Floats, Ints
from ..errors import counted

AWAY = 5.0  # s; who was lost for longer may be somebody else
BESIDE, PACE = 0.4, 1.5  # m and m/s; who comes back is so near to where they were lost, and walks on for a second
WALKED = 1.0  # s
AS_NUMBERED = 0.1  # m, by which a body's own number must lead it farther than another's: sensors tremble by less
NOWHERE = 1e6  # m; stands for a place that is not known, or another's that was not there a frame ago


@dataclass(frozen=True, eq=False)
class Body:
    """What a frame holds of one of its bodies: the number it has there, and positions (J, 3) m."""

    number: Any
    positions: Floats


@dataclass(eq=False)
class _Track:
    """One body followed: the frames it is in, which of each frame's bodies it is there, and its numbers in turn."""

    frames: list[int]
    which: list[int]
    numbers: list[Any]
    first: Floats
    last: Floats
    exchanged: list[int]


def one_person(bodies: Sequence[Sequence[Body]], times: Floats) -> tuple[Ints, tuple[str, ...]]:
    """The body in each frame that is the person who is seen longest (the first of several).

    Bodies whose numbers change places, or who have one number, are followed by where they are. Bodies that are not
    there at once, the later of which begins where the earlier one ended, are one person.

    Parameters
    ----------
    bodies : of each of T frames.
    times : (T,) s.

    Returns
    -------
    (T,) which of the frame's bodies it is, -1 = none; and what was supposed of them.
    """
    tracks = _followed(bodies)
    chains: list[list[_Track]] = []
    for track in sorted(tracks, key=lambda one: one.frames[0]):
        near = [(_apart(chain[-1], track, times), k) for k, chain in enumerate(chains)]
        least, nearest = min(near, default=(np.inf, -1))
        if least <= 1.0:
            chains[nearest].append(track)
        else:
            chains.append([track])
    seen = [sum(len(track.frames) for track in chain) for chain in chains]
    best = max(range(len(chains)), key=lambda k: (seen[k], -tracks.index(chains[k][0])))
    found = np.full(len(times), -1, dtype=np.int64)
    for track in chains[best]:
        found[track.frames] = track.which
    return found, _said(bodies, chains, best, seen[best], times)


def _said(
    bodies: Sequence[Sequence[Body]], chains: Sequence[Sequence[_Track]], best: int, seen: int, times: Floats
) -> tuple[str, ...]:
    """What was supposed when of all people (chains) one was taken."""
    said, chosen = [], chains[best]
    every = [[one.number for one in frame] for frame in bodies]
    twice = [frame for frame in every if len(set(map(str, frame))) < len(frame)]
    if twice:
        whose = next(number for number in twice[0] if twice[0].count(number) > 1)
        said.append(f"several bodies have the number {whose} in {counted(len(twice), 'frame')}: told apart by place")
    exchanged = sorted({frame for chain in chains for track in chain for frame in track.exchanged})
    if exchanged:
        when = ", ".join(f"{times[frame] - times[0]:.2f}" for frame in exchanged[:5])
        more = f" and {len(exchanged) - 5} more times" if len(exchanged) > 5 else ""
        said.append(f"numbers of bodies change places at {when} s{more}: each is followed by where it is")
    numbers = list(dict.fromkeys(str(number) for track in chosen for number in track.numbers))
    if len(chosen) > 1:
        names = ", ".join(numbers)
        said.append(f"{len(chosen)} bodies go on where one before them ended: took {names} for one person")
    if len(chains) > 1:
        count = len({str(number) for frame in every for number in frame})
        plain = len(chosen) == 1 and not exchanged and not twice
        among = f"{count} bodies" if plain else f"{len(chains)} people"
        if exchanged or twice:
            numbers = [f"the one who begins as {numbers[0]}"]
        which = "which is" if len(numbers) == 1 else "which are"
        said.append(
            f"{among}: took {', '.join(numbers)}, {which} seen longest ({seen} of {counted(len(times), 'frame')})"
        )
    return tuple(said)


def _followed(bodies: Sequence[Sequence[Body]]) -> list[_Track]:
    """The tracks of all bodies, in the order in which they appear: by number, or by place where that says otherwise."""
    tracks: list[_Track] = []
    known: dict[Any, list[_Track]] = {}  # by the number that each had last
    there: list[_Track] = []  # in the frame before
    for t, frame in enumerate(bodies):
        owners = _owners(frame, known, there)
        now = []
        for k, (body, track) in enumerate(zip(frame, owners, strict=True)):
            if track is None:
                track = _Track([], [], [body.number], body.positions, body.positions, [])
                tracks.append(track)
                known.setdefault(body.number, []).append(track)
            elif body.number != track.numbers[-1]:
                known[track.numbers[-1]].remove(track)
                known[body.number].append(track)
                track.numbers.append(body.number)
                track.exchanged.append(t)
            track.frames.append(t)
            track.which.append(k)
            track.last = body.positions
            now.append(track)
        there = now
    return tracks


def _owners(
    frame: Sequence[Body], known: Mapping[Any, Sequence[_Track]], there: Sequence[_Track]
) -> list[_Track | None]:
    """The track of each body of a frame, those that a sensor numbers for the first time without one."""
    from scipy.optimize import linear_sum_assignment

    own = [known.get(body.number, ()) for body in frame]
    numbered = len({id(tracks[0]) for tracks in own if tracks}) == sum(map(bool, own))
    if numbered and all(
        len(tracks) < 2 and all(_step(track.last, body.positions) < AS_NUMBERED for track in tracks)
        for tracks, body in zip(own, frame, strict=True)
    ):
        return [tracks[0] if tracks else None for tracks in own]
    asked = list({id(track): track for tracks in (*own, there) for track in tracks}.values())
    costs = np.full((len(frame), len(asked)), NOWHERE)
    for k, body in enumerate(frame):
        for m, track in enumerate(asked):
            step = _step(track.last, body.positions)
            if any(track is one for one in own[k]):
                costs[k, m] = min(step, 0.1 * NOWHERE) - AS_NUMBERED
            elif own[k] and step < BESIDE and any(track is one for one in there):
                costs[k, m] = step
    pairs = zip(*(one.tolist() for one in linear_sum_assignment(costs)), strict=True)
    chosen = {k: asked[m] for k, m in pairs if costs[k, m] < NOWHERE}
    return [chosen.get(k) for k in range(len(frame))]


def _step(before: Floats, now: Floats) -> float:
    """m, how far the middle joint went; infinite where none is in both."""
    with np.errstate(over="ignore", invalid="ignore"):  # damage; what is not finite tells nothing
        steps = np.linalg.norm(now - before, axis=1)
    some = steps[np.isfinite(steps)]
    return float(np.median(some)) if len(some) else np.inf


def _apart(earlier: _Track, later: _Track, times: Floats) -> float:
    """How far the later body begins from where the earlier one ended, by what a person may be; infinite where the two
    are there at once, or too long after each other."""
    last, first = earlier.frames[-1], later.frames[0]
    seconds = float(times[first] - times[last])
    if first <= last or seconds > AWAY:
        return np.inf
    return _step(earlier.last, later.first) / (BESIDE + PACE * min(max(seconds, 0.0), WALKED))
