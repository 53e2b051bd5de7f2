"""A recording through the library's one call: the same as step by step, as the command has it, and NaN for nobody."""

from dataclasses import replace

import numpy as np
import pytest

import motionmend as mm
from motionmend.bodies import anatomy
from motionmend.bodies.camera import KINECT, Camera, DepthFrame
from motionmend.bodies.performer import DOFS, LANDMARKS, advance, landmarks, standing
from motionmend.bodies.surface import render
from motionmend.track.database import PoseDatabase
from motionmend.track.hindsight.backwards import moment, revised
from motionmend.track.person.room import scene_of
from motionmend.track.recording import UNSURE, Told, follow
from motionmend.track.settings import settings_of
from motionmend.track.starting.furniture import Room
from motionmend.track.tracker import start, step

BODY = anatomy.average()
FRAMES = 14


def walked():
    """Somebody who steps aside and turns, and images of it."""
    speed = np.zeros(DOFS)
    speed[[0, 4, 12, 20]] = 0.3, 0.4, 0.5, 0.4
    poses = [advance(BODY, standing((0.0, 0.1, 2.6)), speed * t / 30.0) for t in range(FRAMES)]
    return poses, [DepthFrame(KINECT, render(BODY, pose, KINECT).depth, None, t / 30.0) for t, pose in enumerate(poses)]


TRUE, IMAGES = walked()
MODEL = mm.TrackerModel(PoseDatabase(np.array([pose.joints for pose in TRUE]), np.full(FRAMES, FRAMES - 1)))
PLACES = np.array([landmarks(BODY, pose) for pose in TRUE])


def test_a_recording_is_followed_to_where_the_body_is():
    tracked = mm.track.follow(MODEL, iter(IMAGES), BODY, TRUE[0])
    assert tracked.seen.all()
    assert np.linalg.norm(tracked.joints - PLACES, axis=2).mean() < 0.005
    assert np.array_equal(tracked.times, [frame.time for frame in IMAGES])
    assert tracked.std.shape == tracked.held.shape == PLACES.shape[:2]
    assert len(tracked.poses) == len(tracked.flags) == len(tracked.company) == len(tracked.moved) == FRAMES
    assert not (tracked.company | tracked.moved).any()


def test_numbers_of_time_and_camera_may_be_numpys_own():
    """As of `np.arange(60) / 30` and a matrix of a calibration; somebody else is seen, too."""
    camera = Camera(KINECT.width, KINECT.height, *np.array([KINECT.fx, KINECT.fy, KINECT.cx, KINECT.cy]))
    frame = DepthFrame(camera, IMAGES[0].depth, None, np.float64(0.0))
    told = Told()
    told.saw(replace(scene_of(frame), others=frame.depth), frame)
    assert list(told.company) == [True]
    assert list(told.moved) == [False]


@pytest.mark.slow
@pytest.mark.parametrize("preset", ["default", "paper"])
def test_it_is_step_by_step_and_then_looked_back_at(preset):
    wish = settings_of(preset)
    tracked = follow(MODEL, IMAGES, BODY, TRUE[0], wish)
    state, moments = start(MODEL, wish, IMAGES[0], BODY, TRUE[0]), []
    for frame in IMAGES:
        state, estimate = step(MODEL, wish, state, frame)
        moments.append(moment(state, estimate))
    said = list(revised(MODEL, wish, moments))
    assert tracked.flags == tuple(tuple(one.flags) for one in said)
    assert np.array_equal(tracked.performer.solids.size, state.performer.solids.size)
    unsteadied = np.array([one.landmarks for one in said])
    assert np.linalg.norm(tracked.joints - unsteadied, axis=2).max() < (0.03 if wish.steady else 1e-12)


def test_frames_without_anybody_have_no_joints_and_the_others_keep_theirs():
    empty = [DepthFrame(KINECT, np.full((KINECT.height, KINECT.width), np.nan), None, t / 30.0) for t in range(FRAMES)]
    tracked = follow(MODEL, [*IMAGES[:6], *empty[6:9], *IMAGES[9:]], BODY, TRUE[0])
    assert not tracked.seen[6:9].any()
    assert all("empty" in flags for flags in tracked.flags[6:9])
    assert np.isnan(tracked.joints[6:9]).all()
    assert np.isnan(tracked.std[6:9]).all()
    assert tracked.seen[:6].all()
    assert np.isfinite(tracked.joints[:6]).all()


def test_where_the_body_is_lost_no_joint_is_said_to_be_known():
    told = Told()
    state = start(MODEL, settings_of(), IMAGES[0], BODY, TRUE[0])
    _, estimate = step(MODEL, settings_of(), state, IMAGES[0])
    for flags in (("tracked",), ("lost",)):
        told.add(type(estimate)(**{**vars(estimate), "flags": flags}))
    tracked = told.tracked(np.array([0.0, 0.1]), BODY, steady=False)
    assert tracked.seen.tolist() == [True, False]
    assert (tracked.std[1] >= UNSURE).all()
    assert tracked.std[0].min() < UNSURE


def test_of_what_never_sways_and_is_half_explained_no_joint_is_said_to_be_known():
    """A coat rack explains nearly as much as somebody does; who stands still and is explained is only said to."""
    _, estimate = step(MODEL, settings_of(), start(MODEL, settings_of(), IMAGES[0], BODY, TRUE[0]), IMAGES[0])
    nothing = np.full((KINECT.height, KINECT.width), np.nan, np.float32)
    for wrong, still, known in ((0.28, False, True), (0.19, True, True), (0.28, True, False)):
        told = Told()
        for _ in range(FRAMES):
            told.add(replace(estimate, wrong=wrong))
        tracked = told.tracked(np.arange(FRAMES) / 30, BODY, Room(KINECT, nothing, still), steady=False)
        assert tracked.seen.all()
        assert (tracked.std.min() < UNSURE) == known


def test_what_was_never_seen_is_not_said_to_be_known():
    """Legs behind a desk from the first frame on had to be out of sight for half a second first."""
    wish, head = settings_of(), LANDMARKS.index("head")
    legs = [LANDMARKS.index(f"{side}_{joint}") for side in "lr" for joint in ("knee", "ankle")]
    depth = np.array(IMAGES[0].depth)
    depth[130:] = 1.5  # nearer than the person
    behind = DepthFrame(KINECT, depth, None, 0.0)
    given = start(MODEL, wish, behind, BODY, TRUE[0])
    never = start(replace(MODEL, detector=object()), wish, behind, BODY).hidden
    for hidden in (given.hidden, never):
        _, estimate = step(MODEL, wish, replace(given, hidden=hidden), behind)
        assert estimate.std[head] < 0.05
        assert (estimate.std[legs] >= UNSURE).all() == (hidden is never)


def test_a_recording_without_frames_is_refused():
    with pytest.raises(mm.MismatchError, match="came none"):
        mm.track.follow(MODEL, [], BODY)
