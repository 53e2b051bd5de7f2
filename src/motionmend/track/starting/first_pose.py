"""The first pose, with nothing known of the frame before: from joints, from five of them, or from the image alone.

Several readings of the same joints are kept until the depth has spoken: from the back a person looks as from the
front with left and right changed over, and five joints leave the torso open. Each candidate is judged against the
frame, the best are refined by the tracker's own step, and the one that explains the frame best is taken.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias, final

import numpy as np

from ...arrays import Floats, Ints
from ...bodies.performer import (
    AXES,
    BONES,
    DOF_BONES,
    FIRST,
    LANDMARKS,
    MIRROR,
    Performer,
    Pose,
    landmarks,
    rotation,
)
from ...errors import MismatchError
from ..detect.joints import Detection
from ..frame.observation import Observation
from ..limbs.judge import judge
from .reach import TORSO, fitted, placed, reach, standing_at

FIVE = ("head", "l_wrist", "r_wrist", "l_ankle", "r_ankle")
"""The joints that the dissertation starts from (section 3.3.2)."""
LEVEL = 0.6  # of a surface's long axis up or down, above which it stands rather than lies
THICK = 0.2  # m, a body from front to back
LONG = 1.6  # times as long as wide, as standard deviations, is somebody who is stretched out
_FIVE = np.array([LANDMARKS.index(name) for name in FIVE])

_HINGES = np.isin(DOF_BONES[6:], [b for b, bone in enumerate(BONES) if bone.endswith(("forearm", "shank"))])

Refine: TypeAlias = Callable[[Pose], tuple[Pose, float]]
"""A few steps of the tracker from a pose: where they lead, and a cost that can be compared; smaller is better."""


@final
@dataclass(frozen=True, eq=False)
class Candidate:
    """A pose that may be the first, its cost against the frame and where it came from."""

    pose: Pose
    cost: float
    source: str


def pose_from_joints(performer: Performer, joints: Floats, examples: Floats | None = None) -> tuple[Pose, float]:
    """The pose with its joints at given places, and the distance left (m, root mean square).

    Parameters
    ----------
    performer : whose pose.
    joints : (16, 3) m in camera axes, NaN = not given; three or more.
    examples : (N, 28) rad, poses of a library to begin with as well as from standing.

    Raises
    ------
    MismatchError : fewer than three joints.
    """
    ways = poses_to(performer, joints, np.ones(len(LANDMARKS)), examples, 3)
    return min(ways, key=lambda way: way[1])


def poses_to(
    performer: Performer, joints: Floats, weights: Floats, examples: Floats | None = None, most: int = 3
) -> list[tuple[Pose, float]]:
    """Poses that bring joints to their places, from several beginnings, different ones first.

    With pelvis, chest, shoulders or hips among the joints the torso's place is known and standing is turned to it;
    with five joints at the limbs' ends (section 3.3.2) four headings are tried.

    Parameters
    ----------
    joints, weights : (16, 3) m with NaN = not given, and how much each counts.
    examples : (N, 28) rad, of a library.
    most : how many from the library.

    Raises
    ------
    MismatchError : fewer than three joints.
    """
    joints = np.asarray(joints, dtype=np.float64)
    if joints.shape != (len(LANDMARKS), 3):
        raise MismatchError(f"a start needs joints ({len(LANDMARKS)}, 3), came {joints.shape}")
    weights = np.where(np.isfinite(joints).all(axis=1), weights, 0.0)
    if (weights > 0).sum() < 3:
        raise MismatchError(f"a start needs three joints or more, came {int((weights > 0).sum())}")
    begins = [standing_at(joints, weights, heading, performer) for heading in (0.0, np.pi, 0.5 * np.pi, -0.5 * np.pi)]
    torso = np.zeros(len(LANDMARKS))
    torso[TORSO] = weights[TORSO]
    if (torso > 0).sum() >= 3:
        begins = [placed(performer, begins[0].joints, joints, torso)]
    # Straight elbows and knees do not tell which way to bend.
    begins = [Pose(begin.translation, begin.root, np.where(_HINGES, 0.4, begin.joints)) for begin in begins]
    if examples is not None and len(examples):
        bodies = bodies_of(performer, examples)
        turns, shifts, left = fitted(bodies, joints, weights)
        for i in _different(bodies, left, most):
            begins.append(Pose(shifts[i], turns[i], examples[i]))
    return [reach(performer, begin, joints, weights) for begin in begins]


def bodies_of(performer: Performer, joints: Floats) -> Floats:
    """(N, 16, 3) m, the joints of poses (N, 28) with the root at 0 and upright."""
    from ...kernels import articulated

    world = np.empty((len(joints), len(LANDMARKS), 3))
    articulated.upright(performer.chain, np.array(joints, dtype=np.float64), *performer.marks, world)
    return world


def mirrored(joints: Floats) -> Floats:
    """Joint angles (28,) or (N, 28) of the same poses with left and right changed over."""
    order, sign = _mirror()
    return np.asarray(joints)[..., order] * sign


def candidates(
    performer: Performer, detection: Detection, seen: Observation, examples: Floats | None = None, most: int = 8
) -> list[Candidate]:
    """Poses that the detected joints suggest, for both readings of left and right, the likeliest first.

    Parameters
    ----------
    detection : of this frame.
    seen : the frame, coarse (as fine as `judge.JUDGED`), to judge them by.
    examples : (N, 28) rad of a library, a thousand or so.
    most : how many are returned.
    """
    found: list[Candidate] = []
    for reading, source in ((detection, "front"), (detection.mirrored, "back")):
        sure = np.where(reading.confidence > 0.15, reading.confidence, 0.0) ** 2
        # In a pose that it has hardly met the forest is unsure of what it nevertheless finds.
        every = np.where(np.isfinite(reading.joints[:, 0]), reading.confidence**2 + 0.05, 0.0)
        for weights in (sure, every):
            if (weights > 0).sum() < 3:
                continue
            for pose, _ in poses_to(performer, reading.joints, weights, examples, 2):
                found.append(Candidate(pose, judge(performer, pose, seen).cost, source))
    if not found and np.isfinite(seen.depth).any():
        found = _upright(performer, seen)
    return sorted(found, key=lambda one: one.cost)[:most]


def five_of(joints: Floats) -> Floats:
    """(16, 3) with only the five joints of section 3.3.2 kept, all others NaN."""
    kept = np.full_like(np.asarray(joints, dtype=np.float64), np.nan)
    kept[_FIVE] = joints[_FIVE]
    return kept


def _upright(performer: Performer, seen: Observation) -> list[Candidate]:
    """Standing where the person is, eight headings: all that is left when nothing was detected."""
    poses = _standing(performer, _points(seen).mean(axis=0))
    return [Candidate(pose, judge(performer, pose, seen).cost, "upright") for pose in poses]


def lying(performer: Performer, seen: Observation) -> list[Candidate]:
    """Stretched along the surface's long axis, the head at either end and eight ways to lie; none for who is upright.

    The forest knows people who are upright, and turned by a quarter across the image: not those who lie aslant.
    """
    points = _points(seen)
    if len(points) < len(LANDMARKS):
        return []
    middle = points.mean(axis=0)
    spread, axes = np.linalg.eigh(np.cov((points - middle).T))
    middle[2] += THICK / 2
    axis = axes[:, 2]
    if abs(axis[1]) > LEVEL or spread[2] < (LONG * LONG) * spread[1]:
        return []
    found = []
    for end, source in ((axis, "lying"), (-axis, "lying the other way")):
        across = np.cross([0.0, -1.0, 0.0], end)
        turn = rotation(across / np.linalg.norm(across) * np.arccos(np.clip(-end[1], -1.0, 1.0)))  # up becomes `end`
        for pose in _standing(performer, np.zeros(3)):
            body = landmarks(performer, pose) @ turn.T
            half = 0.5 * (body.min(axis=0) + body.max(axis=0))
            laid = Pose(turn @ pose.translation + middle - half, turn @ pose.root, pose.joints)
            found.append(Candidate(laid, judge(performer, laid, seen).cost, source))
    return found


def _standing(performer: Performer, middle: Floats) -> list[Pose]:
    """Standing with the pelvis at a place (3,) m, eight headings."""
    place = np.full((len(LANDMARKS), 3), np.nan)
    place[LANDMARKS.index("pelvis")] = middle
    weights = np.isfinite(place[:, 0]).astype(np.float64)
    return [standing_at(place, weights, heading, performer) for heading in np.arange(8) * np.pi / 4]


def _points(seen: Observation) -> Floats:
    """(N, 3) m, what is seen of the person."""
    rows, columns = np.nonzero(np.isfinite(seen.depth))
    return seen.camera.unproject(np.column_stack([columns, rows]), seen.depth[rows, columns].astype(np.float64))


def _different(bodies: Floats, left: Floats, most: int) -> list[int]:
    """Indices of bodies with the smallest distances left, each 10 cm or more from those chosen before."""
    chosen: list[int] = []
    for i in np.argsort(left, kind="stable")[:200]:
        if all(np.linalg.norm(bodies[i] - bodies[k], axis=1).mean() > 0.10 for k in chosen):
            chosen.append(int(i))
        if len(chosen) == most:
            break
    return chosen


def _mirror() -> tuple[Ints, Floats]:
    order = np.empty(len(AXES), np.int64)
    for b in range(len(BONES)):
        order[FIRST[b] : FIRST[b + 1]] = np.arange(FIRST[MIRROR[b]], FIRST[MIRROR[b] + 1])
    return order, np.where(np.abs(AXES[:, 0]) > 0.5, 1.0, -1.0)
