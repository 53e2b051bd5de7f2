"""Joint sets: each joint has one meaning, trees are trees, and maps between sets agree with the names."""

from random import Random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionmend.arrays import Ints
from motionmend.bodies.joint_sets import (
    AZURE32,
    JOINT_SETS,
    KINECT25,
    TRACKER16,
    TREE,
    UIPRMD22,
    JointSet,
    correspondence,
    known_set,
    meanings,
    mirrored,
    parents,
)

SETS = list(JOINT_SETS.values())


def depth(parent: Ints, joint: int) -> int:
    """Steps from a joint to its root; fails on a cycle."""
    steps = 0
    while parent[joint] >= 0:
        joint = int(parent[joint])
        steps += 1
        assert steps <= len(parent)
    return steps


@pytest.mark.parametrize("one", SETS, ids=lambda one: one.key)
def test_a_set_is_one_tree_of_joints_with_one_meaning_each(one: JointSet) -> None:
    named = [meaning for meaning in one.meanings if meaning]
    assert len(set(named)) == len(named)
    assert set(named) <= set(TREE)
    assert one.parents.count(-1) == 1
    for joint in range(len(one.names)):
        depth(np.array(one.parents), joint)


@pytest.mark.parametrize("one", SETS, ids=lambda one: one.key)
def test_the_other_side_of_the_other_side_is_the_joint_itself(one: JointSet) -> None:
    other = mirrored(one.names)
    np.testing.assert_array_equal(other[other], np.arange(len(other)))
    sided = [k for k, meaning in enumerate(one.meanings) if meaning[1:2] == "_"]
    assert all(other[k] != k for k in sided)


@given(st.sampled_from(SETS), st.sampled_from(SETS))
def test_maps_join_equal_meanings_both_ways(source: JointSet, target: JointSet) -> None:
    forth, back = correspondence(source.names, target.names), correspondence(target.names, source.names)
    for k, j in enumerate(forth):
        if j >= 0:
            assert back[j] == k
            assert source.meanings[j] == target.meanings[k]


@pytest.mark.slow
@given(st.sampled_from(SETS), st.randoms())
def test_names_in_any_order_mean_the_same(one: JointSet, random: Random) -> None:
    order = list(range(len(one.names)))
    random.shuffle(order)
    names = [one.names[k] for k in order]
    assert meanings(names) == tuple(one.meanings[k] for k in order)
    found = parents(names)
    for here, k in enumerate(order):
        wanted = one.parents[k]
        assert (found[here] < 0) if wanted < 0 else names[found[here]] == one.names[wanted]


def test_the_second_kinect_and_uiprmd_share_seventeen_joints() -> None:
    joined = correspondence(KINECT25.names, UIPRMD22.names)
    assert KINECT25.names[joined[UIPRMD22.names.index("LHand")]] == "WristLeft"
    assert KINECT25.names[joined[UIPRMD22.names.index("Neck")]] == "SpineShoulder"
    assert (joined >= 0).sum() == 18


def test_all_of_the_trackers_joints_are_found_in_the_second_kinect() -> None:
    assert (correspondence(KINECT25.names, TRACKER16.names) >= 0).all()


@pytest.mark.parametrize(
    ("names", "wanted"),
    [
        ("Hips LeftUpLeg LeftLeg LeftFoot LeftToeBase", "pelvis l_hip l_knee l_ankle l_foot"),
        (
            "Spine Neck Head LeftShoulder LeftArm LeftForeArm LeftHand",
            "spine neck head l_clavicle l_shoulder l_elbow l_wrist",
        ),
        ("Hip RHip RKnee RAnkle RBigToe RHeel Nose RWrist", "pelvis r_hip r_knee r_ankle r_foot r_heel nose r_wrist"),
        ("root lfemur ltibia lfoot ltoes rhumerus rradius", "pelvis l_hip l_knee l_ankle l_foot r_shoulder r_elbow"),
        ("Hip Neck Head RShoulder", "pelvis neck_base head r_shoulder"),
        ("mixamorig:LeftForeArm hand_l tool", "l_elbow l_wrist -"),
        (
            "pelvis spine_01 spine_02 spine_03 neck_01 head clavicle_l upperarm_l lowerarm_l thigh_r calf_r foot_r "
            "ball_r",
            "pelvis spine - chest neck head l_clavicle l_shoulder l_elbow r_hip r_knee r_ankle r_foot",
        ),
        (
            "shoulder.L upper_arm.L forearm.L hand.L shin.R foot.R",
            "l_clavicle l_shoulder l_elbow l_wrist r_knee r_ankle",
        ),
        ("Bip01_L_Clavicle Bip01_L_UpperArm Bip01_L_Foot Bip01_L_Toe0", "l_clavicle l_shoulder l_ankle l_foot"),
        ("RightShoulder RightUpperArm", "r_clavicle r_shoulder"),
        ("NAVAL_SPINE CHEST_SPINE NECK", "spine chest neck"),
        ("XN_SKEL_TORSO XN_SKEL_LEFT_KNEE", "spine l_knee"),
        ("NUI_SKELETON_POSITION_HIP_CENTER NUI_SKELETON_POSITION_FOOT_LEFT", "pelvis l_ankle"),
        ("hand_ball ball", "- -"),
        ("root pelvis upperarm_l", "- pelvis l_shoulder"),  # on the floor, below the pelvis
        ("root spine", "pelvis spine"),
        ("root lhipjoint lfemur", "pelvis - l_hip"),
        ("ShoulderSpine MidSpine BaseSpine", "neck_base spine pelvis"),
        (
            "root hips_joint left_upLeg_joint left_toesEnd_joint spine_1_joint spine_7_joint left_shoulder_1_joint "
            "left_arm_joint left_hand_joint",
            "- pelvis l_hip l_toe_tip spine neck_base l_clavicle l_shoulder l_wrist",
        ),
        (
            "human_top_head_3D human_center_shoulder_3D human_left_knee_3D human_root_3D",
            "head_top neck_base l_knee pelvis",
        ),
        (
            "Body_Root Body_Hips Body_SpineLower Body_Chest Body_LeftShoulder Body_LeftArmUpper Body_LeftArmLower "
            "Body_LeftHandWrist Body_LeftHandPalm",
            "- pelvis spine chest l_clavicle l_shoulder l_elbow l_wrist l_hand",
        ),
        (
            "FullBody_LeftUpperLeg FullBody_LeftFootAnkle XR_FULL_BODY_JOINT_RIGHT_ARM_LOWER_META",
            "l_hip l_ankle r_elbow",
        ),
    ],
)
def test_names_of_other_makers_are_understood(names: str, wanted: str) -> None:
    assert meanings(names.split()) == tuple("" if one == "-" else one for one in wanted.split())


