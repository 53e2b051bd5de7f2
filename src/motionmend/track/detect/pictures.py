"""Synthetic pictures to learn from: people of many sizes, in any pose and heading, before any camera."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from ...arrays import Floats, Singles
from ...bodies.camera import KINECT, Camera
from ...bodies.performer import (
    BONES,
    DOF_AXES,
    FIRST,
    LANDMARKS,
    LIMITS,
    MIRROR,
    OTHER_SIDE,
    Performer,
    Pose,
    Poses,
    landmarks,
    rotation,
)
from ...bodies.surface import render
from ..person.foreground import clean

BELOW = 0.35  # m, a pelvis below the image's border at most

_ENDS = {
    "pelvis": ("pelvis", "_hip"),
    "chest": ("pelvis", "chest"),
    "head": ("neck", "head"),
    "clavicle": ("chest", "_shoulder"),
    "upperarm": ("_shoulder", "_elbow"),
    "forearm": ("_elbow", "_wrist"),
    "thigh": ("_hip", "_knee"),
    "shank": ("_knee", "_ankle"),
    "foot": ("_ankle",),
}


def _joints_of_bones() -> NDArray[np.bool_]:
    """(15, 16) the joints whose parts a bone's pixels may be."""
    table = np.zeros((len(BONES), len(LANDMARKS)), bool)
    for b, bone in enumerate(BONES):
        for end in _ENDS[bone.split("_")[-1]]:
            sides = (bone[0],) if "_" in bone else ("l", "r")
            for name in [side + end for side in sides] if end.startswith("_") else [end]:
                table[b, LANDMARKS.index(name)] = True
    return table


JOINTS_OF_BONES = _joints_of_bones()


@final
@dataclass(frozen=True, eq=False)
class Picture:
    """One synthetic person: cleaned depth, some pixels and the parts they are of, joints.

    Left and right are those of the picture, as of someone who faces the camera: for one who does not
    (`facing` False) the names are swapped, since from the back the same outline is seen.

    Attributes
    ----------
    depth : (H, W) float32 m.
    pixels : (N, 2) int32 row and column.
    parts : (N,) int64 in 0..15, the joint that each pixel is nearest to among those of its bone.
    joints : (16, 3) m in camera axes.
    facing : whether the pelvis faces the camera.
    """

    depth: Singles
    pixels: NDArray[np.int32]
    parts: NDArray[np.int64]
    joints: Floats
    facing: bool


def _columns(*names: str) -> tuple[NDArray[np.int64], ...]:
    """Joint coordinates of a limb's bones, left and right."""
    sides = [[BONES.index(f"{side}_{name}") for name in names] for side in "lr"]
    return tuple(np.concatenate([np.arange(FIRST[b], FIRST[b + 1]) for b in bones]) for bones in sides)


_ARMS, _LEGS = _columns("clavicle", "upperarm", "forearm"), _columns("thigh", "shank", "foot")


def mixed(poses: Poses, rng: np.random.Generator) -> Pose:
    """A pose with limbs of its own: of other poses, of the other side, or anywhere at all; leaning now and then.

    Recordings hold few of the things that people do. Two arms in three and one leg in three are exchanged, and a
    third of the bodies lean, by up to about a right angle, any way.
    """
    pose = poses[int(rng.integers(len(poses)))]
    joints, root = np.array(pose.joints), pose.root
    for limbs, kept, anywhere in ((_ARMS, 0.33, 0.25), (_LEGS, 0.67, 0.08)):
        for side in (0, 1):
            way = rng.uniform()
            if way < kept:
                continue
            if way < 1.0 - anywhere:
                source = int(rng.integers(2))
                limb = np.array(poses[int(rng.integers(len(poses)))].joints[limbs[source]])
                if source != side:
                    limb *= np.where(np.abs(DOF_AXES[6:][limbs[side], 0]) > 0.5, 1.0, -1.0)
            else:
                low, high = LIMITS[6:][limbs[side]].T
                limb = rng.uniform(low, high) * rng.uniform(0.2, 0.8)
            joints[limbs[side]] = limb
    if rng.uniform() < 0.33:
        way = rng.uniform(0.0, 2.0 * np.pi)
        root = rotation(rng.uniform(0.0, 1.4) * np.array([np.cos(way), 0.0, np.sin(way)])) @ root
    return Pose(pose.translation, root, joints)


