"""The library of poses that clips give."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.track.database import database_of
from performers import truth


@pytest.mark.slow
@given(st.lists(st.integers(1, 12), min_size=1, max_size=3, unique=True))
@settings(max_examples=15, deadline=None)
def test_nothing_follows_a_pose_across_a_gap(missing):
    clip = truth("walk")
    step = max(1, round(clip.fps / 30.0))
    q = clip.q[: 14 * step].copy()
    whole, *_ = database_of([clip.with_q(q)])
    q[[step * t for t in missing], 7] = np.nan
    split, poses, _ = database_of([clip.with_q(q)])
    kept = np.setdiff1d(np.arange(14), missing)
    np.testing.assert_allclose(split.joints, whole.joints[kept], atol=1e-9)
    assert len(poses) == len(kept)
    for i, t in enumerate(kept):
        after = split.following(np.array([i]), 1)[0, 0]
        assert kept[after] == (t + 1 if t + 1 in kept else t)


def test_a_clip_of_which_no_pose_is_whole_teaches_nothing():
    clip = truth("walk")
    q = clip.q.copy()
    q[:, 7] = np.nan
    assert len(database_of([replace(clip, q=q)])[0]) == 0
