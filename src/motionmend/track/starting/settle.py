"""A first pose's limbs brought to where the frame shows them, one after the other, the trunk being about right.

Gauss-Newton moves a limb to what is near it; one that a detector mistook or did not see is far. So each limb's poses
are searched as a whole: those of a library and those that detected joints and unexplained points suggest, then
closer and closer about the best of them (`other_poses.limb_search`), every one judged by a picture.
"""

from collections.abc import Sequence

import numpy as np

from ...arrays import Floats
from ...bodies.performer import DOFS, LANDMARKS, Performer, Pose, landmarks, rotation
from ..detect.joints import Detection
from ..frame.observation import Observation
from ..limbs.judge import Verdict, judge
from ..limbs.other_poses import LIMBS, Coarse, Limb, draws, limb_search, opposite, with_limb
from .first_pose import Candidate, Refine
from .reach import reach

ROUNDS = (0.30, 0.15, 0.07)  # rad, spread about the best in each round
ELITE, DRAWN = 12, 84  # how many best are kept, and how many are drawn about them
TURN = np.radians(30.0)
HOPELESS = 1.7  # times the disagreement of the best reading: such a one is not settled any more
PASSES = 2
WELL = 0.10  # disagreement of a pose that needs no second pass
GAIN = 0.004  # share of the person's pixels that a limb's new pose must explain better


def settled_readings(
    performer: Performer,
    found: Sequence[Candidate],
    seen: Observation,
    coarse: Coarse,
    shapes: Sequence[Floats],
    refine: Refine,
    detection: Detection | None = None,
    most: int = 4,
) -> list[Candidate]:
    """First poses, the best first: candidates refined, and the best of each reading settled limb by limb.

    Parameters
    ----------
    performer : whose pose.
    found : candidates, the likeliest first (`first_pose.candidates`).
    seen : the frame, coarse, as they were judged by.
    coarse, shapes, refine : as of `settle`.
    detection : of the frame, if there is one, for the limbs.
    most : how many candidates are refined, besides the best of each reading.
    """
    chosen = list(found[:most])
    missed = sorted({one.source for one in found} - {one.source for one in chosen})
    chosen += [next(one for one in found if one.source == source) for source in missed]
    refined = sorted((Candidate(*refine(one.pose), one.source) for one in chosen), key=lambda one: one.cost)
    settled = []
    for source in dict.fromkeys(one.source for one in refined):
        first = next(one for one in refined if one.source == source)
        if first.cost > HOPELESS * refined[0].cost + 0.02:
            continue
        hints = limb_hints(performer, first.pose, detection, judge(performer, first.pose, seen))
        pose, cost = settle(performer, first.pose, first.cost, coarse, shapes, refine, hints)
        settled.append(Candidate(pose, cost, source))
    return sorted(settled, key=lambda one: one.cost)


def settle(
    performer: Performer,
    pose: Pose,
    cost: float,
    coarse: Coarse,
    shapes: Sequence[Floats],
    refine: Refine,
    hints: Sequence[Floats] | None = None,
    seed: int = 0,
) -> tuple[Pose, float]:
    """Search every limb's poses, and keep what explains the frame better once it is refined.

    Parameters
    ----------
    performer : whose limbs.
    pose, cost : to begin with, and its disagreement with the frame.
    coarse : the frame.
    shapes : for each of `LIMBS` poses of a library, (C, n).
    refine : the tracker's step from a pose; its cost is a disagreement too.
    hints : for each of `LIMBS` more poses (C, n), see `limb_hints`.
    seed : of what is drawn; the same arguments give the same pose.

    Returns
    -------
    The pose and its cost, never a worse one.
    """
    rng = np.random.default_rng(seed)
    for _ in range(PASSES):
        before = cost
        for change in (_turned, _swapped):
            for other in change(pose):
                moved, after = refine(other)
                if after < cost - GAIN:
                    pose, cost = moved, after
        pose, cost = _limb_by_limb(performer, pose, cost, coarse, shapes, refine, hints, rng)
        if cost > before - GAIN or cost < WELL:
            break
    if cost >= WELL:
        # Legs seen from the side, one before the other: neither can move to the other's place while that is taken.
        other, after = refine(_swapped(pose)[1])
        other, after = _limb_by_limb(performer, other, after, coarse, shapes, refine, hints, rng)
        if after < cost - GAIN:
            pose, cost = other, after
    return pose, cost


