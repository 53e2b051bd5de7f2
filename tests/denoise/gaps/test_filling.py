"""Laws of the marker gap filler that learns from the recording and a library."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.transform import Rotation

from motionmend.denoise.gaps.hedge import filled_both_ways, hedged
from motionmend.denoise.gaps.limbs import _most_known
from motionmend.denoise.gaps.markers import HOPELESS, fill_gaps
from motionmend.denoise.library.likeness import likeness
from motionmend.denoise.library.markers import (
    MarkerLibrary,
    examples_like,
    learn_marker_library,
    library_of,
    merged,
)
from motionmend.denoise.rivals.filtered import Filtered
from motionmend.denoise.rivals.interpolate import spline
from motionmend.denoise.rivals.marker_gaps import fill_pca
from motionmend.errors import MismatchError
from motionmend.io import read

UP = np.array([0.0, 0.0, 1.0])
FPS = 60.0


def _body(seed, frames=400, size=1.0):
    """Three segments of four markers each: a trunk that walks, an arm and a hand that swing; metres."""
    rng = np.random.default_rng(seed)
    shapes = np.random.default_rng(5).uniform(-0.1, 0.1, (3, 4, 3)) * size
    time = np.arange(frames) / FPS
    swing = 0.8 * np.sin(2 * np.pi * time * rng.uniform(0.6, 0.9) + rng.uniform(0, 6))
    bend = 0.6 * swing + 0.3 * np.sin(2 * np.pi * time * rng.uniform(1.0, 1.4))
    trunk = Rotation.from_euler("zx", np.stack([0.4 * np.sin(time), 0.1 * swing], axis=1))
    arm = trunk * Rotation.from_euler("y", swing[:, None])
    hand = arm * Rotation.from_euler("y", bend[:, None])
    place = np.stack([time, 0.05 * np.sin(time), 1.0 + 0.02 * np.cos(3 * time)], axis=1)
    shoulder = place + trunk.apply([0.0, 0.2 * size, 0.3 * size])
    wrist = shoulder + arm.apply([0.0, 0.0, -0.5 * size])
    parts = [
        np.stack([where + turn.apply(marker) for marker in shape], axis=1)
        for where, turn, shape in zip((place, shoulder, wrist), (trunk, arm, hand), shapes, strict=True)
    ]
    return np.concatenate(parts, axis=1) + rng.normal(0, 0.0003, (frames, 12, 3))


def _gappy(rng, positions, gaps=6, longest=60):
    gappy = positions.copy()
    for _ in range(gaps):
        length = rng.integers(5, longest)
        start = rng.integers(0, len(positions) - length)
        gappy[start : start + length, rng.integers(positions.shape[1])] = np.nan
    return gappy


def _rms(values, truth, where):
    return float(np.sqrt(np.square(values - truth).sum(axis=2)[where].mean()))


@pytest.mark.slow
@given(seed=st.integers(0, 10**6), taught=st.booleans())
@settings(max_examples=6, deadline=None)
def test_measured_samples_stay_bit_for_bit(seed, taught):
    gappy = _gappy(np.random.default_rng(seed), _body(seed, 150))
    gappy[10:20, 3, 1] = np.nan  # one coordinate alone
    library = library_of(_body(seed + 1), FPS, UP) if taught else None
    found = fill_gaps(gappy, FPS, library=library)
    measured = np.isfinite(gappy)
    np.testing.assert_array_equal(found.values[measured], gappy[measured])
    whole = measured.all(axis=2)
    np.testing.assert_array_equal(found.filled, np.isfinite(found.values).all(axis=2) & ~whole)
    assert found.filled.sum() >= 0.9 * (~whole).sum()
    assert (found.std[found.filled] > 0).all()
    assert (found.std[found.filled] <= HOPELESS).all()


@pytest.mark.slow
@pytest.mark.parametrize("taught", [False, True])
def test_filling_beats_what_it_replaces_and_says_how_well(taught, rng):
    library = learn_marker_library([(_body(s), FPS) for s in (11, 12)], UP) if taught else None
    ours, rival, errors = [], [], []
    for seed in range(3):
        truth = _body(seed)
        gappy = _gappy(rng, truth, gaps=8)
        gone = ~np.isfinite(gappy).all(axis=2)
        found = fill_gaps(gappy, FPS, library=library)
        curve = spline(gappy.reshape(len(gappy), -1), FPS).values.reshape(gappy.shape)
        both = gone & np.isfinite(curve).all(axis=2)
        ours.append(_rms(found.values, truth, both))
        rival.append(min(_rms(curve, truth, both), _rms(fill_pca(gappy).values, truth, both)))
        errors.append(np.abs(found.values - truth)[gone] / found.std[gone][:, None])
    assert np.mean(ours) < 0.5 * np.mean(rival)
    inside = np.concatenate(errors)
    assert 0.5 < (inside < 1).mean() < 0.95
    assert (inside < 1.96).mean() > 0.8


@pytest.mark.slow
def test_filling_commutes_with_moving_and_turning_the_recording(rng):
    gappy = _gappy(rng, _body(3, 200))
    library = library_of(_body(4), FPS, UP)
    turned, away = Rotation.from_euler("z", 1.1), np.array([3.0, -2.0, 0.0])
    there = turned.apply(gappy.reshape(-1, 3)).reshape(gappy.shape) + away
    here = fill_gaps(gappy, FPS, library=library)
    other = fill_gaps(there, FPS, library=library)
    back = turned.apply(here.values.reshape(-1, 3).copy()).reshape(gappy.shape) + away
    np.testing.assert_allclose(other.values, back, atol=1e-4)


def test_gaps_that_are_asked_for_come_out_as_with_the_others_which_stay_open(rng):
    gappy = _body(3, 150)
    gaps = {2: slice(20, 50), 5: slice(60, 90), 9: slice(100, 130)}
    for marker, gap in gaps.items():
        gappy[gap, marker] = np.nan
    asked = np.zeros(gappy.shape[:2], dtype=bool)
    asked[44, 2] = asked[70, 7] = True  # amid one gap, and where nothing is missing
    some, whole = fill_gaps(gappy, FPS, asked=asked), fill_gaps(gappy, FPS)
    assert np.array_equal(np.argwhere(some.filled.any(axis=0)).ravel(), [2])
    assert some.filled[gaps[2], 2].all()
    assert np.abs(some.values - whole.values)[gaps[2], 2].max() < 1e-9
    assert np.isnan(some.values[gaps[5], 5]).all()
    assert np.isnan(some.values[gaps[9], 9]).all()


@pytest.mark.parametrize("fill", [fill_gaps, lambda positions, fps: fill_pca(positions)])
def test_filling_does_not_depend_on_the_order_of_the_markers(rng, fill):
    positions = _gappy(rng, _body(2, frames=160), gaps=12)
    positions[rng.random(positions.shape[:2]) < 0.02] += 0.3
    expected = fill(positions, FPS)
    order = rng.permutation(positions.shape[1])
    found = fill(positions[:, order], FPS)
    np.testing.assert_allclose(found.values, expected.values[:, order], atol=1e-5)
    np.testing.assert_allclose(found.std, expected.std[:, order], rtol=1e-3)


def test_noise_and_a_stray_sample_do_not_explode(rng):
    truth = _body(6)
    gappy = _gappy(rng, truth + rng.normal(0, 0.01, truth.shape), gaps=10)
    gappy[50, 2] += 0.3
    gone = ~np.isfinite(gappy).all(axis=2)
    found = fill_gaps(gappy, FPS)
    assert _rms(found.values, truth, gone & found.filled) < 0.03
    assert np.linalg.norm(found.values - truth, axis=2)[gone & found.filled].max() < 0.6  # twice the stray sample


def test_a_marker_that_is_in_the_file_twice_is_filled_from_its_double():
    truth = np.cumsum(np.full((400, 1, 3), 1 / 64), axis=0) + np.eye(5, 3)[None]
    spoilt = truth.copy()
    spoilt[100:140, 3] = spoilt[120:160, 1] = np.nan
    with np.errstate(all="raise"):
        filled = fill_gaps(spoilt, FPS)
    np.testing.assert_allclose(filled.values, truth, atol=1e-6)


LIMB_PEOPLE = range(20, 24)  # four clips of some seconds know the limb as well as more of them


@pytest.fixture(scope="module")
def limb():
    """Somebody without an arm's hand throughout: a library, how he is, how he is seen and how he is filled."""
    library = learn_marker_library([(_body(s, 200), FPS) for s in LIMB_PEOPLE], UP)
    truth = _body(40, 150)
    cut = truth.copy()
    cut[:, 8:] = np.nan
    return library, truth, cut, fill_gaps(cut, FPS, library=library)


