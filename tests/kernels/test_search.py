"""The search for outliers against the enumeration of all histories."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import naive
from motionmend.kernels.search import RECENT, likeliest_history

SEEDS = st.integers(0, 10**6)
ORDER = (
    *("observed", "hint", "hint_var", "pull", "step_var", "noise_var", "outlier_rate", "outlier_follow"),
    *("outlier_density", "outlier_held", "factors", "log_modes", "width"),
    *("start", "start_var", "speed_var", "vouched", "at_pole"),
)


def _case(rng, frames, modes=2, coordinates=1, missing=0.0, **given):
    """A walk of bursts with outliers, and everything the search asks."""
    shape = frames, coordinates
    factors = np.array([1.0, 30.0, 800.0])[:modes]
    step_var = np.exp(rng.normal(-2, 0.5, shape))
    lively = rng.choice(factors, (frames, 1), p=np.array([0.7, 0.2, 0.1])[:modes] / sum([0.7, 0.2, 0.1][:modes]))
    pull = rng.normal(0, 0.2, shape)
    truth = np.cumsum(np.cumsum(pull + rng.normal(size=shape) * np.sqrt(step_var * lively), axis=0), axis=0)
    observed = truth + rng.normal(0, 1.0, shape)
    observed += (rng.random((frames, 1)) < 0.3) * rng.choice([-1, 1], shape) * rng.uniform(5, 30, shape)
    observed[rng.random(frames) < missing] = np.nan
    stays = np.full((modes, modes), 0.3 / max(modes - 1, 1)) + (0.7 - 0.3 / max(modes - 1, 1)) * np.eye(modes)
    case = {
        "observed": observed,
        "hint": truth + rng.normal(0, 3.0, shape),
        "hint_var": np.where(rng.random(shape) < 0.5, 9.0, np.inf),
        "pull": pull,
        "step_var": step_var,
        "noise_var": rng.uniform(0.5, 2.0, shape),
        "outlier_rate": 0.2,
        "outlier_follow": rng.uniform(0.2, 0.8),
        "outlier_density": 80.0**-coordinates,
        "outlier_held": rng.choice([0.01, 0.5, 0.9]),
        "factors": factors,
        "log_modes": np.log(stays if modes > 1 else np.ones((1, 1))),
        "width": 200,
        "start": np.zeros(coordinates),
        "start_var": np.full(coordinates, 25.0),
        "speed_var": np.full(coordinates, 4.0),
        "vouched": rng.random(frames) < 0.15,
        "at_pole": rng.random(frames) < 0.15,
    }
    return {**case, **given}


def _found(case):
    outlier, mode = likeliest_history(*(case[name] for name in ORDER))
    return tuple(int(k) for k in mode), tuple(bool(o) for o in outlier)


@pytest.mark.slow
@pytest.mark.parametrize("modes", [1, 2])
@pytest.mark.parametrize("coordinates", [1, 3])
def test_of_few_samples_the_likeliest_history_of_all_is_found(modes, coordinates):
    """But for 1 in 100 of four frames: that an outlier stayed where the one before was is no memory of its own."""
    behind = []
    for seed in range(50):
        for frames in range(1, RECENT + 1):
            case = _case(np.random.default_rng(seed), frames, modes, coordinates)
            score = {(mode, rejects): score for score, mode, rejects in sorted(naive.all_histories(case))}
            behind.append(max(score.values()) - score[_found(case)])
    assert np.mean(np.array(behind) < 1e-6) > 0.98
    assert max(behind) < 5.0


@pytest.mark.slow
def test_frames_without_a_sample_hardly_spend_the_memory():
    """The likeliest of all histories of so few samples is found whatever lies between, but for 2 in 100 of 300 cases:
    how lively those frames were is forgotten earlier."""
    found = []
    for seed in range(300):
        rng = np.random.default_rng(seed)
        case = _case(rng, 9)
        case["observed"][rng.permutation(9)[: 9 - RECENT]] = np.nan
        _, *wanted = max(naive.all_histories(case))
        found.append(_found(case) == tuple(wanted))
    assert np.mean(found) > 0.975


@pytest.mark.slow
@given(SEEDS, st.sampled_from([1, 2, 3]), st.sampled_from([1, 3]), st.integers(1, 14), st.integers(1, 20))
@settings(max_examples=60)
def test_the_beam_is_that_of_its_plain_twin(seed, modes, coordinates, frames, width):
    case = _case(np.random.default_rng(seed), frames, modes, coordinates, missing=0.15, width=width)
    _, *wanted = naive.beam_of_histories(case, width, RECENT)
    assert _found(case) == tuple(wanted)


@pytest.mark.slow
def test_longer_series_lose_little_by_what_the_beam_forgets():
    """Of 30 walks of 6 frames nearly all histories found are the likeliest of all, and none is much less likely."""
    behind = []
    for seed in range(30):
        case = _case(np.random.default_rng(seed), 6)
        score = {(modes, rejects): score for score, modes, rejects in sorted(naive.all_histories(case))}
        behind.append(max(score.values()) - score[_found(case)])
    assert np.mean(np.array(behind) < 1e-6) > 0.9
    assert max(behind) < 5.0


def _walk(rng, frames=200):
    speed = np.cumsum(rng.normal(0, 0.1, (frames, 1)), axis=0)
    return np.cumsum(speed, axis=0)


def _plain(observed, **given):
    """What is asked of a recording without a library: nothing is hinted, vouched or pulled."""
    shape = observed.shape
    nowhere = np.zeros(len(observed), dtype=bool)
    case = _case(np.random.default_rng(0), len(observed), 3, shape[1], vouched=nowhere, at_pole=nowhere)
    begin = np.array([np.median(row[np.isfinite(row)][:5]) if np.isfinite(row).any() else 0.0 for row in observed.T])
    case |= {"observed": observed, "hint": np.zeros(shape), "hint_var": np.full(shape, np.inf), "pull": np.zeros(shape)}
    case |= {
        "step_var": np.full(shape, 0.01),
        "noise_var": np.ones(shape),
        "start": begin,
        "outlier_rate": 0.1,
        "outlier_follow": 0.1,
    }
    stays = 0.5 * np.eye(3) + 0.5 * np.array([0.96, 0.035, 0.005])
    return {**case, "width": 14, "start_var": np.full(shape[1], 400.0), "log_modes": np.log(stays), **given}


@pytest.mark.parametrize("share", [0.0, 0.05, 0.15, 0.3])
def test_outliers_of_a_smooth_walk_are_found(rng, share):
    truth = _walk(rng, 600)
    hit = rng.random(truth.shape) < share
    off = rng.choice([-1, 1], truth.shape) * rng.uniform(12, 50, truth.shape)
    observed = truth + rng.normal(size=truth.shape) + hit * off
    _, rejects = _found(_plain(observed, outlier_rate=max(share, 0.01), outlier_follow=max(share, 0.01)))
    wrong = np.array(rejects) != hit[:, 0]
    assert wrong.mean() < 0.02


def test_a_vouched_sample_is_never_rejected(rng):
    observed = _walk(rng, 80) + rng.normal(size=(80, 1))
    observed[[20, 50]] += 40.0
    alone = np.array(_found(_plain(observed))[1])
    vouched = np.zeros(80, dtype=bool)
    vouched[50] = True
    told = np.array(_found(_plain(observed, vouched=vouched))[1])
    assert alone[[20, 50]].all()
    assert told[20]
    assert not told[50]


def test_bursts_are_found_by_those_who_expect_them(rng):
    """Ten wild samples on end look like lively motion, unless it is known that an outlier seldom comes alone."""
    truth = _walk(rng, 400)
    hit = (np.arange(400) % 50 >= 40)[:, None]
    observed = truth + rng.normal(size=truth.shape)
    observed += hit * rng.choice([-1, 1], truth.shape) * rng.uniform(15, 55, truth.shape)
    step = np.full(truth.shape, 0.3)  # of which a jump may have a thousand times
    lone, together = (
        np.array(_found(_plain(observed, step_var=step, outlier_rate=0.2, outlier_follow=follow))[1]) == hit[:, 0]
        for follow in (0.2, 0.9)
    )
    assert together.mean() > 0.98
    assert (~together).sum() < 0.3 * (~lone).sum()


def test_slips_are_found_by_those_who_expect_them(rng):
    """Eight samples on end off by the same amount: within them nothing tells of outliers."""
    truth = _walk(rng, 400)
    hit = (np.arange(400) % 50 >= 42)[:, None]
    observed = truth + rng.normal(size=truth.shape) + 30.0 * hit
    step = np.full(truth.shape, 0.3)
    given = {"step_var": step, "outlier_rate": 0.1, "outlier_follow": 0.5}
    anywhere, held = (
        np.array(_found(_plain(observed, **given, outlier_held=held))[1]) == hit[:, 0] for held in (0.01, 0.8)
    )
    assert held.mean() > 0.98
    assert (~held).sum() < 0.3 * (~anywhere).sum()


def test_a_burst_at_the_beginning_is_one_from_its_first_sample(rng):
    """Nothing before it says so: only that outliers seldom come alone."""
    observed = _walk(rng, 80) + rng.normal(size=(80, 1))
    observed[:10] += rng.choice([-1, 1], (10, 1)) * rng.uniform(15, 55, (10, 1))
    found = np.array(_found(_plain(observed, outlier_rate=0.05, outlier_follow=0.9))[1])
    assert np.flatnonzero(found).tolist() == list(range(10))


def test_a_jump_that_stays_is_motion_and_one_that_returns_is_an_outlier(rng):
    observed = _walk(rng, 80) + rng.normal(size=(80, 1))
    stays, returns = observed.copy(), observed.copy()
    stays[40:] += 40.0
    returns[40] += 40.0
    assert not np.array(_found(_plain(stays))[1])[44:].any()
    assert np.flatnonzero(_found(_plain(returns))[1]).tolist() == [40]


def test_coordinates_together_are_rejected_together_when_one_is_far_off(rng):
    """A marker that jumps along one axis is no marker any more."""
    observed = np.hstack([_walk(rng, 80) for _ in range(3)]) + rng.normal(size=(80, 3))
    observed[33, 1] += 40.0
    assert np.flatnonzero(_found(_plain(observed))[1]).tolist() == [33]


def test_a_sample_without_one_of_its_coordinates_counts_as_missing(rng):
    observed = np.hstack([_walk(rng, 60) for _ in range(3)]) + rng.normal(size=(60, 3))
    part, whole = observed.copy(), observed.copy()
    part[20:24, 1] = np.nan
    whole[20:24] = np.nan
    assert _found(_plain(part)) == _found(_plain(whole))


def test_what_stands_at_infinite_variance_is_no_hint(rng):
    observed = _walk(rng, 60) + rng.normal(size=(60, 1))
    hint = rng.normal(0, 1e3, (60, 1))
    assert _found(_plain(observed)) == _found(_plain(observed, hint=hint))


def test_hints_tell_which_of_two_stories_is_true(rng):
    """Half of the samples 20 away from the other half: only a hint can say which half lies."""
    truth = np.zeros((60, 1))
    observed = truth + rng.normal(0, 1, truth.shape) + 20.0 * (np.arange(60) % 2)[:, None]
    sure = np.full(truth.shape, 4.0)
    for level, lying in ((0.0, 1), (20.0, 0)):
        _, rejects = _found(_plain(observed, hint=truth + level, hint_var=sure, start=np.array([level])))
        assert (np.array(rejects) == (np.arange(60) % 2 == lying)).all()


@pytest.mark.parametrize("frames", [0, 1, 2])
def test_no_frame_and_few_frames_and_none_seen(frames):
    outlier, mode = likeliest_history(*(_plain(np.full((frames, 1), np.nan))[name] for name in ORDER))
    assert outlier.shape == mode.shape == (frames,)
    assert not outlier.any()