@pytest.mark.parametrize("prefix", ["mixamorig:", "mixamorig1:", "mixamorig_", "Bip01 ", "Skeleton_"])
def test_what_a_maker_puts_before_all_names_does_not_change_what_one_means_beside_the_others(prefix: str) -> None:
    names = ["Hips", "Spine", "Spine1", "Spine2", "Neck", "Head"]
    limbs = ("Shoulder", "Arm", "ForeArm", "Hand", "UpLeg", "Leg", "Foot", "ToeBase")
    names += [f"{side}{limb}" for side in ("Left", "Right") for limb in limbs]
    assert {"l_clavicle", "r_shoulder", "l_wrist", "r_ankle", "l_foot"} <= set(meanings(names))
    assert meanings([f"{prefix}{name}" for name in names]) == meanings(names)


def test_enumerators_of_the_azure_kinect_are_its_joint_set() -> None:
    assert known_set([f"K4ABT_JOINT_{name}" for name in AZURE32.names]) is AZURE32


def test_case_and_punctuation_do_not_count_but_order_does() -> None:
    assert known_set([name.lower() for name in KINECT25.names]) is KINECT25
    assert known_set(KINECT25.names[::-1]) is None
    assert known_set(["a", "b"]) is None


def test_what_is_missing_from_a_trunk_is_stepped_over() -> None:
    names = ["Head", "LShoulder", "Pelvis", "Marker"]
    np.testing.assert_array_equal(parents(names), [2, 2, -1, -1])


def test_names_of_nuitrack_mean_the_same_with_and_without_their_prefix() -> None:
    limbs = ("COLLAR", "SHOULDER", "ELBOW", "HIP", "KNEE", "ANKLE", "FOOT")
    names = [f"{side}_{joint}" for side in ("LEFT", "RIGHT") for joint in limbs]
    names += ["HEAD", "NECK", "TORSO", "WAIST"]
    prefixed = [f"JOINT_{name}" for name in names]
    assert meanings(prefixed) == meanings(names)
    assert {"head", "neck", "l_shoulder", "r_knee", "l_foot"} <= set(meanings(prefixed))
    np.testing.assert_array_equal(parents(prefixed), parents(names))


@pytest.mark.parametrize(
    ("name", "wanted"),
    [
        ("RSmallToe", "RBigToe"),
        ("left_pinky", "LWrist"),
        ("LIndex3", "LWrist"),
        ("little_finger_right", "Neck"),  # of that arm nothing is there
        ("r_sh2_study", "RKnee"),
        ("r_mknee_study", "RKnee"),
        ("L.ASIS_study", "LHip"),
        ("r_calc_study", "RHeel"),
        ("r_5meta_study", "RBigToe"),
        ("l_metacarpal_2", "LWrist"),
        ("LForearm1", "LShoulder"),  # there is no elbow, and a forearm no ear
        ("MidHip", "Hip"),
        ("LPelvis", "Hip"),
        ("mouth_left", "Nose"),
        ("spine_4_joint", "Hip"),
        ("LeftScapula", "LShoulder"),
        ("Fridge", ""),
    ],
)
def test_what_means_no_joint_hangs_from_the_one_it_is_at(name: str, wanted: str) -> None:
    joints = [
        "Hip",
        "RHip",
        "RKnee",
        "RAnkle",
        "RBigToe",
        "RHeel",
        "LHip",
        "LKnee",
        "Neck",
        "Nose",
        "LShoulder",
        "LWrist",
    ]
    assert parents(joints).tolist() == parents([*joints, name])[:-1].tolist()
    found = int(parents([*joints, name])[-1])
    assert (joints[found] if found >= 0 else "") == wanted
