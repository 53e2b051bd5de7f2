"""What was not shown: movements, restless sensors, somebody else."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from sensed_people import error, fitted, pair, recording, sensed, truth

from motionmend.arrays import Floats
from motionmend.bodies.joint_sets import KINECT25, TRACKER16, correspondence, mirrored
from motionmend.bodies.postures import Postures
from motionmend.correct import Corrector, CorrectorModel, Pair
from motionmend.evaluate.sensor_failures import fail


@pytest.fixture(scope="module")
def model() -> CorrectorModel:
    return fitted()


def live(model: CorrectorModel, frames: Floats, times: Floats) -> Floats:
    state = model.start(model.names)
    found = []
    for t, frame in zip(times, frames, strict=True):
        state, one = model.step(state, frame, None, float(t))
        found.append(one.positions)
    return np.stack(found)


@pytest.mark.slow
@pytest.mark.parametrize("taught", ["walk", "reach"])
@pytest.mark.parametrize("count", [1, 3])
def test_who_was_taught_one_movement_makes_no_other_worse(taught: str, count: int) -> None:
    """Three repetitions all alike say no more of other movements than one does."""
    little = Corrector(points=100).fit([pair(taught, seed, 1.5) for seed in range(count)])
    for action in ("walk", "reach", "jump"):
        true = truth(action, 40)
        raw = recording(sensed(true, 40))
        assert error(little.correct(raw), true) < error(raw, true)


@cache
def calm() -> CorrectorModel:
    return Corrector(points=100).fit([pair(action, one) for one in range(6) for action in ("walk", "reach")])


@pytest.mark.slow
@pytest.mark.parametrize("seed", [40, 41])
def test_limbs_that_go_quickly_where_none_was_taught_are_not_thrown_away(seed: int) -> None:
    """A library without lively motions is no reason to doubt what a sensor sees going well."""
    true = truth("jump", seed, 3.0)
    raw = recording(sensed(true, seed))
    assert error(calm().correct(raw), true) < error(raw, true)


@pytest.mark.slow
def test_limbs_of_a_restless_sensor_are_found_failing_too() -> None:
    """Bones and jerk that are usual there hide what would be evidence elsewhere."""
    noise, names = 0.02, ("walk", "reach", "jump", "run")
    pairs = []
    for seed in range(2):
        for action in names:
            true = truth(action, seed)
            pairs.append(Pair(recording(sensed(true, seed, noise)), recording(true)))
    restless = Corrector(points=100).fit(pairs)
    raw, found = [], []
    for seed, action in enumerate(names):
        true = truth(action, 50, 3.0)
        failed = fail(recording(sensed(true, 50, noise)), seed=seed, swaps=0.0, states=False)
        for kept, postures in ((raw, failed.postures), (found, restless.correct(failed.postures))):
            kept.append(np.linalg.norm(postures.positions - true, axis=2)[failed.affected].mean())
    assert np.mean(found) < 0.55 * np.mean(raw)


@cache
def two_strangers() -> tuple[tuple[Floats, Floats], list[Floats], Floats, Floats]:
    """Two people, what comes of each alone, and live of the second and, looking ahead, of the first."""
    first, second = (sensed(truth(action, 60, 2.0), 60) for action in ("walk", "reach"))
    turn = Rotation.from_euler("y", 170.0, degrees=True).as_matrix()
    second = 1.1 * (second - second[0, 0]) @ turn.T + first[-1, 0] + [3.0, 0.1, 0.5]
    apart = [fitted().correct(recording(one)).positions for one in (first, second)]
    alone = live(fitted(), second, np.arange(len(second)) / 30.0)
    return (first, second), apart, alone, fitted().correct(recording(first), look_ahead=3).positions


@pytest.mark.slow
@pytest.mark.parametrize("lost", [0, 5])
def test_somebody_else_is_met_as_a_stranger(model: CorrectorModel, lost: int) -> None:
    """A metre to the side from one frame to the next, or half a second on, is nobody who was there."""
    (first, second), apart, alone, calm = two_strangers()
    frames = np.concatenate([first, np.full((lost, *first.shape[1:]), np.nan), second])
    times = np.arange(len(frames)) / 30.0
    met = slice(len(first) + lost, None)
    np.testing.assert_allclose(live(model, frames, times)[met], alone, atol=1e-9)
    ahead = model.correct(Postures(model.names, frames, times), look_ahead=3)
    np.testing.assert_allclose(ahead.positions[: len(first) - 3], calm[:-3], atol=1e-9)
    assert np.linalg.norm(ahead.positions[met] - alone, axis=2).mean() < 0.01
    both = model.correct(Postures(model.names, frames, times)).positions
    assert np.linalg.norm(both[: len(first)] - apart[0], axis=2).mean() < 0.02
    assert np.linalg.norm(both[met] - apart[1], axis=2).mean() < 0.02


@cache
def walking_by() -> tuple[Floats, Floats, Floats]:
    """Somebody who is seen throughout, and what comes of it, afterwards and live."""
    frames = sensed(truth("walk", 61), 61) + np.linspace([0.0, 0.0, 0.0], [4.0, 0.0, 0.0], 60)[:, None]
    return frames, fitted().correct(recording(frames)).positions, live(fitted(), frames, np.arange(60) / 30.0)


@pytest.mark.slow
@pytest.mark.parametrize("lost", [6, 15])
def test_who_was_out_of_sight_for_a_moment_did_not_fail(model: CorrectorModel, lost: int) -> None:
    """Nobody stays where they were lost: a walker comes into sight a metre on."""
    frames, wanted, at_once = (one.copy() for one in walking_by())
    times = np.arange(len(frames)) / 30.0
    gap, after = slice(25, 25 + lost), slice(25 + lost, None)
    frames[gap] = np.nan
    assert np.linalg.norm(live(model, frames, times) - at_once, axis=2)[after].mean() < 0.02
    assert np.linalg.norm(model.correct(recording(frames)).positions - wanted, axis=2)[after].mean() < 0.02


def test_who_comes_late_is_met_where_they_are(model: CorrectorModel) -> None:
    """Empty frames before somebody comes say nothing of where that is, nor that their joints fail."""
    frames = sensed(truth("walk", 64, 1.0), 64) + np.array([0.5, 0.0, 3.0])
    wanted, frames[:3] = model.correct(recording(frames)).positions, np.nan
    assert np.linalg.norm(model.correct(recording(frames)).positions - wanted, axis=2)[3:].max() < 0.05


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_joints_that_are_there_stay_there_whatever_others_lack(model: CorrectorModel, seed: int) -> None:
    """Sides that are changed back bring joints to where the sensor has none; those that hang on them are kept."""
    names, rng = KINECT25.names, np.random.default_rng(seed)
    frames = sensed(truth("walk", 62, 1.2), 62)[:, np.maximum(correspondence(model.names, names), 0)]
    frames = frames[:, mirrored(names)]
    frames[1:][rng.random((len(frames) - 1, len(names))) < 0.2] = np.nan
    found = model.correct(Postures(names, frames, np.arange(len(frames)) / 30.0)).positions
    assert np.isfinite(found[np.isfinite(frames)]).all()


@pytest.mark.slow
@pytest.mark.parametrize("exchanged", [10, 20])
def test_who_comes_with_the_sides_exchanged_is_right_when_they_are(model: CorrectorModel, exchanged: int) -> None:
    """That a recording begins with a back taken for a front says nothing of how it goes on."""
    right = sensed(truth("run", 36), 36)
    frames = right.copy()
    frames[:exchanged] = right[:exchanged, mirrored(model.names)]
    apart = model.correct(recording(frames)).positions - model.correct(recording(right)).positions
    assert np.linalg.norm(apart, axis=2).mean() < 0.02


@pytest.mark.parametrize("method", ["default", "ridge", "one-euro", "savgol", "kalman"])
def test_what_is_no_person_moves_nobody(model: CorrectorModel, method: str) -> None:
    """Frames of zeros between others are those of an empty room, for filters too."""
    frames = sensed(truth("walk", 63, 2.0), 63)
    frames[20:24] = 0.0
    found = model.correct(recording(frames), method=method).positions
    there = np.delete(np.arange(len(frames)), np.arange(20, 24))
    assert np.linalg.norm(found - frames, axis=2)[there].max() < 0.5


def foreign(positions: Floats, seed: int) -> Floats:
    """(T, 20, 3) what another sensor makes of people: it has every joint elsewhere, alike on both sides."""
    habit = 0.08 * np.random.default_rng(seed).normal(size=(20, 3))
    other = mirrored(recording(positions[:1]).names)
    return np.asarray(positions + 0.5 * (habit + habit[other] * [-1.0, 1.0, 1.0]))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_what_was_learned_of_one_sensor_is_not_done_to_another(model: CorrectorModel, seed: int) -> None:
    """Its bones tell; it is said; and nothing is made worse than by smoothing alone."""
    true = truth("reach", 70 + seed)
    strange, usual = recording(foreign(true, seed)), recording(sensed(true, seed))
    corrected = model.correct(strange)
    assert error(corrected, true) < 1.05 * error(model.correct(strange, method="savgol"), true)
    assert error(model.correct(strange, look_ahead=0), true) < 1.1 * error(strange, true)
    assert "another sensor" in corrected.source.warnings[0]  # type: ignore[attr-defined]
    assert model.correct(usual).source.warnings == ()  # type: ignore[attr-defined]
    state = model.start(model.names)
    for t, frame in enumerate(strange.positions[:3]):
        state, one = model.step(state, frame, None, t / 30.0)
        assert "foreign" in one.flags
    assert one.std.mean() > 1.3 * model.step(model.start(model.names), usual.positions[0], None, 0.0)[1].std.mean()


def test_joints_of_a_pose_estimator_are_not_taken_for_the_sensors_beforehand(model: CorrectorModel) -> None:
    """Every depth sensor has something between pelvis and neck; without it bones must speak for the learned sensor."""
    frames = foreign(truth("walk", 77, 2.0), 1)
    limbs = [k for k, name in enumerate(model.names) if name not in ("HipCenter", "Spine")]
    both = [k for k, name in enumerate(model.names) if name != "HipCenter"]
    shares = []
    for joints in (limbs, both):
        given = replace(recording(frames), names=tuple(model.names[k] for k in joints), positions=frames[:, joints])
        said = model.correct(given).source.warnings  # type: ignore[attr-defined]
        shares.append(float(said[0].partition(" % of")[0].split()[-1]) if said else 100.0)
    assert shares[0] < min(0.5 * shares[1], 30.0)


@pytest.mark.parametrize("seed", range(3))
def test_another_sensors_bones_are_its_own_from_the_first_frame(model: CorrectorModel, seed: int) -> None:
    """What bones of the sensor that was learned from are like is no reason to pull joints about."""
    strange = recording(foreign(truth("reach", 80 + seed, 3.0), seed))
    found = model.correct(strange, look_ahead=0).positions
    moved = np.linalg.norm(found - strange.positions, axis=2)
    assert moved[:3].mean() < 1.5 * moved[60:].mean() + 0.002


def test_who_sits_is_seen_by_the_same_sensor(model: CorrectorModel) -> None:
    """Legs that a sensor guesses throughout are no sign of another one."""
    true = truth("reach", 75, 3.0)
    given, rng = sensed(true, 75), np.random.default_rng(75)
    legs = [model.names.index(f"{joint}{side}") for joint in ("Knee", "Ankle", "Foot") for side in ("Left", "Right")]
    given[:, legs] += 0.6 * (given[:, :1] + [0.0, -0.4, 0.1] - given[:, legs])
    given[:, legs] += 0.05 * rng.normal(size=given[:, legs].shape)
    for ahead in (None, 0):
        corrected = model.correct(recording(given), look_ahead=ahead)
        assert corrected.source.warnings == ()  # type: ignore[attr-defined]
        rest = np.setdiff1d(np.arange(20), legs)
        far = [np.linalg.norm(one - true, axis=2)[:, rest].mean() for one in (given, corrected.positions)]
        assert far[1] < 0.8 * far[0]


def stopped(model: CorrectorModel, seed: int, digits: int | None) -> tuple[Floats, Floats, list[int], slice]:
    """The truth, and a recording in which an arm stops for two seconds; or all do, in rounded positions."""
    true = truth("reach", 80 + seed, 4.0)
    given, arm, spell = (
        sensed(true, seed),
        [model.names.index(f"{j}Right") for j in ("Elbow", "Wrist", "Hand")],
        slice(30, 90),
    )
    if digits is None:
        given[spell, arm] = given[spell.start, arm]
        return true, given, arm, spell
    given[spell] = given[spell.start] + 0.0005 * np.random.default_rng(seed).normal(size=given[spell].shape)
    return true, np.round(given, digits), arm, spell


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_a_limb_that_stands_still_to_the_last_digit_is_not_seen(model: CorrectorModel, seed: int) -> None:
    """Whatever its state."""
    _, given, arm, spell = stopped(model, seed, None)
    for ahead in (None, 0, 3):
        found = model.correct(recording(given, state=True), look_ahead=ahead).reliability
        assert found is not None
        assert (found[spell][5:, arm] < 0.1).all()
        assert (found[: spell.start - 1] > 0.5).mean() > 0.99


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_who_rests_in_rounded_positions_is_seen(model: CorrectorModel, seed: int) -> None:
    _, given, _, spell = stopped(model, seed, 3)
    found = model.correct(recording(given, state=True)).reliability
    assert found is not None
    assert (found[spell] > 0.5).mean() > 0.98


def test_what_is_repeated_whole_is_seen(model: CorrectorModel) -> None:
    """A sensor that says every posture three times."""
    given = np.repeat(sensed(truth("walk", 90, 4.0), 90)[::3], 3, axis=0)
    found = model.correct(recording(given, state=True)).reliability
    assert found is not None
    assert (found > 0.5).mean() > 0.95


@pytest.mark.parametrize("ahead", [None, 0])
def test_what_never_moves_has_not_stopped(model: CorrectorModel, ahead: int | None) -> None:
    """Legs of who sits, given alike to the last digit in all frames."""
    true = truth("reach", 91, 4.0)
    legs = [model.names.index(f"{joint}{side}") for side in ("Left", "Right") for joint in ("Knee", "Ankle", "Foot")]
    true[:, legs] = true[0, legs]
    given = sensed(true, 91)
    given[:, legs] = given[0, legs]
    found = model.correct(recording(given, state=True), look_ahead=ahead)
    assert found.reliability is not None
    assert (found.reliability[:, legs] > 0.9).all()
    assert np.linalg.norm(found.positions - true, axis=2)[:, legs].mean() < 0.03


def sitting(positions: Floats, names: tuple[str, ...]) -> Floats:
    """Positions (T, J, 3) with legs that lie ahead of the hips."""
    sat = positions.copy()
    for side in ("Left", "Right"):
        for joint, place in (("Knee", [0.0, -0.05, 0.42]), ("Ankle", [0.0, -0.45, 0.45]), ("Foot", [0.0, -0.5, 0.58])):
            sat[:, names.index(f"{joint}{side}")] = sat[:, names.index(f"Hip{side}")] + place
    return sat


@pytest.mark.parametrize("ahead", [None, 0])
def test_limbs_that_were_never_seen_are_unsure_and_named(model: CorrectorModel, ahead: int | None) -> None:
    true = sitting(truth("reach", 92, 3.0), model.names)
    given = sensed(true, 92)
    legs = [model.names.index(f"{joint}Left") for joint in ("Knee", "Ankle", "Foot")]
    given[:, legs] = np.nan
    found = model.correct(recording(given), look_ahead=ahead)
    assert found.std is not None
    assert (found.std[30:, legs] > 0.1).all()
    assert any(one.startswith("KneeLeft, AnkleLeft, FootLeft are in no frame") for one in found.source.warnings)  # type: ignore[attr-defined]


def test_joints_as_pictures_give_them_are_said_to_be_of_another_kind_and_moved_less(model: CorrectorModel) -> None:
    """What estimates poses in pictures has a face and no spine, and none of a depth sensor's habits."""
    true = truth("walk", 78, 3.0)
    limbs = [f"{side}{part}" for side in "LR" for part in ("Shoulder", "Elbow", "Wrist", "Hip", "Knee", "Ankle")]
    kinect = [f"{name[1:]}{'Left' if name[0] == 'L' else 'Right'}" for name in limbs]
    placed = true[:, [model.names.index(name) for name in kinect]]
    nose = true[:, [model.names.index("Head")]] + [0.0, 0.0, 0.1]
    times = np.arange(len(true)) / 30.0
    moved = []
    for names, positions in ((limbs, placed), (["Nose", *limbs], np.concatenate([nose, placed], axis=1))):
        got = model.correct(Postures(tuple(names), positions, times))
        said = " ".join(got.source.warnings)  # type: ignore[attr-defined]
        assert ("pictures" in said or "another sensor" in said) == (names != limbs)
        moved.append(np.linalg.norm((got.positions - positions)[:, -len(limbs) :], axis=2).mean())
    assert moved[1] < 0.75 * moved[0]


