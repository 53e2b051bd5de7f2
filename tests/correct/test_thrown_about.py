"""A sensor that throws its joints about, now these and now those: each is put back, and who fails is left."""

import numpy as np
import pytest
from sensed_people import NAMES, fitted, recording, sensed, truth

from motionmend.correct.thrown_about import followed, put_back, unknown


def thrown(positions: np.ndarray, share: float, far: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Positions of which a share of the joints is so many m off in each frame, and which are."""
    rng = np.random.default_rng(seed)
    which, way = rng.random(positions.shape[:2]) < share, rng.normal(size=positions.shape)
    way *= far / np.linalg.norm(way, axis=2, keepdims=True)
    return positions + way * which[..., None], which


def off(positions: np.ndarray, true: np.ndarray) -> float:
    return float(np.linalg.norm(positions - true, axis=2).mean())


@pytest.mark.parametrize(("share", "far"), [(0.15, 0.1), (0.4, 0.1), (0.4, 0.2)])
def test_thrown_joints_are_told_and_put_back(share: float, far: float) -> None:
    true = truth("walk", 7, 3.0)
    given, which = thrown(true, share, far, 1)
    found = put_back(given, np.arange(len(given)) / 30.0)
    assert found.thrown[which].mean() > 0.8
    assert found.thrown[~which].mean() < 0.1
    assert off(found.positions, true) < 0.25 * off(given, true)
    assert 0.0 < found.deviation < 0.02


@pytest.mark.parametrize("action", ["walk", "run", "jump"])
def test_who_moves_or_fails_is_not_thrown(action: str) -> None:
    """Nor is white noise of all joints, or a sensor that throws joints for a third of a second."""
    true, rng = truth(action, 8, 3.0), np.random.default_rng(2)
    times = np.arange(len(true)) / 30.0
    arm = [NAMES.index(f"{part}Left") for part in ("Elbow", "Wrist", "Hand")]
    failing, bursts = true.copy(), true.copy()
    failing[30:60, arm] += 0.08 * rng.normal(size=(30, 3, 3))
    for first in range(0, len(true), 10):
        bursts[first : first + 10, rng.random(20) < 0.4] += 0.1 * rng.normal(size=3)
    for given in (true, failing, bursts, true + 0.005 * rng.normal(size=true.shape)):
        np.testing.assert_array_equal(put_back(given, times).positions, given)
    courses = unknown(20)
    for t, row in enumerate(failing):
        courses, believed = followed(courses, row, times[t])
        np.testing.assert_array_equal(believed.positions, row)


def test_a_limb_that_fails_is_left_as_it_came() -> None:
    """Its shaking tells of it."""
    true, rng = truth("reach", 9, 4.0), np.random.default_rng(3)
    given, which = thrown(true, 0.15, 0.1, 4)
    arm = [NAMES.index(f"{part}Left") for part in ("Elbow", "Wrist", "Hand")]
    given[40:70, arm] += 0.08 * rng.normal(size=(30, 3, 3))
    found = put_back(given, np.arange(len(given)) / 30.0).thrown
    assert found[45:65][:, arm].mean() < 0.1
    rest = np.setdiff1d(np.arange(20), arm)
    assert found[:, rest][which[:, rest]].mean() > 0.9


def test_live_thrown_joints_are_put_back_as_soon_as_they_are_known_to_be() -> None:
    true = truth("walk", 10, 3.0)
    given, which = thrown(true, 0.4, 0.2, 5)
    courses, positions, shares = unknown(20), [], []
    for t, row in enumerate(given):
        courses, believed = followed(courses, row, t / 30.0)
        positions.append(believed.positions)
        shares.append(believed.share)
    late = slice(15, None)
    assert off(np.array(positions)[late], true[late]) < 0.5 * off(given[late], true[late])
    assert np.array(shares)[late][which[late]].mean() < 0.3
    assert np.array(shares)[late][~which[late]].mean() > 0.8
    for k in range(2):  # who is elsewhere for good went there
        courses, believed = followed(courses, true[0] + 5.0, (len(given) + k) / 30.0)
    np.testing.assert_array_equal(believed.positions, true[0] + 5.0)


@pytest.mark.slow
@pytest.mark.parametrize(("look_ahead", "left"), [(None, 0.35), (0, 0.8)])
def test_sides_are_not_exchanged_and_joints_come_out_nearer(look_ahead: int | None, left: float) -> None:
    """Half of the frames had their sides exchanged, and live joints were twice as far off as they came."""
    for seed, action in enumerate(("walk", "reach", "jump")):
        true = truth(action, 80 + seed, 3.0)
        given, which = thrown(sensed(true, 80 + seed), 0.4, 0.2, seed)
        found = fitted().correct(recording(given), look_ahead=look_ahead)
        assert found.reliability is not None
        assert off(found.positions, true) < left * off(given, true)
        assert (found.source.flags & 2).astype(bool).mean() < 0.1
        assert found.reliability[20:][which[20:]].mean() < 0.3
