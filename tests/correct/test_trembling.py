"""Joints that a sensor sees worse than the others throughout: their mean is good."""

import numpy as np
import pytest
from sensed_people import NAMES, fitted, recording, sensed, truth

from motionmend.correct import CorrectorModel
from motionmend.correct.trembling import calmed


@pytest.fixture(scope="module")
def model() -> CorrectorModel:
    return fitted()


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.02, 0.04, 0.06])
@pytest.mark.parametrize("parts", [("Wrist", "Hand"), ("Ankle", "Foot")])
def test_joints_that_tremble_throughout_are_calmed_and_not_given_up(
    model: CorrectorModel, parts: tuple[str, str], noise: float
) -> None:
    true = truth("walk", 110, 4.0)
    given, joints = sensed(true, 110), [NAMES.index(f"{part}Right") for part in parts]
    given[:, joints] += noise * np.random.default_rng(7).normal(size=given[:, joints].shape)
    found = model.correct(recording(given, state=True))
    assert found.reliability is not None
    assert found.std is not None
    assert found.reliability[:, joints].mean() > 0.8
    off = np.abs(found.positions - true)[:, joints]
    assert np.linalg.norm(off, axis=2).mean() < 0.6 * np.linalg.norm(given - true, axis=2)[:, joints].mean()
    assert (off < found.std[:, joints, None]).mean() > 0.5


@pytest.mark.parametrize("seed", range(3))
def test_noise_is_known_and_motion_is_none(seed: int) -> None:
    """Of a person who runs only the joint with noise is changed; the variance that is said to be left is."""
    rng = np.random.default_rng(seed)
    clean = truth("run", 111 + seed, 4.0)
    given = clean + 0.001 * rng.normal(size=clean.shape)
    hand = NAMES.index("HandLeft")
    given[:, hand] += 0.03 * rng.normal(size=(len(given), 3))
    given[40:43, 2] = np.nan
    found = calmed(given, np.arange(len(given)) / 30.0)
    rest = np.arange(len(NAMES)) != hand
    np.testing.assert_array_equal(found.positions[:, rest], given[:, rest])
    assert not found.variance[rest].any()
    left = np.square(found.positions - clean)[:, hand].mean()
    assert left < 0.8 * np.square(given - clean)[:, hand].mean()
    assert 0.3 < found.variance[hand] / left < 1.5


def test_who_shakes_for_a_while_or_is_hardly_seen_is_left_as_it_is() -> None:
    given = truth("walk", 114, 4.0)
    hand, times = NAMES.index("HandLeft"), np.arange(len(given)) / 30.0
    given[20:, hand] += 0.05 * np.random.default_rng(0).normal(size=(len(given) - 20, 3))
    np.testing.assert_array_equal(calmed(given, times).positions, given)
    few = given[:20] + 0.05 * np.random.default_rng(0).normal(size=given[:20].shape)
    np.testing.assert_array_equal(calmed(few, times[:20]).positions, few)
    np.testing.assert_array_equal(calmed(np.full_like(few, np.nan), times[:20]).positions, np.full_like(few, np.nan))
