"""Capture that froze: several markers or joints repeat themselves to the last digit, and then leap on."""

from functools import cache

import numpy as np
import pytest

from motionmend.bodies.motion import Markers, Motion, Origin
from motionmend.denoise import Denoiser, repair_without_model
from motionmend.denoise.faults.frozen import frozen, held_ends
from motionmend.evaluate import compare
from motionmend.io import read
from motionmend.samples import markers
from performers import FPS, clips, joints_model, truth


def _values(recording):
    return recording.q if isinstance(recording, Motion) else recording.positions


def _with(recording, values):
    return recording.with_q(values) if isinstance(recording, Motion) else recording.with_positions(values)


def _moves(recording):
    """(C,) True for the channels that ever move."""
    values = _values(recording)
    return (values != values[:1]).reshape(len(values), values.shape[1], -1).any(axis=(0, 2))


def _freezing(recording, first, last, channels=slice(None)):
    """The recording with the frame before these held in some channels, and (T, C) where that is."""
    values, still = _values(recording).copy(), np.zeros((recording.frames, len(recording.channels)), dtype=bool)
    columns = np.flatnonzero(_moves(recording))[channels]
    values[first : last + 1, columns] = values[first - 1, columns]
    still[first : last + 1, columns] = True
    return _with(recording, values), still


@pytest.fixture(params=["motion", "markers"])
def clean(request):
    motion = truth("walk")
    return motion if request.param == "motion" else markers(motion)


def _thinned(motion):
    """Every third marker: to be filled from each other they need not be more, and effort grows with them squared."""
    every = markers(motion)
    return Markers(every.names[::3], every.positions[:, ::3], every.fps, up=every.up)


@pytest.fixture(params=["motion", "markers"])
def light(request):
    """As `clean`, for tests that repair it whole."""
    motion = truth("walk")
    return motion if request.param == "motion" else _thinned(motion)


@cache
def _thinned_model():
    return Denoiser(window=20, fps=FPS).fit([_thinned(motion) for motion in clips()])


@pytest.mark.parametrize("length", [1, 3, 15, 30])
def test_what_freezes_is_found_and_nothing_else(clean, length):
    spoilt, still = _freezing(clean, 60, 59 + length)
    np.testing.assert_array_equal(frozen(spoilt), still)


def test_lost_frames_are_found_in_a_little_noise_and_frames_that_were_put_in_are_left(clean):
    """None of the steps leaps by itself there, beside what noise changes from one to the next."""
    values = _values(clean)
    noise = np.random.default_rng(0).normal(scale=np.radians(0.3), size=values.shape)  # rad, or m of markers: less
    noisy = values + np.where(values == values[:1], 0.0, noise if isinstance(clean, Motion) else 0.2 * noise)
    lost, twice = np.arange(25, clean.frames - 5, 20), np.arange(clean.frames)
    twice[lost] -= 1
    found = frozen(_with(clean, noisy[twice]))[:, _moves(clean)]
    assert found[lost].mean() > 0.7  # before, of angles: 0.33
    assert not np.delete(found, lost, axis=0).any()
    put_in = np.sort(np.append(np.arange(clean.frames), lost))
    assert frozen(_with(clean, noisy[put_in])).any(axis=1).sum() <= 1


def test_some_markers_that_freeze_together_are_found():
    spoilt, still = _freezing(markers(truth("walk")), 60, 75, slice(3, 9))
    np.testing.assert_array_equal(frozen(spoilt), still)


def test_every_tenth_frame_shown_twice_is_found(clean):
    values, again = _values(clean).copy(), np.arange(10, clean.frames - 2, 10)
    values[again] = values[again - 1]
    found = frozen(_with(clean, values))
    assert found[again][:, _moves(clean)].mean() > 0.9
    assert not np.delete(found, again, axis=0).any()


def test_what_is_frozen_elsewhere_is_found_from_the_first(clean):
    """A stale frame shown again for a while: the motion leaps away from where it was, and back."""
    values = _values(clean).copy()
    values[70:75] = values[61]
    found = frozen(_with(clean, values))
    assert found[70:75, _moves(clean)].mean() > 0.9
    assert not np.delete(found, np.arange(70, 75), axis=0).any()


@pytest.mark.parametrize("times", [2, 3])
def test_frames_shown_several_times_throughout_are_left(clean, times):
    assert not frozen(_with(clean, _values(clean).repeat(times, axis=0))).any()


def test_every_second_frame_shown_twice_is_left(clean):
    assert not frozen(_with(clean, _values(clean)[(np.arange(1.5 * clean.frames - 2) / 1.5).astype(int)])).any()


def test_poses_that_are_held_by_whoever_draws_them_are_left(clean):
    """Held poses with an even way from one to the next; and the same with nothing between them."""
    keys = _values(clean)[::15]
    time = np.concatenate([np.r_[n + np.arange(9) / 9, np.full(11, n + 1.0)] for n in range(len(keys) - 1)])
    before, share = time.astype(int), (time % 1.0).reshape(-1, *[1] * (keys.ndim - 1))
    even = keys[before] * (1 - share) + keys[np.minimum(before + 1, len(keys) - 1)] * share
    assert not frozen(_with(clean, even)).any()
    assert not frozen(_with(clean, keys.repeat(15, axis=0))).any()


def test_who_stands_still_and_goes_on_is_left(clean):
    values = np.concatenate([_values(clean)[:60], _values(clean)[59:60].repeat(20, axis=0), _values(clean)[60:]])
    assert not frozen(_with(clean, values)).any()


def test_a_pose_at_either_end_is_left(clean):
    values = _values(clean)
    posed = np.concatenate([values[90:91].repeat(20, axis=0), values, values[10:11].repeat(20, axis=0)])
    assert not frozen(_with(clean, posed)).any()