@pytest.mark.slow
@pytest.mark.parametrize("look_ahead", [None, 0, 2])
def test_a_sensor_that_says_of_no_joint_that_it_is_tracked_says_nothing(
    model: CorrectorModel, look_ahead: int | None
) -> None:
    raw = recording(sensed(truth("reach", 79), 79))
    silent = replace(raw, state=np.zeros(raw.positions.shape[:2], dtype=np.uint8))
    plain, got = model.correct(raw, look_ahead=look_ahead), model.correct(silent, look_ahead=look_ahead)
    np.testing.assert_array_equal(got.positions, plain.positions)
    assert plain.source.warnings == ()  # type: ignore[attr-defined]
    assert "not to be tracked" in got.source.warnings[0]  # type: ignore[attr-defined]


def test_the_trackers_own_joints_are_of_no_picture(model: CorrectorModel) -> None:
    true = truth("walk", 78, 3.0)
    place = correspondence(model.names, TRACKER16.names)
    positions = np.where((place >= 0)[None, :, None], true[:, place], true[:, [model.names.index("ShoulderCenter")]])
    got = model.correct(Postures(TRACKER16.names, positions, np.arange(len(true)) / 30.0))
    assert not any("pictures" in one for one in got.source.warnings)  # type: ignore[attr-defined]


@pytest.mark.parametrize("look_ahead", [None, 0])
def test_a_sensor_that_loses_everybody_for_a_while_is_heard(model: CorrectorModel, look_ahead: int | None) -> None:
    """Where it says that no joint is tracked after it said that they are, it makes them up."""
    true = truth("reach", 79)
    lost = slice(30, 45)
    given = sensed(true, 79)
    given[lost] = given[29] + np.linspace(0.0, 0.4, 15)[:, None, None] * [1.0, 0.0, 0.0]
    states = np.full(given.shape[:2], 2, dtype=np.uint8)
    states[lost] = 0
    raw = recording(given)
    told = model.correct(replace(raw, state=states), look_ahead=look_ahead)
    untold = model.correct(raw, look_ahead=look_ahead)
    assert told.reliability is not None
    assert untold.reliability is not None
    assert (1.0 - told.reliability[lost]).mean() > 5.0 * (1.0 - untold.reliability[lost]).mean()
