"""A whole recording: followed from frame to frame, set right by what comes later, and told in arrays."""

from array import array
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import final

import numpy as np

from ..arrays import Bools, Floats, frozen
from ..bodies.camera import DepthFrame
from ..bodies.performer import AXES, LANDMARKS, Performer, Pose, Poses
from ..errors import MismatchError
from .hindsight.backwards import Moment, moment, revised
from .hindsight.smoothing import smoothed
from .measure.plausible import STILL_UNLIKE, doubts, unlike
from .model import TrackerModel
from .outcome import Estimate
from .person.company import is_accompanied
from .person.room import Scene
from .readings.facing import changed_over
from .settings import TrackSettings, settings_of
from .starting.furniture import Room, is_furniture, room_behind
from .tracker import start, step

UNSURE = 0.10  # m; a joint whose place has this standard deviation or more is not said to be known
DEFAULT = settings_of("default")


@final
@dataclass(frozen=True, eq=False)
class Tracked:
    """What the tracker made of T frames.

    Attributes
    ----------
    times : (T,) s.
    joints : (T, 16, 3) m, `LANDMARKS` in camera axes; NaN in a frame without anybody.
    std : (T, 16) m, standard deviation of each joint (one coordinate), `UNSURE` or more where the body is lost or
        may be nobody's.
    poses : T poses of true left and right; in a frame without the person that of the last one with it, NaN before the
        first.
    performer : the body that was followed, with the widths as they were learned by the end.
    flags : (T,) the tracker's words for each frame: tracked, held, recovered, revised, lost, empty.
    seen : (T,) whether the person is in the frame and followed. held : (T, 16) joints of limbs that are out of sight.
    mistaken : (T,) frames in which furniture was followed: nobody is in them.
    company : (T,) frames in which somebody else is seen, too. moved : (T,) frames in which the camera is elsewhere.
    warnings : what speaks against the body that was followed (`measure.plausible`).
    """

    times: Floats
    joints: Floats
    std: Floats
    poses: Poses
    performer: Performer
    flags: tuple[tuple[str, ...], ...]
    seen: Bools
    held: Bools
    mistaken: Bools
    company: Bools
    moved: Bools
    warnings: tuple[str, ...] = ()


def follow(
    model: TrackerModel,
    frames: Iterable[DepthFrame],
    performer: Performer,
    pose: Pose | None = None,
    settings: TrackSettings = DEFAULT,
    scene: Scene | None = None,
) -> Tracked:
    """Follow a body through a recording, as `motionmend track` does.

    Parameters
    ----------
    model : fitted.
    frames : in order, one at least, each looked at once.
    performer : the person's lengths: measured (`measure_person`), or an average adult's (`anatomy.average`).
    pose : of frame 0 (`pose_from_joints`); the detector finds it when not given.
    settings : of `settings_of`.
    scene : the room with its furniture and who else is in it (`told_beforehand`); None = nothing is known of it.

    Raises
    ------
    MismatchError : no frames.
    UsageError : neither a pose nor a model with a detector.
    """
    told, times = Told(), array("d")
    body, room = performer, None

    def moments() -> Iterator[Moment]:
        nonlocal body, room
        state = None
        for frame in frames:
            if state is None:
                state = start(model, settings, frame, performer, pose, scene)
            state, estimate = step(model, settings, state, frame)
            told.saw(state.scene, frame)
            times.append(frame.time)
            body = state.performer
            yield moment(state, estimate)
        room = None if state is None else room_behind(state, frame)

    for estimate in revised(model, settings, moments()):
        told.add(estimate)
    if not times:
        raise MismatchError("depth frames were wanted, came none")
    return told.tracked(np.array(times), body, room, steady=settings.steady)


