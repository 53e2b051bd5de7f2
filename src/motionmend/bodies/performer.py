"""The performer that is followed: 15 bones, 34 degrees of freedom, and a pose of it (section 3.2.1).

Every bone has axes of its own: while the performer stands upright with hanging arms and palms to the thighs, those of
all bones point the same way, x to the performer's left, y up, z forward. Limbs lie along -y, feet along z.
"""

from dataclasses import dataclass, field
from functools import cache, cached_property
from typing import final

import numpy as np

from ..arrays import Bools, Floats, Ints, frozen
from ..errors import MismatchError
from ..kernels.body import Chain, Posed
from .solids import CONE, Solids

BONES = (
    "pelvis",
    "chest",
    "head",
    "l_clavicle",
    "r_clavicle",
    "l_upperarm",
    "l_forearm",
    "r_upperarm",
    "r_forearm",
    "l_thigh",
    "l_shank",
    "l_foot",
    "r_thigh",
    "r_shank",
    "r_foot",
)
PARENTS = frozen((-1, 0, 1, 1, 1, 3, 5, 4, 7, 0, 9, 10, 0, 12, 13), np.int64)
MIRROR = frozen((0, 1, 2, 4, 3, 7, 8, 5, 6, 12, 13, 14, 9, 10, 11), np.int64)
"""The same bone of the other side."""
LANDMARKS = (
    "pelvis",
    "chest",
    "neck",
    "head",
    "l_shoulder",
    "l_elbow",
    "l_wrist",
    "r_shoulder",
    "r_elbow",
    "r_wrist",
    "l_hip",
    "l_knee",
    "l_ankle",
    "r_hip",
    "r_knee",
    "r_ankle",
)
OTHER_SIDE = frozen((0, 1, 2, 3, 7, 8, 9, 4, 5, 6, 13, 14, 15, 10, 11, 12), np.int64)
"""The same landmark of the other side."""
LANDMARK_BONES = frozen((0, 1, 2, 2, 5, 6, 6, 7, 8, 8, 9, 10, 11, 12, 13, 14), np.int64)
TIPS = ("crown", "l_hand", "r_hand", "l_toe", "r_toe")
"""The far ends of head, hands and feet; the hands are stiff with the forearms."""
TIP_BONES = frozen((2, 6, 8, 11, 14), np.int64)

_X, _Y, _Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
_BACK = (-1.0, 0.0, 0.0)  # about -x a hanging forearm rises to the front
# What turns each bone against its parent: balls three axes, clavicles up-down and to-and-fro, hinges one.
_TURNS: dict[str, tuple[tuple[float, float, float], ...]] = {
    "chest": (_X, _Y, _Z),
    "head": (_X, _Y, _Z),
    "clavicle": (_Y, _Z),
    "upperarm": (_X, _Y, _Z),
    "forearm": (_BACK,),
    "thigh": (_X, _Y, _Z),
    "shank": (_X,),
    "foot": (_X,),
}
TRANSLATION, FREE, BALL, HINGE = 0, 1, 2, 3


def _axes() -> tuple[Ints, Floats]:
    """(B + 1,) where each bone's coordinates begin, (28, 3) their axes."""
    first = [0]
    axes: list[tuple[float, float, float]] = []
    for bone in BONES:
        axes += _TURNS.get(bone.split("_")[-1], ())
        first.append(len(axes))
    return frozen(first, np.int64), frozen(axes)


def _moves() -> Bools:
    """(B, 34) which degrees of freedom move which bone."""
    moves = np.zeros((len(BONES), 6 + len(AXES)), dtype=bool)
    moves[:, :6] = True
    for bone in range(1, len(BONES)):
        moves[bone] |= moves[PARENTS[bone]]
        moves[bone, 6 + FIRST[bone] : 6 + FIRST[bone + 1]] = True
    return frozen(moves, np.bool_)


def _rests() -> Floats:
    """(B, 3, 3) parent from bone half way through each joint's range, where its rotation vector is 0."""
    rests = np.tile(np.eye(3), (len(BONES), 1, 1))
    for side, sign in (("l", 1.0), ("r", -1.0)):
        # Arms go from behind the back to over the head: half way they point sideways, forward and 45 degrees down.
        arm = _turn(_Y, -sign * 35.0) @ _turn(_Z, sign * 45.0)
        rests[BONES.index(f"{side}_upperarm")] = arm
        rests[BONES.index(f"{side}_thigh")] = _turn(_Z, sign * 10.0) @ _turn(_X, -40.0)
    return frozen(rests)


