"""How close joint positions come to the truth: distances, their tail, what is missing and what is too much."""

from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np

from ..arrays import Bools, Floats, Ints
from ..bodies.joint_sets import correspondence, meanings
from ..bodies.postures import Postures
from ..errors import MismatchError, counted, few
from .axes import carrying
from .metrics import (
    bone_drift,
    centimetres,
    centroids,
    counting_missing,
    jitter,
    mean_of_known,
    number,
    position_error,
)
from .names import same_names

FAR = 0.15  # m; a joint farther from the truth than this is lost
UNSURE = 0.10  # m; a joint with this deviation or more is not said to be anywhere
_BY_MEANING = "joints were matched by what their names mean"
_GAP = 2.5  # frames; between samples farther apart than this nothing is interpolated
_SAME_RATE = 1.05  # times another; rates of one recording as two clocks tell them
_LAPSE = 0.5  # of a frame; rows whose times differ by more are worth a sentence


@dataclass(frozen=True, eq=False)
class JointComparison:
    """What `compare_joints` found; None stands where there is nothing to measure.

    Attributes
    ----------
    frames, fps : compared; fps in Hz, of the truth.
    mean_cm : mean distance over joints and frames, over the samples both have, cm.
    mean_cm_counting_missing : the same, each missing joint scored as if it were at the mean of the frame's true joints,
        or as far off as that joint otherwise is, or all joints, where those are farther.
    median_cm, p95_cm, max_cm : median, 95 % quantile and largest of those distances, cm.
    share_above_15cm : of those samples farther than 15 cm.
    share_above_15cm_counting_missing : of the truth's samples, farther than 15 cm or missing.
    frames_above_15cm : share of the frames whose joints are farther than 15 cm on average, or all missing.
    mean_cm_by_joint, p95_cm_by_joint : by the truth's names.
    jitter : `truth`, `other` in m/s^3 over the samples both have, and `ratio`.
    bone_drift_cm, bone_drift_truth_cm : as for markers, cm.
    missing : `samples` that the truth has and the other lacks, their `share`, and `by_channel`.
    extra : `samples` that the other claims where the truth has nothing (deviations of 0.10 m or more claim nothing),
        and their `share` of the truth's empty ones.
    notes : one sentence for all that had to be supposed.
    """

    frames: int
    fps: float
    mean_cm: float | None
    mean_cm_counting_missing: float | None
    median_cm: float | None
    p95_cm: float | None
    max_cm: float | None
    share_above_15cm: float | None
    share_above_15cm_counting_missing: float | None
    frames_above_15cm: float | None
    mean_cm_by_joint: dict[str, float | None]
    p95_cm_by_joint: dict[str, float | None]
    jitter: dict[str, float | None]
    bone_drift_cm: float | None
    bone_drift_truth_cm: float | None
    missing: dict[str, Any]
    extra: dict[str, Any]
    notes: tuple[str, ...] = ()
    kind: str = field(default="joints")

    def to_json(self) -> dict[str, Any]:
        """Every field under its own name, ready for `json.dumps`; None becomes null."""
        values = {f.name: getattr(self, f.name) for f in fields(self)}
        return {"kind": values.pop("kind"), **values, "notes": list(self.notes)}


