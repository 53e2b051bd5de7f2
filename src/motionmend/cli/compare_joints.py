"""What `compare` does with joint positions: tables of joints and what sensors report, against each other."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import counted
from .inputs import ending
from .output import Done

if TYPE_CHECKING:
    from ..bodies.motion import Markers, Motion
    from ..bodies.postures import Postures

SENSORS = (".skl", ".skeleton", ".gz", ".mat", ".json")  # endings that only recordings of joints have
TEXTS = (".csv", ".txt")  # endings that they share with others
_ANGLES = (".amc", ".bvh")
_TRUTHS = ("uiprmd markers", "keraal bodies")  # what optical systems wrote beside a sensor, in axes of their own
_WORST = 5  # joints listed for people; JSON has them all


def holds_joints(path: Path) -> bool:
    """Whether a file holds joints over time rather than joint angles or markers.

    A table without deviations, reliabilities or states holds joints when most of its names are those of joints.
    """
    from ..io.joint_table import beside_of, read_joint_table
    from ..io.sensor import kind_of
    from ..io.table import are_joints

    if not path.is_file() or ending(path) not in (*SENSORS, *TEXTS):
        return False
    kind = kind_of(path)
    if kind == "joints":
        if beside_of(path):
            return True
        return are_joints(read_joint_table(path).names)
    return kind in ("table", "ntu", "uiprmd", "utdmhad", "keraal", "azure", *_TRUTHS)


def judge_joints(truth: Path, other: Path, *, fps: float | None, skeleton: Path | None = None) -> Done:
    """What `evaluate.compare_joints` finds for one pair of files.

    Joint angles (.amc, .bvh) against joints are compared by the joints of their skeleton where most have the names of
    the others, else by the 16 joints of the tracker, in the truth's axes. So is what an optical system recorded beside
    a sensor (UI-PRMD, Keraal).

    Raises
    ------
    FileError, MismatchError : a file that cannot be read, or two that have nothing in common.
    """
    from ..evaluate.joints import compare_joints

    angles = [ending(path) in _ANGLES for path in (truth, other)]
    if angles[0]:
        judged = _read(other, fps)
        true = _of_angles(truth, fps, skeleton, judged.names)
    else:
        true = _read(truth, fps)
        judged = _of_angles(other, fps, skeleton, true.names) if angles[1] else _read(other, fps)
    align = any(angles) or any(_kind(path) in _TRUTHS for path in (truth, other))
    return told(truth, other, compare_joints(true, judged, align=align).to_json(), true, judged)


def doubts_of(*files: "tuple[Path, Postures | Motion | Markers]") -> tuple[tuple[str, ...], tuple[str, ...]]:
    """What may be wrong with each of the files read, after its name; what was supposed of one of them, as well, and
    what of all."""
    doubts = dict.fromkeys(f"{path.name}: {one}" for path, held in files for one in held.warnings)
    supposed: dict[str, list[str]] = {}
    for path, held in files:
        for one in dict.fromkeys(held.guesses):
            supposed.setdefault(one, []).append(path.name)
    guesses = (one if len(names) == len(files) else f"{names[0]}: {one}" for one, names in supposed.items())
    return tuple(doubts), tuple(guesses)


def told(
    truth: Path, other: Path, found: Mapping[str, Any], true: "Postures | Motion", judged: "Postures | Motion"
) -> Done:
    """What was found of joints in two files, for people and programs: under the names that every comparison has."""
    warnings, guesses = doubts_of((truth, true), (other, judged))
    unknown = {"rms_deg": None, "foot_skate_cm_s": {"truth": None, "other": None}}
    facts = {"input": other, "truth": truth, **unknown, **found, "warnings": warnings, "guesses": guesses}
    return Done(facts, _table(facts), warnings=warnings, guesses=guesses)


def _kind(path: Path) -> str:
    from ..io.sensor import kind_of

    return kind_of(path) if path.is_file() else ""


def _read(path: Path, fps: float | None) -> "Postures":
    from ..errors import MismatchError
    from ..io.joint_table import read_joint_table
    from ..io.sensor import read_postures
    from ..io.truth import read_truth

    if ending(path) not in (*SENSORS, ".csv", ".txt", ".trc"):
        raise MismatchError(
            f"{path}: joints are compared with joints: a table (.csv) or what a sensor reports was wanted, came "
            f"'{path.suffix}'"
        )
    kind = _kind(path)
    if kind in _TRUTHS:
        return read_truth(path, fps=fps)
    return read_joint_table(path) if kind == "joints" else read_postures(path, fps=fps)


def _of_angles(path: Path, fps: float | None, skeleton: Path | None, names: Sequence[str]) -> "Postures":
    """The joints in a recording of joint angles that others' names ask for: those of its skeleton where most of these
    are among them, as in a .bvh made of a table; the tracker's, at their places on a body, for the rest."""
    import numpy as np

    from ..bodies.motion import Motion
    from ..bodies.performer import LANDMARKS
    from ..bodies.postures import Postures
    from ..bodies.rig import motion_landmarks
    from ..bodies.skeleton import positions
    from ..errors import MismatchError
    from ..evaluate.names import same_names
    from ..io import read

    motion = read(path, fps=fps, skeleton=skeleton)
    assert isinstance(motion, Motion)
    times = np.arange(motion.frames) / motion.fps
    own = np.flatnonzero(same_names(motion.skeleton.names, names) >= 0)
    if 2 * len(own) <= len(names):
        return Postures(LANDMARKS, motion_landmarks(motion), times, guesses=motion.guesses, warnings=motion.warnings)
    found, at = tuple(motion.skeleton.names[j] for j in own), positions(motion.skeleton, motion.q)[:, own]
    if len(own) < len(names):
        try:
            more = motion_landmarks(motion)
        except MismatchError:
            return Postures(found, at, times, guesses=motion.guesses, warnings=motion.warnings)
        rest = [k for k, name in enumerate(LANDMARKS) if name not in found]
        found, at = (*found, *(LANDMARKS[k] for k in rest)), np.concatenate([at, more[:, rest]], axis=1)
    return Postures(found, at, times, guesses=motion.guesses, warnings=motion.warnings)


