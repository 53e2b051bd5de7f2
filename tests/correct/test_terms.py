"""The parts of correction one by one: standard form, energy, reliability, filters, and failures on purpose."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sensed_people import NAMES, recording, sensed, truth

import naive_correct as naive
from motionmend.bodies.joint_sets import KINECT20
from motionmend.bodies.postures import INFERRED
from motionmend.correct.anatomy import anatomy, following
from motionmend.correct.classic import FILTERS
from motionmend.correct.energy import Terms, Weights, adapted, energy, sampled, solved, solved_together
from motionmend.correct.normalise import Placement, turns, upright
from motionmend.correct.reliability import (
    FAILING_SECONDS,
    HONEST_SECONDS,
    behaviour,
    chain_backward,
    kinematics,
    tracking,
)
from motionmend.correct.settling import settled_frame, settled_recording, unborn
from motionmend.errors import UsageError
from motionmend.evaluate.sensor_failures import fail


def terms(seed: int, steady: bool = True) -> Terms:
    rng = np.random.default_rng(seed)
    observed, offset, ahead = rng.normal(size=(3, 6, 3))
    steadily = observed + 0.05 * ahead if steady else None
    return Terms(observed, 0.05 * offset, steadily, rng.uniform(size=6), rng.uniform(0.2, 5.0, 6))


@given(st.integers(0, 1000), st.booleans())
@settings(max_examples=20)
def test_the_energy_is_least_where_it_is_solved(seed: int, steady: bool) -> None:
    one, weights = terms(seed, steady), Weights()
    best = solved(one, weights)
    least = energy(best, one, weights)
    rng = np.random.default_rng(seed + 1)
    for size in (1e-3, 1e-2, 0.1):
        assert energy(best + size * rng.normal(size=best.shape), one, weights) > least


def test_the_papers_descent_comes_to_the_same_place() -> None:
    one, weights = terms(3), Weights()
    found = sampled(one, weights, np.zeros((6, 3)), np.random.default_rng(0), rounds=80)
    least, start = energy(solved(one, weights), one, weights), energy(np.zeros((6, 3)), one, weights)
    assert energy(found, one, weights) - least < 0.05 * (start - least)


def test_an_offset_that_is_doubted_is_drawn_the_further_to_the_reliable_sensor() -> None:
    one = Terms(np.zeros((3, 3)), np.full((3, 3), 0.1), None, np.ones(3), np.array([0.01, 1.0, 100.0]))
    known, usual, doubted = solved(one, Weights())[:, 0]
    assert known > 0.095
    assert usual == pytest.approx(0.1 * 0.6 / 0.8)
    assert doubted < 0.01


def test_weights_follow_what_is_known() -> None:
    doubt = np.array([1e-6, 1e6, 1.0])
    spatial, temporal, sensor = adapted(doubt, Weights(0.6, 0.2, 0.2))
    np.testing.assert_allclose(spatial, 0.6)
    np.testing.assert_allclose(temporal, 0.2)
    np.testing.assert_allclose(sensor, [0.0, 0.2, 0.1], atol=1e-6)
    one = Terms(np.zeros((3, 3)), np.full((3, 3), 0.1), None, np.ones(3), doubt)
    found = solved(one, (spatial, temporal, sensor))
    np.testing.assert_allclose(found[0], 0.1, atol=1e-5)  # known: the offset is believed and nothing else
    assert (found[1] < 1e-6).all()  # reliable and not known: back to the sensor


def walked(frames: int, seed: int) -> tuple[Terms, Placement]:
    """A recording of so many frames, its placements turning and moving about."""
    rng = np.random.default_rng(seed)
    observed, offset = rng.normal(size=(2, frames, 4, 3))
    angle = rng.normal(size=frames)
    place = Placement(
        turns(np.stack([np.cos(angle), np.sin(angle)], axis=1)), rng.normal(size=(frames, 3)), np.full(frames, 1.2)
    )
    return Terms(observed, 0.1 * offset, None, rng.uniform(size=(frames, 4)), rng.uniform(0.2, 5, (frames, 4))), place


def all_energies(offsets: np.ndarray, terms: Terms, weights: Weights, tied: np.ndarray, place: Placement) -> float:
    """Eq. 22 of every frame, added up; the last two postures are those the offsets themselves lead to."""
    postures, total = place.outward(terms.observed + offsets), 0.0
    for t in range(len(offsets)):
        here = Placement(place.turn[t : t + 1], place.origin[t : t + 1], place.scale[t : t + 1])
        steady = here.inward((2.0 * postures[t - 1] - postures[t - 2])[None])[0] if tied[t] else None
        one = Terms(terms.observed[t], terms.offset[t], steady, terms.reliability[t], terms.doubt[t])
        total += energy(offsets[t], one, weights)
    return total


@given(st.integers(1, 9), st.integers(0, 1000))
@settings(max_examples=30)
def test_the_energies_of_all_frames_are_least_where_they_are_solved_together(frames: int, seed: int) -> None:
    rng, weights = np.random.default_rng(seed + 1), Weights()
    terms, place = walked(frames, seed)
    tied = (rng.uniform(size=frames) < 0.8) & (np.arange(frames) > 1)
    best = solved_together(terms, weights, tied, place)
    least = all_energies(best, terms, weights, tied, place)
    for size in (1e-3, 1e-2, 0.1):
        assert all_energies(best + size * rng.normal(size=best.shape), terms, weights, tied, place) > least


def test_frames_that_nothing_ties_are_solved_as_by_themselves() -> None:
    terms, place = walked(5, 0)
    together = solved_together(terms, Weights(), np.zeros(5, dtype=np.bool_), place)
    for t in range(5):
        alone = Terms(terms.observed[t], terms.offset[t], None, terms.reliability[t], terms.doubt[t])
        np.testing.assert_allclose(together[t], solved(alone, Weights()), atol=1e-12)


@given(st.floats(-3.0, 3.0), st.floats(0.5, 1.5), st.integers(0, 100))
@settings(max_examples=20)
def test_standard_form_and_back(angle: float, size: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    place = Placement(turns(np.array([[np.cos(angle), np.sin(angle)]])), rng.normal(size=(1, 3)), np.array([size]))
    positions = rng.normal(size=(1, 5, 3))
    np.testing.assert_allclose(place.outward(place.inward(positions)), positions, atol=1e-12)
    np.testing.assert_allclose(place.turn[0] @ [np.cos(angle), 0.0, np.sin(angle)], [1.0, 0.0, 0.0], atol=1e-12)


@pytest.mark.parametrize("up", [0, 1, 2])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_up_is_found_whatever_axis_it_is(up: int, sign: float) -> None:
    standing = truth("walk", 1)
    turn = np.roll(np.eye(3), up - 1, axis=0) if sign > 0 else np.roll(np.eye(3), up - 1, axis=0) @ np.diag([1, -1, -1])
    found = upright(standing @ turn.T, anatomy(NAMES))
    assert np.linalg.det(found) == pytest.approx(1.0)
    assert ((found @ turn)[1, 1]) == pytest.approx(1.0)


def test_joints_without_a_value_are_the_mean_of_their_neighbours() -> None:
    known = np.array([name not in ("HandLeft", "Spine") for name in NAMES])
    rows = following(NAMES, known)
    np.testing.assert_allclose(rows.sum(axis=1), 1.0, atol=1e-6)
    assert rows[NAMES.index("HandLeft"), NAMES.index("WristLeft")] == pytest.approx(1.0, abs=1e-6)
    assert rows[NAMES.index("Spine"), NAMES.index("HipCenter")] == pytest.approx(0.5, abs=1e-6)


def test_the_papers_measures_of_reliability() -> None:
    body = anatomy(KINECT20.names)
    still = np.zeros((20, 3))
    ahead = still + np.array([0.1, 0.0, 0.0])
    assert behaviour(2 * ahead, ahead, still) == pytest.approx(np.ones(20))
    assert behaviour(still, ahead, still) == pytest.approx(np.zeros(20))
    usual = np.full(len(body.bones), 0.3)
    assert kinematics(usual, usual, body) == pytest.approx(np.ones(20))
    longer = usual.copy()
    longer[body.bones[:, 1] == NAMES.index("WristLeft")] = 0.6
    off = kinematics(longer, usual, body)
    assert set(np.flatnonzero(off < 0.99)) == {NAMES.index("WristLeft"), NAMES.index("ElbowLeft")}
    told = tracking(np.array([2, 1, 0, 2], dtype=np.uint8), np.array([True, True, True, False]))
    np.testing.assert_array_equal(told, [1.0, 0.5, 0.0, 0.0])


def test_hindsight_of_a_chain_is_that_of_all_paths() -> None:
    evidence = np.array([0.3, 2.0, -1.0, 1.5, -2.0])[:, None]
    step = 1 / 30
    forecasts, filtered, failing = [], [], np.array([0.05])
    for one in evidence:
        forecast = naive.chain_ahead(failing, step, np.array([HONEST_SECONDS, FAILING_SECONDS]))
        failing = naive.chance_after(one, forecast)
        forecasts.append(forecast)
        filtered.append(failing)
    got = chain_backward(np.stack(forecasts), np.stack(filtered), np.full(5, step))
    into, out = 1 - np.exp(-step / 8.0), 1 - np.exp(-step / 1.0)
    move = np.array([[1 - into, into], [out, 1 - out]])
    weight, marginal = 0.0, np.zeros(5)
    for path in np.ndindex(2, 2, 2, 2, 2):
        chance = (np.array([0.95, 0.05]) @ move)[path[0]]
        for t in range(1, 5):
            chance *= move[path[t - 1], path[t]]
        chance *= np.exp(sum(evidence[t, 0] for t in range(5) if path[t]))
        weight += chance
        marginal += chance * np.array(path)
    np.testing.assert_allclose(got[:, 0], marginal / weight, rtol=1e-6)


@pytest.mark.parametrize("method", list(FILTERS))
def test_filters_lessen_noise_and_leave_holes_open(method: str) -> None:
    true = truth("reach", 2)
    noisy = true + 0.01 * np.random.default_rng(0).normal(size=true.shape)
    noisy[30:34, 5] = np.nan
    times = np.arange(len(true)) / 30.0
    got = FILTERS[method](noisy, times)
    np.testing.assert_array_equal(np.isfinite(got), np.isfinite(noisy))
    jerk = [np.nanmean(np.abs(np.diff(one, 3, axis=0))) for one in (got, noisy)]
    assert jerk[0] < 0.6 * jerk[1]


def test_failures_are_where_they_are_said_to_be() -> None:
    raw = recording(sensed(truth("walk", 3, 6.0), 3))
    failed = fail(raw, share=0.5, seed=4)
    moved = np.linalg.norm(failed.postures.positions - raw.positions, axis=2)
    assert (moved[~failed.affected] == 0).all()
    assert (moved[failed.affected] > 0).all()
    assert failed.postures.state is not None
    np.testing.assert_array_equal(failed.postures.state == INFERRED, failed.affected & ~failed.swapped)
    again = fail(raw, share=0.5, seed=4)
    np.testing.assert_array_equal(again.postures.positions, failed.postures.positions)
    assert fail(raw, states=False).postures.state is None
    assert not fail(raw, share=0.0).affected.any()
    with pytest.raises(UsageError, match="shares"):
        fail(raw, share=1.5)
    with pytest.raises(UsageError, match="no arm or leg"):
        fail(raw.__class__(("a", "b"), raw.positions[:, :2], raw.times))


def test_a_foot_that_a_sensor_throws_about_leaves_the_planted_ankle_where_it_is() -> None:
    times = np.arange(60) / 30.0
    chain = np.array([[0.0, 0.9, 0.0], [0.0, 0.5, 0.05], [0.0, 0.1, 0.0], [0.0, 0.0, 0.14]])
    positions = np.tile(chain, (60, 1, 1))
    positions[30::4, 3, 2] -= 0.13  # every fourth frame of the second half
    bones = np.array([[0, 1], [1, 2], [2, 3]])
    settled = settled_recording(positions, times, np.ones((60, 4)), bones)
    assert np.linalg.norm(np.diff(settled[:, :3], axis=0), axis=2).max() < 0.006
    body, frames = unborn(4, 3), []
    for t, row in enumerate(positions):
        prior = np.linalg.norm(np.diff(chain, axis=0), axis=1)
        body, frame = settled_frame(body, row, float(times[t]), np.ones(4), bones, prior)
        frames.append(frame)
    moves = np.linalg.norm(np.diff(np.stack(frames)[:, :3], axis=0), axis=2)
    assert moves.max() < 0.02
    lengths = np.linalg.norm(np.diff(settled, axis=1), axis=2)
    assert np.ptp(lengths, axis=0).max() < 1e-9


def test_frames_without_anybody_leave_the_others_as_steady_as_they_are_without_them() -> None:
    rng, times = np.random.default_rng(0), np.arange(120) / 30.0
    chain = np.array([[0.0, 0, 0], [0, -0.4, 0], [0, -0.8, 0]])
    bones = np.array([[0, 1], [1, 2]])
    seen = chain + 0.01 * np.sin(2.0 * times)[:, None, None] + 0.004 * rng.standard_normal((120, 3, 3))
    for gone in (slice(0, 40), slice(60, 61), slice(60, 100), slice(None, None, 9)):
        there = np.ones(120, dtype=np.bool_)
        there[gone] = False
        gappy = np.where(there[:, None, None], seen, np.nan)
        whole = settled_recording(gappy, times, np.ones((120, 3)), bones)
        np.testing.assert_array_equal(np.isfinite(whole).all(axis=(1, 2)), there)
        alone = settled_recording(seen[there], times[there], np.ones((there.sum(), 3)), bones)
        np.testing.assert_allclose(whole[there], alone, atol=1e-3)
        body, frames = unborn(3, 2), []
        for row, time in zip(gappy, times, strict=True):
            body, frame = settled_frame(body, row, float(time), np.ones(3), bones, np.array([0.4, 0.4]))
            frames.append(frame)
        body, others = unborn(3, 2), []
        for row, time in zip(seen[there], times[there], strict=True):
            body, frame = settled_frame(body, row, float(time), np.ones(3), bones, np.array([0.4, 0.4]))
            others.append(frame)
        np.testing.assert_array_equal(np.stack(frames)[there], np.stack(others))


def test_who_rests_does_not_tremble_with_what_others_do() -> None:
    """A joint at rest follows its bones more slowly than one that moves, at any rate."""
    for fps in (15.0, 30.0):
        times = np.arange(int(6 * fps)) / fps
        ends = np.zeros((len(times), 2, 3))
        ends[:, 1, 1] = 0.4 + 0.05 * np.sin(2.0 * np.pi * 1.5 * times)  # a bone that a sensor stretches
        bones, trust = np.array([[0, 1]]), np.ones((len(times), 2))
        settled = settled_recording(ends, times, trust, bones)
        moving = settled_recording(ends + 0.5 * times[:, None, None], times, trust, bones)
        moving = moving - 0.5 * times[:, None, None]
        middle = slice(int(fps), -int(fps))
        assert np.ptp(settled[middle, 0, 1]) < 0.5 * np.ptp(moving[middle, 0, 1])


def test_a_quick_move_keeps_its_peak_where_the_joint_is_believed_and_a_resting_one_is_calmed() -> None:
    times = np.arange(90) / 30.0
    rng = np.random.default_rng(0)
    ends = np.zeros((90, 2, 3))
    ends[:, 1, 1] = 0.6 / (1.0 + np.exp(-(times - 1.5) / 0.02))  # a strike: 6 m/s, over within three frames
    seen = ends + 0.004 * rng.standard_normal(ends.shape)
    unbound = np.zeros((0, 2), dtype=np.int64)

    def speeds(values: np.ndarray) -> np.ndarray:
        return np.linalg.norm(np.diff(values, axis=0), axis=2).T * 30.0

    believed = settled_recording(seen, times, np.ones((90, 2)), unbound)
    doubted = settled_recording(seen, times, np.zeros((90, 2)), unbound)
    assert speeds(believed)[1].max() > 0.97 * speeds(seen)[1].max()
    assert speeds(doubted)[1].max() < 0.97 * speeds(seen)[1].max()
    for j, still in ((0, slice(None)), (1, slice(0, 35))):
        assert np.square(speeds(believed)[j, still]).mean() < 0.7 * np.square(speeds(seen)[j, still]).mean()
