"""Walks down the part forest, votes and mean shift against their plain twins."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

import naive_detector as naive
from motionmend.arrays import frozen
from motionmend.kernels import forest

SEEDS = st.integers(0, 10**6)
FAR, CLIP = 10.0, 0.6


def _image(rng, height=24, width=32):
    depth = (2.0 + rng.uniform(-0.5, 0.5, (height, width))).astype(np.float32)
    depth[rng.uniform(size=depth.shape) < 0.3] = FAR
    pixels = np.argwhere(depth < FAR)
    rows, columns = pixels[rng.choice(len(pixels), 20)].T.astype(np.int32)
    return depth, np.ascontiguousarray(rows), np.ascontiguousarray(columns)


def _tree(rng, depth=4):
    """A full tree whose leaves are numbered from the left."""
    inner = 2**depth - 1
    children = np.array([(2 * i + 1, 2 * i + 2) for i in range(inner)] + [(-1 - i, -1 - i) for i in range(inner + 1)])
    probes = rng.uniform(-0.6, 0.6, (len(children), 4)).astype(np.float32)
    probes[rng.uniform(size=len(children)) < 0.4, 2:] = 0.0
    return frozen(probes, np.float32), frozen(rng.normal(0, 0.3, len(children))), frozen(children, np.int32)


@given(SEEDS)
@settings(max_examples=25)
def test_differences_are_those_of_the_twin(seed):
    rng = np.random.default_rng(seed)
    depth, rows, columns = _image(rng)
    probes = frozen(rng.uniform(-1, 1, (7, 4)), np.float32)
    out = np.empty((len(rows), 7), np.float32)
    forest.differences(depth, rows, columns, 30.0, 28.0, FAR, CLIP, probes, out)
    wanted = [
        [naive.difference(depth, r, c, 30.0, 28.0, FAR, CLIP, p) for p in probes]
        for r, c in zip(rows, columns, strict=True)
    ]
    np.testing.assert_array_equal(out, np.array(wanted, np.float32))


@given(SEEDS)
@settings(max_examples=25)
def test_every_pixel_reaches_the_twins_leaf(seed):
    rng = np.random.default_rng(seed)
    depth, rows, columns = _image(rng)
    probes, thresholds, children = _tree(rng)
    roots = frozen([0], np.int32)
    out = np.empty((len(rows), 1), np.int32)
    forest.leaves(depth, rows, columns, 30.0, 28.0, FAR, CLIP, probes, thresholds, children, roots, out)
    wanted = [
        naive.leaf(depth, r, c, 30.0, 28.0, FAR, CLIP, probes, thresholds, children, 0)
        for r, c in zip(rows, columns, strict=True)
    ]
    np.testing.assert_array_equal(out[:, 0], wanted)


@given(SEEDS)
@settings(max_examples=25)
def test_votes_are_those_of_the_twin(seed):
    rng = np.random.default_rng(seed)
    parts = frozen(rng.dirichlet(np.ones(4), 9), np.float32)
    offsets = frozen(rng.normal(0, 0.1, (9, 4, 3)), np.float32)
    reached, points = rng.integers(9, size=(30, 3)).astype(np.int32), rng.normal(size=(30, 3))
    area, places, weights = rng.uniform(size=30), np.empty((30, 3)), np.empty(30)
    count = forest.votes(reached, parts, offsets, points, area, 2, 0.2, places, weights)
    wanted, weight = naive.mean_votes(reached, parts, offsets, points, area, 2, 0.2)
    assert count == len(wanted)
    np.testing.assert_allclose(places[:count], wanted, atol=1e-6)
    np.testing.assert_allclose(weights[:count], weight, rtol=1e-5)


@given(SEEDS)
@settings(max_examples=25)
def test_modes_are_where_the_twin_climbs_to_and_weigh_as_much(seed):
    rng = np.random.default_rng(seed)
    centers = np.array([[0.0, 0, 2], [0.7, 0, 2], [0, 0.9, 2]])
    points = np.concatenate([c + rng.normal(0, 0.02, (n, 3)) for c, n in zip(centers, (60, 40, 20), strict=True)])
    weights = rng.uniform(0.5, 1.0, len(points))
    places, masses = np.full((3, 3), np.nan), np.zeros(3)
    assert forest.densest(points, weights, 0.1, 0.15, 100, places, masses) == 3
    assert np.all(np.diff(masses) <= 0)
    for place, mass in zip(places, masses, strict=True):
        np.testing.assert_allclose(naive.climb(points, weights, 0.1, place), place, atol=1e-3)
        np.testing.assert_allclose(naive.mass(points, weights, 0.1, place), mass, rtol=1e-6)
        assert np.linalg.norm(centers - place, axis=1).min() < 0.03


def test_no_votes_have_no_mode():
    places, masses = np.full((3, 3), np.nan), np.zeros(3)
    assert forest.densest(np.empty((0, 3)), np.empty(0), 0.1, 0.15, 20, places, masses) == 0
    assert np.isnan(places).all()
