"""What the scripts on tracking share: who moves before which camera, a tracker, and how far off it is."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import islice
from pathlib import Path
from time import perf_counter, thread_time

import numpy as np

import motionmend as mm
from motionmend.arrays import Bools, Floats, frozen
from motionmend.bodies.camera import KINECT, DepthFrame
from motionmend.bodies.performer import BONES, LANDMARKS, Performer, Pose, Poses, landmarks
from motionmend.bodies.skeleton import forward
from motionmend.bodies.surface import render
from motionmend.bodies.templates import performer_of, poses_of
from motionmend.evaluate.scenes import Plane, View, behind, performed, room, strange, view
from motionmend.evaluate.sensor import sensed
from motionmend.evaluate.strangers import stranger
from motionmend.track.hindsight.backwards import moment, revised
from motionmend.track.hindsight.smoothing import smoothed
from motionmend.track.model import TrackerModel
from motionmend.track.person.company import told_beforehand
from motionmend.track.person.room import Scene
from motionmend.track.person.standing import looked_at
from motionmend.track.settings import TrackSettings
from motionmend.track.starting.furniture import is_furniture, room_behind
from motionmend.track.state import TrackState
from motionmend.track.tracker import Estimate, start, step

from .common import FPS, motion, reduced

FAR = 15.0  # cm; a joint farther from the truth is lost
LIBRARY = (
    *("02_02", "02_04", "05_02", "05_10", "05_13", "05_14", "05_16", "07_01"),
    *("09_02", "14_33", "16_01", "16_12", "16_18", "135_07"),
)
"""Clips the tracker learns from; none of them is tried."""
ABOUT = (
    "Rendered: CMU motions at 30 Hz before a Kinect of 320 x 240; the clips tried are not in the library. Errors are mean "
    "distances over sixteen joints and all frames."
)


@dataclass(frozen=True)
class Take:
    """Part of a clip before a camera.

    Attributes
    ----------
    name : for tables. clip : of CMU's. first, last : frames at 120 Hz.
    heading : degrees the camera stands beside where the person looks in the first frame.
    """

    name: str
    clip: str
    first: int
    last: int
    heading: float = 0.0


SLOW = Take("slow dance", "05_02", 80, 552)  # 118 frames, as the dissertation's
DANCE = Take("dance", "05_03", 0, 433)  # 109 frames, a fast one
BEND = Take("bend", "02_06", 360, 712, 20.0)  # 88 frames, as the dissertation's
BENDS = tuple(Take("bend", "02_06", 360, 712, heading) for heading in (-70.0, -45.0))  # an arm out of sight
TURN = Take("turn", "16_17", 0, 400)
KICK = Take("kick", "135_04", 200, 520)
SIT = Take("sit", "14_29", 100, 420, 30.0)
PIROUETTE = Take("pirouette", "05_06", 192, 430)  # before it the recorded knee jumps 40 cm in one frame, seven times
DOZEN = (
    DANCE,
    BEND,
    TURN,
    KICK,
    SIT,
    PIROUETTE,
    Take("walk", "02_01", 0, 343),
    Take("walk across", "07_04", 0, 320, 80.0),
    Take("boxing", "02_05", 200, 520),
    Take("jump", "16_02", 0, 320),
    Take("hop", "131_04", 100, 420),
    Take("kicks and punches", "86_01", 600, 920),
)


@dataclass(frozen=True, eq=False)
class Stage:
    """A take in the camera's axes.

    Attributes
    ----------
    motion : on its own skeleton. performer, poses : on the tracker's, with the skeleton's lengths.
    seen : where the camera stands. retargeting : (16,) m, the joints' mean distance from the skeleton's.
    """

    motion: mm.Motion
    performer: Performer
    poses: Poses
    seen: View
    retargeting: Floats

    @property
    def joints(self) -> Floats:
        """(T, 16, 3) m, the truth."""
        return np.array([landmarks(self.performer, self.poses[t]) for t in range(len(self.poses))])


@cache
def stage(mocap: Path, take: Take) -> Stage:
    """A take before a level camera that keeps all of it in view."""
    whole = motion(mocap, take.clip)
    clip = reduced(mm.Motion(whole.skeleton, whole.q[take.first : take.last], whole.fps), FPS)
    performer = performer_of(clip.skeleton)
    found = poses_of(clip, performer)
    up = np.asarray(clip.skeleton.up, dtype=np.float64)
    ahead = found.poses.root[0][:, 2]
    plain = view(np.zeros(3), up)
    facing = plain.turn @ ahead
    yaw = np.degrees(np.arctan2(facing[0], -facing[2])) + take.heading
    places = np.concatenate([landmarks(performer, found.poses[t]) for t in range(len(found.poses))])
    turned = view(np.zeros(3), up, 0.0, yaw)
    seen = places @ turned.turn.T
    middle = (seen.min(axis=0) + seen.max(axis=0)) / 2
    half = (seen.max(axis=0) - seen.min(axis=0)) / 2
    away = max(2.6, (half[0] + 0.3) * KINECT.fx / 160, (half[1] + 0.25) * KINECT.fy / 120) + half[2]
    seen_from = View(turned.turn, np.array([0.0, 0.0, away]) - middle, turned.up)
    return Stage(
        clip, performer, found.poses.moved(seen_from.turn, seen_from.shift), seen_from, found.error.mean(axis=0)
    )


def shown(
    scene: Stage, seed: int | None = None, *, colored: bool = False, frames: int | None = None
) -> list[DepthFrame]:
    """The take as the tracker's own body; a seed adds the Kinect's noise."""
    some = performed(scene.poses, scene.performer, fps=FPS, seed=seed, colored=colored)
    return list(islice(some, frames))


def foreign(scene: Stage, who: int, seed: int | None, frames: int | None = None) -> list[DepthFrame]:
    """The take as somebody else's body, on the motion's own skeleton."""
    some: Iterator[DepthFrame] = strange(scene.motion, stranger(scene.motion.skeleton, who), scene.seen, seed=seed)
    return list(islice(some, frames))


def roomed(scene: Stage, who: int, frames: int) -> tuple[list[DepthFrame], tuple[Plane, ...]]:
    """True depth of the take as somebody else's body, and a floor under their feet, a wall behind and one beside."""
    body = stranger(scene.motion.skeleton, who)
    up = np.asarray(scene.motion.skeleton.up, dtype=np.float64)
    lowest = []
    for t in range(0, scene.motion.frames, 5):
        position, turned = forward(scene.motion.skeleton, scene.motion.q[t : t + 1])
        centers = position[0][body.joint] + np.einsum("nij,nj->ni", turned[0][body.joint], body.place)
        lowest.append(float((centers @ up - body.radius).min()))
    right, _, far = scene.joints.reshape(-1, 3).max(axis=0)
    planes = room(scene.seen, float(np.percentile(lowest, 10)), up, max(0.4, far - 2.2), max(right + 0.7, 1.5))
    return foreign(scene, who, None, frames), planes


