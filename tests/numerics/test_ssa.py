"""Laws of the lag covariance and its eigenbases."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import naive
from motionmend.errors import MismatchError
from motionmend.numerics.ssa import at_rate, eigenbases, lag_covariance, sum_covariances, whole_stretches


def _walk(seed, frames=120, channels=4):
    return np.cumsum(np.random.default_rng(seed).normal(size=(frames, channels)), axis=0)


@given(st.integers(0, 10**6), st.integers(2, 12))
@settings(max_examples=30)
def test_matrix_is_the_covariance_of_the_trajectory_rows(seed, window):
    series = _walk(seed)
    rows = naive.trajectory_matrix(series, window)
    np.testing.assert_allclose(lag_covariance(series, window).matrix(), np.cov(rows.T, bias=True), rtol=1e-8, atol=1e-8)


@given(st.integers(0, 10**6), st.integers(20, 100))
@settings(max_examples=30)
def test_covariances_of_parts_add_and_no_window_straddles(seed, cut):
    series, window = _walk(seed), 8
    parts = series[:cut], series[cut:]
    rows = np.concatenate([naive.trajectory_matrix(p, window) for p in parts if len(p) >= window])
    whole = sum_covariances(lag_covariance(p, window) for p in parts)
    assert whole.count == len(rows)
    np.testing.assert_allclose(whole.matrix(), np.cov(rows.T, bias=True), rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(whole.mean(), rows.mean(axis=0), rtol=1e-9, atol=1e-9)


def test_a_missing_sample_cuts_the_clip():
    series = _walk(3)
    broken = series.copy()
    broken[50, 2] = np.nan
    assert whole_stretches(broken) == [(0, 50), (51, 120)]
    expected = lag_covariance(series[:50], 8) + lag_covariance(series[51:], 8)
    np.testing.assert_allclose(lag_covariance(broken, 8).products, expected.products)


def test_parts_of_other_shape_do_not_add():
    with pytest.raises(MismatchError, match="agree"):
        lag_covariance(_walk(0), 8) + lag_covariance(_walk(0), 9)


@given(st.integers(0, 10**6), st.floats(0.5, 0.999))
@settings(max_examples=25)
def test_bases_are_orthonormal_and_hold_the_energy_with_as_few_as_needed(seed, energy):
    bases = eigenbases(lag_covariance(_walk(seed), 6), energy)
    flat = bases.vectors.reshape(bases.count, -1)
    np.testing.assert_allclose(flat @ flat.T, np.eye(bases.count), atol=1e-9)
    assert bases.energy >= energy - 1e-9
    assert bases.values[:-1].sum() < energy * bases.total
    assert (np.diff(bases.values) <= 1e-9).all()


def test_the_full_set_of_bases_rebuilds_any_window(rng):
    """Eq. 2.6."""
    series = _walk(1, frames=200, channels=3)
    bases = eigenbases(lag_covariance(series, 5), 1.0)
    piece = rng.normal(size=(5, 3))
    flat = bases.vectors.reshape(bases.count, -1)
    assert bases.count == 15
    np.testing.assert_allclose(flat.T @ (flat @ piece.ravel()), piece.ravel(), atol=1e-9)


def test_two_sinusoids_have_rank_four():
    t = np.arange(2000)[:, None]
    series = np.hstack([np.sin(0.2 * t), np.cos(0.2 * t) + 2 * np.sin(0.05 * t)])
    values = np.linalg.eigvalsh(lag_covariance(series, 30).matrix())[::-1]
    assert values[4] < 1e-2 * values[3]


def test_discarded_variance_is_what_the_bases_leave_out():
    series = _walk(5)
    covariance = lag_covariance(series, 6)
    bases = eigenbases(covariance, 0.9)
    left = (np.trace(covariance.matrix()) - bases.values.sum()) / 6
    assert bases.discarded.sum() == pytest.approx(left, rel=1e-6)


@pytest.mark.parametrize("energy", [0.9, 0.999, 1.0])
@pytest.mark.parametrize(("few", "limit"), [(4, 10), (4, 3000), (64, 3000)])
def test_every_way_to_the_leading_patterns_ends_at_the_same(monkeypatch, few, limit, energy):
    import motionmend.numerics.ssa as ssa

    covariance = lag_covariance(_walk(7, frames=600, channels=5), 10)
    values, vectors = np.linalg.eigh(covariance.matrix())
    monkeypatch.setattr(ssa, "FEW", few)
    monkeypatch.setattr(ssa, "TRIDIAGONAL_LIMIT", limit)
    found = eigenbases(covariance, energy)
    assert found.count == int(np.argmax(np.cumsum(values[::-1]) >= energy * values.sum() * (1 - 1e-12))) + 1
    np.testing.assert_allclose(found.values, values[::-1][: found.count], rtol=1e-7, atol=1e-9 * values[-1])
    along = np.einsum("kd,dk->k", found.vectors.reshape(found.count, -1), vectors[:, ::-1][:, : found.count])
    np.testing.assert_allclose(np.abs(along[:20]), 1.0, atol=1e-6)
    again = eigenbases(covariance, energy)
    assert again.vectors.tobytes() == found.vectors.tobytes()


def test_clips_at_rest_have_one_pattern_of_no_variance():
    found = eigenbases(lag_covariance(np.zeros((400, 20)), 20), 0.99)
    assert found.count == 1
    assert found.values[0] == 0.0


@given(st.integers(0, 10**6), st.lists(st.integers(1, 60), min_size=1, max_size=6))
@settings(max_examples=30)
def test_several_clips_at_once_are_the_sum_of_each(seed, lengths):
    clips = [_walk(seed + k, frames=n) for k, n in enumerate(lengths)]
    together, apart = lag_covariance(clips, 8), sum_covariances(lag_covariance(c, 8) for c in clips)
    assert together.count == apart.count
    np.testing.assert_allclose(together.products, apart.products, rtol=1e-9, atol=1e-8)
    np.testing.assert_allclose(together.total, apart.total, rtol=1e-9, atol=1e-8)


def test_bases_at_another_rate_span_the_same_time_and_describe_the_same_motion():
    """A slow signal at 30 Hz and at 120 Hz: bases learned on the one rebuild the other."""
    fine = np.arange(0, 40, 1 / 120)[:, None]
    signal = np.hstack([np.sin(3 * fine), np.cos(3 * fine + 1), np.sin(3 * fine + 2)])
    bases = eigenbases(lag_covariance(np.ascontiguousarray(signal[::4]), 20), 0.9999)
    faster, stride = at_rate(bases, 30.0, 120.0)
    assert (stride, faster.window) == (4, 77)
    flat = faster.vectors.reshape(faster.count, -1)
    np.testing.assert_allclose(flat @ flat.T, np.eye(faster.count), atol=1e-9)
    piece = (signal[100:177] - faster.mean).ravel()
    assert np.linalg.norm(piece - flat.T @ (flat @ piece)) < 1e-2 * np.linalg.norm(piece)


def test_bases_at_a_rate_too_low_for_all_of_them_are_as_many_as_there_is_room_for():
    bases = eigenbases(lag_covariance(_walk(0, frames=400)[:, :2], 20), 1.0)
    slower, _ = at_rate(bases, 30.0, 5.0)
    assert bases.count > 8
    assert (slower.count, slower.window) == (8, 4)
    flat = slower.vectors.reshape(8, -1)
    np.testing.assert_allclose(flat @ flat.T, np.eye(8), atol=1e-9)


def test_no_window_is_one_clear_error():
    with pytest.raises(MismatchError, match="longer clips"):
        eigenbases(lag_covariance(_walk(0, frames=5), 20), 0.99)


def test_a_window_longer_than_every_clip_takes_no_memory_for_its_matrix():
    clips = [_walk(seed, frames=50) for seed in range(2)]
    whole = sum_covariances(lag_covariance(clip, 10**6) for clip in clips)  # full, its products would take 72 TB
    assert whole.count == 0
    with pytest.raises(MismatchError, match="longer clips"):
        eigenbases(whole, 0.99)
    none, some = lag_covariance(clips[0][:5], 8), lag_covariance(clips[1], 8)
    for both in (none + some, some + none):
        assert both.count == some.count
        np.testing.assert_array_equal(both.products, some.products)
