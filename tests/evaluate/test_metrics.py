"""Metrics against hand-reckoned cases and the laws they have to keep."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from motionmend.bodies.motion import Markers, Motion
from motionmend.bodies.skeleton import ROTATION, TRANSLATION, Skeleton, positions
from motionmend.errors import MismatchError
from motionmend.evaluate import (
    body_channels,
    bone_drift,
    compare,
    corrupt,
    jitter,
    position_error,
    rms_angle,
)
from motionmend.samples import clip, markers

MOTION = clip("walk", seconds=2, seed=3)
MARKERS = markers(MOTION)
# What is to hold whatever is drawn needs few frames for each.
COARSE = replace(MOTION, q=MOTION.q[::6], fps=MOTION.fps / 6)
COARSE_MARKERS = MARKERS.with_positions(MARKERS.positions[::6])


def reordered(motion: Motion, order: np.ndarray) -> Motion:
    """The same motion with the channels of each joint in another order of columns (names go with them)."""
    s = motion.skeleton
    body = Skeleton(
        s.names,
        s.parents,
        s.offsets,
        tuple(s.dof_names[i] for i in order),
        s.dof_joint[order],
        s.dof_axis[order],
        s.dof_kind[order],
        s.limits[order],
        s.up,
    )
    return Motion(body, motion.q[:, order], motion.fps)


@pytest.mark.parametrize("recording", [MOTION, MARKERS], ids=["motion", "markers"])
def test_equal_inputs_score_zero(recording):
    facts = compare(recording, recording).to_json()
    for name in ("rms_deg", "rms_deg_all", "rms_deg_counting_missing", "mean_cm", "mean_cm_counting_missing"):
        assert facts[name] in (0.0, None)
    assert facts["jitter"]["ratio"] == 1.0
    assert facts["bone_drift_cm"] == facts["bone_drift_truth_cm"]
    assert facts["foot_skate_cm_s"]["truth"] == facts["foot_skate_cm_s"]["other"]
    assert facts["missing"]["samples"] == 0


def test_the_report_is_json_and_says_null_where_there_is_nothing():
    facts = json.loads(json.dumps(compare(MARKERS, MARKERS).to_json()))
    assert facts["kind"] == "markers"
    assert facts["rms_deg"] is None
    assert facts["root_rms_cm"] is None
    empty = MARKERS.with_positions(np.full_like(MARKERS.positions, np.nan))
    facts = json.loads(json.dumps(compare(MARKERS, empty).to_json()))
    assert facts["mean_cm"] is None
    assert facts["missing"] == {
        "samples": MARKERS.present.size,
        "share": 1.0,
        "by_channel": dict.fromkeys(MARKERS.names, MARKERS.frames),
    }


def test_a_constant_offset_of_one_joint_is_its_rms():
    column = MOTION.channels.index("ltibia.rx")
    q = MOTION.q.copy()
    q[:, column] += np.radians(10.0)
    found = compare(MOTION, MOTION.with_q(q))
    body = int((body_channels(MOTION.channels) & (MOTION.skeleton.dof_kind == ROTATION)).sum())
    assert found.rms_deg == pytest.approx(10.0 / np.sqrt(body))
    assert found.rms_deg_by_channel["ltibia.rx"] == pytest.approx(10.0)
    assert found.rms_deg_by_channel["rtibia.rx"] == 0.0
    shank = np.linalg.norm(MOTION.skeleton.offsets[MOTION.skeleton.names.index("lfoot")])
    assert found.mean_cm_by_joint["lfoot"] == pytest.approx(100 * 2 * shank * np.sin(np.radians(5.0)))
    assert found.mean_cm_by_joint["head"] == 0.0


def test_a_moved_root_moves_every_joint_and_no_angle():
    q = MOTION.q.copy()
    q[:, :3] += [0.03, 0.0, 0.04]
    found = compare(MOTION, MOTION.with_q(q))
    assert found.rms_deg_all == 0.0
    assert found.mean_cm == pytest.approx(5.0)
    assert found.root_rms_cm == pytest.approx(5.0)
    assert found.foot_skate_cm_s["other"] == pytest.approx(found.foot_skate_cm_s["truth"])


def elsewhere(motion: Motion, degrees: float, metres: tuple[float, float, float]) -> Motion:
    """The same motion in other axes: turned about the outermost axis of the root's angles, then moved."""
    skeleton, q = motion.skeleton, motion.q.copy()
    own = skeleton.dofs_of(0)
    places, turns = (own[skeleton.dof_kind[own] == kind] for kind in (TRANSLATION, ROTATION))
    q[:, turns[0]] += np.radians(degrees)
    turn = Rotation.from_rotvec(np.radians(degrees) * skeleton.dof_axis[turns[0]])
    q[:, places] = turn.apply(q[:, places] + skeleton.offsets[0]) - skeleton.offsets[0] + metres
    return motion.with_q(q)


