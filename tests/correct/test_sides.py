"""Sides, by the way knees bend and toes point."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.bodies.joint_sets import KINECT20
from motionmend.correct.anatomy import anatomy
from motionmend.correct.normalise import Standard, bone_lengths
from motionmend.correct.sides import about_turn, faces_away, gone_along, knees_ahead, toes_ahead, trunk_turned
from motionmend.numerics.factors import Factors

BODY = anatomy(KINECT20.names)


def standing(bent: float, toes: float = 0.1) -> np.ndarray:
    """(J, 3) m in standard form: upright, facing +z, left at +x; knees `bent` m ahead, feet `toes`."""
    posture = np.zeros((len(BODY.names), 3))
    for k, name in enumerate(BODY.names):
        side = 1.0 if "Left" in name else -1.0 if "Right" in name else 0.0
        height = {"Hip": 0.0, "Knee": -0.45, "Ankle": -0.9, "Foot": -0.95, "Spine": 0.2, "Head": 0.7}
        up = next((h for part, h in height.items() if part in name), 0.45)
        ahead = bent if "Knee" in name else toes if "Foot" in name else 0.0
        posture[k] = (0.15 * side, up, ahead)
    return posture


@given(st.floats(-0.3, 0.3), st.floats(-0.2, 0.2))
@settings(max_examples=20)
def test_knees_and_toes_lie_as_far_behind_when_all_sides_are_exchanged(bent: float, toes: float) -> None:
    postures = standing(bent, toes)[None].repeat(3, axis=0)
    np.testing.assert_allclose(toes_ahead(postures, BODY), toes, atol=1e-12)
    np.testing.assert_allclose(toes_ahead(about_turn(postures, BODY), BODY), -toes, atol=1e-12)
    np.testing.assert_allclose(knees_ahead(postures, BODY), bent, atol=1e-12)
    np.testing.assert_allclose(knees_ahead(about_turn(postures, BODY), BODY), -bent, atol=1e-12)
    postures[:] = np.nan
    assert knees_ahead(postures, BODY) == toes_ahead(postures, BODY) == 0.0


def test_however_strange_a_posture_knees_do_not_bend_backwards_nor_toes_point_there() -> None:
    """A model that was taught people who face the other way would turn anybody about, but for knees and toes."""
    for bent, toes, away in (
        (0.0, -0.1, True),
        (-0.2, 0.0, True),
        (0.2, -0.1, False),
        (0.0, 0.1, False),
        (-0.2, 0.1, False),
    ):
        postures = standing(bent, toes)[None]
        taught = about_turn(postures, BODY)[0]
        factors = Factors(taught, np.zeros((len(taught), 3, 1)), np.ones(1), np.full(len(taught), 1e-4))
        usual = Standard(bone_lengths(taught[None], BODY)[0], taught)
        assert faces_away(factors, usual, BODY, postures) is away


@given(st.floats(-0.3, 0.3), st.floats(-0.2, 0.2), st.sampled_from(["Left", "Right"]))
@settings(max_examples=20)
def test_one_leg_that_is_seen_tells_as_much_as_two(bent: float, toes: float, lost: str) -> None:
    postures = standing(bent, toes)[None].repeat(3, axis=0)
    postures[:, [k for k, name in enumerate(BODY.names) if lost in name]] = np.nan
    np.testing.assert_allclose(toes_ahead(postures, BODY), toes, atol=1e-12)
    np.testing.assert_allclose(knees_ahead(postures, BODY), bent, atol=1e-12)


def test_without_legs_many_frames_say_no_more_than_one() -> None:
    """Who leans, or holds the arms back, does so in all of them; legs that look that way may be believed."""

    def enough(least: float, *, legs: bool) -> float:
        """The lean, m, from which on somebody is taken to face away."""
        for lean in np.linspace(0.0, 0.5, 200):
            posture = standing(0.0, -0.01)
            posture[BODY.names.index("Head"), 2] -= lean
            taught = about_turn(posture[None], BODY)[0]
            factors = Factors(taught, np.zeros((len(taught), 3, 1)), np.ones(1), np.full(len(taught), 1e-3))
            usual = Standard(bone_lengths(taught[None], BODY)[0], taught)
            if not legs:
                posture[np.append(BODY.legs[:, 1:], BODY.feet)] = np.nan
            if faces_away(factors, usual, BODY, posture[None].repeat(5, axis=0), least):
                return float(lean)
        return np.inf

    assert enough(1.5, legs=True) < enough(3.0, legs=True) < 0.5
    assert enough(1.5, legs=False) == enough(3.0, legs=False) < 0.5


@given(st.integers(0, 100), st.booleans())
@settings(max_examples=30)
def test_limbs_that_change_places_with_the_trunk_are_those_that_jump(seed: int, otherwise: bool) -> None:
    """Legs that stand together too: a frame's step is less than what lies between them."""
    rng = np.random.default_rng(seed)
    last = standing(0.05) * [0.4, 1.0, 1.0]
    limbs = np.setdiff1d(BODY.pairs[rng.random(len(BODY.pairs)) < 0.5], BODY.across)
    rows = last + rng.normal(0.0, 0.01, last.shape)
    rows[limbs] = rows[BODY.mirror[limbs]]
    told = np.full(len(rows), otherwise)
    missing = BODY.names.index("HandLeft")
    rows[missing] = np.nan
    found = gone_along(rows, last, told, BODY)
    known = np.setdiff1d(BODY.pairs, [*BODY.across.ravel(), missing, BODY.mirror[missing]])
    np.testing.assert_array_equal(np.flatnonzero(found[known]), np.flatnonzero(np.isin(known, limbs)))
    assert (found[BODY.across] == otherwise).all()
    assert (found[[missing, BODY.mirror[missing]]] == otherwise).all()


def test_where_all_joints_shake_a_thrown_joint_turns_no_pair_about() -> None:
    """An exchanged pair is as long as it was; one joint that is thrown past the other leaves it elsewhere."""
    last = standing(0.05)
    facing = (last[BODY.across[0, 0]] - last[BODY.across[0, 1]])[[0, 2]]
    exchanged, wrong = last[BODY.mirror] + 0.02, last.copy()
    wrong[BODY.across[0, 0]] += [-0.45, 0.25, 0.1]
    for shaking in (0.0, 0.03):
        assert trunk_turned(exchanged, last, facing, 0.03, BODY, shaking).all()
        assert not trunk_turned(last, last, facing, 0.03, BODY, shaking).any()
        assert trunk_turned(wrong, last, facing, 0.03, BODY, shaking)[0] == (shaking == 0.0)
