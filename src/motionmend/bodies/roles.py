"""Which joint of a skeleton is which part of the body."""

from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np

from ..arrays import Floats
from ..errors import MismatchError
from .feet import Feet, first_child, foot_joints, named_sides, upwards
from .skeleton import ROTATION, Skeleton, rest_positions

# An elbow is where the lower arm begins. CMU's `wrist` lies half way down the forearm: the hand begins at `hand` there.
SHOULDERS = ("humerus", "upperarm", "uparm", "shldr", "arm", "shoulder")
ELBOWS = ("radius", "elbow", "forearm", "lowerarm", "lowarm")
WRISTS = ("wrist", "hand", "palm")
LONG = 0.2  # of an arm's length: a bone shorter than this is neither upper arm nor forearm


@dataclass(frozen=True)
class Arm:
    """One arm as joint indices; `clavicle` and `tip` are -1 where the skeleton has none."""

    clavicle: int
    shoulder: int
    elbow: int
    wrist: int
    tip: int


@dataclass(frozen=True)
class Roles:
    """The parts of a body as joint indices.

    Attributes
    ----------
    pelvis : the joint that carries both legs and the trunk.
    spine : joints that turn between pelvis and chest, the chest's own (which carries the arms) last.
    chest : the joint that lies at the chest's upper end.
    neck : joints that turn above it, the head's own last.
    head : the joint that the head turns about.
    head_end : (K,) joints at the head's far end.
    arms : left, right.
    feet : the legs.
    guesses : one sentence for each thing the names did not say.
    """

    pelvis: int
    spine: tuple[int, ...]
    chest: int
    neck: tuple[int, ...]
    head: int
    head_end: tuple[int, ...]
    arms: tuple[Arm, Arm]
    feet: Feet
    guesses: tuple[str, ...] = ()


def roles(skeleton: Skeleton) -> Roles:
    """Find the parts of a body by the joints' names, or failing that by the shape of the tree at rest.

    Parameters
    ----------
    skeleton : any human body with two legs, two arms and a head, at rest upright or nearly so.

    Raises
    ------
    MismatchError : a body on which hips, knees, shoulders, elbows or wrists are not found.
    """
    feet = foot_joints(skeleton)
    if min(*feet.hips, *feet.knees, *feet.ankles) < 0:
        raise MismatchError("a performer needs hips, knees and ankles; this skeleton's legs have too few joints")
    pelvis = _common(skeleton, feet.hips)
    guesses = list(feet.guesses)
    head = _head(skeleton, feet)
    wrists = _wrists(skeleton, feet, head, guesses)
    trunk = _common(skeleton, (*wrists, head))
    if pelvis not in upwards(skeleton, trunk):
        pelvis = _common(skeleton, (pelvis, trunk))
    left, right = (_arm(skeleton, side, wrist, trunk) for side, wrist in zip("lr", wrists, strict=True))
    above = [joint for joint in reversed(upwards(skeleton, head)) if trunk in upwards(skeleton, joint)[1:]]
    chest = above[0] if len(above) > 1 else trunk
    spine = [j for j in reversed(upwards(skeleton, trunk)) if pelvis in upwards(skeleton, j)[1:]]
    return Roles(
        pelvis=pelvis,
        spine=tuple(j for j in spine if _turns(skeleton, j)),
        chest=chest,
        neck=tuple(j for j in above if _turns(skeleton, j)),
        head=head,
        head_end=_head_end(skeleton, head),
        arms=(left, right),
        feet=feet,
        guesses=tuple(guesses),
    )


def _turns(skeleton: Skeleton, joint: int) -> bool:
    return bool(np.any(skeleton.dof_kind[skeleton.dofs_of(joint)] == ROTATION))


def _common(skeleton: Skeleton, joints: tuple[int, ...]) -> int:
    """The lowest joint on whose path to the root all lie."""
    shared = set(upwards(skeleton, joints[0]))
    for joint in joints[1:]:
        shared &= set(upwards(skeleton, joint))
    return max(shared, key=lambda joint: len(upwards(skeleton, joint)))


def _head(skeleton: Skeleton, feet: Feet) -> int:
    """The joint named head, or the one below the highest chain end that is not of a leg."""
    for name in ("head", "skull"):
        for joint, spelt in enumerate(skeleton.names):
            if spelt.rsplit(":", 1)[-1].lower().strip("_- ") in (name, f"j{name}"):
                return joint
    height = rest_positions(skeleton) @ skeleton.up
    legs = {j for hip in feet.hips for j in range(len(skeleton.names)) if hip in upwards(skeleton, j)}
    ends = [j for j in range(len(skeleton.names)) if j not in skeleton.parents and j not in legs]
    if not ends:
        raise MismatchError("a performer needs a head; this skeleton has legs only")
    top = max(ends, key=lambda joint: height[joint])
    return int(skeleton.parents[top]) if skeleton.parents[top] >= 0 else top


def _head_end(skeleton: Skeleton, head: int) -> tuple[int, ...]:
    """What marks the head's far end: the child right above it, else all of its children (eyes, say)."""
    below = [int(j) for j in np.flatnonzero(skeleton.parents == head) if np.linalg.norm(skeleton.offsets[j]) > 1e-6]
    if not below:
        return (head,)
    rise = [float(skeleton.offsets[j] @ skeleton.up / np.linalg.norm(skeleton.offsets[j])) for j in below]
    best = int(np.argmax(rise))
    return (below[best],) if rise[best] > 0.9 or len(below) == 1 else tuple(below)


