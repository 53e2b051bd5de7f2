"""People for the tests that look for them: random poses, their pictures, and rooms around them."""

import numpy as np

from motionmend.bodies.anatomy import average
from motionmend.bodies.camera import Camera, DepthFrame
from motionmend.bodies.performer import BONES, FIRST, LIMITS, Pose, Poses, rotation, standing
from motionmend.bodies.surface import render

CAMERA = Camera(320, 240, 285.63, 285.63, 160.0, 120.0)
HALF = CAMERA.every(2)
PERSON = average()
_SPREAD = {"upperarm": 0.5, "forearm": 0.5, "thigh": 0.2, "shank": 0.15, "chest": 0.1, "head": 0.15}


def random_joints(rng):
    """(28,) rad about standing: arms anywhere before the body, legs a little apart."""
    joints = np.array(standing().joints)
    for b, bone in enumerate(BONES):
        part = bone.split("_")[-1]
        if part in _SPREAD:
            own = slice(FIRST[b], FIRST[b + 1])
            joints[own] += rng.normal(0, _SPREAD[part], FIRST[b + 1] - FIRST[b])
            if part in ("forearm", "shank"):
                joints[own] = np.abs(joints[own]) + 0.1
    return np.clip(joints, LIMITS[6:, 0], LIMITS[6:, 1])


def random_poses(count, seed):
    """Facing the camera, 3 m away."""
    rng = np.random.default_rng(seed)
    base = standing((0.0, 0.1, 3.0))
    joints = np.array([random_joints(rng) for _ in range(count)])
    return Poses(np.tile(base.translation, (count, 1)), np.tile(base.root, (count, 1, 1)), joints)


def turned(pose, heading):
    """The pose turned about the vertical, rad."""
    return Pose(pose.translation, rotation(np.array([0.0, heading, 0.0])) @ pose.root, pose.joints)


def picture(pose, camera=CAMERA, person=PERSON, rng=None, time=0.0):
    """A frame of nothing but the person, with noise when a generator is given."""
    depth = np.array(render(person, pose, camera).depth)
    if rng is not None:
        depth += rng.normal(0, 0.0015, depth.shape).astype(np.float32) * depth**2
        depth[rng.uniform(size=depth.shape) < 0.01] = np.nan
    return DepthFrame(camera, depth, None, time)


def in_room(frame, floor=1.05, wall=4.0, rng=None):
    """The same frame before a wall and on a floor that is `floor` m below the camera."""
    camera = frame.camera
    v = np.arange(camera.height)[:, None] - camera.cy
    with np.errstate(divide="ignore"):
        ground = np.where(v > 0, floor * camera.fy / np.maximum(v, 1e-9), np.inf)
    room = np.minimum(ground, wall) * np.ones((1, camera.width))
    if rng is not None:
        room = room + rng.normal(0, 0.0015, room.shape) * room**2
    depth = np.fmin(frame.depth, room.astype(np.float32))
    return DepthFrame(camera, depth, None, frame.time)
