"""Figure 2.6: both arms missing from the first frame to the last

Three kinds of data: real markers (.c3d) of the takes at hand, joint positions of .amc walks as markers, joint angles.
Interpolation and marker intercorrelation have nothing to start from; what they leave open is counted.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

import motionmend as mm
from motionmend.arrays import Bools, Ints
from motionmend.bodies.skeleton import positions
from motionmend.denoise.channels.recording import from_channels, to_channels
from motionmend.report.edges import rigid_edges
from motionmend.report.figures import skeleton_figure

from .common import SPLITS, WALKS, Findings, Table, distances, markers, motion, motions, only, reduced, stretch
from .pictures import parents_along, parents_within

CMU = (
    "LFHD", "RFHD", "LBHD", "RBHD", "C7", "T10", "CLAV", "STRN", "RBAC", "LSHO", "LUPA", "LELB", "LFRM", "LWRA",
    "LWRB", "LFIN", "RSHO", "RUPA", "RELB", "RFRM", "RWRA", "RWRB", "RFIN", "LFWT", "RFWT", "LBWT", "RBWT",
    "LTHI", "LKNE", "LSHN", "LANK", "LHEE", "LTOE", "LMT5", "RTHI", "RKNE", "RSHN", "RANK", "RHEE", "RTOE", "RMT5"
)  # fmt: skip
CMU_ARMS = tuple(side + name for side in "LR" for name in ("UPA", "ELB", "FRM", "WRA", "WRB", "FIN"))
SFU_ARMS = tuple(side + name for side in "LR" for name in ("UPA", "ELB", "IEL", "OWR", "IWR", "WRE", "IHAND", "OHAND"))
# joints of the CMU skeleton that lie apart from each other
JOINTS = (
    "root", "lfemur", "ltibia", "lfoot", "ltoes", "rfemur", "rtibia", "rfoot", "rtoes", "upperback", "thorax",
    "lowerneck", "head", "head_end", "lclavicle", "lhumerus", "lradius", "lhand", "lfingers", "rclavicle",
    "rhumerus", "rradius", "rhand", "rfingers"
)  # fmt: skip
JOINT_ARMS = ("lradius", "lhand", "lfingers", "rradius", "rhand", "rfingers")
ARM_ANGLES = tuple(s + b for s in "lr" for b in ("humerus", "radius", "wrist", "hand", "fingers", "thumb"))
MOMENTS = 7
RIVALS = ("linear", "spline", "pca")


@dataclass(frozen=True)
class Case:
    """Recordings to learn from and to try, and the markers that go missing."""

    title: str
    learn: tuple[mm.Markers, ...]
    test: tuple[mm.Markers, ...]
    arms: tuple[str, ...]


def run(mocap: Path, pictures: Path) -> Findings:
    """Distance of the filled arms from the truth in each case, beside the mean pose of the clips learned from."""
    values: dict[str, float] = {}
    rows = []
    shown: dict[str, tuple[mm.Markers, mm.Markers, mm.Markers]] = {}
    for key, case in cases(mocap).items():
        model = mm.Denoiser().fit(case.learn)
        found: dict[str, list[float]] = {name: [] for name in ("paper", "std", "mean", *RIVALS)}
        for truth in case.test:
            cut = mm.corrupt(truth, drop=case.arms).recording
            gone = truth.present & ~cut.present
            repaired = model.repair(cut, "paper")
            # a deviation is of one coordinate, a distance has three
            found["std"].append(float(100 * np.sqrt(3 * np.square(repaired.std[gone]).mean())))
            filled = {"paper": repaired.recording} | {name: model.repair(cut, name).recording for name in RIVALS}
            filled["mean"] = mean_pose(cut, model)
            for name, recording in filled.items():
                found[name].append(float(distances(truth.positions, recording.positions, gone).mean()))
            shown.setdefault(key, (truth, cut, filled["paper"]))
        error = {name: float(np.mean(errors)) for name, errors in found.items()}
        values[key] = error["paper"]
        values[f"{key}_mean"] = error["mean"]
        for rival in RIVALS:
            values[f"{key}_{rival}_open"] = float(np.isnan(error[rival]))
        text = {name: "left open" if np.isnan(e) else f"{e:.1f}" for name, e in error.items()}
        learned = sum(clip.frames for clip in case.learn)
        rows.append((case.title, f"{learned:,}", *(text[name] for name in ("paper", "std", "mean", *RIVALS))))
    angles = joint_angles(mocap)
    rows.append(("joint angles (.amc), same walker", *angles.pop("row")))
    values |= angles
    values["rivals_fill"] = float(sum(1 for name, v in values.items() if name.endswith("_open") and v == 0))
    skeleton = motion(mocap, SPLITS["walking"].test[0]).skeleton
    draw(pictures / "fig_2_6.png", *shown["walker"], parents_within(skeleton, JOINTS))
    truth = shown["walk"][0]
    parents = parents_along(rigid_edges(truth.names, truth.positions), len(truth.names))
    draw(pictures / "fig_2_6_c3d.png", *shown["walk"], parents)
    return Findings(
        values=values,
        notes=(
            "Distances from the truth over all missing markers or joints and all frames, cm; shoulders stay.",
            "Mean pose: the arms stand still where they were on average in the clips learned from, carried by the body.",
            "Its own deviation: the standard deviation that the repair states for the filled samples, as a distance.",
            "There are few .c3d takes of one marker set: a take teaches with its first part and is tried on its last.",
            "Vicon Blade, the paper's commercial rival, is not at hand.",
        ),
        tables=(
            Table(
                "Both arms missing throughout: distance from the truth, cm",
                ("recording", "frames learned", "paper", "its own deviation", "mean pose", *RIVALS),
                tuple(rows),
            ),
        ),
        figures=(
            ("fig_2_6.png", "Joints of a walk: arms missing, and filled; thin: the truth."),
            ("fig_2_6_c3d.png", "Markers of a walk (02_01.c3d): arms missing, and filled; thin: the truth."),
        ),
    )


def cases(mocap: Path) -> dict[str, Case]:
    """What is tried."""
    split = SPLITS["walking"]
    strangers = tuple(clip for clip in WALKS if not clip.startswith("16_"))
    walk, kata = only(markers(mocap, "cmu_02_01"), CMU), only(markers(mocap, "cmu_135_02"), CMU)
    family, other = (only(markers(mocap, f"hdm05_bd_{n}_01_120"), CMU) for n in ("01-02", "05-01"))
    skip = markers(mocap, "sfu_0005_SideSkip001")
    return {
        "walker": Case(
            "joints of walks, same walker",
            tuple(joints_as_markers(clip) for clip in motions(mocap, split.learn)),
            tuple(joints_as_markers(clip) for clip in motions(mocap, split.test)),
            JOINT_ARMS,
        ),
        "strangers": Case(
            "joints of walks, learned from other people",
            tuple(joints_as_markers(clip) for clip in motions(mocap, strangers)),
            tuple(joints_as_markers(clip) for clip in motions(mocap, split.test)),
            JOINT_ARMS,
        ),
        "hdm05": Case(
            "markers, HDM05 walking family, last third",
            (stretch(family, 0.0, 0.65), other),
            (stretch(family, 0.65, 1.0),),
            CMU_ARMS,
        ),
        "kata": Case(
            "markers, CMU 135_02 martial arts, last third",
            (stretch(kata, 0.0, 0.65),),
            (stretch(kata, 0.65, 1.0),),
            CMU_ARMS,
        ),
        "walk": Case(
            "markers, CMU 02_01 walk, last 40 %", (stretch(walk, 0.0, 0.6),), (stretch(walk, 0.6, 1.0),), CMU_ARMS
        ),
        "skip": Case(
            "markers, SFU side skip, last third", (stretch(skip, 0.0, 0.65),), (stretch(skip, 0.65, 1.0),), SFU_ARMS
        ),
    }


def joints_as_markers(recording: mm.Motion) -> mm.Markers:
    """The joints of a motion as if each carried a marker."""
    at = positions(recording.skeleton, recording.q)
    columns = [recording.skeleton.names.index(name) for name in JOINTS]
    return mm.Markers(JOINTS, at[:, columns], recording.fps, up=recording.skeleton.up)


def mean_pose(cut: mm.Markers, model: mm.DenoiserModel) -> mm.Markers:
    """The recording with every missing marker at its mean place in the body's travelling frame."""
    channels = to_channels(cut, model.layout)
    filled = np.where(np.isfinite(channels.values), channels.values, model.bases.mean.mean(axis=0))
    everywhere: Bools = np.ones(filled.shape, dtype=bool)
    return cut.with_positions(from_channels(channels, filled, everywhere, cut))


