"""The performer's skeleton: names, proportions, axes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionmend.bodies.skeleton import forward, positions, rest_positions
from motionmend.errors import UsageError
from motionmend.samples import skeleton
from motionmend.samples.body import axes, build, rotation

DOFS = {
    "root": "tx ty tz rz ry rx",
    **dict.fromkeys(("lowerback", "upperback", "thorax", "lowerneck", "upperneck", "head"), "rz ry rx"),
    **{
        side + bone: dofs
        for side in "lr"
        for bone, dofs in {
            "femur": "rz ry rx",
            "tibia": "rx",
            "foot": "rz rx",
            "toes": "rx",
            "clavicle": "rz ry",
            "humerus": "rz ry rx",
            "radius": "rx",
            "wrist": "ry",
            "hand": "rz rx",
            "fingers": "rx",
            "thumb": "rz rx",
        }.items()
    },
}


def test_the_62_dofs_are_cmus_outermost_turn_first():
    body = skeleton()
    assert len(body.dof_names) == 62
    for joint, dofs in DOFS.items():
        rows = body.dofs_of(body.names.index(joint))
        assert [body.dof_names[row] for row in rows] == [f"{joint}.{dof}" for dof in dofs.split()]
    assert not body.dofs_of(body.names.index("lhipjoint")).size


@given(st.floats(1.0, 2.5))
def test_every_length_grows_with_stature_and_left_mirrors_right(height):
    body, one = skeleton(height), skeleton(1.0)
    np.testing.assert_allclose(body.offsets, height * one.offsets, atol=1e-12)
    rest = dict(zip(body.names, rest_positions(body), strict=True))
    for name, place in rest.items():
        if name[0] == "l" and not name.startswith("lower"):
            np.testing.assert_allclose(place * (-1, 1, 1), rest["r" + name[1:]], atol=1e-12)


def test_segments_are_winters_fractions_of_stature():
    body = skeleton(1.0)
    length = {n: np.linalg.norm(o) for n, o in zip(body.names, body.offsets, strict=True)}
    assert length["ltibia"] == pytest.approx(0.245)  # thigh
    assert length["rfoot"] == pytest.approx(0.246)  # shank
    assert length["lradius"] == pytest.approx(0.186)  # upper arm
    assert length["lwrist"] + length["lhand"] == pytest.approx(0.146)  # forearm
    b = build(1.0)
    assert b.standing - b.hip[1] * 0 + b.hip[1] == pytest.approx(0.530)  # hip over the floor
    assert b.heel + b.ball + b.toes == pytest.approx(0.152)  # foot


def test_standing_straight_the_performer_is_as_tall_as_winters():
    body = skeleton(1.75)
    q = np.zeros((1, 62))
    for side, tilt in (("l", -20.0), ("r", 20.0)):
        q[0, body.dof_names.index(f"{side}femur.rz")] = np.radians(tilt)
    at = dict(zip(body.names, positions(body, q)[0], strict=True))
    shoulder = at["lhumerus"][1] - at["ltoes"][1] + build(1.75).ball_height
    assert shoulder / 1.75 == pytest.approx(0.818, abs=0.005)
    assert at["ltoes"][0] == pytest.approx(at["lfemur"][0])  # the leg hangs straight down
    assert at["ltoes"][2] > at["lfoot"][2]  # and the foot points forward


def test_signs_are_cmus(rng):
    body = skeleton()
    rest = forward(body, np.zeros((1, 62)))[0][0]

    def moved(dof: str, joint: str) -> np.ndarray:
        q = np.zeros((1, 62))
        q[0, body.dof_names.index(dof)] = 0.5
        return positions(body, q)[0, body.names.index(joint)] - rest[body.names.index(joint)]

    assert moved("ltibia.rx", "lfoot")[2] < 0  # knees flex backward
    assert moved("lfemur.rx", "ltibia")[2] < 0  # thighs extend with positive angles
    assert moved("rfoot.rx", "rtoes")[1] < 0  # feet point down
    for side in "lr":
        assert moved(f"{side}radius.rx", f"{side}hand")[2] > 0  # elbows flex forward
        assert moved(f"{side}humerus.rz", f"{side}radius")[1] * (1 if side == "l" else -1) < 0


@given(st.tuples(*[st.floats(-180, 180)] * 3))
def test_axes_are_rotations_about_x_then_y_then_z(degrees):
    turned = axes(degrees)
    np.testing.assert_allclose(turned @ turned.T, np.eye(3), atol=1e-12)
    x, y, z = np.radians(degrees)
    np.testing.assert_allclose(turned, rotation(2, z) @ rotation(1, y) @ rotation(0, x))


@pytest.mark.parametrize("height", [0.5, 3.0, np.nan])
def test_a_stature_nobody_has_is_refused(height):
    with pytest.raises(UsageError, match="height"):
        skeleton(height)
