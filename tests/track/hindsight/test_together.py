"""Frames solved together: exact where images are, nearer to the truth where they are not, and bound to nothing else."""

from dataclasses import replace

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from motionmend.bodies import anatomy
from motionmend.bodies.camera import KINECT, DepthFrame
from motionmend.bodies.performer import BONES, DOFS, LANDMARKS, advance, landmarks, standing
from motionmend.bodies.surface import render
from motionmend.evaluate.sensor import sensed
from motionmend.numerics.chained import chained
from motionmend.track.database import PoseDatabase
from motionmend.track.frame.evidence import evidence_of
from motionmend.track.frame.observation import Observation
from motionmend.track.hindsight import together
from motionmend.track.hindsight.together import between_turns, solved_together
from motionmend.track.limbs.other_poses import LIMBS
from motionmend.track.model import TrackerModel
from motionmend.track.settings import settings_of
from motionmend.track.tracker import start

BODY = anatomy.average()
DEFAULT = settings_of("default")
FRAMES = 12
L_ARM = LIMBS[0]


def moving(frames=FRAMES):
    """Somebody who steps aside, turns and raises the left arm."""
    speed = np.zeros(DOFS)
    speed[[0, 4]] = 0.3, 0.4
    speed[6 + L_ARM.columns] = 0.5
    return [advance(BODY, standing((0.0, 0.1, 2.6)), speed * (0.3 + t / 30.0)) for t in range(frames)]


def states_of(poses, noise=None, body=BODY, times=None, keep=lambda depth, t: depth):
    """What the tracker keeps of frames that show a body."""
    states = []
    for t, pose in enumerate(poses):
        depth = render(body, pose, KINECT).depth
        depth = keep(depth if noise is None else sensed(depth, KINECT, noise, t), t)
        time = t / 30.0 if times is None else times[t]
        free = np.isnan(render(body, pose, KINECT).depth)  # what is not measured is not known to be free
        seen = Observation(KINECT, depth, free, time)
        evidence = evidence_of(seen, DEFAULT)
        state = start(MODEL, DEFAULT, DepthFrame(KINECT, depth, None, time), body, pose)
        states.append(replace(state, observation=seen, evidence=evidence, time=time))
    return states


def off(poses, truth):
    """(T, 16) m."""
    return np.array(
        [np.linalg.norm(landmarks(BODY, a) - landmarks(BODY, b), axis=1) for a, b in zip(poses, truth, strict=True)]
    )


TRUE = moving()
MODEL = TrackerModel(PoseDatabase(np.array([pose.joints for pose in TRUE]), np.full(FRAMES, FRAMES - 1)))


def jittered(poses, much=0.02, seed=0):
    rng = np.random.default_rng(seed)
    return [advance(BODY, pose, much * rng.normal(size=DOFS)) for pose in poses]


@pytest.mark.slow
def test_the_truth_stays_and_what_is_beside_it_comes_back():
    states = states_of(TRUE)
    assert off(solved_together(MODEL, DEFAULT, BODY, states, TRUE), TRUE).max() < 0.003
    begun = jittered(TRUE)
    solved = off(solved_together(MODEL, DEFAULT, BODY, states, begun), TRUE)
    assert solved.mean() < 0.4 * off(begun, TRUE).mean()


