"""People who walk through: they are not followed, and who is hidden by them is found again."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from drawn_people import CAMERA, HALF, PERSON, in_room, picture, random_poses
from motionmend.bodies.camera import DepthFrame
from motionmend.bodies.performer import Pose, landmarks, standing
from motionmend.track.database import PoseDatabase
from motionmend.track.model import TrackerModel
from motionmend.track.person.foreground import find_person, remember, scene_of
from motionmend.track.settings import settings_of
from motionmend.track.tracker import start, step

PLACE = (0.0, 0.1, 3.0)


def swaying(t):
    """Somebody standing with arms that swing a little, at frame `t`."""
    pose = standing(PLACE)
    joints = np.array(pose.joints)
    joints[np.abs(joints) > 0.5] += 0.15 * np.sin(0.4 * t)
    return Pose(pose.translation, pose.root, joints)


def walking_through(camera, rng, away, frames=60, widest=2.2, towards=1):
    """For each frame: the person alone, the passer alone, and what is measured of both in a room."""
    for t, x in enumerate(towards * np.linspace(-widest, widest, frames)):
        own, other = picture(swaying(t), camera), picture(standing((x, 0.1, away)), camera)
        both = DepthFrame(camera, np.fmin(own.depth, other.depth), None, t / 30)
        yield own.depth, other.depth, in_room(both, wall=5.2, rng=rng)


def shown(own, other):
    """Share of the person's pixels that the passer leaves in sight, and which those are."""
    with np.errstate(invalid="ignore"):
        in_sight = np.isfinite(own) & ~(other < own)
    return in_sight.sum() / np.isfinite(own).sum(), in_sight


@pytest.mark.slow
@pytest.mark.parametrize("towards", [-1, 1])
@pytest.mark.parametrize("away", [2.0, 4.2])
def test_who_walks_through_is_never_the_person(away, towards, rng):
    scene, last, hidden = None, None, 0
    for own, other, frame in walking_through(HALF, rng, away, towards=towards):
        scene = replace(scene_of(frame), vouched=True) if scene is None else scene
        found = find_person(scene, frame, last)
        scene = remember(scene, frame, found)
        share, in_sight = shown(own, other)
        seen = np.isfinite(found.depth)
        with np.errstate(invalid="ignore"):
            strange = seen & (np.abs(found.depth - other) < 0.1) & (np.abs(frame.depth - own) > 0.3)
        assert strange.sum() <= 0.1 * max(seen.sum(), 1)
        if share > 0.8:
            assert (seen & in_sight).sum() > 0.85 * in_sight.sum()
        hidden += not found.found
        last = found.place if found.found else last
    assert (hidden > 0) == (away < PLACE[2])


def test_who_comes_where_only_furniture_is_is_the_person(rng):
    """What does not move and is explained by no body: whoever walks in is no passer."""
    box = np.full((120, 160), np.nan, np.float32)
    rows, columns = np.mgrid[:120, :160]
    round_ = ((columns - 120) / 14.0) ** 2 + ((rows - 70) / 40.0) ** 2 < 1.0
    box[round_] = (
        3.0 - 0.2 * np.sqrt(np.maximum(1.0 - ((columns - 120) / 14.0) ** 2 - ((rows - 70) / 40.0) ** 2, 0.0))[round_]
    )
    scene, last = None, None
    for t, x in enumerate([-3.0] * 8 + list(np.linspace(-1.2, 0.0, 20))):
        alone = picture(standing((x, 0.1, 2.8)), HALF)
        frame = in_room(DepthFrame(HALF, np.fmin(alone.depth, box), None, t / 30), wall=5.2, rng=rng)
        scene = scene_of(frame) if scene is None else scene
        found = find_person(scene, frame, last)
        if t == 7:
            assert found.found
            assert np.isfinite(found.depth)[round_].mean() > 0.8
        scene = remember(scene, frame, found)
        last = found.place if found.found else last
    seen = np.isfinite(alone.depth)
    assert np.isfinite(found.depth)[seen].mean() > 0.8


