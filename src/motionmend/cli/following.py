"""One depth recording through the tracker: what it says of every frame, and how long each step took."""

from array import array
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import Bools, Bytes, Floats, frozen
from ..bodies.anatomy import average
from ..bodies.motion import Origin
from ..bodies.performer import LANDMARKS, Performer, Pose, Poses
from ..bodies.postures import Postures
from ..errors import MismatchError

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from ..io.depth_recording import DepthRecording
    from ..processes import Crew
    from ..track.hindsight.backwards import Moment
    from ..track.measure.calibrate import Calibration
    from ..track.model import TrackerModel
    from ..track.outcome import Estimate
    from ..track.person.room import Scene
    from ..track.recording import Told
    from ..track.settings import TrackSettings
    from ..track.starting.furniture import Room

WINDOW = 3.0  # s, looked at to measure the person
MEASURED_FPS = 15.0  # Hz, of the frames looked at
ROOM = 0.4  # share of the pixels with depth, from which on a recording shows a room
FEWER = 0.75  # times as many, below which an image is blank or damaged


@dataclass(frozen=True, eq=False)
class Followed:
    """What the tracker made of a recording.

    Attributes
    ----------
    postures : (T, 16) joints in camera axes with their deviations; NaN in an empty frame, deviations of 0.10 m or
        more where the body is lost.
    poses : T poses of true left and right; in a frame without the person that of the last one with it, NaN before the
        first.
    performer : the body that was followed, with the widths as they were learned by the end.
    flags : (T,) the tracker's words for each frame: tracked, held, recovered, revised, lost, empty.
    seen : (T,) whether the person is in the frame and followed. held : (T, 16) joints of limbs that are out of sight.
    returns : (T,) share of the depth image's pixels that hold anything.
    frame_ms : (T - 1,) milliseconds of each frame but the first, reading and looking back left out.
    read, track, calibrate : seconds in all; of reading those in which the tracker had to wait for an image.
    stages : seconds in all of each stage of the tracker.
    iterations : of the solver, in all; this and what follows on the way forward.
    cost : weighted cost of each term in all.
    converged : frames whose solution converged.
    restarts : how many limbs or bodies were found anew.
    calibrated : whether the performer was fitted to this recording.
    mistaken : (T,) frames in which furniture was followed: nobody is in them.
    furnished : whether furniture that looks like a body was told before anybody was followed.
    company : (T,) frames in which somebody else is seen, too. moved : (T,) frames in which the camera is elsewhere.
    doubts : what speaks against the body that was followed.
    """

    postures: Postures
    poses: Poses
    performer: Performer
    flags: tuple[tuple[str, ...], ...]
    seen: Bools
    held: Bools
    returns: Floats
    frame_ms: Floats
    read: float
    track: float
    calibrate: float
    stages: Mapping[str, float] = field(default_factory=dict)
    iterations: int = 0
    cost: Mapping[str, float] = field(default_factory=dict)
    converged: int = 0
    restarts: int = 0
    calibrated: bool = False
    mistaken: Bools = field(default_factory=lambda: np.zeros(0, bool))
    furnished: bool = False
    company: Bools = field(default_factory=lambda: np.zeros(0, bool))
    moved: Bools = field(default_factory=lambda: np.zeros(0, bool))
    doubts: tuple[str, ...] = ()

    @property
    def lost(self) -> int:
        """Frames in which nobody is followed."""
        return int((~self.seen).sum())

    def runs(self) -> dict[str, list[list[int]]]:
        """Stretches of frames by what is said of them beyond `tracked`: [first frame from 0, number of frames]."""
        from .provenance import mask_runs

        said = sorted({flag for flags in self.flags for flag in flags} - {"tracked"})
        return {
            flag: [list(run) for run in mask_runs(np.array([flag in flags for flags in self.flags]))] for flag in said
        }

    @property
    def damaged(self) -> Bools:
        """(T,) frames with depth in clearly fewer pixels than most have; without a room none."""
        usual = float(np.median(self.returns))
        return self.returns < FEWER * usual if usual > ROOM else np.zeros(len(self.returns), bool)

    @property
    def origin(self) -> Bytes:
        """(T, 16) of `Origin`: measured, filled (out of sight or unsure), or left open."""
        from ..track.recording import UNSURE

        std = self.postures.std
        unsure = np.zeros(self.held.shape, bool) if std is None else ~(np.nan_to_num(std, nan=np.inf) < UNSURE)
        found = np.where(self.held | unsure, Origin.FILLED, Origin.MEASURED)
        return np.where(self.postures.present, found, Origin.LEFT_OPEN).astype(np.uint8)

    def counts(self) -> dict[str, dict[str, int]]:
        """For each joint, in how many frames it is of which `Origin`."""
        origin = self.origin
        return {
            name: {kind.name.lower(): int((origin[:, j] == kind).sum()) for kind in Origin}
            for j, name in enumerate(self.postures.names)
        }

    def joint_runs(self) -> dict[str, dict[str, list[list[Any]]]]:
        """For each joint the stretches in which it is not measured, as `provenance.runs_of` tells them, m."""
        from .provenance import runs_of

        std = np.full(self.held.shape, np.nan) if self.postures.std is None else self.postures.std
        origin = self.origin
        runs = {name: runs_of(origin[:, j], std[:, j]) for j, name in enumerate(self.postures.names)}
        return {name: found for name, found in runs.items() if found}


