"""The joint sets that sensors and trackers report, what each joint means on a body, and the maps between sets.

A joint's *meaning* is its place on a body in one vocabulary, whatever a sensor calls it: `HipCenter` of the first
Kinect, `SpineBase` of the second and `PELVIS` of Azure Kinect are all `pelvis`. Two sets are joined by meanings.
Left and right are the person's own.

Sources: Kinect for Windows SDK 1.8 (NUI_SKELETON_POSITION_INDEX) and 2.0 (JointType), Azure Kinect Body Tracking SDK
(k4abt_joint_id_t), UI-PRMD's appendix, UTD-MHAD's read-me, MediaPipe's pose landmarks.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import final

import numpy as np

from ..arrays import Ints

# Every meaning and the meaning it hangs from; an order in which parents come first.
TREE: dict[str, str] = {"pelvis": "", "spine": "pelvis", "chest": "spine", "neck_base": "chest", "neck": "neck_base"}
TREE |= {"head": "neck", "head_top": "head", "nose": "head"}
for _side in ("l", "r"):
    TREE |= {
        f"{_side}_eye": "head",
        f"{_side}_ear": "head",
        f"{_side}_clavicle": "neck_base",
        f"{_side}_shoulder": f"{_side}_clavicle",
        f"{_side}_elbow": f"{_side}_shoulder",
        f"{_side}_wrist": f"{_side}_elbow",
        f"{_side}_hand": f"{_side}_wrist",
        f"{_side}_hand_tip": f"{_side}_hand",
        f"{_side}_thumb": f"{_side}_wrist",
        f"{_side}_hip": "pelvis",
        f"{_side}_knee": f"{_side}_hip",
        f"{_side}_ankle": f"{_side}_knee",
        f"{_side}_heel": f"{_side}_ankle",
        f"{_side}_foot": f"{_side}_ankle",
        f"{_side}_toe_tip": f"{_side}_foot",
    }


@final
@dataclass(frozen=True)
class JointSet:
    """The joints of one sensor or tracker.

    Attributes
    ----------
    key : its name here ("kinect20").
    names : (J,) in the sensor's order and spelling.
    meanings : (J,) keys of `TREE`; "" for a joint that has no counterpart elsewhere.
    parents : (J,) index of the joint that each hangs from, -1 for the root; not always lower than the joint's own.
    """

    key: str
    names: tuple[str, ...]
    meanings: tuple[str, ...]
    parents: tuple[int, ...]


def _joint_set(key: str, *rows: str) -> JointSet:
    """A set of rows `name meaning parent`; `-` stands for no meaning and for no parent."""
    parts = [row.split() for one in rows for row in one.split(",")]
    names = tuple(name for name, _, _ in parts)
    meanings = tuple("" if meaning == "-" else meaning for _, meaning, _ in parts)
    return JointSet(key, names, meanings, tuple(-1 if p == "-" else names.index(p) for _, _, p in parts))


KINECT20 = _joint_set(
    "kinect20",
    "HipCenter pelvis -,Spine spine HipCenter,ShoulderCenter neck_base Spine,Head head ShoulderCenter",
    "ShoulderLeft l_shoulder ShoulderCenter,ElbowLeft l_elbow ShoulderLeft,WristLeft l_wrist ElbowLeft",
    "HandLeft l_hand WristLeft",
    "ShoulderRight r_shoulder ShoulderCenter,ElbowRight r_elbow ShoulderRight,WristRight r_wrist ElbowRight",
    "HandRight r_hand WristRight",
    "HipLeft l_hip HipCenter,KneeLeft l_knee HipLeft,AnkleLeft l_ankle KneeLeft,FootLeft l_foot AnkleLeft",
    "HipRight r_hip HipCenter,KneeRight r_knee HipRight,AnkleRight r_ankle KneeRight,FootRight r_foot AnkleRight",
)
KINECT25 = _joint_set(
    "kinect25",
    "SpineBase pelvis -,SpineMid spine SpineBase,Neck neck SpineShoulder,Head head Neck",
    "ShoulderLeft l_shoulder SpineShoulder,ElbowLeft l_elbow ShoulderLeft,WristLeft l_wrist ElbowLeft",
    "HandLeft l_hand WristLeft",
    "ShoulderRight r_shoulder SpineShoulder,ElbowRight r_elbow ShoulderRight,WristRight r_wrist ElbowRight",
    "HandRight r_hand WristRight",
    "HipLeft l_hip SpineBase,KneeLeft l_knee HipLeft,AnkleLeft l_ankle KneeLeft,FootLeft l_foot AnkleLeft",
    "HipRight r_hip SpineBase,KneeRight r_knee HipRight,AnkleRight r_ankle KneeRight,FootRight r_foot AnkleRight",
    "SpineShoulder neck_base SpineMid,HandTipLeft l_hand_tip HandLeft,ThumbLeft l_thumb WristLeft",
    "HandTipRight r_hand_tip HandRight,ThumbRight r_thumb WristRight",
)
AZURE32 = _joint_set(
    "azure32",
    "PELVIS pelvis -,SPINE_NAVEL spine PELVIS,SPINE_CHEST chest SPINE_NAVEL,NECK neck_base SPINE_CHEST",
    "CLAVICLE_LEFT l_clavicle SPINE_CHEST,SHOULDER_LEFT l_shoulder CLAVICLE_LEFT,ELBOW_LEFT l_elbow SHOULDER_LEFT",
    "WRIST_LEFT l_wrist ELBOW_LEFT,HAND_LEFT l_hand WRIST_LEFT,HANDTIP_LEFT l_hand_tip HAND_LEFT",
    "THUMB_LEFT l_thumb WRIST_LEFT",
    "CLAVICLE_RIGHT r_clavicle SPINE_CHEST,SHOULDER_RIGHT r_shoulder CLAVICLE_RIGHT",
    "ELBOW_RIGHT r_elbow SHOULDER_RIGHT,WRIST_RIGHT r_wrist ELBOW_RIGHT,HAND_RIGHT r_hand WRIST_RIGHT",
    "HANDTIP_RIGHT r_hand_tip HAND_RIGHT,THUMB_RIGHT r_thumb WRIST_RIGHT",
    "HIP_LEFT l_hip PELVIS,KNEE_LEFT l_knee HIP_LEFT,ANKLE_LEFT l_ankle KNEE_LEFT,FOOT_LEFT l_foot ANKLE_LEFT",
    "HIP_RIGHT r_hip PELVIS,KNEE_RIGHT r_knee HIP_RIGHT,ANKLE_RIGHT r_ankle KNEE_RIGHT",
    "FOOT_RIGHT r_foot ANKLE_RIGHT,HEAD head NECK,NOSE nose HEAD,EYE_LEFT l_eye HEAD,EAR_LEFT l_ear HEAD",
    "EYE_RIGHT r_eye HEAD,EAR_RIGHT r_ear HEAD",
)
UIPRMD22 = _joint_set(
    "uiprmd22",
    "Waist pelvis -,Spine spine Waist,Chest chest Spine,Neck neck_base Chest,Head head Neck,HeadTip head_top Head",
    "LCollar l_clavicle Chest,LUpperArm l_shoulder LCollar,LForearm l_elbow LUpperArm,LHand l_wrist LForearm",
    "RCollar r_clavicle Chest,RUpperArm r_shoulder RCollar,RForearm r_elbow RUpperArm,RHand r_wrist RForearm",
    "LUpperLeg l_hip Waist,LLowerLeg l_knee LUpperLeg,LFoot l_ankle LLowerLeg,LToes l_foot LFoot",
    "RUpperLeg r_hip Waist,RLowerLeg r_knee RUpperLeg,RFoot r_ankle RLowerLeg,RToes r_foot RFoot",
)
UTDMHAD20 = _joint_set(
    "utdmhad20",
    "head head shoulder_center,shoulder_center neck_base spine,spine spine hip_center,hip_center pelvis -",
    "left_shoulder l_shoulder shoulder_center,left_elbow l_elbow left_shoulder,left_wrist l_wrist left_elbow",
    "left_hand l_hand left_wrist",
    "right_shoulder r_shoulder shoulder_center,right_elbow r_elbow right_shoulder,right_wrist r_wrist right_elbow",
    "right_hand r_hand right_wrist",
    "left_hip l_hip hip_center,left_knee l_knee left_hip,left_ankle l_ankle left_knee,left_foot l_foot left_ankle",
    "right_hip r_hip hip_center,right_knee r_knee right_hip,right_ankle r_ankle right_knee",
    "right_foot r_foot right_ankle",
)
MEDIAPIPE33 = _joint_set(
    "mediapipe33",
    "nose nose -,left_eye_inner - left_eye,left_eye l_eye nose,left_eye_outer - left_eye",
    "right_eye_inner - right_eye,right_eye r_eye nose,right_eye_outer - right_eye",
    "left_ear l_ear left_eye,right_ear r_ear right_eye,mouth_left - nose,mouth_right - nose",
    "left_shoulder l_shoulder nose,right_shoulder r_shoulder nose",
    "left_elbow l_elbow left_shoulder,right_elbow r_elbow right_shoulder",
    "left_wrist l_wrist left_elbow,right_wrist r_wrist right_elbow,left_pinky - left_wrist",
    "right_pinky - right_wrist,left_index - left_wrist,right_index - right_wrist",
    "left_thumb l_thumb left_wrist,right_thumb r_thumb right_wrist,left_hip l_hip left_shoulder",
    "right_hip r_hip right_shoulder,left_knee l_knee left_hip,right_knee r_knee right_hip",
    "left_ankle l_ankle left_knee,right_ankle r_ankle right_knee,left_heel l_heel left_ankle",
    "right_heel r_heel right_ankle,left_foot_index l_foot left_ankle,right_foot_index r_foot right_ankle",
)
TRACKER16 = _joint_set(
    "tracker16",
    "pelvis pelvis -,chest neck_base pelvis,neck neck chest,head head neck",
    "l_shoulder l_shoulder chest,l_elbow l_elbow l_shoulder,l_wrist l_wrist l_elbow",
    "r_shoulder r_shoulder chest,r_elbow r_elbow r_shoulder,r_wrist r_wrist r_elbow",
    "l_hip l_hip pelvis,l_knee l_knee l_hip,l_ankle l_ankle l_knee",
    "r_hip r_hip pelvis,r_knee r_knee r_hip,r_ankle r_ankle r_knee",
)
JOINT_SETS = {one.key: one for one in (KINECT20, KINECT25, AZURE32, UIPRMD22, UTDMHAD20, MEDIAPIPE33, TRACKER16)}

# What joints and bones are called elsewhere (Pose2Sim, OpenPose, HALPE, Acclaim, BVH, Unity, Unreal, Blender), without
# their side.
_MIDDLE = {
    "pelvis": "pelvis hip hips hipcenter midhip root waist spinebase hipscenter centerhip chip pelvisroot cmidhip "
    "basespine",
    "spine": "spine spinemid spinenavel navelspine spine1 spine01 lowerback torso abdomen midspine spinelower",
    "chest": "chest spinechest chestspine spine2 upperback spine3 spine03",
    "neck_base": "neckbase shouldercenter spineshoulder cshoulder midshoulder c7 shoulderspine centershoulder spine7",
    "neck": "neck lowerneck neck1 neck01",
    "head": "head upperneck centerhead",
    "head_top": "headtip headtop headend topofhead headsite tophead",
    "nose": "nose",
}
_SIDED = {
    "eye": "eye",
    "ear": "ear",
    "clavicle": "clavicle collar shoulder1",
    "shoulder": "shoulder upperarm arm humerus armupper",
    "elbow": "elbow forearm lowerarm radius armlower",
    "wrist": "wrist handwrist",
    "hand": "hand handpalm",
    "hand_tip": "handtip",
    "thumb": "thumb",
    "hip": "hip upperleg upleg thigh femur",
    "knee": "knee lowerleg leg shin calf tibia",
    "ankle": "ankle footankle",
    "heel": "heel",
    "foot": "foot toe toes toe0 toebase ball bigtoe footindex football",
    "toe_tip": "toetip toeend toesend toebaseend",
}
# What else is on a body (skin, fingers, faces), and the joint that it is at: the first of these words in its name.
_NEAR = {
    "metacarp": "hand",
    **dict.fromkeys(("toe", "meta"), "foot"),
    **dict.fromkeys(("heel", "calc"), "heel"),
    "ankle": "ankle",
    **dict.fromkeys(("knee", "shank", "sh1", "sh2", "sh3"), "knee"),
    **dict.fromkeys(("thigh", "hjc", "asis", "psis", "hip"), "hip"),
    "wrist": "wrist",
    **dict.fromkeys(("thumb", "index", "middle", "ring", "pinky", "little", "finger", "palm", "hand"), "hand"),
    **dict.fromkeys(("elbow", "forearm"), "elbow"),
    **dict.fromkeys(("shoulder", "acromion", "upperarm"), "shoulder"),
    "eye": "eye",
    "ear": "ear",
    **dict.fromkeys(("mouth", "jaw", "chin", "brow", "face"), "nose"),
    "scapul": "shoulder",
    "spine": "spine",
    **dict.fromkeys(("head", "skull"), "head"),
    "neck": "neck",
    "c7": "neck_base",
    **dict.fromkeys(("sacr", "pelvi"), "pelvis"),
}
# What makers put before all of their names (Mixamo, Biped, Nuitrack, Quest, Apple's Vision, the SDKs of Kinects, OpenNI
# and OpenXR), and behind them (ARKit, Vision, OpenXR's body tracking).
_BEFORE = re.compile(
    r"^(mixamorig\d*|skeleton|bip0*1|joint(type)?|k4abtjoint|nuiskeletonposition|xnskel|(xr)?(full)?body(joint)?|human)"
    r"(?=[a-z])"
)
_BEHIND = re.compile(r"_(joint|3d|meta)$")  # no "lhipjoint" of Acclaim's: that bone starts at the pelvis
_ROOT = "root"
_UPPER_ARMS = {"arm", "upperarm", "humerus", "armupper"}
_MIDDLE_NAMES = {alias: meaning for meaning, aliases in _MIDDLE.items() for alias in aliases.split()}
_SIDED_NAMES = {alias: meaning for meaning, aliases in _SIDED.items() for alias in aliases.split()}


def known_set(names: Sequence[str]) -> JointSet | None:
    """The joint set that these are the names of, in its order; None when it is none known here.

    Parameters
    ----------
    names : (J,) in the recording's order; case and punctuation do not count.
    """
    plain = [_plain(name) for name in names]
    for one in JOINT_SETS.values():
        if len(one.names) == len(plain) and [_plain(name) for name in one.names] == plain:
            return one
    return None


def meanings(names: Sequence[str]) -> tuple[str, ...]:
    """What each joint is on a body, a key of `TREE`; "" where that is not known.

    Names of a set known here have its meanings; of any others each is read by itself. No meaning is given twice: the
    first joint of that name has it.

    Parameters
    ----------
    names : (J,) in any order.
    """
    whole = _set_holding(names)
    if whole is not None:
        table = {_plain(name): meaning for name, meaning in zip(whole.names, whole.meanings, strict=True)}
        found = [table[_plain(name)] for name in names]
    else:
        parted = [_parted(name) for name in names]
        found = [_meaning(name) for name in names]
        if {stem for side, stem in parted if side} & _UPPER_ARMS:  # a "shoulder" is the collar's
            found = [
                f"{side}_clavicle" if side and stem == "shoulder" else one
                for one, (side, stem) in zip(found, parted, strict=True)
            ]
        if found.count("pelvis") > 1:  # a "root" beside hips or a pelvis is where somebody stands, on the floor
            found = ["" if stem == _ROOT else one for one, (_, stem) in zip(found, parted, strict=True)]
        if not any(one.endswith("_ankle") for one in found):  # a "foot" beside "toes" starts at the ankle
            found = [
                f"{side}_ankle" if side and stem == "foot" else one
                for one, (side, stem) in zip(found, parted, strict=True)
            ]
        if not any(one.endswith("_wrist") for one in found):  # a "hand" starts at the wrist
            found = [f"{one[0]}_wrist" if one.endswith("_hand") else one for one in found]
        if not {"spine", "chest", "neck_base"} & set(found):  # pose estimators' neck lies between the shoulders
            found = ["neck_base" if one == "neck" else one for one in found]
    seen: set[str] = set()
    for k, one in enumerate(found):
        found[k] = "" if one in seen else one
        seen.add(one)
    return tuple(found)


def correspondence(source: Sequence[str], target: Sequence[str]) -> Ints:
    """(J of target,) which joint of `source` means the same as each of `target`; -1 where none does.

    Joints of one name match too, whatever they mean.

    Parameters
    ----------
    source, target : names of joints.
    """
    by_meaning = {meaning: k for k, meaning in enumerate(meanings(source)) if meaning}
    by_name = {name: k for k, name in enumerate(source)}
    same = known_set(source) is not None and known_set(source) is known_set(target)
    found = []
    for name, meaning in zip(target, meanings(target), strict=True):
        if meaning and not same:
            found.append(by_meaning.get(meaning, -1))
        else:
            found.append(by_name.get(name, by_meaning.get(meaning, -1) if meaning else -1))
    return np.array(found, dtype=np.int64)


def parents(names: Sequence[str]) -> Ints:
    """(J,) the joint that each hangs from, -1 for a root or where that is not known.

    A known set has its own tree. Elsewhere a joint hangs from the nearest meaning above its own that is there, and
    where the trunk is missing from the trunk's nearest joint that is. What means no joint of its own, as a little toe,
    hangs from the joint that it is at.

    Parameters
    ----------
    names : (J,) in any order.
    """
    whole = _set_holding(names)
    if whole is not None and len(whole.names) == len(names):
        order = {_plain(name): k for k, name in enumerate(names)}
        to_here = [order[_plain(name)] for name in whole.names]
        found = np.full(len(names), -1, dtype=np.int64)
        for k, parent in enumerate(whole.parents):
            found[to_here[k]] = -1 if parent < 0 else to_here[parent]
        return found
    named = meanings(names)
    place = {meaning: k for k, meaning in enumerate(named) if meaning}
    above = []
    for name, meaning in zip(names, named, strict=True):
        upper = TREE[meaning] if meaning else _near(name)
        while upper and upper not in place:
            upper = TREE[upper]
        above.append(place[upper] if upper else -1)
    roots = [k for k, meaning in enumerate(named) if meaning and above[k] < 0]
    for k in roots[1:]:  # one body: what is left without a parent hangs from the first joint of the trunk's order
        above[k] = roots[0]
    return np.array(above, dtype=np.int64)


def mirrored(names: Sequence[str]) -> Ints:
    """(J,) the joint on the other side of the body; its own number for a joint in the middle or without a partner.

    Parameters
    ----------
    names : (J,) in any order.
    """
    named = meanings(names)
    place = {meaning: k for k, meaning in enumerate(named) if meaning}
    other = {"l": "r", "r": "l"}
    return np.array(
        [
            place.get(f"{other[meaning[0]]}{meaning[1:]}", k) if meaning[1:2] == "_" else k
            for k, meaning in enumerate(named)
        ],
        dtype=np.int64,
    )


def _set_holding(names: Sequence[str]) -> JointSet | None:
    """The smallest known set that has all of these joints, and at least half of its own among them."""
    plain = {_plain(name) for name in names}
    if len(plain) < len(names):
        return None
    holding = [
        one
        for one in JOINT_SETS.values()
        if plain <= {_plain(name) for name in one.names} and 2 * len(plain) >= len(one.names)
    ]
    return min(holding, key=lambda one: len(one.names)) if holding else None


@lru_cache(maxsize=4096)  # asked of all names of all sets for every recording
def _plain(name: str) -> str:
    """A name in lower case without punctuation, whose it is, or what its maker puts before or behind all names; Azure's
    recorder once spelt the navel another way."""
    own = _BEHIND.sub("", name.split(":")[-1].lower())
    return _BEFORE.sub("", re.sub(r"[^a-z0-9]", "", own).replace("naval", "navel"))


def _parted(name: str) -> tuple[str, str]:
    """The side that a name says ("l", "r", "" for the middle) and the rest of it as `_MIDDLE` or `_SIDED` has it;
    two times "" where they do not."""
    plain = _plain(name)
    if plain in _MIDDLE_NAMES:
        return "", plain
    for pattern in (
        r"^(?P<side>left|right)(?P<stem>.+)$",
        r"^(?P<stem>.+?)(?P<side>left|right)$",
        r"^(?P<side>[lr])(?P<stem>.+)$",
    ):
        match = re.match(pattern, plain)
        if match and match["stem"] in _SIDED_NAMES:
            return match["side"][0], match["stem"]
    behind = re.match(r"^(.+)[._]([lr])$", name.lower())
    if behind and _plain(behind[1]) in _SIDED_NAMES:
        return behind[2], _plain(behind[1])
    return "", ""


def _near(name: str) -> str:
    """The meaning of the joint at which something is that is none of its own; "" where the name does not tell."""
    own = _meaning(name)
    if own:
        return own
    bare = re.sub(r"[^a-z0-9]+", " ", name.lower()).strip()
    part = next((part for part in _NEAR if part in bare), "")
    found = _NEAR.get(part, "")
    if found in _SIDED:
        side = re.search(r"left|right", bare) or re.search(r"^[lr]| [lr]$", bare)
        return f"{side[0].strip()[0]}_{found}" if side else ""
    return found


def _meaning(name: str) -> str:
    side, stem = _parted(name)
    return f"{side}_{_SIDED_NAMES[stem]}" if side else _MIDDLE_NAMES.get(stem, "")
