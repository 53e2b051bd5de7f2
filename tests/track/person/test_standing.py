"""Furniture that never moves, told before anybody is followed."""

import numpy as np
import pytest

from drawn_people import CAMERA, PERSON, in_room, picture, random_joints
from motionmend.bodies.camera import DepthFrame
from motionmend.bodies.performer import Pose, rotation, standing
from motionmend.bodies.surface import render
from motionmend.track.person.company import told_beforehand
from motionmend.track.person.foreground import find_person, scene_of
from motionmend.track.person.standing import with_furniture

BOX = np.s_[120:240, 225:320]  # px, on the floor 1.9 m away, as tall as a table and wider than a person


def _frames(rng, poses, box=True):
    """The person in a room with a large box nearer than they are."""
    frames = []
    for k, pose in enumerate(poses):
        depth = np.array(in_room(picture(pose, rng=rng), rng=rng).depth)
        if box:
            front = np.full(depth[BOX].shape, 1.9)
            front[:, ::2] += 0.06  # slats, for a flat one is a board
            front += rng.normal(0, 0.0015, front.shape) * front**2
            depth[BOX] = np.fmin(depth[BOX], front.astype(np.float32))
        frames.append(DepthFrame(CAMERA, depth, None, k / 30.0))
    return frames


def _explained(scene, frame, pose):
    """Share of the person's pixels that are found, and of what is found that is theirs."""
    found = np.isfinite(find_person(scene, frame).depth)
    theirs = np.isfinite(render(PERSON, pose, CAMERA).depth)
    return (found & theirs).sum() / theirs.sum(), (found & theirs).sum() / max(found.sum(), 1)


def test_a_box_nearer_and_larger_than_who_walks_is_furniture(rng):
    poses = [standing((x, 0.1, 2.9)) for x in np.linspace(-1.0, 0.2, 12)]
    frames = _frames(rng, poses)
    assert _explained(scene_of(frames[0]), frames[0], poses[0])[0] < 0.5  # the box is more like a body
    scene = with_furniture(frames)
    for k in (0, 5, 11):
        assert min(_explained(scene, frames[k], poses[k])) > 0.9


@pytest.mark.parametrize("moves", ["arms", "hardly"])
def test_a_table_before_the_person_is_furniture_though_they_are_more_like_a_body(rng, moves):
    """Learned as background up to a hand's breadth beside them, what is left of it would pass for a limb."""
    base, v, u = standing((-0.2, 0.1, 2.7)), *np.mgrid[:240, :320]
    much = [base.joints + rng.normal(0, 0.02, 28) if moves == "hardly" else random_joints(rng) for _ in range(12)]
    for own in much:
        own[-8:] = base.joints[-8:] + rng.normal(0, 0.02, 8)  # legs
    poses = [Pose(base.translation, base.root, joints) for joints in much]
    top = (v >= 150) & (v < 162) & (u >= 118) & (u < 270)
    legs = (v >= 162) & ((u >= 118) & (u < 127) | (u >= 261) & (u < 270))
    away = np.where(top, 1.9 + 0.4 * (162 - v) / 12, np.where(legs, 1.9, np.inf))
    frames = []
    for frame in _frames(rng, poses, box=False):
        noise = rng.normal(0, 0.0015, away.shape) * np.where(np.isfinite(away), away, 0.0) ** 2
        frames.append(DepthFrame(CAMERA, np.fmin(frame.depth, (away + noise).astype(np.float32)), None, frame.time))
    scene = with_furniture(frames)
    assert scene is not None
    for k in (0, 5, 11):
        found = find_person(scene, frames[k])
        theirs = np.isfinite(render(PERSON, poses[k], CAMERA).depth) & ~np.isfinite(away)
        assert (np.isfinite(found.depth) & ~theirs).sum() < 0.08 * theirs.sum()
        above = theirs & (v < 150)
        assert (np.isfinite(found.depth) & above).sum() > 0.9 * above.sum()
        assert not found.free[top | legs].any()  # it may hide them