@pytest.mark.parametrize("step", [1e-4, 1e-3, 1e-2])
def test_what_was_rounded_is_left(clean, step):
    assert not frozen(_with(clean, step * np.round(_values(clean) / step))).any()


@pytest.mark.parametrize("frames", [0, 1, 2, 3, 5])
def test_few_frames(clean, frames):
    assert not frozen(_with(clean, np.repeat(_values(clean)[:1], frames, axis=0))).any()


def test_missing_samples_and_one_marker_alone():
    spoilt, still = _freezing(markers(truth("walk")), 60, 75)
    positions = spoilt.positions.copy()
    positions[:, 3] = np.nan
    positions[70:, 5] = np.nan
    still[:, [3, 5]] = False
    np.testing.assert_array_equal(frozen(spoilt.with_positions(positions)), still)
    alone, _ = _freezing(Markers(("M",), spoilt.positions[:, :1], 30.0), 20, 30)
    assert not frozen(alone).any()


@pytest.mark.slow
@pytest.mark.parametrize("library", [True, False])
@pytest.mark.parametrize("part", ["all", "some"])
def test_frozen_samples_are_repaired_as_if_they_were_missing_and_said(light, library, part):
    moves = isinstance(light, Motion)
    spoilt, still = _freezing(
        light, 60, 68, {"all": slice(None), "some": slice(20, 32) if moves else slice(7, 11)}[part]
    )

    def repaired(recording):
        if not library:
            return repair_without_model(recording)
        return (joints_model() if isinstance(recording, Motion) else _thinned_model()).repair(recording)

    found = repaired(spoilt)
    gap = still if moves else still[..., None]
    gaps = repaired(_with(light, np.where(gap, np.nan, _values(light))))
    np.testing.assert_allclose(_values(found.recording), _values(gaps.recording), atol=1e-9)
    np.testing.assert_array_equal(found.std, gaps.std)
    assert (found.origin[still] == Origin.REPAIRED).all()
    assert (found.origin[~still] == Origin.MEASURED).mean() > 0.99
    (said,) = [warning for warning in found.warnings if "frozen" in warning]
    assert "frames 60 to 68" in said
    if moves:
        assert compare(light, found.recording).rms_deg < 0.5 * compare(light, spoilt).rms_deg


def test_a_joint_that_rested_as_it_froze_is_frozen_as_well():
    """A knee at its limit, 0, when capture freezes."""
    clean = truth("walk")
    values, knee = clean.q.copy(), clean.channels.index("ltibia.rx")
    values[50:60, knee] = 0.0
    spoilt, still = _freezing(clean.with_q(values), 60, 75)
    np.testing.assert_array_equal(frozen(spoilt), still)


@pytest.mark.slow
@pytest.mark.parametrize("library", [True, False])
def test_what_nothing_supports_stays_as_it_was_recorded_and_is_said(library):
    """Two seconds in which all joints are frozen: not a row of NaN in a recording that had none."""
    clean = truth("walk", seconds=5.0)
    spoilt, still = _freezing(clean, 45, 104)
    outcome = joints_model().repair(spoilt) if library else repair_without_model(spoilt)
    assert np.isfinite(outcome.recording.q).all()
    kept = still & (outcome.origin == Origin.MEASURED)
    assert not (outcome.origin == Origin.LEFT_OPEN).any()
    np.testing.assert_array_equal(outcome.recording.q[kept], spoilt.q[kept])
    off = np.abs(outcome.recording.q - clean.q)[kept]
    if kept.any():
        assert (off <= 1.96 * outcome.std[kept]).mean() > 0.8
        assert any("were left as recorded" in warning for warning in outcome.warnings)
    assert not any("missing samples were left open" in warning for warning in outcome.warnings)


@pytest.mark.slow
def test_clean_recordings_hold_one_arm_that_froze(data):
    """CMU's 16_01: an arm stands still for 18 frames of a jump and then leaps by 6 to 18 degrees."""
    found = {}
    for file in sorted((data / "mocap").rglob("*")):
        if file.suffix in (".amc", ".bvh", ".c3d"):
            still = frozen(read(file))
            if still.any():
                found[file.stem] = (np.flatnonzero(still.any(axis=1)), int(still.sum()))
    assert set(found) == {"16_01"}
    frames, samples = found["16_01"]
    assert (frames[0], frames[-1], samples) == (185, 202, 90)


@cache
def _said_of(kind):
    """What is said of `light` as it is."""
    motion = truth("walk")
    return repair_without_model(motion if kind is Motion else _thinned(motion)).warnings


@pytest.mark.slow
@pytest.mark.parametrize("length", [40, 60])
def test_frames_at_the_ends_that_repeat_each_other_are_left_and_said(light, length):
    values = _values(light).copy()
    values[:length], values[-length - 5 :] = values[length], values[-length - 6]
    held = _with(light, values)
    assert held_ends(light) == (0, 0)
    assert held_ends(held) == (length + 1, length + 6)
    assert held_ends(_with(light, np.broadcast_to(values[:1], values.shape).copy())) == (0, 0)
    repaired = repair_without_model(held)
    assert any(f"the first {length + 1} frames repeat each other" in said for said in repaired.warnings)
    assert any(f"the last {length + 6} frames repeat each other" in said for said in repaired.warnings)
    assert not any("repeat each other" in said for said in _said_of(type(light)))


def test_markers_that_are_not_seen_hold_nothing():
    values = markers(truth("walk")).positions.copy()
    values[:60] = values[60]
    values[:60, 3] = np.nan
    assert held_ends(Markers(markers(truth("walk")).names, values, 120.0)) == (61, 0)
    values[20:40] = np.nan
    assert held_ends(Markers(markers(truth("walk")).names, values, 120.0)) == (0, 0)
