"""Furniture that was taken for somebody: it still stands there when it is known where the person is."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ...arrays import Bools, Singles
from ...bodies.camera import KINECT, Camera, DepthFrame
from ...bodies.performer import Performer, Poses
from ...bodies.surface import render
from ..person.fineness import evened
from ..state import TrackState

COARSE = KINECT.fx / 4  # px, focal length of the pictures that tell
NEAR = 0.10  # m, that a body and a piece of furniture which it was fitted to are apart at most
SHARE = 0.4  # of a body's pixels; of somebody who has left the place hardly any are near what is behind


@final
@dataclass(frozen=True, eq=False)
class Room:
    """What was seen behind everybody in a recording.

    Attributes
    ----------
    camera : of the background.
    background : (H, W) m, the farthest surface seen, NaN where none was.
    still : whether what is most like a body never moves in all of the recording.
    """

    camera: Camera
    background: Singles
    still: bool = False


def room_behind(state: TrackState, frame: DepthFrame) -> Room | None:
    """The room as it is known after a recording's last frame; None where nothing is."""
    scene = state.scene
    return None if scene is None else Room(evened(frame).camera, scene.background, scene.still)


def is_furniture(room: Room, performer: Performer, poses: Poses, seen: Bools) -> Bools:
    """In which frames the body stands where the room has a surface of its own.

    Parameters
    ----------
    room : behind everybody.
    performer : whose body is followed.
    poses : T of them. seen : (T,) frames in which the body is followed; no other is looked at.
    """
    step = room.camera.step_to(COARSE)
    camera, behind = room.camera.every(step), room.background[::step, ::step]
    found = np.zeros(len(seen), dtype=np.bool_)
    if not np.isfinite(behind).any():
        return found
    for t in np.flatnonzero(seen).tolist():
        drawn = render(performer, poses[t], camera).depth
        body = np.isfinite(drawn)
        with np.errstate(invalid="ignore"):
            found[t] = np.count_nonzero(np.abs(behind[body] - drawn[body]) < NEAR) > SHARE * np.count_nonzero(body)
    return found
