"""Clean-up and connected surfaces against their plain twins."""

import cv2
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

import naive_detector as naive
from depth_images import INTRINSICS, stepped
from motionmend.arrays import frozen
from motionmend.kernels import regions

SEEDS = st.integers(0, 10**6)


@given(SEEDS, st.integers(0, 2))
@settings(max_examples=25)
def test_clean_up_is_the_twins(seed, radius):
    depth = stepped(np.random.default_rng(seed))
    out = np.empty_like(depth)
    regions.mend(depth, radius, 6, 0.05, out)
    np.testing.assert_allclose(out, naive.mended(depth, radius, 6, 0.05), rtol=1e-6)


@given(SEEDS)
@settings(max_examples=25)
def test_surfaces_are_those_of_a_flood(seed):
    rng = np.random.default_rng(seed)
    depth = stepped(rng)
    inside = np.isfinite(depth)
    labels = np.empty(depth.shape, np.int32)
    count = regions.surfaces(depth, inside, 0.04, 0.005, labels)
    wanted, number = naive.surfaces(depth, inside, 0.04, 0.005)
    assert count == number
    np.testing.assert_array_equal(labels, wanted)


@given(SEEDS)
@settings(max_examples=10)
def test_measures_and_samples_are_those_of_the_surfaces(seed):
    rng = np.random.default_rng(seed)
    depth = stepped(rng, 0.1)
    labels = np.empty(depth.shape, np.int32)
    count = regions.surfaces(depth, np.isfinite(depth), 0.1, 0.0, labels)
    moved = (rng.uniform(size=depth.shape) < 0.5).astype(np.uint8)
    out = np.empty((count, 14))
    regions.measures(depth, labels, moved, INTRINSICS, out)
    np.testing.assert_allclose(out, naive.measures(depth, labels, moved, INTRINSICS, count), rtol=1e-9, atol=1e-12)
    largest = int(np.argmax(out[:, 0]))
    slot, step = np.full(count, -1, np.int64), np.full(count, 3, np.int64)
    slot[largest] = 0
    points, counts = np.empty((1, 400, 3)), np.zeros(1, np.int64)
    regions.sampled(depth, labels, slot, step, INTRINSICS, points, counts)
    wanted = naive.points(depth, INTRINSICS)[labels == largest][::3]
    assert counts[0] == len(wanted)
    np.testing.assert_allclose(points[0, : counts[0]], wanted, rtol=1e-9)


@given(SEEDS, st.integers(2, 4), st.floats(0.1, 0.9), st.tuples(st.integers(15, 18), st.integers(19, 22)))
@settings(max_examples=40)
def test_blocks_are_the_twins(seed, step, missing, shape):
    depth = stepped(np.random.default_rng(seed), missing)[: shape[0], : shape[1]].copy()
    out = np.empty((-(-shape[0] // step), -(-shape[1] // step)), np.float32)
    regions.blocks(depth, step, 0.05, 0.004, out)
    np.testing.assert_allclose(out, naive.blocks(depth, step, 0.05, 0.004), rtol=1e-6)


@given(SEEDS, st.floats(0.0, 3.0), st.floats(0.0, 0.2), st.integers(2, 6))
@settings(max_examples=40)
def test_bridges_are_the_twins(seed, blurred, missing, longest):
    rng = np.random.default_rng(seed)
    depth = (2.0 + np.cumsum(rng.choice([0.0, 0.0, 0.3, -0.3], (18, 22)), axis=1)).astype(np.float32)
    depth = cv2.GaussianBlur(depth, (0, 0), blurred) if blurred > 0.3 else depth
    depth[rng.uniform(size=depth.shape) < missing] = np.nan
    depth = frozen(depth, np.float32)
    between = np.empty(depth.shape, np.bool_)
    count = regions.bridges(depth, 0.05, 0.004, longest, between)
    np.testing.assert_array_equal(between, naive.bridges(depth, 0.05, 0.004, longest))
    assert count == between.sum()
