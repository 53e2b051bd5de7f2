"""Reaching with the performer: what is in reach, what is not, and against a general solver."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import least_squares

import naive_body
from motionmend.bodies import anatomy
from motionmend.bodies import performer as bodies
from motionmend.kernels import articulated

PERSON = anatomy.average()
SEEDS = st.integers(0, 2**32 - 1)


def reach(targets, weights, hold, pose, rounds=40):
    posed = pose.arrays
    cost = articulated.reach(
        PERSON.chain,
        bodies.MOVES.copy(),
        *PERSON.marks,
        targets,
        weights,
        hold,
        bodies.LIMITS.copy(),
        rounds,
        posed,
    )
    return cost, bodies.Pose(*posed)


def near(pose, rng, much):
    delta = much * rng.normal(size=34)
    moved = bodies.advance(PERSON, pose, delta)
    return bodies.Pose(moved.translation, moved.root, np.clip(moved.joints, *(0.95 * bodies.LIMITS[6:].T)))


@pytest.mark.slow
def test_joints_within_reach_are_reached():
    """Nearly always: now and then two limits of one arm make a corner that no small step leads out of."""
    missed = []
    for seed in range(60):
        rng = np.random.default_rng(seed)
        goal = near(bodies.standing(), rng, 0.25)
        targets = bodies.landmarks(PERSON, goal)
        _, found = reach(targets, np.ones(16), np.full(34, 1e-5), near(goal, rng, 0.1))
        missed.append(np.abs(bodies.landmarks(PERSON, found) - targets).max())
        assert np.all(found.joints >= bodies.LIMITS[6:, 0] - 1e-9)
        assert np.all(found.joints <= bodies.LIMITS[6:, 1] + 1e-9)
    assert np.quantile(missed, 0.9) < 1e-3


def missed_by_scipy(begin, targets, seen, hold):
    """The least cost that a general solver finds from the same start within the same limits."""

    def residual(delta):
        moved = naive_body.advance(begin.translation, begin.root, begin.joints, delta)
        frames = naive_body.frames(PERSON.chain, *moved)
        at = np.einsum("nij,nj->ni", frames[bodies.LANDMARK_BONES, :3, :3], PERSON.landmark_place)
        at += frames[bodies.LANDMARK_BONES, :3, 3]
        return np.concatenate(((at - targets)[seen].ravel(), hold * delta))

    room = bodies.LIMITS - np.concatenate((np.zeros(6), begin.joints))[:, None]
    return 2 * least_squares(residual, np.zeros(34), bounds=(room[:, 0], room[:, 1]), max_nfev=15).cost


@pytest.mark.slow
def test_targets_out_of_reach_are_missed_by_as_little_as_scipy_misses_them():
    ratios = []
    for seed in range(7):
        rng = np.random.default_rng(seed)
        begin = near(bodies.standing(), rng, 0.1)
        targets = bodies.landmarks(PERSON, begin) + 0.03 * rng.normal(size=(16, 3))
        weights, hold = np.where(rng.random(16) < 0.2, 0.0, 1.0), np.full(34, 0.02)
        seen = weights > 0
        cost, found = reach(np.where(seen[:, None], targets, np.nan), weights, hold, begin)
        miss = np.linalg.norm((bodies.landmarks(PERSON, found) - targets)[seen], axis=1)
        assert np.square(miss).sum() <= cost + 1e-9
        ratios.append(cost / missed_by_scipy(begin, targets, seen, hold))
    assert np.median(ratios) < 1.02
    assert max(ratios) < 1.5


def test_nothing_asked_changes_nothing():
    begin = bodies.standing()
    cost, found = reach(np.full((16, 3), np.nan), np.zeros(16), np.full(34, 0.02), begin)
    assert cost == 0.0
    np.testing.assert_array_equal(found.joints, begin.joints)


@settings(max_examples=20, deadline=None)
@given(SEEDS)
def test_points_ride_on_their_bones(seed):
    rng = np.random.default_rng(seed)
    pose = near(bodies.standing(), rng, 0.5)
    bones, local = rng.integers(0, 15, 9), rng.normal(size=(9, 3))
    world = np.empty((9, 3))
    articulated.points(bodies.bone_frames(PERSON, pose), bones, local, world)
    frames = naive_body.frames(PERSON.chain, pose.translation, pose.root, pose.joints)
    expected = np.einsum("nij,nj->ni", frames[bones, :3, :3], local) + frames[bones, :3, 3]
    np.testing.assert_allclose(world, expected, rtol=0, atol=1e-12)


@settings(max_examples=20, deadline=None)
@given(SEEDS)
def test_points_of_many_poses_are_those_of_each(seed):
    rng = np.random.default_rng(seed)
    joints = rng.uniform(-1.5, 1.5, (4, len(bodies.AXES)))
    world = np.empty((4, len(bodies.LANDMARKS), 3))
    articulated.upright(PERSON.chain, joints, *PERSON.marks, world)
    each = [bodies.landmarks(PERSON, bodies.Pose(np.zeros(3), np.eye(3), row)) for row in joints]
    np.testing.assert_array_equal(world, each)
