"""What a rigid fit of each pair's truth onto its reading takes away is no error to be learned."""

from dataclasses import replace

import numpy as np
import pytest
from sensed_people import NAMES, pair, recording, sensed, truth

from motionmend.arrays import Bools
from motionmend.bodies.postures import Postures
from motionmend.correct import Corrector, CorrectorModel
from motionmend.correct.pairs import match


def learned_by_fits(told: Bools, fitted: bool) -> CorrectorModel:
    """From pairs whose truth, of those joints alone, was brought to the sensor by a rigid motion."""
    pairs = [pair("reach", seed) for seed in range(3)]
    known = [one.truth.with_positions(np.where(told[:, None], one.truth.positions, np.nan)) for one in pairs]
    fits = [match(one.sensor, true, 0.0).pair for one, true in zip(pairs, known, strict=True)]
    assert all(one.fitted for one in fits)
    return Corrector(points=60).fit([replace(one, fitted=fitted) for one in fits])


@pytest.mark.slow
def test_what_a_rigid_fit_took_away_is_not_learned() -> None:
    raw = recording(sensed(truth("reach", 8), 8))
    fitted, free = (
        learned_by_fits(np.ones(20, dtype=np.bool_), fitted).correct(raw).positions for fitted in (True, False)
    )
    assert np.linalg.norm((fitted - raw.positions).mean(axis=(0, 1))) < 0.0003
    assert np.linalg.norm((free - raw.positions).mean(axis=(0, 1))) > 0.001
    assert np.linalg.norm(fitted - free, axis=2).max() < 0.03


@pytest.mark.slow
def test_nobody_is_turned_about_the_one_arm_that_was_paired() -> None:
    raw = recording(sensed(truth("reach", 8), 8))
    arm = np.array([name in ("ShoulderLeft", "ElbowLeft", "WristLeft", "HandLeft") for name in NAMES])
    fitted, free = (learned_by_fits(arm, fitted).correct(raw).positions for fitted in (True, False))
    assert np.linalg.norm(fitted - free, axis=2).max() < 0.03


@pytest.mark.slow
def test_a_room_left_empty_moves_nobody_who_was_in_it() -> None:
    """What takes a recording away as a whole is asked of the frames that somebody is in."""
    model = learned_by_fits(np.ones(20, dtype=np.bool_), fitted=True)
    raw = recording(sensed(truth("reach", 8), 8))
    empty = np.concatenate([raw.positions, np.full((600, *raw.positions.shape[1:]), np.nan)])
    left = Postures(raw.names, empty, np.arange(len(empty)) / 30.0)
    alone = model.correct(Postures(raw.names, raw.positions, left.times[: raw.frames]))
    before = model.correct(left).positions[: raw.frames]
    assert np.linalg.norm((before - alone.positions).mean(axis=(0, 1))) < 0.0003
