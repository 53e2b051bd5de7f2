"""Laws of inverse kinematics: targets are reached, limits hold, nothing moves without need."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bipeds import biped
from motionmend.bodies import ik
from motionmend.bodies.ik import solve
from motionmend.bodies.skeleton import jacobian, positions
from motionmend.errors import MismatchError
from skeletons import random_skeleton, skeletons

BODY = biped()
POINTS = [BODY.names.index(name) for name in ("LeftFoot", "LeftToeBase", "RightFoot", "RightToeBase", "Arm_End")]
seeds = st.integers(0, 2**32 - 1)


def pose(rng, frames, spread=0.4):
    """Poses (frames, D) within the limits, knees bent."""
    q = rng.normal(size=(frames, len(BODY.dof_names))) * spread
    for name in ("LeftLeg.rx", "RightLeg.rx"):
        q[:, BODY.dof_names.index(name)] = rng.uniform(0.4, 1.5, size=frames)
    return np.clip(q, 0.9 * BODY.limits[:, 0], 0.9 * BODY.limits[:, 1])


@settings(max_examples=25)
@given(skeletons())
def test_its_own_chain_agrees_with_the_kinematics_kernels(case):
    """Places and Jacobian of the joints to place equal those of bodies.skeleton."""
    skeleton, rng = case
    q = rng.normal(size=(2, len(skeleton.dof_names)))
    joints, dofs = np.arange(len(skeleton.names)), np.arange(len(skeleton.dof_names))
    at, slope = ik._Chain(skeleton, joints, dofs).positions_and_jacobian(q)
    np.testing.assert_allclose(at, positions(skeleton, q), atol=1e-12)
    np.testing.assert_allclose(slope[1], jacobian(skeleton, q[1]), atol=1e-12)


@pytest.mark.slow
@settings(max_examples=20)
@given(seeds)
def test_reaches_what_can_be_reached(seed):
    """Targets taken from a pose within the limits are met to a millionth of a metre from a pose nearby."""
    rng = np.random.default_rng(seed)
    truth = pose(rng, 5)
    start = np.clip(truth + 0.3 * rng.normal(size=truth.shape), BODY.limits[:, 0], BODY.limits[:, 1])
    found = solve(BODY, start, POINTS, positions(BODY, truth)[:, POINTS])
    assert found.residual.max() < 1e-6
    np.testing.assert_allclose(
        np.linalg.norm(positions(BODY, found.q)[:, POINTS] - positions(BODY, truth)[:, POINTS], axis=2),
        found.residual,
        atol=1e-12,
    )


@settings(max_examples=20)
@given(seeds)
def test_a_pose_that_is_already_there_is_not_touched(seed):
    """The very same bits come back, whatever the weight of staying."""
    rng = np.random.default_rng(seed)
    q = pose(rng, 4)
    found = solve(BODY, q, POINTS, positions(BODY, q)[:, POINTS], rest_weight=rng.uniform(0, 1))
    assert found.q.tobytes() == q.tobytes()
    assert found.converged.all()
    assert found.iterations == 0


@pytest.mark.slow
@settings(max_examples=20)
@given(seeds)
def test_never_leaves_the_limits_nor_moves_what_may_not(seed):
    """Even for targets far out of reach."""
    rng = np.random.default_rng(seed)
    q, movable = pose(rng, 4), np.sort(rng.choice(len(BODY.dof_names), size=7, replace=False))
    found = solve(BODY, q, POINTS, rng.normal(size=(4, len(POINTS), 3)) * 3, movable=movable)
    assert (found.q >= BODY.limits[:, 0]).all()
    assert (found.q <= BODY.limits[:, 1]).all()
    fixed = np.setdiff1d(np.arange(len(BODY.dof_names)), movable)
    assert found.q[:, fixed].tobytes() == q[:, fixed].tobytes()


def test_a_limit_that_the_start_breaks_is_never_broken_further():
    """A recorded pose outside its file's limits may come back, not go on."""
    q = np.zeros(len(BODY.dof_names))
    knee = BODY.dof_names.index("LeftLeg.rx")
    q[knee] = 2.8  # the limit is 2.6
    ankle = BODY.names.index("LeftFoot")
    for goal in (2.4, 3.1):
        wanted = q.copy()
        wanted[knee] = goal
        found = solve(BODY, q, [ankle], positions(BODY, wanted[None])[0, [ankle]], movable=[knee])
        assert found.q[knee] == pytest.approx(min(goal, 2.8), abs=1e-6)


@pytest.mark.slow
def test_frames_are_solved_each_by_itself(rng):
    """Side by side or one by one: the same poses."""
    q = pose(rng, 6)
    targets = positions(BODY, q)[:, POINTS] + 0.05 * rng.normal(size=(6, len(POINTS), 3))
    together = solve(BODY, q, POINTS, targets)
    for frame in range(6):
        alone = solve(BODY, q[frame], POINTS, targets[frame])
        np.testing.assert_allclose(alone.q, together.q[frame], atol=1e-9)
        assert alone.residual.shape == (len(POINTS),)
        assert alone.converged.shape == (1,)


