"""Two poses of one body followed side by side until one of them is refuted."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionmend.arrays import frozen
from motionmend.bodies import anatomy
from motionmend.bodies.camera import KINECT
from motionmend.bodies.performer import DOFS, LANDMARKS, landmarks, standing
from motionmend.bodies.surface import render
from motionmend.numerics.least_squares import Solution, System
from motionmend.track.database import PoseDatabase
from motionmend.track.frame.evidence import evidence_of
from motionmend.track.frame.observation import Observation
from motionmend.track.limbs.other_poses import LIMBS, coarse_of, disagreement
from motionmend.track.model import TrackerModel
from motionmend.track.readings.hypotheses import GAIN, LASTS, MOST, apart, asked, contested
from motionmend.track.settings import settings_of
from motionmend.track.starting.reach import reach
from motionmend.track.state import Fit, Hypothesis, Sight, TrackState
from motionmend.track.terms.objective import fitted, terms_of
from walkers import as_sensed

BODY = anatomy.average()
DT = 1.0 / 30.0
DEFAULT = settings_of("default")
R_WRIST, R_SHOULDER = LANDMARKS.index("r_wrist"), LANDMARKS.index("r_shoulder")
HANGING = standing((0.0, 0.1, 2.6))


def raised(pose, ahead=0.0):
    """The pose with its right wrist above its shoulder, or before it, m."""
    targets, free = np.full((len(LANDMARKS), 3), np.nan), np.zeros(DOFS, bool)
    targets[R_WRIST] = landmarks(BODY, pose)[R_SHOULDER] + np.array([-0.15, ahead - 0.5, -ahead])
    free[6 + LIMBS[1].columns] = True
    return reach(BODY, pose, targets, None, free)[0]


@cache
def library():
    poses = np.array([HANGING.joints, *(raised(HANGING, ahead).joints for ahead in (0.0, 0.2, 0.4))])
    return TrackerModel(PoseDatabase(poses, np.full(len(poses), len(poses) - 1)))


def sight_of(depth, time):
    seen = Observation(KINECT, depth, np.isnan(depth), time)
    evidence = evidence_of(seen, DEFAULT)
    return Sight(library(), DEFAULT, seen, evidence, coarse_of(evidence))


def contest(shown, taken, other, frames, gained=0.0):
    """The pose that is followed after each frame, and the hypotheses, `taken` being what the solution would be."""
    state = TrackState(BODY, None, taken, hypothesis=Hypothesis(other, gained))
    followed, hypotheses = [], []
    drawn = render(BODY, shown, KINECT).depth
    for t in range(frames):
        depth = as_sensed(drawn, KINECT, 3, t)
        sight = sight_of(depth, t * DT)
        fit = contested(sight, fitted(sight, state, state.pose), DT, None)
        assert fit.wrong == disagreement(BODY, fit.pose, sight.coarse)
        state = replace(fit.state, pose=fit.pose, velocity=frozen(np.zeros(DOFS)))
        followed.append(fit.pose)
        hypotheses.append(state.hypothesis)
    return followed, hypotheses


@given(st.floats(0.0, 5.0), st.floats(0.0, 5.0))
def test_a_longer_leap_asks_for_more_but_never_for_what_cannot_be_shown(one, other):
    assert GAIN <= asked(one) <= MOST * GAIN
    assert (asked(one) <= asked(other)) or one > other


@pytest.mark.parametrize(("truth", "taken"), [(HANGING, raised(HANGING)), (raised(HANGING), HANGING)])
def test_of_two_arms_the_one_that_is_seen_is_taken_and_the_other_watched_for_a_while(truth, taken):
    assert apart(BODY, truth, taken) > 0.5
    followed, hypotheses = contest(truth, taken, truth, 8)
    turn = next(t for t, pose in enumerate(followed) if apart(BODY, pose, truth) < 0.15)
    assert turn < 6
    assert hypotheses[turn] is not None
    assert apart(BODY, hypotheses[turn].pose, truth) > 0.1
    assert all(apart(BODY, pose, truth) < 0.15 for pose in followed[turn:])


@pytest.mark.slow
@pytest.mark.parametrize("gained", [0.0, 0.03])
def test_a_wrong_hypothesis_is_never_taken_and_is_given_up(gained):
    followed, hypotheses = contest(HANGING, HANGING, raised(HANGING), LASTS + 1, gained)
    assert all(apart(BODY, pose, HANGING) < 0.1 for pose in followed)
    assert hypotheses[-1] is None


def test_two_poses_that_have_become_one_are_one():
    _, hypotheses = contest(HANGING, HANGING, HANGING, 1, 0.02)
    assert hypotheses == [None]


def test_a_pose_that_lost_is_a_hypothesis_only_if_it_is_another_and_only_while_time_is_known():
    depth = render(BODY, HANGING, KINECT).depth
    sight = sight_of(depth, 0.0)
    state = TrackState(BODY, None, HANGING, hypothesis=Hypothesis(raised(HANGING, 0.3), 0.01))
    terms = terms_of(library(), DEFAULT, state, sight.evidence, HANGING)
    solution = Solution(HANGING, System(np.eye(DOFS), np.zeros(DOFS), {}, {}, 0.0), 1, True)
    for hypothesis, kept in (
        (None, False),
        (Hypothesis(HANGING, 0.01), False),
        (Hypothesis(raised(HANGING), 0.01), True),
    ):
        after = contested(sight, Fit(state, terms, HANGING, solution, 0.0), 0.0, hypothesis).state
        assert (after.hypothesis is not None) == kept
        if kept:
            np.testing.assert_array_equal(landmarks(BODY, after.hypothesis.pose), landmarks(BODY, hypothesis.pose))
