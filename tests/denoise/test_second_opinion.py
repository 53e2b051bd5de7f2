"""A library that misses a recording, and what the recording shows of itself."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from performers import FPS, joints_model, truth

from motionmend import corrupt, repair_without_model
from motionmend.bodies.motion import Origin
from motionmend.denoise.mending import Mended
from motionmend.denoise.repair import ChannelRepair
from motionmend.denoise.second_opinion import SAID, of_one_mind

SEEDS = st.integers(0, 10**6)


def _mended(rng, origin, missed=9.0):
    shape = origin.shape
    spread, weights = rng.uniform(0.5, 2, shape), rng.random(shape)
    said = ("Missed",)
    found = ChannelRepair(rng.normal(0, 10, shape), spread, weights, origin, 3, np.empty(0), True, said)
    return Mended(found, rng.uniform(1, 2, shape[1]), np.zeros(shape[1]), missed)


def _two(seed):
    rng = np.random.default_rng(seed)
    filled = rng.random((40, 3)) < 0.3
    filled[:, 2] |= seed % 2 == 0
    kinds = (np.where(rng.random((40, 3)) < 0.1, Origin.REPAIRED, Origin.MEASURED) for _ in range(2))
    one, other = (_mended(rng, np.where(filled, Origin.FILLED, kind).astype(np.uint8)) for kind in kinds)
    return one, other, filled


def _joined(one, other):
    """Both as one; the first is given up, so a copy is."""
    mine = replace(one.found, **{n: getattr(one.found, n).copy() for n in ("values", "std", "weights", "origin")})
    return of_one_mind(replace(one, found=mine), other)


@given(SEEDS)
@settings(max_examples=25, deadline=None)
def test_one_mind_lies_between_nearer_to_the_surer_and_is_as_unsure_as_the_two_are_at_odds(seed):
    one, other, filled = _two(seed)
    found = _joined(one, other).found
    a, b = one.found, other.found
    for c in range(3):
        seen = ~filled[:, c]
        if not seen.any():
            continue
        apart, way = (b.values - a.values)[seen, c], (found.values - a.values)[seen, c]
        share = way @ apart / (apart @ apart)
        np.testing.assert_allclose(way, share * apart, atol=1e-9)
        surer = np.square(a.std[seen, c]).mean() - np.square(b.std[seen, c]).mean()
        np.testing.assert_allclose(share, 0.5 + np.clip(0.5 * surer / np.square(apart).mean(), -0.5, 0.5), atol=1e-9)
        between = np.minimum(share, 1 - share) * np.abs(apart)
        assert (found.std[seen, c] >= between - 1e-6).all()
    assert (found.std >= np.minimum(a.std, b.std) - 1e-6)[~filled].all()
    np.testing.assert_array_equal(found.origin, np.where(filled, a.origin, b.origin))
    assert np.isfinite(found.values).all()
    assert found.warnings == ("Missed" + SAID,)


@given(SEEDS)
@settings(max_examples=25, deadline=None)
def test_two_that_agree_are_left_as_they_are(seed):
    one, _, _ = _two(seed)
    found = _joined(one, one)
    np.testing.assert_array_equal(found.found.values, one.found.values)
    np.testing.assert_allclose(found.found.std, one.found.std)
    np.testing.assert_allclose(found.noise, one.noise)


@given(SEEDS)
@settings(max_examples=25, deadline=None)
def test_gaps_are_the_librarys_shifted_by_what_is_found_at_their_edges(seed):
    one, other, filled = _two(seed)
    shift = np.arange(3.0) - 1.0
    other = replace(other, found=replace(one.found, values=one.found.values + shift))
    found = _joined(one, other).found.values - one.found.values
    seen_at_all = ~filled.all(axis=0)
    np.testing.assert_allclose(found, np.broadcast_to(np.where(seen_at_all, 0.5 * shift, 0.0), found.shape), atol=1e-12)


@pytest.mark.parametrize(("action", "outliers"), [("jump", 0.0), ("run", 0.1)])
def test_motions_that_the_library_does_not_know_are_no_worse_for_it(action, outliers):
    clean = truth(action)
    spoilt = corrupt(clean, noise=np.radians(2.0), outliers=outliers, seed=3).recording
    found = joints_model().repair(spoilt)
    alone = repair_without_model(spoilt, "adaptive")
    assert any("misses this recording" in said and said.endswith(SAID) for said in found.warnings)
    angles = clean.skeleton.dof_kind == 0

    def error(outcome):
        away = (outcome.recording.q - clean.q)[:, angles]
        return np.sqrt(np.mean(np.square((away + np.pi) % (2 * np.pi) - np.pi)))

    assert clean.fps == FPS
    assert error(found) < 1.1 * error(alone)


def test_what_the_library_knows_needs_no_second_opinion():
    found = joints_model().repair(corrupt(truth("walk"), noise=np.radians(2.0), seed=3).recording)
    assert not any("misses" in said for said in found.warnings)
