"""Arms out of sight in other motions: with a library that does not hold them, and without a prior"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from motionmend.arrays import Bools, runs
from motionmend.bodies.performer import LANDMARKS
from motionmend.track.settings import settings_of

from .common import Findings, Table, motion
from .track_common import ABOUT, Stage, Take, away, hidden, library, recorded, shown, stage

CLIPS = (
    *("02_01", "02_05", "02_06", "03_01", "05_03", "07_04", "14_29"),
    *("16_17", "16_21", "29_01", "86_01", "131_04", "135_04"),
)
LONG, WINDOWS = 360, 8  # frames at 120 Hz, and how many stretches of a clip are looked at
FURTHER = (0, 120, 240, 360)  # frames that a stretch goes on, until the arm is back
SIDES = (-75.0, -45.0, 45.0, 75.0)  # degrees
SPELL = (7, 30)  # frames that the forearm is out of sight at a time, the longest
SEEN_FIRST, AT_LEAST = 3, 60  # frames
EACH, NOISES = 3, 5  # takes of a clip at most, drawn; and seeds of the noise
AFTER = 10  # frames after the arm is back that still count
WANTED, OF_NONE = 6.0, 0.75  # cm; of the error without the prior


@dataclass(frozen=True, eq=False)
class Case:
    """An arm that is out of sight for a while.

    Attributes
    ----------
    take : what is seen. scene : the same on its stage. side : l or r. gone : (T,) frames in which it is hidden.
    """

    take: Take
    scene: Stage
    side: str
    gone: Bools


def run(mocap: Path, pictures: Path) -> Findings:
    """Error of elbow and wrist while they are hidden and ten frames after, as `motionmend track` has them."""
    del pictures
    model, ours = library(mocap), settings_of("default")
    without = settings_of("default", tuple(term for term in ours.terms if term != "prior"))
    rows, errors, spells, clips = [], [], [], []
    for case in _cases(mocap):
        counted = np.array([case.gone[max(0, t - AFTER) : t + 1].any() for t in range(len(case.gone))])
        arm = [LANDMARKS.index(f"{case.side}_{joint}") for joint in ("elbow", "wrist")]
        both = np.zeros((2, NOISES))
        for seed in range(NOISES):
            frames = shown(case.scene, seed)
            for k, wish in enumerate((ours, without)):
                track = recorded(model, wish, frames, case.scene.performer, case.scene.poses[0])
                both[k, seed] = away(case.scene.joints, track.joints)[counted][:, arm].mean()
        errors.append(both.mean(axis=1))
        spells.append(_longest(case.gone))
        clips.append(case.take.clip)
        side = "left" if case.side == "l" else "right"
        place = f"{case.take.clip}, from frame {case.take.first}"
        rows.append((place, f"{case.take.heading:.0f}", side, str(spells[-1]), *(f"{one:.1f}" for one in errors[-1])))
    error, none = np.array(errors).T
    of_clips = np.array([np.mean(np.array(errors)[np.array(clips) == clip], axis=0) for clip in dict.fromkeys(clips)])
    return Findings(
        {
            "takes": float(len(error)),
            "mean": float(error.mean()),
            "none": float(none.mean()),
            "of_none": float(error.mean() / none.mean()),
            "median": float(np.median(error)),
            "worst": float(error.max()),
            "near": float((error <= WANTED).mean()),
            "helped": float((error <= OF_NONE * none).mean()),
            "near_clips": float((of_clips[:, 0] <= WANTED).mean()),
            "helped_clips": float((of_clips[:, 0] <= OF_NONE * of_clips[:, 1]).mean()),
            "harmed": float((error > 1.05 * none).mean()),
        },
        (
            ABOUT,
            f"Three seconds each, or until the arm is back, {NOISES} seeds of the Kinect's noise, the tracker's own body, lengths "
            f"and first pose given; a forearm is out of sight for {min(spells)} to {max(spells)} frames at a time; these and "
            f"{AFTER} after each count. Up to {EACH} takes of a clip are drawn from all sides and stretches in which that happens.",
        ),
        (
            Table(
                "Elbow and wrist, cm",
                ("take", "degrees", "arm", "frames hidden", "default", "without the prior"),
                tuple(rows),
            ),
        ),
    )


def _cases(mocap: Path) -> Iterator[Case]:
    for clip in CLIPS:
        rng = np.random.default_rng(0)
        found = list(_hiding(mocap, clip))
        yield from (found[k] for k in rng.permutation(len(found))[:EACH])


def _hiding(mocap: Path, clip: str) -> Iterator[Case]:
    """All stretches and sides of a clip in which an arm that was seen is gone for a while."""
    frames = motion(mocap, clip).frames
    for first in range(0, max(1, frames - LONG), LONG)[:WINDOWS]:
        for heading in SIDES:
            take = Take(clip, clip, first, min(frames, first + LONG), heading)
            scene = stage(mocap, take)
            if len(scene.poses) < AT_LEAST:
                continue
            for side in ("l", "r"):
                gone = hidden(scene, side)
                if not gone[:SEEN_FIRST].any() and SPELL[0] <= _longest(gone) <= SPELL[1]:
                    yield _until_back(mocap, Case(take, scene, side, gone))


def _until_back(mocap: Path, case: Case) -> Case:
    """The same going on until the arm has been back for `AFTER` frames, or as far as clip and `FURTHER` go."""
    frames = motion(mocap, case.take.clip).frames
    for more in FURTHER:
        take = replace(case.take, last=min(frames, case.take.last + more))
        scene = stage(mocap, take)
        gone = hidden(scene, case.side)
        if take.last == frames or not gone[-AFTER:].any():
            break
    return Case(take, scene, case.side, gone)


def _longest(gone: Bools) -> int:
    """Frames of the longest stretch of True."""
    return max((last - first for first, last in runs(gone)), default=0)