def test_joint_angles_in_other_axes_are_brought_to_the_truths_and_that_is_said():
    q = MOTION.q.copy()
    q[:, 6:] += np.radians(3.0) * np.random.default_rng(0).standard_normal(q[:, 6:].shape)
    off = MOTION.with_q(q)
    near, far = compare(MOTION, off), compare(MOTION, elsewhere(off, 130.0, (0.4, -1.0, 3.0)))
    assert not any("rigid" in note for note in near.notes)
    assert any("one rigid motion: turned by 130 degrees" in note for note in far.notes)
    assert far.mean_cm == pytest.approx(near.mean_cm, rel=0.1)
    assert far.root_rms_cm < 0.5
    assert far.rms_deg == near.rms_deg
    assert far.rms_deg_by_channel["lhumerus.rx"] == near.rms_deg_by_channel["lhumerus.rx"]
    assert far.jitter["other"] == pytest.approx(near.jitter["other"])
    assert far.foot_skate_cm_s["other"] == pytest.approx(near.foot_skate_cm_s["other"], abs=0.5)
    roots = [name for name, value in far.rms_deg_by_channel.items() if value is None]
    assert sorted(roots) == ["root.rx", "root.ry", "root.rz"]
    assert far.rms_deg_all == pytest.approx(3.0, rel=0.05)


@pytest.mark.parametrize(("degrees", "metres"), [(0.0, 0.45), (12.0, 0.0)])
def test_a_recording_that_is_a_little_off_is_judged_where_it_lies(degrees, metres):
    found = compare(MOTION, elsewhere(MOTION.with_q(MOTION.q - MOTION.q[0]), degrees, (metres, 0.0, 0.0)))
    assert not any("rigid" in note for note in found.notes)
    assert found.mean_cm > 5.0
    assert found.rms_deg_by_channel["root.rx"] is not None


def test_a_root_that_stands_still_where_the_truth_walks_is_an_error_and_no_other_axes():
    walk = clip("walk", seconds=4, seed=3)
    q = walk.q.copy()
    q[:, :3] = q[0, :3]
    found = compare(walk, walk.with_q(q))
    gone = np.linalg.norm(walk.q[:, :3] - walk.q[0, :3], axis=1)
    assert gone.mean() > 1.0
    assert found.mean_cm == pytest.approx(100 * gone.mean())


def test_what_is_missing_of_a_root_in_other_axes_counts_as_it_does_in_the_same():
    q = MOTION.q.copy()
    q[20:40, :6] = np.nan
    q[60:70, 1] = np.nan
    spoilt = MOTION.with_q(q)
    near, far = compare(MOTION, spoilt), compare(MOTION, elsewhere(spoilt, 75.0, (3.0, 0.0, 1.0)))
    assert far.mean_cm == pytest.approx(0.0, abs=1e-6)
    # All of a place is missing where a part is, for in the truth's axes that is a part of each.
    assert near.mean_cm_counting_missing < far.mean_cm_counting_missing < 100.0


def test_markers_off_by_a_known_distance():
    off = MARKERS.positions.copy()
    off[:, 4] += [0.0, 0.012, 0.016]
    found = compare(MARKERS, MARKERS.with_positions(off))
    assert found.mean_cm_by_joint["C7"] == pytest.approx(2.0)
    assert found.mean_cm == pytest.approx(2.0 / 41)


@given(st.lists(st.floats(-10, 10), min_size=1, max_size=20), st.integers(-3, 3))
def test_full_turns_do_not_count(angles, turns):
    truth = np.array(angles)
    assert rms_angle(truth, truth + 2 * np.pi * turns) == pytest.approx(0.0, abs=1e-7)


def test_a_difference_wraps_the_short_way():
    assert rms_angle(np.radians([179.0]), np.radians([-179.0])) == pytest.approx(np.radians(2.0))


