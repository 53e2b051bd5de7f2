"""A rest pose before a recording stays as it is and disturbs nothing."""

import numpy as np
import pytest

from motionmend.bodies.motion import Origin
from motionmend.bodies.skeleton import ROTATION
from motionmend.denoise import Denoiser, repair_without_model
from motionmend.denoise.library.learning import glitches
from motionmend.evaluate import corrupt
from motionmend.io import read
from motionmend.samples import clip
from performers import joints_model, truth


def resting(motion):
    """One frame (1, D) of the motion's root place with all angles zero."""
    frame = motion.q[:1].copy()
    frame[:, motion.skeleton.dof_kind == ROTATION] = 0.0
    return frame


@pytest.mark.slow
@pytest.mark.parametrize("method", ["adaptive", "paper", "savgol", "linear"])
def test_it_stays_and_the_rest_is_repaired_as_without_it(method):
    walk = truth("walk", seconds=3.0)
    spoilt = corrupt(walk, noise=np.radians(1), gaps=0.05, seed=2).recording
    rest = resting(walk)
    before = spoilt.with_q(np.vstack([rest, spoilt.q]))
    model = joints_model()
    with_it, without = model.repair(before, method), model.repair(spoilt, method)
    np.testing.assert_array_equal(with_it.recording.q[:1], rest)
    np.testing.assert_array_equal(with_it.recording.q[1:], without.recording.q)
    np.testing.assert_array_equal(with_it.origin[1:], without.origin)
    assert (with_it.origin[0] == Origin.MEASURED).all()
    assert any("frame 0 is a rest pose" in said for said in with_it.warnings)
    assert not any("rest pose" in said for said in without.warnings)


@pytest.mark.slow
def test_without_a_model_too():
    walk = truth("walk", seconds=3.0)
    rest = resting(walk)
    repaired = repair_without_model(walk.with_q(np.vstack([rest, rest, rest, walk.q])), "adaptive")
    np.testing.assert_array_equal(repaired.recording.q[:3], np.vstack([rest, rest, rest]))
    assert any("frames 0 to 2 are a rest pose" in said for said in repaired.warnings)
    rest[0, 8] = np.nan
    repaired = repair_without_model(walk.with_q(np.vstack([rest, walk.q])), "adaptive")
    np.testing.assert_array_equal(repaired.recording.q[:1], rest)
    assert repaired.origin[0, 8] == Origin.LEFT_OPEN
    assert np.isnan(repaired.std[0, 8])


def test_nothing_is_learned_from_it():
    clips = [clip(action, seconds=3.0, fps=30.0, seed=3) for action in ("walk", "reach")]
    rested = [c.with_q(np.vstack([resting(c), c.q])) for c in clips]
    for one in rested:
        (found,) = glitches(one)
        assert (found.start, found.stop, len(found.rows)) == (0, 1, one.q.shape[1])
    plain, other = (Denoiser(window=20, fps=30.0).fit(some) for some in (clips, rested))
    np.testing.assert_allclose(other.bases.mean, plain.bases.mean, atol=1e-9)
    assert any("rest poses before a clip" in note for note in other.notes)


@pytest.mark.slow
def test_a_clean_file_with_one_is_left_alone(data):
    for name in ("10_04", "32_01"):
        motion = read(data / "mocap" / "bvh" / f"{name}.bvh")
        repaired = repair_without_model(motion, "adaptive").recording
        np.testing.assert_array_equal(repaired.q[0], motion.q[0])
        turned = np.degrees((repaired.q - motion.q + np.pi) % (2 * np.pi) - np.pi)[:, 6:]
        assert np.sqrt(np.mean(np.square(turned))) < 0.3