def _named(skeleton: Skeleton, parts: tuple[str, ...], side: str) -> dict[str, int]:
    """The first joint of one side for each of some names."""
    found: dict[str, int] = {}
    for joint, name in enumerate(skeleton.names):
        for where, part in named_sides(name):
            if where == side and part in parts:
                found.setdefault(part, joint)
                break
    return found


def _wrists(skeleton: Skeleton, feet: Feet, head: int, guesses: list[str]) -> tuple[int, int]:
    """The joints at which the hands begin, left and right."""
    wrists = []
    for side in "lr":
        named = _named(skeleton, (*ELBOWS, *WRISTS), side)
        first = WRISTS if "radius" not in named else ("hand", "palm", "wrist")
        wrists.append(next((named[part] for part in first if part in named), -1))
    if min(wrists) >= 0:
        return wrists[0], wrists[1]
    rest = rest_positions(skeleton)
    left = rest[feet.hips[0]] - rest[feet.hips[1]]
    taken = {j for joint in (*feet.hips, head) for j in range(len(skeleton.names)) if joint in upwards(skeleton, j)}
    ends = [j for j in range(len(skeleton.names)) if j not in skeleton.parents and j not in taken]
    for index, sign in enumerate((1.0, -1.0)):
        reach = [(sign * float(rest[j] @ left), -len(upwards(skeleton, j)), j) for j in ends]
        if not reach or max(reach)[0] <= 0:
            raise MismatchError("a performer needs two arms; neither names nor chain ends of this skeleton show them")
        path = upwards(skeleton, max(reach)[2])
        trunk = set(upwards(skeleton, head))
        own = [j for j in path if j not in trunk]
        wrists[index] = _likely_arm(skeleton, own)[2]
    guesses.append(
        "no joint is named as a wrist: the chain ends farthest to the sides are taken as hands, wrists "
        f"'{skeleton.names[wrists[0]]}' and '{skeleton.names[wrists[1]]}'"
    )
    return wrists[0], wrists[1]


def _arm(skeleton: Skeleton, side: str, wrist: int, trunk: int) -> Arm:
    """Shoulder and elbow above a wrist: by name, or as the turning joints with a long bone below them."""
    rest = rest_positions(skeleton)
    path = [j for j in upwards(skeleton, wrist) if j != trunk and trunk in upwards(skeleton, j)]
    named = _named(skeleton, (*ELBOWS, *SHOULDERS), side)
    if not named and not _named(skeleton, WRISTS, side):
        whole = [j for j in upwards(skeleton, _tip(skeleton, wrist, rest)) if trunk in upwards(skeleton, j)[1:]]
        shoulder, elbow, wrist = _likely_arm(skeleton, whole)
        named = {"shoulder": shoulder, "elbow": elbow}
    elbow = next((named[part] for part in ELBOWS if named.get(part, -1) in path[1:]), -1)
    higher = path[path.index(elbow) + 1 :] if elbow >= 0 else path[1:]
    shoulder = next((named[part] for part in SHOULDERS if named.get(part, -1) in higher), -1)
    length = sum(float(np.linalg.norm(rest[a] - rest[b])) for a, b in pairwise(path))
    for joint in path[1:]:
        if not _turns(skeleton, joint):
            continue
        if elbow < 0:
            if np.linalg.norm(rest[joint] - rest[wrist]) > LONG * length:
                elbow = joint
        elif shoulder < 0 and joint in higher and np.linalg.norm(rest[joint] - rest[elbow]) > LONG * length:
            shoulder = joint
        if elbow >= 0 and not higher:
            higher = path[path.index(elbow) + 1 :]
    if elbow < 0 or shoulder < 0:
        raise MismatchError(f"a performer needs shoulders, elbows and wrists; '{skeleton.names[wrist]}' hangs on none")
    over = [j for j in path[path.index(shoulder) + 1 :] if _turns(skeleton, j)]
    return Arm(over[-1] if over else -1, shoulder, elbow, wrist, _tip(skeleton, wrist, rest))


def _likely_arm(skeleton: Skeleton, path: list[int]) -> tuple[int, int, int]:
    """Shoulder, elbow and wrist among the turning joints of a path from the hand's tip up to the trunk.

    Upper arm and forearm are about as long as each other and together two thirds of the way.
    """
    rest = rest_positions(skeleton)
    turning = [j for j in path if _turns(skeleton, j)]
    whole = sum(float(np.linalg.norm(skeleton.offsets[j])) for j in path)
    best, found = np.inf, (-1, -1, -1)
    for wrist, elbow, shoulder in combinations(turning, 3):
        upper = float(np.linalg.norm(rest[shoulder] - rest[elbow]))
        lower = float(np.linalg.norm(rest[elbow] - rest[wrist]))
        if min(upper, lower) > 0.05 * whole:
            miss = np.log(upper / lower / 1.1) ** 2 + np.log((upper + lower) / whole / 0.66) ** 2
            if miss < best:
                best, found = float(miss), (shoulder, elbow, wrist)
    if found[0] < 0:
        raise MismatchError("a performer needs shoulders, elbows and wrists; this skeleton's arms have too few joints")
    return found


def _tip(skeleton: Skeleton, wrist: int, rest: Floats) -> int:
    """The end of the hand farthest from the wrist, -1 where the hand has no length."""
    below = [j for j in range(len(skeleton.names)) if wrist in upwards(skeleton, j)[1:]]
    far = max(below, key=lambda j: float(np.linalg.norm(rest[j] - rest[wrist])), default=-1)
    return far if far >= 0 and np.linalg.norm(rest[far] - rest[wrist]) > 1e-6 else first_child(skeleton, wrist)
