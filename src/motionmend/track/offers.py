"""Where else a limb may be, by what the frame shows and the pose does not: detected joints, unexplained points."""

import numpy as np

from ..bodies.camera import DepthFrame
from ..bodies.performer import LANDMARKS, Performer, Pose, landmarks
from .detect import Detector, detect
from .judge import judge
from .limbs import LIMBS, Coarse, limb_costs, with_limb
from .observation import Observation
from .settle import limb_hints

UNEXPLAINED = 0.006  # m^2, about a hand: with less the frame raises no question
APART = 0.12  # m, a joint detected nearer to where the pose has it says nothing new


def limb_offers(
    detector: Detector, performer: Performer, pose: Pose, seen: Observation, coarse: Coarse, most: int = 2
) -> list[Pose]:
    """Poses with one limb elsewhere, to be refined and kept if they explain the frame better; none as a rule.

    Parameters
    ----------
    detector : fitted; it is asked only when the pose leaves something unexplained.
    performer, pose : as tracked.
    seen, coarse : the frame.
    most : how many poses.
    """
    step = max(1, round(seen.camera.width / 80))
    verdict = judge(performer, pose, seen.every(step))
    if verdict.area < UNEXPLAINED:
        return []
    detection = detect(detector, DepthFrame(seen.camera, seen.depth, None, seen.time))
    hints = limb_hints(performer, pose, detection, verdict)
    offers: list[tuple[float, Pose]] = []
    here = landmarks(performer, pose)
    for limb, some in zip(LIMBS, hints, strict=True):
        if not len(some):
            continue
        costs = limb_costs(performer, pose, limb, np.concatenate((pose.joints[limb.columns][None], some)), coarse)
        best = int(np.argmin(costs[1:]))
        moved = with_limb(pose, limb, some[best])
        end = LANDMARKS.index(limb.name[:2] + ("wrist" if limb.name.endswith("arm") else "ankle"))
        if np.linalg.norm(landmarks(performer, moved)[end] - here[end]) > APART:
            offers.append((float(costs[1 + best] - costs[0]), moved))
    return [moved for _, moved in sorted(offers, key=lambda offer: offer[0])[:most]]
