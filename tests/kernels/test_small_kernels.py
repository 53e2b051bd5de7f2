"""Dense systems, distances and pictures described: each against NumPy."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import naive_tracking as naive
from motionmend.bodies import anatomy
from motionmend.bodies.camera import KINECT
from motionmend.bodies.performer import advance, standing
from motionmend.bodies.surface import intrinsics, render
from motionmend.kernels import dense, limbs, nearest, rendered


def test_cholesky_solves_and_refuses(rng):
    root = rng.normal(size=(34, 40))
    matrix, right = root @ root.T, rng.normal(size=34)
    solved = right.copy()
    assert dense.factor_and_solve(matrix.copy(), solved)
    np.testing.assert_allclose(matrix @ solved, right, atol=1e-8)
    assert not dense.factor_and_solve(-matrix, right.copy())


def test_the_turn_between_two_rotations(rng):
    for angle in (0.0, 1e-9, 1e-3, 1.0, 3.1):
        axis = rng.normal(size=3)
        wanted = angle * axis / np.linalg.norm(axis)
        origin = Rotation.random(random_state=3).as_matrix()
        vector = np.empty(3)
        assert dense.turn_between(Rotation.from_rotvec(wanted).as_matrix() @ origin, origin, vector) == pytest.approx(
            angle, abs=1e-7
        )
        np.testing.assert_allclose(vector, wanted, atol=1e-7)


def test_squared_distances(rng):
    samples, query = rng.normal(size=(500, 28)).astype(np.float32), rng.normal(size=28).astype(np.float32)
    weights = rng.uniform(0, 1, 28).astype(np.float32)
    weights[3] = 0.0
    out = np.empty(500, np.float32)
    nearest.squared_distances(np.ascontiguousarray(samples.T), query, weights, out)
    np.testing.assert_allclose(out, ((samples - query) ** 2) @ weights, rtol=1e-4)


def test_a_picture_described_is_the_picture(rng):
    body = anatomy.average()
    picture = render(body, standing(), KINECT, 4)
    shape, solids = picture.depth.shape, body.solids
    points, pixels = np.empty((*shape, 3), np.float32), np.empty((picture.depth.size, 2), np.int64)
    samples, normals = (np.empty((picture.depth.size, 3), np.float32) for _ in range(2))
    bones = np.empty(picture.depth.size, np.int64)
    shared = picture.placed, solids.kind, solids.size, solids.taper, solids.bone
    count = rendered.describe(
        picture.depth, picture.solid, *shared, intrinsics(picture.camera), 2, points, pixels, samples, normals, bones
    )
    wanted = np.argwhere(np.isfinite(picture.depth[::2, ::2])) * 2
    np.testing.assert_array_equal(pixels[:count], wanted)
    np.testing.assert_allclose(points, picture.points, atol=1e-6)
    at = tuple(wanted.T)
    np.testing.assert_allclose(samples[:count], picture.points[at], atol=1e-6)
    np.testing.assert_allclose(normals[:count], picture.normals[at], atol=1e-5)
    np.testing.assert_array_equal(bones[:count], picture.bones[at])
    index = np.ravel_multi_index(at, shape)
    again = np.empty((count, 3), np.float32), np.empty((count, 3), np.float32), np.empty(count, np.int64)
    rendered.describe_found(index, points, picture.solid, *shared, *again)
    np.testing.assert_allclose(again[1], normals[:count], atol=1e-4)
    np.testing.assert_array_equal(again[2], bones[:count])
    listing = np.empty((picture.depth.size, 2), np.int64)
    assert rendered.listed(picture.depth, 2, listing) == count
    np.testing.assert_array_equal(listing[:count], wanted)
    values = np.empty((count, 3), np.float32)
    rendered.samples_of(listing, count, points, values)
    np.testing.assert_array_equal(values, samples[:count])


def test_disagreement_and_what_a_limb_changes_of_it(rng):
    from motionmend.track.limbs import LIMBS, MOST, Coarse, cast_parts, limb_costs, with_limb

    body, pose = anatomy.average(), standing()
    moved = advance(body, pose, np.concatenate((np.zeros(6), rng.normal(0, 0.3, 28))))
    picture = render(body, moved, KINECT, 4)
    seen = picture.depth.copy()
    seen[rng.random(seen.shape) < 0.1] = np.nan
    free = np.isnan(picture.depth)
    coarse = Coarse(intrinsics(picture.camera), seen, free, int(np.isfinite(seen).sum()))
    whole = limbs.disagreement(seen, free, cast_parts(body, pose, coarse)[0], MOST)
    assert whole == pytest.approx(naive.disagreement(seen, free, cast_parts(body, pose, coarse)[0], MOST), rel=1e-5)
    for limb in LIMBS:
        tried = np.stack((pose.joints[limb.columns], moved.joints[limb.columns]))
        costs = limb_costs(body, pose, limb, tried, coarse)
        others = [
            naive.disagreement(seen, free, cast_parts(body, with_limb(pose, limb, row), coarse)[0], MOST)
            for row in tried
        ]
        np.testing.assert_allclose(costs, np.array(others) / coarse.pixels, atol=1e-5)
