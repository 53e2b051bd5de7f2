"""Where a mask holds, and how far that is."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionmend.arrays import away_from, runs

MASKS = st.lists(st.booleans(), max_size=30)


@given(MASKS)
def test_runs_are_all_that_a_mask_holds_and_none_touches_the_next(mask):
    found = runs(mask)
    assert sorted(i for start, stop in found for i in range(start, stop)) == list(np.flatnonzero(mask))
    assert all(stop < start for (_, stop), (start, _) in pairwise(found))


@pytest.mark.slow
@given(MASKS)
def test_the_nearest_at_which_a_mask_holds_is_so_far(mask):
    holds = np.flatnonzero(mask)
    wanted = [min((abs(i - k) for k in holds), default=np.inf) for i in range(len(mask))]
    np.testing.assert_array_equal(away_from(mask), wanted)
