"""Closed-form legs and arms, checked by forward kinematics."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.bodies.skeleton import forward, positions
from motionmend.samples import skeleton
from motionmend.samples.arms import Arms, arm_angles, shoulder, stretched
from motionmend.samples.body import build, rotation
from motionmend.samples.legs import Feet, ankle_over, leg_angles, roll

BODY, B = skeleton(1.75), build(1.75)
NAMES = list(BODY.names)
ANGLE = st.floats(-0.3, 0.3)


def pose(angles: dict[str, np.ndarray], frames: int) -> np.ndarray:
    q = np.zeros((frames, len(BODY.dof_names)))
    for name, values in angles.items():
        q[:, BODY.dof_names.index(name)] = values
    return q


@settings(max_examples=40)
@given(
    st.tuples(*[st.floats(-0.1, 0.1)] * 2),
    st.floats(0.70, 0.90),
    st.tuples(ANGLE, ANGLE, ANGLE),
    st.floats(-0.9, 0.3),
    ANGLE,
)
def test_standing_feet_are_where_they_should_be(level, height, turns, pitch, heading):
    frames = 20
    root = np.tile([level[0], height, level[1]], (frames, 1))
    rz, ry, rx = (np.full(frames, v) for v in turns)
    turned = rotation(2, rz) @ rotation(1, ry) @ rotation(0, rx)
    place = [np.tile([side * 0.09, 0.0, 0.0], (frames, 1)) for side in (1, -1)]
    facing, pitched = np.full(frames, heading), np.full(frames, pitch)
    ankles = np.stack([ankle_over(B, p, facing, pitched) for p in place], axis=1)

    def both(values: np.ndarray) -> np.ndarray:
        return np.stack([values, values], axis=1)

    feet = Feet(
        ankles,
        both(facing),
        both(pitched),
        both(roll(B, pitched)[2]),
        np.ones((frames, 2), dtype=bool),
        np.zeros((frames, 2, 2)),
    )
    q = pose(leg_angles(B, root, turned, feet), frames)
    q[:, :6] = np.column_stack([root, rz, ry, rx])
    at = positions(BODY, q)
    for side, s in enumerate("lr"):
        np.testing.assert_allclose(at[:, NAMES.index(f"{s}foot")], ankles[:, side], atol=1e-6)
        bone = at[0, NAMES.index(f"{s}toes")] - at[0, NAMES.index(f"{s}foot")]
        assert np.arctan2(bone[0], bone[2]) == pytest.approx(heading, abs=1e-6)
        flat = np.arctan2(B.ankle_height - B.ball_height, B.ball)
        assert np.arcsin(bone[1] / np.linalg.norm(bone)) == pytest.approx(pitch - flat, abs=1e-6)


@given(st.floats(-1.2, 0.5))
def test_a_rolling_foot_stands_on_heel_ball_or_toes(pitch):
    forward_, up, bend = roll(B, np.array(pitch))
    c, s = np.cos(pitch), np.sin(pitch)
    ankle = np.array([forward_, B.ankle_height + up])
    heel = ankle + np.array([-B.heel * c + B.ankle_height * s, -B.heel * s - B.ankle_height * c])
    above = B.ankle_height - B.ball_height
    ball = ankle + np.array([B.ball * c + above * s, B.ball * s - above * c])
    tip = ball + B.toes * np.array([np.cos(pitch + bend), np.sin(pitch + bend)])
    if pitch > np.radians(10):
        np.testing.assert_allclose(heel, [-B.heel, 0.0], atol=1e-9)
    elif pitch < np.radians(-10):
        assert tip[1] == pytest.approx(B.ball_height, abs=1e-9)
        np.testing.assert_allclose(tip[0], B.ball + B.toes, atol=1e-9)
    else:
        assert abs(heel[1] if pitch > 0 else ball[1] - B.ball_height) < 0.005
    assert 0 <= bend < np.radians(45)


@settings(max_examples=40)
@given(
    st.sampled_from([0, 1]),
    st.floats(0.15, 0.55),
    st.floats(-1.2, 1.2),
    st.floats(-1.2, 1.0),
    st.tuples(st.floats(-0.2, 0.2), st.floats(-0.1, 0.3)),
)
def test_a_stretched_arm_brings_the_wrist_there(side, distance, azimuth, elevation, girdle):
    to = distance * np.array(
        [[np.sin(azimuth) * np.cos(elevation), np.sin(elevation), np.cos(azimuth) * np.cos(elevation)]]
    )
    upper, fold, elbow = stretched(B, side, to)
    clavicle = np.zeros((1, 2, 2))
    clavicle[:, side] = girdle

    def of_both(values: np.ndarray, idle: list[float]) -> np.ndarray:
        pair = np.tile(np.array(idle), (1, 2, 1)).reshape(1, 2, -1).astype(float)
        pair[:, side] = values
        return pair

    arms = Arms(
        of_both(upper, [0, -1, 0]),
        of_both(fold, [0, 0, 1]),
        of_both(elbow[:, None], [0.3])[:, :, 0],
        clavicle,
        np.zeros((1, 2)),
        np.zeros((1, 2)),
    )
    at, _ = forward(BODY, pose(arm_angles(arms), 1))
    s = "lr"[side]
    thorax = at[0, NAMES.index(f"{s}clavicle")]
    joint = at[0, NAMES.index(f"{s}humerus")]
    np.testing.assert_allclose(joint - thorax, shoulder(B, side, np.array([girdle]))[0], atol=1e-9)
    reach = np.linalg.norm(at[0, NAMES.index(f"{s}hand")] - joint)
    np.testing.assert_allclose((at[0, NAMES.index(f"{s}hand")] - joint) / reach, to[0] / distance, atol=1e-6)
    # Up to an elbow flexed by 40 degrees the wrist arrives; beyond, it stops short rather than lock the elbow.
    if distance < 0.93 * (B.upper_arm + B.forearm):
        assert reach == pytest.approx(distance, abs=1e-6)
    assert np.degrees(elbow[0]) >= 8.0 - 1e-6