@pytest.mark.slow
def test_a_limb_missing_throughout_comes_from_the_library(limb):
    library, truth, cut, found = limb
    assert found.filled[:, 8:].all()
    middle = library.postures[:, 8:].mean(axis=(0, 1)) - library.postures[:, :8].mean(axis=(0, 1))
    standing = cut[:, :8].mean(axis=1, keepdims=True) + middle
    gone = ~np.isfinite(cut).all(axis=2)
    still = _rms(np.broadcast_to(standing, truth[:, 8:].shape), truth[:, 8:], gone[:, 8:])
    assert _rms(found.values, truth, gone) < 0.5 * still
    away = np.abs(found.values - truth)[gone] / found.std[gone][:, None]
    assert (away < 1.96).mean() > 0.7
    assert not fill_gaps(cut, FPS).filled.any()


@pytest.mark.slow
def test_a_library_with_gaps_of_its_own_knows_a_limb_too(limb, rng):
    """Hardly an example shows all markers at every moment: those lost most are left out, not the examples."""
    clips = []
    for seed in LIMB_PEOPLE:
        clip = _body(seed, 200)
        for start in range(0, len(clip), 40):
            clip[start : start + 20, rng.choice([1, 5])] = np.nan
        clips.append((clip, FPS))
    _, truth, cut, whole = limb
    gone = ~np.isfinite(cut).all(axis=2)
    found = fill_gaps(cut, FPS, library=learn_marker_library(clips, UP))
    assert found.filled[:, 8:].all()
    assert _rms(found.values, truth, gone) < 1.2 * _rms(whole.values, truth, gone)


