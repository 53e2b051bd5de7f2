"""How close a recording comes to the truth: angles, places, jitter, bone lengths, feet, and what is missing."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from ..arrays import Bools, Floats, Ints
from ..bodies.feet import contacts, foot_joints, foot_markers, skate_during
from ..bodies.motion import Markers, Motion
from ..bodies.skeleton import ROTATION, positions, wrapped
from ..errors import MismatchError, counted, few
from .axes import Carrying, carrying
from .names import numbered, same_names

RIGID_STD = 0.005  # m; two markers whose distance varies less than this in the truth sit on one bone
RATE_TOLERANCE = 5e-4  # relative; what a frame time written with few digits is off by, 119.88 Hz is not 120 Hz
EXPLAINED = 0.4  # of the distance; a rigid motion that leaves more is not all that is wrong
_ROOTS = {"root", "hips", "hip", "pelvis", "reference"}
_NOT_BODY = ("hand", "finger", "thumb", "index", "middle", "ring", "pinky", "little", "toe", "toebase")


@dataclass(frozen=True, eq=False)
class Comparison:
    """What `compare` found; None stands where a quantity does not exist for the kind of recording or the data.

    Attributes
    ----------
    kind : `motion` or `markers`.
    frames, fps : of both recordings; fps in Hz.
    rms_deg : RMS difference of the body joint angles (`body_channels`), over the samples both have, degrees.
    rms_deg_counting_missing : the same, each missing angle scored as if it were the truth's mean over time, or as
        the channel's other angles are, or all angles, where they err more: what is missing counts no less than what is
        there.
    rms_deg_all, rms_deg_by_channel : over all rotation channels, and each by its name; the root's left out, and None,
        where the other lies in other axes.
    mean_cm : mean distance over joints or markers and frames, over the samples both have, cm.
    mean_cm_counting_missing : the same, each missing marker scored as if it were at the centroid of the frame's
        true markers, each missing angle as if it were the truth's mean over time; or as far off as the others of that
        joint or marker, or all, where those are farther.
    mean_cm_by_joint : `mean_cm` of each joint or marker by its name.
    root_rms_cm : RMS distance of the root, cm.
    jitter : `truth`, `other` in m/s^3 over the samples both have, and `ratio` = other / truth.
    bone_drift_cm, bone_drift_truth_cm : standard deviation over time of the distances between markers that the
        truth shows to be rigidly linked, cm; 0 for joint angles.
    foot_skate_cm_s : `truth`, `other`: mean horizontal speed of the feet while the truth's stand on the floor, cm/s.
    missing : `samples` that the truth has and the other lacks, their `share`, and `by_channel`.
    notes : one sentence for each number that needs one.
    unknown : names of the other's markers that the truth has not; they are left out.
    """

    kind: str
    frames: int
    fps: float
    rms_deg: float | None
    rms_deg_counting_missing: float | None
    rms_deg_all: float | None
    rms_deg_by_channel: dict[str, float | None] | None
    mean_cm: float | None
    mean_cm_counting_missing: float | None
    mean_cm_by_joint: dict[str, float | None]
    root_rms_cm: float | None
    jitter: dict[str, float | None]
    bone_drift_cm: float | None
    bone_drift_truth_cm: float | None
    foot_skate_cm_s: dict[str, float | None]
    missing: dict[str, Any]
    notes: tuple[str, ...] = ()
    unknown: tuple[str, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """Every field under its own name, ready for `json.dumps`; None becomes null."""
        values = {f.name: getattr(self, f.name) for f in fields(self)}
        return {**values, "notes": list(self.notes), "unknown": list(self.unknown)}


def compare(truth: Motion | Markers, other: Motion | Markers) -> Comparison:
    """Compare a recording with the truth, sample by sample.

    Channels and markers are matched by name, in whatever order; markers also without the subject's prefix and in
    another case when that is unambiguous. A marker that the other lacks counts as missing, one that the truth has not
    is left out. Samples that the truth lacks are left out of everything. Joint angles whose root lies so far
    off throughout that its axes cannot be the truth's are brought there by one rigid motion, which is noted.

    Parameters
    ----------
    truth, other : T frames of the same channels at the same rate. Joint positions of both are computed with the
        truth's skeleton: where joints turn in another order (`bodies.skeleton.turned_in_other_order`),
        `compare_skeletons` tells what is meant.

    Returns
    -------
    Comparison

    Raises
    ------
    MismatchError
        Different kinds, frame counts, rates or names.
    """
    if type(truth) is not type(other):
        raise MismatchError(f"a comparison needs two recordings of one kind, came {_kind(truth)} and {_kind(other)}")
    if truth.frames != other.frames:
        raise MismatchError(f"a comparison needs as many frames as the truth has, {truth.frames}, came {other.frames}")
    if abs(truth.fps - other.fps) > RATE_TOLERANCE * truth.fps:
        raise MismatchError(f"a comparison needs the truth's rate, {truth.fps:g} Hz, came {other.fps:g} Hz")
    if isinstance(truth, Motion):
        assert isinstance(other, Motion)
        return _compare_motions(truth, other)
    assert isinstance(other, Markers)
    return _compare_markers(truth, other)


def rms_angle(truth: Floats, other: Floats) -> float:
    """Root of the mean squared angle difference modulo a full turn, over the samples both have.

    Parameters
    ----------
    truth, other : same shape, rad, NaN = missing.

    Returns
    -------
    float
        rad; NaN when there is no common sample.
    """
    return float(np.sqrt(mean_of_known(wrapped(other - truth) ** 2)))


def position_error(truth: Floats, other: Floats) -> Floats:
    """Distance of each point from where it truly is: (T, P, 3) m and (T, P, 3) m to (T, P) m, NaN = missing."""
    return np.asarray(np.linalg.norm(other - truth, axis=2))


def counting_missing(loss: Floats, filled: Floats) -> float:
    """Mean loss, with what is missing as bad as what stands in for it, as its column otherwise is, or as all is,
    whichever is worst: to lose samples improves no score.

    Parameters
    ----------
    loss : (T, C) of each sample of C points or angles, as m of `position_error` or rad²; NaN = missing.
    filled : (T, C) the same with something in place of what the other lacks; NaN = the truth lacks it.
    """
    usual = np.fmax([mean_of_known(column) for column in loss.T], mean_of_known(loss))
    return mean_of_known(np.where(np.isfinite(loss) | ~np.isfinite(filled), loss, np.fmax(filled, usual)))


def jitter(positions: Floats, fps: float) -> float:
    """Mean over points and frames of the size of the jerk, by third differences.

    Parameters
    ----------
    positions : (T, P, 3) m, NaN = missing; a difference that touches a missing sample is left out.
    fps : Hz.

    Returns
    -------
    float
        m/s^3; NaN when no four consecutive frames are there.
    """
    jerk = np.linalg.norm(np.diff(positions, n=3, axis=0), axis=2) * fps**3
    return mean_of_known(np.array([mean_of_known(column) for column in jerk.T]))


def bone_drift(truth: Floats, other: Floats) -> float:
    """Mean, over pairs of points rigidly linked in the truth, of the standard deviation of their distance.

    Parameters
    ----------
    truth : (T, P, 3) m, NaN = missing; says which pairs are rigid: distance within 5 mm (standard deviation).
    other : (T, P, 3) m, NaN = missing; whose distances are measured.

    Returns
    -------
    float
        m; NaN when no rigid pair has two frames in both.
    """
    drifts: list[float] = []
    for p in range(truth.shape[1] - 1):
        true_std = _std_over_time(truth[:, p + 1 :] - truth[:, p : p + 1])
        other_std = _std_over_time(other[:, p + 1 :] - other[:, p : p + 1])
        drifts.extend(other_std[(true_std <= RIGID_STD) & np.isfinite(other_std)])
    return mean_of_known(np.array(drifts))


def body_channels(names: Sequence[str]) -> Bools:
    """Which channels are body joint angles: rotations, but not of the root, fingers, thumbs, hands and toes.

    Parameters
    ----------
    names : (C,) `<joint>.<channel>`, joints named as in CMU's .asf files or in the common .bvh ways, with or
        without a subject's prefix.

    Returns
    -------
    (C,) bool
    """
    return np.array([_is_body(name) for name in names], dtype=bool)


def _is_body(name: str) -> bool:
    joint, _, channel = name.rpartition(":")[2].rpartition(".")
    if channel.lower() in {"tx", "ty", "tz"} or channel.lower().endswith("position"):
        return False
    if joint.lower() in _ROOTS:
        return False
    words = re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", joint)
    return not any(word.lower().removesuffix("s").endswith(_NOT_BODY) for word in words)


def _compare_motions(truth: Motion, other: Motion) -> Comparison:
    other_q = other.q[:, _matching(truth.channels, other.channels)]
    other_q = np.where(truth.present, other_q, np.nan)
    filled_q = np.where(truth.present & ~np.isfinite(other_q), _mean_pose(truth), other_q)
    rotation = truth.skeleton.dof_kind == ROTATION
    roots = truth.skeleton.parents < 0
    of_root = roots[truth.skeleton.dof_joint]
    body = body_channels(truth.channels) & rotation & ~of_root
    true_at, other_at = (positions(truth.skeleton, q) for q in (truth.q, other_q))
    carried = _other_axes(true_at, other_at)
    axes_notes: tuple[str, ...] = ()
    told = rotation
    if carried is None:
        filled_at = positions(truth.skeleton, filled_q)
    else:
        other_at, filled_at = carried.of(other_at), _filled_there(truth, other_q, filled_q, carried)
        told, axes_notes = rotation & ~of_root, (carried.note, "the root's own angles are left out: of other axes")
    distance = position_error(true_at, other_at)
    off, filled_off = (wrapped(q - truth.q) ** 2 for q in (other_q, filled_q))
    feet, notes = _feet(truth)
    skates = _skates(true_at, other_at, feet, truth.fps, truth.skeleton.up)
    return Comparison(
        kind="motion",
        frames=truth.frames,
        fps=truth.fps,
        rms_deg=_degrees(rms_angle(truth.q[:, body], other_q[:, body])),
        rms_deg_counting_missing=_degrees(float(np.sqrt(counting_missing(off[:, body], filled_off[:, body])))),
        rms_deg_all=_degrees(rms_angle(truth.q[:, told], other_q[:, told])),
        rms_deg_by_channel={
            truth.channels[c]: _degrees(rms_angle(truth.q[:, c], other_q[:, c])) if told[c] else None
            for c in np.flatnonzero(rotation)
        },
        mean_cm=centimetres(mean_of_known(distance)),
        mean_cm_counting_missing=centimetres(counting_missing(distance, position_error(true_at, filled_at))),
        mean_cm_by_joint=_by_name(truth.skeleton.names, distance),
        root_rms_cm=centimetres(float(np.sqrt(mean_of_known(distance[:, roots] ** 2)))),
        jitter=_jitters(true_at, other_at, truth.fps),
        bone_drift_cm=0.0,
        bone_drift_truth_cm=0.0,
        foot_skate_cm_s=skates,
        missing=_missing(truth, np.isfinite(other_q)),
        notes=(*axes_notes, "bone_drift_cm is 0 by construction: joint angles keep every bone's length", *notes),
    )


def _other_axes(true_at: Floats, other_at: Floats) -> Carrying | None:
    """What brings the other to the truth's axes where these are others: far, and most of the distance is that.

    A root that was held or has drifted is far too, but no rigid motion mends it: that is an error, and stays one.
    """
    common = np.asarray(np.isfinite(true_at + other_at).all(axis=2))
    if common.sum() < 3:
        return None
    found = carrying(np.where(common[:, :, None], other_at, np.nan), true_at)
    left, whole = (mean_of_known(position_error(true_at, at)) for at in (found.of(other_at), other_at))
    return found if found.large and left < EXPLAINED * whole else None


def _filled_there(truth: Motion, other_q: Floats, filled_q: Floats, carried: Carrying) -> Floats:
    """(T, J, 3) m of the filled angles in the truth's axes; a root that is missing in part is missing, for what is put
    in its place is in these axes already."""
    of_root = np.asarray(truth.skeleton.parents < 0)[truth.skeleton.dof_joint]
    lost = np.asarray((truth.present & ~np.isfinite(other_q))[:, of_root].any(axis=1))[:, None]
    q = np.where(lost & of_root, np.where(truth.present, _mean_pose(truth), np.nan), filled_q)
    at = positions(truth.skeleton, q)
    return np.where(lost[:, :, None], at, carried.of(at))


def _compare_markers(truth: Markers, other: Markers) -> Comparison:
    place = same_names(truth.names, other.names)
    if (place < 0).all():
        raise _no_match(truth.names, other.names)
    other_at = np.where((place >= 0)[None, :, None], other.positions[:, place], np.nan)
    seen = np.asarray(np.isfinite(other_at).all(axis=2))
    other_at = np.where((truth.present & seen)[:, :, None], other_at, np.nan)
    true_at = np.where(truth.present[:, :, None], truth.positions, np.nan)
    filled_at = np.where((truth.present & ~seen)[:, :, None], centroids(true_at), other_at)
    distance = position_error(true_at, other_at)
    drift = centimetres(bone_drift(true_at, other_at))
    feet, notes = _feet(truth)
    lacking = [name for name, p in zip(truth.names, place, strict=True) if p < 0]
    if lacking:
        notes += (f"{counted(len(lacking), 'marker')} of the truth not in the other count as missing: {few(lacking)}",)
    unknown = tuple(name for m, name in enumerate(other.names) if m not in place)
    if drift is None:
        notes += ("bone_drift_cm is null: no two markers keep their distance within 5 mm in the truth",)
    return Comparison(
        kind="markers",
        frames=truth.frames,
        fps=truth.fps,
        rms_deg=None,
        rms_deg_counting_missing=None,
        rms_deg_all=None,
        rms_deg_by_channel=None,
        mean_cm=centimetres(mean_of_known(distance)),
        mean_cm_counting_missing=centimetres(counting_missing(distance, position_error(true_at, filled_at))),
        mean_cm_by_joint=_by_name(truth.names, distance),
        root_rms_cm=None,
        jitter=_jitters(true_at, other_at, truth.fps),
        bone_drift_cm=drift,
        bone_drift_truth_cm=centimetres(bone_drift(true_at, true_at)),
        foot_skate_cm_s=_skates(true_at, other_at, feet, truth.fps, truth.up),
        missing=_missing(truth, seen),
        notes=notes,
        unknown=unknown,
    )


def _matching(wanted: tuple[str, ...], came: tuple[str, ...]) -> Ints:
    """(C,) where each wanted channel stands among those that came; equal names match in their order."""
    keys, others = numbered(wanted), numbered(came)
    if sorted(keys) != sorted(others):
        raise _no_match(wanted, came)
    place = {key: c for c, key in enumerate(others)}
    return np.array([place[key] for key in keys], dtype=np.int64)


def _no_match(wanted: tuple[str, ...], came: tuple[str, ...]) -> MismatchError:
    lacks, extra = sorted(set(wanted) - set(came)), sorted(set(came) - set(wanted))
    return MismatchError(
        f"a comparison needs the truth's {len(wanted)} channels by name, came {len(came)}; "
        f"lacking: {few(lacks) or 'none'}; unknown to the truth: {few(extra) or 'none'}"
    )


def _mean_pose(motion: Motion) -> Floats:
    """(D,) rad and m: the mean over time of each channel, of angles on the circle; 0 where never recorded."""
    rotation = motion.skeleton.dof_kind == ROTATION
    return np.array(
        [
            np.arctan2(mean_of_known(np.sin(column)), mean_of_known(np.cos(column))) if turns else mean_of_known(column)
            for column, turns in zip(motion.q.T, rotation, strict=True)
        ]
    )


def centroids(points: Floats) -> Floats:
    """(T, 1, 3) m: the mean of each frame's points that are there, NaN in an empty frame."""
    there = np.isfinite(points).all(axis=2, keepdims=True)
    count = there.sum(axis=1, keepdims=True)
    total = np.where(there, points, 0.0).sum(axis=1, keepdims=True)
    return np.asarray(np.where(count > 0, total / np.maximum(count, 1), np.nan))


