"""The person in a frame: all that is measured where the room was taken away, else what `foreground` tells apart."""

from dataclasses import replace

import numpy as np

from ...arrays import Floats
from ...bodies.camera import DepthFrame
from ...bodies.surface import intrinsics
from ..frame.evidence import listed, middle
from .foreground import CLOSING, Foreground, Scene, beside, find_person, mended, remember
from .surfaces import BOTH, JUMP_NEAR, JUMP_STEEP, LARGEST, SMALLEST, about, two_bodies
from .window import Lines, lines_of, reached, untold

GAP = 0.5  # m, that one body has nowhere: less than a forearm
PIECE = 0.01  # m², at least, of somebody else who comes into view


def person_of(scene: Scene, frame: DepthFrame, last: Floats | None, median: int) -> tuple[Foreground, Scene]:
    """The person in a frame, and the scene with what the frame taught of it.

    Parameters
    ----------
    scene : as known so far. last : (3,) m, where the person was, if known. median : radius of the filter, px.

    Notes
    -----
    A recording without background has no floor or wall, and while all that is in it hangs together no more than one
    body: then nothing need be, and nothing is, told apart, so that limbs before and behind each other are never taken
    for something else.
    """
    if scene.bare and scene.others is None:
        lines = lines_of(frame.depth, frame.camera)
        if lines is not None and SMALLEST < lines.area < LARGEST and not _apart(frame, lines):
            window = reached(scene.window, lines)
            person = _all_of_it(frame, median, about(lines.box, frame.depth.shape, CLOSING + median))
            away = None if window is None else untold(window, lines)
            person = person if away is None else replace(person, free=person.free & ~away)
            return person, replace(scene, window=window, person=person.depth, since=frame.time)
    person = find_person(scene, frame, last, median)
    return person, remember(scene, frame, person)


def _apart(frame: DepthFrame, lines: Lines) -> bool:
    """Whether all that is measured is of two things: with a gap between that no body has, or a body each."""
    points = listed(frame.depth, intrinsics(frame.camera), 4)[1]
    least = int(np.ceil(PIECE / lines.area * len(points)))
    if len(points) < 2 * least:
        return False
    across, away = points[:, 0], points[:, 2]
    ways = np.sort(np.stack([across, away, np.sqrt(0.5) * (across + away), np.sqrt(0.5) * (across - away)]), axis=1)
    within = ways[:, least - 1 : len(points) - least + 1]
    if (within[:, 1:] - within[:, :-1]).max(initial=0.0) > GAP:
        return True
    return lines.area > BOTH and _side_by_side(frame)


def _side_by_side(frame: DepthFrame) -> bool:
    """Whether the two largest surfaces are a body's each."""
    from ...kernels import regions

    labels = np.empty(frame.depth.shape, np.int32)
    count = regions.surfaces(frame.depth, np.isfinite(frame.depth), JUMP_NEAR, JUMP_STEEP, labels)
    measures = np.empty((count, 14))
    regions.measures(frame.depth, labels, np.zeros(labels.shape, np.uint8), intrinsics(frame.camera), measures)
    two = np.argsort(-measures[:, 1], kind="stable")[:2]
    return len(two) == 2 and two_bodies(*measures[two])


def _all_of_it(frame: DepthFrame, median: int, box: tuple[slice, slice]) -> Foreground:
    """What is measured, cleaned; `box` holds all of it and a margin wide enough for the clean-up."""
    depth, free = np.full(frame.depth.shape, np.nan, np.float32), np.ones(frame.depth.shape, np.bool_)
    part = mended(frame.depth[box], median)
    depth[box] = part
    free[box] = beside(np.isfinite(part))
    points = listed(depth, intrinsics(frame.camera), 4)[1]
    if not len(points):
        return Foreground(depth, False, np.full(3, np.nan), free)
    return Foreground(depth, True, middle(points), free)
