"""One person of the several bodies in a file, whom a sensor may have numbered anew after losing sight of them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Floats, Ints
from ..errors import counted

AWAY = 5.0  # s; who was lost for longer may be somebody else
BESIDE, PACE = 0.4, 1.5  # m and m/s; who comes back is so near to where they were lost, and walks on for a second
WALKED = 1.0  # s


@dataclass(frozen=True, eq=False)
class Track:
    """What a file holds of one of its bodies: the frames (F,), rising, and in them positions (F, J, 3) m."""

    frames: Ints
    positions: Floats


def one_person(tracks: Mapping[Any, Track], times: Floats) -> tuple[tuple[Any, ...], tuple[str, ...]]:
    """The bodies that are the person who is seen longest (the first of several), in the order in which they come.

    Bodies that are not there at once, the later of which begins where the earlier one ended, are one person.

    Parameters
    ----------
    tracks : by body, in the order in which they appear.
    times : (T,) s, of the recording's frames.

    Returns
    -------
    The bodies, and what was supposed of them.
    """
    chains: list[list[Any]] = []
    for body in sorted(tracks, key=lambda one: int(tracks[one].frames[0])):
        near = [(_apart(tracks[chain[-1]], tracks[body], times), k) for k, chain in enumerate(chains)]
        least, nearest = min(near, default=(np.inf, -1))
        if least <= 1.0:
            chains[nearest].append(body)
        else:
            chains.append([body])
    seen = [sum(len(tracks[body].frames) for body in chain) for chain in chains]
    order = list(tracks)
    best = max(range(len(chains)), key=lambda k: (seen[k], -order.index(chains[k][0])))
    chosen, said = chains[best], []
    names = ", ".join(str(body) for body in chosen)
    if len(chosen) > 1:
        said.append(f"{len(chosen)} bodies go on where one before them ended: took {names} for one person")
    if len(chains) > 1:
        among = f"{len(tracks)} bodies" if len(chosen) == 1 else f"{len(chains)} people"
        frames = f"{seen[best]} of {counted(len(times), 'frame')}"
        said.append(f"{among}: took {names}, which {'is' if len(chosen) == 1 else 'are'} seen longest ({frames})")
    return tuple(chosen), tuple(said)


def _apart(earlier: Track, later: Track, times: Floats) -> float:
    """How far the later body begins from where the earlier one ended, by what a person may be; infinite where the two
    are there at once, or too long after each other."""
    last, first = int(earlier.frames[-1]), int(later.frames[0])
    seconds = float(times[first] - times[last])
    steps = np.linalg.norm(later.positions[0] - earlier.positions[-1], axis=1)
    known = steps[np.isfinite(steps)]
    if first <= last or seconds > AWAY or not len(known):
        return np.inf
    return float(np.median(known)) / (BESIDE + PACE * min(max(seconds, 0.0), WALKED))