def _std_over_time(links: Floats) -> Floats:
    """(T, P, 3) m to (P,) m: standard deviation of each link's length; NaN with fewer than two frames."""
    length = np.linalg.norm(links, axis=2)
    there = np.isfinite(length)
    count = there.sum(axis=0)
    mean = np.where(there, length, 0.0).sum(axis=0) / np.maximum(count, 1)
    variance = (np.where(there, length - mean, 0.0) ** 2).sum(axis=0) / np.maximum(count, 1)
    return np.asarray(np.where(count >= 2, np.sqrt(variance), np.nan))


def _jitters(true_at: Floats, other_at: Floats, fps: float) -> dict[str, float | None]:
    """Jitter of both over the samples both have, and their ratio."""
    common = np.where(np.isfinite(other_at), true_at, np.nan)
    truth, other = jitter(common, fps), jitter(other_at, fps)
    return {
        "truth": number(truth),
        "other": number(other),
        "ratio": number(other / truth) if truth > 0 else None,
    }


def _feet(truth: Motion | Markers) -> tuple[Ints, tuple[str, ...]]:
    """(P,) joints or markers of the feet, and what there is to say about them."""
    if isinstance(truth, Motion):
        try:
            feet = foot_joints(truth.skeleton)
        except MismatchError as error:
            return np.empty(0, dtype=np.int64), (f"foot_skate_cm_s is null: {error}",)
        return feet.joints, feet.guesses
    markers = foot_markers(truth.names).markers
    if markers.size == 0:
        return markers, ("foot_skate_cm_s is null: no marker is named as one of a foot",)
    return markers, ()


