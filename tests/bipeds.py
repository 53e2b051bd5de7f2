"""A small person for tests of legs and feet, and one that walks without any skate."""

from collections.abc import Sequence

import numpy as np

from motionmend.bodies.ik import solve
from motionmend.bodies.motion import Motion
from motionmend.bodies.skeleton import ROTATION, TRANSLATION, Skeleton

LEG_NAMES = ("Hips", "{l}UpLeg", "{l}Leg", "{l}Foot", "{l}ToeBase", "{l}Toe_End")


def biped(
    names: Sequence[str] = ("LeftUpLeg", "LeftLeg", "LeftFoot", "LeftToeBase", "LeftToe_End"), *, up: int = 1
) -> Skeleton:
    """Root, two legs (left first, named after `names` with left turned into right), and one arm; `up` is the axis."""
    right = [_mirrored(name) for name in names]
    joints, parents, offsets = ["Hips"], [-1], [(0.0, 0.0, 0.0)]
    lengths = [(0.0, -0.42, 0.0), (0.0, -0.40, 0.0), (0.0, -0.07, 0.13), (0.0, -0.01, 0.06)]
    for side, own in ((0.1, names), (-0.1, right)):
        for index, name in enumerate(own):
            parents.append(0 if index == 0 else len(joints) - 1)
            offsets.append((side, -0.08, 0.0) if index == 0 else lengths[index - 1])
            joints.append(name)
    joints += ["Arm", "Arm_End"]
    parents += [0, len(joints) - 2]
    offsets += [(0.2, 0.5, 0.0), (0.5, 0.0, 0.0)]
    axes = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
    rows = [(0, axis, TRANSLATION, 10.0) for axis in "xyz"] + [(0, axis, ROTATION, 7.0) for axis in "zyx"]
    for leg in (1, 1 + len(names)):
        rows += [(leg, axis, ROTATION, 2.5) for axis in "zyx"] + [(leg + 1, "x", ROTATION, 2.6)]
        rows += [(leg + 2, axis, ROTATION, 1.2) for axis in "zx"] if len(names) > 3 else []
        rows += [(leg + 3, "x", ROTATION, 1.0)] if len(names) > 4 else []
    rows += [(len(joints) - 2, "z", ROTATION, 3.0)]
    turn = np.eye(3) if up == 1 else np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])  # y up to z up
    return Skeleton(
        names=tuple(joints),
        parents=np.array(parents),
        offsets=np.array(offsets) @ turn.T,
        dof_names=tuple(f"{joints[j]}.{'t' if kind else 'r'}{axis}" for j, axis, kind, _ in rows),
        dof_joint=np.array([row[0] for row in rows]),
        dof_axis=np.array([axes[row[1]] for row in rows]) @ turn.T,
        dof_kind=np.array([row[2] for row in rows], dtype=np.uint8),
        limits=np.array([(-row[3], row[3]) for row in rows]),
        up=turn @ np.array([0.0, 1.0, 0.0]),
    )


def steps(
    seconds: float, fps: float, *, stance: float = 0.6, swing: float = 0.4, stride: float = 1.2
) -> tuple[np.ndarray, np.ndarray]:
    """Ankle and toes of two walking feet (T, 4, 3) m, y up, z ahead, as `Feet.joints`; when they stand (T, 4)."""
    frames = round(seconds * fps)
    places, stands = np.zeros((frames, 4, 3)), np.zeros((frames, 4), dtype=bool)
    for side, late in ((0, 0.0), (1, (stance + swing) / 2)):
        time = np.arange(frames) / fps + late
        cycle, phase = np.divmod(time, stance + swing)
        u = np.clip((phase - stance) / swing, 0.0, 1.0)
        ahead = stride * (cycle + u - np.sin(2 * np.pi * u) / (2 * np.pi) - late / (stance + swing))
        rise = 0.12 * np.sin(np.pi * u) ** 2
        for point, (height, forward) in enumerate(((0.08, 0.0), (0.01, 0.13))):
            places[:, 2 * side + point] = np.stack(
                (np.full(frames, 0.1 - 0.2 * side), height + rise, ahead + forward), axis=1
            )
            stands[:, 2 * side + point] = u == 0.0
    return places, stands


def walk(seconds: float = 4.0, fps: float = 60.0, *, up: int = 1) -> tuple[Motion, np.ndarray]:
    """A biped that walks on feet that do not slide, and the true contacts (T, 4)."""
    body = biped(up=up)
    feet, stands = steps(seconds, fps)
    turn = np.eye(3) if up == 1 else np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    time = np.arange(len(feet)) / fps
    q = np.zeros((len(feet), len(body.dof_names)))
    q[:, 1] = 0.86 + 0.01 * np.cos(4 * np.pi * time)
    q[:, 2] = 1.2 * time - 0.36
    q[:, -1] = 0.3 * np.sin(time)
    for knee in ("LeftLeg.rx", "RightLeg.rx"):
        q[:, body.dof_names.index(knee)] = 0.4
    for hip in ("LeftUpLeg.rx", "RightUpLeg.rx"):
        q[:, body.dof_names.index(hip)] = -0.2
    legs = np.flatnonzero((np.arange(q.shape[1]) >= 6) & (np.arange(q.shape[1]) < q.shape[1] - 1))
    points = [body.names.index(name) for name in ("LeftFoot", "LeftToeBase", "RightFoot", "RightToeBase")]
    return Motion(body, solve(body, q, points, feet @ turn.T, movable=legs).q, fps), stands


def _mirrored(name: str) -> str:
    for left, right in (("Left", "Right"), ("left", "right"), ("_L", "_R"), ("L_", "R_"), ("l_", "r_")):
        if left in name:
            return name.replace(left, right)
    return {"l": "r", "L": "R"}.get(name[0], "other_") + name[1:]
