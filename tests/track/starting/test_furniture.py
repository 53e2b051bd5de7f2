"""What was followed and stands there still when the person is elsewhere."""

from dataclasses import replace

import numpy as np
import pytest

import motionmend as mm
from drawn_people import CAMERA, PERSON, in_room, picture
from motionmend.bodies.camera import DepthFrame
from motionmend.bodies.performer import Poses, standing
from motionmend.track.database import PoseDatabase
from motionmend.track.recording import Told
from motionmend.track.settings import settings_of
from motionmend.track.starting.furniture import Room, is_furniture
from motionmend.track.tracker import start, step

PLACES = [(-0.7, 0.1, 2.6), (0.6, 0.1, 2.6), (0.7, 0.1, 2.4)]
POSES = [standing(place) for place in PLACES]
NOBODY = DepthFrame(CAMERA, np.full((CAMERA.height, CAMERA.width), np.nan, np.float32))


def _poses():
    return Poses(*(np.array([getattr(pose, name) for pose in POSES]) for name in ("translation", "root", "joints")))


def test_only_what_stands_where_the_room_has_a_surface_is_furniture(rng):
    seen = np.ones(3, dtype=bool)
    statue = np.array(in_room(picture(POSES[0], rng=rng), rng=rng).depth) + 0.04  # a body is fitted to it, not it
    bare = np.array(in_room(NOBODY, rng=rng).depth)
    assert is_furniture(Room(CAMERA, statue), PERSON, _poses(), seen).tolist() == [True, False, False]
    assert is_furniture(Room(CAMERA, statue), PERSON, _poses(), ~seen).tolist() == [False] * 3
    for nothing in (bare, np.full(bare.shape, np.nan, np.float32)):
        assert not is_furniture(Room(CAMERA, nothing), PERSON, _poses(), seen).any()


def test_frames_in_which_it_was_followed_are_empty(rng):
    model = mm.TrackerModel(PoseDatabase(np.array([pose.joints for pose in POSES]), np.full(3, 2)))
    told = Told()
    for k, pose in enumerate(POSES):
        frame = DepthFrame(CAMERA, in_room(picture(pose, rng=rng), rng=rng).depth, None, k / 30.0)
        state = start(model, settings_of(), frame, PERSON, pose)
        told.add(step(model, settings_of(), state, frame)[1])
    room = Room(CAMERA, np.array(in_room(picture(POSES[0], rng=rng), rng=rng).depth))
    tracked = told.tracked(np.arange(3) / 30.0, PERSON, room, steady=False)
    assert tracked.mistaken.tolist() == [True, False, False]
    assert tracked.flags[0] == ("empty",)
    assert tracked.seen.tolist() == [False, True, True]
    assert np.isnan(tracked.joints[0]).all()
    assert np.isnan(tracked.std[0]).all()
    assert np.isnan(tracked.poses[0].translation).all()
    assert np.linalg.norm(tracked.joints[1:, 0] - np.array(PLACES)[1:], axis=1).max() < 0.1


@pytest.mark.parametrize("wrong", [0.15, 0.4])
def test_what_never_moves_is_nobody_where_no_body_explains_it_and_else_it_is_said(rng, wrong):
    model = mm.TrackerModel(PoseDatabase(np.array([pose.joints for pose in POSES]), np.full(3, 2)))
    told, frame = Told(), DepthFrame(CAMERA, in_room(picture(POSES[0], rng=rng), rng=rng).depth)
    estimate = step(model, settings_of(), start(model, settings_of(), frame, PERSON, POSES[0]), frame)[1]
    for _ in range(6):
        told.add(replace(estimate, wrong=wrong))
        told.company.append(False)
        told.moved.append(False)
    nothing = np.full(frame.depth.shape, np.nan, np.float32)
    for still in (True, False):
        tracked = told.tracked(np.arange(6) / 30.0, PERSON, Room(CAMERA, nothing, still), steady=False)
        assert tracked.mistaken.all() == (still and wrong > 0.3)
        assert any("never moves" in said for said in tracked.warnings) == (still and wrong < 0.3)
