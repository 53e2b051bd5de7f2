"""Feet: found under every rig's names, contacts that do not depend on place, heading or frame rate, honest skate."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bipeds import biped, steps, walk
from motionmend.arrays import runs
from motionmend.bodies.feet import contacts, foot_joints, foot_markers, skate, skate_during
from motionmend.bodies.motion import Motion
from motionmend.bodies.skeleton import Skeleton, positions
from motionmend.errors import MismatchError
from motionmend.io import read

Y_UP = np.array([0.0, 1.0, 0.0])

RIGS = {
    "cmu": ("lfemur", "ltibia", "lfoot", "ltoes", "ltoes_end"),
    "bvh": ("LeftUpLeg", "LeftLeg", "LeftFoot", "LeftToeBase", "LeftToeBase_end"),
    "mixamo": (
        "mixamorig:LeftUpLeg",
        "mixamorig:LeftLeg",
        "mixamorig:LeftFoot",
        "mixamorig:LeftToeBase",
        "mixamorig:LeftToe_End",
    ),
    "poser": ("lThigh", "lShin", "lFoot", "lToe", "lToe_end"),
    "ankle": ("LeftHip", "LeftKnee", "LeftAnkle", "LeftToe", "LeftToe_end"),
    "blender": ("Thigh_L", "Shin_L", "Foot_L", "Toe_L", "Toe_L_end"),
    "smpl": ("L_Hip", "L_Knee", "L_Ankle", "L_Foot", "L_Foot_end"),
    "sensor": ("HipLeft", "KneeLeft", "AnkleLeft", "FootLeft", "TipLeft"),
    "biped": ("Bip01_L_Thigh", "Bip01_L_Calf", "Bip01_L_Foot", "Bip01_L_Toe0", "Bip01_L_Toe0Nub"),
    "tracker": ("l_hip", "l_knee", "l_ankle", "l_toe", "l_toe_end"),
}


@pytest.mark.parametrize("names", RIGS.values(), ids=RIGS.keys())
def test_legs_are_found_by_name(names):
    """Hip, knee, ankle, toes and tips, left first, nothing guessed."""
    feet = foot_joints(biped(names))
    assert (feet.hips, feet.knees, feet.ankles) == ((1, 6), (2, 7), (3, 8))
    assert (feet.toes, feet.ends) == ((4, 9), (5, 10))
    assert feet.joints.tolist() == [3, 4, 8, 9]
    assert feet.guesses == ()


def test_without_names_the_lowest_chain_ends_are_feet_and_that_is_said():
    """Left is to the left of where the feet point."""
    feet = foot_joints(biped(("a", "b", "c", "d", "e")))
    assert (feet.hips, feet.knees, feet.ankles, feet.toes) == ((1, 6), (2, 7), (3, 8), (4, 9))
    assert "lowest" in feet.guesses[0]
    assert "'c'" in feet.guesses[0]


def test_twist_joints_and_idle_joints_are_no_knees():
    """Rigs split the shank and put a joint between pelvis and thigh: the long bones count."""
    plain = biped()
    left = ("LHipJoint", "LeftUpLeg", "LeftLeg", "LeftLegRoll", "LeftFoot", "LeftToeBase")
    body = Skeleton(
        names=("Hips", *left, *(name.replace("L", "R", 1).replace("Reft", "Right") for name in left)),
        parents=np.array([-1, 0, 1, 2, 3, 4, 5, 0, 7, 8, 9, 10, 11]),
        offsets=np.array(
            [[0, 0, 0]]
            + [
                row
                for side in (0.1, -0.1)
                for row in ([0, 0, 0], [side, -0.08, 0], [0, -0.42, 0], [0, -0.05, 0], [0, -0.35, 0], [0, -0.07, 0.13])
            ],
            dtype=float,
        ),
        dof_names=tuple(f"d{i}" for i in range(13)),
        dof_joint=np.arange(13),
        dof_axis=np.tile(plain.dof_axis[3], (13, 1)),
        dof_kind=np.zeros(13, dtype=np.uint8),
        limits=np.tile([-3.0, 3.0], (13, 1)),
    )
    feet = foot_joints(body)
    assert (feet.hips, feet.knees, feet.ankles, feet.toes) == ((2, 8), (4, 10), (5, 11), (6, 12))
    assert feet.ends == (-1, -1)


def test_a_body_without_two_legs_has_no_feet():
    """Said in one line."""
    chain = Skeleton(
        ("a", "b"), np.array([-1, 0]), np.zeros((2, 3)), (), *(np.empty(s) for s in (0, (0, 3), 0, (0, 2)))
    )
    with pytest.raises(MismatchError, match="two legs"):
        foot_joints(chain)


@pytest.mark.parametrize(
    ("names", "left", "right"),
    [
        (["subject:LANK", "LHEE", "LTOE", "LMT5", "LKNE", "RANK", "RHEE", "RTOE", "RMT5", "C7"], 4, 4),
        (["L.Heel", "L.Toe", "L.LateralFoot", "R.Heel", "R.Toe", "R.Hip", "R.DistalShank"], 3, 2),
        (["LHEL", "LMT1", "LMT5", "LSHN", "RHEL", "RMT1", "RMT5", "RHIP"], 3, 3),
        (["Heel", "Ball", "LFHD", "RELB", "LFIN", "LTHI"], 0, 0),
        (["left_heel", "left_foot_index", "left_ankle", "right_heel", "right_knee"], 3, 1),
    ],
)
def test_markers_of_the_feet_are_found_by_name(names, left, right):
    """And no others."""
    found = foot_markers(names)
    assert (len(found.left), len(found.right)) == (left, right)
    assert found.markers.tolist() == list(found.left + found.right)


@settings(max_examples=15)
@given(
    fps=st.sampled_from([25.0, 30.0, 60.0, 120.0, 250.0]),
    heading=st.floats(0, 6.28),
    height=st.floats(-2, 2),
    slope=st.floats(-0.02, 0.02),
    noise=st.floats(0, 0.003),
)
def test_contacts_of_walking_are_found_at_any_rate_place_and_heading(fps, heading, height, slope, noise):
    """Against the contacts that the steps were made with: no edge is off by more than 0.1 s."""
    places, truth = steps(4.0, fps)
    places[..., 1] += slope * places[..., 2] + height
    turn = np.array([[np.cos(heading), 0, np.sin(heading)], [0, 1, 0], [-np.sin(heading), 0, np.cos(heading)]])
    places = places @ turn.T + noise * np.random.default_rng(0).normal(size=places.shape)
    found = contacts(places, fps, Y_UP)
    for point in range(4):
        for begin, end in runs(truth[:, point]):
            inner = slice(begin + round(0.1 * fps), end - round(0.1 * fps))
            assert found[inner, point].all()
        for begin, end in runs(~truth[:, point]):
            inner = slice(begin + round(0.1 * fps), end - round(0.1 * fps))
            assert not found[inner, point].any()


def test_up_may_be_any_axis():
    """The same walk with z up gives the same contacts and skate."""
    found = []
    for up in (1, 2):
        motion, _ = walk(2.0, up=up)
        body = motion.skeleton
        places = positions(body, motion.q)[:, foot_joints(body).joints]
        found.append((contacts(places, motion.fps, body.up), skate(places, motion.fps, body.up)))
    np.testing.assert_array_equal(found[0][0], found[1][0])
    assert found[0][1] == pytest.approx(found[1][1])


def test_a_point_that_never_comes_down_never_stands():
    """A foot held up for the whole clip is no contact, however still."""
    places, _ = steps(3.0, 60.0)
    places[:, 2:] = np.array([-0.1, 0.5, 0.0])
    found = contacts(places, 60.0, Y_UP)
    assert found[:, :2].any()
    assert not found[:, 2:].any()


@settings(max_examples=15)
@given(st.floats(0, 0.25), st.sampled_from([30.0, 60.0, 120.0, 240.0]), st.floats(0, 6.28))
def test_skate_is_the_speed_at_which_standing_feet_slide(speed, fps, heading):
    """A standing foot that slides at v has a skate of v, at every frame rate and in every direction."""
    time = np.arange(round(2 * fps)) / fps
    places = np.zeros((len(time), 2, 3))
    places[:, 0] = speed * time[:, None] * np.array([np.cos(heading), 0.0, np.sin(heading)])
    places[:, 1] = places[:, 0] + 0.1
    assert contacts(places, fps, Y_UP).all()
    assert skate(places, fps, Y_UP) == pytest.approx(speed, abs=1e-12)


def test_skate_leaves_out_what_rises_what_is_missing_and_what_does_not_stand():
    """Only level speed within contacts counts; nothing to measure is not 0 but NaN."""
    rng = np.random.default_rng(3)
    places = np.zeros((60, 1, 3))
    places[:, 0, 1] = rng.normal(size=60)
    places[30:, 0, 0] = 5.0
    standing = np.ones((60, 1), dtype=bool)
    standing[30] = False
    assert skate_during(places, standing, 30.0, Y_UP) == 0.0
    places[10:15] = np.nan
    assert skate_during(places, standing, 30.0, Y_UP) == 0.0
    assert np.isnan(skate_during(places, np.zeros((60, 1), dtype=bool), 30.0, Y_UP))
    assert np.isnan(skate(np.full((10, 1, 3), np.nan), 30.0, Y_UP))
    assert np.isnan(skate_during(places[:1], standing[:1], 30.0, Y_UP))


def test_missing_samples_cost_their_own_frames_only():
    """Gaps in the feet: no contact there, the same contacts elsewhere but for the gap's neighbours."""
    places, _ = steps(4.0, 120.0)
    whole = contacts(places, 120.0, Y_UP)
    rng = np.random.default_rng(1)
    gone = np.zeros(len(places), dtype=bool)
    for begin in rng.integers(0, len(places) - 5, size=6):
        gone[begin : begin + 5] = True
    places[gone, 1] = np.nan
    found = contacts(places, 120.0, Y_UP)
    assert not found[gone, 1].any()
    far = ~np.convolve(gone, np.ones(21), mode="same").astype(bool)
    assert (found[far] == whole[far]).mean() > 0.98


