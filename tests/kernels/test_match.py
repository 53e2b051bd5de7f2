"""Matching in pixel windows and the bones' systems against their plain twins."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import naive_tracking as naive
from motionmend.arrays import frozen
from motionmend.bodies.camera import Camera
from motionmend.bodies.performer import MOVES
from motionmend.kernels import bone_systems, match, raycast, rendered, widths
from motionmend.kernels.body import Shell
from motionmend.track.terms.view import BONES_MOVED, MOVED_FIRST

NONE = np.empty(0, np.float32)
F = 200.0


CAMERA = np.array([F, F, 15.0, 12.0])
PLACED = np.concatenate((np.eye(3), [[0.0], [0.0], [2.2]]), axis=1)[None]
BALL = Shell(
    carriers=np.zeros(1, np.int64),
    kinds=np.zeros(1, np.uint8),
    centers=np.zeros((1, 3)),
    turns=np.eye(3)[None],
    sizes=np.full((1, 3), 0.15),
    tapers=np.zeros(1),
)


def scene(rng, height=24, width=30, missing=0.3):
    """A wavy surface at about 2 m with holes: depth (H, W) and points (H, W, 3)."""
    z = 2.0 + 0.2 * rng.standard_normal((height, width)).cumsum(axis=1) * 0.3
    z[rng.random(z.shape) < missing] = np.nan
    depth = z.astype(np.float32)
    return depth, Camera(width, height, *CAMERA).points(depth)


def seen_points(rng, count, height=24, width=30):
    """Points near pixels of that image, and their pixels; some outside."""
    pixels = np.column_stack((rng.integers(-3, height + 3, count), rng.integers(-3, width + 3, count)))
    z = 2.0 + 0.2 * rng.standard_normal(count)
    u, v = pixels[:, 1] + rng.uniform(-0.49, 0.49, count), pixels[:, 0] + rng.uniform(-0.49, 0.49, count)
    points = np.column_stack(((u - width / 2) / F * z, (v - height / 2) / F * z, z))
    return pixels.astype(np.int64), points.astype(np.float32)


def nearest_of(pixels, points, depth, half, gate, apart, tones=NONE, image=NONE[None], tone_weight=0.0):
    """(N,) number of the pixel that `match.nearest` finds for each point, row by row; -1 = none."""
    tones = tones if len(tones) else np.full(len(pixels), np.nan)
    near = depth, 1.0 / F, 1.0 / F, CAMERA[2], CAMERA[3], half, gate, apart
    each = zip(pixels, points.astype(float), tones.astype(float), strict=True)
    found = np.array([match.nearest(*pixel, *point, *near, tone, image, tone_weight) for pixel, point, tone in each])
    return np.where(found[:, 0] < 0, -1, found[:, 0] * depth.shape[1] + found[:, 1])


@given(seed=st.integers(0, 10_000), half=st.integers(0, 7), gate=st.sampled_from([0.05, 0.3, np.inf]))
def test_the_nearest_point_of_the_window_is_found(seed, half, gate):
    rng = np.random.default_rng(seed)
    depth, target = scene(rng)
    pixels, points = seen_points(rng, 12)
    apart = 1.0 / (F * np.sqrt(1.0 + (18 / F) ** 2))
    found = nearest_of(pixels, points, depth, half, gate, apart)
    distance, _ = naive.nearest_in_window(pixels, points, target, half, gate)
    hit = found >= 0
    np.testing.assert_array_equal(hit, np.isfinite(distance))
    got = np.linalg.norm(target.reshape(-1, 3)[found[hit]].astype(float) - points[hit], axis=1)
    np.testing.assert_allclose(got, distance[hit], atol=1e-5)


def test_unlike_intensities_are_as_far_as_they_weigh(rng):
    depth, target = scene(rng)
    pixels, points = seen_points(rng, 40)
    tones = rng.uniform(0, 255, 40).astype(np.float32)
    tones[:5] = np.nan
    image = rng.uniform(0, 255, target.shape[:2]).astype(np.float32)
    found = nearest_of(pixels, points, depth, 5, 1.0, 0.9 / F, tones, image, 1e-6)
    distance, index = naive.nearest_in_window(pixels, points, target, 5, 1.0, tones, image, 1e-6)
    hit = found >= 0
    np.testing.assert_array_equal(hit, index >= 0)
    got = np.linalg.norm(target.reshape(-1, 3)[found[hit]].astype(float) - points[hit], axis=1)
    unlike = np.abs(image.ravel()[found[hit]] - tones[hit])
    np.testing.assert_allclose(np.hypot(got, 1e-3 * np.nan_to_num(unlike)), distance[hit], atol=1e-5)


@pytest.mark.parametrize("along", [0.0, 0.6, 1.0])
@pytest.mark.parametrize("scale", [0.05, np.inf])
def test_bone_systems_are_sums_over_rows_of_the_jacobian(rng, along, scale):
    seen, targets = scene(rng)
    pixels, points = seen_points(rng, 40)
    normals = rng.normal(size=(40, 3))
    normals = (normals / np.linalg.norm(normals, axis=1, keepdims=True)).astype(np.float32)
    bones = rng.integers(0, 3, 40)
    hessian, gradient = np.zeros((3, 6, 6)), np.zeros((3, 6))
    near = 3, 0.2, 0.9 / F
    cost, inliers = match.draw_to_seen(
        pixels, points, normals, bones, seen, CAMERA, *near, NONE, seen, 0.0, along, scale, 2.0, hessian, gradient
    )
    _, index = naive.nearest_in_window(pixels, points, targets, *near[:2])
    off = targets.reshape(-1, 3)[index] - points
    _check(hessian, gradient, cost, bones, index >= 0, points, normals, off, along, scale)
    assert 0 <= inliers <= (index >= 0).sum()


@pytest.mark.parametrize("along", [0.0, 0.9])
def test_observed_points_draw_the_nearest_of_the_model(rng, along):
    camera = Camera(30, 24, *CAMERA)
    depth, solid, parts = np.empty((24, 30), np.float32), np.empty((24, 30), np.int16), np.empty((1, raycast.PARTS))
    raycast.prepare(PLACED, BALL.kinds, BALL.sizes, BALL.tapers, CAMERA, 30, 24, parts)
    raycast.cast(parts, depth, solid)
    model = camera.points(depth)
    pixels, samples = seen_points(rng, 60)
    samples[:, 2] += 0.1
    hessian, gradient = np.zeros((1, 6, 6)), np.zeros((1, 6))
    near = 4, 0.3, 0.9 / F
    cost, inliers = match.draw_from_seen(
        pixels, samples, depth, solid, CAMERA, PLACED, BALL, *near, along, 0.1, 2.0, hessian, gradient
    )
    _, index = naive.nearest_in_window(pixels, samples, model, *near[:2])
    points = model.reshape(-1, 3)[index]
    normals = (points - [0.0, 0.0, 2.2]) / 0.15
    hit = index >= 0
    assert 10 < hit.sum() < 60
    _check(hessian, gradient, cost, np.zeros(60, int), hit, points, normals, samples - points, along, 0.1)
    assert 0 < inliers <= hit.sum()


def _check(hessian, gradient, cost, bones, hit, points, normals, off, along, scale):
    total = 0.0
    for b in range(len(hessian)):
        own = (bones == b) & hit
        wanted = naive.bone_system(*(a[own].astype(float) for a in (points, normals, off)), along, scale, 2.0)
        np.testing.assert_allclose(np.triu(hessian[b]), np.triu(wanted[0]), rtol=1e-4, atol=1e-4)
        np.testing.assert_allclose(gradient[b], wanted[1], rtol=1e-4, atol=1e-4)
        total += wanted[2]
    assert cost == pytest.approx(total, rel=1e-4)


def test_widths_and_motion_of_a_bone_are_sums_over_rows(rng):
    frame = np.eye(4)
    frame[:3, :3], frame[:3, 3] = Rotation.random(random_state=4).as_matrix(), (0.2, -0.1, 2.0)
    wanted, system = np.zeros((10, 10)), np.zeros((10, 10))
    for _ in range(5):
        point, normal = rng.normal(size=3), rng.normal(size=3)
        normal /= np.linalg.norm(normal)
        off = 0.05 * rng.normal()
        widths.stretch_row(frame, *point, *normal, off, 0.04, 3.0, np.empty(10), system)
        local, along = frame[:3, :3].T @ (point - frame[:3, 3]), frame[:3, :3].T @ normal
        row = np.concatenate((np.cross(point, normal), normal, local * along, [off]))
        wanted += 3.0 / (1 + (off / 0.04) ** 2) ** 2 * np.outer(row, row)
    np.testing.assert_allclose(system, wanted, rtol=1e-9, atol=1e-12)


def test_the_chain_rule_over_bones(rng):
    hessian = rng.normal(size=(15, 6, 6))
    hessian = hessian @ hessian.transpose(0, 2, 1)
    gradient, twists = rng.normal(size=(15, 6)), rng.normal(size=(34, 6))
    normal, right = np.zeros((34, 34)), np.zeros(34)
    bone_systems.assemble(np.triu(hessian), gradient, twists, MOVED_FIRST, BONES_MOVED, normal, right)
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
    depth, _ = scene(rng)
    unknown = np.isnan(depth) & (rng.random(depth.shape) < 0.5)
    edge = np.empty_like(depth)
    rendered.steps(depth, unknown, 0.1, edge)
    on = np.isfinite(edge)
    np.testing.assert_array_equal(on, naive.near_sides(depth, unknown, 0.1))
    np.testing.assert_array_equal(edge[on], depth[on])
    rendered.steps(depth, np.empty((0, 0), np.bool_), 0.1, edge)
    np.testing.assert_array_equal(np.isfinite(edge), naive.near_sides(depth, np.zeros_like(unknown), 0.1))
    rendered.steps(depth, np.ones_like(unknown), 0.1, edge)
    assert not np.isfinite(edge).any()


def test_spreads_of_points_follow_from_the_covariance(rng):
    root = rng.normal(size=(34, 34))
    covariance, twists = root @ root.T, rng.normal(size=(34, 6))
    bones, points, std = np.array([0, 6, 11]), rng.normal(size=(3, 3)), np.empty(3)
    bone_systems.spreads(covariance, twists, MOVED_FIRST, BONES_MOVED, frozen(bones, np.int64), points, std)
    wanted = [naive.joint_spread(covariance, twists, MOVES[b], x) for b, x in zip(bones, points, strict=True)]
    np.testing.assert_allclose(std, wanted, rtol=1e-9)
