"""Reaching, placing, counting and widths of limbs, sums without pictures and inverses: each against NumPy."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import naive_limbs as naive
import naive_tracking
from motionmend.arrays import frozen
from motionmend.bodies import anatomy
from motionmend.bodies.camera import KINECT
from motionmend.bodies.performer import BONES, DOFS, MOVES, Pose, advance, landmarks, standing
from motionmend.bodies.surface import intrinsics, render
from motionmend.kernels import dense, judging, limbs, regions, widths
from motionmend.track.frame.evidence import evidence_of
from motionmend.track.frame.observation import Observation
from motionmend.track.limbs.other_poses import (
    LIMBS,
    MOST,
    Coarse,
    cast_parts,
    draws,
    left_over,
    limb_costs,
    limb_places,
    limb_search,
    with_limb,
)
from motionmend.track.settings import settings_of
from motionmend.track.starting.reach import reach
from motionmend.track.terms.view import view_of

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


def test_a_limb_is_searched_closer_and_closer(rng):
    pose = advance(BODY, standing(), np.concatenate((np.zeros(6), rng.normal(0, 0.2, 28))))
    picture = render(BODY, advance(BODY, pose, np.concatenate((np.zeros(6), rng.normal(0, 0.3, 28)))), KINECT, 8)
    coarse = Coarse(intrinsics(picture.camera), picture.depth, np.isnan(picture.depth), 300)
    mean, form = rng.normal(0, 0.2, 28), np.diag(rng.uniform(0.0, 0.1, 28)) + 0.002

    for limb in LIMBS[1:3]:
        drawn = draws(np.random.default_rng(5), limb, (0.3, 0.1), 3, 4)
        some = rng.normal(0, 0.5, (6, len(limb.columns)))

        rest = cast_parts(naive_tracking.without_limb(BODY, limb), pose, coarse)[0]

        def cost(row, limb=limb, rest=rest):
            moved = with_limb(pose, limb, row)
            whole = cast_parts(BODY, moved, coarse)[0]
            seen = naive_tracking.disagreement(coarse.seen, coarse.free, whole, MOST, rest) / 300
            away, before = moved.joints - mean, pose.joints - mean
            return seen + away @ form @ away - before @ form @ before

        found = limb_search(BODY, pose, limb, some, coarse, drawn, mean, form)
        first, values, cheapest = naive.narrowed(cost, some, BODY.limits[6 + limb.columns], drawn)
        np.testing.assert_allclose(found.prices, first, atol=1e-5)
        np.testing.assert_allclose(found.best, values, atol=1e-12)
        assert found.price == pytest.approx(cheapest, abs=1e-5)
        assert found.price <= first.min() + 1e-9
        np.testing.assert_allclose(limb_costs(BODY, pose, limb, some, coarse), found.costs, rtol=1e-12)


def test_an_arm_with_nothing_near_it_is_left_over():
    pose = standing()
    joints = pose.joints.copy()
    joints[LIMBS[0].columns[4]] += 1.5  # the shoulder
    raised = Pose(pose.translation, pose.root, joints)
    picture = render(BODY, raised, KINECT, 4)
    coarse = Coarse(intrinsics(picture.camera), picture.depth, np.isnan(picture.depth), 300)
    assert left_over(BODY, raised, coarse).area == 0.0
    assert 0.02 < left_over(BODY, pose, coarse).area < 0.08


def test_places_of_a_limb_are_those_of_the_whole_body(rng):
    pose = advance(BODY, standing(), rng.normal(0, 0.2, DOFS))
    for limb in LIMBS:
        tried = rng.normal(0, 0.5, (3, len(limb.columns)))
        np.testing.assert_allclose(
            limb_places(BODY, pose, limb, tried), naive.limb_places(BODY, pose, limb, tried), atol=1e-9
        )


def test_a_body_is_judged_pixel_by_pixel(rng):
    picture = render(BODY, standing(), KINECT, 4)
    seen = np.roll(picture.depth, 2, axis=1) + rng.normal(0, 0.06, picture.depth.shape).astype(np.float32)
    seen[rng.random(seen.shape) < 0.1] = np.nan
    free = np.isnan(seen) & (rng.random(seen.shape) < 0.5)
    loose, counts = np.empty((seen.size, 2), np.int64), np.empty(5, np.int64)
    visible, denied = np.zeros((2, len(BONES)))
    bone = BODY.solids.arrays.carriers
    off = judging.judged(seen, free, picture.depth, picture.solid, bone, 0.1, loose, visible, denied, counts)
    wanted = naive.judged(seen, free, picture.depth, picture.bones, 0.1, len(BONES))
    assert off == pytest.approx(wanted[0])
    for found, twin in zip((loose[: counts[3]], visible, denied, counts), wanted[1:], strict=True):
        np.testing.assert_array_equal(found, twin)
    assert counts.min() > 0


def test_pixels_are_counted_for_their_bones(rng):
    picture = render(BODY, standing(), KINECT, 4)
    seen = picture.depth + rng.normal(0, 0.08, picture.depth.shape).astype(np.float32)
    seen[rng.random(seen.shape) < 0.2] = np.nan
    free = np.isnan(seen) & (rng.random(seen.shape) < 0.5)
    counts = np.zeros((3, len(BONES)))
    limbs.shown_and_denied(seen, free, picture.depth, picture.solid, BODY.solids.arrays.carriers, 0.05, *counts)
    wanted = naive.shown_and_denied(seen, free, picture.depth, picture.bones, np.float32(0.05), len(BONES))
    np.testing.assert_array_equal(counts, wanted)
    assert (counts.sum(axis=1) > 20).all()


def test_widths_are_told_by_the_matches_of_both_ways(rng):
    pose = standing()
    shift = np.concatenate(((0.05, -0.03, 0.02), rng.normal(0, 0.12, DOFS - 3)))
    picture = render(BODY, advance(BODY, pose, shift), KINECT, 4)
    depth = picture.depth.copy()
    depth[rng.random(depth.shape) < 0.15] = np.nan
    wish = replace(settings_of("default"), raster=4, every=1)
    evidence = evidence_of(Observation(picture.camera, depth, np.isnan(picture.depth), 0.0), wish)
    view = view_of(BODY, pose, evidence, 1)
    reach_by, half, gate, scale, trust = 2, 2, 0.2, 0.05, 3.0
    near = half, gate, evidence.apart, scale, trust
    systems, shape = np.zeros((len(BONES), widths.ROW, widths.ROW)), (evidence.depth, evidence.free)
    samples = view.pixels, view.samples, view.normals, view.bones
    widths.from_model(*samples, view.placed, *shape, evidence.intrinsics, reach_by, *near, systems)
    target, focal = evidence.camera.points(evidence.depth), evidence.camera.fx
    wanted, hit, aside = naive.widths_from_model(
        *samples, view.placed, target, evidence.free, focal, reach_by, half, gate, scale, trust
    )
    outside = evidence.free[tuple(view.pixels.T)].sum()
    assert hit.sum() > 100
    assert 20 < len(aside) < outside  # some are too far
    np.testing.assert_allclose(systems, wanted, rtol=1e-7, atol=1e-7 * np.abs(wanted).max())
    systems[:] = 0.0
    carriers, seen = BODY.solids.arrays.carriers, (evidence.pixels, evidence.samples)
    widths.from_seen(*seen, view.depth, view.solid, evidence.intrinsics, carriers, view.placed, *near, systems)
    model, bones = evidence.camera.points(view.depth), np.append(carriers, -1)[view.solid]
    wanted, hit = naive.widths_from_seen(*seen, model, bones, view.placed, half, gate, scale, trust)
    assert 20 < hit.sum() < len(hit)
    np.testing.assert_allclose(systems, wanted, rtol=1e-7, atol=1e-7 * np.abs(wanted).max())


@given(seed=st.integers(0, 10_000), size=st.integers(1, 34))
def test_inverses_are_lapacks(seed, size):
    root = np.random.default_rng(seed).normal(size=(size, size + 3))
    matrix, found = root @ root.T + 0.1 * np.eye(size), np.empty((size, size))
    assert dense.inverted(matrix.copy(), found)
    np.testing.assert_allclose(found @ matrix, np.eye(size), atol=1e-7)
    assert not dense.inverted(-matrix, found)


@pytest.mark.slow
@given(seed=st.integers(0, 10_000), share=st.sampled_from([0.0, 0.01, 0.5]))
def test_the_extent_of_what_is_measured(seed, share):
    rng = np.random.default_rng(seed)
    depth = frozen(np.where(rng.random((9, 14)) < share, rng.uniform(0.5, 4.0, (9, 14)), np.nan), np.float32)
    box = np.empty(4, np.int64)
    nearest = regions.extent(depth, box)
    rows, columns = np.nonzero(np.isfinite(depth))
    wanted = (rows.min(), rows.max(), columns.min(), columns.max()) if len(rows) else (0, -1, 0, -1)
    assert tuple(box) == wanted
    assert nearest == (np.nanmin(depth) if len(rows) else np.inf)


@given(seed=st.integers(0, 10_000), share=st.sampled_from([0.0, 0.01, 0.5]))
def test_the_tally_of_what_is_measured(seed, share):
    rng = np.random.default_rng(seed)
    depth = np.where(rng.uniform(size=(13, 21)) < share, rng.uniform(1, 4, (13, 21)), np.nan).astype(np.float32)
    rows, columns = np.full(13, -1), np.full(21, -1)
    total = regions.tally(depth, rows, columns)
    assert (rows == np.isfinite(depth).sum(axis=1)).all()
    assert (columns == np.isfinite(depth).sum(axis=0)).all()
    assert total == pytest.approx(np.nansum(np.square(depth, dtype=np.float64)))


def test_a_pose_that_is_reached_already_stays():
    pose = standing()
    found, left = reach(BODY, pose, landmarks(BODY, pose))
    assert isinstance(found, Pose)
    assert left < 1e-9
