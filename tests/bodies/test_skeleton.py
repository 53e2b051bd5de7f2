"""Shapes, heights and equality of skeletons; test_chain holds the kinematics themselves against twins."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings

from motionmend.bodies.skeleton import (
    Skeleton,
    forward,
    height,
    jacobian,
    positions,
    rest_positions,
    same,
)
from motionmend.errors import MismatchError
from skeletons import skeletons


@settings(max_examples=20)
@given(skeletons())
def test_moving_elsewhere_moves_everything_alike(case):
    """Rigid motion of the root carries the whole body: distances between joints stay."""
    skeleton, rng = case
    q = rng.normal(size=(1, len(skeleton.dof_names)))
    step = np.array([1.0, 2.0, 3.0])
    moved = replace(skeleton, offsets=skeleton.offsets + np.eye(len(skeleton.names))[:, :1] * step)
    np.testing.assert_allclose(positions(moved, q), positions(skeleton, q) + step, atol=1e-12)


@settings(max_examples=20)
@given(skeletons())
def test_rotations_are_rotations(case):
    skeleton, rng = case
    _, rotations = forward(skeleton, rng.normal(size=(3, len(skeleton.dof_names))) * 3)
    identity = np.broadcast_to(np.eye(3), rotations.shape)
    np.testing.assert_allclose(rotations @ rotations.swapaxes(-1, -2), identity, atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(rotations), 1.0, atol=1e-12)


@settings(max_examples=20)
@given(skeletons())
def test_rest_is_the_pose_of_zeros(case):
    skeleton, _ = case
    rest = positions(skeleton, np.zeros((1, len(skeleton.dof_names))))[0]
    np.testing.assert_allclose(rest_positions(skeleton), rest, atol=1e-12)
    assert height(skeleton) == pytest.approx(np.ptp(rest[:, 1]))
    lying = replace(skeleton, up=np.array([0.0, 0.0, 1.0]))
    assert height(lying) == pytest.approx(np.ptp(rest[:, 2]))


@settings(max_examples=10)
@given(skeletons())
def test_same_means_every_number(case):
    skeleton, _ = case
    assert same(skeleton, replace(skeleton))
    assert same(skeleton, replace(skeleton, offsets=skeleton.offsets + 1e-9))
    assert not same(skeleton, replace(skeleton, offsets=skeleton.offsets + 1e-3))
    assert not same(skeleton, replace(skeleton, dof_axis=-skeleton.dof_axis))
    assert not same(skeleton, replace(skeleton, names=tuple(f"{n}x" for n in skeleton.names)))
    assert not same(skeleton, replace(skeleton, limits=np.clip(skeleton.limits, -1.0, 1.0)))


def finger() -> Skeleton:
    return Skeleton(
        names=("base", "tip"),
        parents=np.array([-1, 0]),
        offsets=np.array([[0.0, 0, 0], [0, 0.1, 0]]),
        dof_names=("base.rz",),
        dof_joint=np.array([0]),
        dof_axis=np.array([[0.0, 0, 1]]),
        dof_kind=np.array([0]),
        limits=np.array([[-1.0, 1.0]]),
    )


def test_a_quarter_turn():
    """Positive angles turn counterclockwise: the tip on +y goes to -x about z."""
    np.testing.assert_allclose(positions(finger(), np.array([[np.pi / 2]]))[0, 1], [-0.1, 0, 0], atol=1e-15)


@pytest.mark.parametrize("shape", [(3,), (2, 2), (2, 1, 1)])
def test_wrong_shapes_are_one_clear_line(shape):
    for function in (forward, positions):
        with pytest.raises(MismatchError, match=r"\(frames, 1\), came an array of shape") as failure:
            function(finger(), np.zeros(shape))
        assert "\n" not in str(failure.value)
    with pytest.raises(MismatchError, match="one pose of this skeleton has 1 values"):
        jacobian(finger(), np.zeros(shape))


def test_no_frames_and_no_dofs():
    assert positions(finger(), np.zeros((0, 1))).shape == (0, 2, 3)
    stiff = replace(
        finger(),
        dof_names=(),
        dof_joint=np.zeros(0),
        dof_axis=np.zeros((0, 3)),
        dof_kind=np.zeros(0),
        limits=np.zeros((0, 2)),
    )
    np.testing.assert_allclose(positions(stiff, np.zeros((2, 0))), np.stack([finger().offsets] * 2))
    assert jacobian(stiff, np.zeros(0)).shape == (2, 3, 0)
