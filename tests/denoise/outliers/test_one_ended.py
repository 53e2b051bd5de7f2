"""What leaps once and never back is right on either side; what comes back may be off."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import motionmend as mm
from motionmend.bodies.skeleton import ROTATION
from motionmend.denoise.outliers.one_ended import begins_or_ends

SEEDS = st.integers(0, 10**6)
FRAMES = 200


def _noisy(rng, channels=8):
    t = np.arange(FRAMES)[:, None] / 120.0
    swings = 10.0 * np.sin(2.0 * np.pi * t * rng.uniform(0.3, 1.0, channels) + rng.uniform(0.0, 6.0, channels))
    return swings + rng.standard_normal((FRAMES, channels))


@given(SEEDS, st.integers(3, FRAMES - 4), st.floats(15.0, 90.0), st.booleans())
@settings(max_examples=40)
def test_what_leaps_once_is_kept_whichever_side_was_rejected(seed, frame, by, before):
    measured = _noisy(np.random.default_rng(seed))
    measured[frame:, 2:4] += by
    outlier = np.zeros(measured.shape, dtype=bool)
    side = slice(0, frame) if before else slice(frame, FRAMES)
    outlier[side, 2:4] = True
    kept, leap = begins_or_ends(measured, outlier)
    assert np.array_equal(kept, outlier)
    assert set(np.flatnonzero(leap[:, 2])) == set(range(*side.indices(FRAMES))) & set(range(frame - 3, frame + 3))


@given(SEEDS, st.integers(3, 20))
@settings(max_examples=40)
def test_where_such_stretches_do_come_back_one_at_an_end_is_one_of_them(seed, length):
    rng = np.random.default_rng(seed)
    measured, outlier = _noisy(rng), np.zeros((FRAMES, 8), dtype=bool)
    for channel, start in enumerate([FRAMES - length, *rng.integers(10, FRAMES - 40, 7)]):
        stop = min(start + length + channel, FRAMES)
        measured[start:stop, channel] += 40.0
        outlier[start:stop, channel] = True
    assert not begins_or_ends(measured, outlier)[0].any()


@given(SEEDS, st.integers(3, 12))
@settings(max_examples=40)
def test_outliers_that_lie_anywhere_are_not_kept(seed, length):
    rng = np.random.default_rng(seed)
    measured, outlier = _noisy(rng), np.zeros((FRAMES, 8), dtype=bool)
    outlier[-length:, 1] = True
    measured[-length:, 1] += np.resize([50.0, -40.0, 20.0, -60.0], length) + rng.standard_normal(length)
    assert not begins_or_ends(measured, outlier)[0].any()


@given(SEEDS)
@settings(max_examples=20)
def test_two_outliers_on_end_are_none_where_one_sample_in_twenty_is(seed):
    rng = np.random.default_rng(seed)
    measured, outlier = _noisy(rng, 60), rng.random((FRAMES, 60)) < 0.05
    outlier[:3] = outlier[-3:] = False  # none but these two are off at an end
    measured[outlier] += rng.uniform(-80.0, 80.0, int(outlier.sum()))
    outlier[-2:, 5], measured[-2:, 5] = True, measured[-3, 5] + 60.0
    assert not begins_or_ends(measured, outlier)[0][:, 5].any()


def test_two_channels_of_sixty_that_are_off_at_an_end_together_are_chance_where_one_sample_in_ten_is():
    kept = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        measured, outlier = _noisy(rng, 60), rng.random((FRAMES, 60)) < 0.1
        outlier[-3:] = False
        outlier[-2:, [5, 40]] = True
        measured[outlier] += rng.uniform(-80.0, 80.0, int(outlier.sum()))
        measured[-2:, [5, 40]] = measured[-3, [5, 40]] + 60.0
        kept.append(begins_or_ends(measured, outlier)[0].any())
    assert not any(kept)


def test_zeros_to_the_last_digit_and_lone_samples_are_not_kept():
    measured, outlier = 60.0 + _noisy(np.random.default_rng(1)), np.zeros((FRAMES, 8), dtype=bool)
    measured[:9, 0], outlier[:9, 0] = 0.0, True
    measured[-1, 1], outlier[-1, 1] = 0.0, True
    assert not begins_or_ends(measured, outlier)[0].any()


@pytest.mark.slow
def test_an_arm_that_rests_before_it_is_driven_costs_nothing_else():
    truth = mm.samples.clip("walk", seconds=3, seed=3)
    arm = [name.startswith(("rhumerus", "rradius", "rwrist")) for name in truth.skeleton.dof_names]
    q = truth.q.copy()
    q[:50, arm] = q[50, arm] + np.radians(80.0)  # 80 degrees from where it is then
    noise = np.where(truth.skeleton.dof_kind == ROTATION, np.radians(1.0), 0.0)
    spoiled = truth.with_q(q + noise * np.random.default_rng(0).standard_normal(q.shape))
    off = np.degrees(mm.repair_without_model(spoiled, "adaptive").recording.q - q)[:, arm]
    assert np.sqrt(np.mean(np.square(off))) < 1.0


@given(SEEDS, st.integers(3, 12), st.booleans())
@settings(max_examples=20)
def test_what_leaps_where_the_recording_goes_on_may_still_come_back(seed, length, last):
    measured, outlier = _noisy(np.random.default_rng(seed)), np.zeros((FRAMES, 8), dtype=bool)
    end = slice(FRAMES - length, None) if last else slice(0, length)
    measured[end, 2] += 60.0
    outlier[end, 2] = True
    assert begins_or_ends(measured, outlier)[0].any()
    assert not begins_or_ends(measured, outlier, (last, not last))[0].any()


@pytest.mark.slow
def test_a_slip_under_way_is_no_truth_to_who_repairs_what_is_still_being_made():
    clips = [mm.samples.clip("walk", seconds=5, seed=seed) for seed in range(3)]
    model, truth = mm.Denoiser(fps=30).fit(clips), mm.samples.clip("walk", seconds=3, seed=9)
    column = truth.skeleton.dof_names.index("ltibia.rx")
    q = truth.q + np.radians(1.0) * np.random.default_rng(0).standard_normal(truth.q.shape)
    q[-12:, column] += np.radians(60.0)
    off = {
        whole: np.degrees(model.repair(truth.with_q(q), whole=whole).recording.q - truth.q)[-12:, column]
        for whole in (True, False)
    }
    assert np.abs(off[True]).min() > 40.0  # what never comes back is left
    assert np.abs(off[False]).max() < 20.0