@pytest.mark.parametrize(
    ("examples", "always", "known_together", "kept"),
    [(1000, 1, 50, 10), (1000, 2, 50, 10), (1000, 4, 50, 4), (1000, 4, 600, 10), (100, 3, 39, 3)],
)
def test_markers_that_a_library_lost_are_left_out_but_not_so_many_that_nothing_can_be_learned(
    examples, always, known_together, kept
):
    """Of ten markers a few are in every example, the others together in some."""
    known = np.ones((examples, 2, 10), dtype=bool)
    known[known_together:, 1, always:] = False
    assert len(_most_known(known, np.arange(10))) == kept


def test_a_limb_seen_for_a_moment_goes_with_the_body():
    """Of twelve frames together too little is known to say how steady two markers are; the body walks on by 5 m."""
    truth = _body(3)
    gappy = truth.copy()
    gappy[12:, 4:] = np.nan
    found = fill_gaps(gappy, FPS)
    away = np.linalg.norm(found.values - truth, axis=2)[12:, 4:8]
    assert np.nanmedian(away) < 0.15
    assert np.nanmax(away) < 0.5


def test_a_marker_missing_for_most_of_a_recording_is_filled():
    """Hidden elsewhere, as long a gap leaves nothing to learn from: that tells nothing of how wrong deviations are."""
    truth = _body(6)
    gappy = truth.copy()
    gappy[180:, [5, 9]] = np.nan
    found = fill_gaps(gappy, FPS)
    off = (found.values - truth)[180:, [5, 9]]
    assert np.abs(off).max() < 0.02
    assert (np.abs(off) < 1.96 * found.std[180:, [5, 9], None]).mean() > 0.8


@pytest.mark.slow
def test_who_is_hidden_whole_is_not_led_by_somebody_else():
    first, second = _body(4), np.array([0.0, 2.0, 0.0]) + _body(9)[::-1]  # they walk past each other
    gappy = np.concatenate([first, second], axis=1)
    gappy[150:180, 12:] = np.nan
    alone = second.copy()
    alone[150:180] = np.nan
    both, own = fill_gaps(gappy, FPS), fill_gaps(alone, FPS)
    off = [
        _rms(values, second, np.s_[150:180])
        for values in (
            both.values[:, 12:],
            own.values,
            spline(alone.reshape(len(alone), -1), FPS).values.reshape(alone.shape),
        )
    ]
    assert off[0] < 1.2 * off[1]
    assert off[0] < 1.5 * off[2]


@pytest.mark.slow
def test_a_gap_at_an_end_and_frames_without_any_marker(rng):
    truth = _body(7)
    cut = truth.copy()
    cut[:30, 5] = np.nan
    cut[-30:, 6] = np.nan
    cut[100:104] = np.nan
    found = fill_gaps(cut, FPS)
    assert found.filled[:30, 5].all()
    assert found.filled[-30:, 6].all()
    assert found.filled[100:104].all()
    assert _rms(found.values, truth, found.filled) < 0.01


@pytest.mark.parametrize("markers", [1, 2, 3])
def test_few_markers_are_filled_in_time(markers):
    truth = _body(8)[:, :markers]
    cut = truth.copy()
    cut[100:106, 0] = np.nan
    found = fill_gaps(cut, FPS)
    assert found.filled[100:106, 0].all()
    assert _rms(found.values, truth, found.filled) < 0.01


