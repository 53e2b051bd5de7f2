"""Joints from what optical systems record: markers on the skin, or the joints of an animated skeleton."""

from collections.abc import Sequence

import numpy as np

from ..arrays import Floats
from .motion import Markers, Motion
from .postures import Postures
from .skeleton import positions

# Plug-in Gait: the marker, or the markers in whose middle the joint lies; on the skin, not in the joint.
_MARKERS = {"head": "LFHD RFHD LBHD RBHD", "neck_base": "C7 CLAV", "pelvis": "LASI RASI LPSI RPSI"}
for _side in "LR":
    _MARKERS |= {
        f"{_side.lower()}_{joint}": " ".join(_side + name for name in names.split())
        for joint, names in {
            "shoulder": "SHO",
            "elbow": "ELB",
            "wrist": "WRA WRB",
            "knee": "KNE",
            "ankle": "ANK",
            "foot": "TOE",
        }.items()
    }
_FEWEST = 6  # joints that make a marker set one of these

# Acclaim skeletons: a joint is where its bone starts, so that names of bones mean the joint nearer to the root.
_BONES = {
    "root": "pelvis",
    "lowerback": "",
    "upperback": "spine",
    "thorax": "chest",
    "lowerneck": "neck_base",
    "upperneck": "",
    "head": "neck",
}
_BONES |= {"head_end": "head"}
for _side in "lr":
    _BONES |= {
        _side + bone: f"{_side}_{joint}" if joint else ""
        for bone, joint in {
            "clavicle": "",
            "humerus": "shoulder",
            "radius": "elbow",
            "wrist": "",
            "hand": "wrist",
            "fingers": "",
            "femur": "hip",
            "tibia": "knee",
            "foot": "ankle",
            "toes": "foot",
        }.items()
    }


def joints_of_markers(markers: Markers) -> Postures:
    """The joints that markers of the Plug-in Gait set lie on; of any other set the markers themselves.

    A joint among several markers is missing where one of them is: the middle of the others would lie elsewhere.
    """
    times = np.arange(markers.frames) / markers.fps
    plain = {_last(name).upper(): k for k, name in enumerate(markers.names)}
    places = {
        joint: [plain[name] for name in names.split()]
        for joint, names in _MARKERS.items()
        if all(name in plain for name in names.split())
    }
    if len(places) < _FEWEST:
        return Postures(
            markers.names,
            markers.positions,
            times,
            source=markers.source,
            guesses=markers.guesses,
            warnings=markers.warnings,
        )
    middle = np.stack([markers.positions[:, rows].mean(axis=1) for rows in places.values()], axis=1)
    said = f"joints are taken from markers on the skin: {', '.join(places)}"
    return Postures(
        tuple(places),
        middle,
        times,
        source=markers.source,
        guesses=(*markers.guesses, said),
        warnings=markers.warnings,
    )


def joints_of_motion(motion: Motion) -> Postures:
    """The joints of a skeleton, by forward kinematics; those of an Acclaim skeleton by what they mean on a body."""
    places: Floats = positions(motion.skeleton, motion.q)
    names = motion.skeleton.names
    if {"lhumerus", "lfemur"} <= {name.lower() for name in names}:
        names = tuple(_BONES.get(name.lower(), name) or f"{name} bone" for name in names)
    return Postures(
        _distinct(names),
        places,
        np.arange(motion.frames) / motion.fps,
        source=motion.source,
        guesses=motion.guesses,
        warnings=motion.warnings,
    )


def _last(name: str) -> str:
    """A marker's name without the subject's in front."""
    return name.split(":")[-1].strip()


def _distinct(names: Sequence[str]) -> tuple[str, ...]:
    seen: dict[str, int] = {}
    found = []
    for name in names:
        seen[name] = seen.get(name, 0) + 1
        found.append(name if seen[name] == 1 else f"{name} {seen[name]}")
    return tuple(found)