def _turn(axis: tuple[float, float, float], degrees: float) -> Floats:
    return rotation(np.array(axis) * np.radians(degrees))


def rotation(vector: Floats) -> Floats:
    """Rotations (..., 3, 3) about vectors (..., 3) by their lengths in rad."""
    vector = np.asarray(vector, dtype=np.float64)
    angle = np.linalg.norm(vector, axis=-1)[..., None, None]
    x, y, z = np.moveaxis(vector, -1, 0)
    zero = np.zeros_like(x)
    cross = np.stack((zero, -z, y, z, zero, -x, -y, x, zero), axis=-1).reshape(*x.shape, 3, 3)
    return np.asarray(
        np.eye(3) + np.sinc(angle / np.pi) * cross + 0.5 * np.sinc(angle / 2 / np.pi) ** 2 * cross @ cross
    )


def rotation_vector(rotations: Floats) -> Floats:
    """The vectors (..., 3), shorter than pi, that turn as rotations (..., 3, 3) do."""
    from scipy.spatial.transform import Rotation

    rotations = np.array(rotations, dtype=np.float64)  # a copy: older SciPy wants to be able to write
    return np.asarray(Rotation.from_matrix(rotations.reshape(-1, 3, 3)).as_rotvec().reshape(rotations.shape[:-1]))


FIRST, AXES = _axes()
MOVES = _moves()
RESTS = _rests()
DOFS = 6 + len(AXES)
DOF_BONES = frozen([0] * 6 + [b for b in range(len(BONES)) for _ in range(FIRST[b], FIRST[b + 1])], np.int64)
DOF_AXES = frozen([_X, _Y, _Z, _X, _Y, _Z, *AXES])
DOF_KINDS = frozen(
    [TRANSLATION] * 3 + [FREE] * 3 + [HINGE if FIRST[b + 1] - FIRST[b] == 1 else BALL for b in DOF_BONES[6:]], np.uint8
)
DOF_NAMES = (
    *(f"pelvis.{channel}" for channel in ("tx", "ty", "tz", "rx", "ry", "rz")),
    *(f"{BONES[b]}.{'xyz'[int(np.abs(a).argmax())]}" for b, a in zip(DOF_BONES[6:], AXES, strict=True)),
)
# Degrees each joint coordinate may go either way: the anatomical range with what the shared rotation vector adds to it.
_RANGES: dict[str, tuple[tuple[float, float], ...]] = {
    "chest": ((-50, 90), (-70, 70), (-55, 55)),
    "head": ((-75, 75), (-90, 90), (-60, 60)),
    "clavicle": ((-35, 35), (-30, 50)),
    "upperarm": ((-140, 140), (-155, 155), (-140, 140)),
    "forearm": ((-10, 160),),
    "thigh": ((-105, 85), (-80, 80), (-70, 70)),
    "shank": ((-10, 165),),
    "foot": ((-70, 75),),
}


def _limits() -> Floats:
    """(34, 2) rad; right sides mirrored: what turns about y or z turns the other way."""
    limits = np.full((DOFS, 2), (-np.inf, np.inf))
    for d in range(6, DOFS):
        bone = BONES[DOF_BONES[d]]
        low, high = _RANGES[bone.split("_")[-1]][d - 6 - FIRST[DOF_BONES[d]]]
        flips = bone.startswith("r_") and DOF_KINDS[d] == BALL and DOF_AXES[d, 0] == 0.0
        limits[d] = (-high, -low) if flips else (low, high)
    return frozen(np.radians(limits))


LIMITS = _limits()


