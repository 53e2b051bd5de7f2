"""A single joint that freezes while the rest of the body goes on."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from motionmend import repair_without_model
from motionmend.bodies.motion import Origin
from motionmend.denoise.faults.stuck_joint import ALONE, RECORDED_SO, stuck_joints
from performers import truth

JOINTS = ("lfemur", "rfemur", "lhumerus", "rhumerus", "ltibia", "rradius")


def _rows(motion, joint):
    return [d for d, name in enumerate(motion.skeleton.dof_names) if name.startswith(joint + ".")]


def _held(motion, joint, start, stop):
    """The motion with a joint as in the frame `start` until before `stop`."""
    q = motion.q.copy()
    for row in _rows(motion, joint):
        q[start:stop, row] = q[start, row]
    return motion.with_q(q)


def _found(motion):
    return stuck_joints(motion, np.zeros(motion.q.shape, np.bool_))


@pytest.mark.slow
@given(st.sampled_from(JOINTS), st.sampled_from([30.0, 60.0, 120.0]), st.integers(0, 10**6))
@example("ltibia", 30.0, 223)  # 18 degrees, and it moves by 13 from frame to frame
@example("rradius", 120.0, 12)  # held where it is straightest
@settings(max_examples=30, deadline=None)
def test_it_is_found_where_it_leaps_on_and_nothing_else_is(joint, fps, seed):
    rng = np.random.default_rng(seed)
    clean = truth("walk", seconds=4.0, fps=fps)
    length = int(rng.uniform(0.2, 0.5) * fps)
    start = int(rng.integers(10, clean.frames - length - 10))
    rows, stop = _rows(clean, joint), start + length
    own, held = clean.q[:, rows], clean.q[start, rows]
    away, step = (np.degrees(np.abs(some)).max() for some in (own[stop - 1] - held, np.diff(own, axis=0)))
    others = np.delete(own, slice(start, stop), axis=0)
    at_limit = ((held <= others.min(axis=0)) | (held >= others.max(axis=0)) | (held == 0.0)).all()
    found = _found(_held(clean, joint, start, stop))
    there = np.zeros(found.shape, np.bool_)
    there[start + 1 : stop, rows] = True
    assert not found[~there].any()
    assert found[there].all() or away < max(8.0, 2.0 * step) or at_limit  # else it leaps farther than it ever moves


@pytest.mark.slow
@pytest.mark.parametrize("action", ["walk", "run", "jump", "reach", "turn"])
@pytest.mark.parametrize("fps", [30.0, 120.0])
def test_nothing_is_found_in_a_clean_recording(action, fps):
    assert not _found(truth(action, fps=fps)).any()


def test_a_joint_at_its_limit_or_at_rest_is_not_stuck():
    clean = truth("walk", seconds=4.0, fps=60.0)
    row = _rows(clean, "ltibia")
    limit = clean.q.copy()
    limit[:, row] = np.maximum(limit[:, row], np.quantile(limit[:, row], 0.4))
    assert not _found(clean.with_q(limit)).any()
    rest = clean.q.copy()
    hip = _rows(clean, "lfemur")
    for stretch in (slice(60, 90), slice(150, 175)):
        rest[stretch, hip] = rest[60, hip]
    assert not _found(clean.with_q(rest)).any()
    assert not _found(_held(clean, "lfemur", clean.frames - 40, clean.frames)).any()  # it may have come to rest


@pytest.mark.parametrize("fps", [30.0, 60.0, 120.0])
@pytest.mark.parametrize("seconds", [0.4, 1.5, 2.5])
def test_one_angle_of_a_joint_is_found_however_long_it_holds(fps, seconds):
    clean = truth("walk", seconds=6.0, fps=fps)
    row, start = _rows(clean, "lfemur")[-1], round(2.0 * fps)
    stop = start + round(seconds * fps)
    q = clean.q.copy()
    while (around := np.abs(np.diff(q[[start, stop], row]))[0]) < np.radians(10.0):
        stop += 1
    assert around >= np.radians(10.0)  # it leaps on
    q[start:stop, row] = q[start, row]
    there = np.zeros(q.shape, np.bool_)
    there[start + 1 : stop, row] = True
    np.testing.assert_array_equal(_found(clean.with_q(q)), there)


def test_one_angle_that_holds_for_a_moment_or_at_its_limit_is_left():
    clean = truth("walk", seconds=6.0, fps=60.0)
    row = _rows(clean, "lfemur")[-1]
    q = clean.q.copy()
    q[100 : 100 + round(ALONE * 60.0) - 1, row] = q[100, row]
    assert not _found(clean.with_q(q)).any()
    assert not _found(clean.with_q(np.minimum(clean.q, np.quantile(clean.q, 0.6, axis=0)))).any()


def test_joints_that_hold_together_for_long_are_found():
    clean = truth("walk", seconds=6.0, fps=60.0)
    start, stop = 100, 100 + round(RECORDED_SO * 60.0) + 20
    both = _held(_held(clean, "lfemur", start, stop), "rhumerus", start, stop)
    rows = [*_rows(clean, "lfemur"), *_rows(clean, "rhumerus")]
    there = np.zeros(clean.q.shape, np.bool_)
    there[start + 1 : stop, rows] = True
    np.testing.assert_array_equal(_found(both), there)


def test_joints_that_hold_and_leap_together_are_left():
    clean = truth("walk", seconds=4.0, fps=60.0)
    one = _held(clean, "lfemur", 100, 130)
    assert _found(one).any()
    assert not _found(_held(one, "rhumerus", 100, 130)).any()
    assert _found(_held(one, "rhumerus", 110, 140)).any()


@pytest.mark.slow
def test_it_is_repaired_and_said_while_a_clean_recording_says_nothing():
    clean = truth("walk", seconds=4.0, fps=60.0)
    start, stop = 100, 130
    rows = _rows(clean, "lfemur")
    spoilt = _held(clean, "lfemur", start, stop)
    found = repair_without_model(spoilt)
    inside = np.ix_(range(start + 1, stop), rows)
    assert (found.origin[inside] == Origin.REPAIRED).all()
    assert (np.delete(found.origin, rows, axis=1) == Origin.MEASURED).all()
    before, after = (np.sqrt(np.square(q - clean.q)[inside].mean()) for q in (spoilt.q, found.recording.q))
    assert after < 0.5 * before
    assert any("were frozen and taken as missing, frames 101 to 129" in said for said in found.warnings)
    assert not any("frozen" in said for said in repair_without_model(clean).warnings)
