"""Sections 3.8 and 4, beyond: somebody else walks through between the camera and the person, or behind them"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from motionmend.arrays import Floats, Singles
from motionmend.evaluate.scenes import View
from motionmend.track.recording import UNSURE
from motionmend.track.settings import settings_of

from .common import Findings, Table
from .track_common import (
    BEND,
    FAR,
    FPS,
    KICK,
    TURN,
    Stage,
    Take,
    Track,
    away,
    foreign,
    noisy,
    recorded,
    roomed,
    stage,
    tracker,
)

TAKES = (
    BEND,
    TURN,
    KICK,
    Take("boxing", "02_05", 200, 520),
    Take("jump", "16_02", 0, 320),
    Take("walk", "02_01", 0, 343),
)
WALKER = Take("slow walk", "07_04", 0, 449, 80.0)  # from one side of the picture to the other
PASSER = 7  # whose body walks through
APART = 0.9  # m, from the person
NOISES = 4  # seeds: how who was out of sight is found again hangs by the noise
IN_SIGHT = 0.7  # share of the person's pixels that the passer leaves, from which on a frame counts


def run(mocap: Path, pictures: Path) -> Findings:
    """Six takes of other bodies before floor and walls, noisy; each alone, with a passer before it and with one behind."""
    del pictures
    model, wish = tracker(mocap), settings_of("default")
    walker = stage(mocap, WALKER)
    rows: list[tuple[str, ...]] = []
    error: dict[str, list[float]] = {"alone": [], "before": [], "behind": []}
    strange, wrong = [], []
    for number, take in enumerate(TAKES):
        scene = stage(mocap, take)
        own, near = roomed(scene, number, len(scene.poses))
        # The wall behind has room before it for one more; `normal` is towards the camera, distances are negative.
        planes = tuple(
            replace(one, distance=one.distance - 2.0 * APART) if one.normal[2] < -0.5 else one for one in near
        )
        for way in error:
            passer = None if way == "alone" else _passer(scene, walker, way == "before", len(own))
            both = [
                frame if passer is None else replace(frame, depth=np.fmin(frame.depth, passer[t]))
                for t, frame in enumerate(own)
            ]
            seen = np.array([_share(frame.depth, both[t].depth) for t, frame in enumerate(own)])
            counted = seen > IN_SIGHT
            tracks = [
                recorded(model, wish, noisy(both, number + 100 * seed, planes), scene.performer, scene.poses[0])
                for seed in range(NOISES)
            ]
            times = np.arange(len(own)) / FPS
            off = np.array([away(scene.joints, track.steady(times)) for track in tracks])
            lost = np.array([track.lost for track in tracks])
            said = (np.array([track.std for track in tracks]) < UNSURE) & ~lost[..., None]
            sure_wrong = float((said & (off > FAR)).sum() / max(said.sum(), 1))
            error[way].append(float(off[:, counted].mean()))
            if passer is not None:
                wrong.append(sure_wrong)
                strange.append(float(np.mean([_followed(track, scene) for track in tracks])))
            spread = off[:, counted].mean(axis=(1, 2))
            rows.append(
                (
                    take.name,
                    way,
                    f"{100 * seen.min():.0f}",
                    f"{spread.mean():.2f}",
                    f"{spread.min():.2f} to {spread.max():.2f}",
                    f"{100 * lost[:, counted].mean():.0f}",
                    f"{100 * sure_wrong:.1f}",
                )
            )
    mean = {way: float(np.mean(values)) for way, values in error.items()}
    return Findings(
        {
            **{f"{way}_cm": value for way, value in mean.items()},
            "before_share": mean["before"] / mean["alone"],
            "behind_share": mean["behind"] / mean["alone"],
            "strange": 100.0 * float(np.mean(strange)),
            "sure_wrong": 100.0 * float(np.mean(wrong)),
            "takes": float(len(TAKES)),
        },
        (
            f"Other bodies than the tracker's before floor and walls, {NOISES} seeds of the Kinect's noise, the first pose given. "
            f"Somebody else walks across {100 * APART:.0f} cm before the person, or behind. Errors are over frames in which the passer "
            f"leaves more than {100 * IN_SIGHT:.0f} % of the person in sight.",
        ),
        (
            Table(
                "Somebody walks through",
                ("motion", "passer", "least in sight, %", "error, cm", "by seed", "lost, %", "sure and 15 cm off, %"),
                tuple(rows),
            ),
        ),
    )


def _passer(scene: Stage, walker: Stage, before: bool, frames: int) -> list[Singles]:
    """True depth of somebody who walks across the picture, on the same floor; they are before the person half-way."""
    person = scene.joints.reshape(-1, 3)
    wanted = person[:, 2].min() - APART if before else person[:, 2].max() + APART
    way = walker.joints[:, 0]
    middle = way[min(frames, len(way)) // 2]
    shift = np.array([np.median(person[:, 0]) - middle[0], 0.0, wanted - np.median(way[:, 2])])
    shift += (floor_of(scene) - floor_of(walker) - shift @ scene.seen.up) * scene.seen.up
    seen = walker.seen
    moved = replace(walker, seen=View(seen.turn, seen.shift + shift, seen.up))
    drawn = [frame.depth for frame in foreign(moved, PASSER, None, frames)]
    return [*drawn, *[np.full_like(drawn[0], np.nan)] * (frames - len(drawn))]


def floor_of(scene: Stage) -> float:
    """m along the vertical, where the lowest of the feet stand, in camera axes."""
    return float(np.percentile(scene.joints[:, [12, 15]] @ scene.seen.up, 10))


def _share(own: Singles, both: Singles) -> float:
    """Share of the person's pixels that nothing stands before."""
    there = np.isfinite(own)
    return float((both[there] >= own[there]).mean())


def _followed(track: Track, scene: Stage) -> float:
    """Share of the tracked frames in which the trunk is more than half a metre from the person's: it is another's."""
    trunk: Floats = np.linalg.norm(track.joints[:, :2] - scene.joints[: len(track.joints), :2], axis=2).mean(axis=1)
    return float((trunk[~track.lost] > 0.5).mean())