def test_what_does_not_fit_is_said():
    """One line, with what came."""
    with pytest.raises(MismatchError, match="positions"):
        contacts(np.zeros((4, 3)), 30.0, Y_UP)
    with pytest.raises(MismatchError, match="contacts must be"):
        skate_during(np.zeros((4, 2, 3)), np.ones((4, 1), dtype=bool), 30.0, Y_UP)


@settings(max_examples=30)
@given(st.lists(st.booleans(), max_size=30))
def test_runs_cover_what_holds(state):
    """Each run is all true, ends are false or the end, together they are all."""
    state = np.array(state, dtype=bool)
    covered = np.zeros(len(state), dtype=bool)
    for begin, end in runs(state):
        assert begin < end
        assert state[begin:end].all()
        assert begin == 0 or not state[begin - 1]
        covered[begin:end] = True
    np.testing.assert_array_equal(covered, state)


@pytest.mark.parametrize(
    ("clip", "least", "most"), [("07/07_01", 0.3, 0.7), ("16/16_01", 0.7, 0.9), ("09/09_01", 0.1, 0.4)]
)
def test_real_clips_stand_as_long_as_people_do(data, clip, least, most):
    """Walking 60 %, a jump on the spot all but the flight, running a quarter; clean clips skate below 0.25 m/s."""
    motion = read(data / "mocap" / "amc" / f"{clip}.amc")
    places = positions(motion.skeleton, motion.q)[:, foot_joints(motion.skeleton).joints]
    found = contacts(places, motion.fps, motion.skeleton.up)
    assert (found.mean(axis=0) > least).all()
    assert (found.mean(axis=0) < most).all()
    assert skate(places, motion.fps, motion.skeleton.up) < 0.25