@pytest.mark.slow
@settings(max_examples=10)
@given(st.integers(0, 100), st.floats(0.0, 0.3))
def test_errors_are_symmetric(seed, noise):
    other = corrupt(COARSE, noise=noise, seed=seed).recording
    there, back = compare(COARSE, other), compare(other, COARSE)
    for name in ("rms_deg", "rms_deg_all", "mean_cm", "root_rms_cm"):
        assert getattr(there, name) == pytest.approx(getattr(back, name))
    spoilt = corrupt(COARSE_MARKERS, noise=noise, seed=seed).recording
    assert compare(COARSE_MARKERS, spoilt).mean_cm == pytest.approx(compare(spoilt, COARSE_MARKERS).mean_cm)


@pytest.mark.slow
@settings(max_examples=10)
@given(st.integers(0, 100), st.floats(0.05, 0.9))
def test_a_missing_marker_never_improves_the_score(seed, gaps):
    noisy = corrupt(COARSE_MARKERS, noise=0.01, seed=seed).recording
    holed = corrupt(noisy, gaps=gaps, seed=seed).recording
    with_all, with_holes = compare(COARSE_MARKERS, noisy), compare(COARSE_MARKERS, holed)
    assert with_holes.mean_cm_counting_missing > with_all.mean_cm_counting_missing
    assert with_all.mean_cm_counting_missing == with_all.mean_cm
    assert with_holes.missing["samples"] == (~holed.present).sum()


@settings(max_examples=10)
@given(st.integers(0, 100))
def test_a_missing_limb_never_improves_the_score(seed):
    noisy = corrupt(COARSE, noise=np.radians(1.0), seed=seed).recording
    holed = corrupt(noisy, drop=["lfemur", "rhumerus"]).recording
    with_all, with_holes = compare(COARSE, noisy), compare(COARSE, holed)
    assert with_holes.rms_deg_counting_missing > with_all.rms_deg_counting_missing
    assert with_holes.mean_cm_counting_missing > with_all.mean_cm_counting_missing
    assert with_all.rms_deg_counting_missing == with_all.rms_deg
    assert with_holes.missing["by_channel"]["lfemur.rx"] == COARSE.frames
    assert with_holes.missing["by_channel"]["ltibia.rx"] == 0
    assert with_holes.mean_cm_by_joint["lfoot"] is None


def test_a_missing_angle_is_scored_as_the_mean_on_the_circle():
    column = MOTION.channels.index("rfemur.rx")
    holed = corrupt(MOTION, drop=["rfemur.rx"]).recording
    body = int((body_channels(MOTION.channels) & (MOTION.skeleton.dof_kind == ROTATION)).sum())
    expected = np.degrees(MOTION.q[:, column].std()) / np.sqrt(body)
    assert compare(MOTION, holed).rms_deg_counting_missing == pytest.approx(expected, rel=1e-3)


@given(st.integers(0, 10**6), st.floats(0.0, 30.0))
@settings(max_examples=20)
@example(165, 27.0)  # more is lost of angles that err more
def test_to_lose_samples_of_a_bad_recording_improves_no_score(seed, noise):
    rng = np.random.default_rng(seed)
    off = np.radians(noise) * rng.standard_normal(MOTION.q.shape)
    bad = replace(MOTION, q=MOTION.q + off, source=None)
    lost = compare(MOTION, replace(bad, q=np.where(rng.random(off.shape) < 0.5, np.nan, bad.q)))
    assert lost.rms_deg_counting_missing >= lost.rms_deg


def test_to_lose_markers_of_a_recording_that_lies_elsewhere_improves_no_score():
    away = replace(MARKERS, positions=MARKERS.positions + np.array([5.0, 0.0, 0.0]), source=None)
    holed = corrupt(away, gaps=0.2, seed=3).recording
    assert compare(MARKERS, holed).mean_cm_counting_missing >= compare(MARKERS, holed).mean_cm - 1e-6


def test_what_the_truth_lacks_is_left_out():
    truth = corrupt(MARKERS, drop=["LFHD"], gaps=0.1, seed=4).recording
    far = MARKERS.positions.copy()
    far[~truth.present] += 100.0
    found = compare(truth, MARKERS.with_positions(far))
    assert found.mean_cm == pytest.approx(0.0, abs=1e-9)
    assert found.mean_cm_by_joint["LFHD"] is None
    assert found.missing["samples"] == 0
    angles = corrupt(MOTION, drop=["head"]).recording
    assert compare(angles, MOTION).rms_deg == 0.0


