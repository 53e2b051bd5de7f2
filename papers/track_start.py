"""Section 3.3.2 and future work: the first frame without anybody's help, and the person found again"""

from pathlib import Path

import numpy as np

from motionmend.bodies.camera import KINECT, DepthFrame
from motionmend.track.model import TrackerModel
from motionmend.track.settings import TrackSettings, settings_of
from motionmend.track.start import five_of, pose_from_joints

from .common import FPS, Findings, Table
from .track_common import ABOUT, DOZEN, Stage, away, follow, shown, stage, tracker

AFTER = 15  # frames until a start counts
GONE = 30  # frames, one second, out of view


def run(mocap: Path, pictures: Path) -> Findings:
    """Started from nothing, from five joints and from the truth; and again after a second out of view."""
    del pictures
    model, wish = tracker(mocap), settings_of("default")
    rows, ratios, again, fives = [], [], [], []
    for take in DOZEN:
        scene = stage(mocap, take)
        frames = shown(scene, 0, frames=AFTER + 10)
        truth = scene.joints
        given = away(truth, follow(model, wish, frames, scene.performer, scene.poses[0]).joints)[AFTER:].mean()
        alone = away(truth, follow(model, wish, frames, scene.performer).joints)[AFTER:].mean()
        five, _ = pose_from_joints(scene.performer, five_of(truth[0]))
        helped = away(truth, follow(model, wish, frames, scene.performer, five).joints)[AFTER:].mean()
        back = _again(model, wish, scene, frames)
        ratios.append(alone / given)
        fives.append(helped / given)
        again.append(back)
        rows.append((take.name, f"{given:.2f}", f"{alone:.2f}", f"{helped:.2f}", f"{back:.2f}"))
    ratio, five_ratio, returned = np.array(ratios), np.array(fives), np.array(again)
    given_all = np.array([float(row[1]) for row in rows])
    return Findings(
        {
            "alone_well": float(np.mean(ratio <= 1.3)),
            "alone_median": float(np.median(ratio)),
            "five_well": float(np.mean(five_ratio <= 1.3)),
            "back_well": float(np.mean(returned <= 1.3 * given_all + 1.0)),
            "clips": float(len(ratio)),
        },
        (
            ABOUT,
            f"Kinect's noise, the tracker's own body, given lengths. Means of the frames {AFTER} to {AFTER + 9} after the "
            "start. Five joints: true places of head, wrists and ankles (section 3.3.2). Found again: ten frames, a second "
            "of empty images, and the clip from its beginning.",
        ),
        (
            Table(
                "Error 15 frames after the start, cm",
                ("motion", "pose given", "found alone", "from five joints", "after 1 s out of view"),
                tuple(rows),
            ),
        ),
    )


def _again(model: TrackerModel, wish: TrackSettings, scene: Stage, frames: list[DepthFrame]) -> float:
    """Error 15 frames after the person is back, cm."""
    nothing = np.full((KINECT.height, KINECT.width), np.nan, np.float32)
    empty = [DepthFrame(KINECT, nothing, None, (10 + k) / FPS) for k in range(GONE)]
    back = [DepthFrame(KINECT, one.depth, None, (10 + GONE + k) / FPS) for k, one in enumerate(frames)]
    every = [*frames[:10], *empty, *back]
    track = follow(model, wish, every, scene.performer, scene.poses[0])
    return float(away(scene.joints, track.joints[10 + GONE :])[AFTER:].mean())