def test_a_leg_stretches_towards_what_is_out_of_reach():
    """The miss is the distance less the leg's length: 0.82 m from the hip."""
    ankle = BODY.names.index("LeftFoot")
    legs = [d for d, name in enumerate(BODY.dof_names) if name.startswith(("LeftUpLeg", "LeftLeg"))]
    q = np.zeros(len(BODY.dof_names))
    q[BODY.dof_names.index("LeftLeg.rx")] = 0.5
    hip = positions(BODY, q[None])[0, BODY.names.index("LeftUpLeg")]
    target = hip + 1.5 * np.array([0.0, -0.8, 0.6])
    found = solve(BODY, q, [ankle], [target], movable=legs)
    assert found.residual[0] == pytest.approx(1.5 - 0.82, abs=1e-4)


def test_a_straight_leg_told_to_shorten_bends():
    """There the pull on every joint is nil: the saddle is left."""
    ankle = BODY.names.index("LeftFoot")
    legs = [d for d, name in enumerate(BODY.dof_names) if name.startswith(("LeftUpLeg", "LeftLeg"))]
    q = np.zeros(len(BODY.dof_names))
    target = positions(BODY, q[None])[0, ankle] + np.array([0.0, 0.2, 0.0])
    found = solve(BODY, q, [ankle], [target], movable=legs)
    assert found.residual[0] < 1e-6


def test_stays_near_where_the_targets_leave_a_choice(rng):
    """The least change wins: no other pose on the targets, found by wandering along them, is nearer to the start."""
    q = pose(rng, 1)[0]
    ankle = BODY.names.index("LeftFoot")
    target = positions(BODY, q[None])[0, ankle] + 0.1
    legs = [d for d, name in enumerate(BODY.dof_names) if name.startswith(("LeftUpLeg", "LeftLeg"))]
    found = solve(BODY, q, [ankle], [target], movable=legs)
    assert found.residual[0] < 1e-6
    for _ in range(20):
        other = found.q + 0.05 * rng.normal(size=len(q)) * np.isin(np.arange(len(q)), legs)
        other = solve(BODY, other, [ankle], [target], movable=legs)
        assert other.residual[0] < 1e-6
        assert np.linalg.norm(other.q - q) > np.linalg.norm(found.q - q) - 1e-3


def test_weights_decide_between_targets_that_contradict_each_other():
    """Two goals for one joint: it lies between them as the weights say."""
    root = [0, 1, 2]
    q = np.zeros(len(BODY.dof_names))
    goals = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    found = solve(BODY, q, [0, 0], goals, weights=[1.0, 3.0], movable=root)
    assert found.q[:3] == pytest.approx([0.75, 0.0, 0.0], abs=1e-5)


def test_missing_targets_and_missing_poses(rng):
    """A NaN target is left out; a frame whose pose is not known above the joints comes back as it was."""
    q = pose(rng, 4)
    targets = positions(BODY, q)[:, POINTS] + 0.02
    alone = solve(BODY, q[0], POINTS[1:], targets[0, 1:])
    targets[0, 0] = np.nan
    targets[1] = np.nan
    q[2, BODY.dof_names.index("LeftLeg.rx")] = np.nan
    found = solve(BODY, q, POINTS, targets)
    np.testing.assert_allclose(found.q[0], alone.q, atol=1e-9)
    assert np.isnan(found.residual[0, 0])
    assert found.q[1].tobytes() == q[1].tobytes()
    assert found.q[2].tobytes() == q[2].tobytes()
    assert not found.converged[2]
    assert found.residual[3].max() < 1e-6
    arm = BODY.dof_names.index("Arm.rz")
    q[3, arm] = np.nan  # not above the feet
    legs_only = solve(BODY, q[3], POINTS[:4], targets[3, :4])
    assert legs_only.residual.max() < 1e-6
    assert np.isnan(legs_only.q[arm])


def test_translations_move_too(rng):
    """Any tree of one-DOF joints: random bodies with sliding joints reach what they can."""
    for _ in range(5):
        skeleton = random_skeleton(rng, joints=6)
        truth = 0.3 * rng.normal(size=(3, len(skeleton.dof_names)))
        targets = positions(skeleton, truth)[:, [3, 5]]
        assert solve(skeleton, truth + 0.1 * rng.normal(size=truth.shape), [3, 5], targets).residual.max() < 1e-6


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"q0": np.zeros(3)}, "start pose"),
        ({"joints": [99]}, "joints must lie in"),
        ({"movable": [-1]}, "movable must lie in"),
        ({"targets": np.zeros((2, 2))}, "targets must be"),
        ({"weights": np.zeros(7)}, "weights must be"),
    ],
)
def test_what_does_not_fit_is_said(changes, said):
    """One line, with what came."""
    case = {"q0": np.zeros(len(BODY.dof_names)), "joints": [3], "targets": np.zeros((1, 3))} | changes
    with pytest.raises(MismatchError, match=said) as failure:
        solve(BODY, case.pop("q0"), case.pop("joints"), case.pop("targets"), **case)
    assert "\n" not in str(failure.value)