def test_threads_of_the_linear_algebra_do_not_wait_for_the_cores_that_frames_need(monkeypatch):
    used = []

    def watched(*args):
        used.extend(one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas")
        return chained(*args)

    monkeypatch.setattr(together, "chained", watched)
    states = states_of(TRUE)
    with threadpool_limits(2, user_api="blas"):
        solved_together(MODEL, DEFAULT, BODY, states, TRUE)
        after = {one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"}
    assert set(used) == {1}
    assert after == {2}


def test_what_slid_along_itself_comes_back():
    """Along limbs matches say little, and steps as Gauss-Newton has them would be left half way."""
    aside = np.zeros(DOFS)
    aside[1] = 0.04
    begun = [advance(BODY, pose, aside) for pose in TRUE]
    assert off(solved_together(MODEL, DEFAULT, BODY, states_of(TRUE), begun), TRUE).mean() < 0.2 * 0.04


@pytest.mark.slow
def test_noise_that_neighbours_do_not_share_is_shared_out():
    states = states_of(TRUE, noise=0)
    together = solved_together(MODEL, DEFAULT, BODY, states, TRUE)
    apart = [
        solved_together(MODEL, DEFAULT, BODY, [state], [pose])[0] for state, pose in zip(states, TRUE, strict=True)
    ]
    assert off(together, TRUE).mean() < off(apart, TRUE).mean()
    jerks = [np.diff([landmarks(BODY, pose) for pose in some], 2, axis=0) for some in (together, apart)]
    assert np.abs(jerks[0]).mean() < 0.75 * np.abs(jerks[1]).mean()


@pytest.mark.slow
def test_a_poor_library_hardly_draws_a_limb_that_is_seen():
    still = TrackerModel(PoseDatabase(np.repeat(standing((0.0, 0.1, 2.6)).joints[None], 50, axis=0), np.full(50, 49)))
    states = states_of(TRUE, noise=1)
    arm = [int(joint) for joint in L_ARM.landmarks]
    assert off(solved_together(still, DEFAULT, BODY, states, TRUE), TRUE)[:, arm].mean() < 0.01


@pytest.mark.slow
@pytest.mark.parametrize("gone", [1, 5])
def test_frames_without_anybody_stay_and_bind_nothing(gone):
    states, begun = states_of(TRUE, noise=2), jittered(TRUE)
    some = [None if t == gone else pose for t, pose in enumerate(begun)]
    told = solved_together(MODEL, DEFAULT, BODY, states, some)
    assert told[gone] is None
    for part in (slice(0, gone), slice(gone + 1, None)):
        alone = solved_together(MODEL, DEFAULT, BODY, states[part], some[part])
        for one, other in zip(told[part], alone, strict=True):
            np.testing.assert_array_equal(one.joints, other.joints)


@pytest.mark.slow
def test_a_pause_binds_nothing():
    times = [t / 30.0 + (1.0 if t >= 6 else 0.0) for t in range(FRAMES)]
    states, begun = states_of(TRUE, noise=2, times=times), jittered(TRUE)
    told = solved_together(MODEL, DEFAULT, BODY, states, begun)
    alone = solved_together(MODEL, DEFAULT, BODY, states[:6], begun[:6])
    for one, other in zip(told[:6], alone, strict=True):
        np.testing.assert_array_equal(one.joints, other.joints)


@pytest.mark.slow
def test_a_limb_out_of_sight_goes_on_between_where_it_is_seen():
    arm = [BONES.index(f"l_{bone}") for bone in ("upperarm", "forearm")]

    def keep(depth, t):
        shown = np.isin(render(BODY, TRUE[t], KINECT).bones, arm)
        return np.where(shown & (4 <= t < 8), np.nan, depth).astype(np.float32)

    states = states_of(TRUE, keep=keep)
    begun = [
        replace(pose, joints=pose.joints + np.where(np.isin(np.arange(DOFS - 6), L_ARM.columns), 0.1, 0.0))
        if 4 <= t < 8
        else pose
        for t, pose in enumerate(TRUE)
    ]
    solved = solved_together(MODEL, DEFAULT, BODY, states, begun)
    wrist = LANDMARKS.index("l_wrist")
    assert off(solved, TRUE)[4:8, wrist].mean() < 0.6 * off(begun, TRUE)[4:8, wrist].mean()


@pytest.mark.slow
def test_few_pixels_do_not_bend_the_way_of_a_limb_that_is_as_good_as_out_of_sight(monkeypatch):
    """Pixels of another limb are near enough to draw at it; how well it was shown says how far to follow them."""
    forearm, wrist = BONES.index("l_forearm"), LANDMARKS.index("l_wrist")
    astray = np.where(np.isin(np.arange(DOFS), 6 + L_ARM.columns), 0.15, 0.0)

    def keep(depth, t):
        if not 4 <= t < 8:
            return depth
        wrong = render(BODY, advance(BODY, TRUE[t], astray), KINECT)
        few = (np.add(*np.indices(depth.shape)) % 5 == 0) & (wrong.bones == forearm)
        gone = np.isin(render(BODY, TRUE[t], KINECT).bones, L_ARM.bones)
        return np.where(few, wrong.depth, np.where(gone, np.nan, depth)).astype(np.float32)

    trust = np.where(np.isin(np.arange(DOFS - 6), L_ARM.columns), 0.1, 1.0)
    states = [
        replace(state, trust=trust) if 4 <= t < 8 else replace(state, trust=np.ones(DOFS - 6))
        for t, state in enumerate(states_of(TRUE, keep=keep))
    ]
    away = []
    for much in (together.UNSEEN, 0.0):
        monkeypatch.setattr(together, "UNSEEN", much)
        away.append(off(solved_together(MODEL, DEFAULT, BODY, states, TRUE), TRUE)[4:8, wrist].mean())
    assert away[0] < 0.7 * away[1], away


@pytest.mark.slow
def test_a_leap_is_left_a_leap():
    """Two still poses, one after the other: neither is drawn to the other by what binds frames."""
    first, other = TRUE[0], advance(BODY, TRUE[0], np.where(np.isin(np.arange(DOFS), 6 + L_ARM.columns), 0.4, 0.0))
    leaping = [first] * 6 + [other] * 6
    assert off(solved_together(MODEL, DEFAULT, BODY, states_of(leaping), leaping), leaping).max() < 0.02


def test_half_way_between_turns_is_as_far_from_either():
    a, b = TRUE[0].root, TRUE[-1].root
    middle = between_turns(a, b, 0.5)
    np.testing.assert_allclose(middle @ middle.T, np.eye(3), atol=1e-12)
    assert np.trace(middle.T @ a) == pytest.approx(np.trace(middle.T @ b))
    np.testing.assert_allclose(between_turns(a, b, 1.0), b, atol=1e-12)
