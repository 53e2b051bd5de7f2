"""Laws of joint-angle limits."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend import corrupt, repair_without_model
from motionmend.bodies.motion import Origin
from motionmend.denoise.adaptive.limits import BROKEN, brought_inside, seen_between, within_body_limits, within_seen
from motionmend.denoise.adaptive.recording import mend_alone
from motionmend.denoise.bases.repair import ChannelRepair
from motionmend.io import read
from performers import truth

SEEDS = st.integers(0, 10**6)


def _case(seed):
    """Angles of which those that were measured keep to limits that the others know nothing of."""
    rng = np.random.default_rng(seed)
    limits = np.sort(rng.uniform(-100, 100, (4, 2)), axis=1) + np.array([-1.0, 1.0])
    limits[3] = -np.inf, np.inf
    origin = rng.choice([Origin.MEASURED, Origin.REPAIRED, Origin.FILLED, Origin.LEFT_OPEN], (60, 4)).astype(np.uint8)
    origin[0] = Origin.MEASURED
    within = rng.uniform(np.maximum(limits[:, 0], -300), np.minimum(limits[:, 1], 300), (60, 4))
    values = np.where(origin == Origin.MEASURED, within, rng.uniform(-175, 175, (60, 4)))
    values[origin == Origin.LEFT_OPEN] = np.nan
    return values, np.where(np.isnan(values), np.nan, rng.uniform(0.1, 3, (60, 4))), origin, limits


@dataclass(frozen=True, eq=False)
class Held:
    """Channels held within limits: (T, C) values and which of them moved, and (C,) how far each limit is broken."""

    values: np.ndarray
    moved: np.ndarray
    broken: np.ndarray


def _held(values, std, origin, limits, made_up):
    """All channels, each by `brought_inside`."""
    held, moved, broken = values.copy(), np.zeros(values.shape, dtype=bool), np.zeros(values.shape[1])
    for c in range(values.shape[1]):
        inside = brought_inside(values[:, c], std[:, c], origin[:, c], limits[c], made_up[:, c])
        held[inside.frames, c], moved[inside.frames, c], broken[c] = inside.values, True, inside.broken
    return Held(held, moved, broken)


def _made_up(origin):
    return (origin == Origin.REPAIRED) | (origin == Origin.FILLED)


@given(SEEDS, st.integers(-1, 1))
@settings(max_examples=40, deadline=None)
def test_made_up_samples_end_inside_and_nothing_else_moves(seed, turns):
    values, std, origin, limits = _case(seed)
    values = values + 360.0 * turns
    limited = np.isfinite(limits).all(axis=1)
    found = _held(values, std, origin, limits, _made_up(origin))
    assert (found.broken == 0).all()
    np.testing.assert_array_equal(found.values[~found.moved], values[~found.moved])
    assert not (found.moved & ~_made_up(origin)).any()
    assert not found.moved[:, ~limited].any()
    low, high = limits[limited].T
    held = found.values[:, limited]
    held = held - 360.0 * np.round((held - 0.5 * (low + high)) / 360.0)
    known = np.isfinite(held) & _made_up(origin)[:, limited]
    assert (np.maximum(low - held, held - high)[known] < 1e-9).all()
    again = _held(found.values, std, origin, limits, _made_up(origin))
    np.testing.assert_allclose(again.values, found.values, atol=1e-9)


@given(SEEDS)
@settings(max_examples=40, deadline=None)
def test_a_truth_within_the_limits_is_never_further_off(seed):
    values, std, origin, limits = _case(seed)
    found = _held(values, std, origin, limits, _made_up(origin))
    rng = np.random.default_rng(seed + 1)
    real = rng.uniform(np.maximum(limits[:, 0], -300), np.minimum(limits[:, 1], 300), values.shape)

    def away(angles):
        return np.abs((angles - real + 180.0) % 360.0 - 180.0)

    nearer = np.minimum(away(values), 360.0 - np.abs(np.diff(limits, axis=1)).T)  # round the other way may be nearer
    moved = found.moved & (away(values) < 90.0)
    assert (away(found.values) <= np.maximum(away(values), nearer) + 1e-9)[moved].all()


@given(SEEDS, st.floats(0.05, 0.9))
@settings(max_examples=40, deadline=None)
def test_limits_that_the_measured_samples_break_are_left_alone(seed, share):
    values, std, origin, limits = _case(seed)
    origin[:, 0] = np.where(np.arange(60) % 2, Origin.MEASURED, Origin.FILLED)
    values[:, 0], std[:, 0] = limits[0, 1] + 30.0, 1.0
    calm = np.random.default_rng(seed).random(60) > share
    values[calm & (origin[:, 0] == Origin.MEASURED), 0] = limits[0].mean()
    beyond = (values[1::2, 0] > limits[0, 1]).mean()
    found = _held(values, std, origin, limits, _made_up(origin))
    if beyond > BROKEN:
        assert found.broken[0] == pytest.approx(beyond)
        assert not found.moved[:, 0].any()
    else:
        assert found.moved[::2, 0].all()


def test_what_was_seen_once_widens_the_limits():
    values = np.full((200, 1), 10.0)
    values[100], values[150] = 37.0, 60.0
    origin = np.full((200, 1), Origin.MEASURED, dtype=np.uint8)
    origin[150] = Origin.FILLED
    found = _held(values, np.ones((200, 1)), origin, np.array([[-30.0, 30.0]]), origin == Origin.FILLED)
    assert found.values[150, 0] == pytest.approx(35.0)  # so far it was surely seen
    assert found.values[100, 0] == 37.0


def _elbow_limited(motion, row, low, high):
    limits = motion.skeleton.limits.copy()
    limits[row] = np.radians([low, high])
    return replace(motion, skeleton=replace(motion.skeleton, limits=limits))


@pytest.mark.slow
def test_a_repair_keeps_within_the_skeleton_and_says_so():
    """Outliers and gaps where the joint stops: the repair alone would overshoot."""
    clean = truth("walk", seconds=4.0)
    row = 40  # an upper arm that moves by ten degrees
    low, high = np.degrees([clean.q[:, row].min(), clean.q[:, row].max()])
    clean = _elbow_limited(clean, row, low, high)
    spoilt = corrupt(clean, noise=np.radians(1.0), outliers=0.3, seed=1).recording
    outcome = mend_alone(spoilt)
    made_up = _made_up(outcome.origin[:, row])
    angle = np.degrees(outcome.recording.q[made_up, row])
    measured = np.degrees(outcome.recording.q[~made_up, row])
    assert made_up.sum() > 10
    assert (angle <= max(high, measured.max()) + 1e-6).all()
    assert (angle >= min(low, measured.min()) - 1e-6).all()
    free = mend_alone(_elbow_limited(spoilt, row, -np.inf, np.inf))
    same = np.setdiff1d(np.arange(clean.q.shape[1]), [row])
    np.testing.assert_array_equal(outcome.recording.q[:, same], free.recording.q[:, same])
    np.testing.assert_array_equal(outcome.std, free.std)


@pytest.mark.slow
def test_the_sentences_name_the_channels():
    clean = truth("walk", seconds=4.0)
    outcome = repair_without_model(corrupt(clean, noise=np.radians(1.0), seed=1).recording, "adaptive")
    angle = np.degrees(outcome.recording.q[:, 25])
    name = clean.skeleton.dof_names[25]
    wrong = replace(outcome, recording=_elbow_limited(outcome.recording, 25, angle.min() - 9, angle.mean() - 9))
    said = within_body_limits(wrong).warnings[-1]
    assert "left alone" in said
    assert name in said
    q, origin = outcome.recording.q.copy(), outcome.origin.copy()
    q[50, 25] += np.radians(80)
    origin[50, 25] = Origin.FILLED
    held = replace(outcome, origin=origin, recording=outcome.recording.with_q(q))
    limited = replace(held, recording=_elbow_limited(held.recording, 25, angle.min() - 1, angle.max() + 1))
    found = within_body_limits(limited)
    assert "1 repaired or filled samples" in found.warnings[-1]
    assert name in found.warnings[-1]
    assert np.degrees(found.recording.q[50, 25]) == pytest.approx(angle.max() + 1)


@pytest.mark.slow
def test_what_clean_clips_do_is_no_sample_out_of_bounds():
    """A filled angle beyond a limit of the file stays where clips of a library go there, and not further."""
    clean = truth("walk", seconds=4.0)
    outcome = repair_without_model(corrupt(clean, noise=np.radians(1.0), seed=1).recording, "adaptive")
    angle = np.degrees(outcome.recording.q[:, 25])
    q, origin = outcome.recording.q.copy(), outcome.origin.copy()
    q[50, 25], origin[50, 25] = np.radians(angle.max() + 30.0), Origin.FILLED
    limited = _elbow_limited(outcome.recording.with_q(q), 25, angle.min() - 1, angle.max() + 1)
    held = replace(outcome, origin=origin, recording=limited)
    seen = np.full((q.shape[1], 2), np.nan)
    for high, wanted in ((20.0, 20.0), (40.0, 30.0), (-50.0, 1.0)):
        seen[25] = angle.min(), angle.max() + high
        found = np.degrees(within_body_limits(held, seen).recording.q[50, 25])
        assert found == pytest.approx(angle.max() + wanted)


@pytest.mark.slow
def test_a_skeleton_without_limits_changes_nothing():
    clean = truth("walk", seconds=3.0)
    free = replace(
        clean, skeleton=replace(clean.skeleton, limits=np.full_like(clean.skeleton.limits, np.inf) * [-1, 1])
    )
    outcome = repair_without_model(corrupt(free, noise=np.radians(3.0), outliers=0.1, gaps=0.1).recording, "adaptive")
    again = within_body_limits(outcome)
    np.testing.assert_array_equal(again.recording.q, outcome.recording.q)
    assert again.warnings == outcome.warnings


@given(SEEDS)
@settings(max_examples=25, deadline=None)
def test_filled_angles_stay_near_what_the_clips_of_a_library_do(seed):
    values, std, origin, _ = _case(seed)
    origin[:] = np.where(origin == Origin.MEASURED, Origin.FILLED, origin)
    found = ChannelRepair(3.0 * values, std, np.ones(values.shape), origin, 1, np.empty(0), True)
    exemplars = np.random.default_rng(seed).uniform(-40, 40, (9, 5, 4)).astype(np.float32)
    angular = np.array([True, True, True, False])
    held = within_seen(found, seen_between(exemplars, angular))
    filled = (origin == Origin.FILLED) & angular
    np.testing.assert_array_equal(held.values[~filled], found.values[~filled])
    low, high = exemplars.min(axis=(0, 1)), exemplars.max(axis=(0, 1))
    turned = (held.values + 180.0) % 360.0 - 180.0
    assert (turned <= high + 0.26 * (high - low) + 5.0)[filled].all()
    assert (turned >= low - 0.26 * (high - low) - 5.0)[filled].all()
    assert within_seen(found, seen_between(exemplars[:0], angular)) is found


@pytest.mark.slow
def test_real_limits_that_a_dancer_breaks_are_named(data):
    motion = read(data / "mocap" / "amc" / "05" / "05_13.amc")
    outcome = repair_without_model(replace(motion, q=motion.q[:480:4], fps=30.0), "adaptive")
    assert any("limits that the recording itself breaks" in said for said in outcome.warnings)