@dataclass
class Told:
    """Estimates so far, in arrays that grow by a kilobyte a frame: with all they hold an hour would not fit."""

    rows: "array[float]" = field(default_factory=lambda: array("d"))  # numbers of one frame after those of another
    flags: list[tuple[str, ...]] = field(default_factory=list)
    company: bytearray = field(default_factory=bytearray)
    moved: bytearray = field(default_factory=bytearray)

    def saw(self, scene: Scene | None, frame: DepthFrame) -> None:
        """What the next frame shows beside the body; `scene` is that after it. The way forward is ahead of `add`."""
        self.company.append(is_accompanied(scene, frame))
        self.moved.append(scene is not None and bool(scene.moved == frame.time))  # a time may be numpy's own

    def add(self, estimate: Estimate) -> None:
        """The next frame's."""
        pose = estimate.pose
        parts = (
            estimate.landmarks.ravel(),
            estimate.std,
            estimate.std if estimate.settled is None else estimate.settled,
            estimate.held,
            np.full(3, np.nan) if pose is None else pose.translation,
            np.full(9, np.nan) if pose is None else pose.root.ravel(),
            np.full(len(AXES), np.nan) if pose is None else pose.joints,
            np.array([estimate.wrong, estimate.changed]),
        )
        self.rows.frombytes(np.concatenate(parts, dtype=np.float64).tobytes())
        self.flags.append(tuple(estimate.flags))

    def tracked(self, times: Floats, performer: Performer, room: Room | None = None, *, steady: bool) -> Tracked:
        """All of them, in arrays; furniture that was followed is nobody.

        Parameters
        ----------
        times : (T,) s, of the frames that were added.
        performer : the body that was followed, as known at the end.
        room : behind everybody, as known at the end; None = not known.
        steady : whether poses and joints are smoothed over the whole recording.
        """
        count = len(self.flags)
        widths = (3 * len(LANDMARKS), *(len(LANDMARKS),) * 3, 3, 9, len(AXES), 1, 1)
        table = np.frombuffer(self.rows).reshape(count, sum(widths))
        flat, std, settled, held, way, root, joints, wrong, changed = (
            part.copy() for part in np.split(table, np.cumsum(widths)[:-1], axis=1)
        )
        places, root = flat.reshape(count, len(LANDMARKS), 3), root.reshape(count, 3, 3)
        there = np.isfinite(places).all(axis=(1, 2)) & np.array(["empty" not in flags for flags in self.flags], bool)
        seen = there & np.array(["lost" not in flags for flags in self.flags], bool)
        mistaken = np.zeros(count, bool)
        if room is not None:
            mistaken = is_furniture(room, performer, Poses(way, root, joints), seen)
        still = room is not None and room.still
        if still and unlike(wrong[seen, 0]):  # of who stands so still a body explains more
            mistaken |= seen
        there, seen = there & ~mistaken, seen & ~mistaken
        flags = tuple(("empty",) if mistaken[t] else flags for t, flags in enumerate(self.flags))
        for t in np.flatnonzero(mistaken).tolist():
            for rows in (way, root, joints):
                rows[t] = rows[t - 1] if t else np.nan
        std = in_hindsight(std, settled, places, root[:, :, 2], seen, changed[:, 0])
        # where the body was last, or may be; and what never sways may be nobody
        unsure = ~seen | (still and unlike(wrong[:, 0], STILL_UNLIKE))
        std[unsure] = np.maximum(std[unsure], UNSURE)
        places[~there], std[~there] = np.nan, np.nan
        poses = Poses(way, root, joints)
        if steady:
            poses, steadied = smoothed(poses, performer, times, frozen(seen, np.bool_), held > 0)
            places = np.where(seen[:, None, None], steadied, places)
        hidden = (held > 0) & seen[:, None]
        return Tracked(
            frozen(times),
            frozen(places),
            frozen(std),
            poses,
            performer,
            flags,
            frozen(seen, np.bool_),
            frozen(hidden, np.bool_),
            frozen(mistaken, np.bool_),
            frozen(np.frombuffer(self.company, np.bool_), np.bool_),
            frozen(np.frombuffer(self.moved, np.bool_), np.bool_),
            doubts(performer, wrong[there, 0], still=still and bool(seen.any())),
        )


def in_hindsight(std: Floats, settled: Floats, places: Floats, ahead: Floats, seen: Bools, changed: Floats) -> Floats:
    """Deviations (T, 16) m of a whole recording: what the end of a reading tells of front and back goes for all.

    Parameters
    ----------
    std, settled : (T, 16) m with and without doubt about front and back, as `Estimate` has them.
    places : (T, 16, 3) m, joints.
    ahead : (T, 3) where the body faces. seen : (T,) frames in which it is followed.
    changed : (T,) how likely front and back are changed over, as known in each frame.

    Returns
    -------
    (T, 16) m. Where the other reading was taken at the end, or the question was open to the last frame, doubt stays.
    """
    later = np.array(changed)
    for t in range(len(std) - 2, -1, -1):
        if not (seen[t] and seen[t + 1]):
            continue
        if ahead[t] @ ahead[t + 1] < 0.0:
            later[t] = 0.5  # the other one was taken
        elif not changed[t] < changed[t + 1] == 0.5:  # there it is asked of a body found anew
            later[t] = later[t + 1]
    told = changed_over(settled, places, later)
    return np.where((later < changed)[:, None], told, np.maximum(std, told))
