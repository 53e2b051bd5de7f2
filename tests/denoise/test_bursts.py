"""How long samples are lost on end."""

from itertools import groupby

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionmend.denoise.bursts import LONG_BURST, long_runs


@given(st.integers(0, 2**32 - 1), st.integers(0, 60), st.sampled_from([1.0, 24.0, 30.0, 60.0, 120.0]))
def test_long_runs_are_those_of_more_frames_than_a_burst_may_have(seed, frames, fps):
    rng = np.random.default_rng(seed)
    lost = rng.random((frames, 3)) < rng.random()
    wanted = np.zeros(lost.shape, dtype=bool)
    for c in range(3):
        for here, run in groupby(range(frames), key=lambda t, c=c: lost[t, c]):
            run = list(run)
            wanted[run, c] = here and len(run) > round(LONG_BURST * fps)
    np.testing.assert_array_equal(long_runs(lost, fps), wanted)


@pytest.mark.parametrize("shape", [(0, 3), (3, 0)])
def test_of_nothing_nothing_is_lost(shape):
    assert long_runs(np.zeros(shape, dtype=bool), 30.0).shape == shape