def follow(
    model: "TrackerModel",
    settings: "TrackSettings",
    recording: "DepthRecording",
    performer: Performer | None = None,
    landmarks: Floats | None = None,
    other: "Crew | Executor | None" = None,
) -> Followed:
    """Track a recording, one frame at a time; once later ones have set it right only its estimate is kept.

    Parameters
    ----------
    model : fitted.
    settings : preset and terms.
    recording : the depth images.
    performer : the person's lengths and widths; None calibrates them on the recording itself.
    landmarks : (16, 3) m, where the joints are in frame 0, NaN where not known; None finds the person.
    other : another process to look back with (`looking_back.second_process`); None does it here.

    Raises
    ------
    FileError : an image that cannot be read.
    MismatchError : fewer than three joints to start from.
    """
    import cv2

    cv2.setNumThreads(1)  # small images: threads cost more than they save, and each job has one of its own
    begin = perf_counter()
    if landmarks is not None:
        landmarks = landmarks @ recording.axes
    scene = _known_beforehand(recording, landmarks)
    measured = None if performer is not None else _measured(model, settings, recording, landmarks, scene)
    found = _followed(model, settings, recording, performer, measured, landmarks, scene, other, perf_counter() - begin)
    window = max(1, round(WINDOW * recording.fps))
    if measured is None or not found.mistaken[:window].any() or not found.seen.any():
        return found
    # furniture was measured, alone or with who came after it
    measured = _measured(model, settings, recording, None, scene, int(np.argmax(found.seen)))
    return _followed(model, settings, recording, None, measured, landmarks, scene, other, perf_counter() - begin)


def _known_beforehand(recording: "DepthRecording", landmarks: Floats | None) -> "Scene | None":
    """The room with its furniture and who else is there, by frames of all of the recording; None where none is told."""
    from ..track.person.company import told_beforehand
    from ..track.person.standing import looked_at

    frames = [recording.true_frame(k) for k in looked_at(recording.frames)]
    return told_beforehand(frames, None if landmarks is None else np.nanmean(landmarks, axis=0))


