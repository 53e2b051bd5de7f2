"""Section 4, future work: bodies that are not the tracker's, a dozen motions, lengths and widths measured"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from motionmend.arrays import Floats
from motionmend.bodies.anatomy import average
from motionmend.bodies.performer import BONES, Poses
from motionmend.evaluate.scenes import performed
from motionmend.report.figures import lines_figure
from motionmend.track.measure.first_seconds import measure_person
from motionmend.track.model import TrackerModel
from motionmend.track.settings import TrackSettings, settings_of

from .common import FPS, Findings, Table
from .track_common import (
    ABOUT,
    BEND,
    DANCE,
    DOZEN,
    FAR,
    LIBRARY,
    SLOW,
    TURN,
    away,
    foreign,
    noisy,
    numbers,
    recorded,
    roomed,
    shown,
    stage,
    tracker,
)

MOST = 80  # frames of each motion
ROOM, NOISES, WHO = 60, 5, 40  # frames of each motion before floor and walls, seeds of the noise, whose shapes
TURNED = (25.0, -30.0, 15.0, -20.0, 35.0, -10.0)  # degrees by which the camera stands elsewhere
SIDES = (-40.0, 0.0, 40.0)  # degrees beside where our own body looks


def run(mocap: Path, pictures: Path) -> Findings:
    """Somebody else's surface with noise; our own body with and without noise; a person measured."""
    model, wish = tracker(mocap), settings_of("default")
    rows, every, off = [], [], []
    for who, take in enumerate(DOZEN):
        scene = stage(mocap, take)
        tracked = []
        for seed in range(NOISES):
            frames = foreign(scene, who, who + 100 * seed, MOST)
            track = recorded(model, wish, frames, scene.performer, scene.poses[0])
            tracked.append(away(scene.joints, track.steady(np.arange(len(frames)) / FPS)))
        errors = np.concatenate(tracked)
        rows.append((take.name, *numbers(errors)))
        every.append(errors)
        off.append(_off(errors))
    joined = np.concatenate(every)
    rows.append(("all", *numbers(joined)))
    lines_figure(
        pictures / "track_strangers.png",
        np.linspace(0, 100, 101),
        {"all motions": np.percentile(joined, np.linspace(0, 100, 101))},
        xlabel="share of joints and frames, %",
        ylabel="error, cm",
        log="y",
    )
    same, values = _own(mocap, wish)
    length, width = _measured(mocap, model, wish)
    seeds, rooms = _rooms(mocap, model, wish)
    return Findings(
        {
            **values,
            **rooms,
            "strangers_mean": float(joined.mean()),
            "strangers_95": float(np.percentile(joined, 95)),
            "strangers_far": 100.0 * float((joined > FAR).mean()),
            "strangers_lost": float(np.mean(off)),  # frames whose mean error is above 15 cm, whatever the tracker says
            "length_off": length,
            "width_off": width,
        },
        (
            ABOUT,
            f"Somebody else: a skin of spheres on the recording's own skeleton, hands and feet included, another shape for "
            f"each motion, {NOISES} seeds of the Kinect's noise, at most {MOST} frames; lengths and first pose given. The "
            f"tracker's own body: without noise and with {NOISES} seeds of it, each from {len(SIDES)} sides, the slow dance "
            f"of {SLOW.clip} by a library without it. Poses steadied as `motionmend track` does.",
            f"Floor and walls: six of the motions, other bodies and other headings than above, {ROOM} frames, {NOISES} seeds of "
            "the noise; the same with nothing but the body in view beside it. Means over seeds, and the seeds' standard "
            "deviation.",
            "Measured: a person 8 % taller than the average with 10 % longer legs and 12 % thicker limbs, walking and "
            "turning for 2 s with noise; neither lengths nor poses given.",
        ),
        (
            Table(
                f"Another body, noisy, {NOISES} seeds, cm",
                ("motion", "mean", "95 %", "largest", "> 15 cm, %"),
                tuple(rows),
            ),
            Table(
                f"Floor and walls in view, {NOISES} seeds, cm",
                (
                    "motion",
                    "body alone",
                    "95 %",
                    "> 15 cm, %",
                    "floor and walls",
                    "95 %",
                    "> 15 cm, %",
                    "frames > 15 cm on average, %",
                ),
                seeds,
            ),
            Table("The tracker's own body, cm", ("motion", "cm a frame", "clean", "noisy", "noisy, 95 %"), same),
        ),
        (("track_strangers.png", "Another body: error by share of joints and frames, twelve motions."),),
    )


