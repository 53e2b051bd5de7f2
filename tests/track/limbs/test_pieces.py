"""Pieces of a person that nothing of the body is near."""

import numpy as np
import pytest

from motionmend.bodies.anatomy import average
from motionmend.bodies.camera import KINECT
from motionmend.bodies.performer import LANDMARKS, Pose, landmarks, standing
from motionmend.bodies.surface import intrinsics, render
from motionmend.track.limbs.other_poses import LIMBS, Coarse, disagreement, left_over
from motionmend.track.limbs.pieces import laid_in

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
    best = laid_in(BODY, pose, coarse, left)[0][0]
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
