"""The performer of a sensor's joints, its poses from them, and its joints under a sensor's names."""

from collections.abc import Sequence

import numpy as np

from ..arrays import Bools, Floats
from ..errors import MismatchError
from . import anatomy
from .joint_sets import correspondence
from .performer import (
    AXES,
    BONES,
    DOFS,
    LANDMARKS,
    MOVES,
    Performer,
    Pose,
    Poses,
    landmarks,
    standing,
)
from .postures import Postures
from .templates import Retargeted

# Sensors put hips, pelvis and head elsewhere than CMU does, by centimetres and always the same way; limbs agree.
_TRUST = {"pelvis": 0.3, "chest": 0.5, "neck": 0.3, "head": 0.3, "l_hip": 0.5, "r_hip": 0.5}
_TRUNK = [LANDMARKS.index(name) for name in ("pelvis", "chest", "l_shoulder", "r_shoulder", "l_hip", "r_hip")]
HOLD = 0.02  # m of miss that weigh as much as one radian away from the frame before
ASTRAY = 0.10  # m; when joints are missed by more on average, the frame is begun anew
ROUNDS = 20
# Each bone's length as the distance between two joints: what its own stretch along y, or x, is to make right.
_SPANS = (
    ("upperarm", 1, "shoulder", "elbow"),
    ("forearm", 1, "elbow", "wrist"),
    ("thigh", 1, "hip", "knee"),
    ("shank", 1, "knee", "ankle"),
)
_TRUNK_SPANS: tuple[tuple[tuple[str, ...], int, tuple[str, ...], tuple[str, ...]], ...] = (
    (("pelvis", "chest"), 1, ("l_shoulder", "r_shoulder"), ("l_hip", "r_hip")),
    (("l_clavicle", "r_clavicle"), 0, ("l_shoulder",), ("r_shoulder",)),
)


def performer_of_joints(postures: Postures) -> Performer:
    """An average adult with the median lengths of a sensor's limbs and trunk, both sides alike, and of its size.

    Raises
    ------
    MismatchError : joints without an arm or leg that is seen whole in any frame.
    """
    place = _as_landmarks(postures)
    average = anatomy.average()
    rest = landmarks(average, standing())
    stretch = np.ones((len(BONES), 3))
    ratios = []
    for bone, axis, begin, end in _SPANS:
        sides = [(LANDMARKS.index(f"{side}_{begin}"), LANDMARKS.index(f"{side}_{end}")) for side in "lr"]
        seen = np.concatenate([np.linalg.norm(place[:, a] - place[:, b], axis=1) for a, b in sides])
        if not np.isfinite(seen).any():
            raise MismatchError(f"a performer needs joints at both ends of the {bone}, these have none")
        ratio = float(np.nanmedian(seen) / np.mean([np.linalg.norm(rest[a] - rest[b]) for a, b in sides]))
        ratios.append(ratio)
        for side in "lr":
            stretch[BONES.index(f"{side}_{bone}"), axis] = ratio
    size = float(np.median(ratios))
    for b, bone in enumerate(BONES):
        limb = bone.split("_")[-1] in {name for name, *_ in _SPANS}
        stretch[b] *= np.array([size, 1.0, size]) if limb else size
    for bones, axis, above, below in _TRUNK_SPANS:
        spans = [np.linalg.norm(_middle(p, above) - _middle(p, below), axis=1) for p in (place, rest[None])]
        if np.isfinite(spans[0]).any():
            for bone in bones:
                stretch[BONES.index(bone), axis] = float(np.nanmedian(spans[0]) / spans[1][0])
    return average.stretched(stretch)


def poses_of_joints(postures: Postures, performer: Performer) -> Retargeted:
    """The poses in which the performer's joints lie nearest to a sensor's, frame by frame.

    Parameters
    ----------
    postures : T frames of any joints whose meanings are known, right-handed axes (x right, y up, z to the viewer, or
        the camera's own). Mirrored axes are not found out here: elbows and knees that bend the wrong way fit worse.
    performer : its lengths are kept.

    Returns
    -------
    Retargeted : poses in the postures' axes, NaN in frames with fewer than six joints; the distances of the 16 joints,
        NaN where the sensor has none.
    """
    from ..kernels import articulated

    place = _as_landmarks(postures)
    trust = np.array([_TRUST.get(name, 1.0) for name in LANDMARKS])
    hold = np.full(DOFS, HOLD)
    hold[:6] = 1e-4
    translation, root = np.full((len(place), 3), np.nan), np.full((len(place), 3, 3), np.nan)
    joints = np.full((len(place), len(AXES)), np.nan)
    error = np.full(place.shape[:2], np.nan)
    moves, limits = MOVES.copy(), performer.limits.copy()  # as kernels take arrays
    last: Pose | None = None
    for t, wanted in enumerate(place):
        seen = np.isfinite(wanted).all(axis=1)
        if seen.sum() < 6:
            last = None
            continue
        least = np.inf
        begun = [pose for pose in (last, _upright(performer, wanted, seen)) if pose is not None]
        for pose in begun:
            posed = pose.arrays
            articulated.reach(
                performer.chain,
                moves,
                *performer.marks,
                wanted,
                trust * seen,
                hold,
                limits,
                ROUNDS,
                posed,
            )
            reached = Pose(*posed)
            missed = np.linalg.norm(landmarks(performer, reached) - wanted, axis=1)
            if float(np.nanmean(missed)) < least:
                least = float(np.nanmean(missed))
                (translation[t], root[t], joints[t]), error[t], last = posed, missed, reached
            if least < ASTRAY:
                break
    return Retargeted(Poses(translation, root, joints), error)


def joints_of_poses(poses: Poses, performer: Performer, names: Sequence[str], times: Floats) -> Postures:
    """The performer's joints as a sensor names them; NaN for joints that are none of the performer's 16.

    Parameters
    ----------
    poses : T poses, NaN where nobody was seen.
    names : (J,) the sensor's.
    times : (T,) s.
    """
    place = np.full((len(poses), len(LANDMARKS), 3), np.nan)
    for t in range(len(poses)):
        if np.isfinite(poses.translation[t]).all() and np.isfinite(poses.joints[t]).all():
            place[t] = landmarks(performer, poses[t])
    found = correspondence(LANDMARKS, names)
    return Postures(tuple(names), np.where((found >= 0)[:, None], place[:, found], np.nan), times)


def _as_landmarks(postures: Postures) -> Floats:
    """(T, 16, 3) m, the sensor's joints as the performer's; NaN where it has none."""
    found = correspondence(postures.names, LANDMARKS)
    return np.ascontiguousarray(np.where((found >= 0)[:, None], postures.positions[:, found], np.nan))


def _middle(place: Floats, names: tuple[str, ...]) -> Floats:
    """(T, 3) m, half way between joints of (T, 16, 3)."""
    return np.asarray(place[:, [LANDMARKS.index(name) for name in names]].mean(axis=1))


def _upright(performer: Performer, wanted: Floats, seen: Bools) -> Pose | None:
    """A standing pose turned and moved to where the trunk's joints are (Kabsch 1976); None with fewer than three."""
    known = [j for j in _TRUNK if seen[j]]
    if len(known) < 3:
        return None
    upright = standing((0.0, 0.0, 0.0), np.eye(3))
    own, theirs = landmarks(performer, upright)[known], wanted[known]
    middle, goal = own.mean(axis=0), theirs.mean(axis=0)
    u, _, v = np.linalg.svd((theirs - goal).T @ (own - middle))
    turn = u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ v))]) @ v
    return Pose(goal - turn @ middle, turn, upright.joints)
