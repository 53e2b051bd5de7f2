"""Earlier frames as later ones have them: what is set right, what stays, and how long it is waited for."""

from dataclasses import replace
from functools import cache
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.arrays import frozen
from motionmend.bodies import anatomy
from motionmend.bodies.camera import KINECT, DepthFrame
from motionmend.bodies.performer import DOFS, LANDMARKS, advance, landmarks, standing
from motionmend.bodies.surface import render
from motionmend.evaluate.sensor import sensed
from motionmend.track.database import PoseDatabase
from motionmend.track.hindsight import backwards as hindsight
from motionmend.track.hindsight.backwards import (
    CHOICES,
    NEAR,
    PARTS,
    SWITCH,
    TRUNK,
    Back,
    eased,
    likeliest,
    looked_back,
    moment,
    revised,
)
from motionmend.track.hindsight.together import between_turns
from motionmend.track.limbs.other_poses import LIMBS, with_limb
from motionmend.track.model import TrackerModel
from motionmend.track.readings.facing import doubted
from motionmend.track.settings import settings_of
from motionmend.track.starting.reach import reach
from motionmend.track.tracker import start, step

BODY = anatomy.average()
DEFAULT = settings_of("default")
HANGING = standing((0.0, 0.1, 2.6))
R_ARM = 1
R_WRIST, R_SHOULDER = LANDMARKS.index("r_wrist"), LANDMARKS.index("r_shoulder")
FRAMES = 16


def raised(share):
    """Standing with the right wrist on its way from beside the hip to above the shoulder."""
    targets, free = np.full((len(LANDMARKS), 3), np.nan), np.zeros(DOFS, bool)
    at = landmarks(BODY, HANGING)
    high = at[R_SHOULDER] + np.array([-0.35, -0.3, 0.0])
    targets[R_WRIST] = (1.0 - share) * (at[R_WRIST] + np.array([-0.15, 0.0, 0.0])) + share * high
    free[6 + LIMBS[R_ARM].columns] = True
    return reach(BODY, HANGING, targets, None, free)[0]


@cache
def take(noise=None):
    """Truth, model, and what the tracker said of somebody who raises an arm."""
    true = [raised(share) for share in np.linspace(0.0, 1.0, FRAMES)]
    poses = np.array([pose.joints for pose in true])
    model = TrackerModel(PoseDatabase(poses, np.full(len(poses), len(poses) - 1)))
    depths = [render(BODY, pose, KINECT).depth for pose in true]
    if noise is not None:
        depths = [sensed(depth, KINECT, noise, t) for t, depth in enumerate(depths)]
    frames = [DepthFrame(KINECT, depth, None, t / 30.0) for t, depth in enumerate(depths)]
    state, moments = start(model, DEFAULT, frames[0], BODY, true[0]), []
    for frame in frames:
        state, estimate = step(model, DEFAULT, state, frame)
        moments.append(moment(state, estimate))
    return true, model, tuple(moments)


def said_otherwise(one, pose, flags=("tracked",)):
    """The moment, had the tracker said another pose."""
    estimate = replace(one.estimate, pose=pose, landmarks=landmarks(BODY, pose), flags=flags)
    return replace(one, state=replace(one.state, pose=pose, lost="lost" in flags), estimate=estimate)


def off(estimate, pose):
    return np.linalg.norm(estimate.landmarks - landmarks(BODY, pose), axis=1)


def test_parts_are_all_joints_once_and_a_limbs_bones_end_within_its_part():
    assert sorted(np.concatenate(PARTS).tolist()) == list(range(len(LANDMARKS)))
    for limb, part in zip(LIMBS, PARTS, strict=False):
        moved = with_limb(HANGING, limb, HANGING.joints[limb.columns] + 0.2)
        gone = np.linalg.norm(landmarks(BODY, moved) - landmarks(BODY, HANGING), axis=1) > 1e-9
        assert set(np.flatnonzero(gone)) <= set(part.tolist())


@pytest.mark.slow
@pytest.mark.parametrize("noise", [None, 0])
def test_a_limb_taken_up_wrongly_is_set_right_from_where_it_is_found_again(noise):
    true, model, moments = take(noise)
    wrong = list(moments)
    for t in range(5, 12):
        arm = HANGING.joints[LIMBS[R_ARM].columns]
        wrong[t] = said_otherwise(moments[t], with_limb(moments[t].estimate.pose, LIMBS[R_ARM], arm))
    told = looked_back(model, DEFAULT, wrong, FRAMES)
    for t, (pose, before, after) in enumerate(zip(true, wrong, told, strict=True)):
        lost = off(before.estimate, pose)[PARTS[R_ARM]].max() > 2 * NEAR
        assert ("revised" in after.flags) >= lost
        assert off(after, pose).max() < 0.05
        assert 5 <= t < 12 or "revised" not in after.flags
    assert sum("revised" in one.flags for one in told) >= 4


