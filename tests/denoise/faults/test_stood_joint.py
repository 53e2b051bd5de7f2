"""A joint that stands in noise while it should go on, or that has fallen to some value."""

import numpy as np
import pytest

from motionmend import repair_without_model
from motionmend.bodies.motion import Origin
from motionmend.denoise.faults.stood_joint import stood_joints
from performers import truth

NOISE = 0.5  # degrees


def _rows(motion, joint):
    return [d for d, name in enumerate(motion.skeleton.dof_names) if name.startswith(joint + ".")]


def _shaken(motion, noise=NOISE, seed=0):
    q = motion.q.copy()
    q[:, 6:] += np.radians(noise) * np.random.default_rng(seed).standard_normal(q[:, 6:].shape)
    return motion.with_q(q)


def _held(motion, joint, start, stop, value=None):
    q = motion.q.copy()
    for row in _rows(motion, joint):
        q[start:stop, row] = q[start, row] if value is None else value
    return motion.with_q(q)


@pytest.mark.parametrize(
    ("joint", "fps"),
    [
        ("lfemur", 60.0),
        ("rhumerus", 60.0),
        ("lfemur", 120.0),
        ("rhumerus", 120.0),
        ("ltibia", 120.0),
    ],  # at 60 Hz too quick
)
@pytest.mark.parametrize("fallen", [False, True])
def test_who_stands_in_noise_and_leaps_on_is_found_and_nobody_else(joint, fps, fallen):
    clean = truth("run", seconds=4.0, fps=fps)
    rows, length = _rows(clean, joint), round(0.25 * fps)
    quickest = max(
        range(20, clean.frames - length - 20),
        key=lambda f: np.abs(clean.q[f + length, rows] - clean.q[f, rows]).max(),
    )
    value = clean.q[:, rows].mean() + np.radians(120.0) if fallen else None
    held = _held(clean, joint, quickest, quickest + length, value)
    found = stood_joints(_shaken(held))
    there = np.zeros(found.shape, np.bool_)
    there[quickest + 2 : quickest + length, rows] = True
    assert found[there].all()
    there[quickest - round(0.05 * fps) : quickest + length, rows] = True
    assert not found[~there].any()


@pytest.mark.slow
@pytest.mark.parametrize("action", ["walk", "run", "jump", "reach", "turn"])
@pytest.mark.parametrize("noise", [0.0, 0.5, 3.0])
def test_who_rests_may(action, noise):
    for fps in (30.0, 120.0):
        assert not stood_joints(_shaken(truth(action, seconds=4.0, fps=fps), noise)).any()


def test_outliers_and_who_is_off_by_one_amount_for_a_while_are_no_stands():
    clean = truth("walk", seconds=4.0, fps=60.0)
    rng = np.random.default_rng(4)
    spoilt = _shaken(clean, 2.0).q.copy()
    spoilt[:, 6:] += (rng.random(spoilt[:, 6:].shape) < 0.2) * rng.uniform(-1.0, 1.0, spoilt[:, 6:].shape)
    assert not stood_joints(clean.with_q(spoilt)).any()
    rest = np.repeat(clean.q[:1], 200, axis=0)
    rest[90:100, _rows(clean, "lradius")] += np.radians(40.0)
    slipped = stood_joints(_shaken(clean.at_frames(np.arange(200)).with_q(rest)))
    assert not slipped[:90].any()  # who stands before and after is right
    assert not slipped[100:].any()


def test_angles_that_leap_to_others_of_the_same_rotation_are_no_leap():
    clean = truth("walk", seconds=4.0, fps=60.0)
    rows = _rows(clean, "lhumerus")
    q = clean.q.copy()
    q[100:130, rows] = q[100, rows]
    leapt = q.copy()
    leapt[130:, rows] += np.radians([60.0, 0.0, 0.0])
    q[130:, rows] = q[130:, rows] * [1.0, -1.0, 1.0] + np.pi  # about three axes at right angles
    assert not stood_joints(_shaken(clean.with_q(q), 1.0)).any()
    assert stood_joints(_shaken(clean.with_q(leapt), 1.0))[102:130, rows].all()


def test_who_leaps_in_one_angle_while_another_is_missing_is_not_asked():
    clean = truth("run", seconds=4.0, fps=120.0)
    rows = _rows(clean, "lhumerus")
    q = _shaken(_held(clean, "lhumerus", 150, 180, 2.0)).q.copy()
    q[:, rows[1]] = np.nan
    assert not stood_joints(clean.with_q(q)).any()


def test_toes_rest_and_snap_by_themselves():
    clean = truth("run", seconds=4.0, fps=120.0)
    foot, toes = (stood_joints(_shaken(_held(clean, joint, 150, 180, 2.0))) for joint in ("lfoot", "ltoes"))
    assert foot[150:180, _rows(clean, "lfoot")].all()
    assert not toes.any()


@pytest.mark.parametrize("frames", [0, 1, 5, 20])
def test_few_frames_tell_nothing(frames):
    assert not stood_joints(truth("walk", seconds=4.0, fps=60.0).at_frames(np.arange(frames))).any()


@pytest.mark.slow
@pytest.mark.parametrize("fallen", [False, True])
def test_it_is_filled_and_said(fallen):
    """It was left as it was recorded."""
    clean = truth("run", seconds=4.0, fps=120.0)
    rows = _rows(clean, "ltibia")
    start = int(np.argmax(np.abs(clean.q[130:400, rows[0]] - clean.q[100:370, rows[0]]))) + 100
    value = clean.q[:, rows].mean() + np.radians(120.0) if fallen else None
    spoilt = _shaken(_held(clean, "ltibia", start, start + 30, value))
    outcome = repair_without_model(spoilt)
    window = slice(start + 2, start + 30)
    off, was = outcome.recording.q - clean.q, spoilt.q - clean.q
    assert np.abs(off[window][:, rows]).max() < 0.5 * np.abs(was[window][:, rows]).max()
    assert (outcome.origin[window][:, rows] == Origin.REPAIRED).all()
    assert any("joints that stood still in noise and leapt on" in warning for warning in outcome.warnings)
