"""What became of each sample, in a recording's own channels."""

import numpy as np
import pytest

from motionmend.bodies.motion import Origin
from motionmend.denoise import repair_without_model
from motionmend.denoise.channels.joints import root_rows
from motionmend.denoise.channels.layout import own_layout
from motionmend.denoise.channels.recording import from_channels, to_channels
from motionmend.denoise.outcome import _root_never_leapt
from performers import truth


@pytest.mark.slow
@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("action", ["walk", "turn"])
def test_an_angle_of_the_root_that_is_changed_by_much_is_repaired_whichever_way_the_root_turned(axis, action):
    """The root is repaired as one turn, in the travelling frame; its three angles in the file are others."""
    clean = truth(action, fps=60.0)
    turns = root_rows(clean.skeleton)[0]
    channels = to_channels(clean, own_layout(clean))
    values, hit = channels.values.copy(), np.arange(20, clean.frames - 20, 37)
    values[hit, turns[axis]] += 30.0
    q = clean.q.copy()
    q[hit] = from_channels(channels, values, np.ones(values.shape, dtype=bool), clean)[hit]
    outcome = repair_without_model(clean.with_q(q))
    changed = np.abs((outcome.recording.q - q + np.pi) % (2.0 * np.pi) - np.pi)[:, turns]
    assert (changed > np.radians(10.0)).sum() >= len(hit)
    assert (outcome.origin[:, turns][changed > np.radians(10.0)] == Origin.REPAIRED).all()
    assert (outcome.origin[:, turns][changed < np.radians(0.1)] == Origin.MEASURED).all()


@pytest.mark.parametrize("last", [120, None])
@pytest.mark.parametrize("leaps", [False, True])
def test_a_root_that_was_turned_about_though_it_never_leapt_is_given_back(leaps, last):
    """As of who rolls over: the repair took the middle, or all of the rest, for another way round."""
    motion, wrong = truth("walk", fps=60.0), slice(60, last)
    turns = root_rows(motion.skeleton)[0]
    turned = motion.q.copy()
    turned[wrong, turns[0]] += np.radians(150.0)
    recorded, values = (turned, motion.q.copy()) if leaps else (motion.q, turned.copy())
    origin = np.full(values.shape, Origin.REPAIRED, dtype=np.uint8)
    std, weights = (np.full(values.shape, one, dtype=np.float32) for one in (0.001, 0.5))
    repaired = values.copy()
    said = _root_never_leapt(motion.with_q(recorded), values, origin, std, weights)
    if leaps:  # what leapt was put right, and stays so
        np.testing.assert_array_equal(values, repaired)
        assert not said
        return
    np.testing.assert_allclose(values, motion.q)
    assert (origin[wrong][:, turns] == Origin.MEASURED).all()
    assert (std[wrong][:, turns] >= np.float32(np.radians(1.0))).all()
    assert len(said) == 1
    assert "as recorded" in said[0]
