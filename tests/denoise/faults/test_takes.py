"""Takes that were joined, and scenes that were put elsewhere."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.bodies.motion import Markers, Origin
from motionmend.denoise import Denoiser, repair_without_model
from motionmend.denoise.channels.joints import root_rows
from motionmend.denoise.faults.takes import first_frames, repaired_in_takes
from motionmend.evaluate import corrupt
from motionmend.samples import clip, markers
from performers import FPS, clips, joints_model, truth


def _thinned(recording):
    """A recording of every third marker: of who is put elsewhere whole, as good as more."""
    return Markers(recording.names[::3], recording.positions[:, ::3], recording.fps, up=recording.up)


@cache
def _thinned_model():
    return Denoiser(window=20, fps=FPS).fit([_thinned(markers(motion)) for motion in clips()])


ACTIONS = ("walk", "run", "jump", "reach", "turn")


def _moved(recording, first, last, shift):
    """The recording with frames first to last - 1 elsewhere."""
    if isinstance(recording, Markers):
        positions = recording.positions.copy()
        positions[first:last] += shift
        return recording.with_positions(positions)
    q = recording.q.copy()
    q[first:last, root_rows(recording.skeleton)[1]] += shift
    return recording.with_q(q)


def _spliced(recording, first, last):
    """The recording without frames first to last - 1."""
    return recording.with_positions(np.delete(recording.positions, np.s_[first:last], axis=0))


@pytest.mark.slow
@given(
    st.sampled_from(ACTIONS),
    st.booleans(),
    st.integers(30, 260),
    st.floats(0.8, 5.0),
    st.integers(0, 10**6),
    st.sampled_from([0.0, 2.0]),
)
@settings(max_examples=30, deadline=None)
def test_a_lasting_leap_of_everything_is_found_to_the_frame(action, joints, at, far, seed, noise):
    clean = truth(action, fps=60.0)
    along = np.random.default_rng(seed).standard_normal(3)
    recording = clean if joints else markers(clean)
    spoilt = corrupt(recording, noise=np.radians(noise) if joints else 0.01 * noise / 2.0, seed=1).recording
    bad = _moved(spoilt, at, clean.frames, far * along / np.linalg.norm(along))
    assert first_frames(bad).tolist() == [at]


@pytest.mark.slow
@pytest.mark.parametrize("action", ACTIONS)
@pytest.mark.parametrize("fps", [15.0, 30.0, 120.0])
def test_nothing_is_found_in_what_people_do_nor_in_noise_and_outliers(action, fps):
    clean = truth(action, fps=fps)
    for recording, noise in ((clean, np.radians(5.0)), (markers(clean), 0.02)):
        assert not len(first_frames(recording))
        for outliers in (0.0, 0.1, 0.2):
            assert not len(first_frames(corrupt(recording, noise=noise, outliers=outliers, seed=2).recording))


@pytest.mark.parametrize("frames", [1, 3, 8, 20, 50])
def test_who_comes_back_within_a_second_was_never_put_elsewhere(frames):
    clean = markers(truth("walk", fps=60.0))
    assert not len(first_frames(_moved(clean, 120, 120 + frames, np.array([1.0, 0.0, 0.5]))))


@pytest.mark.parametrize("frames", [0, 1, 2, 5])
def test_short_recordings_and_those_without_anybody_have_none(frames):
    clean = markers(truth("walk"))
    short = clean.with_positions(clean.positions[:frames])
    assert not len(first_frames(short))
    assert not len(first_frames(clean.with_positions(np.full_like(clean.positions, np.nan))))


@pytest.mark.slow
@pytest.mark.parametrize("taught", [False, True])
def test_of_joined_takes_every_sample_stays_and_it_is_said(taught):
    clean = _thinned(markers(truth("walk", seconds=8.0, fps=30.0)))
    joined = _spliced(clean, 100, 160)
    outcome = _thinned_model().repair(joined) if taught else repair_without_model(joined)
    assert (outcome.origin == Origin.MEASURED).all()
    assert np.abs(outcome.recording.positions - joined.positions).max() < 0.005
    assert any("before frame 100;" in said for said in outcome.warnings)
    assert outcome.recording.frames == joined.frames


@pytest.mark.slow
@pytest.mark.parametrize("taught", [False, True])
def test_noise_and_gaps_on_either_side_are_repaired(taught):
    clean = truth("walk", seconds=8.0, fps=30.0)
    spoilt = corrupt(clean, noise=np.radians(2.0), outliers=0.05, seed=3)
    bad = _moved(spoilt.recording, 120, clean.frames, np.array([0.0, 0.0, 2.0]))
    aim = _moved(clean, 120, clean.frames, np.array([0.0, 0.0, 2.0]))
    outcome = joints_model().repair(bad) if taught else repair_without_model(bad)
    whole = joints_model().repair(spoilt.recording) if taught else repair_without_model(spoilt.recording)
    off = np.sqrt(np.mean(np.square(outcome.recording.q - aim.q)))
    assert off < 1.3 * np.sqrt(np.mean(np.square(whole.recording.q - clean.q)))
    assert outcome.noise is not None
    assert outcome.noise.shape == (clean.q.shape[1],)


@pytest.mark.slow
def test_residuals_stay_with_their_frames():
    clean = _thinned(markers(truth("walk", fps=30.0)))
    residuals = np.arange(clean.frames * len(clean.names), dtype=float).reshape(clean.frames, -1)
    bad = _moved(replace(clean, residuals=residuals), 70, clean.frames, np.array([3.0, 0.0, 0.0]))
    outcome = repair_without_model(bad)
    np.testing.assert_array_equal(outcome.recording.residuals, residuals)


def test_what_is_said_of_a_take_counts_from_its_first_frame_and_what_holds_of_all_is_said_once():
    clean = markers(truth("walk", seconds=8.0, fps=30.0))
    bad = _moved(clean, 100, clean.frames, np.array([3.0, 0.0, 0.0]))

    def repair(take):
        return replace(repair_without_model(take, "linear"), warnings=("of all", f"of {take.frames} frames"))

    common, cut, *said = repaired_in_takes(bad, repair).warnings
    assert common == "of all"
    assert "before frame 100;" in cut
    assert said == ["of 100 frames", f"from frame 100 on, counted from there: of {clean.frames - 100} frames"]


@pytest.mark.parametrize("seed", range(6))
def test_what_rattles_near_the_root_throws_half_of_the_body_and_is_no_other_take(seed):
    clean = clip("walk", seconds=2, fps=120.0, seed=seed)
    rng = np.random.default_rng(seed)
    trunk = np.flatnonzero(clean.skeleton.parents[clean.skeleton.dof_joint] == 0)
    q = np.array(clean.q)
    for channel in rng.permutation(trunk)[:3]:
        first = int(rng.integers(30, 160))
        q[first : first + 40, channel] += np.radians(45.0) * rng.choice([-1.0, 1.0], 40)
    assert not len(first_frames(clean.with_q(q)))


@pytest.mark.parametrize("noise", [0.0, 0.005])
@pytest.mark.parametrize("last", [170, 300])
def test_limbs_and_people_that_change_their_labels_are_no_other_take(noise, last):
    clean = corrupt(markers(truth("walk", fps=60.0)), noise=noise, seed=1).recording
    left = [k for k, name in enumerate(clean.names) if "L" + name[1:] == name and "R" + name[1:] in clean.names]
    right = [clean.names.index("R" + clean.names[k][1:]) for k in left]
    limbs = replace(
        clean, names=tuple(clean.names[k] for k in left + right), positions=clean.positions[:, left + right]
    )
    some = _thinned(clean)
    two = replace(
        some,
        names=tuple(f"{who}:{name}" for who in ("Ann", "Bob") for name in some.names),
        positions=np.concatenate([some.positions, some.positions[::-1] + np.array([0.7, 0.0, 0.3])], axis=1),
    )
    for recording in (limbs, two):
        assert not len(first_frames(recording))
        positions = recording.positions.copy()
        positions[100:last] = np.roll(positions[100:last], len(recording.names) // 2, axis=1)
        assert not len(first_frames(recording.with_positions(positions)))
    # ... but both of them put elsewhere are, whoever stands where the other stood
    assert first_frames(_moved(two, 100, two.frames, np.array([0.7, 0.0, 0.3]))).tolist() == [100]


def test_where_nothing_tells_which_side_bears_the_wrong_labels_each_is_repaired_on_its_own_and_it_is_said():
    clean = markers(truth("walk", fps=60.0))
    positions = np.concatenate([clean.positions, clean.positions + np.array([0.7, 0.0, 0.3])], axis=1)
    positions[150:] = np.roll(positions[150:], len(clean.names), axis=1)
    names = tuple(f"{who}:{name}" for who in ("Ann", "Bob") for name in clean.names)
    two = replace(clean, names=names, positions=positions)
    assert first_frames(two).tolist() == [150]
    (said,) = repaired_in_takes(two, lambda take: repair_without_model(take, "linear")).warnings
    assert "before frame 150 many markers change places: labels may be swapped on one side of it" in said
