"""Takes of a few frames."""

import numpy as np
import pytest

from motionmend import repair_without_model
from motionmend.bodies.motion import Markers, Origin
from motionmend.denoise.too_short import FEWEST_FRAMES
from motionmend.samples import markers
from performers import every_other, half_the_markers_model, joints_model, truth


def _takes(frames):
    """Joint angles and markers, with noise and two samples missing."""
    rng = np.random.default_rng(frames)
    motion = truth("reach")
    q = motion.q[40 : 40 + frames] + np.radians(2.0) * rng.standard_normal((frames, motion.q.shape[1]))
    places = every_other(markers(motion))
    positions = places.positions[40 : 40 + frames] + rng.normal(0.0, 0.005, (frames, *places.positions.shape[1:]))
    q[0, 9] = np.nan
    positions[0, 3] = np.nan
    return motion.with_q(q), Markers(places.names, positions, places.fps, up=places.up)


@pytest.mark.slow
@pytest.mark.parametrize("taught", [False, True])
@pytest.mark.parametrize("frames", range(1, FEWEST_FRAMES))
def test_what_nothing_tells_of_is_kept_and_said(frames, taught):
    motion, places = _takes(frames)
    for take, model in ((motion, joints_model()), (places, half_the_markers_model())):
        outcome = model.repair(take) if taught else repair_without_model(take)
        there = take.present
        given, out = (one.q if take is motion else one.positions for one in (take, outcome.recording))
        np.testing.assert_array_equal(out[there], given[there])
        assert (outcome.origin[there] == Origin.MEASURED).all()
        assert (outcome.std[there] >= 0.02).all()
        filled = outcome.origin == Origin.FILLED
        assert np.isfinite(outcome.std[filled]).all()
        assert np.isnan(outcome.std[outcome.origin == Origin.LEFT_OPEN]).all()
        words = "1 frame tells too little" if frames == 1 else f"{frames} frames tell too little"
        assert any(said.startswith(words) and "a guess" in said for said in outcome.warnings)


@pytest.mark.parametrize("taught", [False, True])
def test_no_frames_are_no_frames(taught):
    motion = truth("reach")
    places = every_other(markers(motion))
    for take, model in ((motion, joints_model()), (places, half_the_markers_model())):
        take = take.at_frames(slice(0, 0))
        outcome = model.repair(take) if taught else repair_without_model(take)
        assert outcome.recording.frames == 0


@pytest.mark.slow
@pytest.mark.parametrize("frames", [FEWEST_FRAMES, 10])
def test_a_few_more_are_repaired_and_as_far_off_as_they_say(frames):
    """Without a library, for which alone the recording speaks."""
    clean = truth("walk")
    near = []
    for first in range(10, 110, 10):
        rng = np.random.default_rng(first)
        part = clean.q[first : first + frames]
        outcome = repair_without_model(clean.with_q(part + np.radians(2.0) * rng.standard_normal(part.shape)))
        assert not any("a guess" in said for said in outcome.warnings)
        near.append(np.abs(outcome.recording.q - part)[:, 6:] / outcome.std[:, 6:])
    assert 0.6 < (np.concatenate(near) < 1.0).mean() < 0.8
    assert (np.concatenate(near) < 1.96).mean() > 0.9
