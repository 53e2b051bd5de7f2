"""Real people before a real sensor: strangers come out nearer to the truth, and failing limbs are mended."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from motionmend.arrays import Bools, Floats
from motionmend.bodies.postures import Postures
from motionmend.correct import Corrector, CorrectorModel, Pair
from motionmend.correct.pairs import match
from motionmend.evaluate.sensor_failures import fail
from motionmend.io.sensor import read_postures
from motionmend.io.truth import read_truth

LEARNED = ("m01_s04", "m05_s04", "m07_s05", "m01_s05", "m04_s05", "m05_s06", "m09_s06", "m07_s04")
TESTED = ("m01_s03", "m05_s03", "m07_s03")
LIMBS = ("LForearm", "LHand"), ("RLowerLeg", "RFoot", "RToes")


@cache
def paired(folder: Path, stems: tuple[str, ...]) -> list[Pair]:
    found = []
    for stem in stems:
        for name in sorted((folder / "Kinect" / "Positions").glob(f"{stem}_e*_positions.txt.gz"))[:1]:
            one = match(read_postures(name), read_truth(folder / "Vicon" / "Positions" / name.name))
            found.append(one.pair)
    return found


@pytest.fixture(scope="module")
def folder(data: Path) -> Path:
    """The paired recordings."""
    found = data / "kinect" / "uiprmd"
    if not found.is_dir():
        pytest.skip("no paired recordings of a sensor among the data")
    return found


@pytest.fixture(scope="module")
def model(folder: Path) -> CorrectorModel:
    return Corrector(points=150).fit(paired(folder, LEARNED))


@pytest.mark.slow
def test_people_not_learned_from_come_out_nearer_to_the_truth(model: CorrectorModel, folder: Path) -> None:
    tested = paired(folder, TESTED)
    assert len(tested) == len(TESTED)
    for one in tested:
        known = np.isfinite(one.truth.positions).all(axis=2)

        def error(positions, one=one, known=known):  # type: ignore[no-untyped-def]
            return np.linalg.norm(positions - one.truth.positions, axis=2)[known].mean()

        assert error(model.correct(one.sensor).positions) < 0.8 * error(one.sensor.positions)


@pytest.mark.slow
def test_failing_limbs_of_real_people_are_mended(model: CorrectorModel, folder: Path) -> None:
    before, after = [], []
    for seed, one in enumerate(paired(folder, TESTED)):
        failed = fail(one.sensor, seed=seed)
        there = failed.affected & np.isfinite(one.truth.positions).all(axis=2)
        corrected = model.correct(failed.postures)
        before.append(np.linalg.norm(failed.postures.positions - one.truth.positions, axis=2)[there])
        after.append(np.linalg.norm(corrected.positions - one.truth.positions, axis=2)[there])
    assert np.concatenate(after).mean() < 0.7 * np.concatenate(before).mean()


@pytest.mark.slow
def test_a_limb_that_fails_calmly_from_the_first_frame_is_nobodys(model: CorrectorModel, folder: Path) -> None:
    """It neither shakes nor jumps, and no frame before tells how long the person's own are."""
    before, after, live = [], [], []
    for seed, one in enumerate(paired(folder, TESTED)):
        failed = fail(one.sensor, seed=seed, seconds=(2.0, 4.0), jitter=(0.0, 0.01), swaps=0.0)
        start = int(np.flatnonzero(failed.affected.any(axis=1))[0]) + 2
        cut = replace(
            failed.postures,
            positions=failed.postures.positions[start:],
            times=failed.postures.times[start:],
            state=None,
        )
        truth = one.truth.positions[start:]
        there = failed.affected[start:] & np.isfinite(truth).all(axis=2)
        for kept, positions in (
            (before, cut.positions),
            (after, model.correct(cut).positions),
            (live, model.correct(cut, look_ahead=0).positions),
        ):
            kept.append(np.linalg.norm(positions - truth, axis=2)[there])
    raw, mended, at_once = (np.concatenate(each).mean() for each in (before, after, live))
    assert mended < 0.75 * raw
    assert at_once < 0.75 * raw


def drawn_in(sensor: Postures, limb: tuple[str, ...], share: float = 0.9) -> tuple[Postures, Bools]:
    """A limb drawn to the trunk within 0.8 s, kept there for a second, and given back; where that is 15 cm."""
    joints = [sensor.names.index(name) for name in limb]
    middle = sensor.positions[:, [sensor.names.index(name) for name in ("Waist", "Spine", "Chest")]].mean(axis=1)
    rise = np.clip((sensor.times - sensor.times[0] - 0.8) / 0.8, 0.0, 1.0)
    fall = np.clip((sensor.times[0] + 3.4 - sensor.times) / 0.8, 0.0, 1.0)
    way = share * np.minimum(rise**2 * (3.0 - 2.0 * rise), fall**2 * (3.0 - 2.0 * fall))[:, None, None]
    positions: Floats = np.array(sensor.positions)
    positions[:, joints] += way * (middle[:, None] - positions[:, joints])
    off = np.linalg.norm(positions - sensor.positions, axis=2) > 0.15
    return replace(sensor, positions=positions, state=None), np.asarray(off)


@pytest.mark.slow
@pytest.mark.parametrize("ahead", [None, 0])
def test_limbs_that_are_drawn_in_slowly_are_mended(model: CorrectorModel, folder: Path, ahead: int | None) -> None:
    before, after = [], []
    for one in paired(folder, TESTED):
        for limb in LIMBS:
            spoilt, off = drawn_in(one.sensor, limb)
            there = off & np.isfinite(one.truth.positions).all(axis=2)
            found = model.correct(spoilt, look_ahead=ahead).positions
            before.append(np.linalg.norm(spoilt.positions - one.truth.positions, axis=2)[there])
            after.append(np.linalg.norm(found - one.truth.positions, axis=2)[there])
    assert np.concatenate(after).mean() < 0.35 * np.concatenate(before).mean()