@pytest.mark.parametrize("noise", [None, 0])
def test_what_was_tracked_well_stays_and_keeps_its_flags(noise):
    true, model, moments = take(noise)
    told = looked_back(model, DEFAULT, moments, FRAMES)
    for before, after in zip(moments, told, strict=True):
        assert after.flags == before.estimate.flags
        assert np.linalg.norm(after.landmarks - before.estimate.landmarks, axis=1).max() < NEAR
    before, after = (
        np.mean([off(one, pose) for one, pose in zip(said, true, strict=True)])
        for said in ([one.estimate for one in moments], told)
    )
    assert after < (before + 0.001 if noise is None else 0.8 * before)


def test_lost_frames_before_the_body_was_found_are_tracked_and_nobody_stays_nobody():
    true, model, moments = take()
    lost = list(moments)
    away = replace(HANGING, translation=HANGING.translation + np.array([0.5, 0.0, 0.5]))
    for t in range(3, 9):
        lost[t] = said_otherwise(moments[t], away, ("lost",))
    empty = replace(lost[2], state=replace(lost[2].state, evidence=None, lost=True))
    lost[2] = replace(empty, estimate=replace(empty.estimate, pose=None, flags=("empty",)))
    told = looked_back(model, DEFAULT, lost, FRAMES)
    for t in range(3, 9):
        assert {"tracked", "revised"} <= set(told[t].flags)
        assert off(told[t], true[t]).max() < 0.05
        assert told[t].std.max() < 0.1
    assert told[2].flags == ("empty",)
    assert told[2].pose is None
    assert told[1].flags == moments[1].estimate.flags


def test_lost_frames_are_as_doubtful_between_front_and_back_as_what_they_are_followed_from():
    _, model, moments = take()
    lost = [said_otherwise(one, one.estimate.pose, ("lost",)) if t < 8 else one for t, one in enumerate(moments)]
    last = lost[-1].state
    asked = [*lost[:-1], replace(lost[-1], state=replace(last, facing=doubted(BODY, last.pose, None)))]
    for closed, opened in zip(*(looked_back(model, DEFAULT, some, 8) for some in (lost, asked)), strict=True):
        np.testing.assert_array_equal(closed.std, closed.settled)
        np.testing.assert_array_equal(opened.settled, closed.settled)
        assert opened.std[R_SHOULDER] > 0.1


def test_the_way_back_does_not_cross_a_pause():
    _, model, moments = take()
    lost = [said_otherwise(one, one.estimate.pose, ("lost",)) if t < 8 else one for t, one in enumerate(moments)]
    apart = [
        replace(one, state=replace(one.state, time=one.state.time - (1.0 if t < 8 else 0.0)))
        for t, one in enumerate(lost)
    ]
    assert all("tracked" in one.flags for one in looked_back(model, DEFAULT, lost, FRAMES))
    assert [one.flags for one in looked_back(model, DEFAULT, apart, FRAMES)][:8] == [("lost",)] * 8


def test_what_neither_account_sees_is_as_unsure_as_half_of_what_they_are_apart():
    _, model, moments = take()
    arm = HANGING.joints[LIMBS[R_ARM].columns]
    held = np.zeros(16, bool)
    held[PARTS[R_ARM]] = True
    some = list(moments)
    for t in range(4, 10):
        one = said_otherwise(moments[t], with_limb(moments[t].estimate.pose, LIMBS[R_ARM], arm), ("tracked", "held"))
        some[t] = replace(one, estimate=replace(one.estimate, held=held))
    backs = hindsight.way_back(model, DEFAULT, some)
    for one, back in zip(some[4:10], backs[4:10], strict=True):
        unseen = replace(back, held=held)
        told = hindsight._joined(BODY, one, unseen, np.array([0.0, 1.0, 0.0, 0.0, 0.0]), one.estimate.pose.root)
        gap = np.linalg.norm(landmarks(BODY, back.pose) - one.estimate.landmarks, axis=1)
        assert (told.std[held] >= 0.5 * gap[held] - 1e-12).all()
        assert "held" in told.flags


@pytest.mark.slow
@settings(max_examples=6)
@given(st.integers(1, 13), st.integers(1, 6), st.integers(1, 3))
def test_every_frame_is_told_of_once_in_order_and_few_wait(count, window, ahead):
    _, model, moments = take()
    drawn = 0

    def some():
        nonlocal drawn
        for one in moments[:count]:
            drawn += 1
            yield one

    kept = hindsight.WINDOW, hindsight.AHEAD
    hindsight.WINDOW, hindsight.AHEAD = window, ahead
    try:
        told = []
        for estimate in revised(model, DEFAULT, some()):
            told.append(estimate)
            assert drawn <= len(told) + window + ahead - 1
    finally:
        hindsight.WINDOW, hindsight.AHEAD = kept
    assert len(told) == count
    for one, estimate in zip(moments, told, strict=False):
        assert np.linalg.norm(one.estimate.landmarks - estimate.landmarks, axis=1).max() < NEAR
        assert estimate.seconds["hindsight"] >= 0.0


