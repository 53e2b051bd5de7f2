"""Laws of a repair by the adaptive method: where, when and in which order does not matter; every sample is told of."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.bodies.motion import Markers, Motion, Origin
from motionmend.denoise import Denoiser, repair_without_model
from motionmend.denoise.adaptive import blocks
from motionmend.denoise.adaptive.blocks import mend_channels
from motionmend.denoise.channels.joints import joint_rotation, root_rows
from motionmend.denoise.library.local_prior import Prior
from motionmend.evaluate import compare, corrupt
from motionmend.io import read
from motionmend.samples import markers
from performers import (
    FPS,
    channels_of,
    clips,
    every_other,
    f1,
    half_the_markers_model,
    joints_model,
    mend,
    moved,
    rms,
    spoilt,
    truth,
)


def _spoilt(recording, seed=4, **damage):
    return corrupt(recording, seed=seed, **damage).recording


def _said_of_all(repaired):
    """Every sample has an origin; a value and a deviation unless it was left open."""
    open_ = repaired.origin == Origin.LEFT_OPEN
    assert np.isin(repaired.origin, list(Origin)).all()
    np.testing.assert_array_equal(repaired.recording.present, ~open_)
    assert (repaired.std[~open_] > 0).all()
    assert np.isnan(repaired.std[open_]).all()


def _cloud(seconds):
    return every_other(markers(truth("walk", seconds=seconds)))


@cache
def _at_home(kind):
    """A model, a recording, and its repair where it was recorded."""
    motion = kind == "motion"
    clean, model = (truth("walk", seconds=2.0), joints_model()) if motion else (_cloud(2.0), half_the_markers_model())
    damaged = _spoilt(clean, noise=np.radians(2) if motion else 0.01, outliers=0.05, gaps=0.05)
    return model, damaged, model.repair(damaged)


@pytest.mark.slow
@given(angle=st.floats(-6, 6), x=st.floats(-9, 9), y=st.floats(-2, 2), z=st.floats(-9, 9))
@settings(max_examples=3)  # the first is no way at all
@pytest.mark.parametrize("kind", ["motion", "markers"])
def test_walking_somewhere_else_is_repaired_the_same(kind, angle, x, y, z):
    """To 1e-6 rad and m, with noise, outliers and gaps."""
    model, damaged, at_home = _at_home(kind)
    shift = np.array([x, y, z])
    there = model.repair(moved(damaged, angle, shift))
    here = moved(at_home.recording, angle, shift)
    if kind == "markers":
        np.testing.assert_array_equal(there.origin, at_home.origin)
        assert np.nanmax(np.abs(there.recording.positions - here.positions)) < 1e-6
        return
    turns, _ = root_rows(here.skeleton)
    others = np.setdiff1d(np.arange(here.q.shape[1]), turns)
    np.testing.assert_array_equal(there.origin[:, others[6:]], at_home.origin[:, others[6:]])
    assert np.nanmax(np.abs(there.recording.q - here.q)[:, others]) < 1e-6
    # one rotation has many Euler angles: compare the rotations
    one, other = (joint_rotation(m.skeleton, turns, m.q) for m in (there.recording, here))
    assert np.nanmax(np.abs(one - other)) < 1e-6


@pytest.mark.slow
def test_markers_facing_elsewhere_are_repaired_the_same_by_what_they_show_themselves():
    """To 1e-6 m; by coordinates along the room's axes gaps came out up to 3 mm elsewhere."""
    damaged = _spoilt(_cloud(2.0), noise=0.002, outliers=0.02, gaps=0.1)
    here, there = repair_without_model(damaged), repair_without_model(moved(damaged, 0.7, np.zeros(3)))
    np.testing.assert_array_equal(there.origin, here.origin)
    assert np.nanmax(np.abs(there.recording.positions - moved(here.recording, 0.7, np.zeros(3)).positions)) < 1e-6
    np.testing.assert_allclose(there.std, here.std, rtol=1e-4)


@pytest.mark.slow
@given(st.integers(0, 10**6))
@settings(max_examples=2)
def test_the_order_of_the_models_channels_does_not_matter(seed):
    model, order = joints_model(), np.random.default_rng(seed).permutation(62)
    measured, _ = spoilt(channels_of(truth("walk", seconds=3.0)), 2.0, 0.1, seed)
    measured[20:40, 5] = np.nan
    one = mend(measured, near=False)
    bases = replace(
        model.bases,
        mean=model.bases.mean[:, order],
        vectors=model.bases.vectors[:, :, order],
        discarded=model.bases.discarded[order],
    )
    bends = model.library.usual_bends(FPS)[np.ix_(order, order)]
    two = mend_channels(measured[:, order], Prior(bends, bases), FPS)
    np.testing.assert_allclose(two.found.values, one.found.values[:, order], atol=1e-6)
    np.testing.assert_allclose(two.found.std, one.found.std[:, order], rtol=1e-6)
    np.testing.assert_array_equal(two.found.origin, one.found.origin[:, order])