def test_channels_are_matched_by_name_in_any_order(rng):
    within = np.arange(len(MOTION.channels))
    within[[3, 4, 5]] = [5, 3, 4]  # the root's own angles: their order matters to the pose, not to the names
    assert compare(MOTION, reordered(MOTION, within)).rms_deg_all == 0.0
    order = rng.permutation(41)
    shuffled = Markers(tuple(MARKERS.names[i] for i in order), MARKERS.positions[:, order], MARKERS.fps)
    assert compare(MARKERS, shuffled).mean_cm == pytest.approx(0.0, abs=1e-12)


def test_markers_are_matched_without_the_subject_when_that_is_clear():
    named = Markers(tuple(f"Ada:{n}" for n in MARKERS.names), MARKERS.positions, MARKERS.fps)
    assert compare(MARKERS, named).mean_cm == 0.0
    assert compare(named, MARKERS).mean_cm == 0.0
    two = Markers(("Ada:C7", "Bob:C7"), MARKERS.positions[:, :2], MARKERS.fps)
    twice = Markers(("C7", "C7"), MARKERS.positions[:, :2], MARKERS.fps)
    with pytest.raises(MismatchError):
        compare(two, twice)


@pytest.mark.slow
@given(st.sets(st.integers(0, 40), min_size=1, max_size=40), st.sampled_from([str, str.lower, "Ada:{}".format]))
def test_markers_that_the_other_lacks_are_missing_throughout_and_those_it_has_more_are_named(kept, spelt):
    rows = sorted(kept)
    names = (*(spelt(COARSE_MARKERS.names[m]) for m in rows), "stick")
    at = np.concatenate([COARSE_MARKERS.positions[:, rows], COARSE_MARKERS.positions[:, :1] + 1.0], axis=1)
    found = compare(COARSE_MARKERS, Markers(names, at, COARSE_MARKERS.fps))
    assert found.mean_cm == pytest.approx(0.0, abs=1e-9)
    assert found.missing["samples"] == (41 - len(rows)) * COARSE_MARKERS.frames
    assert found.unknown == ("stick",)
    assert found.mean_cm_counting_missing is not None
    assert (found.mean_cm_counting_missing > 0.1) == (len(rows) < 41)
    assert any("count as missing" in note for note in found.notes) == (len(rows) < 41)


def test_markers_without_a_name_in_common_are_refused():
    strange = Markers(("stick", "cap"), MARKERS.positions[:, :2], MARKERS.fps)
    with pytest.raises(MismatchError, match="by name"):
        compare(MARKERS, strange)


@pytest.mark.parametrize(
    "other",
    [
        MARKERS,
        MOTION.with_q(MOTION.q[:-1]),
        replace(MOTION, fps=119.88),
        reordered(MOTION, np.arange(len(MOTION.channels) - 1)),
    ],
    ids=["kind", "frames", "rate", "names"],
)
def test_what_does_not_belong_together_is_refused_in_one_line(other):
    with pytest.raises(MismatchError) as caught:
        compare(MOTION, other)
    assert "\n" not in str(caught.value)


def test_a_rate_rounded_by_a_file_is_the_same_rate():
    assert compare(MOTION, replace(MOTION, fps=1 / 0.008333)).rms_deg == 0.0


@given(st.floats(0.1, 50.0), st.floats(20.0, 240.0))
def test_jitter_is_the_jerk_of_a_cubic(rate, fps):
    t = np.arange(12) / fps
    cubic = np.stack([rate * t**3 / 6, 0 * t, 3 + t], axis=1)[:, None]
    assert jitter(cubic, fps) == pytest.approx(rate, rel=1e-4)


def test_jitter_leaves_out_what_touches_a_gap():
    points = np.cumsum(np.ones((20, 2, 3)), axis=0)
    points[7, 0] = np.nan
    assert jitter(points, 100.0) == pytest.approx(0.0, abs=1e-6)
    assert np.isnan(jitter(points[:3], 100.0))


def test_bone_drift_is_the_spread_of_a_rigid_distance(rng):
    truth = np.cumsum(rng.normal(size=(200, 1, 3)), axis=0) + np.array([[0.0, 0, 0], [0.3, 0, 0]])
    stretched = truth.copy()
    stretch = 0.02 * np.sin(np.arange(200))
    stretched[:, 1, 0] += stretch
    assert bone_drift(truth, truth) == pytest.approx(0.0, abs=1e-12)
    assert bone_drift(truth, stretched) == pytest.approx(stretch.std())
    loose = truth.copy()
    loose[:, 1] += rng.normal(size=(200, 3))
    assert np.isnan(bone_drift(loose, truth))


