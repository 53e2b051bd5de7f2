"""Laws of robust estimators (figure 2.3)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionmend.numerics.robust import ESTIMATORS, spread

RESIDUALS = st.floats(-50, 50)
SCALES = st.floats(0.5, 10)
NAMES = st.sampled_from(sorted(ESTIMATORS))


@given(NAMES, RESIDUALS, SCALES)
def test_influence_is_the_slope_of_rho(name, r, p):
    e = ESTIMATORS[name]
    h = 1e-5
    slope = (e.rho(np.array([r + h]), p) - e.rho(np.array([r - h]), p)) / (2 * h)
    assert e.influence(np.array([r]), p)[0] == pytest.approx(slope[0], abs=1e-4)


@given(NAMES, RESIDUALS, RESIDUALS, SCALES)
def test_weighted_squares_lie_above_rho_and_touch_it(name, at, r, p):
    """What makes every step of the repair go downhill."""
    e = ESTIMATORS[name]
    w = e.weight(np.array([at]), p)[0]
    above = e.rho(np.array([at]), p)[0] + 0.5 * w * (r * r - at * at)
    assert above >= e.rho(np.array([r]), p)[0] - 1e-9 * (1 + abs(above))


@given(NAMES, SCALES)
def test_weight_starts_at_one_and_never_rises(name, p):
    w = ESTIMATORS[name].weight(np.linspace(0, 40, 200), p)
    assert w[0] == pytest.approx(1.0)
    assert (np.diff(w) <= 1e-12).all()
    assert (w >= 0).all()


@pytest.mark.parametrize("name", ["welsch", "tukey"])
def test_far_outliers_have_no_influence(name):
    assert ESTIMATORS[name].influence(np.array([60.0]), 3.0)[0] == pytest.approx(0.0, abs=1e-12)


def test_welsch_is_equation_2_9():
    r = np.array([0.0, 1.0, 3.0, 9.0])
    expected = 4.5 * (1 - np.exp(-(r**2) / 9))
    np.testing.assert_allclose(ESTIMATORS["welsch"].rho(r, 3.0), expected, rtol=1e-12)


def test_spread_is_the_standard_deviation_of_a_gaussian_despite_outliers(rng):
    values = rng.normal(scale=2.0, size=20000)
    values[:2000] = 1e3
    values[2000:2100] = np.nan
    assert spread(values) == pytest.approx(2.0, rel=0.15)