def compare_joints(truth: Postures, other: Postures, *, align: bool | None = False) -> JointComparison:
    """Compare joint positions with the truth, sample by sample.

    Joints are matched by name, whatever case and subject's prefix; where few names are the same, and what has no such
    name, by what they mean on a body. A joint of the truth that the other lacks counts as missing. As many rows on both
    sides at one rate are compared row by row, as clocks may begin at other times; otherwise both are taken at the times
    of the slower one, between samples on a straight line.

    Parameters
    ----------
    truth, other : positions in the same axes.
    align : the axes are others: bring the other to the truth's by one rigid motion, never a mirroring. None: where
        that is a motion so large that the axes cannot be the same.

    Raises
    ------
    MismatchError
        No joint or no time in common.
    """
    place, notes = _matching(truth.names, other.names)
    truth, other, said = _in_step(truth, other)
    notes += said
    other, said = _upright_alike(truth, other, place) if align is False else _aligned(truth, other, place, align)
    notes += said
    true_at = np.where(truth.present[:, :, None], truth.positions, np.nan)
    other_at = np.where((place >= 0)[None, :, None], other.positions[:, place], np.nan)
    there, seen = truth.present, np.asarray(np.isfinite(other_at).all(axis=2))
    claimed = seen if other.std is None else seen & ~(other.std[:, place] >= UNSURE)
    both = np.where((there & seen)[:, :, None], other_at, np.nan)
    centre = centroids(true_at)
    distance = position_error(true_at, both)
    filled = position_error(true_at, np.where((there & ~seen)[:, :, None], centre, both))
    far = np.where(there, np.where(seen, distance > FAR, True), False)
    held = there.any(axis=1)
    of_frame = np.array([mean_of_known(row) for row in distance])
    lost = held & ~(of_frame <= FAR)
    still, moved = (jitter(at, truth.fps) for at in (np.where(np.isfinite(both), true_at, np.nan), both))
    return JointComparison(
        frames=truth.frames,
        fps=truth.fps,
        mean_cm=centimetres(mean_of_known(distance)),
        mean_cm_counting_missing=centimetres(counting_missing(distance, filled)),
        median_cm=centimetres(_quantile(distance, 0.5)),
        p95_cm=centimetres(_quantile(distance, 0.95)),
        max_cm=centimetres(_quantile(distance, 1.0)),
        share_above_15cm=number(mean_of_known(np.where(np.isfinite(distance), distance > FAR, np.nan))),
        share_above_15cm_counting_missing=_ratio(far.sum(), there.sum()),
        frames_above_15cm=_ratio(lost.sum(), held.sum()),
        mean_cm_by_joint=_by_name(truth.names, [mean_of_known(column) for column in distance.T]),
        p95_cm_by_joint=_by_name(truth.names, [_quantile(column, 0.95) for column in distance.T]),
        jitter={
            "truth": number(still),
            "other": number(moved),
            "ratio": number(moved / still) if still > 0 else None,
        },
        bone_drift_cm=centimetres(bone_drift(true_at, both)),
        bone_drift_truth_cm=centimetres(bone_drift(true_at, true_at)),
        missing=_missing(truth.names, there, there & ~seen),
        extra={"samples": int((claimed & ~there).sum()), "share": _ratio((claimed & ~there).sum(), (~there).sum())},
        notes=notes,
    )


def _matching(wanted: tuple[str, ...], came: tuple[str, ...]) -> tuple[Ints, tuple[str, ...]]:
    """(J,) where each joint of the truth stands in the other, -1 for nowhere; and what is worth a sentence.

    Where most names are the same on both sides, so are the joints, and meanings tell of the rest alone; a few equal
    names, as two sensors have them, may stand for other places of a body.
    """
    place, notes = same_names(wanted, came), tuple[str, ...]()
    alike = 2 * int((place >= 0).sum()) > min(len(wanted), len(came))
    if (place < 0).any():
        meant = correspondence(came, wanted)
        if alike:
            meant = np.where(place >= 0, place, np.where(np.isin(meant, place), -1, meant))
        if (meant >= 0).sum() > (place >= 0).sum():
            others = few([name for name, p, m in zip(wanted, place, meant, strict=True) if p != m])
            which = f"these joints were matched by what their names mean ({others})" if alike else _BY_MEANING
            place = meant
            notes += (f"{which}, and each sensor places them a little elsewhere",)
    if (place < 0).all():
        raise MismatchError(
            f"a comparison needs joints of the same names, came {few(came)} where the truth has {few(wanted)}"
        )
    lacking = [name for name, p in zip(wanted, place, strict=True) if p < 0]
    if lacking:
        notes += (f"{len(lacking)} joints of the truth have no column and count as missing: {few(lacking)}",)
    return place, notes


def _upright_alike(truth: Postures, other: Postures, place: Ints) -> tuple[Postures, tuple[str, ...]]:
    """The other with y pointing as the truth's does: sensors' skeletons have it up, cameras down.

    Where y is turned round, x is too when that brings the joints nearer: some sensors' x goes to the image's left.
    """
    ups = [_up_along_y(one) for one in (truth, other)]
    if not ups[0] * ups[1] < 0:
        return other, ()
    best: tuple[float, str, Postures] | None = None
    for signs, axes in (((1.0, -1.0, 1.0), "y"), ((-1.0, -1.0, 1.0), "x and y")):
        turned = other.with_positions(other.positions * np.array(signs))
        apart = mean_of_known(np.linalg.norm(turned.positions[:, place] - truth.positions, axis=2)[:, place >= 0])
        if best is None or apart < best[0]:
            best = apart, axes, turned
    assert best is not None
    return best[2], (f"one has y up, the other y down: the other's {best[1]} changed sign",)


def _aligned(truth: Postures, other: Postures, place: Ints, align: bool | None) -> tuple[Postures, tuple[str, ...]]:
    """The other in the truth's axes, by the rigid motion that brings all joints of all frames nearest."""
    matched = np.flatnonzero(place >= 0)
    found = carrying(other.positions[:, place[matched]], truth.positions[:, matched])
    if align is None and not found.large:
        return other, ()
    said = found.note if align is None else "the other was brought to the truth's axes by one rigid motion"
    return other.with_positions(found.of(other.positions)), (said,)


