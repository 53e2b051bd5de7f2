"""A person's body from the first seconds of a recording, with neither lengths nor poses known (section 3.8)."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...bodies import anatomy
from ...bodies.camera import KINECT, DepthFrame
from ...bodies.performer import Performer, Pose
from ...errors import MismatchError
from ..detect.joints import detect
from ..frame.observation import Observation
from ..model import TrackerModel
from ..person.fineness import evened
from ..person.foreground import Scene, find_person, first_whole, remember, scene_of, told_again
from ..person.moved_camera import camera_followed
from ..settings import TrackSettings
from ..tracker import start, step
from .calibrate import Calibration, Trial, calibrated, size_from

FINE = KINECT.fx / 2  # px, focal length of the pictures that bodies are fitted to
SAME = 0.03  # sizes whose logarithms are no farther apart are tried once
CHILDREN = 0.8, 0.63  # sizes of ten and of five years, of whom the detector may be sure of no joint
SURE = 0.40  # share of wrongly explained pixels up to which a pose serves as a beginning


def measure_person(
    model: TrackerModel,
    settings: TrackSettings,
    frames: Sequence[DepthFrame],
    scene: Scene | None = None,
    pose: Pose | None = None,
    passes: int = 2,
) -> Calibration:
    """Find how long and wide the person in some frames is.

    The size comes from distances between detected joints, or is an adult's or a child's where that explains the frames
    better; then they are tracked with the body known so far and the body is fitted to those that were tracked well,
    `passes` times.

    Parameters
    ----------
    model : with a detector, unless `pose` is given.
    settings : of the tracking; as `step` takes them.
    frames : the first few seconds, in order.
    scene : the room before the first frame, as far as it is known: empty, or with its furniture.
    pose : of frame 0, if it is known.
    passes : how often.

    Returns
    -------
    Calibration : its performer is to be used from now on. Not `measured` where no fitted body is borne out.

    Raises
    ------
    MismatchError : when there is nobody who could be followed in these frames.
    """
    seen: dict[int, Observation] = {}
    detections = []
    last = None
    frames = [evened(frame) for frame in frames]  # once, for they are tracked several times
    begun = scene if scene is not None or not frames else scene_of(frames[first_whole(frames)])
    scene = begun
    for k, frame in enumerate(frames):
        other = scene is None or scene.background.shape != frame.depth.shape
        room = scene_of(frame) if scene is None or other else camera_followed(told_again(scene, frame), frame)
        person = find_person(room, frame, last)
        scene = remember(room, frame, person)
        if not person.found:
            continue
        last = person.place
        whole = Observation(frame.camera, person.depth, person.free, frame.time)
        seen[k] = whole.as_fine_as(FINE)
        if model.detector is not None and k % 4 == 0:
            detections.append(detect(model.detector, replace(frame, depth=person.depth), furniture=room.furniture))
    if not seen:
        raise MismatchError("a person in the first frames was wanted, there is nobody")
    average = anatomy.average()
    size = size_from(average, detections)
    begins = [average.stretched(np.full((1, 3), size))]
    if abs(np.log(size)) > SAME:
        begins.append(average)  # bent arms are detected too short

    def follow(body: Performer) -> Trial:
        state = start(model, settings, frames[0], body, pose, begun)
        followed = []
        for k, frame in enumerate(frames):
            state, estimate = step(model, settings, state, frame)
            # Bodies are tried that nobody has, and what those explain badly says nothing of the pose.
            state = replace(state, afresh=None)
            if k in seen and estimate.pose is not None and "tracked" in estimate.flags:
                followed.append((estimate.wrong, seen[k], estimate.pose))
        good = [one for one in followed if one[0] < SURE]
        # Where nothing fits well yet, as with a child and an adult's body, the better half has to do.
        kept = good if good else sorted(followed, key=lambda one: one[0])[: (len(followed) + 1) // 2]
        wrong = float(np.median([wrong for wrong, *_ in followed] + [1.0] * (len(seen) - len(followed))))
        return Trial([one for _, one, _ in kept], [found for *_, found in kept], wrong)

    return calibrated(begins, follow, passes, others=[average.stretched(np.full((1, 3), small)) for small in CHILDREN])