def test_the_dissertations_settings_leave_estimates_as_they_come():
    _, model, moments = take()
    told = list(revised(model, settings_of("paper"), moments))
    assert all(after is one.estimate for one, after in zip(moments, told, strict=True))


def test_a_moment_keeps_no_room_and_no_images():
    _, _, moments = take()
    state = moments[-1].state
    kept = moment(replace(state, before=(np.zeros(1),) * 4), moments[-1].estimate)
    for one in (*moments, kept):
        assert one.state.scene is None
        assert one.state.before is None
        assert one.state.evidence is not None


def account(rng, one):
    """The way back of a frame with costs and distances drawn."""
    pose = one.estimate.pose
    zeros = frozen(np.zeros(16))
    solution = type("", (), {"state": pose})()
    costs = rng.uniform(0.0, 0.1, (2, TRUNK + 1))
    return Back(solution, costs[1, 0], zeros > 0, zeros, zeros, zeros, rng.uniform(0.0, 0.5, TRUNK + 1), costs)


@pytest.mark.slow
@settings(max_examples=10)
@given(st.integers(0, 2**32 - 1))
def test_the_choice_is_the_best_of_all(seed):
    rng = np.random.default_rng(seed)
    _, _, moments = take()
    moments = moments[:3]
    backs = [account(rng, one) for one in moments]

    def cost(back, choice):
        first, other = back.costs
        if choice[TRUNK]:
            return other[0] + sum(other[1 + k] - other[0] for k in range(TRUNK) if not choice[k])
        return first[0] + sum(first[1 + k] - first[0] for k in range(TRUNK) if choice[k])

    def total(path):
        chosen = [CHOICES[k] for k in path]
        shown = sum(cost(back, choice) for back, choice in zip(backs, chosen, strict=True))
        apart = [np.minimum(backs[t].apart, backs[t + 1].apart) for t in range(2)]
        return shown + SWITCH * sum((apart[t] * (chosen[t] != chosen[t + 1])).sum() for t in range(2))

    sums = {path: total(path) for path in product(range(0, len(CHOICES), 3), repeat=3)}
    found = likeliest(moments, backs)
    path = tuple(int(np.flatnonzero((parts == CHOICES).all(axis=1))[0]) for parts in found)
    assert total(path) <= min(sums.values()) + 1e-12


def test_what_one_account_does_not_have_is_the_others():
    rng = np.random.default_rng(3)
    _, _, moments = take()
    some = [
        said_otherwise(one, one.estimate.pose, ("lost",)) if t in (2, 3) else one for t, one in enumerate(moments[:6])
    ]
    backs = [None if t in (1, 3) else account(rng, one) for t, one in enumerate(some)]
    found = likeliest(some, backs)
    assert not found[[1, 3]].any()
    assert found[2].all()


@settings(max_examples=10)
@given(st.integers(0, 2**32 - 1))
def test_a_choice_is_spread_over_near_frames_alone_and_a_steady_one_stays(seed):
    rng = np.random.default_rng(seed)
    _, _, moments = take()
    backs = [account(rng, one) for one in moments]
    for back in backs:
        back.apart[:] = np.where(rng.uniform(size=TRUNK + 1) < 0.7, 0.5 * NEAR, 2.0 * NEAR)
    chosen = rng.uniform(size=(FRAMES, TRUNK + 1)) < 0.5
    shares = eased(moments, backs, chosen)
    far = np.array([back.apart for back in backs]) > NEAR
    np.testing.assert_array_equal(shares[far], chosen[far])
    assert ((shares >= 0.0) & (shares <= 1.0)).all()
    for steady in (np.zeros_like(chosen), np.ones_like(chosen)):
        np.testing.assert_array_equal(eased(moments, backs, steady), steady)


@settings(max_examples=10)
@given(st.integers(0, 2**32 - 1), st.floats(0.0, 1.0))
def test_mixed_poses_have_their_joints_between_or_are_of_one_pose(seed, share):
    rng = np.random.default_rng(seed)
    first, other = (
        advance(BODY, raised(0.5), np.repeat((0.02, 0.1), (6, DOFS - 6)) * rng.normal(size=DOFS)) for _ in "ab"
    )
    shares = np.full(TRUNK + 1, share)
    turned = between_turns(first.root, other.root, share)
    here, there = landmarks(BODY, first), landmarks(BODY, other)
    pose, place = hindsight._mixed(BODY, (first, here), (other, there), shares, turned)
    np.testing.assert_allclose(place, landmarks(BODY, pose))
    straight = np.linalg.norm(place - here - share * (there - here), axis=1).max() <= hindsight.STRAIGHT
    whole = there if share > 0.5 else here
    assert straight or np.allclose(place, whole)
    for all_of, one in ((0.0, first), (1.0, other)):
        mixed = hindsight._mixed(BODY, (first, here), (other, there), 0.0 * shares + all_of, one.root)
        np.testing.assert_allclose(mixed[1], landmarks(BODY, one))
