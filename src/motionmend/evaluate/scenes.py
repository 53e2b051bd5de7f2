"""Depth recordings made from motions: who moves, which camera looks on from where, and what else is in view."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from ..arrays import Bytes, Floats, Singles
from ..bodies.camera import KINECT, Camera, DepthFrame
from ..bodies.motion import Motion
from ..bodies.performer import Performer, Poses
from ..bodies.skeleton import forward
from ..bodies.surface import Rendering, render
from .sensor import Sensor, sensed
from .strangers import Stranger, depth_of


@final
@dataclass(frozen=True, eq=False)
class View:
    """Where the camera stands: a point x of the motion's axes lies at turn · x + shift in the camera's.

    `turn` (3, 3), `shift` (3,) m, `up` (3,) unit vector against gravity in the camera's axes.
    """

    turn: Floats
    shift: Floats
    up: Floats


@final
@dataclass(frozen=True)
class Plane:
    """A floor or a wall: all points x with normal · x = distance, camera axes; the normal points into the room."""

    normal: tuple[float, float, float]
    distance: float


def view(target: Floats, up: Floats, distance: float = 3.0, yaw: float = 0.0, rise: float = 0.0) -> View:
    """A camera that looks at a point.

    Parameters
    ----------
    target : (3,) m, in the motion's axes.
    up : (3,) against gravity.
    distance : from the camera to the target, m.
    yaw : degrees about `up`; at 0 the camera stands where z (x where up is z) is larger, and turns leftwards about it.
    rise : degrees by which the camera looks down.
    """
    up = np.asarray(up, dtype=np.float64) / np.linalg.norm(up)
    first = np.array([0.0, 0.0, 1.0]) if abs(up[2]) < 0.7 else np.array([1.0, 0.0, 0.0])
    first = first - (first @ up) * up
    first /= np.linalg.norm(first)
    turned = np.cos(np.radians(yaw)) * first + np.sin(np.radians(yaw)) * np.cross(up, first)
    away = np.cos(np.radians(rise)) * turned + np.sin(np.radians(rise)) * up
    ahead = -away
    right = np.cross(ahead, up)
    right /= np.linalg.norm(right)
    turn = np.stack((right, np.cross(ahead, right), ahead))
    shift = -turn @ (np.asarray(target, dtype=np.float64) + distance * away)
    return View(turn, shift, turn @ up)


def room(seen: View, floor: float, up_axis: Floats, back: float = 1.5, aside: float = 2.0) -> tuple[Plane, ...]:
    """A floor, a wall behind and one beside.

    Parameters
    ----------
    seen : where the camera stands.
    floor : height of the floor along `up_axis`, m, in the motion's axes.
    up_axis : (3,) against gravity, in the motion's axes.
    back : m, the wall behind is 3 m and so much more before the camera.
    aside : m from the camera to the wall beside, at the right of the picture.
    """
    up = np.asarray(up_axis, dtype=np.float64)
    level = float(seen.up @ (seen.turn @ (floor * up) + seen.shift))
    ahead = np.array([0.0, 0.0, 1.0]) - seen.up[2] * seen.up
    ahead /= np.linalg.norm(ahead)
    side = np.cross(seen.up, ahead)
    planes = (Plane(_triple(seen.up), level), Plane(_triple(-ahead), -(3.0 + back)))
    return (*planes, Plane(_triple(-side if side[0] > 0 else side), -aside))


def behind(depth: Singles, camera: Camera, planes: Sequence[Plane]) -> Singles:
    """The depth image with planes behind (and before) what it holds."""
    u, v = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
    rays = np.stack(((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, np.ones(u.shape)), axis=-1)
    nearest = np.where(np.isfinite(depth), depth, np.inf).astype(np.float64)
    for plane in planes:
        with np.errstate(divide="ignore"):
            z = plane.distance / (rays @ np.array(plane.normal))
        nearest = np.minimum(nearest, np.where(z > 0, z, np.inf))
    return np.where(np.isfinite(nearest), nearest, np.nan).astype(np.float32)


def painted(picture: Rendering) -> Bytes:
    """Colours (H, W, 3) of a rendered performer: stripes and blotches that keep their place on every bone."""
    points, bones = picture.points, picture.bones
    solids = picture.performer.solids
    seen = picture.solid >= 0
    solid = picture.solid[seen].astype(np.int64)
    frame = picture.placed[solid]
    local = np.einsum("nij,ni->nj", frame[:, :, :3], points[seen] - frame[:, :, 3])
    local = np.einsum("nij,nj->ni", solids.turn[solid], local) + solids.center[solid]  # on the bone
    color = np.zeros((*picture.depth.shape, 3))
    phase = 1.7 * bones[seen].astype(np.float64)
    wave = np.stack(
        (
            np.sin(60.0 * local[:, 1] + phase) + 0.5 * np.sin(47.0 * local[:, 0] + 2 * phase),
            np.sin(52.0 * local[:, 2] + 31.0 * local[:, 1] + phase),
            np.sin(38.0 * local[:, 0] - 44.0 * local[:, 1] + 3 * phase) + 0.5 * np.cos(70.0 * local[:, 2]),
        ),
        axis=1,
    )
    color[seen] = 128.0 + 60.0 * wave
    return np.clip(np.round(color), 0, 255).astype(np.uint8)


def performed(
    poses: Poses,
    performer: Performer,
    camera: Camera = KINECT,
    *,
    fps: float = 30.0,
    seed: int | None = None,
    sensor: Sensor | None = None,
    planes: Sequence[Plane] = (),
    colored: bool = False,
) -> Iterator[DepthFrame]:
    """Frames of a performer as the camera sees it.

    Parameters
    ----------
    poses : T poses in the camera's axes (`Poses.moved` with the turn and shift of a `View`).
    performer, camera : who, and what looks.
    fps : of the poses, Hz.
    seed : of the noise; None gives true depth.
    sensor : its properties; the Kinect's when not given.
    planes : floor and walls in view.
    colored : paint the performer; what is not the performer is black.
    """
    for t in range(len(poses)):
        picture = render(performer, poses[t], camera)
        color = painted(picture) if colored else None
        yield DepthFrame(camera, _finished(picture.depth, camera, planes, seed, t, sensor), color, t / fps)


def strange(
    motion: Motion,
    body: Stranger,
    seen: View,
    camera: Camera = KINECT,
    *,
    seed: int | None = None,
    sensor: Sensor | None = None,
    planes: Sequence[Plane] = (),
) -> Iterator[DepthFrame]:
    """Frames of a body that is not the tracker's, doing a motion of its own skeleton.

    Parameters
    ----------
    motion : T frames of the skeleton that the body was made on.
    body : its surface.
    seen, camera, seed, sensor, planes : as in `performed`.

    Returns
    -------
    T frames, drawn when asked for, without colour.
    """
    for t in range(motion.frames):
        position, turned = forward(motion.skeleton, motion.q[t : t + 1])
        depth, _ = depth_of(body, position[0], turned[0], camera, seen.turn, seen.shift)
        yield DepthFrame(camera, _finished(depth, camera, planes, seed, t, sensor), None, t / motion.fps)


def _finished(
    depth: Singles, camera: Camera, planes: Sequence[Plane], seed: int | None, frame: int, sensor: Sensor | None
) -> Singles:
    if planes:
        depth = behind(depth, camera, planes)
    if seed is None:
        return depth
    return sensed(depth, camera, seed, frame) if sensor is None else sensed(depth, camera, seed, frame, sensor)


def _triple(vector: Floats) -> tuple[float, float, float]:
    return float(vector[0]), float(vector[1]), float(vector[2])
