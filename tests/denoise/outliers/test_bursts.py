"""How long samples are lost on end."""

from itertools import groupby

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import motionmend as mm
from motionmend.denoise.outliers.bursts import LONG_BURST, SHORT_GAP, long_runs, short_runs


@given(st.integers(0, 2**32 - 1), st.integers(0, 60), st.sampled_from([1.0, 24.0, 30.0, 60.0, 120.0]))
def test_long_runs_are_those_of_more_frames_than_a_burst_may_have(seed, frames, fps):
    rng = np.random.default_rng(seed)
    lost = rng.random((frames, 3)) < rng.random()
    wanted, short = np.zeros((2, *lost.shape), dtype=bool)
    for c in range(3):
        for here, run in groupby(range(frames), key=lambda t, c=c: lost[t, c]):
            run = list(run)
            wanted[run, c] = here and len(run) > round(LONG_BURST * fps)
            short[run, c] = here and len(run) <= max(1, round(SHORT_GAP * fps))
    np.testing.assert_array_equal(short_runs(lost, fps), short)
    np.testing.assert_array_equal(long_runs(lost, fps), wanted)


@pytest.mark.parametrize("shape", [(0, 3), (3, 0)])
def test_of_nothing_nothing_is_lost(shape):
    assert long_runs(np.zeros(shape, dtype=bool), 30.0).shape == shape
    assert short_runs(np.zeros(shape, dtype=bool), 30.0).shape == shape


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.1, 0.3])
@pytest.mark.parametrize(("clip", "first"), [("cmu_02_05", 600), ("cmu_135_02", 1000), ("hdm05_bd_05-01_01_120", 3000)])
def test_markers_that_flicker_are_where_they_move_and_as_sure_as_that_is(data, clip, first, share):
    whole = mm.read(data / "mocap" / "c3d" / f"{clip}.c3d")
    assert isinstance(whole, mm.Markers)
    clean = whole.positions[first : first + 240, :30]
    assert np.isfinite(clean).all()
    rng = np.random.default_rng(0)
    gone = rng.random(clean.shape[:2]) < share
    seen = np.where(gone[:, :, None], np.nan, clean + 0.001 * rng.standard_normal(clean.shape))
    told = mm.repair_without_model(mm.Markers(whole.names[:30], seen, whole.fps))
    off = np.abs(told.recording.positions - clean)[gone]
    assert np.sqrt(np.mean(np.square(off))) < 0.0015
    assert 0.9 < (off < 1.96 * told.std[gone][:, None]).mean() <= 1.0