def noisy(frames: Sequence[DepthFrame], seed: int, planes: Sequence[Plane] = ()) -> list[DepthFrame]:
    """Frames of true depth with planes in view, as the Kinect would report them."""
    return [
        replace(frame, depth=sensed(behind(frame.depth, frame.camera, planes), frame.camera, seed, t))
        for t, frame in enumerate(frames)
    ]


@cache
def library(mocap: Path, clips: tuple[str, ...] = LIBRARY) -> TrackerModel:
    """Poses of clips, without a detector."""
    return TrackerModel.fit([reduced(motion(mocap, clip), FPS) for clip in clips], detector=False)


@cache
def tracker(mocap: Path, clips: tuple[str, ...] = LIBRARY) -> TrackerModel:
    """Poses of clips and a detector learned from 2,000 pictures of them, as `motionmend fit tracker` makes it."""
    return TrackerModel.fit([reduced(motion(mocap, clip), FPS) for clip in clips])


@dataclass(frozen=True, eq=False)
class Track:
    """What the tracker said of some frames.

    Attributes
    ----------
    joints : (T, 16, 3) m. std : (T, 16) m. flags : (T,). held : (T, 16). poses : (T,), None where nobody was found.
    seconds : (T,) of the thread's time, without what looks back. iterations : (T,). wrong : (T,).
    performer : as known at the end. behind : s by the clock in all for looking back, on two threads.
    """

    joints: Floats
    std: Floats
    flags: tuple[tuple[str, ...], ...]
    held: Bools
    poses: tuple[Pose | None, ...]
    seconds: Floats
    iterations: Floats
    wrong: Floats
    performer: Performer
    behind: float = 0.0

    @property
    def lost(self) -> Bools:
        """(T,) frames in which the person is not followed."""
        return frozen([bool({"lost", "empty"} & set(flags)) for flags in self.flags], np.bool_)

    def steady(self, times: Floats) -> Floats:
        """(T, 16, 3) m as `motionmend track` writes them: steadied over the whole recording."""
        there = ~self.lost
        if not there.any():
            return self.joints
        filled = [pose if pose is not None else self.poses[int(np.flatnonzero(there)[0])] for pose in self.poses]
        poses = Poses(*(np.array([getattr(p, name) for p in filled]) for name in ("translation", "root", "joints")))
        _, places = smoothed(poses, self.performer, times, frozen(there, np.bool_), self.held)
        return np.where(there[:, None, None], places, self.joints)


