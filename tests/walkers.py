"""Somebody who walks, drawn, a library of strides, and what the tracker makes of them."""

from dataclasses import replace
from functools import cache

import numpy as np

from motionmend.bodies import anatomy
from motionmend.bodies.camera import KINECT, DepthFrame
from motionmend.bodies.performer import BONES, FACING, FIRST, Pose, landmarks, rotation, standing
from motionmend.bodies.surface import render
from motionmend.evaluate.sensor import KINECT_SENSOR, sensed
from motionmend.numerics.least_squares import Solution, System
from motionmend.track.database import PoseDatabase
from motionmend.track.model import TrackerModel
from motionmend.track.settings import settings_of
from motionmend.track.state import Fit
from motionmend.track.tracker import start, step

BODY = anatomy.average()
DT = 1.0 / 30.0


def column(bone, of=0):
    return int(FIRST[BONES.index(bone)]) + of


def walking(phase, place, heading, swing=0.45):
    """A stride: legs and arms to and fro, the knee bent in the swing, elbows a little."""
    joints = standing().joints.copy()
    for side, sign in (("l", 1.0), ("r", -1.0)):
        forward = sign * np.sin(phase)
        joints[column(f"{side}_thigh")] -= swing * forward
        joints[column(f"{side}_shank")] = 0.15 + 0.5 * max(sign * np.cos(phase), 0.0)
        joints[column(f"{side}_forearm")] = 0.5
        joints[column(f"{side}_upperarm")] += 0.6 * swing * forward
    return Pose(place, rotation(np.array([0.0, np.radians(heading), 0.0])) @ FACING, joints)


def walk(frames, heading, speed=1.1):
    """Poses of somebody who passes 3 m before the camera; to where they face unless the speed is negative."""
    root = rotation(np.array([0.0, np.radians(heading), 0.0])) @ FACING
    way = root[:, 2] * speed * DT
    return [
        walking(np.sign(speed) * 2.0 * np.pi * k * DT / 1.1, (0, 0.05, 3.0) + (k - frames / 2) * way, heading)
        for k in range(frames)
    ]


@cache
def library():
    poses = [walking(2.0 * np.pi * k / 33.0, np.zeros(3), 0.0, swing).joints for swing in (0.3, 0.6) for k in range(33)]
    return TrackerModel(PoseDatabase(np.array(poses), np.repeat([32, 65], 33)))


def as_sensed(depth, camera, seed, frame):
    """What the sensor makes of an image that is empty but for somebody: of the part in which they are.

    All of it takes five times as long as the tracker takes for a frame.
    """
    rows, columns = (np.flatnonzero(np.isfinite(depth).any(axis=axis)) for axis in (1, 0))
    part = slice(max(rows[0] - 4, 0), rows[-1] + 5), slice(max(columns[0] - 4, 0), columns[-1] + 5)
    height, width = depth[part].shape
    share = width / camera.width  # by the width of the image the sensor knows how fine it is
    sensor = replace(KINECT_SENSOR, lateral=KINECT_SENSOR.lateral / share, steps=KINECT_SENSOR.steps * share)
    ahead = replace(camera, width=width, height=height, cx=camera.cx - part[1].start, cy=camera.cy - part[0].start)
    found = np.full_like(depth, np.nan)
    found[part] = sensed(depth[part], ahead, seed, frame, sensor)
    return found


def followed(poses, first, **known):
    """The poses that the tracker finds when it begins with `first` and with what is known of readings."""
    return [estimate.pose for estimate in told(poses, first, **known)]


def told(poses, first, **known):
    """What the tracker says of each frame then."""
    model, settings = library(), settings_of()
    state, found = None, []
    for k, pose in enumerate(poses):
        depth = as_sensed(render(BODY, pose, KINECT).depth, KINECT, 0, k)
        frame = DepthFrame(KINECT, depth, None, k * DT)
        if state is None:
            state = replace(start(model, settings, frame, BODY, first), **known)
        state, estimate = step(model, settings, state, frame)
        found.append(estimate)
    return found


def off(pose, other):
    return float(np.linalg.norm(landmarks(BODY, pose) - landmarks(BODY, other), axis=1).mean())


def begun_at(twin, expected, wrong):
    """The first half of a look that finds the other reading where it was expected, and so wrong."""
    solution = Solution(expected, System(np.eye(34), np.zeros(34)), 1, True)
    return Fit(twin, [], expected, solution, wrong)


def finished(sight, begun):
    """The second half, in which no limb is found elsewhere."""
    return begun, np.ones(28)
