"""Who else is there from the first frame on: a body that sways beside the person is no furniture, and not theirs."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...arrays import Floats
from ...bodies.camera import DepthFrame
from ...errors import MismatchError
from .fineness import evened
from .room import Scene, scene_of
from .standing import inner_of, likest, looked_at, stays_of, sways, with_furniture
from .surfaces import SOMEBODY, joined, two_bodies


def told_beforehand(frames: Sequence[DepthFrame], pointed_at: Floats | None = None) -> Scene | None:
    """The room before anybody is followed: with furniture that looks like a body, and who else is there from the start.

    What only stands beside the person is learned as background, and is in the way of whoever starts to move in pieces.
    Where nothing moves at all, that is told, too.

    Parameters
    ----------
    frames : of all of a recording; two dozen of them are looked at.
    pointed_at : (3,) m, in the middle of the person in the first frame, where that is known: then no furniture is told.

    Returns
    -------
    The scene before the first frame; None where nothing is told.

    Raises
    ------
    MismatchError : no frames.
    """
    if not frames:
        raise MismatchError("depth frames were wanted, came none")
    even = [evened(frames[k]) for k in looked_at(len(frames))]
    scene = with_furniture(even) if pointed_at is None else None
    if len(even) < 3 or len({frame.depth.shape for frame in even}) > 1 or (scene is not None and scene.still):
        return scene
    camera, depths = even[0].camera, np.stack([frame.depth for frame in even])
    room = scene_of(even[0]) if scene is None else scene
    seen, main = likest(room, depths[0], camera, pointed_at)
    beside = [s for s in seen.clouds if main >= 0 and s != main and two_bodies(*seen.measures[[main, s]])]
    if not beside:
        return scene
    stays, _ = stays_of(depths, camera.fx * camera.fy)
    strange = np.zeros(len(seen.measures), np.bool_)
    strange[joined(main, seen, strange)] = True
    others: list[int] = []
    for s in beside:
        if not strange[s] and sways(depths, stays, inner_of(seen.pixels_of([s]))):
            others += joined(s, seen, strange)
            strange[others] = True
    if not others:
        return scene
    return replace(room, others=np.where(seen.pixels_of(others), depths[0], np.float32(np.nan)))


def is_accompanied(scene: Scene | None, frame: DepthFrame) -> bool:
    """Whether so much of somebody else was seen in a frame that it is a body's.

    Parameters
    ----------
    scene : after the frame; None = nothing is known. frame : as it was recorded, maybe finer than the scene.
    """
    if scene is None or scene.others is None:
        return False
    fineness = scene.others.size / frame.depth.size
    squares = float(np.nansum(np.square(scene.others, dtype=np.float64)))
    return bool(squares / (fineness * frame.camera.fx * frame.camera.fy) > SOMEBODY)