def _followed(
    model: "TrackerModel",
    settings: "TrackSettings",
    recording: "DepthRecording",
    performer: Performer | None,
    measured: "Calibration | None",
    landmarks: Floats | None,
    scene: "Scene | None",
    other: "Crew | Executor | None",
    calibrate: float,
) -> Followed:
    """The recording tracked with a body that is given, or was measured in so many seconds."""
    from ..track.hindsight.backwards import moment
    from ..track.recording import Told
    from ..track.starting.furniture import room_behind
    from ..track.tracker import start, step
    from .ahead import ahead
    from .looking_back import revised_beside

    fitted = measured is not None and measured.measured
    body = performer if performer is not None else average() if measured is None else measured.performer
    pose = None if landmarks is None else _posed(model, body, landmarks)
    log, begun = _Log(Told(), body), perf_counter()

    def moments() -> "Iterator[Moment]":
        state, begin = None, perf_counter()
        for frame in ahead(recording.true_frame, recording.frames):
            log.read += perf_counter() - begin
            if state is None:
                state = start(model, settings, frame, body, pose, scene)
            there = perf_counter()
            state, estimate = step(model, settings, state, frame)
            log.spent.append(perf_counter() - there)
            log.returns.append(float(np.mean(np.isfinite(frame.depth))))
            log.told.saw(state.scene, frame)
            log.performer = state.performer
            yield moment(state, estimate)
            begin = perf_counter()
        log.room = None if state is None else room_behind(state, frame)

    for estimate in revised_beside(other, model, settings, moments()):
        log.add(estimate)
    found = log.followed(recording, begun, calibrate, fitted, steady=settings.steady)
    return replace(found, furnished=scene is not None and bool(np.isfinite(scene.background).any()))


def _measured(
    model: "TrackerModel",
    settings: "TrackSettings",
    recording: "DepthRecording",
    landmarks: Floats | None,
    scene: "Scene | None",
    first: int = 0,
) -> "Calibration | None":
    """The body of who is seen first from a frame on, by the first seconds in which somebody is; None when nobody is."""
    from ..track.measure.first_seconds import measure_person

    window = max(1, round(WINDOW * recording.fps))
    thin = max(1, round(recording.fps / MEASURED_FPS))
    for begin in range(first, recording.frames, window):
        frames = [recording.true_frame(k) for k in range(begin, min(begin + window, recording.frames), thin)]
        pose = None
        if begin == 0 and landmarks is not None:
            pose = _posed(model, average(), landmarks)
        if begin and scene is not None:
            scene = replace(scene, others=None)  # by now they are elsewhere
        try:
            return measure_person(model, settings, frames, scene, pose)
        except MismatchError:
            continue
    return None


def _posed(model: "TrackerModel", body: Performer, landmarks: Floats) -> Pose:
    """The pose of a body with its joints at given places."""
    from ..track.starting.first_pose import pose_from_joints

    examples = model.database.joints
    return pose_from_joints(body, landmarks, examples[:: 1 + len(examples) // 1000])[0]


@dataclass
class _Log:
    """What was said so far, and how long it took."""

    told: "Told"
    performer: Performer
    room: "Room | None" = None
    read: float = 0.0
    spent: "array[float]" = field(default_factory=lambda: array("d"))
    returns: "array[float]" = field(default_factory=lambda: array("d"))
    stages: dict[str, float] = field(default_factory=dict)
    cost: dict[str, float] = field(default_factory=dict)
    iterations: int = 0
    converged: int = 0
    restarts: int = 0

    def add(self, estimate: "Estimate") -> None:
        self.told.add(estimate)
        for name, value in estimate.seconds.items():
            self.stages[name] = self.stages.get(name, 0.0) + value
        for name, value in estimate.costs.items():
            self.cost[name] = self.cost.get(name, 0.0) + value
        self.iterations += estimate.iterations
        self.converged += estimate.converged
        self.restarts += estimate.restarts

    def followed(
        self, recording: "DepthRecording", begun: float, calibrate: float, fitted: bool, *, steady: bool
    ) -> Followed:
        """All of it; `begun` is when the first image was asked for, by `perf_counter`."""
        begin = perf_counter()
        tracked = self.told.tracked(recording.times, self.performer, self.room, steady=steady)
        if steady:
            self.stages["smoothing"] = perf_counter() - begin
        joints = tracked.joints @ recording.axes.T  # back to where they are in the images; names stay the person's own
        return Followed(
            Postures(LANDMARKS, joints, recording.times, std=tracked.std),
            tracked.poses,
            tracked.performer,
            tracked.flags,
            tracked.seen,
            tracked.held,
            frozen(self.returns),
            frozen(1000 * np.array(self.spent[1:])),
            self.read,
            perf_counter() - begun - self.read,
            calibrate,
            self.stages,
            self.iterations,
            self.cost,
            self.converged,
            self.restarts,
            fitted,
            tracked.mistaken,
            company=tracked.company,
            moved=tracked.moved,
            doubts=tracked.warnings,
        )