@final
@dataclass(frozen=True, eq=False)
class Performer:
    """One person: how long and how wide the 15 bones are. The joints and their axes are the same for everybody.

    Attributes
    ----------
    offsets : (15, 3) m, where each bone begins in its parent's axes; the pelvis bone begins at the root, (0, 0, 0).
    landmark_place : (16, 3) m, the joints of `LANDMARKS` in the axes of the bones `LANDMARK_BONES`.
    tip_place : (5, 3) m, the points of `TIPS` in the axes of the bones `TIP_BONES`.
    solids : the surface.
    limits : (34, 2) rad, of the degrees of freedom; -inf and inf for the root.
    """

    offsets: Floats
    landmark_place: Floats
    tip_place: Floats
    solids: Solids
    limits: Floats = field(default_factory=lambda: LIMITS)

    bones = BONES
    moves = MOVES
    landmark_bone = LANDMARK_BONES

    def __post_init__(self) -> None:
        shapes = {"offsets": (len(BONES), 3), "landmark_place": (len(LANDMARKS), 3), "tip_place": (len(TIPS), 3)}
        for name, shape in {**shapes, "limits": (DOFS, 2)}.items():
            object.__setattr__(self, name, frozen(getattr(self, name)))
            if getattr(self, name).shape != shape:
                raise MismatchError(f"a performer's {name} must be {shape}, came {getattr(self, name).shape}")

    @cached_property
    def chain(self) -> Chain:
        """Copies of what its bones are, as kernels take them."""
        return Chain(PARENTS.copy(), self.offsets.copy(), RESTS.copy(), FIRST.copy(), AXES.copy())

    @cached_property
    def marks(self) -> tuple[Ints, Floats]:
        """Copies of `LANDMARK_BONES` (16,) and `landmark_place` (16, 3) m, as kernels take points."""
        return LANDMARK_BONES.copy(), self.landmark_place.copy()

    @cached_property
    def trunk_and_forearms(self) -> tuple[Ints, Ints]:
        """Which solids are the trunk, (S,), and which are the forearms' cones, (L,), the left one first."""
        bones, cones = self.solids.bone, self.solids.kind == CONE
        trunk = bones <= BONES.index("chest")  # the pelvis is the only one before it
        left, right = (np.flatnonzero(cones & (bones == BONES.index(f"{side}_forearm"))) for side in "lr")
        return np.flatnonzero(trunk), np.concatenate((left, right))

    @cached_property
    def lengths(self) -> Floats:
        """(15,) m: how far it is along each bone to what hangs on its end; the pelvis's is the distance of the hips."""
        place = self.landmark_place
        ends = {
            "pelvis": self.offsets[BONES.index("l_thigh")] - self.offsets[BONES.index("r_thigh")],
            "chest": place[1],
            "head": place[3],
        }
        for side, toe in (("l", 3), ("r", 4)):
            ends[f"{side}_clavicle"] = self.offsets[BONES.index(f"{side}_upperarm")]
            ends[f"{side}_upperarm"] = self.offsets[BONES.index(f"{side}_forearm")]
            ends[f"{side}_forearm"] = place[LANDMARKS.index(f"{side}_wrist")]
            ends[f"{side}_thigh"] = self.offsets[BONES.index(f"{side}_shank")]
            ends[f"{side}_shank"] = self.offsets[BONES.index(f"{side}_foot")]
            ends[f"{side}_foot"] = self.tip_place[toe]
        return frozen([np.linalg.norm(ends[bone]) for bone in BONES])

    def stretched(self, stretch: Floats) -> "Performer":
        """Another person: every bone, with all that is fixed to it, stretched along its own axes.

        Parameters
        ----------
        stretch : (15, 3) factors along x, y and z of each bone, or what broadcasts to it. For arms and legs y is the
            length, x and z the widths; for pelvis and chest x is the breadth, z the depth. Joints fixed to a bone (the
            shoulder to the clavicle, the hip to the pelvis) move along.

        Raises
        ------
        MismatchError : factors that are not finite and above 0.
        """
        factor = np.broadcast_to(np.asarray(stretch, dtype=np.float64), (len(BONES), 3))
        if not (np.isfinite(factor).all() and (factor > 0).all()):
            raise MismatchError("bones are stretched by finite factors above 0")
        carrier = np.where(PARENTS >= 0, PARENTS, 0)
        return Performer(
            offsets=self.offsets * factor[carrier],
            landmark_place=self.landmark_place * factor[LANDMARK_BONES],
            tip_place=self.tip_place * factor[TIP_BONES],
            solids=self.solids.stretched(factor),
            limits=self.limits,
        )


@final
@dataclass(frozen=True, eq=False)
class Pose:
    """Where a performer is and how every joint is turned.

    Attributes
    ----------
    translation : (3,) m, of the root.
    root : (3, 3), world from pelvis.
    joints : (28,) rad: of each bone but the pelvis the components of its rotation vector about the rest of `RESTS`, or
        its hinge's angle, in the order of `AXES`.
    """

    translation: Floats
    root: Floats
    joints: Floats

    def __post_init__(self) -> None:
        for name, shape in (("translation", (3,)), ("root", (3, 3)), ("joints", (len(AXES),))):
            object.__setattr__(self, name, frozen(getattr(self, name)))
            if getattr(self, name).shape != shape:
                raise MismatchError(f"a pose's {name} must be {shape}, came {getattr(self, name).shape}")

    @property
    def arrays(self) -> Posed:
        """Copies of translation, root and joints, as kernels take them."""
        return Posed(self.translation.copy(), self.root.copy(), self.joints.copy())