def _skates(true_at: Floats, other_at: Floats, feet: Ints, fps: float, up: Floats) -> dict[str, float | None]:
    """Skate of both during the truth's contacts, cm/s: noise cannot talk its way out by ending a contact."""
    if feet.size == 0:
        return {"truth": None, "other": None}
    standing = contacts(true_at[:, feet], fps, up)
    return {
        "truth": centimetres(skate_during(true_at[:, feet], standing, fps, up)),
        "other": centimetres(skate_during(other_at[:, feet], standing, fps, up)),
    }


def _missing(truth: Motion | Markers, seen: Bools) -> dict[str, Any]:
    lost = truth.present & ~seen
    return {
        "samples": int(lost.sum()),
        "share": float(lost.sum() / max(1, truth.present.sum())),
        "by_channel": dict(zip(_labels(truth.channels), lost.sum(axis=0).tolist(), strict=True)),
    }


def _by_name(names: tuple[str, ...], distance: Floats) -> dict[str, float | None]:
    return {label: centimetres(mean_of_known(column)) for label, column in zip(_labels(names), distance.T, strict=True)}


def _labels(names: tuple[str, ...]) -> list[str]:
    """The names, a repeated one with its number, so that none is lost as a key."""
    return [name if count == 0 else f"{name}#{count + 1}" for name, count in numbered(names)]


def _kind(recording: Motion | Markers) -> str:
    return "joint angles" if isinstance(recording, Motion) else "markers"


def mean_of_known(values: Floats) -> float:
    """Mean of what is not NaN; NaN of nothing."""
    there = np.isfinite(values)
    return float(values[there].mean()) if there.any() else float("nan")


def number(value: float) -> float | None:
    """The value, None where it is not known."""
    return float(value) if np.isfinite(value) else None


def centimetres(metres: float) -> float | None:
    """m in cm, None where it is not known."""
    return number(100.0 * metres)


def _degrees(radians: float) -> float | None:
    return number(float(np.degrees(radians)))
