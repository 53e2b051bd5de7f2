"""A root of which too little is recorded: what there is of it stays, and no place or heading is made up."""

import numpy as np
import pytest

from motionmend.bodies.motion import Origin
from motionmend.denoise import FixedLag, repair_with_lag, repair_without_model
from motionmend.denoise.channels.joints import root_rows
from performers import joints_model, truth

WAYS = {
    "adaptive": repair_without_model,
    "savgol": lambda motion: repair_without_model(motion, "savgol"),
    "kalman": lambda motion: repair_without_model(motion, "kalman"),
    "taught": lambda motion: joints_model().repair(motion),
    "paper": lambda motion: joints_model().repair(motion, "paper"),
    "live": lambda motion: repair_with_lag(joints_model(), motion, FixedLag(0.1)),
}


@pytest.mark.slow
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("group", [0, 1])  # its three rotations, its three translations
def test_a_channel_of_the_root_that_is_missing_throughout_takes_no_other_with_it(way, group):
    motion = truth("reach")
    rows = root_rows(motion.skeleton)[group]
    q = motion.q[:45] + np.radians(0.5) * np.random.default_rng(1).standard_normal((45, motion.q.shape[1]))
    q[:, rows[1]] = np.nan
    outcome = WAYS[way](motion.with_q(q))
    np.testing.assert_array_equal(outcome.recording.q[:, rows], q[:, rows])
    assert (outcome.origin[:, rows[[0, 2]]] == Origin.MEASURED).all()
    assert (outcome.origin[:, rows[1]] == Origin.LEFT_OPEN).all()
    assert np.isnan(outcome.std[:, rows[1]]).all()
    assert (outcome.std[:, rows[[0, 2]]] > 0.01).all()
    assert (outcome.weights[:, rows[[0, 2]]] == 1.0).all()
    assert any(motion.channels[rows[1]] in said and "kept" in said for said in outcome.warnings)
    assert np.isfinite(np.delete(outcome.recording.q, rows, axis=1)).all()


@pytest.mark.slow
@pytest.mark.parametrize("way", ["adaptive", "savgol"])
def test_a_long_gap_of_one_channel_of_the_root_takes_no_other_with_it(way):
    motion = truth("reach")
    rows = root_rows(motion.skeleton)[1]
    frames = min(motion.frames, round(6 * motion.fps))
    q, gap = motion.q[:frames].copy(), slice(frames // 6, None)
    q[gap, rows[0]] = np.nan
    outcome = WAYS[way](motion.with_q(q))
    assert (outcome.origin[:, rows[0]] == Origin.LEFT_OPEN).any()
    there = np.isfinite(q)
    assert np.isfinite(outcome.recording.q[there]).all()
    assert (outcome.origin[there] <= Origin.REPAIRED).all()
    np.testing.assert_array_equal(outcome.origin == Origin.LEFT_OPEN, ~np.isfinite(outcome.recording.q))
