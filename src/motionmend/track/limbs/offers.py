"""Where else a limb may be, by what the frame shows and the pose does not: detected joints, unexplained points."""

from collections.abc import Sequence

import numpy as np

from ...arrays import Bools, Floats
from ...bodies.camera import DepthFrame
from ...bodies.performer import Performer, Pose, landmarks
from ..detect.joints import Detector, detect
from ..frame.observation import Observation
from ..readings.hypotheses import apart, asked
from ..starting.settle import limb_hints
from ..state import Fit, Sight
from ..terms.objective import refined
from .judge import JUDGED, Verdict, judge
from .mend import DRAWS
from .other_poses import LIMBS, Coarse, limb_costs, limb_search, with_limb

UNEXPLAINED = 0.006  # m^2, about a hand: with less the frame raises no question
MUCH = 0.02  # m^2, half a forearm: with more a limb is not where the pose has it
APART = 0.12  # m, a joint detected nearer to where the pose has it says nothing new
PIXELS = 450  # of the person the detector looks at: it is asked for a place to begin from, no more


def offers_tried(sight: Sight, fit: Fit) -> tuple[Fit, int, bool]:
    """The best of the fit and what Gauss-Newton makes of limbs where the detector sees them.

    Parameters
    ----------
    sight, fit : the frame, whose model has a detector, and how it is explained so far.

    Returns
    -------
    The fit, how many limbs were moved, and whether there were any offers.
    """
    model, performer = sight.model, fit.state.performer
    assert model.detector is not None
    shapes, furniture = model.limb_shapes, fit.state.furniture
    offers = limb_offers(model.detector, performer, fit.pose, sight.seen, sight.coarse, shapes, furniture=furniture)
    moved = 0
    for offer in offers:
        trial = refined(sight, fit, offer, fit.terms)
        if trial.wrong < fit.wrong - asked(apart(performer, trial.pose, fit.pose)):
            fit, moved = trial, moved + 1
    return fit, moved, bool(offers)


def limb_offers(
    detector: Detector,
    performer: Performer,
    pose: Pose,
    seen: Observation,
    coarse: Coarse,
    shapes: Sequence[Floats] = (),
    most: int = 2,
    furniture: Bools | None = None,
) -> list[Pose]:
    """The pose with one of its limbs elsewhere, for each place where the frame shows one, the likeliest first.

    None as a rule. They are to be refined, and kept if they explain the frame better.

    Parameters
    ----------
    detector : fitted; it is asked only when the pose leaves something unexplained.
    performer, pose : as tracked.
    seen, coarse : the frame.
    shapes : for each of `LIMBS` poses of a library (C, n): where much is unexplained the limbs that may be there are
        searched, too; without shapes they are not.
    most : how many. furniture : (H, W) as for `detect`.
    """
    verdict = judge(performer, pose, seen.as_fine_as(JUDGED))
    if verdict.area < UNEXPLAINED:
        return []
    detection = detect(detector, DepthFrame(seen.camera, seen.depth, None, seen.time), PIXELS, furniture)
    hints = limb_hints(performer, pose, detection, verdict, 0.8 * APART)
    offers: list[tuple[float, Pose]] = []
    here = landmarks(performer, pose)
    doubtful = _doubtful(performer, pose, verdict) if len(shapes) and verdict.area > MUCH else ()
    for number, (limb, some) in enumerate(zip(LIMBS, hints, strict=True)):
        ways = [some] if len(some) else []
        if number in doubtful:
            more = np.concatenate((shapes[number], some))
            ways.append(limb_search(performer, pose, limb, more, coarse, DRAWS[number]).best[None])
        for way in ways:
            costs = limb_costs(performer, pose, limb, np.concatenate((pose.joints[limb.columns][None], way)), coarse)
            best = int(np.argmin(costs[1:]))
            moved = with_limb(pose, limb, way[best])
            if np.linalg.norm((landmarks(performer, moved) - here)[limb.landmarks[-1]]) > APART:
                offers.append((float(costs[1 + best] - costs[0]), moved))
    return [moved for _, moved in sorted(offers, key=lambda offer: offer[0])[:most]]


def _doubtful(performer: Performer, pose: Pose, verdict: Verdict) -> tuple[int, ...]:
    """Which of `LIMBS` can reach most of what is unexplained: the arms, or the legs."""
    at = landmarks(performer, pose)
    within = []
    for limb in LIMBS:
        root, middle, end = at[limb.begin], *at[limb.landmarks]
        reach = np.linalg.norm(middle - root) + np.linalg.norm(end - middle) + 0.15
        within.append(int((np.linalg.norm(verdict.loose - root, axis=1) < reach).sum()))
    arms, legs = within[0] + within[1], within[2] + within[3]
    return (0, 1) if arms >= legs else (2, 3)