@pytest.mark.slow
def test_the_order_of_the_recordings_markers_does_not_matter(rng):
    cloud = _spoilt(_cloud(2.0), noise=0.005, outliers=0.05, gaps=0.05)
    order = rng.permutation(len(cloud.names))
    other = Markers(tuple(cloud.names[i] for i in order), cloud.positions[:, order], cloud.fps, up=cloud.up)
    one, two = (half_the_markers_model().repair(one) for one in (cloud, other))
    np.testing.assert_array_equal(two.recording.positions, one.recording.positions[:, order])
    np.testing.assert_array_equal(two.origin, one.origin[:, order])
    np.testing.assert_array_equal(two.std, one.std[:, order])


@pytest.mark.slow
@pytest.mark.parametrize(("noise", "outliers"), [(1.0, 0.1), (3.0, 0.1), (3.0, 0.2)])
def test_backwards_it_is_repaired_alike(noise, outliers):
    """Filters of one direction break the symmetry: to half a deviation, and one label in a hundred."""
    model = joints_model()
    measured, _ = spoilt(channels_of(truth("walk")), noise, outliers)
    bases = replace(model.bases, mean=model.bases.mean[::-1].copy(), vectors=model.bases.vectors[:, ::-1].copy())
    one = mend(measured, near=False)
    two = mend_channels(measured[::-1].copy(), Prior(model.library.usual_bends(FPS), bases), FPS)
    assert rms((two.found.values[::-1] - one.found.values) / one.found.std) < 0.5
    assert (two.found.origin[::-1] != one.found.origin).mean() < 0.01
    np.testing.assert_allclose(two.noise, one.noise, rtol=0.15)


@pytest.mark.slow
def test_what_hides_under_a_missing_sample_has_no_influence(rng):
    """A marker is missing when one coordinate is: the other two, and its residual, say nothing."""
    cloud = _spoilt(_cloud(2.0), noise=0.005)
    gone = cloud.positions.copy()
    gone[30:40, 8] = np.nan
    hidden = cloud.positions.copy()
    hidden[30:40, 8, 1] = np.nan
    hidden[30:40, 8, [0, 2]] = rng.normal(0, 100.0, (10, 2))
    residuals = np.abs(rng.normal(size=gone.shape[:2]))
    one = half_the_markers_model().repair(cloud.with_positions(gone))
    two = half_the_markers_model().repair(replace(cloud.with_positions(hidden), residuals=residuals))
    np.testing.assert_array_equal(one.recording.positions, two.recording.positions)
    np.testing.assert_array_equal(one.origin, two.origin)


@pytest.mark.slow
@pytest.mark.parametrize("noise", [1.0, 3.0])
def test_what_is_repaired_stays_as_it_is(noise):
    walk = truth("walk")
    once = joints_model().repair(_spoilt(walk, noise=np.radians(noise), outliers=0.1))
    twice = joints_model().repair(once.recording)
    assert compare(once.recording, twice.recording).rms_deg < noise / 3
    assert (twice.origin == Origin.REPAIRED).mean() < 0.005


@pytest.mark.slow
@given(st.integers(0, 10**6))
@settings(max_examples=2)
@pytest.mark.parametrize("kind", ["motion", "markers"])
def test_every_sample_is_told_of(kind, seed):
    rng = np.random.default_rng(seed)
    motion = kind == "motion"
    clean, model = (truth("walk", seconds=1.5), joints_model()) if motion else (_cloud(1.5), half_the_markers_model())
    damaged = _spoilt(clean, seed, noise=0.01, outliers=rng.uniform(0, 0.2), gaps=rng.uniform(0, 0.5))
    repaired = model.repair(damaged)
    _said_of_all(repaired)
    lost = (repaired.origin == Origin.FILLED) | (repaired.origin == Origin.LEFT_OPEN)
    np.testing.assert_array_equal(lost, ~damaged.present)