@final
@dataclass(frozen=True, eq=False)
class Poses:
    """T poses of one performer: `translation` (T, 3) m, `root` (T, 3, 3), `joints` (T, 28) rad, as in `Pose`."""

    translation: Floats
    root: Floats
    joints: Floats

    def __post_init__(self) -> None:
        count = len(self.translation)
        for name, shape in (("translation", (count, 3)), ("root", (count, 3, 3)), ("joints", (count, len(AXES)))):
            object.__setattr__(self, name, frozen(getattr(self, name)))
            if getattr(self, name).shape != shape:
                raise MismatchError(f"{count} poses' {name} must be {shape}, came {getattr(self, name).shape}")

    def __len__(self) -> int:
        return len(self.translation)

    def __getitem__(self, frame: int) -> Pose:
        return Pose(self.translation[frame], self.root[frame], self.joints[frame])

    def some(self, frames: Ints | slice) -> "Poses":
        """The poses at some frames."""
        return Poses(self.translation[frames], self.root[frames], self.joints[frames])

    def moved(self, turn: Floats, shift: Floats) -> "Poses":
        """The same poses seen from elsewhere: every point x becomes turn · x + shift."""
        return Poses(self.translation @ turn.T + shift, turn @ self.root, self.joints)


FACING = frozen(np.diag((1.0, -1.0, -1.0)))
"""Camera from pelvis of a performer who stands upright before a level camera and looks at it."""


def standing(translation: Floats | tuple[float, float, float] = (0.0, 0.0, 3.0), root: Floats = FACING) -> Pose:
    """Upright with hanging arms; unless told otherwise 3 m before the camera and facing it."""
    return Pose(np.asarray(translation, dtype=np.float64), root, _hanging())


@cache
def _hanging() -> Floats:
    """(28,) rad of who stands upright: balls have the axes x, y, z, and their rests undone."""
    joints = np.zeros(len(AXES))
    for bone in range(1, len(BONES)):
        if FIRST[bone + 1] - FIRST[bone] == 3:
            joints[FIRST[bone] : FIRST[bone + 1]] = rotation_vector(RESTS[bone].T)
    return frozen(joints)


def advance(performer: Performer, pose: Pose, delta: Floats) -> Pose:
    """The pose after an increment (34,) of its degrees of freedom: m, then rad.

    The root is turned from the left, exp(delta[3:6]) · root, about its own place in world axes; all else is added to.
    Limits are not looked at.
    """
    from ..kernels import articulated

    posed = pose.arrays
    articulated.advance(posed, np.ascontiguousarray(delta, dtype=np.float64))
    return Pose(*posed)


def bone_frames(performer: Performer, pose: Pose) -> Floats:
    """World from bone, (15, 4, 4)."""
    from ..kernels import articulated

    placed = np.empty((len(BONES), 4, 4))
    articulated.frames(performer.chain, pose.arrays, placed)
    return placed


def twists(performer: Performer, pose: Pose) -> Floats:
    """How every degree of freedom moves what it carries, (34, 6): angular velocity ω and velocity v of the origin.

    A point x on a bone that the degree of freedom moves (`performer.moves`) goes at ω x x + v, world axes.
    """
    from ..kernels import articulated

    moving = np.empty((DOFS, 6))
    articulated.twists(performer.chain, pose.joints.copy(), bone_frames(performer, pose), moving)
    return moving


def landmarks(performer: Performer, pose: Pose) -> Floats:
    """World places (16, 3) in m of the joints of `LANDMARKS`."""
    return _points(performer, pose, LANDMARK_BONES, performer.landmark_place)


def tips(performer: Performer, pose: Pose) -> Floats:
    """World places (5, 3) in m of the points of `TIPS`."""
    return _points(performer, pose, TIP_BONES, performer.tip_place)


def _points(performer: Performer, pose: Pose, bones: Ints, local: Floats) -> Floats:
    from ..kernels import articulated

    world = np.empty((len(bones), 3))
    articulated.points(bone_frames(performer, pose), bones, local, world)
    return world
