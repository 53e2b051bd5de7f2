"""Dense systems, distances and pictures described: each against NumPy."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import naive_tracking as naive
from motionmend.arrays import frozen
from motionmend.bodies import anatomy
from motionmend.bodies.camera import KINECT
from motionmend.bodies.performer import advance, bone_frames, standing, twists
from motionmend.bodies.surface import Rendering, intrinsics, render
from motionmend.kernels import dense, limbs, nearest
from motionmend.track.frame.evidence import evidence_of
from motionmend.track.frame.observation import Observation
from motionmend.track.settings import settings_of
from motionmend.track.terms.view import view_of

WISH = replace(settings_of("default"), raster=4)


@pytest.mark.parametrize("size", [1, 2, 5, 34])
def test_cholesky_solves_and_refuses_and_reads_the_lower_half_only(rng, size):
    root = rng.normal(size=(size, size + 6))
    matrix, right = root @ root.T, rng.normal(size=size)
    lower = np.where(np.tri(size, dtype=bool), matrix, np.nan)
    solved, factor = right.copy(), lower.copy()
    assert dense.factor_and_solve(lower, solved)
    np.testing.assert_allclose(matrix @ solved, right, atol=1e-8)
    assert dense.factored(factor)
    np.testing.assert_allclose(np.tril(factor), np.linalg.cholesky(matrix), rtol=1e-9, atol=1e-9)
    assert not dense.factor_and_solve(-matrix, right.copy())
    assert not dense.factored(np.diag(np.append(np.ones(size), -1.0)))


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
    nearest.squared_distances(frozen(samples.T, np.float32), query, weights, out)
    np.testing.assert_allclose(out, ((samples - query) ** 2) @ weights, rtol=1e-4)


def test_samples_of_a_picture_are_of_the_picture(rng):
    body, pose = anatomy.average(), standing()
    picture = render(body, pose, KINECT, 4)
    evidence = evidence_of(Observation(picture.camera, picture.depth, np.isnan(picture.depth), 0.0), WISH)
    view = view_of(body, pose, evidence, 2)
    own = Rendering(evidence.camera, view.depth, view.solid, picture.bone, view.solid_placed, body)
    np.testing.assert_array_equal(view.depth, evidence.depth)
    wanted = np.argwhere(np.isfinite(view.depth[::2, ::2])) * 2
    np.testing.assert_array_equal(view.pixels, wanted)
    at = tuple(wanted.T)
    np.testing.assert_allclose(view.samples, own.points[at], atol=1e-6)
    np.testing.assert_allclose(view.normals, own.normals[at], atol=1e-5)
    np.testing.assert_array_equal(view.bones, own.bones[at])
    np.testing.assert_allclose(view.placed, bone_frames(body, pose), atol=1e-12)
    np.testing.assert_allclose(view.twists, twists(body, pose), atol=1e-12)
    np.testing.assert_array_equal(evidence.pixels, wanted)
    np.testing.assert_allclose(evidence.samples, own.points[at], atol=1e-6)


def test_the_middle_of_points_is_their_median(rng):
    from motionmend.track.frame.evidence import middle

    for count in range(1, 9):
        points = rng.normal(size=(count, 3)).astype(np.float32)
        np.testing.assert_allclose(middle(points), np.median(points.astype(np.float64), axis=0), rtol=1e-12)


def test_disagreement_and_what_a_limb_changes_of_it(rng):
    from motionmend.track.limbs.other_poses import LIMBS, MOST, Coarse, cast_parts, disagreements, limb_costs, with_limb

    body, pose = anatomy.average(), standing()
    moved = advance(body, pose, np.concatenate((np.zeros(6), rng.normal(0, 0.3, 28))))
    picture = render(body, moved, KINECT, 4)
    seen = picture.depth.copy()
    seen[rng.random(seen.shape) < 0.1] = np.nan
    free = np.isnan(picture.depth)
    coarse = Coarse(intrinsics(picture.camera), seen, free, int(np.isfinite(seen).sum()))
    each = np.empty(seen.shape)
    whole = limbs.unlikeness(seen, free, cast_parts(body, pose, coarse)[0], MOST, each)
    assert whole == pytest.approx(each.sum())
    assert whole == pytest.approx(naive.disagreement(seen, free, cast_parts(body, pose, coarse)[0], MOST), rel=1e-5)
    both = [naive.disagreement(seen, free, cast_parts(body, one, coarse)[0], MOST) for one in (pose, moved)]
    np.testing.assert_allclose(disagreements(body, [pose, moved], coarse), np.array(both) / coarse.pixels, rtol=1e-5)
    for limb in LIMBS:
        tried = np.stack((pose.joints[limb.columns], moved.joints[limb.columns]))
        costs = limb_costs(body, pose, limb, tried, coarse)
        rest = cast_parts(naive.without_limb(body, limb), pose, coarse)[0]
        others = [
            naive.disagreement(seen, free, cast_parts(body, with_limb(pose, limb, row), coarse)[0], MOST, rest)
            for row in tried
        ]
        np.testing.assert_allclose(costs, np.array(others) / coarse.pixels, atol=1e-5)
