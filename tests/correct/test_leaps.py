"""Joints that leap away from where they were well, and back."""

import numpy as np
import pytest
from sensed_people import NAMES, fitted, recording, sensed, truth

from motionmend.arrays import Floats, Ints
from motionmend.bodies.joint_sets import mirrored
from motionmend.correct import CorrectorModel
from motionmend.correct.leaps import leaps_again

MIRROR: Ints = mirrored(NAMES)


@pytest.fixture(scope="module")
def model() -> CorrectorModel:
    return fitted()


def limb(*parts: str) -> list[int]:
    return [NAMES.index(f"{part}Right") for part in parts]


def spoilt(given: Floats, how: str, joints: list[int], spell: slice, seed: int) -> Floats:
    """A limb on its other side's, drawn to the trunk, or missing; what is somewhere shakes a little."""
    found, rng = given.copy(), np.random.default_rng(seed)
    shape = found[spell][:, joints].shape
    if how == "slipped":
        found[spell, joints] = given[spell][:, MIRROR[joints]] + 0.01 * rng.normal(size=shape)
    elif how == "drawn":
        found[spell, joints] = given[spell][:, [NAMES.index("Spine")]] + 0.02 * rng.normal(size=shape)
    else:
        found[spell, joints] = np.nan
    return found


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("how", ["slipped", "drawn"])
@pytest.mark.parametrize("ahead", [None, 0])
def test_a_limb_that_leapt_away_is_as_good_and_as_unsure_as_a_missing_one(
    model: CorrectorModel, ahead: int | None, how: str, seed: int
) -> None:
    true = truth("reach", 100 + seed, 4.0)
    given, arm, spell = sensed(true, seed), limb("Elbow", "Wrist", "Hand"), slice(45, 80)
    far, std = {}, {}
    for kind in (how, "missing"):
        found = model.correct(recording(spoilt(given, kind, arm, spell, seed)), look_ahead=ahead)
        assert found.std is not None
        far[kind] = np.linalg.norm(found.positions - true, axis=2)[spell][:, arm].mean()
        std[kind] = found.std[spell][:, arm].mean()
    assert far[how] < 1.3 * far["missing"] + 0.01
    assert std[how] > 0.7 * std["missing"]


def test_a_limb_on_its_other_side_is_not_believed_as_long_as_it_is_there(model: CorrectorModel) -> None:
    """Also where the recording ends."""
    given, leg = sensed(truth("walk", 103, 3.0), 3), limb("Knee", "Ankle", "Foot")
    spoiled = spoilt(given, "slipped", leg, slice(50, None), 3)
    found = model.correct(recording(spoiled)).reliability
    assert found is not None
    assert found[52:, leg].mean() < 0.1
    assert found[:50].mean() > 0.95


def test_who_leaps_again_is_told_within_seconds() -> None:
    times = np.arange(240) / 30.0
    rows = np.zeros((240, len(NAMES), 3)) + np.arange(len(NAMES))[:, None]
    rows += 0.001 * np.sin(times)[:, None, None]
    (hand,) = limb("Hand")
    rows[20:40, hand] += 0.5
    rows[40:, hand] += 0.1
    found = leaps_again(rows, times, MIRROR)
    assert found[20, hand]  # 40 follows
    assert not found[40:, hand].any()
    assert not np.delete(found, hand, axis=1).any()
    slow = np.repeat(rows[::3], 3, axis=0)  # 0.35 m are no leap where a posture takes three frames
    slow[:, hand] = np.repeat(0.2 * np.arange(80), 3)[:, None]
    assert not leaps_again(slow, times, MIRROR).any()
    rows[40:220, hand] += 0.4
    assert not leaps_again(rows, times, MIRROR)[20, hand]  # 220 is too late