def test_a_real_jump_is_in_the_air_and_a_real_walk_never(data):
    """All points off the floor at the top of the jump; in walking one foot always stands."""
    jump = read(data / "mocap" / "amc" / "16" / "16_01.amc")
    places = positions(jump.skeleton, jump.q)[:, foot_joints(jump.skeleton).joints]
    found = contacts(places, jump.fps, jump.skeleton.up)
    assert not found[(places @ jump.skeleton.up).min(axis=1).argmax()].any()
    walking = read(data / "mocap" / "amc" / "07" / "07_01.amc")
    places = positions(walking.skeleton, walking.q)[:, foot_joints(walking.skeleton).joints]
    assert contacts(places, walking.fps, walking.skeleton.up).any(axis=1).mean() > 0.98


def test_contacts_of_a_real_clip_agree_at_all_frame_rates(data):
    """120, 60 and 30 Hz of the same walk: 97 % of the frames alike, skate within a tenth."""
    motion = read(data / "mocap" / "amc" / "07" / "07_01.amc")
    body, joints = motion.skeleton, foot_joints(motion.skeleton).joints
    places = positions(body, motion.q)[:, joints]
    full = contacts(places, motion.fps, body.up)
    for step in (2, 4):
        slower = Motion(body, motion.q[::step], motion.fps / step)
        places = positions(body, slower.q)[:, joints]
        assert (contacts(places, slower.fps, body.up) == full[::step]).mean() > 0.97
        assert skate(places, slower.fps, body.up) == pytest.approx(0.095, rel=0.1)


@pytest.mark.slow
def test_feet_are_found_in_real_files(data):
    """Every .bvh and one .amc a person, markers of every .c3d."""
    for path in sorted((data / "mocap" / "bvh").glob("*.bvh")) + sorted((data / "mocap" / "amc").glob("*/*_01.amc")):
        body = read(path).skeleton
        feet = foot_joints(body)
        assert feet.guesses == (), path.name
        assert min(feet.hips + feet.knees + feet.ankles + feet.toes) > 0, path.name
        named = [body.names[joint].lower() for joint in feet.ankles]
        assert named[0][0] == "l", path.name
        assert named[1][0] == "r", path.name
    for path in sorted((data / "mocap" / "c3d").glob("*.c3d")):
        if "golfswing" in path.name:
            continue
        found = foot_markers(read(path).names)
        assert len(found.left) >= 3, path.name
        assert len(found.left) == len(found.right), path.name
