"""Live repair: what is given out never needs the future beyond the lag, and never changes."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.bodies.motion import Markers, Motion, Origin
from motionmend.denoise import Denoiser, DenoiserModel
from motionmend.denoise.fixed_lag import FixedLag, Live, finish, joined, repair_with_lag, start, step
from motionmend.errors import MismatchError, UsageError
from motionmend.evaluate import compare, corrupt
from motionmend.io import read
from motionmend.samples import clip, markers
from performers import every_other

FPS = 30.0
QUICK = FixedLag(lag=0.2, memory=0.4, hop=0.5)  # 6, 12 and 15 frames
FRAMES = 45  # given out in three pieces, the later two by repairs that no longer see the beginning


def values(recording) -> np.ndarray:
    return recording.positions if isinstance(recording, Markers) else recording.q


def with_values(recording, changed: np.ndarray):
    return recording.with_positions(changed) if isinstance(recording, Markers) else recording.with_q(changed)


def same(one, other) -> None:
    np.testing.assert_array_equal(values(one.recording), values(other.recording))
    for name in ("origin", "std", "weights"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def given_out(model, recording, settings, cuts) -> list:
    """The pieces of a recording that comes in cut at some frames."""
    state, pieces = start(model, recording, settings), []
    for part in np.split(values(recording), cuts):
        state, finished = step(state, part)
        pieces += finished
    last = finish(state)
    return pieces + ([] if last is None else [last])


@pytest.fixture(scope="module")
def model() -> DenoiserModel:
    return Denoiser(window=12, fps=FPS).fit([clip("walk", seconds=3.0, fps=FPS, seed=s) for s in (1, 2, 3)])


@pytest.fixture(scope="module")
def marker_model() -> DenoiserModel:
    clips = [clip("walk", seconds=3.0, fps=FPS, seed=s) for s in (1, 2, 3)]
    return Denoiser(window=12, fps=FPS).fit([every_other(markers(c)) for c in clips])


@pytest.fixture(scope="module")
def take() -> Motion:
    walk = clip("walk", seconds=2.0, fps=FPS, seed=9).at_frames(slice(0, FRAMES))
    return corrupt(walk, noise=np.radians(3), outliers=0.1, gaps=0.05, seed=4).recording


@pytest.fixture(scope="module")
def marker_take() -> Markers:
    walk = every_other(markers(clip("walk", seconds=2.0, fps=FPS, seed=9))).at_frames(slice(0, FRAMES))
    # gaps no longer than a piece: what of a marker none tells is filled from limbs, which takes ten times as long
    return corrupt(walk, noise=0.005, outliers=0.05, gaps=0.02, seed=4).recording


@pytest.fixture(scope="module")
def whole(model, take):
    return repair_with_lag(model, take, QUICK)


@pytest.mark.slow
@settings(max_examples=4)
@given(st.integers(0, FRAMES - 1), st.integers(0, 2**31))
def test_frames_beyond_lag_and_hop_change_nothing_before(model, take, whole, first, seed):
    rng = np.random.default_rng(seed)
    changed = take.q.copy()
    changed[first:] += rng.normal(0.0, 0.1, changed[first:].shape)  # to the bit, by however little it is another
    changed[first:][rng.random(changed[first:].shape) < 0.1] = np.nan
    other = repair_with_lag(model, take.with_q(changed), QUICK)
    lag, _, hop = QUICK.frames(FPS)
    before = max(0, first - lag - hop + 1)  # frame t needs none after t + lag + hop - 1
    np.testing.assert_array_equal(other.recording.q[:before], whole.recording.q[:before])
    np.testing.assert_array_equal(other.origin[:before], whole.origin[:before])
    np.testing.assert_array_equal(other.std[:before], whole.std[:before])


@pytest.mark.slow
def test_markers_too_need_no_future(marker_model, marker_take):
    changed = marker_take.positions.copy()
    changed[39:] = changed[39:, :, [1, 0, 2]] + [3.0, -2.0, 0.5]
    one = repair_with_lag(marker_model, marker_take, QUICK)
    other = repair_with_lag(marker_model, marker_take.with_positions(changed), QUICK)
    lag, _, hop = QUICK.frames(FPS)
    before = 39 - lag - hop + 1
    np.testing.assert_array_equal(other.recording.positions[:before], one.recording.positions[:before])
    assert not np.array_equal(other.recording.positions[39:], one.recording.positions[39:])


@pytest.mark.slow
def test_a_marker_gone_for_all_that_is_remembered_is_filled_by_the_library(marker_model):
    clean = every_other(markers(clip("walk", seconds=1.0, fps=FPS, seed=9)))
    gone = clean.positions.copy()
    gone[:, 4] = np.nan
    found = repair_with_lag(marker_model, clean.with_positions(gone), FixedLag(lag=0.2, memory=0.4, hop=0.8))
    assert (found.origin[:, 4] == Origin.FILLED).all()
    assert np.linalg.norm(found.recording.positions - clean.positions, axis=2)[:, 4].mean() < 0.03


@pytest.mark.slow
@settings(max_examples=3)
@given(st.lists(st.integers(0, FRAMES), max_size=12).map(sorted))
def test_how_frames_are_dealt_out_changes_no_byte(model, take, whole, cuts):
    same(joined(take, given_out(model, take, QUICK, cuts)), whole)


@pytest.mark.slow
def test_single_frames_come_out_once_and_in_order_no_later_than_said(model, take, whole):
    state = start(model, take, QUICK)
    lag, _, hop = QUICK.frames(FPS)
    out = []
    for t, frame in enumerate(take.q):
        before = state
        state, finished = step(state, frame)
        out += [(t, piece) for piece in finished]
        assert state.given == sum(piece.recording.frames for _, piece in out)
        assert t + 1 - state.given <= lag + hop - 1
        assert (before.seen, state.seen) == (t, t + 1)
    assert QUICK.latency(FPS) == pytest.approx((lag + hop - 1) / FPS)
    last = finish(state)
    assert last is not None
    pieces = [piece for _, piece in out] + [last]
    assert sum(piece.recording.frames for piece in pieces) == take.frames
    same(joined(take, pieces), whole)


@pytest.mark.slow
def test_a_state_is_never_changed(model, take):
    state, _ = step(start(model, take, QUICK), take.q[:25])
    kept = state.recent.q.copy()
    one, first = step(state, take.q[25:40])
    other, second = step(state, take.q[25:40])
    assert (state.seen, state.given) == (25, 15)
    np.testing.assert_array_equal(state.recent.q, kept)
    for a, b in zip(first, second, strict=True):
        same(a, b)
    assert (one.seen, one.given) == (other.seen, other.given)


@pytest.mark.slow
def test_memory_is_bounded(model, take):
    state: Live[Motion] = start(model, take, QUICK)
    for _ in range(2):
        state, _ = step(state, take.q[:20])
    assert state.recent.frames == sum(QUICK.frames(FPS))


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["motion", "markers"])
def test_a_lag_longer_than_the_clip_is_the_repair_of_the_whole(request, kind):
    model = request.getfixturevalue("model" if kind == "motion" else "marker_model")
    take = request.getfixturevalue("take" if kind == "motion" else "marker_take")
    live, offline = repair_with_lag(model, take, FixedLag(lag=2.0, memory=0.5)), model.repair(take)
    same(live, offline)
    assert live.warnings == offline.warnings
    np.testing.assert_array_equal(live.noise, offline.noise)


@pytest.mark.slow
def test_it_repairs_with_a_tenth_of_a_second(model, take):
    truth = clip("walk", seconds=2.0, fps=FPS, seed=9).at_frames(slice(0, FRAMES))
    live = repair_with_lag(model, take, FixedLag(lag=0.1, memory=1.0, hop=0.2))
    assert compare(truth, live.recording).rms_deg < 0.35 * compare(truth, take).rms_deg
    assert live.recording.present.all()
    assert ((live.origin == Origin.FILLED) == ~take.present).all()


@pytest.mark.slow
def test_what_is_left_open_is_counted_over_the_whole(model, take):
    gone = take.q.copy()
    gone[20:] = np.nan
    live = repair_with_lag(model, take.with_q(gone), QUICK)
    left = int((live.origin == Origin.LEFT_OPEN).sum())
    assert left > 0
    assert [said.split()[0] for said in live.warnings if "left open" in said] == [str(left)]


@pytest.mark.slow
def test_nothing_comes_of_nothing(model, take):
    empty = replace(take, q=take.q[:0])
    assert finish(start(model, empty)) is None
    assert repair_with_lag(model, empty).recording.frames == 0
    one = repair_with_lag(model, replace(take, q=take.q[:1]), FixedLag(lag=0.0, hop=0.0))
    assert one.recording.frames == 1


@pytest.mark.parametrize("wrong", [{"lag": -0.1}, {"lag": np.nan}, {"memory": 0.0}, {"hop": -1.0}, {"lag": np.inf}])
def test_senseless_settings_are_refused(wrong):
    with pytest.raises(UsageError):
        FixedLag(**wrong)


def test_frames_of_other_channels_are_refused(model, take):
    state = start(model, take, QUICK)
    with pytest.raises(MismatchError):
        step(state, take.q[0, :-1])
    with pytest.raises(MismatchError):
        step(state, take.q[None])


@pytest.mark.slow
def test_a_real_walk_with_a_quarter_of_a_second_is_as_good_as_offline(data):
    folder = data / "mocap" / "amc" / "07"
    clips = [read(path) for path in sorted(folder.glob("07_0[2-5].amc"))]
    truth = read(folder / "07_01.amc")
    truth = replace(truth, q=truth.q[::4], fps=FPS)
    model = Denoiser().fit(clips)
    noisy = corrupt(truth, noise=np.radians(3), outliers=0.1, seed=1).recording
    offline = compare(truth, model.repair(noisy).recording).rms_deg
    live = compare(truth, repair_with_lag(model, noisy, FixedLag(lag=0.25)).recording).rms_deg
    assert live < 1.15 * offline
    assert live < 0.2 * compare(truth, noisy).rms_deg
