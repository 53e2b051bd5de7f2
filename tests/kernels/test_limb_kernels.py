"""Reaching, placing and counting of limbs, sums without pictures and inverses: each against NumPy."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import naive_limbs as naive
from motionmend.bodies import anatomy
from motionmend.bodies.camera import KINECT
from motionmend.bodies.performer import BONES, DOFS, MOVES, Pose, advance, landmarks, standing
from motionmend.bodies.surface import render
from motionmend.kernels import dense, limbs, regions
from motionmend.track.limbs import LIMBS, limb_places
from motionmend.track.reach import reach

BODY = anatomy.average()


@pytest.mark.parametrize("seed", range(6))
def test_reaching_takes_the_steps_of_levenberg_and_marquardt(seed):
    rng = np.random.default_rng(seed)
    pose = standing()
    targets = landmarks(BODY, advance(BODY, pose, rng.normal(0, 0.3, DOFS))) + rng.normal(0, 0.03, (16, 3))
    weights, loose = rng.random(16), np.ones(DOFS, bool)
    if seed % 2:
        loose[:] = False
        loose[6 + LIMBS[seed % 4].columns] = True
    weights[rng.random(16) < 0.3] = 0.0
    found, left = reach(BODY, pose, targets, weights, loose, 0.03, 6)
    wanted = naive.reach_within(BODY, pose, MOVES[BODY.landmark_bone], targets, weights, 0.03, loose, 6)
    place = landmarks(BODY, found)
    np.testing.assert_allclose(place, landmarks(BODY, wanted), atol=1e-6)
    off = ((place - targets) ** 2).sum(axis=1)
    assert left == pytest.approx(np.sqrt(weights @ off / weights.sum()))


def test_places_of_a_limb_are_those_of_the_whole_body(rng):
    pose = advance(BODY, standing(), rng.normal(0, 0.2, DOFS))
    for limb in LIMBS:
        tried = rng.normal(0, 0.5, (3, len(limb.columns)))
        np.testing.assert_allclose(
            limb_places(BODY, pose, limb, tried), naive.limb_places(BODY, pose, limb, tried), atol=1e-9
        )


def test_pixels_are_counted_for_their_bones(rng):
    picture = render(BODY, standing(), KINECT, 4)
    seen = picture.depth + rng.normal(0, 0.08, picture.depth.shape).astype(np.float32)
    seen[rng.random(seen.shape) < 0.2] = np.nan
    free = np.isnan(seen) & (rng.random(seen.shape) < 0.5)
    shown, denied = np.zeros((2, len(BONES)))
    limbs.shown_and_denied(seen, free, picture.depth, picture.solid, BODY.solids.arrays[0], 0.05, shown, denied)
    wanted = naive.shown_and_denied(seen, free, picture.depth, picture.bones, np.float32(0.05), len(BONES))
    np.testing.assert_array_equal(shown, wanted[0])
    np.testing.assert_array_equal(denied, wanted[1])


@given(seed=st.integers(0, 10_000), size=st.integers(1, 34))
def test_inverses_are_lapacks(seed, size):
    root = np.random.default_rng(seed).normal(size=(size, size + 3))
    matrix, found = root @ root.T + 0.1 * np.eye(size), np.empty((size, size))
    assert dense.inverted(matrix.copy(), found)
    np.testing.assert_allclose(found @ matrix, np.eye(size), atol=1e-7)
    assert not dense.inverted(-matrix, found)


@given(seed=st.integers(0, 10_000), share=st.sampled_from([0.0, 0.01, 0.5]))
def test_the_extent_of_what_is_measured(seed, share):
    rng = np.random.default_rng(seed)
    depth = np.where(rng.random((9, 14)) < share, rng.uniform(0.5, 4.0, (9, 14)), np.nan).astype(np.float32)
    box = np.empty(4, np.int64)
    total = regions.extent(depth, box)
    rows, columns = np.nonzero(np.isfinite(depth))
    wanted = (rows.min(), rows.max(), columns.min(), columns.max()) if len(rows) else (0, -1, 0, -1)
    assert tuple(box) == wanted
    assert total == pytest.approx(float(np.nansum(depth.astype(float) ** 2)))


def test_a_pose_that_is_reached_already_stays():
    pose = standing()
    found, left = reach(BODY, pose, landmarks(BODY, pose))
    assert isinstance(found, Pose)
    assert left < 1e-9
