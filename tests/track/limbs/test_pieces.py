"""Pieces of a person that nothing of the body is near."""

from dataclasses import replace

import numpy as np
import pytest

from motionmend.bodies.anatomy import average
from motionmend.bodies.camera import KINECT, DepthFrame
from motionmend.bodies.performer import LANDMARKS, Pose, landmarks, standing
from motionmend.bodies.surface import intrinsics, render
from motionmend.track.database import PoseDatabase
from motionmend.track.frame.evidence import evidence_of
from motionmend.track.frame.observation import Observation
from motionmend.track.limbs.other_poses import LIMBS, Coarse, coarse_of, disagreement, left_over
from motionmend.track.limbs.pieces import CLAIMED, claimed, in_doubt, laid_in
from motionmend.track.model import TrackerModel
from motionmend.track.settings import settings_of
from motionmend.track.state import Sight, TrackState
from motionmend.track.terms.objective import fitted
from motionmend.track.terms.prior import PriorTerm, strangeness
from motionmend.track.tracker import start, step

BODY = average()


@pytest.mark.parametrize("number", [0, 1])
def test_an_arm_is_laid_into_what_is_left_over(number: int) -> None:
    pose, limb = standing(), LIMBS[number]
    joints = pose.joints.copy()
    joints[limb.columns[4]] += 1.5 * (1.0 if number == 0 else limb.mirror[4])  # the shoulder
    elsewhere = Pose(pose.translation, pose.root, joints)
    picture = render(BODY, elsewhere, KINECT, 2)
    coarse = Coarse(
        intrinsics(picture.camera), picture.depth, np.isnan(picture.depth), int(np.isfinite(picture.depth).sum())
    )
    left = left_over(BODY, pose, coarse)
    assert left.area > 0.012
    best = laid_in(BODY, pose, coarse, left)[0].pose
    wrist = LANDMARKS.index(limb.name[:2] + "wrist")
    off, before = (np.linalg.norm((landmarks(BODY, one) - landmarks(BODY, elsewhere))[wrist]) for one in (best, pose))
    assert before > 0.25
    assert off < 0.1
    assert disagreement(BODY, best, coarse) < 0.8 * disagreement(BODY, pose, coarse)
    assert left_over(BODY, best, coarse).area < 0.5 * left.area


def test_nothing_is_laid_into_nothing() -> None:
    pose = standing()
    picture = render(BODY, pose, KINECT, 2)
    coarse = Coarse(intrinsics(picture.camera), picture.depth, np.isnan(picture.depth), 300)
    assert laid_in(BODY, pose, coarse, left_over(BODY, pose, coarse)) == []


def raised(number: int) -> Pose:
    """Somebody who stands with one arm out to the side."""
    joints = standing().joints.copy()
    joints[LIMBS[number].columns[4]] += 1.5 * (1.0 if number == 0 else LIMBS[number].mirror[4])
    return Pose(standing().translation, standing().root, joints)


def sight_of(pose: Pose) -> Sight:
    """What is seen of it, by a tracker whose library has arms that hang down and nothing else."""
    settings, depth = settings_of("default"), render(BODY, pose, KINECT).depth
    library = np.tile(standing().joints, (9, 1)) + np.linspace(-0.01, 0.01, 9)[:, None]
    model = TrackerModel(PoseDatabase(library, np.full(9, 8)))
    seen = Observation(KINECT, depth, np.isnan(depth), 0.0)
    evidence = evidence_of(seen, settings)
    return Sight(model, settings, seen, evidence, coarse_of(evidence))


@pytest.mark.parametrize("number", [0, 1])
def test_an_arm_is_laid_into_a_piece_though_nobody_of_the_library_holds_it_so(number: int) -> None:
    truth = raised(number)
    sight = sight_of(truth)
    fit = fitted(sight, TrackState(BODY, None, standing()), standing(), 0)
    terms = [replace(one, form=0.7 * one.form) if isinstance(one, PriorTerm) else one for one in fit.terms]
    fit = replace(fit, terms=terms)
    left = left_over(BODY, fit.pose, sight.coarse)
    found, moved = claimed(sight, fit, left, laid_in(BODY, fit.pose, sight.coarse, left))
    assert moved == 1
    gained = fit.wrong - found.wrong
    assert strangeness(terms, found.pose) - strangeness(terms, fit.pose) > gained  # an odd pose, by the library
    assert np.linalg.norm(landmarks(BODY, found.pose) - landmarks(BODY, truth), axis=1).max() < 0.12


@pytest.mark.parametrize("number", [0, 1])
def test_while_a_piece_is_left_over_the_limb_that_may_be_in_it_is_unsure(number: int) -> None:
    coarse = sight_of(raised(number)).coarse
    left = left_over(BODY, standing(), coarse)
    assert left.area > CLAIMED
    wrong = disagreement(BODY, standing(), coarse)
    doubt = in_doubt(BODY, standing(), wrong, laid_in(BODY, standing(), coarse, left))
    elbow = LANDMARKS.index(f"{LIMBS[number].name[:2]}elbow")
    assert doubt[elbow : elbow + 2].min() > 0.1
    assert doubt[LANDMARKS.index("l_hip") :].max() < 0.05
    assert doubt[: LANDMARKS.index("head")].max() < 0.05
    right = left_over(BODY, raised(number), coarse)
    assert not in_doubt(BODY, raised(number), 0.0, laid_in(BODY, raised(number), coarse, right)).any()


def test_a_limb_that_the_tracker_has_lost_is_said_to_be_unsure(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("motionmend.track.tracker.mend_limbs", lambda _, fit, *__: (fit, 0, np.zeros(16), None))
    monkeypatch.setattr("motionmend.track.tracker.claimed", lambda _, fit, *__: (fit, 0))
    model, settings = sight_of(standing()).model, settings_of("default")
    frames = [DepthFrame(KINECT, render(BODY, pose, KINECT).depth, None, 0.0) for pose in (standing(), raised(0))]
    state = start(model, settings, frames[0], BODY, standing())
    for t, frame in enumerate(frames):
        state, estimate = step(model, settings, state, replace(frame, time=t / 30.0))
    wrist = LANDMARKS.index("l_wrist")
    assert np.linalg.norm(estimate.landmarks - landmarks(BODY, raised(0)), axis=1)[wrist] > 0.3
    assert estimate.std[wrist] > 0.4  # 0.28 with what the bones alone say of themselves
