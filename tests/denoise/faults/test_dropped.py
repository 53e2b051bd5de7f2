"""Joints that fall to exactly 0 for some frames, while they are elsewhere before and after."""

import numpy as np
import pytest

from motionmend.bodies.motion import Motion, Origin
from motionmend.bodies.skeleton import ROTATION
from motionmend.denoise import repair_without_model
from motionmend.denoise.faults.dropped import dropped
from motionmend.evaluate import compare
from motionmend.io import read
from motionmend.samples import markers
from performers import joints_model, truth

ARM = ("lhumerus", "lradius", "lwrist", "lhand")


def _angles(motion, joints):
    """The angles of these joints that ever move."""
    rows = np.concatenate([motion.skeleton.dofs_of(motion.skeleton.names.index(joint)) for joint in joints])
    moves = (motion.q != motion.q[:1]).any(axis=0)
    return rows[(motion.skeleton.dof_kind[rows] == ROTATION) & moves[rows]]


def _falling(motion, joints, first, last):
    """The motion with these joints at 0 in these frames, and (T, D) where that is."""
    q, fallen = motion.q.copy(), np.zeros(motion.q.shape, dtype=bool)
    columns = _angles(motion, joints)
    q[first : last + 1, columns] = 0.0
    fallen[first : last + 1, columns] = True
    return motion.with_q(q), fallen


@pytest.mark.parametrize("length", [1, 2, 15])
@pytest.mark.parametrize("joints", [ARM, ("lhumerus", "lradius"), ("lhumerus",)])
def test_what_falls_to_0_is_found_and_nothing_else(joints, length):
    clean = truth("reach")
    at = 100 - length // 2
    assert np.degrees(np.abs(clean.q[at, _angles(clean, ("lhumerus",))])).max() > 20.0
    spoilt, fallen = _falling(clean, joints, at, at + length - 1)
    np.testing.assert_array_equal(dropped(spoilt), fallen)


def test_what_falls_in_noise_is_found():
    clean = truth("reach")
    moves = (clean.q != clean.q[:1]).any(axis=0)
    noise = np.radians(1.0) * np.random.default_rng(1).standard_normal(clean.q.shape) * moves
    spoilt, fallen = _falling(clean.with_q(clean.q + noise), ARM, 95, 105)
    np.testing.assert_array_equal(dropped(spoilt), fallen)


@pytest.mark.parametrize("action", ["walk", "reach", "turn"])
def test_clean_motion_and_rounded_motion_are_left(action):
    clean = truth(action)
    for step in (0.0, 0.1, 0.5, 1.0):
        q = np.degrees(clean.q)
        assert not dropped(clean.with_q(np.radians(step * np.round(q / step)) if step else clean.q)).any()


def test_a_knee_at_its_limit_one_that_falls_at_either_end_and_who_is_mostly_at_0_are_left():
    clean = truth("walk")
    knee = _angles(clean, ("ltibia",))
    q = clean.q.copy()
    q[:, knee] = np.maximum(q[:, knee] - np.quantile(q[:, knee], 0.3), 0.0)
    assert (q[:, knee] == 0.0).mean() > 0.25
    assert not dropped(clean.with_q(q)).any()
    for first, last in ((0, 10), (140, 149), (20, 120)):
        assert not dropped(_falling(clean, ("lhumerus",), first, last)[0]).any()


def test_poses_without_anything_between_and_markers_are_left():
    clean = truth("reach")
    held = clean.q[::5].copy()
    held[20, _angles(clean, ARM)] = 0.0
    assert not dropped(clean.with_q(held.repeat(5, axis=0))).any()
    positions = markers(clean).positions.copy()
    positions[50:60] = 0.0
    assert not dropped(markers(clean).with_positions(positions)).any()


@pytest.mark.parametrize("frames", [0, 1, 2, 3, 5])
def test_few_frames(frames):
    clean = truth("reach")
    q = clean.q[:frames].copy()
    q[frames // 2 : frames // 2 + 1] = 0.0
    assert dropped(Motion(clean.skeleton, q, clean.fps)).shape == q.shape


@pytest.mark.slow
@pytest.mark.parametrize("library", [True, False])
def test_an_arm_that_falls_is_repaired_as_if_it_were_missing_and_said(library):
    clean = truth("reach")
    spoilt, fallen = _falling(clean, ARM[:2], 95, 103)

    def repaired(motion):
        return joints_model().repair(motion) if library else repair_without_model(motion)

    found, gaps = repaired(spoilt), repaired(clean.with_q(np.where(fallen, np.nan, clean.q)))
    np.testing.assert_array_equal(found.recording.q, gaps.recording.q)
    np.testing.assert_array_equal(found.std, gaps.std)
    assert (found.origin[fallen] == Origin.REPAIRED).all()
    assert compare(clean, found.recording).rms_deg < 0.2 * compare(clean, spoilt).rms_deg
    (said,) = [warning for warning in found.warnings if "exactly 0" in warning]
    assert "frames 95 to 103" in said
    assert not any("frozen" in warning for warning in found.warnings)


@pytest.mark.slow
def test_clean_recordings_are_left(data):
    for file in sorted((data / "mocap").rglob("*")):
        if file.suffix in (".amc", ".bvh"):
            assert not dropped(read(file)).any(), file.name