def _table(facts: Mapping[str, Any]) -> str:
    """The main numbers with their units, and where the error is largest."""
    missing, extra, jitter = facts["missing"], facts["extra"], facts["jitter"]
    angle = facts.get("rms_deg")
    rows = [
        ("truth", str(facts["truth"])),
        ("other", str(facts["input"])),
        ("kind", f"joints, {counted(facts['frames'], 'frame')} at {facts['fps']:g} Hz"),
        ("body joints, RMS", "" if angle is None else _value(angle, "degrees")),
        (
            "distance, mean",
            f"{_value(facts['mean_cm'], 'cm')} ({_value(facts['mean_cm_counting_missing'], 'cm')} counting what is "
            "missing)",
        ),
        (
            "median, 95 %, largest",
            ", ".join(_value(facts[name], "cm") for name in ("median_cm", "p95_cm", "max_cm")),
        ),
        (
            "above 15 cm",
            f"{_share(facts['share_above_15cm'])} of joints "
            f"({_share(facts['share_above_15cm_counting_missing'])} counting what is missing), "
            f"{_share(facts['frames_above_15cm'])} of frames",
        ),
        ("jitter", f"{_value(jitter['other'], 'm/s3')} (truth {_value(jitter['truth'], 'm/s3')})"),
        ("missing", f"{counted(missing['samples'], 'sample')}, {_share(missing['share'])}"),
    ]
    if extra["samples"]:
        rows.append(("claimed in vain", f"{counted(extra['samples'], 'sample')} where the truth has nothing"))
    worst = sorted(((v, name) for name, v in facts["mean_cm_by_joint"].items() if v is not None), reverse=True)
    rows.append(("worst joints", ", ".join(f"{name} {_value(v, 'cm')}" for v, name in worst[:_WORST])))
    rows += [("note", note) for note in facts["notes"]]
    width = max(len(name) for name, _ in rows)
    return "\n".join(f"{name:<{width}}  {value}" for name, value in rows if value)


def _value(value: float | None, unit: str) -> str:
    return "unknown" if value is None else f"{value:.3g} {unit}"


def _share(value: float | None) -> str:
    return "unknown" if value is None else f"{100 * value:.3g} %"
