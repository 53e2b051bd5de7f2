"""How sure the root is in the file's own channels."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from motionmend.bodies.motion import Motion
from motionmend.denoise import repair_without_model
from motionmend.denoise.channels.joints import joint_channels, own_middle, root_angles, root_rows
from motionmend.denoise.channels.root_deviations import ANY_ANGLE, root_deviations
from motionmend.denoise.channels.travel import Travel
from motionmend.evaluate import corrupt
from performers import joints_model, truth


@pytest.mark.slow
@given(st.integers(0, 2**31), st.floats(-1.2, 1.2), st.floats(-np.pi, np.pi))
@settings(max_examples=60, deadline=None)
def test_deviations_of_turns_are_those_of_small_changes_of_the_rotation_vector(seed, tilt, heading):
    """Against differences; the frame faces elsewhere, and the middle angle stays away from its pole."""
    clean = truth("walk", seconds=0.2)
    skeleton = clean.skeleton
    turns, _ = root_rows(skeleton)
    rng = np.random.default_rng(seed)
    q = clean.q[:1].copy()
    q[0, turns] = rng.uniform(-np.pi, np.pi), tilt, rng.uniform(-np.pi, np.pi)
    frame = Travel(np.zeros((1, 3)), np.array([heading]), skeleton.up)
    std = np.full(q.shape, 0.1)
    std[0, turns] = rng.uniform(0.01, 0.1, 3)
    nothing = np.zeros(q.shape[1])
    found = root_deviations(std, nothing, frame, Motion(skeleton, q, 30.0), q, nothing.astype(bool))[0, turns]

    axes, heads = skeleton.dof_axis[turns], Rotation.from_rotvec(heading * skeleton.up)
    whole = Rotation.identity()
    for axis, angle in zip(axes, q[0, turns], strict=True):
        whole = whole * Rotation.from_rotvec(angle * axis)
    vector = (heads.inv() * whole).as_rotvec()
    if np.linalg.norm(vector) > 3.0:  # the vector leaps at half a turn
        return
    variance = np.zeros(3)
    for axis in range(3):
        ends = []
        for step in (-1e-5, 1e-5):
            there = heads * Rotation.from_rotvec(vector + step * np.eye(3)[axis])
            ends.append(root_angles(skeleton, turns, there.as_matrix()[None])[0])
        change = (ends[1] - ends[0] + 180.0) % 360.0 - 180.0
        variance += np.square(np.radians(change) / 2e-5 * std[0, turns[axis]])
    np.testing.assert_allclose(found, np.minimum(np.sqrt(variance), ANY_ANGLE), rtol=1e-3)


def test_at_a_pole_two_angles_may_be_anything_and_the_third_is_as_sure_as_ever():
    clean = truth("walk", seconds=0.2)
    turns, _ = root_rows(clean.skeleton)
    q = clean.q.copy()
    q[:, turns[1]] = np.pi / 2
    frame = Travel(np.zeros((len(q), 3)), np.zeros(len(q)), clean.skeleton.up)
    std, nothing = np.full(q.shape, 0.02), np.zeros(q.shape[1])
    found = root_deviations(std, nothing, frame, clean.with_q(q), q, nothing.astype(bool))[:, turns]
    np.testing.assert_allclose(found[:, [0, 2]], ANY_ANGLE)
    assert (found[:, 1] < 0.06).all()


def test_deviations_of_the_place_turn_with_the_body():
    clean = truth("walk", seconds=3.0)
    turns, moves = root_rows(clean.skeleton)
    _, frame = joint_channels(clean, own_middle(clean))
    std = np.full(clean.q.shape, 0.1)
    std[:, moves] = 0.01, 0.02, 0.03
    noise = np.full(clean.q.shape[1], 0.02)
    nowhere = np.zeros(clean.q.shape[1], dtype=bool)
    found = root_deviations(std, noise, frame, clean, clean.q, nowhere)
    # along the file's axes as in the frame's, all in all; the vertical is the same in both
    np.testing.assert_allclose(np.square(found[:, moves]).sum(axis=1), np.square([0.01, 0.02, 0.03]).sum())
    upward = int(np.argmax(np.abs(clean.skeleton.dof_axis[moves] @ clean.skeleton.up)))
    np.testing.assert_allclose(found[:, moves[upward]], std[:, moves[upward]])
    others = np.setdiff1d(np.arange(clean.q.shape[1]), [*turns, *moves])
    np.testing.assert_array_equal(found[:, others], std[:, others])
    more = root_deviations(std, noise, frame, clean, clean.q, ~nowhere)
    assert (more[:, moves] > found[:, moves]).all()


@pytest.mark.slow
@pytest.mark.parametrize(("taught", "noise"), [(False, 1.0), (False, 1.5), (True, 1.0), (True, 3.0)])
def test_the_root_is_as_unsure_as_it_is_wrong(taught, noise):
    """Places are in noise of a centimetre for each degree."""
    within = []
    for seed, action in enumerate(("walk", "run", "reach", "turn", "walk", "jump")):
        clean = truth(action, seconds=5.0, fps=(30.0, 60.0)[seed % 2])
        noisy = corrupt(clean, noise=np.radians(noise), seed=seed).recording
        outcome = joints_model().repair(noisy) if taught else repair_without_model(noisy)
        off = np.abs(outcome.recording.q - clean.q)
        for rows in root_rows(clean.skeleton):
            turned = np.minimum(off[:, rows] % (2 * np.pi), -off[:, rows] % (2 * np.pi))  # no place is metres off
            away = turned / outcome.std[:, rows]
            within.append([(away < 1.0).mean(), (away < 1.96).mean()])
    for one, two in np.mean(np.reshape(within, (-1, 2, 2)), axis=0):  # of turns, and of the place
        assert abs(one - 0.68) < 0.1, within
        assert 0.89 < two < 0.99, within