def varied(performer: Performer, rng: np.random.Generator) -> Performer:
    """Someone else: all lengths by up to a tenth, every bone by a few percent, widths by up to a quarter."""
    size, wide = np.exp(rng.normal(0.0, 0.06)), np.exp(rng.normal(0.0, 0.10))
    stretch = np.exp(rng.normal(0.0, (0.06, 0.03, 0.06), (len(BONES), 3))) * size * np.array([wide, 1.0, wide])
    return performer.stretched(np.sqrt(stretch * stretch[MIRROR]))


def viewed(pose: Pose, rng: np.random.Generator, camera: Camera, *, cut_off: bool = False) -> Pose:
    """The pose with any heading, before a camera up to 25 degrees off the level.

    It is 1.3 to 4.5 m away; when `cut_off` nearer, and the border below cuts it somewhere from the knees to the chest.
    """
    heading, pitch, roll = rng.uniform(0.0, 2.0 * np.pi), rng.normal(0.0, 0.17), rng.normal(0.0, 0.04)
    near, far = (0.7, 2.2) if cut_off else (1.3, 4.5)
    distance = near * (far / near) ** rng.uniform()
    tilt = rotation(np.array([0.0, 0.0, roll])) @ rotation(np.array([np.clip(pitch, -0.45, 0.45), 0.0, 0.0]))
    turn = tilt @ rotation(np.array([0.0, heading, 0.0]))
    u = rng.normal(0.5, 0.15) * camera.width
    if cut_off:
        v = rng.uniform(0.75, 1.0 + BELOW * camera.fy / distance / camera.height) * camera.height
    else:
        v = rng.normal(0.5, 0.12) * camera.height
    place = np.array([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0]) * distance
    return Pose(place, turn @ pose.root, pose.joints)


def pictures(
    poses: Poses, performers: Sequence[Performer], count: int, seed: int, *, cut_off: bool = False
) -> Iterator[Picture]:
    """`count` pictures of random poses of varied people; the same seed gives the same ones.

    Parameters
    ----------
    poses : T poses in camera axes, y down; only what stands above what matters, headings are drawn anew.
    performers : the people that are varied.
    cut_off : whether the image's border cuts them off below, as at a desk.
    """
    rng = np.random.default_rng(seed)
    made = 0
    while made < count:
        performer = varied(performers[int(rng.integers(len(performers)))], rng)
        pose = mixed(poses, rng)
        for _ in range(3):  # seen from a few sides: a new body costs more than a new picture
            picture = pictured(performer, viewed(pose, rng, KINECT, cut_off=cut_off), rng)
            if picture is not None and made < count:
                made += 1
                yield picture


def pictured(
    performer: Performer, pose: Pose, rng: np.random.Generator, least: int = 300, some: int = 400
) -> Picture | None:
    """One picture with the noise of a depth camera, cleaned; None when fewer than `least` pixels show the person."""
    drawn = render(performer, pose, KINECT)
    seen = np.isfinite(drawn.depth)
    if seen.sum() < least:
        return None
    joints = landmarks(performer, pose)
    facing = bool((pose.root[:, 2] @ pose.translation) < 0.0)
    depth = np.full(seen.shape, np.nan, np.float32)
    z = drawn.depth[seen].astype(np.float64)
    sigma = 0.0012 + 0.0019 * (z - 0.4) ** 2  # axial noise of a structured-light camera (Nguyen et al. 2012)
    depth[seen] = np.where(rng.uniform(size=len(z)) < 0.01, np.nan, z + rng.normal(0.0, sigma))
    depth = clean(depth)
    every = np.argwhere(seen & np.isfinite(depth))
    pixels = every[rng.permutation(len(every))[:some]].astype(np.int32)
    rows, columns = pixels.T
    points = KINECT.unproject(pixels[:, ::-1], drawn.depth[rows, columns])
    gap = ((points[:, None] - joints) ** 2).sum(axis=2)
    gap[~JOINTS_OF_BONES[drawn.bones[rows, columns]]] = np.inf
    parts = gap.argmin(axis=1)
    if not facing:
        joints, parts = joints[OTHER_SIDE], OTHER_SIDE[parts]
    return Picture(depth, pixels, parts, joints, facing)