def _own(mocap: Path, wish: TrackSettings) -> tuple[tuple[tuple[str, ...], ...], dict[str, float]]:
    """Rows and numbers of our own body, a slow and a fast dance, a bend and a turn."""
    rows, values = [], {}
    for take in (SLOW, DANCE, BEND, TURN):
        model = tracker(mocap, tuple(clip for clip in LIBRARY if clip != take.clip))
        clean, spoilt, pace = [], [], []
        for side in SIDES:
            scene = stage(mocap, replace(take, heading=take.heading + side))
            pace.append(100.0 * np.linalg.norm(np.diff(scene.joints, axis=0), axis=2).mean())
            for seed in (None, *range(NOISES)):
                frames = shown(scene, seed)
                track = recorded(model, wish, frames, scene.performer, scene.poses[0])
                errors = away(scene.joints, track.steady(np.arange(len(frames)) / FPS))
                (clean if seed is None else spoilt).append(errors)
        still, noisy = np.concatenate(clean), np.concatenate(spoilt)
        rows.append(
            (
                take.name,
                f"{np.mean(pace):.1f}",
                f"{still.mean():.2f}",
                f"{noisy.mean():.2f}",
                f"{np.percentile(noisy, 95):.2f}",
            )
        )
        short = take.name.replace(" ", "_")
        values |= {f"{short}_clean": float(still.mean()), f"{short}_noisy": float(noisy.mean())}
    return tuple(rows), values


def _rooms(
    mocap: Path, model: TrackerModel, wish: TrackSettings
) -> tuple[tuple[tuple[str, ...], ...], dict[str, float]]:
    """Rows and numbers of somebody else before floor and walls, and of the same body alone."""
    rows = []
    every: dict[str, list[Floats]] = {"alone": [], "room": []}  # for each motion (seeds, frames, 16)
    for k, name in enumerate(("bend", "kick", "walk across", "boxing", "hop", "dance")):
        take = next(one for one in DOZEN if one.name == name)
        scene = stage(mocap, replace(take, heading=take.heading + TURNED[k]))
        clean, planes = roomed(scene, WHO + k, ROOM)
        row = [name]
        for kind, around in (("alone", ()), ("room", planes)):
            errors = []
            for seed in range(NOISES):
                frames = noisy(clean, seed, around)
                track = recorded(model, wish, frames, scene.performer, scene.poses[0])
                errors.append(away(scene.joints, track.steady(np.arange(len(frames)) / FPS)))
            joined = np.array(errors)
            every[kind].append(joined)
            spread = joined.mean(axis=(1, 2)).std(ddof=1)
            row += [f"{joined.mean():.2f} ± {spread:.2f}", f"{np.percentile(joined, 95):.1f}", f"{_far(joined):.1f}"]
        rows.append((*row, f"{_off(every['room'][-1]):.1f}"))
    found: dict[str, float] = {}
    for kind, parts in every.items():
        joined = np.concatenate([part.reshape(NOISES, -1) for part in parts], axis=1)
        found |= {
            f"{kind}_mean": float(joined.mean()),
            f"{kind}_spread": float(joined.mean(axis=1).std(ddof=1)),
            f"{kind}_95": float(np.percentile(joined, 95)),
            f"{kind}_far": _far(joined),
        }
    total = [
        f"{found[f'{kind}_{name}']:.1f}"
        if name != "mean"
        else f"{found[f'{kind}_mean']:.2f} ± {found[f'{kind}_spread']:.2f}"
        for kind in every
        for name in ("mean", "95", "far")
    ]
    found["room_lost"] = _off(np.concatenate(every["room"], axis=1))
    rows.append(("all", *total, f"{found['room_lost']:.1f}"))
    return tuple(rows), found


def _far(errors: Floats) -> float:
    """Share above 15 cm, %."""
    return 100.0 * float((errors > FAR).mean())


def _off(errors: Floats) -> float:
    """Share of frames, %, whose mean error over the joints, the last axis, is above 15 cm."""
    return 100.0 * float((errors.mean(axis=-1) > FAR).mean())


def _measured(mocap: Path, model: TrackerModel, wish: TrackSettings) -> tuple[float, float]:
    """Mean relative error of bone lengths and of limbs' widths, measured from two seconds of a person."""
    factor = np.full((len(BONES), 3), 1.08)
    for b, bone in enumerate(BONES):
        if bone.endswith(("thigh", "shank")):
            factor[b] *= (1.12, 1.10, 1.12)
    truth = average().stretched(factor)
    poses: Poses = stage(mocap, TURN).poses.some(slice(0, 60))
    moved = poses.moved(np.eye(3), np.array([0.0, 0.0, 0.3]))
    frames = list(performed(moved, truth, fps=FPS, seed=5))[::2]
    found = measure_person(model, wish, frames).performer
    use = [b for b, bone in enumerate(BONES) if bone.endswith(("upperarm", "forearm", "thigh", "shank"))]
    limbs = np.isin(truth.solids.bone, use)
    length = np.abs(found.lengths[use] / truth.lengths[use] - 1.0).mean()
    width = np.abs(found.solids.size[limbs][:, [0, 2]] / truth.solids.size[limbs][:, [0, 2]] - 1.0).mean()
    return 100.0 * float(length), 100.0 * float(width)
