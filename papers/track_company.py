"""Sections 3.8 and 4, beyond: two people are in view from the first frame on, and move beside each other"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from motionmend.arrays import Floats
from motionmend.bodies.camera import KINECT, DepthFrame
from motionmend.evaluate.scenes import View
from motionmend.track.settings import settings_of

from .common import Findings, Table
from .track_common import (
    BEND,
    DANCE,
    FPS,
    KICK,
    SLOW,
    TURN,
    Stage,
    Take,
    away,
    foreign,
    furnished,
    noisy,
    recorded,
    roomed,
    stage,
    tracker,
)
from .track_passers import floor_of

TAKES = (DANCE, BEND, TURN, KICK, Take("boxing", "02_05", 200, 520), Take("jump", "16_02", 0, 320), SLOW)
GAPS = 0.2, 0.5  # m, between the one's reach and the other's
SECONDS = 3.0
CLEAR = 0.7  # m, from anybody's joints to the walls, at least
NEAR = 30.0  # cm, mean over the joints, from which on it is somebody else who is followed


def run(mocap: Path, pictures: Path) -> Findings:
    """Each take beside the next, near and farther, with and without a room, other bodies, noisy, nobody pointed at."""
    del pictures
    model, wish = tracker(mocap), settings_of("default")
    rows: list[tuple[str, ...]] = []
    errors, kept, told = list[float](), list[float](), list[bool]()
    for number, take in enumerate(TAKES):
        beside = TAKES[(number + 1) % len(TAKES)]
        for gap in GAPS:
            two = _beside(stage(mocap, take), stage(mocap, beside), gap)
            count = min(round(SECONDS * FPS), *(len(one.poses) for one in two))
            for room in (False, True):
                frames = _shown(two, number, count, room=room)
                scene = furnished(frames)
                track = recorded(model, wish, frames, two[0].performer)
                joints = track.steady(np.arange(count) / FPS)
                off = np.array([away(one.joints[:count], joints).mean(axis=1) for one in two])
                whom = int(np.argmin(np.median(off, axis=1)))
                followed = ~track.lost & (off[whom] < NEAR)
                told.append(scene is not None and scene.others is not None)
                kept.append(float(followed.mean()))
                errors.append(float(off[whom, followed].mean()) if followed.any() else 100.0)
                rows.append(
                    (
                        take.name,
                        beside.name,
                        f"{gap:.1f}",
                        "yes" if room else "no",
                        ("first", "second")[whom],
                        f"{errors[-1]:.2f}",
                        f"{100 * kept[-1]:.0f}",
                    )
                )
    return Findings(
        {
            "mean_cm": float(np.mean(errors)),
            "kept": 100.0 * float(np.mean(kept)),
            "kept_least": 100.0 * min(kept),
            "told": 100.0 * float(np.mean(told)),
            "takes": float(len(rows)),
        },
        (
            "Two other bodies than the tracker's beside each other, as far away, with the Kinect's noise; the reach of one "
            "ends so far from the other's. Nobody is pointed at: it is followed who is most like a body.",
        ),
        (
            Table(
                "Two people in view from the first frame on",
                ("one", "the other", "apart, m", "room", "followed", "error, cm", "of the frames, %"),
                tuple(rows),
            ),
        ),
    )


def _beside(one: Stage, other: Stage, gap: float) -> tuple[Stage, Stage]:
    """Both on one floor, the second to the right of the first, and both as far away as keeps them in view."""
    left, right = (each.joints.reshape(-1, 3) for each in (one, other))
    shift = np.array([left[:, 0].max() + gap - right[:, 0].min(), 0.0, np.median(left[:, 2]) - np.median(right[:, 2])])
    shift += (floor_of(one) - floor_of(other) - shift @ one.seen.up) * one.seen.up
    right = right + shift
    across = np.concatenate([left[:, 0], right[:, 0]])
    half = (across.max() - across.min()) / 2
    nearest = min(left[:, 2].min(), right[:, 2].min())
    back = np.array([-across.min() - half, 0.0, max(0.0, (half + 0.25) * KINECT.fx / KINECT.cx - nearest)])
    return _moved(one, back), _moved(other, shift + back)


def _moved(scene: Stage, shift: Floats) -> Stage:
    seen = View(scene.seen.turn, scene.seen.shift + shift, scene.seen.up)
    return replace(scene, seen=seen, poses=scene.poses.moved(np.eye(3), shift))


def _shown(two: Sequence[Stage], number: int, count: int, *, room: bool) -> list[DepthFrame]:
    """What the Kinect reports of both, with a floor and walls about them or with the background taken away."""
    own, near = roomed(two[0], number, count)
    both = [
        replace(frame, depth=np.fmin(frame.depth, other.depth))
        for frame, other in zip(own, foreign(two[1], number + 5, None, count), strict=True)
    ]
    floor, *walls = near
    joints = np.concatenate([one.joints.reshape(-1, 3) for one in two])
    walls = [replace(wall, distance=min(wall.distance, (joints @ wall.normal).min() - CLEAR)) for wall in walls]
    return noisy(both, number, (floor, *walls) if room else ())
