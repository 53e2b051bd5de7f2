"""A sensor that looks up, down or aside corrects as a level one does; who bends, sits or leans is not levelled."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from sensed_people import NAMES, error, fitted, recording, sensed, truth

from motionmend.arrays import Floats
from motionmend.bodies.postures import Postures
from motionmend.correct import CorrectorModel
from motionmend.correct.anatomy import anatomy
from motionmend.correct.level import TOLD, level, standing, tilted

BODY = anatomy(NAMES)
TILTS = [("x", 27.0), ("x", -30.0), ("z", 25.0)]


@pytest.fixture(scope="module")
def model() -> CorrectorModel:
    return fitted()


def turned(axis: str, degrees: float) -> Floats:
    return np.asarray(Rotation.from_euler(axis, degrees, degrees=True).as_matrix())


def stands(frames: int) -> Floats:
    """(T, 20, 3) m: who stands, and sways a little."""
    whole = truth("jump", 31, 3.0)
    first = next(one for one in whole if len(standing(one[None], BODY)))
    sway = 0.01 * np.sin(np.arange(frames) / 5)[:, None, None] * np.random.default_rng(0).normal(size=first.shape)
    return np.asarray(first + sway)


def live(model: CorrectorModel, raw: Postures) -> tuple[Floats, int]:
    """Positions, and in how many frames sides were changed back."""
    state = model.start(raw.names)
    found, swapped = [], 0
    for t in range(raw.frames):
        state, one = model.step(state, raw.positions[t], None, float(raw.times[t]))
        found.append(one.positions)
        swapped += "swapped" in one.flags
    return np.stack(found), swapped


@cache
def as_a_level_one(action: str, seed: int) -> Postures:
    return fitted().correct(recording(sensed(truth(action, seed, 3.0), seed)))


@pytest.mark.slow
@pytest.mark.parametrize(("axis", "degrees"), TILTS)
@pytest.mark.parametrize(("action", "seed"), [("jump", 31), ("jump", 32)])
def test_a_tilted_sensor_is_corrected_as_a_level_one(
    model: CorrectorModel, action: str, seed: int, axis: str, degrees: float
) -> None:
    true, turn = truth(action, seed, 3.0), turned(axis, degrees)
    raw = recording(sensed(true, seed))
    aslant = raw.with_positions(raw.positions @ turn.T)
    found = model.correct(aslant)
    back = found.with_positions(found.positions @ turn)
    wanted = as_a_level_one(action, seed)
    assert error(back, true) < 1.05 * error(wanted, true) + 0.001
    assert any("tilted" in one and "°" in one for one in found.source.warnings)
    assert not any("tilted" in one for one in wanted.source.warnings)
    came, swapped = live(model, aslant)
    half = len(true) // 2  # by then somebody has stood
    assert np.linalg.norm(came @ turn - true, axis=2)[half:].mean() < 0.5 * error(raw, true)
    assert swapped == 0


@pytest.mark.slow
@given(st.floats(20.0, 40.0), st.floats(0.0, 360.0), st.floats(0.0, 360.0))
@settings(max_examples=30, deadline=None)
def test_who_stands_comes_out_upright_however_the_sensor_is_tilted(by: float, way: float, heading: float) -> None:
    axis = np.array([np.cos(np.radians(way)), 0.0, np.sin(np.radians(way))])
    tilt = Rotation.from_rotvec(np.radians(by) * axis).as_matrix()
    there = stands(30) @ turned("y", heading).T
    turn = level(there @ tilt.T, BODY)
    axes = standing(there @ tilt.T @ turn.T, BODY)
    assert len(axes) >= TOLD
    np.testing.assert_allclose(np.median(axes, axis=0), [0.0, 1.0, 0.0], atol=0.02)
    assert abs(tilted(turn) - by) < 6.0
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)


def bent(trunk: float, knees: float) -> Floats:
    """(30, 20, 3) of who stands, the trunk leant ahead from the hips and the knees bent, in degrees."""
    there = stands(30)
    at = {name: k for k, name in enumerate(NAMES)}
    hips = there[:, [at["HipLeft"], at["HipRight"]]].mean(axis=1, keepdims=True)
    legs = [k for name, k in at.items() if any(part in name for part in ("Hip", "Knee", "Ankle", "Foot"))]
    above = [k for k in range(len(NAMES)) if k not in legs]
    there[:, above] = hips + (there[:, above] - hips) @ turned("x", trunk).T
    for side in ("Left", "Right"):
        knee = there[:, [at[f"Knee{side}"]]]
        lower = [at[f"Ankle{side}"], at[f"Foot{side}"]]
        there[:, lower] = knee + (there[:, lower] - knee) @ turned("x", knees).T
    return there


@pytest.mark.parametrize(("trunk", "knees"), [(30.0, 0.0), (60.0, 0.0), (0.0, 60.0), (40.0, 90.0)])
def test_who_bends_or_sits_is_not_levelled(trunk: float, knees: float) -> None:
    there = bent(trunk, knees)
    assert len(standing(there, BODY)) == 0
    assert tilted(level(there, BODY)) < 1e-9


def test_a_moment_of_leaning_among_standing_is_no_tilt() -> None:
    there = stands(40)
    there[:8] = there[:8] @ turned("x", 20.0).T
    assert tilted(level(there, BODY)) < 1e-9


@pytest.mark.parametrize("ahead", [0, 3])
def test_a_look_ahead_goes_over_the_frame_that_levels(model: CorrectorModel, ahead: int) -> None:
    true, turn = truth("jump", 31, 3.0), turned("x", 27.0)
    raw = recording(sensed(true, 31))
    found = model.correct(raw.with_positions(raw.positions @ turn.T), look_ahead=ahead)
    off = np.linalg.norm(found.positions @ turn - true, axis=2)
    assert off.max() < 0.12
    assert off[len(off) // 2 :].mean() < 0.5 * error(raw, true)
    assert any("tilted" in one for one in found.source.warnings)


def test_exchanged_legs_stand_as_straight() -> None:
    there = stands(30) @ turned("x", 27.0).T
    lower = [NAMES.index(f"{part}{side}") for part in ("Knee", "Ankle", "Foot") for side in ("Left", "Right")]
    other = [NAMES.index(f"{part}{side}") for part in ("Knee", "Ankle", "Foot") for side in ("Right", "Left")]
    exchanged = there.copy()
    exchanged[:, lower] = there[:, other]
    np.testing.assert_allclose(level(exchanged, BODY), level(there, BODY), atol=1e-12)
    assert tilted(level(exchanged, BODY)) > 20.0