@pytest.mark.slow
@pytest.mark.parametrize("noise", [2.0])
def test_where_blocks_meet_does_not_show(monkeypatch, noise):
    clean = channels_of(truth("walk", seconds=6.0))
    measured, hit = spoilt(clean, noise, 0.1)
    whole = mend(measured)
    monkeypatch.setattr(blocks, "BLOCK", 2.0)
    cut = mend(measured)
    apart = np.abs(cut.found.values - whole.found.values) / whole.found.std
    assert rms(apart) < 0.4
    assert (apart > 1.0).mean() < 0.02
    for edge in (60, 120):
        assert np.median(apart[edge - 1 : edge + 1]) < 0.5
        step = [np.diff(m.found.values, n=2, axis=0)[edge - 2 : edge] for m in (cut, whole)]
        assert rms(step[0]) < 1.5 * rms(step[1]) + 0.1 * noise
    np.testing.assert_allclose(cut.noise, whole.noise, rtol=0.2)
    assert f1(cut.found.origin == Origin.REPAIRED, hit) > 0.9
    assert rms(cut.found.values - clean) < 1.1 * rms(whole.found.values - clean)


@pytest.mark.slow
@pytest.mark.parametrize("frames", [1, 2, 3, 10, 25])
def test_recordings_of_few_frames(frames):
    walk = truth("walk", seconds=3.0)
    short = walk.with_q(walk.q[:frames])
    repaired = joints_model().repair(short)
    _said_of_all(repaired)
    assert compare(short, repaired.recording).rms_deg < 1.0
    cloud = _cloud(3.0).at_frames(slice(0, frames))
    repaired = half_the_markers_model().repair(cloud)
    _said_of_all(repaired)
    assert np.linalg.norm(repaired.recording.positions - cloud.positions, axis=2).max() < 0.05


@pytest.mark.slow
@pytest.mark.parametrize("frames", [1, 2, 3, 30])
@pytest.mark.parametrize("library", [True, False])
def test_few_frames_and_few_channels_need_no_library(rng, frames, library):
    measured = rng.normal(0, 1.0, (frames, 62))
    found = mend(measured, library=library).found
    assert found.values.shape == measured.shape
    assert np.isfinite(found.values).all()
    assert (found.std > 0).all()


@pytest.mark.parametrize("library", [True, False])
@pytest.mark.parametrize("frames", [1, 5, 40, 100])
def test_where_everything_is_missing_everything_stays_open(frames, library):
    found = mend(np.full((frames, 62), np.nan), library=library).found
    assert (found.origin == Origin.LEFT_OPEN).all()
    assert np.isnan(found.values).all()
    assert np.isnan(found.std).all()


@pytest.mark.parametrize("kind", ["motion", "markers"])
def test_a_recording_of_nothing_stays_open(kind):
    walk = truth("walk", seconds=1.0)
    if kind == "motion":
        repaired = joints_model().repair(walk.with_q(np.full(walk.q.shape, np.nan)))
    else:
        cloud = _cloud(1.0)
        repaired = half_the_markers_model().repair(cloud.with_positions(np.full(cloud.positions.shape, np.nan)))
    assert (repaired.origin == Origin.LEFT_OPEN).all()
    assert any("left open" in w for w in repaired.warnings)


@pytest.mark.parametrize("library", [True, False])
def test_channels_that_stand_still_stay(library):
    measured, _ = spoilt(channels_of(truth("walk", seconds=3.0)), 1.0, 0.0)
    measured[:, 11], measured[:, 12] = 3.0, 0.0
    found = mend(measured, library=library).found
    # channels of one recording are taken to be alike in noise, so the neighbours may move them by a part of theirs
    assert np.abs(found.values[:, 11] - 3.0).max() < 0.5
    assert np.abs(found.values[:, 12]).max() < 0.5
    assert (found.origin[:, [11, 12]] == Origin.MEASURED).all()


def test_recordings_that_stand_still_stay():
    still = np.broadcast_to(channels_of(truth("walk"))[10], (60, 62)).copy()
    np.testing.assert_allclose(mend(still).found.values, still, atol=0.05)


def test_a_channel_never_seen_is_filled_from_the_others_or_left_open():
    clean = channels_of(truth("walk"))
    measured, _ = spoilt(clean, 1.0, 0.0)
    measured[:, 30] = np.nan
    told, untold = mend(measured).found, mend(measured, library=False).found
    assert (told.origin[:, 30] == Origin.FILLED).all()
    ratio = (told.values - clean)[:, 30] / told.std[:, 30]
    assert rms(ratio) < 2.5
    assert (untold.origin[:, 30] == Origin.LEFT_OPEN).all()
    others = np.delete(np.arange(62), 30)
    assert rms((told.values - clean)[:, others]) < 0.65
    assert rms((untold.values - clean)[:, others]) < 0.75


@pytest.mark.slow
@pytest.mark.parametrize("length", [1, 5, 30, 120])
def test_gaps_of_any_length_are_filled_as_well_as_they_say(length):
    clean = channels_of(truth("walk"))
    measured, _ = spoilt(clean, 1.0, 0.05)
    columns = [9, 20, 35, 50]
    measured[15 : 15 + length, columns] = np.nan
    found = mend(measured).found
    gap = found.origin[15 : 15 + length, columns]
    assert (gap == Origin.FILLED).all()
    ratio = ((found.values - clean) / found.std)[15 : 15 + length, columns]
    assert rms(ratio) < 2.5