def joint_angles(mocap: Path) -> dict[str, float | tuple[str, ...]]:
    """The same in joint angles: both arms' channels missing, scored at the joints they move."""
    split = SPLITS["walking"]
    model = mm.Denoiser().fit(motions(mocap, split.learn))
    arms = [motion(mocap, split.test[0]).skeleton.names.index(name) for name in JOINT_ARMS]
    found: dict[str, list[float]] = {"paper": [], "mean": []}
    for clip in split.test:
        truth = reduced(motion(mocap, clip))
        cut = mm.corrupt(truth, drop=ARM_ANGLES).recording
        true_at = positions(truth.skeleton, truth.q)[:, arms]
        channels = to_channels(cut, model.layout)
        standing = np.where(np.isfinite(channels.values), channels.values, model.bases.mean.mean(axis=0))
        everywhere: Bools = np.ones(standing.shape, dtype=bool)
        for name, q in (
            ("paper", model.repair(cut, "paper").recording.q),
            ("mean", from_channels(channels, standing, everywhere, cut)),
        ):
            at = positions(truth.skeleton, q)[:, arms]
            found[name].append(float(100 * np.linalg.norm(at - true_at, axis=2).mean()))
    means = {name: float(np.mean(errors)) for name, errors in found.items()}
    return {
        "angles": means["paper"],
        "angles_mean": means["mean"],
        "row": (
            f"{model.frames:,}",
            f"{means['paper']:.1f}",
            "-",
            f"{means['mean']:.1f}",
            "left open",
            "left open",
            "-",
        ),
    }


def draw(
    path: Path, truth: mm.Markers, cut: mm.Markers, filled: mm.Markers, parents: Ints, moments: int = MOMENTS
) -> None:
    """A few moments of the recording with the arms missing and filled, the truth behind them."""
    skeleton_figure(
        path,
        {"arms missing": cut.positions, "repaired": filled.positions},
        parents,
        frames=[int(frame) for frame in np.linspace(0.1, 0.9, moments) * truth.frames],
        fps=truth.fps,
        up=truth.up,
        ghost=truth.positions,
    )
