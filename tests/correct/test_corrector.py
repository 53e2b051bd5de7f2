"""A corrector learned on synthetic people: what it must keep to, whoever it is shown."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from sensed_people import NAMES, error, fitted, pair, recording, sensed, truth

from motionmend.arrays import Floats
from motionmend.bodies.joint_sets import AZURE32, KINECT20, KINECT25, correspondence, mirrored
from motionmend.bodies.postures import Postures
from motionmend.correct import METHODS, Corrector, CorrectorModel, paper
from motionmend.correct.settling import bones_outward
from motionmend.errors import MismatchError, UsageError
from motionmend.evaluate.sensor_failures import fail
from motionmend.io.model import load_model, save_model


@pytest.fixture(scope="module")
def model() -> CorrectorModel:
    return fitted()


@cache
def usually(action: str, seed: int, seconds: float = 2.0, state: bool = False) -> Postures:
    """What several tests compare with: somebody whom the sensor sees going well, corrected."""
    return fitted().correct(recording(sensed(truth(action, seed, seconds), seed), state))


def live(
    model: CorrectorModel, postures: Postures, online: bool = False
) -> tuple[Floats, Floats, list[tuple[str, ...]]]:
    state = model.start(postures.names, online)
    frames, reliable, flags = [], [], []
    for t in range(postures.frames):
        told = None if postures.state is None else postures.state[t]
        state, frame = model.step(state, postures.positions[t], told, float(postures.times[t]))
        frames.append(frame.positions)
        reliable.append(frame.reliability)
        flags.append(frame.flags)
    return np.stack(frames), np.stack(reliable), flags


@pytest.mark.slow
@pytest.mark.parametrize(("action", "seed"), [("walk", 7), ("reach", 8), ("jump", 9), ("run", 5)])
def test_people_not_seen_before_come_out_nearer_to_the_truth(model: CorrectorModel, action: str, seed: int) -> None:
    true = truth(action, seed)
    raw = recording(sensed(true, seed))
    corrected = model.correct(raw)
    assert error(corrected, true) < 0.6 * error(raw, true)
    assert np.linalg.norm(live(model, raw)[0] - true, axis=2).mean() < 0.6 * error(raw, true)
    assert corrected.names == raw.names
    np.testing.assert_array_equal(corrected.times, raw.times)
    assert corrected.std is not None
    assert (corrected.std > 0).all()
    assert corrected.reliability is not None
    assert corrected.reliability.mean() > 0.95


@pytest.mark.slow
@pytest.mark.parametrize("degrees", [35.0, 200.0])
def test_correction_commutes_with_turning_and_moving_the_person(model: CorrectorModel, degrees: float) -> None:
    raw = recording(sensed(truth("reach", 4, 1.0), 4))
    turn = Rotation.from_euler("y", degrees, degrees=True).as_matrix()
    moved = raw.with_positions(raw.positions @ turn.T + [3.0, 0.2, -1.0])
    wanted = usually("reach", 4, 1.0)
    got = model.correct(moved)
    np.testing.assert_allclose(got.positions, wanted.positions @ turn.T + [3.0, 0.2, -1.0], atol=1e-6)
    np.testing.assert_allclose(got.reliability, wanted.reliability, atol=1e-5)
    np.testing.assert_allclose(live(model, moved)[0], live(model, raw)[0] @ turn.T + [3.0, 0.2, -1.0], atol=1e-6)


def test_axes_with_y_down_are_understood(model: CorrectorModel) -> None:
    raw = recording(sensed(truth("walk", 4, 1.0), 4))
    flip = np.diag([1.0, -1.0, -1.0])
    got = model.correct(raw.with_positions(raw.positions @ flip))
    np.testing.assert_allclose(got.positions, usually("walk", 4, 1.0).positions @ flip, atol=1e-6)


def test_a_larger_person_is_corrected_alike(model: CorrectorModel) -> None:
    raw = recording(sensed(truth("walk", 4, 1.0), 4))
    got = model.correct(raw.with_positions(1.2 * raw.positions))
    np.testing.assert_allclose(got.positions / 1.2, usually("walk", 4, 1.0).positions, atol=2e-3)


def test_bones_keep_their_lengths(model: CorrectorModel) -> None:
    raw = recording(sensed(truth("run", 6), 6, noise=0.01))
    bones = bones_outward(NAMES)

    def varies(positions: Floats) -> float:
        lengths = np.linalg.norm(positions[:, bones[:, 1]] - positions[:, bones[:, 0]], axis=2)
        return float((lengths.std(axis=0) / lengths.mean(axis=0)).mean())

    assert varies(model.correct(raw).positions) < 0.05 * varies(raw.positions)
    assert varies(live(model, raw)[0]) < 0.6 * varies(raw.positions)


@pytest.mark.slow
@pytest.mark.parametrize("bad", [np.nan, -np.inf, 1e30])
def test_what_is_not_finite_never_poisons_later_frames(model: CorrectorModel, bad: float) -> None:
    raw = recording(sensed(truth("walk", 7, 1.5), 7))
    positions = np.array(raw.positions)
    positions[5:11, 4:9] = bad
    positions[15] = bad
    spoilt, reliable, _ = live(model, raw.with_positions(positions))
    clean, _, _ = live(model, raw)
    assert np.isfinite(np.delete(spoilt, 15, axis=0)).all()
    assert (reliable[5:11, 4:9] == 0).all()
    assert np.linalg.norm(spoilt[-20:] - clean[-20:], axis=2).max() < 0.03
    whole = model.correct(raw.with_positions(positions))
    assert np.isfinite(np.delete(whole.positions, 15, axis=0)).all()


@pytest.mark.slow
def test_a_state_serves_again_and_again(model: CorrectorModel) -> None:
    raw = recording(sensed(truth("walk", 7), 7))
    state = model.start(NAMES, online=True)
    for t in range(10):
        state, _ = model.step(state, raw.positions[t], None, t / 30.0)
    one = model.step(state, raw.positions[10], None, 10 / 30.0)[1]
    for t in range(11, 20):
        model.step(state, raw.positions[t], None, t / 30.0)
    again = model.step(state, raw.positions[10], None, 10 / 30.0)[1]
    np.testing.assert_array_equal(one.positions, again.positions)


@pytest.mark.slow
@pytest.mark.parametrize("states", [True, False])
def test_failing_limbs_are_told_and_mended(model: CorrectorModel, states: bool) -> None:
    raws, mended, scores, spoilt = [], [], [], []
    for seed, action in enumerate(("walk", "reach", "jump", "walk")):
        true = truth(action, 20 + seed)
        failed = fail(recording(sensed(true, seed)), states=states, seed=seed)
        corrected = model.correct(failed.postures)
        raws.append(np.linalg.norm(failed.postures.positions - true, axis=2)[failed.affected])
        mended.append(np.linalg.norm(corrected.positions - true, axis=2)[failed.affected])
        assert corrected.reliability is not None
        scores.append(corrected.reliability.ravel())
        spoilt.append(failed.affected.ravel())
    score, bad = np.concatenate(scores), np.concatenate(spoilt)
    assert np.concatenate(mended).mean() < 0.45 * np.concatenate(raws).mean()
    order = np.argsort(np.argsort(score, kind="stable"), kind="stable")
    area = 1.0 - (order[bad].sum() - bad.sum() * (bad.sum() - 1) / 2) / (bad.sum() * (~bad).sum())
    assert area > 0.93


def test_sides_taken_for_each_other_are_put_right(model: CorrectorModel) -> None:
    true = truth("walk", 11, 4.0)
    raw = recording(sensed(true, 11))
    swapped = np.array(raw.positions)
    swapped[40:80] = swapped[40:80][:, mirrored(NAMES)]
    frames, reliable, flags = live(model, raw.with_positions(swapped))
    assert np.linalg.norm(frames[40:80] - true[40:80], axis=2).mean() < 0.04
    assert np.linalg.norm(swapped[40:80] - true[40:80], axis=2).mean() > 0.15
    assert all("swapped" in flags[t] for t in range(42, 78))
    assert not any("swapped" in flags[t] for t in range(38))
    legs = [NAMES.index(one) for one in ("KneeLeft", "KneeRight", "HipLeft", "HipRight")]
    assert reliable[45:75][:, legs].mean() < 0.5


def test_a_person_who_turns_around_is_followed(model: CorrectorModel) -> None:
    true = truth("turn", 3, 5.0)
    frames, _, flags = live(model, recording(sensed(true, 3)))
    assert np.linalg.norm(frames - true, axis=2).mean() < 0.03
    assert sum("swapped" in one for one in flags) == 0


@pytest.mark.slow
@pytest.mark.parametrize("names", [KINECT25.names, AZURE32.names, tuple(reversed(NAMES)), NAMES[:15]])
def test_other_skeletons_are_corrected_through_joints_that_mean_the_same(
    model: CorrectorModel, names: tuple[str, ...]
) -> None:
    raw = sensed(truth("walk", 12, 1.0), 12)
    found = correspondence(NAMES, names)
    positions = np.full((len(raw), len(names), 3), np.nan)
    positions[:, found >= 0] = raw[:, found[found >= 0]]
    rest = np.flatnonzero(found < 0)
    positions[:, rest] = raw[:, [0]] + 0.05 * np.random.default_rng(1).normal(size=(len(rest), 3))
    got = model.correct(Postures(names, positions, np.arange(len(raw)) / 30.0))
    assert got.names == names
    assert np.isfinite(got.positions).all()
    known = usually("walk", 12, 1.0).positions
    same = np.linalg.norm(got.positions[:, found >= 0] - known[:, found[found >= 0]], axis=2)
    assert same.mean() < 0.02


@pytest.mark.slow
def test_learning_on_the_way_keeps_its_memory_and_does_no_harm(model: CorrectorModel) -> None:
    true = truth("reach", 14)
    raw = recording(sensed(true, 14))
    offline, online = error(model.correct(raw), true), error(model.correct(raw, online=True), true)
    assert online < 1.1 * offline + 0.001
    state = model.start(NAMES, online=True)
    assert state.memory is not None
    size = state.memory.mixture.factors.nbytes
    for t in range(raw.frames):
        state, _ = model.step(state, raw.positions[t], None, t / 30.0)
    assert state.memory is not None
    assert state.memory.mixture.factors.nbytes == size
    assert state.memory.mixture.counts.sum() > 0
    assert model.start(NAMES).memory is None


@pytest.mark.slow
def test_learning_on_the_way_does_not_learn_from_itself_live(model: CorrectorModel) -> None:
    """What was remembered is no news when it comes back: it would be remembered the more."""
    ratios = []
    for seed, motion in ((21, "reach"), (22, "walk"), (23, "jump")):
        true = truth(motion, seed, 8.0)
        raw = recording(sensed(true, seed))
        live, online = (model.correct(raw, online=way, look_ahead=0) for way in (False, True))
        ratios.append(error(online, true) / error(live, true))
    assert max(ratios) < 1.02


def test_nothing_is_learned_from_joints_that_fail(model: CorrectorModel) -> None:
    raw = recording(sensed(truth("walk", 15, 4.0), 15))
    positions = np.array(raw.positions)
    hand = NAMES.index("WristLeft")
    positions[:, hand] += 0.06 * np.random.default_rng(0).normal(size=positions[:, hand].shape)
    state = model.start(NAMES, online=True)
    for t in range(raw.frames):
        state, _ = model.step(state, positions[t], None, t / 30.0)
    assert state.memory is not None
    counts = state.memory.mixture.counts.sum(axis=1)
    assert counts[hand] < 0.75 * np.median(counts)


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_every_method_keeps_frames_and_joints(
    model: CorrectorModel, method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(paper, "MODELS", 3)
    monkeypatch.setattr(paper, "SIZE", 15)
    true = truth("walk", 13)[:15]  # few frames: those that try several models a frame take their time
    raw = recording(sensed(true, 13))
    got = model.correct(raw, method=method)
    assert got.positions.shape == raw.positions.shape
    assert np.isfinite(got.positions).all()
    again = model.correct(raw, method=method)
    np.testing.assert_array_equal(got.positions, again.positions)
    if method in ("constant", "ridge", "gp", "exemplar"):
        assert error(got, true) < 0.75 * error(raw, true)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["paper", "exact", "adaptive"])
@pytest.mark.parametrize("gone", [0, 5])
def test_the_papers_energy_does_not_carry_a_person_over_a_break(
    model: CorrectorModel, method: str, gone: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(paper, "MODELS", 3)
    monkeypatch.setattr(paper, "SIZE", 15)
    raw = recording(sensed(truth("walk", 13), 13)[:16])
    positions, times = np.array(raw.positions), np.array(raw.times)
    positions[6:] += [4.0, 0.0, 0.0]  # elsewhere after a while
    positions[6 : 6 + gone] = np.nan
    times[6:] += 0.0 if gone else 10.0
    broken = model.correct(replace(raw, positions=positions, times=times), method=method)
    there = np.isfinite(broken.positions)
    np.testing.assert_array_equal(there, np.isfinite(positions))
    assert np.abs(broken.positions - positions)[there].max() < 0.5


@pytest.mark.slow
def test_a_model_comes_back_from_its_file_and_says_the_same(model: CorrectorModel, tmp_path) -> None:  # type: ignore[no-untyped-def]
    arrays, header = model.to_arrays()
    save_model(tmp_path / "m.mend", "corrector", arrays, header)
    stored = load_model(tmp_path / "m.mend")
    again = CorrectorModel.from_arrays(stored.arrays, stored.header)
    raw = recording(sensed(truth("walk", 16, 1.0), 16))
    for method in ("default", "ridge"):
        np.testing.assert_array_equal(
            model.correct(raw, method=method).positions, again.correct(raw, method=method).positions
        )


@pytest.mark.slow
def test_the_same_pairs_make_the_same_model() -> None:
    pairs = [pair("walk", seed, 2.0) for seed in range(3)]
    one, other = (Corrector(points=60).fit(pairs).to_arrays() for _ in range(2))
    assert one[1] == other[1]
    for name in one[0]:
        np.testing.assert_array_equal(one[0][name], other[0][name])


def test_failures_among_the_lessons_do_not_spoil_the_model() -> None:
    clean = [pair("walk", seed) for seed in range(4)]
    spoilt = [
        replace(one, sensor=replace(fail(one.sensor, share=0.3, seed=k).postures, state=None))
        for k, one in enumerate(clean)
    ]
    true = truth("walk", 9)
    raw = recording(sensed(true, 9))
    assert error(Corrector(points=100).fit(spoilt).correct(raw), true) < 0.6 * error(raw, true)


def test_mistakes_are_said(model: CorrectorModel) -> None:
    with pytest.raises(MismatchError, match="came none"):
        Corrector().fit([])
    with pytest.raises(MismatchError, match="at least 4 joints"):
        model.start(("a", "b", "c", "d", "e"))
    with pytest.raises(UsageError, match="came -1"):
        model.start(KINECT20.names, look_ahead=-1)
    with pytest.raises(UsageError, match="came -1"):
        model.correct(Postures(NAMES, np.zeros((0, 20, 3)), np.zeros(0)), look_ahead=-1)
    with pytest.raises(UsageError, match="unknown method"):
        model.correct(recording(sensed(truth("walk", 1), 1)), method="magic")
    empty = Postures(NAMES, np.zeros((0, 20, 3)), np.zeros(0))
    assert model.correct(empty).frames == 0
    alone = recording(sensed(truth("walk", 1), 1)[:1])
    assert np.isfinite(model.correct(alone).positions).all()


def test_joints_in_one_point_are_nobody_to_be_measured_by(model: CorrectorModel) -> None:
    """A sensor that begins with all joints in one place: its first frame says no size, and the next ones do."""
    raw = recording(sensed(truth("walk", 2), 2))
    first = raw.positions.copy()
    first[0] = first[0].mean(axis=0)
    found, _, _ = live(model, raw.with_positions(first))
    assert np.isnan(found[0]).all()
    assert np.isfinite(found[1:]).all()
    np.testing.assert_allclose(found[20:], live(model, raw)[0][20:], atol=0.02)


@pytest.mark.parametrize("empty", [True, False])
def test_who_comes_back_may_face_anywhere(model: CorrectorModel, empty: bool) -> None:
    """Somebody leaves for two seconds, in frames without anybody or without frames, and comes back turned round."""
    true = truth("walk", 4)
    turn = Rotation.from_euler("y", 180, degrees=True).as_matrix()
    back = true @ turn.T
    raw = sensed(np.concatenate([true, back]), 4)
    gap = 60
    times = np.arange(len(raw)) / 30.0
    times[len(true) :] += gap / 30.0
    whole = recording(raw)
    if empty:
        nobody = np.full((gap, *raw.shape[1:]), np.nan)
        raw = np.concatenate([raw[: len(true)], nobody, raw[len(true) :]])
        times = np.arange(len(raw)) / 30.0
    postures = replace(whole, positions=raw, times=times, state=None)
    found, _, flags = live(model, postures)
    assert not any("swapped" in words for words in flags)
    alone = live(model, replace(whole, positions=sensed(np.concatenate([true, back]), 4)[len(true) :],
                                times=np.arange(len(back)) / 30.0, state=None))[0]  # fmt: skip
    assert np.linalg.norm(found[-len(back) :] - back, axis=2).mean() < 1.3 * np.linalg.norm(alone - back, axis=2).mean()


@pytest.mark.slow
@pytest.mark.parametrize("look_ahead", [0, 5])
def test_who_comes_next_is_corrected_as_if_nobody_had_been_before(model: CorrectorModel, look_ahead: int) -> None:
    """A larger person comes three seconds after a smaller one has left; nobody's bones are another's."""
    first, second = sensed(truth("walk", 4, 1.0), 4), 1.3 * sensed(truth("walk", 5, 1.0), 5)
    nobody = np.full((90, *first.shape[1:]), np.nan)
    one = recording(np.concatenate([first, nobody, second]))
    found = model.correct(one, look_ahead=look_ahead).positions[-len(second) :]
    alone = model.correct(recording(second), look_ahead=look_ahead).positions
    np.testing.assert_allclose(found, alone, atol=0.005)
    state, _ = model.start(NAMES, online=True), None
    for t in (0.0, 10.0):
        state, _ = model.step(state, second[0], None, t)
    assert state.memory is not None


def test_a_clock_that_goes_back_in_a_file_leaves_no_hole(model: CorrectorModel) -> None:
    raw = recording(sensed(truth("walk", 6, 1.0), 6))
    times = raw.times.copy()
    times[15:] -= 5.0
    for look_ahead in (None, 3):
        assert np.isfinite(model.correct(replace(raw, times=times), look_ahead=look_ahead).positions).all()


def test_a_quicker_sensor_takes_the_same_time_to_know_a_person(model: CorrectorModel) -> None:
    raw = recording(sensed(truth("walk", 6), 6))
    quick = np.arange(4 * (raw.frames - 1) + 1) / 120.0
    between = np.stack([np.interp(quick, raw.times, one) for one in raw.positions.reshape(raw.frames, -1).T], axis=1)
    states = []
    for times, positions in (
        (raw.times, raw.positions),
        (quick, between.reshape(len(quick), *raw.positions.shape[1:])),
    ):
        state = model.start(NAMES)
        for time, frame in zip(times, positions, strict=True):
            state, _ = model.step(state, frame, None, float(time))
        states.append(state.sight.followed)
    np.testing.assert_allclose(states[1].met, states[0].met, rtol=0.1)
    np.testing.assert_allclose(states[1].own, states[0].own, atol=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_who_knows_all_of_a_recording_does_no_worse_than_live_where_joints_fail(
    model: CorrectorModel, seed: int
) -> None:
    true = truth("reach", 20 + seed, 3.0)
    failed = fail(recording(sensed(true, seed), state=True), seed=seed)
    away = np.linalg.norm(model.correct(failed.postures).positions - true, axis=2)[failed.affected].mean()
    at_once = np.linalg.norm(live(model, failed.postures)[0] - true, axis=2)[failed.affected].mean()
    raw = np.linalg.norm(failed.postures.positions - true, axis=2)[failed.affected].mean()
    assert away < at_once + 0.1 * raw


@pytest.mark.slow
@pytest.mark.parametrize(("limb", "seed"), [("Wrist", 1), ("Ankle", 2)])
@pytest.mark.parametrize("spell", [slice(0, 25), slice(25, 43)])
def test_sides_confused_from_the_first_frame_are_told_from_those_confused_later(
    model: CorrectorModel, limb: str, seed: int, spell: slice
) -> None:
    """Either way two limbs change places within one frame; a body tells which of the two was right."""
    raw = recording(sensed(truth("reach", 30 + seed), 30 + seed))
    sides = [NAMES.index(f"{limb}Left"), NAMES.index(f"{limb}Right")]
    given = raw.positions.copy()
    given[spell, sides] = raw.positions[spell][:, sides[::-1]]
    found = model.correct(raw.with_positions(given)).positions
    apart = np.linalg.norm(found - usually("reach", 30 + seed).positions, axis=2)[:, sides]
    assert apart.mean() < 0.05


@pytest.mark.slow
@pytest.mark.parametrize("parts", [("Elbow", "Wrist", "Hand"), ("Hand", "Wrist"), ("Knee", "Ankle", "Foot"), ("",)])
@pytest.mark.parametrize("spell", [slice(None), slice(0, 27)])
def test_sides_exchanged_throughout_or_mostly_are_put_right(
    model: CorrectorModel, parts: tuple[str, ...], spell: slice
) -> None:
    """Of limbs, or of the whole body, as of one who turns the back."""
    raw = recording(sensed(truth("walk", 35, 1.2), 35), state=True)
    joints = [k for k, name in enumerate(NAMES) if name.startswith(parts) and name.endswith(("Left", "Right"))]
    given = raw.positions.copy()
    given[spell, joints] = raw.positions[spell][:, mirrored(NAMES)[joints]]
    wanted = usually("walk", 35, 1.2, True).positions[:, joints]
    found = model.correct(raw.with_positions(given))
    at_once = live(model, raw.with_positions(given))[0]
    assert np.linalg.norm(found.positions[:, joints] - wanted, axis=2).mean() < 0.03
    assert np.linalg.norm(at_once[:, joints] - wanted, axis=2).mean() < 0.05
    assert found.reliability is not None
    assert found.reliability[spell][:, joints].max() < 0.5


@pytest.mark.slow
@pytest.mark.parametrize("ahead", [None, 0])
@pytest.mark.parametrize(
    ("parts", "said"),
    [("", "left and right of the whole body"), ("Wrist", "WristLeft, HandLeft, WristRight, HandRight")],
)
def test_what_was_exchanged_throughout_is_said(model: CorrectorModel, ahead: int | None, parts: str, said: str) -> None:
    """A mirrored recording is changed as one whose names are wrong; for a while sides are confused without a word."""
    raw = recording(sensed(truth("walk", 35, 1.2), 35), state=True)
    joints = [
        k for k, name in enumerate(NAMES) if name.startswith((parts, "Hand")) and name.endswith(("Left", "Right"))
    ]
    for spell, frames in ((slice(None), raw.frames), (slice(6, 18), 0)):
        given = raw.positions.copy()
        given[spell, joints] = raw.positions[spell][:, mirrored(NAMES)[joints]]
        found = model.correct(raw.with_positions(given), look_ahead=ahead).source.warnings  # type: ignore[attr-defined]
        if frames:
            assert any(said in one and f"in {frames} of {frames} frames" in one for one in found)
        else:
            assert found == ()


def test_who_turns_the_back_at_first_is_not_said_to_have_been_confused_before(model: CorrectorModel) -> None:
    """A first frame can be exchanged, but righted only are sides that earlier frames got wrong."""
    raw = recording(sensed(truth("walk", 35, 0.2), 35), state=True)
    given = raw.positions[:, mirrored(NAMES)]
    state, _ = model.step(model.start(raw.names), given[0], None, 0.0)
    assert state.sight.swapped.any()
    assert not state.sight.righted.any()


def test_times_that_can_be_no_seconds_are_refused_in_words(model: CorrectorModel) -> None:
    """A thirtieth of a second in hours: smoothing would fail in the middle of its sums."""
    hurried = Postures(KINECT25.names, np.zeros((40, 25, 3)) + np.arange(25)[:, None] / 25, np.arange(40) / 30 / 3600)
    with pytest.raises(MismatchError, match=r"times in s were wanted, they rise by 9\.3e-06 a frame"):
        model.correct(hurried)
