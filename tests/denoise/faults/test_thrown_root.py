"""A root that leaps away for some frames and back."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.bodies.motion import Origin
from motionmend.denoise import repair_without_model
from motionmend.denoise.channels.joints import root_rows
from motionmend.denoise.faults.thrown_root import thrown
from motionmend.evaluate import corrupt
from motionmend.io import read
from performers import joints_model, truth

ACTIONS = ("walk", "run", "jump", "reach", "turn")


def _thrown(action, first, last, shift, fps=60.0, noise=0.0):
    clean = truth(action, seconds=5.0, fps=fps)
    q = corrupt(clean, noise=np.radians(noise), seed=1).recording.q.copy()
    _, moves = root_rows(clean.skeleton)
    off = np.zeros(q.shape, dtype=bool)
    off[first : last + 1, moves] = True
    q[first : last + 1, moves] += shift
    return clean, clean.with_q(q), off


@given(
    st.sampled_from(ACTIONS),
    st.integers(10, 200),
    st.integers(0, 40),
    st.integers(0, 10**6),
    st.sampled_from([0.0, 1.0]),
)
@settings(max_examples=30, deadline=None)
def test_a_root_off_by_a_metre_for_a_while_is_found_to_the_frame(action, first, length, seed, noise):
    along = np.random.default_rng(seed).standard_normal(3)
    _, bad, off = _thrown(action, first, first + length, along / np.linalg.norm(along), noise=noise)
    np.testing.assert_array_equal(thrown(bad), off)


@pytest.mark.parametrize("fps", [30.0, 120.0])
def test_single_frames_are_found_each_for_itself(fps):
    clean = truth("walk", seconds=5.0, fps=fps)
    _, moves = root_rows(clean.skeleton)
    away = np.arange(round(0.4 * fps), clean.frames - 10, round(0.3 * fps))
    q, off = clean.q.copy(), np.zeros(clean.q.shape, dtype=bool)
    q[away, moves[0]] += 0.3
    off[np.ix_(away, moves)] = True
    np.testing.assert_array_equal(thrown(clean.with_q(q)), off)


@pytest.mark.parametrize("before", [1, 2, 3, 4])
def test_a_gap_near_it_hides_it_not(before):
    clean, bad, off = _thrown("walk", 60, 69, np.array([0.6, 0.0, 0.8]))
    _, moves = root_rows(clean.skeleton)
    q = bad.q.copy()
    q[60 - before, moves] = np.nan
    found = thrown(bad.with_q(q))
    assert before == 1 or np.array_equal(found, off)


@pytest.mark.slow
@pytest.mark.parametrize("action", ACTIONS)
@pytest.mark.parametrize("fps", [15.0, 30.0, 120.0])
def test_nothing_is_found_in_what_people_do_nor_in_noise(action, fps):
    clean = truth(action, seconds=5.0, fps=fps)
    assert not thrown(clean).any()
    assert not thrown(corrupt(clean, noise=np.radians(3.0), seed=2).recording).any()
    assert thrown(clean.with_q(clean.q[:3])).shape == (3, clean.q.shape[1])


def test_who_is_put_elsewhere_for_good_stays_there():
    _, bad, _ = _thrown("walk", 150, 299, np.array([1.0, 0.0, 0.0]))
    assert not thrown(bad).any()


@pytest.mark.slow
def test_clean_recordings_are_left(data):
    for file in sorted((data / "mocap").rglob("*")):
        if file.suffix in (".amc", ".bvh"):
            motion = read(file, fps=120.0) if file.suffix == ".amc" else read(file)
            found = thrown(motion).any(axis=1)
            assert found.sum() <= 0.001 * len(found), file.name


@pytest.mark.slow
@pytest.mark.parametrize("taught", [False, True])
def test_it_is_brought_back_and_said(taught):
    clean, bad, off = _thrown("walk", 60, 69, np.array([0.6, 0.0, 0.8]), fps=30.0)
    outcome = joints_model().repair(bad) if taught else repair_without_model(bad)
    assert np.abs(outcome.recording.q - clean.q)[off].max() < 0.05
    assert (outcome.origin[off] == Origin.REPAIRED).all()
    assert any("leapt away and back, as no body can" in warning for warning in outcome.warnings)
    assert not any("leapt away" in warning for warning in repair_without_model(clean).warnings)


@pytest.mark.slow
def test_between_outliers_the_root_is_at_home():
    """Five in a hundred samples are off, each for itself: what lies between two that are off alike is not thrown."""
    good, found = [], []
    for action in ("walk", "run", "jump"):
        for seed in range(6):
            clean = truth(action, seconds=8.0, fps=120.0)
            bad = corrupt(clean, outliers=0.05, seed=seed).recording
            _, moves = root_rows(clean.skeleton)
            off = np.linalg.norm((bad.q - clean.q)[:, moves], axis=1) > 0.06
            told = thrown(bad)[:, moves].any(axis=1)
            good.append(told[~off].mean())
            found.append(told[off].mean())
    assert np.mean(good) < 0.02
    assert np.mean(found) > 0.975


@pytest.mark.slow
@pytest.mark.parametrize("fps", [30.0, 120.0])
@pytest.mark.parametrize("noise", [0.5, 2.0])
def test_a_stretch_is_found_among_outliers_and_noise_and_no_more_of_the_root(fps, noise):
    """One in twenty samples is off of its own, at the stretch's ends too; noise is a centimetre for each degree."""
    rng = np.random.default_rng(round(fps))
    found, good = [], []
    for seed in range(8):
        clean = truth(ACTIONS[seed % len(ACTIONS)], seconds=5.0, fps=fps)
        spoilt = corrupt(clean, noise=np.radians(noise), outliers=0.05, seed=seed)
        _, moves = root_rows(clean.skeleton)
        length = round(rng.uniform(0.2, 0.9) * fps)
        start = int(rng.integers(10, clean.frames - length - 10))
        shift = rng.standard_normal(3)
        q = spoilt.recording.q.copy()
        q[start : start + length, moves] += 0.9 * shift / np.linalg.norm(shift)
        told = thrown(clean.with_q(q))[:, moves].any(axis=1)
        off = spoilt.outlier[:, moves].any(axis=1)
        found.append(told[start : start + length].mean())
        off[start : start + length] = True
        good.append(told[~off].mean())
    assert np.mean(found) > 0.95, found
    assert np.mean(good) < 0.01, good


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.5, 2.0])
def test_a_stretch_in_noise_is_no_take_of_its_own(noise):
    clean, bad, off = _thrown("walk", 100, 148, np.array([0.6, 0.0, 0.8]), noise=noise)
    outcome = repair_without_model(bad)
    assert np.abs(outcome.recording.q - clean.q)[off].max() < 0.15
    assert not any("takes are joined" in warning for warning in outcome.warnings)


@pytest.mark.slow
@given(st.floats(-np.pi, np.pi), st.integers(0, 10**6))
@settings(max_examples=20, deadline=None)
def test_heading_makes_no_difference(angle, seed):
    clean = truth("run", seconds=3.0, fps=60.0)
    bad = corrupt(clean, outliers=0.08, seed=seed).recording
    _, moves = root_rows(clean.skeleton)
    turn = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
    q = bad.q.copy()
    q[:, moves] = q[:, moves] @ clean.skeleton.dof_axis[moves] @ turn.T @ np.linalg.inv(clean.skeleton.dof_axis[moves])
    np.testing.assert_array_equal(thrown(bad.with_q(q)), thrown(bad))