def test_markers_drift_when_noise_bends_the_bones():
    noisy = corrupt(MARKERS, noise=0.01, seed=1).recording
    found = compare(MARKERS, noisy)
    # Independent noise on both ends spreads a distance by sqrt(2) of its size along the line between them.
    assert found.bone_drift_cm == pytest.approx(np.sqrt(2.0), rel=0.1)
    assert found.bone_drift_truth_cm < 0.3
    assert found.jitter["ratio"] > 10


def test_feet_that_slide_are_found_out():
    q = MOTION.q.copy()
    q[:, 0] += 0.2 * np.arange(MOTION.frames) / MOTION.fps
    found = compare(MOTION, MOTION.with_q(q)).foot_skate_cm_s
    assert found["truth"] < 5.0
    assert found["other"] == pytest.approx(20.0, abs=4.0)


def test_a_body_without_feet_says_so():
    stick = Skeleton(
        ("base", "tip"),
        np.array([-1, 0]),
        np.array([[0.0, 0, 0], [0, 1, 0]]),
        ("base.x", "tip.z"),
        np.array([0, 1]),
        np.array([[1.0, 0, 0], [0, 0, 1]]),
        np.array([0, 0]),
        np.full((2, 2), [-np.inf, np.inf]),
    )
    still = Motion(stick, np.zeros((10, 2)), 30.0)
    found = compare(still, still)
    assert found.foot_skate_cm_s == {"truth": None, "other": None}
    assert any("foot_skate_cm_s is null" in note for note in found.notes)
    assert found.jitter["ratio"] is None


def test_position_error_knows_a_345_triangle():
    assert position_error(np.zeros((1, 1, 3)), np.array([[[3.0, 4.0, 0.0]]]))[0, 0] == 5.0


@pytest.mark.parametrize(
    ("name", "counts"),
    [
        ("root.rx", False),
        ("root.tx", False),
        ("lfemur.rx", True),
        ("lhipjoint.rx", True),
        ("lfoot.rz", True),
        ("ltoes.rx", False),
        ("rhand.rz", False),
        ("rwrist.ry", True),
        ("rfingers.rx", False),
        ("lthumb.rz", False),
        ("lowerback.ry", True),
        ("Hips.Yposition", False),
        ("Hips.Zrotation", False),
        ("mixamorig:Hips.Zrotation", False),
        ("LeftHip.Xrotation", True),
        ("LeftUpLeg.Xrotation", True),
        ("LeftForeArm.Xrotation", True),
        ("LeftHand.Xrotation", False),
        ("LeftHandIndex1.Xrotation", False),
        ("RightToeBase.Xrotation", False),
        ("LeftFingerBase.Zrotation", False),
        ("RThumb.Zrotation", False),
        ("LeftFoot.Xrotation", True),
        ("Spine1.Xrotation", True),
    ],
)
def test_body_angles_leave_out_root_hands_fingers_and_toes(name, counts):
    assert body_channels([name])[0] == counts


def test_the_body_of_cmu_is_43_angles():
    assert body_channels(MOTION.channels).sum() == 62 - 6 - 2 * (2 + 1 + 2 + 1)


def test_real_recordings_compare(data):
    from motionmend.io import read

    truth = read(data / "mocap" / "amc" / "02" / "02_01.amc", fps=120)
    spoilt = corrupt(truth, noise=np.radians(3.0), outliers=0.05, gaps=0.05, seed=1)
    found = compare(truth, spoilt.recording)
    assert found.missing["samples"] == spoilt.missing.sum()
    assert 5.0 < found.rms_deg < 15.0  # 3 degrees and one sample in twenty off by 37 on average: 8.9
    assert found.mean_cm_by_joint["root"] < found.mean_cm_by_joint["rfingers"]
    real = read(data / "mocap" / "c3d" / "cmu_02_01.c3d")
    moved = real.with_positions(real.positions + 0.01)
    assert compare(real, moved).mean_cm == pytest.approx(np.sqrt(3.0))
    assert positions(truth.skeleton, truth.q).shape[0] == truth.frames
