"""Matching in pixel windows and the bones' systems against their plain twins."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import naive_tracking as naive
from motionmend.bodies.performer import MOVES
from motionmend.kernels import match
from motionmend.track.view import BONES_MOVED, MOVED_FIRST

NONE = np.empty(0, np.float32)
F = 200.0


def scene(rng, height=24, width=30, missing=0.3):
    """A wavy surface at about 2 m with holes, as points (H, W, 3)."""
    z = 2.0 + 0.2 * rng.standard_normal((height, width)).cumsum(axis=1) * 0.3
    z[rng.random(z.shape) < missing] = np.nan
    depth = z.astype(np.float32)
    points = np.empty((height, width, 3), np.float32)
    match.unproject(depth, F, F, width / 2, height / 2, points)
    return depth, points


def seen_points(rng, count, height=24, width=30):
    """Points near pixels of that image, and their pixels; some outside."""
    pixels = np.column_stack((rng.integers(-3, height + 3, count), rng.integers(-3, width + 3, count)))
    z = 2.0 + 0.2 * rng.standard_normal(count)
    u, v = pixels[:, 1] + rng.uniform(-0.49, 0.49, count), pixels[:, 0] + rng.uniform(-0.49, 0.49, count)
    points = np.column_stack(((u - width / 2) / F * z, (v - height / 2) / F * z, z))
    return pixels.astype(np.int64), points.astype(np.float32)


@given(seed=st.integers(0, 10_000), half=st.integers(0, 7), gate=st.sampled_from([0.05, 0.3, np.inf]))
def test_the_nearest_point_of_the_window_is_found(seed, half, gate):
    rng = np.random.default_rng(seed)
    _, target = scene(rng)
    pixels, points = seen_points(rng, 12)
    apart = 1.0 / (F * np.sqrt(1.0 + (18 / F) ** 2))
    found = np.empty(len(pixels), np.int64)
    count = match.nearest_in_window(pixels, points, target, half, gate, apart, NONE, NONE[None], 0.0, found)
    distance, _ = naive.nearest_in_window(pixels, points, target, half, gate)
    assert count == (found >= 0).sum()
    hit = found >= 0
    np.testing.assert_array_equal(hit, np.isfinite(distance))
    got = np.linalg.norm(target.reshape(-1, 3)[found[hit]].astype(float) - points[hit], axis=1)
    np.testing.assert_allclose(got, distance[hit], atol=1e-5)


def test_unlike_intensities_are_as_far_as_they_weigh(rng):
    _, target = scene(rng)
    pixels, points = seen_points(rng, 40)
    tones = rng.uniform(0, 255, 40).astype(np.float32)
    tones[:5] = np.nan
    image = rng.uniform(0, 255, target.shape[:2]).astype(np.float32)
    found = np.empty(40, np.int64)
    match.nearest_in_window(pixels, points, target, 5, 1.0, 0.9 / F, tones, image, 1e-4, found)
    distance, index = naive.nearest_in_window(pixels, points, target, 5, 1.0, tones, image, 1e-4)
    hit = found >= 0
    np.testing.assert_array_equal(hit, index >= 0)
    got = np.linalg.norm(target.reshape(-1, 3)[found[hit]].astype(float) - points[hit], axis=1)
    unlike = np.abs(image.ravel()[found[hit]] - tones[hit])
    np.testing.assert_allclose(got + 1e-4 * np.nan_to_num(unlike), distance[hit], atol=1e-5)


@pytest.mark.parametrize("along", [0.0, 0.6, 1.0])
@pytest.mark.parametrize("scale", [0.05, np.inf])
def test_bone_systems_are_sums_over_rows_of_the_jacobian(rng, along, scale):
    count = 30
    points, to = rng.normal(size=(2, count, 3)).astype(np.float32)
    to = (points + 0.05 * to).astype(np.float32)
    normals = rng.normal(size=(count, 3))
    normals = (normals / np.linalg.norm(normals, axis=1, keepdims=True)).astype(np.float32)
    bones = rng.integers(0, 3, count)
    found = np.where(rng.random(count) < 0.2, -1, np.arange(count))
    hessian, gradient = np.zeros((3, 6, 6)), np.zeros((3, 6))
    cost, inliers = match.gather(found, bones, points, normals, to, True, along, scale, 2.0, hessian, gradient)
    total = 0.0
    for b in range(3):
        own = (bones == b) & (found >= 0)
        wanted = naive.bone_system(*(a[own].astype(float) for a in (points, normals, to - points)), along, scale, 2.0)
        np.testing.assert_allclose(np.triu(hessian[b]), np.triu(wanted[0]), rtol=1e-4, atol=1e-5)
        np.testing.assert_allclose(gradient[b], wanted[1], rtol=1e-4, atol=1e-5)
        total += wanted[2]
    assert cost == pytest.approx(total, rel=1e-4)
    assert 0 <= inliers <= (found >= 0).sum()


def test_the_chain_rule_over_bones(rng):
    hessian = rng.normal(size=(15, 6, 6))
    hessian = hessian @ hessian.transpose(0, 2, 1)
    gradient, twists = rng.normal(size=(15, 6)), rng.normal(size=(34, 6))
    normal, right = np.zeros((34, 34)), np.zeros(34)
    match.assemble(np.triu(hessian), gradient, twists, MOVED_FIRST, BONES_MOVED, normal, right)
    wanted = naive.assembled(hessian, gradient, twists, MOVES)
    np.testing.assert_allclose(normal, wanted[0], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(right, wanted[1], rtol=1e-9, atol=1e-9)


@given(seed=st.integers(0, 10_000))
def test_points_where_nobody_is_go_to_the_nearest_pixel_that_may_hold_them(seed):
    rng = np.random.default_rng(seed)
    free = rng.random((20, 25)) < 0.93
    row, column = rng.integers(0, 20), rng.integers(0, 25)
    point = np.array([[0.0, 0.0, 1.0]], np.float32)
    hessian, gradient = np.zeros((1, 6, 6)), np.zeros((1, 6))
    pixel, bone = np.array([[row, column]]), np.zeros(1, np.int64)
    cost, outside = match.push_out(pixel, bone, point, free, 40, 1.0, 1.0, np.inf, 1.0, hessian, gradient)
    assert outside == int(free[row, column])
    wanted = naive.outward_shift(row, column, free) if free[row, column] else None
    assert cost == pytest.approx(wanted or 0.0)
    assert np.hypot(*gradient[0, 3:5]) == pytest.approx(np.sqrt(wanted or 0.0))


def test_edges_are_near_sides_of_steps_and_unknown_pixels_make_none(rng):
    depth, points = scene(rng)
    unknown = np.isnan(depth) & (rng.random(depth.shape) < 0.5)
    edge = np.empty_like(points)
    match.steps(depth, unknown, 0.1, points, edge)
    on = np.isfinite(edge[..., 2])
    np.testing.assert_array_equal(on, naive.near_sides(depth, unknown, 0.1))
    np.testing.assert_array_equal(edge[on], points[on])
    match.steps(depth, np.ones_like(unknown), 0.1, points, edge)
    assert not np.isfinite(edge[..., 2]).any()


def test_spreads_of_points_follow_from_the_covariance(rng):
    root = rng.normal(size=(34, 34))
    covariance, twists = root @ root.T, rng.normal(size=(34, 6))
    bones, points, std = np.array([0, 6, 11]), rng.normal(size=(3, 3)), np.empty(3)
    match.spreads(covariance, twists, MOVED_FIRST, BONES_MOVED, bones, points, std)
    wanted = [naive.joint_spread(covariance, twists, MOVES[b], x) for b, x in zip(bones, points, strict=True)]
    np.testing.assert_allclose(std, wanted, rtol=1e-9)
