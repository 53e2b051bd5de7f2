"""`motionmend compare`: how close a recording comes to the truth."""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from ..errors import UsageError, counted, few
from .inputs import Refusal, gather
from .options import WORKING, AsJson, Rate, SkeletonFile, Working
from .output import Done, work

if TYPE_CHECKING:
    from ..bodies.motion import Motion

WORST = 5  # channels and joints listed for people; JSON has them all


@dataclass(frozen=True)
class Pair:
    """Two recordings of the same thing."""

    truth: Path
    other: Path


def compare(
    truth: Annotated[Path, Parameter(help="The recording that is right, or a folder of them.")],
    other: Annotated[
        Path, Parameter(help="The recording to judge, or a folder with the same names at the same places.")
    ],
    /,
    *,
    fps: Rate = None,
    skeleton: SkeletonFile = None,
    as_json: AsJson = False,
    working: Working = WORKING,
) -> int:
    """Compare recordings with the truth: errors in degrees and centimetres, jitter, bone drift, foot skate.

    Joint angles (.amc, .bvh), markers (.c3d, .trc, .csv, .tsv), or joints: the tables `track` and `correct` write and
    what sensors report; of joints also the 95 % quantile and the share farther off than 15 cm. Joint angles whose
    channels have other names, as an .amc and the .bvh made of it, are compared by the joints both have.

    What the other recording lacks is counted, never left out in silence: numbers named ..._counting_missing score a
    missing angle as the truth's mean over time, and a missing marker or joint as the middle of the others, or as those
    that are there if they err more.

    Joint angles that lie in other axes, as those tracked in a camera's against what a studio recorded, are brought to
    the truth's by one rigid motion, and that is noted.
    """
    from ..io import READABLE
    from .compare_joints import SENSORS

    endings = (*READABLE, *(() if os.path.isdir(truth) else SENSORS))
    given = working.reachable(truth), working.reachable(other)
    pairs, refused = _pairs(*given, endings)
    task = partial(judge, fps=fps, skeleton=skeleton and working.reachable(skeleton))
    return work(
        task, pairs, name=_other, working=working, as_json=as_json, refused=refused, given=given, against=_truth
    )


def _pairs(truth: Path, other: Path, endings: "tuple[str, ...]") -> tuple[list[Pair], list[Refusal]]:
    if os.path.isdir(truth) != os.path.isdir(other) and os.path.exists(truth) and os.path.exists(other):
        raise UsageError(f"two files or two folders were wanted, came {truth} and {other}")
    true, refused = gather([truth], endings)
    others, refused_too = gather([other], endings)
    refused += refused_too
    if not os.path.isdir(truth):
        return ([Pair(true[0].path, others[0].path)] if true and others else []), refused
    judged = {one.place: one.path for one in others}
    known = {one.place for one in true}
    pairs = [Pair(one.path, judged[one.place]) for one in true if one.place in judged]
    refused += [Refusal(other / one.place, "is not there to be compared") for one in true if one.place not in judged]
    refused += [Refusal(path, f"has no truth in {truth}") for place, path in judged.items() if place not in known]
    return pairs, refused


def judge(pair: Pair, /, *, fps: float | None, skeleton: Path | None) -> Done:
    """What `evaluate.compare`, `compare_joints` or `compare_skeletons` finds for one pair."""
    from ..bodies.motion import Motion
    from ..evaluate import compare, compare_skeletons
    from ..io import read
    from .compare_joints import doubts_of, holds_joints, judge_joints, told

    if holds_joints(pair.truth) or holds_joints(pair.other):
        return judge_joints(pair.truth, pair.other, fps=fps, skeleton=skeleton)
    truth = read(pair.truth, fps=fps, skeleton=skeleton)
    other = read(pair.other, fps=fps, skeleton=skeleton)
    if isinstance(truth, Motion) and isinstance(other, Motion) and _mean_other_things(truth, other):
        return told(pair.truth, pair.other, compare_skeletons(truth, other).to_json(), truth, other)
    found = compare(truth, other).to_json()
    warnings, guesses = doubts_of((pair.truth, truth), (pair.other, other))
    unknown = found["unknown"]
    warnings += (f"{counted(len(unknown), 'marker')} unknown to the truth left out: {few(unknown)}",) if unknown else ()
    facts = {"input": pair.other, "truth": pair.truth, **found, "warnings": warnings, "guesses": guesses}
    return Done(facts, _table(facts), warnings=warnings, guesses=guesses)


def _mean_other_things(truth: "Motion", other: "Motion") -> bool:
    """True if angles cannot be compared by their channels' names."""
    from ..bodies.skeleton import turned_in_other_order

    same = sorted(truth.channels) == sorted(other.channels)
    return not same or len(turned_in_other_order(truth.skeleton, other.channels)) > 0


def _table(facts: Mapping[str, Any]) -> str:
    """The main numbers with their units, and where the error is largest."""
    jitter, skate, missing = facts["jitter"], facts["foot_skate_cm_s"], facts["missing"]
    rows = [
        ("truth", str(facts["truth"])),
        ("other", str(facts["input"])),
        ("kind", f"{facts['kind']}, {counted(facts['frames'], 'frame')} at {facts['fps']:g} Hz"),
        ("body angles, RMS", _both(facts, "rms_deg", "degrees")),
        ("all angles, RMS", _value(facts["rms_deg_all"], "degrees")),
        ("position, mean", _both(facts, "mean_cm", "cm")),
        ("root, RMS", _value(facts["root_rms_cm"], "cm")),
        ("jitter", f"{_value(jitter['other'], 'm/s3')} (truth {_value(jitter['truth'], 'm/s3')})"),
        (
            "bone drift",
            f"{_value(facts['bone_drift_cm'], 'cm')} (truth {_value(facts['bone_drift_truth_cm'], 'cm')})",
        ),
        ("foot skate", f"{_value(skate['other'], 'cm/s')} (truth {_value(skate['truth'], 'cm/s')})"),
        ("missing", f"{counted(missing['samples'], 'sample')}, {100 * missing['share']:.3g} %"),
    ]
    rows += [("worst angles", line) for line in _worst(facts["rms_deg_by_channel"], "degrees")]
    rows += [("worst places", line) for line in _worst(facts["mean_cm_by_joint"], "cm")]
    rows += [("note", note) for note in facts["notes"]]
    width = max(len(name) for name, _ in rows)
    return "\n".join(f"{name:<{width}}  {value}" for name, value in rows if value)


def _both(facts: Mapping[str, Any], name: str, unit: str) -> str:
    if facts[name] is None:
        return ""
    return f"{_value(facts[name], unit)} ({_value(facts[f'{name}_counting_missing'], unit)} counting what is missing)"


def _value(value: float | None, unit: str) -> str:
    return "unknown" if value is None else f"{value:.3g} {unit}"


def _worst(by_name: Mapping[str, float | None] | None, unit: str) -> list[str]:
    if not by_name:
        return []
    known = sorted(((v, name) for name, v in by_name.items() if v is not None), reverse=True)[:WORST]
    return [", ".join(f"{name} {_value(value, unit)}" for value, name in known)] if known else []


def _other(pair: Pair) -> Path:
    return pair.other


def _truth(pair: Pair) -> Path:
    return pair.truth
