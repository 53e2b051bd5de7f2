"""A body that is followed wrongly is not said to be sure, however usual it has become."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionmend.bodies.camera import KINECT, DepthFrame
from motionmend.bodies.performer import LANDMARKS, Pose, landmarks, rotation
from motionmend.bodies.surface import render
from motionmend.numerics.neighbors import Neighbors
from motionmend.track.hindsight.backwards import moment, revised
from motionmend.track.misread import HELD, OFF, held, misread, odds_misread
from motionmend.track.readings.facing import about_face
from motionmend.track.settings import settings_of
from motionmend.track.tracker import start, step
from walkers import BODY, DT, as_sensed, column, library, walk

ODDS = st.floats(-30.0, 30.0)
SURE = 0.05  # m


def twisted(pose):
    """The pose read the other way round, the pelvis turned to the side and the legs against it."""
    pose = about_face(BODY, pose)
    joints = np.array(pose.joints)
    joints[column("chest", 1)] = 1.1
    joints[column("l_thigh", 1)] -= 1.0
    joints[column("r_thigh", 1)] -= 1.0
    return Pose(pose.translation, rotation(np.array([0.0, 1.6, 0.0])) @ pose.root, joints)


@pytest.fixture(scope="module")
def recordings():
    """Live estimates, the same looked back at, and true joints, of a walk taken up rightly and wrongly.

    Within a second the right pose is found by itself; nothing of that is looked at.
    """
    return {kind: followed(kind) for kind in ("rightly", "wrongly")}


def followed(kind):
    poses, settings, model = walk(16, 75.0), settings_of(), library()
    state, moments = None, []
    for k, pose in enumerate(poses):
        frame = DepthFrame(KINECT, as_sensed(render(BODY, pose, KINECT).depth, KINECT, 0, k), None, k * DT)
        if state is None:
            first = pose if kind == "rightly" else twisted(pose)
            state = replace(start(model, settings, frame, BODY, first), wrong=0.2 if kind == "rightly" else 0.4)
        state, estimate = step(model, settings, state, frame)
        moments.append(moment(state, estimate))
    truth = np.array([landmarks(BODY, pose) for pose in poses])
    return [one.estimate for one in moments], list(revised(model, settings, moments)), truth


@pytest.mark.parametrize("looked_back", [False, True])
def test_who_is_followed_wrongly_is_not_said_to_be_sure(recordings, looked_back):
    """What it explains wrongly is usual by then, and each limb lies on something."""
    told, truth = recordings["wrongly"][looked_back], recordings["wrongly"][2]
    joints, std = (np.array([getattr(one, name) for one in told]) for name in ("landmarks", "std"))
    far = np.linalg.norm(joints - truth, axis=2) > 0.15
    assert far.sum() > 40
    assert (far & (std < SURE)).sum() < 0.02 * far.sum()


@pytest.mark.parametrize("looked_back", [False, True])
def test_who_is_followed_rightly_is_as_sure_as_before(recordings, looked_back):
    told, truth = recordings["rightly"][looked_back], recordings["rightly"][2]
    joints, std = (np.array([getattr(one, name) for one in told]) for name in ("landmarks", "std"))
    assert np.linalg.norm(joints - truth, axis=2).mean() < 0.03
    assert (std < SURE).mean() > 0.9


@given(ODDS, ODDS)
def test_the_likelier_it_is_the_less_sure_and_never_lost_by_that_alone(one, other):
    less, more = misread(min(one, other)), misread(max(one, other))
    assert (less <= more).all()
    assert (more < OFF + 1e-9).all()
    assert misread(-float("inf")).max() == 0.0
    assert less[LANDMARKS.index("pelvis")] <= less[LANDMARKS.index("l_knee")]


@given(ODDS, ODDS, st.lists(st.floats(0.0, 0.5), min_size=1, max_size=8))
def test_a_moment_counts_little_and_times_add_up(odds, now, parts):
    once, bit_by_bit = held(odds, now, sum(parts)), odds
    for elapsed in parts:
        bit_by_bit = held(bit_by_bit, now, elapsed)
    assert once == pytest.approx(bit_by_bit, abs=1e-9)
    assert min(odds, now) - 1e-9 <= once <= max(odds, now) + 1e-9
    assert abs(held(odds, now, 0.033) - odds) <= 0.033 / HELD * abs(now - odds) + 1e-9


def test_the_first_frame_is_all_that_is_known_and_without_a_library_nothing_is():
    assert held(float("nan"), 2.0, 0.0) == 2.0
    pose = walk(1, 0.0)[0]
    assert odds_misread(Neighbors(np.empty((0, 28))), pose, 0.9) == -float("inf")
    assert held(1.0, -float("inf"), 0.03) == -float("inf")