def _limb_by_limb(
    performer: Performer,
    pose: Pose,
    cost: float,
    coarse: Coarse,
    shapes: Sequence[Floats],
    refine: Refine,
    hints: Sequence[Floats] | None,
    rng: np.random.Generator,
) -> tuple[Pose, float]:
    """The limb that stands to gain most is next; those that gained nothing wait until another limb has moved."""
    tried: set[int] = set()
    for _ in range(2 * len(LIMBS)):
        offers = []
        for number, limb in enumerate(LIMBS):
            if number in tried:
                continue
            more = shapes[number] if hints is None else np.concatenate((shapes[number], hints[number]))
            values, gain = searched(performer, pose, limb, coarse, more, rng)
            offers.append((gain, number, values))
        if not offers:
            break
        gain, number, values = max(offers, key=lambda offer: offer[0])
        if gain < GAIN:
            break
        moved, after = refine(with_limb(pose, LIMBS[number], values))
        if after < cost - GAIN:
            pose, cost, tried = moved, after, {number}
        else:
            tried.add(number)
    return pose, cost


def limb_hints(
    performer: Performer, pose: Pose, detection: Detection | None, verdict: Verdict | None, least: float = 0.0
) -> tuple[Floats, ...]:
    """For each of `LIMBS` poses (C, n) that lead to detected joints or to points that nothing explains yet.

    Detected elbows and wrists of either side count for both, since left and right are what a detector confuses.
    Only those at least `least` m from where the limb's end is are asked for.
    """
    return tuple(_hints(performer, pose, limb, detection, verdict, least) for limb in LIMBS)


def _turned(pose: Pose) -> list[Pose]:
    """Turned about its own long axis either way, by what front and side are still mistaken for each other."""
    about = [rotation(np.array([0.0, angle, 0.0])) for angle in (-TURN, TURN)]
    return [Pose(pose.translation, pose.root @ turn, pose.joints) for turn in about]


def _swapped(pose: Pose) -> list[Pose]:
    """With the arms, and with the legs, of the other side: mirrored, as if left had been taken for right."""
    found = []
    for left, right in ((LIMBS[0], LIMBS[1]), (LIMBS[2], LIMBS[3])):
        values = pose.joints[left.columns] * left.mirror, pose.joints[right.columns] * right.mirror
        found.append(with_limb(with_limb(pose, left, values[1]), right, values[0]))
    return found


def searched(
    performer: Performer, pose: Pose, limb: Limb, coarse: Coarse, shapes: Floats, rng: np.random.Generator
) -> tuple[Floats, float]:
    """The best joint coordinates (n,) found for a limb, and by how much they are better than its own.

    Parameters
    ----------
    performer, pose, coarse : the body and the frame.
    limb : one of `LIMBS`.
    shapes : (C, n) poses to begin with.
    rng : of what is drawn about the best.
    """
    limits = performer.limits[6 + limb.columns]
    some = np.clip(np.concatenate((pose.joints[limb.columns][None], shapes)), *limits.T)
    drawn = draws(rng, limb, ROUNDS, min(ELITE, len(some)), DRAWN)
    found = limb_search(performer, pose, limb, some, coarse, drawn)
    return found.best, float(found.costs[0] - found.price)


def _hints(
    performer: Performer, pose: Pose, limb: Limb, detection: Detection | None, verdict: Verdict | None, least: float
) -> Floats:
    root, (middle, end) = limb.begin, limb.landmarks
    at = landmarks(performer, pose)
    length = np.linalg.norm(at[end] - at[middle]) + np.linalg.norm(at[middle] - at[root])
    goals = []
    if detection is not None:
        for k, i in (limb.landmarks, opposite(limb).landmarks):
            for place, sure in zip(detection.places[i], detection.strength[i], strict=True):
                if sure > 0.2:
                    goals.append((place, detection.joints[k] if detection.confidence[k] > 0.3 else None))
    if verdict is not None and len(verdict.loose):
        # Of the points that nothing explains and that the limb can reach, the one farthest out is its end.
        gap = np.linalg.norm(verdict.loose - at[root], axis=1)
        within = gap < 1.15 * length
        if within.any():
            goals.append((verdict.loose[within][np.argmax(gap[within])] + np.array([0.0, 0.0, 0.03]), None))
    free = np.zeros(DOFS, bool)
    free[6 + limb.columns] = True
    found = []
    for goal, between in goals[:3]:
        if np.linalg.norm(goal - at[root]) > 1.4 * length or np.linalg.norm(goal - at[end]) < least:
            continue
        targets, weights = np.full((len(LANDMARKS), 3), np.nan), np.ones(len(LANDMARKS))
        targets[end] = goal
        if between is not None:
            targets[middle], weights[middle] = between, 0.5
        found.append(reach(performer, pose, targets, weights, free, rounds=7)[0].joints[limb.columns])
    return np.array(found).reshape(-1, len(limb.columns))
