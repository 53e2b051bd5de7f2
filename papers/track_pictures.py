"""Figures 3.5 and 3.7 to 3.10 in kind: the pose over depth, edges observed and rendered, the second view"""

from pathlib import Path
from typing import Any

import numpy as np

from motionmend.arrays import Bools, Floats, Ints, Singles
from motionmend.bodies.camera import DepthFrame
from motionmend.bodies.joint_sets import parents
from motionmend.bodies.performer import LANDMARKS, Performer, Pose
from motionmend.bodies.surface import render
from motionmend.evaluate.scenes import view
from motionmend.io.depth import read_depth
from motionmend.report.style import figure_at
from motionmend.track.frame.evidence import edges_of
from motionmend.track.measure.first_seconds import measure_person
from motionmend.track.person.foreground import clean
from motionmend.track.settings import settings_of

from .common import Findings
from .correct_common import kinect_in
from .track_common import ABOUT, FAR, KICK, away, follow, foreign, stage, tracker

FRAMES = 4  # of each recording
REAL = "a9_s3_t1"


def run(mocap: Path, pictures: Path) -> Findings:
    """A stranger's kick and a real person's circle, four frames each."""
    model, wish = tracker(mocap), settings_of("default")
    scene = stage(mocap, KICK)
    frames = foreign(scene, 3, 3)
    track = follow(model, wish, frames, scene.performer, scene.poses[0])
    errors = away(scene.joints, track.joints)
    edges = [_edge_gap(frames[t], track.performer, pose) for t, pose in enumerate(track.poses) if pose is not None]
    chosen = np.linspace(0, len(frames) - 1, FRAMES).astype(int)
    _draw(pictures / "track_kick.png", [(frames[t], track.performer, track.poses[t], track.joints[t]) for t in chosen])
    recording = read_depth(kinect_in(mocap) / "utdmhad" / "Depth" / f"{REAL}_depth.mat")
    real = [recording.true_frame(t) for t in range(recording.frames)]
    own = follow(model, wish, real, measure_person(model, wish, real[:60:3]).performer)
    there = np.flatnonzero(~own.lost)
    chosen = there[np.linspace(0, len(there) - 1, FRAMES).astype(int)]
    _draw(pictures / "track_real.png", [(real[t], own.performer, own.poses[t], own.joints[t]) for t in chosen])
    real_edges = [_edge_gap(real[t], own.performer, own.poses[t]) for t in there[::5]]
    return Findings(
        {
            "pictures": 2.0 * FRAMES,
            "edges_px": float(np.mean(edges)),
            "real_edges_px": float(np.mean(real_edges)),
            "kick_mean": float(errors.mean()),
            "kick_far": 100.0 * float((errors > FAR).mean()),
        },
        (ABOUT, f"CMU {KICK.clip} on somebody else's body with noise; UTD-MHAD {REAL} (draw a circle), nothing given."),
        (),
        tuple(
            (
                f"track_{name}.png",
                f"{what}: the joints over the depth image, edges observed (blue) and rendered (red), and the joints from the side.",
            )
            for name, what in (
                ("kick", "A kick, another body than the tracker's, with noise"),
                ("real", "A real recording"),
            )
        ),
    )


def _edges(depth: Singles) -> Bools:
    """(H, W) True on the steps of a depth image, cleaned as the tracker cleans it."""
    depth = clean(depth)
    return np.asarray(np.isfinite(edges_of(depth, False)))


def _edge_gap(frame: DepthFrame, performer: Performer, pose: Pose | None) -> float:
    """Median distance in px of the rendered edges from the nearest observed one."""
    from scipy.ndimage import distance_transform_edt

    assert pose is not None
    observed, drawn = _edges(frame.depth), _edges(render(performer, pose, frame.camera).depth)
    return float(np.median(distance_transform_edt(~observed)[drawn]))


def _draw(path: Path, rows: list[tuple[DepthFrame, Performer, Pose | None, Floats]]) -> None:
    above = parents(LANDMARKS)
    with figure_at(path, 8.0, 6.0, "") as figure:
        axes = figure.subplots(3, len(rows))
        for column, (frame, performer, pose, joints) in enumerate(rows):
            assert pose is not None
            camera = frame.camera
            box = np.argwhere(np.isfinite(frame.depth))
            (top, left), (bottom, right) = box.min(axis=0) - 8, box.max(axis=0) + 8
            grey = np.where(np.isfinite(frame.depth), frame.depth, np.nan)
            first, second, third = axes[:, column]
            first.imshow(-grey, cmap="gray", interpolation="nearest")
            _bones(first, camera.project(joints), above)
            both = np.ones((*grey.shape, 3))
            both[_edges(render(performer, pose, camera).depth)] = (0.85, 0.2, 0.15)
            both[_edges(frame.depth)] = (0.1, 0.35, 0.8)
            second.imshow(both, interpolation="nearest")
            middle = np.nanmedian(joints, axis=0)
            aside = view(middle, np.array([0.0, -1.0, 0.0]), float(middle[2]), 90.0)
            points = camera.points(frame.depth)[::3, ::3].reshape(-1, 3)
            points = points[np.isfinite(points).all(axis=1)] @ aside.turn.T + aside.shift
            third.scatter(*camera.project(points).T, s=0.6, color="0.7", lw=0)
            _bones(third, camera.project(joints @ aside.turn.T + aside.shift), above)
            third.set_aspect("equal")
            third.invert_yaxis()
            for one in (first, second):
                one.set_xlim(left, right)
                one.set_ylim(bottom, top)
            for one in (first, second, third):
                one.set_axis_off()


def _bones(axes: Any, pixels: Floats, above: Ints) -> None:
    for joint, parent in enumerate(above):
        if parent >= 0:
            axes.plot(*pixels[[joint, parent]].T, color="tab:orange", lw=1.6, marker="o", ms=2)
