"""Table 3.1 in kind: UTD-MHAD beside the sensor's own skeleton"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from motionmend.arrays import Bools, Floats
from motionmend.bodies.camera import DepthFrame
from motionmend.bodies.joint_sets import correspondence
from motionmend.bodies.performer import LANDMARKS
from motionmend.errors import FileError, MismatchError
from motionmend.io.depth import read_depth
from motionmend.io.sensor import read_postures
from motionmend.report.figures import lines_figure
from motionmend.track.measure.first_seconds import measure_person
from motionmend.track.settings import settings_of

from .common import Findings, Table
from .correct_common import kinect_in
from .track_common import recorded, tracker
from .track_verdict import DISPUTED, MARGIN, Dispute, disputes, draw

ACTIONS = {
    "a6_s2_t1": "cross arms",
    "a9_s3_t1": "draw a circle",
    "a13_s4_t1": "box",
    "a14_s1_t1": "baseball swing",
    "a17_s5_t1": "tennis serve",
    "a21_s2_t1": "pick up and throw",
    "a22_s3_t1": "jog on the spot",
    "a24_s3_t1": "sit to stand",
    "a26_s1_t1": "lunge",
    "a27_s5_t1": "squat",
}
MOVING = 0.2  # m; joints that go this far count
SHIFTS = (0, 1, 2, 3)  # frames by which the sensor's skeleton may be ahead of its depth
BONES = (("shoulder", "elbow"), ("elbow", "wrist"), ("hip", "knee"), ("knee", "ankle"))


def run(mocap: Path, pictures: Path) -> Findings:
    """All recordings, nothing given: on the silhouette, distance from the sensor, jerk, lost frames. Ten are listed."""
    model, wish = tracker(mocap), settings_of("default")
    folder = kinect_in(mocap) / "utdmhad"
    if not folder.is_dir():
        raise FileError(f"{folder} was to hold UTD-MHAD's depth images, there are none: give the folder that has them")
    rows: list[tuple[str, ...]] = []
    gaps, lost = [], []
    dated: dict[int, list[Floats]] = {shift: [] for shift in SHIFTS}
    found: dict[str, list[float]] = {name: [] for name in ("inside", "jerk", "vary")}
    theirs_found: dict[str, list[float]] = {name: [] for name in found}
    disputed: list[tuple[Dispute, str, DepthFrame, Floats, Floats]] = []
    every: list[Dispute] = []
    verdicts: list[tuple[str, ...]] = []
    files = sorted((folder / "Depth").glob("*_depth.mat"))
    for file in files:
        name = file.name.removesuffix("_depth.mat")
        recording = read_depth(file)
        sensor = read_postures(folder / "Skeleton" / f"{name}_skeleton.mat")
        frames = [recording.true_frame(t) for t in range(recording.frames)]
        try:
            body = measure_person(model, wish, frames[:60:3]).performer
        except MismatchError:
            lost.append(np.ones(len(frames), bool))
            continue
        track = recorded(model, wish, frames, body)
        joints = track.steady(recording.times)
        theirs = _in_camera(sensor.positions, sensor.names)
        gap = _gap(joints, theirs, track.lost)
        for places, numbers in ((joints, found), (theirs, theirs_found)):
            numbers["inside"].append(100.0 * _on_silhouette(places, frames))
            numbers["jerk"].append(_jerk(places, recording.fps))
            numbers["vary"].append(_lengths_vary(places))
        gaps.append(gap)
        for shift, apart in dated.items():
            apart.append(_gap(joints[shift:], theirs[: len(theirs) - shift], track.lost[shift:]))
        lost.append(track.lost)
        some = disputes(joints, theirs, track.lost, frames, MOVING)
        every += some
        if name not in ACTIONS:
            continue
        disputed += [(one, ACTIONS[name], frames[one.frame], joints[one.frame], theirs[one.frame]) for one in some]
        verdicts.append((f"{ACTIONS[name]} ({name})", *(str(count) for count in _counts(some))))
        both = {key: (found[key][-1], theirs_found[key][-1]) for key in found}
        rows.append(
            (
                f"{ACTIONS[name]} ({name})",
                "{:.1f} / {:.1f}".format(*both["inside"]),
                f"{np.median(gap):.1f}",
                f"{np.percentile(gap, 95):.1f}",
                "{:.0f} / {:.0f}".format(*both["jerk"]),
                "{:.1f} / {:.1f}".format(*both["vary"]),
                f"{100 * track.lost.mean():.0f}",
            )
        )
    moved = np.concatenate(gaps)
    later = {shift: np.concatenate(apart) for shift, apart in dated.items()}
    ahead = min(later, key=lambda shift: float(np.median(later[shift])))
    count, ours_right, sensor_right, both_wrong, undecided = _counts(every)
    verdicts.append(("all", *(str(number) for number in _counts(every))))
    draw(
        pictures / "track_disputes.png",
        [
            (frame, ours, theirs, f"{action}\nframe {one.frame}: {'ours' if one.right == 'ours' else 'the sensor'}")
            for one, action, frame, ours, theirs in _worst(disputed)
        ],
    )
    lines_figure(
        pictures / "track_table_1.png",
        np.linspace(0, 100, 101),
        {"moving joints": np.percentile(moved, np.linspace(0, 100, 101))},
        xlabel="share of joints and frames, %",
        ylabel="away from the sensor's skeleton, cm",
        log="y",
    )
    return Findings(
        {
            "inside": float(np.mean(found["inside"])),
            "inside_sensor": float(np.mean(theirs_found["inside"])),
            "better": float(np.sum(np.array(found["inside"]) >= np.array(theirs_found["inside"]) - 2.0)),
            "recordings": float(len(files)),
            "gap_median": float(np.median(moved)),
            "gap_95": float(np.percentile(moved, 95)),
            "jerk": float(np.mean(found["jerk"])),
            "jerk_sensor": float(np.mean(theirs_found["jerk"])),
            "utd_lost": 100.0 * float(np.concatenate(lost).mean()),
            "ahead": float(ahead),
            "ahead_median": float(np.median(later[ahead])),
            "ahead_95": float(np.percentile(later[ahead], 95)),
            "disputed": float(count),
            "ours_right": 100.0 * ours_right / max(count, 1),
            "sensor_right": 100.0 * sensor_right / max(count, 1),
            "both_wrong": 100.0 * both_wrong / max(count, 1),
            "undecided": 100.0 * undecided / max(count, 1),
            "vary": float(np.mean(found["vary"])),
            "vary_sensor": float(np.mean(theirs_found["vary"])),
        },
        (
            "UTD-MHAD: first Kinect, 320 x 240, persons without background, the sensor's own skeleton beside it. Lengths, "
            "widths and first pose found by the tracker. The sensor's joints lie elsewhere in the body: a constant offset "
            f"for each joint (the median) is taken off, and joints count that move {100 * MOVING:.0f} cm or more. On the "
            "silhouette: within two pixels of the person's. The sensor's skeleton is no truth.",
            f"Who is right: every arm and leg in every frame where a joint of it is more than {DISPUTED:.0f} cm apart. Against "
            "either speak the parts of the limb's bones that lie beside the body or before its visible surface, and the "
            "surface farther from any bone than a body is thick, both as areas; who has less by at least "
            f"{1e4 * MARGIN:.0f} cm2 is right, else it stays open; with more than {2e4 * MARGIN:.0f} cm2 against both neither is. "
            "Who fits a body to the surface is favoured by that; a wrong limb within the body is only refuted by the surface "
            "that it leaves unexplained.",
        ),
        (
            Table(
                "Ten of the recordings, ours / the sensor's",
                (
                    "action",
                    "on the silhouette, %",
                    "apart, median cm",
                    "95 %",
                    "jerk, m/s3",
                    "lengths vary, %",
                    "frames lost, %",
                ),
                tuple(rows),
            ),
            Table(
                "The sensor's skeleton compared with the depth image of so many frames later",
                ("frames", "apart, median cm", "95 %"),
                tuple(
                    (str(shift), f"{np.median(apart):.1f}", f"{np.percentile(apart, 95):.1f}")
                    for shift, apart in later.items()
                ),
            ),
            Table(
                "Limbs disputed, and who is right by the depth image",
                ("action", "limbs times frames", "ours", "the sensor's", "neither", "open"),
                tuple(verdicts),
            ),
        ),
        (
            ("track_table_1.png", "Distance from the sensor's skeleton after a constant offset for each joint."),
            (
                "track_disputes.png",
                "Disputes, from the camera and the side: ours orange, the sensor's skeleton blue, above who is right.",
            ),
        ),
    )


def _counts(some: Sequence[Dispute]) -> list[int]:
    """All, those where ours is right, the sensor is, neither is, and those that stay open."""
    return [len(some), *(sum(one.right == who for one in some) for who in ("ours", "sensor", "neither", "open"))]


def _worst(
    disputed: Sequence[tuple[Dispute, str, DepthFrame, Floats, Floats]], most: int = 3
) -> list[tuple[Dispute, str, DepthFrame, Floats, Floats]]:
    """The largest disputes of different actions, first those in which ours is right, then those in which it is not."""
    chosen: list[tuple[Dispute, str, DepthFrame, Floats, Floats]] = []
    for who in ("ours", "sensor"):
        seen: set[str] = set()
        for one in sorted(disputed, key=lambda one: -one[0].apart):
            if one[0].right == who and one[1] not in seen and len(seen) < most:
                seen.add(one[1])
                chosen.append(one)
    return chosen


def _in_camera(positions: Floats, names: Sequence[str]) -> Floats:
    """The sensor's joints (T, 16, 3), y up and mirrored, in the camera's axes; NaN where it has none."""
    match = correspondence(names, LANDMARKS)
    return np.where((match >= 0)[None, :, None], (positions * (-1.0, -1.0, 1.0))[:, np.maximum(match, 0)], np.nan)


def _on_silhouette(joints: Floats, frames: Sequence[DepthFrame]) -> float:
    """Share of the joints within two pixels of the person's."""
    from scipy.ndimage import binary_dilation

    hits = []
    for places, frame in zip(joints, frames, strict=True):
        body = binary_dilation(np.isfinite(frame.depth), np.ones((5, 5), bool))
        pixels = np.round(frame.camera.project(places[np.isfinite(places).all(axis=1)])).astype(int)
        inside = (pixels >= 0).all(axis=1) & (pixels[:, 0] < frame.camera.width) & (pixels[:, 1] < frame.camera.height)
        hits.append(np.where(inside, body[np.clip(pixels[:, 1], 0, 239), np.clip(pixels[:, 0], 0, 319)], False))
    return float(np.concatenate(hits).mean())


def _gap(ours: Floats, theirs: Floats, lost: Bools) -> Floats:
    """(N,) cm between the two after a constant offset for each joint, of joints that move and frames not lost."""
    apart = (ours - theirs)[~lost]
    known = np.isfinite(theirs).all(axis=(0, 2)) & (np.ptp(theirs, axis=0).max(axis=1) > MOVING)
    apart = apart[:, known] - np.median(apart[:, known], axis=0)
    return np.asarray(100.0 * np.linalg.norm(apart, axis=2).ravel())


def _jerk(joints: Floats, fps: float) -> float:
    """Median length of the third derivative over joints and frames, m/s3."""
    return float(np.nanmedian(np.linalg.norm(np.diff(joints, 3, axis=0), axis=2)) * fps**3)


def _lengths_vary(joints: Floats) -> float:
    """Standard deviation of the limbs' lengths over time, % of their means."""
    found = []
    for side in "lr":
        for a, b in BONES:
            length = np.linalg.norm(
                joints[:, LANDMARKS.index(f"{side}_{a}")] - joints[:, LANDMARKS.index(f"{side}_{b}")], axis=1
            )
            found.append(100.0 * length.std() / length.mean())
    return float(np.mean(found))