def test_a_marker_seen_once_and_a_whole_recording():
    truth = _body(9, 120)
    whole = fill_gaps(truth, FPS)
    assert whole.values.tobytes() == truth.tobytes()
    rare = truth.copy()
    rare[1:, 4] = np.nan
    library = learn_marker_library([(_body(s), FPS) for s in (10, 11, 12, 13)], UP)
    found = fill_gaps(rare, FPS, library=library)
    assert found.filled[:, 4].mean() > 0.9
    assert _rms(found.values, truth, found.filled) < 0.03
    np.testing.assert_array_equal(fill_gaps(np.full((30, 4, 3), np.nan), FPS).filled, False)


@pytest.mark.parametrize("seen", [1, 3, 9])
def test_a_marker_seen_for_a_moment_alone_is_not_made_up(seen):
    """Held still beside a body that walks on it was metres off, and stated as sure to a millimetre."""
    truth = _body(9, 120)
    rare = truth.copy()
    rare[:50, 4] = rare[50 + seen :, 4] = np.nan
    found = fill_gaps(rare, FPS)
    assert not found.filled.any()
    assert np.isnan(found.values[:50, 4]).all()
    rare[40:50, 4] = truth[40:50, 4]  # as soon as some more are seen
    assert fill_gaps(rare, FPS).filled[:, 4].any()


@pytest.mark.parametrize("shape", [(0, 4, 3), (30, 0, 3), (1, 4, 3)])
def test_nothing_in_nothing_out(shape):
    assert fill_gaps(np.zeros(shape), FPS).values.shape == shape


def test_refuses_channels_and_other_markers():
    with pytest.raises(MismatchError, match=r"\(frames, markers, 3\)"):
        fill_gaps(np.zeros((10, 6)), FPS)
    with pytest.raises(MismatchError, match="12 markers"):
        fill_gaps(np.zeros((10, 4, 3)), FPS, library=library_of(_body(1), FPS, UP))


def test_a_library_is_bounded_mergeable_and_comes_back_from_arrays():
    clips = [_body(s, frames) for s, frames in ((1, 400), (2, 90), (3, 1000))]
    one, two, three = (library_of(c, FPS, UP, 150) for c in clips)
    left, right = merged(merged(one, two), three), merged(one, merged(two, three))
    np.testing.assert_array_equal(left.windows, right.windows)
    np.testing.assert_array_equal(left.time, right.time)
    together = learn_marker_library([(c, FPS) for c in clips], UP, 150)
    np.testing.assert_array_equal(together.windows, left.windows)
    assert len(left.windows) == 150
    # every clip keeps its say
    assert min(np.bincount(left.clip)[np.unique(left.clip)]) > 20
    back = MarkerLibrary.from_arrays(left.to_arrays())
    np.testing.assert_array_equal(back.windows, left.windows)
    np.testing.assert_array_equal(back.clip, left.clip)
    assert back.most == 150
    postures, clip = examples_like(left, clips[1], 60)
    assert len(postures) == len(clip) == 60
    assert clip.min() >= 1
    with pytest.raises(MismatchError, match="came none"):
        learn_marker_library([], UP)


@pytest.mark.slow
def test_gaps_in_real_clips_with_and_without_a_library(data):
    folder = data / "mocap" / "c3d"
    names = sorted(n.rpartition(":")[2] for n in read(folder / "cmu_02_01.c3d").names)

    def clip(file):
        recording = read(folder / file)
        bare = [n.rpartition(":")[2] for n in recording.names]
        return recording.positions[:, [bare.index(n) for n in names]], recording.fps, recording.up

    truth, fps, up = clip("cmu_02_05.c3d")
    truth = truth[:1000]
    rng = np.random.default_rng(2)
    gappy = truth.copy()
    for marker in rng.permutation(41)[:12]:
        for _ in range(2):
            start = rng.integers(0, 760)
            gappy[start : start + rng.integers(12, 240), marker] = np.nan
    gone = ~np.isfinite(gappy).all(axis=2) & np.isfinite(truth).all(axis=2)
    rival = _rms(fill_pca(gappy).values, truth, gone)
    library = learn_marker_library([clip(f)[:2] for f in ("cmu_02_01.c3d", "cmu_05_13.c3d")], up)
    alone, taught = fill_gaps(gappy, fps), fill_gaps(gappy, fps, library=library)
    assert alone.filled[gone].all()
    assert _rms(alone.values, truth, gone) < rival
    assert _rms(taught.values, truth, gone) < 0.5 * rival
    away = np.abs(taught.values - truth)[gone] / taught.std[gone][:, None]
    assert 0.55 < (away < 1).mean() < 0.9
    assert (away < 1.96).mean() > 0.85