def test_the_feet_of_who_moves_only_the_arms_are_theirs(rng):
    base = standing((-0.6, 0.1, 2.9))
    joints = [random_joints(rng) for _ in range(12)]
    poses = []
    for own in joints:
        own[-8:] = base.joints[-8:]  # both legs
        poses.append(Pose(base.translation, base.root, own))
    scene = with_furniture(_frames(rng, poses))
    for k in (0, 11):
        assert min(_explained(scene, _frames(rng, poses)[k], poses[k])) > 0.9


@pytest.mark.parametrize("box", [False, True])
def test_where_nobody_moves_or_nothing_stands_nothing_is_known(rng, box):
    steps = np.zeros(8) if box else np.linspace(-0.8, 0.4, 8)
    assert with_furniture(_frames(rng, [standing((-0.6 + x, 0.1, 2.9)) for x in steps], box)) is None
    assert with_furniture(_frames(rng, [standing((0.0, 0.1, 2.9))] * 2, box)) is None


def test_frames_of_several_sizes_tell_nothing(rng):
    poses = [standing((x, 0.1, 2.9)) for x in np.linspace(-1.0, 0.2, 4)]
    frames = _frames(rng, poses)
    small = DepthFrame(CAMERA.every(2), frames[1].depth[::2, ::2], None, 0.5)
    assert with_furniture([*frames, small]) is None


@pytest.mark.parametrize("sways", [False, True])
def test_who_stands_still_while_somebody_walks_by_is_no_furniture_unless_they_never_sway(rng, sways):
    base = standing((-0.6, 0.1, 2.4))
    feet = np.array([-0.6, 1.0, 2.4])
    frames = []
    for k, x in enumerate(np.linspace(0.3, 1.2, 24)):
        lean = rotation(np.array([np.radians(0.6) * np.sin(1.3 * k) * sways, 0.0, 0.0]))
        still = Pose(lean @ (base.translation - feet) + feet, lean @ base.root, base.joints)
        passer = standing((-0.6, 0.1, 1.7) if k == 5 else (x, 0.1, 3.0))  # for a moment right before them
        both = np.fmin(picture(still, rng=rng).depth, picture(passer, rng=rng).depth)
        frames.append(in_room(DepthFrame(CAMERA, both, None, k / 30.0), rng=rng))
    assert (with_furniture(frames) is None) == sways


NOBODY = DepthFrame(CAMERA, np.full((CAMERA.height, CAMERA.width), np.nan, np.float32))
UPRIGHT = np.s_[50:215, 130:175]  # px, of a round column, 2 m away


def _alone(rng, shown, step=0.3):
    """Frames of a room with somebody, or a column where they are None."""
    frames = []
    for k, pose in enumerate(shown):
        depth = np.array(in_room(NOBODY if pose is None else picture(pose, rng=rng), rng=rng).depth)
        if pose is None:
            depth[UPRIGHT] = 2.0 + 0.25 * np.linspace(-1, 1, 45) ** 2 + rng.normal(0, 0.006, depth[UPRIGHT].shape)
        frames.append(DepthFrame(CAMERA, depth, None, k * step))
    return frames


def test_what_is_alone_in_a_room_and_never_moves_is_said_to_be_still_unless_somebody_sways(rng):
    frames = _alone(rng, [None] * 12)
    assert told_beforehand(frames).still
    assert told_beforehand(frames, np.array([0.0, 0.0, 2.0])) is None  # pointed at
    assert told_beforehand(_alone(rng, [None] * 12, step=0.15)).still  # 1.6 s
    assert told_beforehand(_alone(rng, [None] * 12, step=0.1)) is None  # 1.1 s
    base, feet = standing((0.0, 0.1, 2.4)), np.array([0.0, 1.0, 2.4])
    leans = [rotation(np.array([np.radians(0.4) * np.sin(1.3 * k), 0.0, 0.0])) for k in range(12)]
    swaying = [Pose(lean @ (base.translation - feet) + feet, lean @ base.root, base.joints) for lean in leans]
    assert told_beforehand(_alone(rng, swaying)) is None
    assert told_beforehand(_alone(rng, [base] * 12)).still  # a dummy