def _up_along_y(postures: Postures) -> float:
    """Median height along y of the head above pelvis, knees and ankles, m; NaN where those are not there."""
    named = meanings(postures.names)
    low = [k for k, meaning in enumerate(named) if meaning == "pelvis" or meaning[1:] in ("_knee", "_ankle", "_foot")]
    high = [k for k, meaning in enumerate(named) if meaning in ("head", "neck", "neck_base")]
    if not low or not high:
        return float("nan")
    y = postures.positions[:, :, 1]
    rise = (y[:, high][:, :, None] - y[:, low][:, None, :]).ravel()
    rise = rise[np.isfinite(rise)]
    return float(np.median(rise)) if rise.size else float("nan")


def _in_step(truth: Postures, other: Postures) -> tuple[Postures, Postures, tuple[str, ...]]:
    """Both with one row for each time that is compared."""
    if not truth.frames or not other.frames:
        raise MismatchError("a comparison needs frames on both sides")
    step = [float(np.median(np.diff(one.times))) if one.frames > 1 else 0.0 for one in (truth, other)]
    if truth.frames == other.frames:
        lapse = float(np.abs(truth.times - other.times).max())
        if lapse <= _LAPSE * step[0] or truth.frames == 1:
            return truth, other, ()
        if not min(step) > 0 or max(step) <= _SAME_RATE * min(step):
            said = f"as many rows on both sides: compared row by row, though times differ by {lapse:.3g} s"
            return truth, other, (said,)
    grid = truth.times
    if truth.frames > 1 and other.frames > 1 and step[1] > 1.25 * step[0]:
        before = np.arange(other.times[0], truth.times[0] - 1e-9, -step[1])[1:][::-1]
        after = np.arange(other.times[-1], truth.times[-1] + 1e-9, step[1])[1:]
        grid = np.concatenate([before, other.times, after])
        grid = grid[(grid >= truth.times[0] - 1e-9) & (grid <= truth.times[-1] + 1e-9)]
    if not len(grid) or grid[0] > other.times[-1] + 1e-9 or grid[-1] < other.times[0] - 1e-9:
        raise MismatchError(
            f"a comparison needs common times, came {other.times[0]:g} to {other.times[-1]:g} s where the truth "
            f"has {truth.times[0]:g} to {truth.times[-1]:g} s"
        )
    note = f"{_rows(other)} where the truth has {_rows(truth)}: compared at {counted(len(grid), 'time')}"
    return _at(truth, grid), _at(other, grid), (f"{note}, between samples on a straight line",)


def _rows(postures: Postures) -> str:
    rate = f" at {postures.fps:.4g} Hz" if np.isfinite(postures.fps) else ""
    return f"{counted(postures.frames, 'row')}{rate}"


def _at(postures: Postures, times: Floats) -> Postures:
    """The joints at other times, on straight lines between samples; missing beyond them and in gaps."""
    order = np.argsort(postures.times, kind="stable")
    known, xyz = postures.times[order], postures.positions[order]
    std = None if postures.std is None else postures.std[order]
    upper = np.clip(np.searchsorted(known, times - 1e-9), 0, len(known) - 1)
    lower = np.clip(upper - 1, 0, len(known) - 1)
    lower = np.where(np.abs(known[upper] - times) <= 1e-6, upper, lower)
    span = known[upper] - known[lower]
    usual = float(np.median(np.diff(known))) if len(known) > 1 else 0.0
    outside = (times > known[-1] + 1e-6) | (times < known[0] - 1e-6) | (span > _GAP * usual + 1e-6)
    share = np.where(span > 0, (times - known[lower]) / np.where(span > 0, span, 1.0), 0.0)
    between = xyz[lower] + share[:, None, None] * (xyz[upper] - xyz[lower])
    between[outside] = np.nan
    whole = replace(postures, positions=between, times=times, state=None, std=None, reliability=None)
    return whole if std is None else replace(whole, std=np.maximum(std[lower], std[upper]))


def _missing(names: tuple[str, ...], there: Bools, lost: Bools) -> dict[str, Any]:
    return {
        "samples": int(lost.sum()),
        "share": float(lost.sum() / max(1, there.sum())),
        "by_channel": dict(zip(names, lost.sum(axis=0).tolist(), strict=True)),
    }


def _by_name(names: tuple[str, ...], metres: list[float]) -> dict[str, float | None]:
    return {name: centimetres(value) for name, value in zip(names, metres, strict=True)}


def _quantile(values: Floats, share: float) -> float:
    there = values[np.isfinite(values)]
    return float(np.quantile(there, share)) if there.size else float("nan")


def _ratio(part: Any, whole: Any) -> float | None:
    return float(part / whole) if whole else None
