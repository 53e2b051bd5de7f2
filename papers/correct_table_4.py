"""Table 4 in kind: joints that a forest finds in depth images, and the same corrected

The tracker's detector, a forest of body parts with mean shift (Shotton et al. 2011), finds joints in rendered depth images.
It has learned from other clips. Each of six actions is cut into five stretches: a corrector learned on four of them, of all
six actions, corrects the fifth.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from motionmend.arrays import Ints
from motionmend.bodies.joint_sets import TRACKER16
from motionmend.bodies.postures import INFERRED, NOT_TRACKED, TRACKED, Postures
from motionmend.correct import Corrector, Pair
from motionmend.track.detect.joints import detect
from motionmend.track.model import TrackerModel

from .common import Findings, Table, motion, reduced
from .track_common import FPS, LIBRARY, Take, shown, stage

ACTIONS = (
    Take("walk", "02_01", 0, 343),
    Take("boxing", "02_05", 200, 520),
    Take("bend", "02_06", 360, 712, 20.0),
    Take("jump", "16_02", 0, 320),
    Take("kick", "135_04", 200, 520),
    Take("kicks and punches", "86_01", 600, 920),
)
FOLDS = 5
PICTURES = 800  # that the forest learns from
LIKELY = 0.5  # a joint less likely to be within 10 cm is said to be a guess


@dataclass(frozen=True, eq=False)
class Seen:
    """An action as the forest saw it, and as it was."""

    sensor: Postures
    truth: Postures

    def stretch(self, fold: int) -> Pair:
        """One of five."""
        some = np.array_split(np.arange(self.sensor.frames), FOLDS)[fold]
        return Pair(_some(self.sensor, some), _some(self.truth, some))


def run(mocap: Path, pictures: Path) -> Findings:
    """Mean error of each action, from the forest and corrected."""
    del pictures
    taught = [reduced(motion(mocap, clip), FPS) for clip in LIBRARY]
    forest = TrackerModel.fit(taught, images=PICTURES)
    seen = [_seen(mocap, forest, take, seed) for seed, take in enumerate(ACTIONS)]
    errors: dict[str, list[tuple[float, float, float]]] = {take.name: [] for take in ACTIONS}
    for fold in range(FOLDS):
        model = Corrector().fit([one.stretch(k) for one in seen for k in range(FOLDS) if k != fold])
        for take, one in zip(ACTIONS, seen, strict=True):
            pair = one.stretch(fold)
            found = (
                pair.sensor.positions,
                model.correct(pair.sensor, method="gp").positions,
                model.correct(pair.sensor).positions,
            )
            known = pair.sensor.present
            off = [np.linalg.norm(each - pair.truth.positions, axis=2)[known].mean() for each in found]
            errors[take.name].append((100.0 * off[0], 100.0 * off[1], 100.0 * off[2]))
    by_action = {name: np.mean(rows, axis=0) for name, rows in errors.items()}
    ratios = {name: float(row[2] / row[0]) for name, row in by_action.items()}
    overall = np.mean(list(by_action.values()), axis=0)
    rows = tuple((name, *(f"{value:.2f}" for value in row)) for name, row in [*by_action.items(), ("all", overall)])
    return Findings(
        {
            "forest": float(overall[0]),
            "gp": float(overall[1]),
            "corrected": float(overall[2]),
            "ratio": float(overall[2] / overall[0]),
            "worst": max(ratios.values()),
            "lower": float(sum(ratio < 1.0 for ratio in ratios.values())),
            "actions": float(len(ACTIONS)),
            "frames": float(sum(one.sensor.frames for one in seen)),
        },
        (
            "Rendered: CMU motions at 30 Hz before a Kinect of 320 x 240 with its noise, each performed by a body of its "
            "own; nobody who moves there taught the forest those actions. Joints that the forest does not find count for "
            "none of the columns. All face the camera at first, and what the forest sees is read so.",
        ),
        (Table("Mean joint error, cm", ("action", "forest", "and one Gaussian process", "and corrected"), rows),),
    )


def _seen(mocap: Path, forest: TrackerModel, take: Take, seed: int) -> Seen:
    scene = stage(mocap, take)
    assert forest.detector is not None
    places, states, times = [], [], []
    for frame in shown(scene, seed):
        detection = detect(forest.detector, frame)
        likely = np.where(detection.confidence >= LIKELY, TRACKED, INFERRED)
        places.append(detection.joints)
        states.append(np.where(np.isfinite(detection.joints).all(axis=1), likely, NOT_TRACKED).astype(np.uint8))
        times.append(frame.time)
    return Seen(
        Postures(TRACKER16.names, np.array(places), np.array(times), state=np.array(states)),
        Postures(TRACKER16.names, scene.joints[: len(places)], np.array(times)),
    )


def _some(postures: Postures, frames: Ints) -> Postures:
    state = None if postures.state is None else postures.state[frames]
    return Postures(postures.names, postures.positions[frames], postures.times[frames], state=state)
