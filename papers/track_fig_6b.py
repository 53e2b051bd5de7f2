"""Figure 3.6b: an arm out of sight, with and without a prior, of many motions or of this one"""

from dataclasses import replace
from pathlib import Path

import numpy as np

import motionmend as mm
from motionmend.arrays import Floats
from motionmend.bodies.performer import LANDMARKS
from motionmend.report.figures import lines_figure
from motionmend.track.model import TrackerModel
from motionmend.track.settings import PER_RADIAN, settings_of

from .common import FPS, Findings, Table, motion, reduced
from .track_common import ABOUT, BENDS, LIBRARY, away, follow, hidden, shown, stage

ARM = [LANDMARKS.index(f"l_{joint}") for joint in ("elbow", "wrist")]
AFTER = 10  # frames after the arm is back that still count
STRENGTHS = (0.001, 0.01, 0.1)


def run(mocap: Path, pictures: Path) -> Findings:
    """Error of elbow and wrist while they are hidden and ten frames after."""
    scenes = [stage(mocap, take) for take in BENDS]
    gone = [hidden(scene) for scene in scenes]
    counted = [np.array([one[max(0, t - AFTER) : t + 1].any() for t in range(len(one))]) for one in gone]
    frames = [shown(scene, colored=True) for scene in scenes]
    whole = motion(mocap, BENDS[0].clip)
    other = mm.Motion(whole.skeleton, np.concatenate((whole.q[: BENDS[0].first], whole.q[BENDS[0].last :])), whole.fps)
    own = [reduced(other, FPS, phase) for phase in range(4)]
    many = [reduced(motion(mocap, clip), FPS) for clip in LIBRARY]
    models = {
        "specific": TrackerModel.fit(own, detector=False),
        "mixed": TrackerModel.fit([*many, *own], detector=False),
        "strange": TrackerModel.fit(many, detector=False),
    }
    curves: dict[str, Floats] = {}
    hurt: dict[str, list[float]] = {}
    rows: list[tuple[str, ...]] = []

    def tried(name: str, model: TrackerModel, preset: str, terms: tuple[str, ...], prior: float) -> None:
        wish = replace(settings_of(preset, terms), prior=prior)
        arms, bodies = [], []
        for scene, images, some in zip(scenes, frames, counted, strict=True):
            track = follow(model, wish, images, scene.performer, scene.poses[0])
            errors = away(scene.joints, track.joints)
            arms.append(errors[:, ARM].mean(axis=1))
            bodies.append(float(errors.mean()))
            hurt.setdefault(name, []).append(float(arms[-1][some].mean()))
        curves[name] = arms[0]
        rows.append((name, *(f"{one:.1f}" for one in hurt[name]), *(f"{one:.2f}" for one in bodies)))

    plain = ("surface", "color", "edge")
    tried("no prior", models["mixed"], "paper", plain, 0.0)
    for kind in ("specific", "mixed"):
        for strength in STRENGTHS:
            tried(f"{kind} {strength:g}", models[kind], "paper", (*plain, "prior"), strength * PER_RADIAN)
    ours = settings_of("default")
    tried("default, no prior", models["mixed"], "default", tuple(t for t in ours.terms if t != "prior"), 0.0)
    for kind in models:
        tried(f"default, {kind}", models[kind], "default", ours.terms, ours.prior)
    chosen = ("no prior", "specific 0.001", "mixed 0.001", "default, mixed")
    lines_figure(
        pictures / "track_fig_6b.png",
        np.arange(len(frames[0]), dtype=float),
        {name: curves[name] for name in chosen},
        xlabel="frame",
        ylabel="error of the arm, cm",
        leading=("default, mixed",),
    )
    none, ours_none = np.array(hurt["no prior"]), np.array(hurt["default, no prior"])
    return Findings(
        {
            "arm_none": float(none.mean()),
            "arm_specific": float(np.mean(hurt["specific 0.001"])),
            "arm_mixed": float(np.mean(hurt["mixed 0.001"])),
            "specific_of_none": float(np.max(hurt["specific 0.001"] / none)),
            "mixed_of_none": float(np.max(hurt["mixed 0.001"] / none)),
            "arm_default_none": float(ours_none.mean()),
            "arm_default": float(np.mean(hurt["default, mixed"])),
            "arm_default_worst": float(np.max(hurt["default, mixed"])),
            "arm_default_strange": float(np.mean(hurt["default, strange"])),
            "default_of_none": float(np.max(hurt["default, mixed"] / ours_none)),
            "hidden_frames": float(sum(one.sum() for one in gone)),
            "specific_poses": float(len(models["specific"].database)),
            "mixed_poses": float(len(models["mixed"].database)),
        },
        (
            ABOUT,
            f"CMU {BENDS[0].clip}, {len(frames[0])} frames, from two sides on which the left forearm is out of sight in "
            f"{gone[0].sum()} and {gone[1].sum()}; these and ten after each count. `specific` holds the other parts of the clip, `mixed` those and fourteen "
            "other clips, `strange` the fourteen alone; the number is lambda2, on metres and degrees.",
        ),
        (
            Table(
                "A bend with a hidden arm, cm",
                ("prior", "arm, view 1", "arm, view 2", "all joints, 1", "all joints, 2"),
                tuple(rows),
            ),
        ),
        (("track_fig_6b.png", "Error of elbow and wrist by frame."),),
    )
