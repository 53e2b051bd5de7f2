"""Ray-casting against its twin, and what must hold of any picture of the performer."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import naive_body
from motionmend.bodies import anatomy
from motionmend.bodies import performer as bodies
from motionmend.bodies.camera import KINECT, Camera
from motionmend.bodies.solids import Solids
from motionmend.bodies.surface import intrinsics, render
from motionmend.kernels import raycast

PERSON = anatomy.average()
SEEDS = st.integers(0, 2**32 - 1)
SMALL = Camera(40, 30, 35.7, 36.1, 20.3, 14.8)


def some_pose(seed, away=3.0):
    rng = np.random.default_rng(seed)
    pose = bodies.standing((0.2, 0.1, away))
    delta = rng.normal(size=34) * 0.4
    delta[:3] *= 0.3
    return bodies.advance(PERSON, pose, delta)


def some_solids(rng, count=6):
    """Solids all about the camera's view, the camera outside them, some cut by the picture's edge."""
    turn = bodies.rotation(rng.normal(size=(count, 3)))
    size = rng.uniform(0.05, 0.5, size=(count, 3))
    center = np.stack((rng.uniform(-1.5, 1.5, count), rng.uniform(-1, 1, count), rng.uniform(1.0, 4.0, count)), axis=1)
    taper = np.where(rng.random(count) < 0.3, 0.0, rng.uniform(-0.9, 0.9, count))
    return Solids(np.zeros(count), rng.integers(0, 2, count), center, turn, size, taper)


def picture(solids, camera):
    placed = naive_body.place(np.eye(4)[None], solids)
    parts = np.empty((len(solids), raycast.PARTS))
    shapes = (one.copy() for one in (solids.kind, solids.size, solids.taper))  # as kernels hand them on
    raycast.prepare(placed, *shapes, intrinsics(camera), camera.width, camera.height, parts)
    depth = np.empty((camera.height, camera.width), dtype=np.float32)
    solid = np.empty(depth.shape, dtype=np.int16)
    raycast.cast(parts, depth, solid)
    return placed, depth, solid


@pytest.mark.slow
@settings(max_examples=12, deadline=None)
@given(SEEDS)
def test_casting_is_its_twin_for_every_pixel(seed):
    rng = np.random.default_rng(seed)
    solids = some_solids(rng)
    placed, depth, solid = picture(solids, SMALL)
    v, u = np.mgrid[: SMALL.height, : SMALL.width]
    pixels = np.stack((u.ravel(), v.ravel()), axis=1)
    twin_depth, twin_solid = naive_body.cast(placed, solids, SMALL, pixels)
    ours = depth[pixels[:, 1], pixels[:, 0]].astype(np.float64)
    # What starts nearer than 0.05 m is not seen by ours, and a ray that only touches is anybody's: leave those out.
    clear = ~((twin_depth < 0.06) & np.isfinite(twin_depth))
    hit, twin_hit = np.isfinite(ours[clear]), np.isfinite(twin_depth[clear])
    assert np.mean(hit != twin_hit) <= 4e-3
    both = clear & np.isfinite(ours) & np.isfinite(twin_depth)
    near = np.abs(ours[both] - twin_depth[both]) < 1e-5 * (1 + twin_depth[both])
    assert np.mean(~near) <= 4e-3
    assert np.mean(solid[pixels[both, 1], pixels[both, 0]][near] != twin_solid[both][near]) <= 2e-3


@settings(max_examples=6, deadline=None)
@given(SEEDS)
def test_the_performer_is_cast_as_its_twin_does(seed):
    pose = some_pose(seed)
    seen = render(PERSON, pose, KINECT)
    where = np.argwhere(seen.solid >= 0)
    placed = naive_body.place(naive_body.frames(PERSON.chain, pose.translation, pose.root, pose.joints), PERSON.solids)
    depth, _ = naive_body.cast(placed, PERSON.solids, KINECT, where[:, ::-1])
    np.testing.assert_allclose(seen.depth[where[:, 0], where[:, 1]], depth, rtol=0, atol=2e-6)


@settings(max_examples=20, deadline=None)
@given(SEEDS)
def test_a_rendered_point_lies_on_its_solid(seed):
    seen = render(PERSON, some_pose(seed), KINECT)
    there = seen.solid >= 0
    assert there.sum() > 500
    s = seen.solid[there].astype(int)
    frame = seen.placed[s]
    away = seen.points[there] - frame[:, :, 3]
    local = np.einsum("nij,ni->nj", frame[:, :, :3], away)
    x, y, w = (local / PERSON.solids.size[s]).T
    least = PERSON.solids.size[s].min(axis=1)
    cone, radius = PERSON.solids.kind[s] == 1, 1 + PERSON.solids.taper[s] * y
    side = np.abs(np.hypot(x, w) - radius) * least
    end = np.abs(np.abs(y) - 1) * PERSON.solids.size[s, 1]
    ball = np.abs(np.sqrt(x * x + y * y + w * w) - 1) * least
    off = np.where(cone, np.minimum(side, end), ball)
    assert off.max() < 1e-6  # m
    assert np.all(np.where(cone, np.abs(y) - 1, 0.0) * PERSON.solids.size[s, 1] < 1e-6)


@settings(max_examples=10, deadline=None)
@given(SEEDS)
def test_normals_are_across_the_surface_and_face_the_camera(seed):
    seen = render(PERSON, some_pose(seed), KINECT)
    there = seen.solid >= 0
    normal, points = seen.normals[there].astype(float), seen.points[there]
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0, rtol=0, atol=1e-5)
    assert np.mean(np.einsum("ni,ni->n", normal, points) > 1e-3) < 0.005
    # A neighbour on the same solid lies in the tangent plane, to first order in the distance.
    level = there[:, :-1] & (seen.solid[:, :-1] == seen.solid[:, 1:])
    step = (seen.points[:, 1:] - seen.points[:, :-1])[level]
    rise = np.abs(np.einsum("ni,ni->n", step, seen.normals[:, :-1][level]))
    assert np.percentile(rise / np.linalg.norm(step, axis=1), 50) < 0.2


@settings(max_examples=10, deadline=None)
@given(SEEDS, st.sampled_from((2, 3, 4, 7)))
def test_every_nth_pixel_is_the_picture_thinned(seed, step):
    pose = some_pose(seed)
    whole, thin = render(PERSON, pose, KINECT), render(PERSON, pose, KINECT, step)
    assert np.mean(whole.solid[::step, ::step] != thin.solid) < 1e-3
    same = (thin.solid >= 0) & (whole.solid[::step, ::step] == thin.solid)
    np.testing.assert_allclose(thin.depth[same], whole.depth[::step, ::step][same], rtol=0, atol=1e-5)


def test_a_sphere_before_the_camera():
    ball = Solids([0], [0], [[0.0, 0.0, 2.0]], [np.eye(3)], [[0.5, 0.5, 0.5]], [0.0])
    _, depth, _ = picture(ball, KINECT)
    assert depth[120, 160] == pytest.approx(1.5, abs=1e-6)
    radius = KINECT.fx * 0.5 / np.sqrt(2.0**2 - 0.5**2)  # of the circle that a sphere on the axis shows
    assert np.isfinite(depth).sum() == pytest.approx(np.pi * radius**2, rel=0.01)


@pytest.mark.parametrize("away", [-3.0, 0.0, 0.3, 500.0])
def test_behind_upon_and_far_from_the_camera_nothing_breaks(away):
    seen = render(PERSON, bodies.standing((0.0, 0.0, away)), KINECT)
    assert np.all(np.isfinite(seen.depth) == (seen.solid >= 0))
    if away < 0:
        assert not np.isfinite(seen.depth).any()
    assert np.all(seen.depth[seen.solid >= 0] >= 0.05)


def test_out_of_the_picture_is_an_empty_picture():
    seen = render(PERSON, bodies.standing((50.0, 0.0, 3.0)), KINECT)
    assert not np.isfinite(seen.depth).any()
    assert np.all(seen.bones == -1)