def test_who_stays_while_the_person_leaves_is_taken_up(rng):
    """The person is not seen for more than a second, and nothing hides where they were: the other one is followed."""
    scene, last, found_at = None, None, None
    for t in range(75):
        own = picture(standing(PLACE), HALF).depth if t < 20 else np.full((120, 160), np.nan, np.float32)
        x = max(2.2 - 0.12 * t, 1.0)
        other = picture(standing((x, 0.1, 2.4)), HALF).depth
        frame = in_room(DepthFrame(HALF, np.fmin(own, other), None, t / 30), wall=5.2, rng=rng)
        scene = replace(scene_of(frame), vouched=True) if scene is None else scene
        found = find_person(scene, frame, last)
        scene = remember(scene, frame, found)
        last = found.place if found.found else last
        if t == 19:
            assert abs(last[0]) < 0.2
        if t >= 20 and found.found and found_at is None:
            found_at = t
    assert 20 + 28 < found_at < 20 + 36
    assert last[0] > 0.7


def door_at(x, camera, away=3.0):
    """A flat door, 0.8 m wide and as high as a room's, whose edge is `x` m beside the camera's axis."""
    v, u = np.mgrid[: camera.height, : camera.width]
    right, down = (u - camera.cx) / camera.fx * away, (v - camera.cy) / camera.fy * away
    there = (right > x) & (right < x + 0.8) & (down > -0.9) & (down < 1.0)
    return np.where(there, np.float32(away), np.float32(np.nan))


def test_who_is_touched_by_a_door_is_still_the_person(rng):
    """It comes up to them, both are one surface for a second, and it goes away again: they are all that is followed."""
    scene, last = None, None
    way = [*np.linspace(1.0, 0.25, 20), *[0.25] * 30, *np.linspace(0.25, 1.0, 20)]
    for t, x in enumerate(way):
        own, door = picture(swaying(t), HALF).depth, door_at(x, HALF)
        frame = in_room(DepthFrame(HALF, np.fmin(own, door), None, t / 30), wall=5.2, rng=rng)
        scene = replace(scene_of(frame), vouched=True) if scene is None else scene
        found = find_person(scene, frame, last)
        scene = remember(scene, frame, found)
        last = found.place
        seen = np.isfinite(found.depth)
        assert found.found, t
        assert seen[np.isfinite(own)].mean() > 0.85, t
        assert (seen & np.isnan(own)).sum() < 0.25 * np.isfinite(own).sum(), t


@pytest.mark.slow
@pytest.mark.parametrize("towards", [-1, 1])
def test_the_tracker_keeps_to_the_person_while_somebody_walks_through(towards, rng):
    poses = random_poses(60, 5)
    joints = np.concatenate([poses.joints, [swaying(t).joints for t in range(20)]])
    model = TrackerModel(PoseDatabase(joints, np.full(len(joints), len(joints) - 1)))
    settings = settings_of("default")
    state, errors, flags = None, [], []
    for t, (own, other, frame) in enumerate(walking_through(CAMERA, rng, 1.9, frames=50, towards=towards)):
        if state is None:
            state = start(model, settings, frame, PERSON, swaying(0))
        state, estimate = step(model, settings, state, frame)
        share, _ = shown(own, other)
        off = np.linalg.norm(landmarks(PERSON, swaying(t)) - estimate.landmarks, axis=1).mean()
        errors.append(off if share > 0.9 else np.nan)
        flags.append("tracked" in estimate.flags)
        if share < 0.02:
            assert not flags[-1]
    assert np.nanmax(errors[-8:]) < 0.05
    assert np.nanmedian(errors) < 0.03
    assert flags[0]
    assert flags[-1]
    assert sum(one and not other for one, other in pairwise(flags)) <= 3
