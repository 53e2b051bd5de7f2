"""Who else is in the room: people who come into view beside the one who is followed, and stay somebody else.

Whoever walks through before a known wall looks as much like a body as the person does, and may hide them for a while.
What tells the two apart is where they were a moment ago: a surface that comes into view away from the person is a
passer's, and so is, from frame to frame, what is where a passer was. While one hides the person nobody is followed.
"""

import numpy as np

from ...arrays import Bools, Floats, Singles
from .room import Scene
from .surfaces import Surfaces, hidden, joined, two_bodies

SOME = 0.1  # share of a piece of a passer that was there a moment ago; who comes out from behind one was not
APART = 0.7  # m, from the person's middle; what comes into view farther away is not theirs


def passers(seen: Surfaces, scene: Scene, depth: Singles, last: Floats | None) -> Bools:
    """(S,) which surfaces are a passer's, with all that hangs together with them and was not the person's.

    Parameters
    ----------
    seen : the surfaces of this frame.
    scene : the room as known so far, and who was in it.
    depth : (H, W) m.
    last : (3,) m, where the person was; None where nobody is followed.
    """
    theirs = seen.known > 0.5
    found = (seen.elsewhere > 0.5) & (seen.elsewhere > seen.known)
    new = [] if last is None else [s for s in seen.likeness if _comes_beside(seen, s, last)]
    # Beside furniture whoever comes may be the person, and so may who comes out from behind a passer.
    if new and scene.alive and not hidden(depth, scene.person):
        found[new] = True
    if scene.vouched:  # of who is lost nothing says which of the two they are
        found[_bodies_beside(seen, found)] = True
    for s in [s for s in seen.likeness if found[s]]:
        found[joined(s, seen, ~found & (theirs | (seen.elsewhere < SOME)))] = True
    return np.asarray(found)


def _comes_beside(seen: Surfaces, s: int, last: Floats) -> bool:
    """Whether a surface could be somebody who moves, was not the person's, and is away from where they were."""
    moves = seen.likeness[s] > 0.0 and seen.measures[s, 11] > 0.5 >= seen.known[s]
    return bool(moves and np.linalg.norm(seen.clouds[s] - last, axis=1).min() > APART)


def _bodies_beside(seen: Surfaces, strange: Bools) -> list[int]:
    """Surfaces that move beside the person and are no part of them, for each of the two is a body: a door, say, which
    passed for a limb while it was seen from its edge."""
    sizes = np.where(strange, 0.0, seen.known * seen.measures[:, 0])
    main = int(np.argmax(sizes)) if len(sizes) else -1
    if main < 0 or seen.known[main] <= 0.5:
        return []
    moving = [s for s in seen.likeness if s != main and seen.measures[s, 11] > 0.5]
    return [s for s in moving if two_bodies(seen.measures[main], seen.measures[s])]


def passers_pixels(seen: Surfaces, depth: Singles, strange: Bools, kept: list[int]) -> Singles | None:
    """(H, W) m, where passers are, NaN beside; None = there is none.

    Parameters
    ----------
    seen : the surfaces. depth : (H, W) m. strange : (S,) those of passers. kept : those of the person.
    """
    some = np.setdiff1d(np.flatnonzero(strange), kept)
    return np.where(seen.pixels_of(some.tolist()), depth, np.float32(np.nan)) if len(some) else None
