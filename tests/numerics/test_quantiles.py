"""Quantiles of columns that lack samples."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.numerics.quantiles import median, quantile_of_known


@pytest.mark.slow
@given(
    st.integers(1, 60),
    st.integers(1, 8),
    st.floats(0.0, 1.0),
    st.floats(0.0, 1.0),
    st.integers(0, 2**31),
)
@settings(max_examples=200, deadline=None)
@pytest.mark.filterwarnings("ignore:All-NaN")
def test_they_are_those_of_numpy_to_the_last_bit(count, columns, share, lacking, seed):
    rng = np.random.default_rng(seed)
    values = rng.standard_normal((count, columns, 2)) * 10.0 ** rng.integers(-3, 3, (columns, 2))
    values[rng.random(values.shape) < lacking] = np.nan
    kept = values.copy()
    np.testing.assert_array_equal(quantile_of_known(values, share), np.nanquantile(values, share, axis=0))
    np.testing.assert_array_equal(values, kept)


@given(st.integers(1, 9), st.integers(0, 2), st.sampled_from([0.0, 0.1]), st.integers(0, 2**31))
@settings(max_examples=60)
def test_medians_are_those_of_numpy_to_the_last_bit(count, digits, lacking, seed):
    """With few digits many values are alike."""
    rng = np.random.default_rng(seed)
    values = np.round(rng.standard_normal((count, 2, 3)), digits)
    values[rng.random(values.shape) < lacking] = np.nan
    np.testing.assert_array_equal(median(values), np.median(values, axis=0))
    np.testing.assert_array_equal(median(values[:, 0, 0]), np.median(values[:, 0, 0]))
