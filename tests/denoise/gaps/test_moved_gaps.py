"""Laws of gaps that are laid elsewhere to see how wrong a repair is inside them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import t as student

from motionmend.denoise.adaptive.rounds import adapt
from motionmend.denoise.gaps.moved import MOST_EXCESS, beyond_normal, excess, gaps_of, hidden_by, laid_elsewhere
from motionmend.denoise.library.local_prior import Prior

FPS = 30.0


@st.composite
def _presences(draw):
    """(T, C) what is there of a recording with bursts of missing samples, some channels together."""
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    present = np.ones((draw(st.integers(20, 120)), draw(st.integers(1, 6))), dtype=bool)
    for _ in range(draw(st.integers(0, 8))):
        start, length = rng.integers(0, len(present)), rng.integers(1, len(present) // 2)
        present[start : start + length, rng.random(present.shape[1]) < 0.4] = False
    return present


@given(present=_presences())
@settings(deadline=None)
def test_gaps_are_all_that_is_missing_of_channels_that_are_seen(present):
    gaps = gaps_of(present)
    np.testing.assert_array_equal(hidden_by(gaps, present.shape), ~present & present.any(axis=0))
    assert sum(g.inside(present).size for g in gaps) == (~present & present.any(axis=0)).sum()  # none twice
    assert not any(g.inside(present).any() for g in gaps)
    assert len({(g.start, g.stop) for g in gaps}) == len(gaps)


@given(present=_presences())
@settings(deadline=None)
def test_moved_gaps_lie_where_samples_are_and_apart(present):
    gaps = gaps_of(present)
    moved = laid_elsewhere(gaps, present)
    hidden = hidden_by(moved, present.shape)
    assert hidden.sum() == sum(g.inside(hidden).size for g in moved)
    assert not (hidden & ~present).any()
    for gap in moved:
        assert present[gap.start - 1, gap.channels].all()
        assert present[gap.stop, gap.channels].all()
        assert not hidden[gap.start - 1, gap.channels].any()
        assert not hidden[gap.stop, gap.channels].any()
        assert any(np.array_equal(gap.channels, one.channels) for one in gaps)
        assert any(0.5 * (one.stop - one.start) <= gap.stop - gap.start <= one.stop - one.start for one in gaps)


@pytest.mark.slow
@given(seed=st.integers(0, 10**6), larger=st.floats(0.5, 6.0))
@settings(deadline=None)
def test_deviations_become_as_large_as_errors_elsewhere_are(seed, larger):
    rng = np.random.default_rng(seed)
    present = np.ones((600, 10), dtype=bool)
    for start in range(10, 560, 40):
        present[start : start + 12, rng.integers(10)] = False
    gaps = gaps_of(present)
    moved = laid_elsewhere(gaps, present)
    variance = rng.uniform(0.5, 20.0, present.shape)
    away = larger * rng.normal(size=present.shape) * np.sqrt(variance)
    everything = np.ones(present.shape, dtype=bool)
    factor = excess(gaps, moved, away, variance, everything)
    assert (factor[present] == 1.0).all()
    np.testing.assert_allclose(np.sqrt(factor[~present]), larger, rtol=0.35)
    beyond = excess(gaps, moved, 2.0 * away, variance, everything)
    assert (beyond >= factor).all()
    assert beyond.max() <= MOST_EXCESS**2
    away[rng.random(away.shape) < 0.3] = np.nan  # of what does not tell nothing is looked at
    assert np.isfinite(excess(gaps, moved, away, variance, np.isfinite(away))).all()


@pytest.mark.slow
@given(freedom=st.floats(2.5, 100.0), scale=st.floats(0.1, 10.0))
def test_intervals_hold_what_they_promise_of_errors_with_long_tails_too(freedom, scale):
    sizes = scale * student.ppf(0.5 + 0.5 * (np.arange(4000) + 0.5) / 4000, freedom)
    deviation = np.sqrt(beyond_normal(sizes, np.arange(1.0, 4001.0)))
    assert 0.68 <= (sizes <= deviation).mean() <= 0.73
    assert 0.90 <= (sizes <= 1.96 * deviation).mean() <= 0.955


def test_nothing_to_look_at_leaves_deviations_as_they_are():
    present = np.ones((30, 2), dtype=bool)
    present[2:28, 0] = False
    gaps = gaps_of(present)
    assert laid_elsewhere(gaps, present) == []
    assert (excess(gaps, [], np.zeros((30, 2)), np.ones((30, 2)), present) == 1.0).all()


def test_gaps_that_nothing_foretells_are_as_unsure_as_they_are_wrong(rng):
    # slow swings of a limb that no other channel shares: across a gap of a second a line misses them by far
    frames = 900
    time = np.arange(frames) / FPS
    swing = np.stack([20 * np.sin(2 * np.pi * (0.5 + 0.07 * c) * time + c) for c in range(6)], axis=1)
    measured = swing + rng.normal(0, 0.3, swing.shape)
    starts = rng.choice(np.arange(30, 850, 60), 8, replace=False)
    for start in starts:
        measured[start : start + 30, rng.integers(6, size=2)] = np.nan
    bends = np.cov(np.diff(swing, n=2, axis=0).T)
    found = adapt(measured, Prior(bends, None), FPS)
    gone = np.isnan(measured)
    away = np.abs(found.values - swing)[gone] / np.sqrt(found.variance[gone])
    assert 0.3 < (away < 1.0).mean() < 0.95  # as stated by the walk alone: 0.15
    assert (away < 1.96).mean() > 0.8  # 0.35
