import json

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.report.packed import FINEST, pack, pack_bytes, unpack, unpack_bytes

sizes = st.tuples(st.integers(1, 40), st.integers(1, 6))


@settings(max_examples=60)
@given(sizes, st.integers(0, 2**32 - 1), st.sampled_from([1e-3, 1.0, 6.0, 300.0]), st.floats(0, 1))
def test_values_come_back_within_half_a_step_and_gaps_as_gaps(size, seed, scale, gaps):
    rng = np.random.default_rng(seed)
    values = rng.normal(0, scale, size) + rng.normal(0, 10 * scale, size[1])
    values[rng.random(size) < gaps] = np.nan
    block = json.loads(json.dumps(pack(values), allow_nan=False))
    back = unpack(block)
    assert np.array_equal(np.isnan(back), np.isnan(values))
    error = np.abs(back - values)
    there = np.isfinite(values)
    bound = np.broadcast_to(np.array(block["step"]) * 0.5 * (1 + 1e-6), size)
    assert (error[there] <= bound[there]).all()


def test_the_step_is_a_tenth_of_a_millimetre_until_a_column_is_wide():
    narrow, wide = np.linspace(0, 6.0, 50), np.linspace(-100, 100, 50)
    block = pack(np.stack([narrow, wide], axis=1))
    assert block["step"] == [FINEST, round(200 / 65000, 11)]
    assert np.abs(unpack(block) - np.stack([narrow, wide], axis=1)).max() < 200 / 65000 * 0.51


def test_infinity_counts_as_missing_and_an_empty_column_stays_empty():
    values = np.array([[1.0, np.nan], [np.inf, np.nan], [-np.inf, np.nan]])
    back = unpack(pack(values))
    assert np.array_equal(np.isnan(back), [[False, True], [True, True], [True, True]])


@given(sizes, st.integers(0, 2**32 - 1))
def test_bytes_come_back(size, seed):
    values = np.random.default_rng(seed).integers(0, 4, size).astype(np.uint8)
    assert np.array_equal(unpack_bytes(pack_bytes(values)), values)


def test_smooth_motion_takes_less_than_half_of_its_codes():
    t = np.linspace(0, 8, 1000)[:, None]
    smooth = np.sin(t + np.arange(93)) + 0.3 * np.sin(5 * t)
    assert len(pack(smooth)["data"]) < 0.5 * smooth.size * 2 * 4 / 3