@pytest.mark.slow
@pytest.mark.parametrize("seed", [6, 7, 8])
def test_hundredths_of_a_millimetre_do_not_decide_what_fills_a_gap(seed):
    # a smoothed recording has hardly any noise left to keep a relation from following every wobble of its markers
    rng = np.random.default_rng(seed)
    gappy = _gappy(rng, gaussian_filter1d(_body(seed, 300), 4.0, axis=0))
    shaken = gappy + rng.normal(0, 2e-5, gappy.shape)
    gone = ~np.isfinite(gappy).all(axis=2)
    one, other = fill_gaps(gappy, FPS), fill_gaps(shaken, FPS)
    assert one.filled[gone].all()
    assert _rms(one.values, other.values, gone) < 3e-4


def test_hedging_prefers_whoever_is_sure_and_never_promises_more_than_both():
    truth = _body(15, 300)
    gappy = truth.copy()
    gappy[100:140, 2] = np.nan
    gone = ~np.isfinite(gappy).all(axis=2)
    rival = fill_pca(gappy)
    wrong = np.where(gone[..., None], truth + 0.2, truth)
    unsure, sure = np.where(gone, 0.2, np.nan), np.where(gone, 0.001, np.nan)
    places, std = hedged(wrong, unsure, gappy)
    assert _rms(places, truth, gone) < 2 * _rms(rival.values, truth, gone)
    assert (std[gone] <= np.minimum(unsure, rival.std)[gone] + 1e-12).all()
    kept, same = hedged(wrong, sure, gappy)
    np.testing.assert_array_equal(kept, wrong)
    np.testing.assert_array_equal(same, sure)


def test_both_ways_fill_what_the_library_fills_between_both_and_nearer_to_the_surer():
    truth = _body(16, 300)
    gappy = truth.copy()
    gappy[100:140, 2] = np.nan
    gappy[:, 3] = np.nan  # what only the library knows
    gone = ~np.isfinite(gappy).all(axis=2)
    alone = fill_gaps(gappy, FPS)
    for sure in (0.001, 0.01, 0.2):
        std = np.where(gone, sure, 0.001)
        taught = Filtered(np.where(gone[..., None], truth + 0.1, truth), std, gone)
        found = filled_both_ways(taught, alone)
        share = (found.values - taught.values)[100:140, 2] / (alone.values - taught.values)[100:140, 2]
        assert ((share >= -1e-9) & (share <= 1 + 1e-9)).all()
        surer = alone.std[100:140, 2] < sure
        assert (share[surer] > 0.5).all()
        assert (share[~surer] < 0.5 + 1e-9).all()
        low, high = (pick(taught.std, alone.std)[100:140, 2] for pick in (np.minimum, np.maximum))
        assert ((found.std[100:140, 2] >= low - 1e-12) & (found.std[100:140, 2] <= high + 1e-12)).all()
        np.testing.assert_array_equal(found.values[:, 3], taught.values[:, 3])
        np.testing.assert_array_equal(found.values[~gone], truth[~gone])


def test_likeness_knows_the_same_body_in_other_postures_and_a_stranger():
    clips = [_body(1), _body(2), _body(3, size=1.2)]
    known, stranger = likeness(_body(4), clips), likeness(_body(4, size=1.1), clips)
    assert known.unlike < 0.02 < stranger.unlike
    assert not known.stranger
    assert stranger.stranger
    assert known.persons == 2
    assert known.person[0] == known.person[1] != known.person[2]
    np.testing.assert_allclose(stranger.larger, [1.1, 1.1, 1.1 / 1.2], rtol=0.01)
    np.testing.assert_allclose(known.larger[:2], 1.0, rtol=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("size", [0.85, 1.3])
def test_a_stranger_s_limb_is_as_large_as_he_is(size):
    people = ((1, 1.0), (2, 1.0), (3, 1.15), (4, 1.15))
    library = learn_marker_library([(_body(seed, 300, large), FPS) for seed, large in people], UP)
    truth = _body(8, 200, size)
    gappy = truth.copy()
    gappy[:, 9:11] = np.nan
    gone = ~np.isfinite(gappy).all(axis=2)
    found = fill_gaps(gappy, FPS, library=library)
    assert found.filled[gone].all()
    assert _rms(found.values, truth, gone) < 0.006  # by people of the library's own size 8 and 11 mm
