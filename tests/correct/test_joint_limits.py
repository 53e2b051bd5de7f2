"""Limbs bend as far as the truth has shown, and no bone changes its length."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from sensed_people import fitted, recording, sensed, truth

from motionmend.arrays import Floats
from motionmend.correct import CorrectorModel
from motionmend.correct.joining import joined
from motionmend.correct.limits import BELIEVED, MARGIN, Hinges, bends
from motionmend.evaluate.sensor_failures import fail

BONES = np.array([(0, 1), (1, 2), (2, 3), (1, 4), (4, 5)])
CHAINS = np.array([(0, 1, 2), (1, 2, 3), (0, 1, 4), (1, 4, 5)])
BELOW = np.array([[k in below for k in range(6)] for below in ({2, 3}, {3}, {4, 5}, {5})])


def lengths(positions: Floats) -> Floats:
    return np.asarray(np.linalg.norm(positions[..., BONES[:, 1], :] - positions[..., BONES[:, 0], :], axis=-1))


def naive(posture: Floats, trust: Floats, hinges: Hinges) -> Floats:
    """One posture, by rotations."""
    bent = posture.copy()
    for (p, j, c), (least, most), below in zip(hinges.joints, hinges.limits, hinges.below, strict=True):
        u, v = bent[p] - bent[j], bent[c] - bent[j]
        angle = np.arccos(np.clip(u @ v / np.linalg.norm(u) / np.linalg.norm(v), -1, 1))
        beyond = angle - np.clip(angle, least, most)
        stays = np.clip((trust[[p, j, c]].min() - BELIEVED) / (1 - BELIEVED), 0, 1)
        axis = np.cross(u, v) / np.linalg.norm(np.cross(u, v))
        turn = Rotation.from_rotvec(-(1 - stays) * beyond * axis)
        bent[below] = bent[j] + turn.apply(bent[below] - bent[j])
    return bent


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000), st.floats(0.2, 1.4), st.floats(1.6, 3.0))
def test_limbs_are_bent_back_and_keep_their_lengths(seed: int, least: float, most: float) -> None:
    rng = np.random.default_rng(seed)
    positions, trust = rng.normal(size=(3, 6, 3)), rng.uniform(0, 1, (3, 6))
    hinges = Hinges(CHAINS, np.tile([least, most], (4, 1)), BELOW)
    kept = hinges.kept(positions, trust)
    np.testing.assert_allclose(lengths(kept), lengths(positions), rtol=1e-9)
    for row, sure, found in zip(positions, trust, kept, strict=True):
        np.testing.assert_allclose(found, naive(row, sure, hinges), atol=1e-7)
    np.testing.assert_allclose(hinges.kept(positions, np.ones((3, 6))), positions, atol=1e-12)
    angles = bends(hinges.kept(positions, np.full((3, 6), BELIEVED)), CHAINS)
    assert (angles > least - 1e-6).all()
    assert (angles < most + 1e-6).all()


def test_straight_and_missing_limbs() -> None:
    straight = np.array([[[0.0, 0, 0], [0, 1, 0], [0, 2, 0], [0, 3, 0], [np.nan] * 3, [1, 1, 1]]])
    hinges = Hinges(CHAINS, np.tile([0.2, 2.5], (4, 1)), BELOW)
    kept = hinges.kept(straight, np.zeros((1, 6)))
    assert bends(kept, CHAINS[:2]) == pytest.approx(2.5)
    np.testing.assert_array_equal(kept[0, 4:], straight[0, 4:])


@pytest.fixture(scope="module")
def model() -> CorrectorModel:
    return fitted()


@pytest.mark.slow
@pytest.mark.parametrize("look_ahead", [0, None])
def test_nothing_bends_beyond_what_all_truth_keeps_unless_the_sensor_is_sure(
    model: CorrectorModel, look_ahead: int | None
) -> None:
    hinges = model.knowledge.hinges(joined(model.names, model.watcher.body))
    assert len(hinges.joints) > 8
    looked_at = 0
    for seed, action in enumerate(("walk", "reach", "jump")):
        true = truth(action, seed)
        inside = bends(true, hinges.joints)  # those it was learned from
        assert (inside > hinges.limits[:, 0] - 0.5 * MARGIN).all()
        assert (inside < hinges.limits[:, 1] + 0.5 * MARGIN).all()
        failed = fail(recording(sensed(true, seed + 5), state=True), seed=seed, share=0.6).postures
        found = model.correct(failed, look_ahead=look_ahead)
        assert found.reliability is not None
        unsure = found.reliability[:, hinges.joints].min(axis=2) <= BELIEVED
        looked_at += int(unsure.sum())
        angles = bends(found.positions, hinges.joints)
        assert (angles > hinges.limits[:, 0] - 1e-6)[unsure].all()
        assert (angles < hinges.limits[:, 1] + 1e-6)[unsure].all()
    assert looked_at > 50