@pytest.mark.slow
@pytest.mark.parametrize("length", [5, 20, 50, 90])
def test_a_stretch_of_nothing_is_bridged_at_its_ends_and_open_within(length):
    measured, _ = spoilt(channels_of(truth("walk")), 1.0, 0.0)
    measured[30 : 30 + length] = np.nan
    found = mend(measured).found
    gap = found.origin[30 : 30 + length]
    near = round(blocks.NEAR * FPS)
    assert (gap[:near] == Origin.FILLED).all()
    assert (gap[-near:] == Origin.FILLED).all()
    assert (gap[near:-near] == Origin.LEFT_OPEN).all()
    rest = np.delete(np.arange(len(measured)), np.arange(30, 30 + length))
    assert (found.origin[rest] < Origin.FILLED).all()


@pytest.mark.slow
def test_markers_are_repaired():
    cloud = _cloud(3.0)
    spoiled = corrupt(cloud, noise=0.005, outliers=0.05, gaps=0.05, seed=3)
    repaired = half_the_markers_model().repair(spoiled.recording)
    _said_of_all(repaired)
    assert f1(repaired.origin == Origin.REPAIRED, spoiled.outlier) > 0.9
    away = repaired.recording.positions - cloud.positions
    seen = ~spoiled.missing
    assert rms(away[seen]) < 0.004
    assert rms(away[spoiled.missing & repaired.recording.present]) < 0.03


@pytest.mark.slow
def test_the_noise_of_a_recording_is_told_in_its_own_unit():
    walk = truth("walk")
    repaired = joints_model().repair(_spoilt(walk, noise=np.radians(2.0), outliers=0.1))
    turns, moves = root_rows(walk.skeleton)
    body = np.setdiff1d(np.arange(62), [*turns, *moves])  # the root's own channels are mixed by its travelling frame
    np.testing.assert_allclose(repaired.noise[body], np.radians(2.0), rtol=0.25)
    cloud = _cloud(5.0)
    repaired = half_the_markers_model().repair(_spoilt(cloud, noise=0.005, outliers=0.05))
    assert np.median(repaired.noise) == pytest.approx(0.005, rel=0.25)


@pytest.mark.slow
def test_the_same_recording_gives_the_same_bytes():
    damaged = _spoilt(truth("walk", seconds=3.0), noise=0.05, outliers=0.1, gaps=0.1)
    one, two = joints_model().repair(damaged), Denoiser(window=20, fps=FPS).fit(clips()).repair(damaged)
    np.testing.assert_array_equal(one.recording.q, two.recording.q)
    np.testing.assert_array_equal(one.std, two.std)


@pytest.mark.slow
def test_real_walks_are_repaired_better_than_by_any_rival(data):
    """A walk of a person known by other walks, at 30 fps, 3 degrees of noise and a tenth outliers."""
    folder = data / "mocap" / "amc" / "16"

    def at_30(name) -> Motion:
        whole = read(folder / f"{name}.amc")
        stride = round(whole.fps / FPS)
        return replace(whole.with_q(whole.q[::stride]), fps=whole.fps / stride)

    model = Denoiser().fit([at_30(f"16_{n}") for n in (15, 16, 21, 22, 31)])
    clean = at_30("16_32").at_frames(slice(0, 60))  # kalman-data takes seconds for as many
    noisy = _spoilt(clean, noise=np.radians(3), outliers=0.1)
    ours = compare(clean, model.repair(noisy).recording).rms_deg
    rivals = {m: compare(clean, model.repair(noisy, m).recording).rms_deg for m in ("kalman-data", "paper")}
    filters = ("gaussian", "butterworth", "kalman")
    rivals |= {m: compare(clean, repair_without_model(noisy, m).recording).rms_deg for m in filters}
    assert ours < min(rivals.values()), (ours, rivals)


@pytest.mark.slow
def test_a_channel_without_any_sample_keeps_no_other_from_repair():
    """Nothing holds it without a library: it stays open."""
    clean = truth("walk", seconds=8.0)
    recording = _spoilt(clean, noise=np.radians(2.0), outliers=0.05, gaps=0.1, seed=0)
    q = recording.q.copy()
    q[:, 20], q[40:80] = np.nan, np.nan
    found = repair_without_model(recording.with_q(q), "adaptive")
    _said_of_all(found)
    assert (found.origin[:, 20] == Origin.LEFT_OPEN).all()
    others = np.delete(np.arange(q.shape[1]), 20)
    assert np.isfinite(found.recording.q[100:][:, others]).mean() > 0.9
