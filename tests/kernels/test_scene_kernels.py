"""The room's planes and background, what hides the person and gaps beside them against their plain twins."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import naive_detector as naive
from depth_images import INTRINSICS, stepped
from motionmend.arrays import frozen
from motionmend.kernels import scene

SEEDS = st.integers(0, 10**6)


@pytest.mark.slow
@given(SEEDS)
@settings(max_examples=25)
def test_what_stands_before_the_scene_is_the_twins(seed):
    rng = np.random.default_rng(seed)
    depth = stepped(rng)
    background = (depth + rng.uniform(-0.2, 0.3, depth.shape)).astype(np.float32)
    background[rng.uniform(size=depth.shape) < 0.3] = np.nan
    background = frozen(background, np.float32)
    normal = np.column_stack([rng.normal(0, 0.2, (2, 2)), -np.ones(2)])
    planes = frozen(np.column_stack([normal / np.linalg.norm(normal, axis=1)[:, None], rng.uniform(2.1, 2.8, 2)]))
    out = np.empty(depth.shape, bool)
    scene.before_scene(depth, INTRINSICS, planes, background, 0.015, 0.007, out)
    wanted = naive.before_scene(depth, INTRINSICS, planes, background, 0.015, 0.007)
    np.testing.assert_array_equal(out, wanted)
    assert 0 < out.sum() < out.size


@given(SEEDS, st.floats(1.9, 2.7))
@settings(max_examples=25)
def test_what_may_hide_the_person_is_the_twins(seed, closest):
    rng = np.random.default_rng(seed)
    depth = stepped(rng)
    normal = np.column_stack([rng.normal(0, 0.2, (2, 2)), -np.ones(2)])
    planes = frozen(np.column_stack([normal / np.linalg.norm(normal, axis=1)[:, None], rng.uniform(2.1, 2.8, 2)]))
    free = rng.uniform(size=depth.shape) < 0.7
    wanted = naive.hiding(depth, INTRINSICS, planes, 0.015, 0.007, closest, free)
    scene.hiding(depth, INTRINSICS, planes, 0.015, 0.007, closest, free)
    np.testing.assert_array_equal(free, wanted)


@given(SEEDS)
@settings(max_examples=25)
def test_what_is_learned_of_the_background_is_the_twins(seed):
    rng = np.random.default_rng(seed)
    depth, person = stepped(rng), stepped(rng, 0.6)
    background = (depth + rng.uniform(-0.2, 0.3, depth.shape)).astype(np.float32)
    background[rng.uniform(size=depth.shape) < 0.3] = np.nan
    seen = np.isfinite(depth) & (rng.uniform(size=depth.shape) < 0.7)
    wanted = naive.farthest(depth, seen, person, 0.015, 0.007, background)
    scene.farthest(depth, seen, person, 0.015, 0.007, background)
    np.testing.assert_array_equal(background, wanted)


def _with_holes(seed):
    """Depth of a square person before a wall, with holes about and in them; the person; what stands free."""
    rng = np.random.default_rng(seed)
    depth = np.full((18, 22), 3.5, np.float32)
    person = np.full(depth.shape, np.nan, np.float32)
    person[5:14, 6:15] = rng.uniform(1.8, 2.2, (9, 9))
    depth[5:14, 6:15] = person[5:14, 6:15]
    away = np.hypot(*(np.indices(depth.shape).T - [9, 10]).T)
    hidden = ((away > 4.6) & (away < 4.6 + rng.uniform(1.0, 3.0))) | (rng.uniform(size=depth.shape) < 0.05)
    depth[hidden] = person[hidden] = np.nan
    free = np.isfinite(depth) & np.isnan(person) & (rng.uniform(size=depth.shape) < 0.9)
    return frozen(depth, np.float32), person, free


@pytest.mark.slow
@given(SEEDS)
@settings(max_examples=25)
def test_gaps_are_the_twins(seed):
    depth, person, free = _with_holes(seed)
    rim = np.zeros(depth.shape, bool)
    scene.gaps(depth, person, free, 14.0, rim)
    np.testing.assert_array_equal(rim, naive.gaps(depth, person, free, 14.0))


def test_holes_about_a_person_nearly_always_hold_gaps():
    found = []
    for seed in range(100):
        depth, person, free = _with_holes(seed)
        rim = np.zeros(depth.shape, bool)
        scene.gaps(depth, person, free, 14.0, rim)
        found.append(rim.any())
    assert np.mean(found) > 0.95