def follow(
    model: TrackerModel,
    settings: TrackSettings,
    frames: Sequence[DepthFrame],
    performer: Performer,
    pose: Pose | None = None,
) -> Track:
    """Track frames, from a given first pose or from none, each as it comes."""
    return recorded(model, replace(settings, hindsight=False), frames, performer, pose)


def recorded(
    model: TrackerModel,
    settings: TrackSettings,
    frames: Sequence[DepthFrame],
    performer: Performer,
    pose: Pose | None = None,
) -> Track:
    """The same as `motionmend track` has it: frames set right by those that come after, furniture told from people."""
    state = start(model, settings, frames[0], performer, pose, furnished(frames) if pose is None else None)
    moments, seconds = [], []
    for frame in frames:
        begin = thread_time()
        state, estimate = step(model, settings, state, frame)
        seconds.append(thread_time() - begin)
        moments.append(moment(state, estimate))
    begin = perf_counter()
    said = list(revised(model, settings, moments))
    behind = perf_counter() - begin
    said = _but_furniture(state, frames[-1], said)
    return Track(
        frozen([one.landmarks for one in said]),
        frozen([one.std for one in said]),
        tuple(tuple(one.flags) for one in said),
        frozen([one.held for one in said], np.bool_),
        tuple(one.pose for one in said),
        frozen(seconds),
        frozen([one.iterations for one in said]),
        frozen([one.wrong for one in said]),
        state.performer,
        behind,
    )


def furnished(frames: Sequence[DepthFrame]) -> Scene | None:
    """What of the room `motionmend track` knows before it follows anybody: furniture, who else is there; None = nothing."""
    return told_beforehand([frames[k] for k in looked_at(len(frames))])


def _but_furniture(state: TrackState, last: DepthFrame, said: list[Estimate]) -> list[Estimate]:
    """The estimates without those of furniture, as the room after the last frame tells it."""
    seen_behind = room_behind(state, last)
    some = [(t, one.pose) for t, one in enumerate(said) if one.pose is not None and "tracked" in one.flags]
    if seen_behind is None or not some:
        return said
    poses = Poses(
        np.array([pose.translation for _, pose in some]),
        np.array([pose.root for _, pose in some]),
        np.array([pose.joints for _, pose in some]),
    )
    mistaken = is_furniture(seen_behind, state.performer, poses, np.ones(len(some), dtype=np.bool_))
    nowhere = frozen(np.full((len(LANDMARKS), 3), np.nan))
    nobody = {"pose": None, "landmarks": nowhere, "std": nowhere[:, 0], "flags": ("empty",)}
    empty = {t for (t, _), found in zip(some, mistaken, strict=True) if found}
    return [replace(one, **nobody) if t in empty else one for t, one in enumerate(said)]


def away(truth: Floats, joints: Floats) -> Floats:
    """(T, 16) cm from the truth; what was never found counts as a metre."""
    return np.asarray(np.nan_to_num(100.0 * np.linalg.norm(joints - truth[: len(joints)], axis=2), nan=100.0))


def hidden(scene: Stage, side: str = "l", share: float = 0.05) -> Bools:
    """(T,) frames in which no more than a share of the pixels that the forearm has at its best are seen."""
    forearm = BONES.index(f"{side}_forearm")
    counts = np.array(
        [(render(scene.performer, scene.poses[t], KINECT).bones == forearm).sum() for t in range(len(scene.poses))]
    )
    return np.asarray(counts <= share * np.percentile(counts, 90))


def numbers(errors: Floats) -> tuple[str, str, str, str]:
    """Mean, 95 %, largest and share above 15 cm, for a table's row."""
    return (
        f"{errors.mean():.2f}",
        f"{np.percentile(errors, 95):.2f}",
        f"{errors.max():.1f}",
        f"{100 * (errors > FAR).mean():.1f}",
    )
