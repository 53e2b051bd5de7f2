"""A library that misses a recording, and what the recording shows of itself."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend import Denoiser, Markers, corrupt, read, repair_without_model
from motionmend.bodies.motion import Origin
from motionmend.denoise.adaptive.blocks import Mended
from motionmend.denoise.adaptive.second_opinion import REACH, SAID, of_one_cloud, of_one_mind
from motionmend.denoise.bases.repair import ChannelRepair
from motionmend.denoise.bases.support import RARE
from performers import FPS, every_other, joints_model, truth

SEEDS = st.integers(0, 10**6)
ONES, NONE = np.ones(2), np.zeros(2)


def _mended(rng, origin, missed=9.0):
    shape = origin.shape
    spread, weights = rng.uniform(0.5, 2, shape), rng.random(shape)
    said = ("Missed",)
    found = ChannelRepair(rng.normal(0, 10, shape), spread, weights, origin, 3, np.empty(0), True, said)
    none = np.zeros(shape[1])
    return Mended(found, rng.uniform(1, 2, shape[1]), none, missed, none.astype(int), none, np.empty((0, shape[1])))


def _two(seed):
    rng = np.random.default_rng(seed)
    filled = rng.random((40, 3)) < 0.3
    filled[:, 2] |= seed % 2 == 0
    kinds = (np.where(rng.random((40, 3)) < 0.1, Origin.REPAIRED, Origin.MEASURED) for _ in range(2))
    one, other = (_mended(rng, np.where(filled, Origin.FILLED, kind).astype(np.uint8)) for kind in kinds)
    return one, other, filled


def _joined(one, other):
    """Both as one; the first is given up, so a copy is."""
    mine = replace(one.found, **{n: getattr(one.found, n).copy() for n in ("values", "std", "weights", "origin")})
    return of_one_mind(replace(one, found=mine), other)


def _on_end(samples, c):
    """Those of a channel's samples that have another of them beside them."""
    one = samples[:, c]
    return np.array([one[t] and one[max(t - 1, 0) : t + 2].sum() > 1 for t in range(len(one))])


@given(SEEDS)
@settings(max_examples=25, deadline=None)
def test_one_mind_lies_between_nearer_to_the_surer_and_is_as_unsure_as_the_two_are_at_odds(seed):
    one, other, filled = _two(seed)
    found = _joined(one, other).found
    a, b = one.found, other.found
    for c in range(3):
        seen = ~filled[:, c]
        if not seen.any():
            continue
        apart, way = (b.values - a.values)[seen, c], (found.values - a.values)[seen, c]
        strays = _on_end((a.origin == Origin.REPAIRED) & (b.origin == Origin.MEASURED), c)[seen]
        share = way[~strays] @ apart[~strays] / (apart[~strays] @ apart[~strays])
        rate = (b.origin == Origin.REPAIRED).sum() / (b.origin <= Origin.REPAIRED).sum()
        share = np.where(strays, 1.0 - rate / (rate + RARE) * (1.0 - share), share)
        np.testing.assert_allclose(way, share * apart, atol=1e-9)
        surer = np.square(a.std[seen, c]).mean() - np.square(b.std[seen, c]).mean()
        told = 0.5 + np.clip(0.5 * surer / np.square(apart).mean(), -0.5, 0.5)
        np.testing.assert_allclose(share[~strays], told, atol=1e-9)
        between = np.minimum(share, 1 - share) * np.abs(apart)
        assert (found.std[seen, c] >= between - 1e-6).all()
    assert (found.std >= np.minimum(a.std, b.std) - 1e-6)[~filled].all()
    np.testing.assert_array_equal(found.origin, np.where(filled, a.origin, b.origin))
    assert np.isfinite(found.values).all()
    assert found.warnings == ("Missed" + SAID,)


def test_what_only_the_library_rejects_on_end_stays_as_measured_where_outliers_are_rare():
    """A library that strays takes a stretch for outliers; one that finds a lone outlier is as right as the other."""
    shape, stretch = (400, 2), slice(100, 108)
    measured, spread = np.zeros(shape), np.ones(shape)
    strayed, origin = measured.copy(), np.full(shape, Origin.MEASURED, np.uint8)
    strayed[stretch, 0], origin[stretch, 0] = 25.0, Origin.REPAIRED
    strayed[200, 0], origin[200, 0] = 25.0, Origin.REPAIRED
    rare, common = np.full(shape, Origin.MEASURED, np.uint8), np.full(shape, Origin.MEASURED, np.uint8)
    common[300:, 1] = Origin.REPAIRED
    moved = []
    for its in (rare, common):
        one, other = (
            Mended(
                ChannelRepair(v, spread, spread, o, 3, np.empty(0), True),
                ONES,
                NONE,
                9.0,
                NONE.astype(int),
                NONE,
                np.empty((0, len(NONE))),
            )
            for v, o in ((strayed, origin), (measured, its))
        )
        moved.append(_joined(one, other).found.values[:, 0])
    np.testing.assert_allclose(moved[0][stretch], 0.0, atol=1e-9)
    assert moved[0][200] == pytest.approx(12.5)
    assert (moved[1][stretch] > 8.0).all()  # outliers that are common come side by side too


@given(SEEDS)
@settings(max_examples=25, deadline=None)
def test_two_that_agree_are_left_as_they_are(seed):
    one, _, _ = _two(seed)
    found = _joined(one, one)
    np.testing.assert_array_equal(found.found.values, one.found.values)
    np.testing.assert_allclose(found.found.std, one.found.std)
    np.testing.assert_allclose(found.noise, one.noise)


@given(SEEDS)
@settings(max_examples=25, deadline=None)
def test_gaps_are_the_librarys_shifted_by_what_is_found_at_their_edges(seed):
    one, other, filled = _two(seed)
    shift = np.arange(3.0) - 1.0
    other = replace(other, found=replace(one.found, values=one.found.values + shift))
    found = _joined(one, other).found.values - one.found.values
    seen_at_all = ~filled.all(axis=0)
    np.testing.assert_allclose(found, np.broadcast_to(np.where(seen_at_all, 0.5 * shift, 0.0), found.shape), atol=1e-12)


@given(SEEDS)
@settings(max_examples=25, deadline=None)
def test_in_gaps_both_meet_at_the_edges_and_the_surer_counts_for_more(seed):
    rng = np.random.default_rng(seed)
    kind = np.full((40, 2), Origin.MEASURED, np.uint8)
    kind[12:25, 0], kind[:, 1] = Origin.FILLED, Origin.FILLED
    one, other = (_mended(rng, kind) for _ in range(2))
    a, b, found = one.found, other.found, _joined(one, other).found
    gap, inside = kind[:, 0] == Origin.FILLED, np.linspace(0, 1, 15)[1:-1]

    def line(values):
        return values[11] + inside * (values[25] - values[11])

    from_edges = [x[12:25, 0] - line(x[:, 0]) for x in (a.values, b.values, found.values)]
    share = a.std[gap, 0] / (a.std[gap, 0] + b.std[gap, 0])
    np.testing.assert_allclose(from_edges[2], (1 - share) * from_edges[0] + share * from_edges[1], atol=1e-9)
    least = np.minimum(a.std, b.std)[gap, 0]
    assert (
        found.std[gap, 0] >= np.hypot(least, np.sqrt(share * (1 - share)) * (from_edges[1] - from_edges[0])) - 1e-6
    ).all()
    for name in ("values", "std"):  # nothing but the library tells of what is never seen
        np.testing.assert_allclose(getattr(found, name)[:, 1], getattr(a, name)[:, 1])


def _rows(motion, joint):
    return [d for d, name in enumerate(motion.skeleton.dof_names) if name.startswith(joint + ".")]


@pytest.mark.slow
def test_a_leg_that_stands_is_not_filled_by_what_a_library_of_walks_does():
    there = truth("reach").at_frames(slice(0, 100))
    wrong = []
    for starts in ((20, 70), (45, 20), (70, 45)):  # of a gap of the thigh and one of the shank, which do not meet
        q, gaps = there.q.copy(), np.zeros(there.q.shape, dtype=bool)
        for joint, start in zip(("lfemur", "ltibia"), starts, strict=True):
            gaps[start : start + 20, _rows(there, joint)] = True
        q[gaps] = np.nan
        found = joints_model().repair(there.with_q(q))
        assert any(said.endswith(SAID) for said in found.warnings)
        for joint in ("lfemur", "ltibia"):
            rows = _rows(there, joint)
            wrong.append(np.square(found.recording.q - there.q)[:, rows][gaps[:, rows]].mean())
    assert np.degrees(np.sqrt(np.mean(wrong))) < 0.3  # by the library 0.6, by the recording alone 0.1


@pytest.mark.slow
@pytest.mark.parametrize(("action", "outliers"), [("jump", 0.0), ("run", 0.1)])
def test_motions_that_the_library_does_not_know_are_no_worse_for_it(action, outliers):
    clean = truth(action)
    spoilt = corrupt(clean, noise=np.radians(2.0), outliers=outliers, seed=3).recording
    found = joints_model().repair(spoilt)
    alone = repair_without_model(spoilt, "adaptive")
    assert any("misses this recording" in said and said.endswith(SAID) for said in found.warnings)
    angles = clean.skeleton.dof_kind == 0

    def error(outcome):
        away = (outcome.recording.q - clean.q)[:, angles]
        return np.sqrt(np.mean(np.square((away + np.pi) % (2 * np.pi) - np.pi)))

    assert clean.fps == FPS
    assert error(found) < 1.1 * error(alone)


@pytest.mark.slow
def test_what_the_library_knows_needs_no_second_opinion():
    found = joints_model().repair(corrupt(truth("walk"), noise=np.radians(2.0), seed=3).recording)
    assert not any("misses" in said for said in found.warnings)


def _copied(mended):
    """The first of two is given up, so a copy is."""
    arrays = {n: getattr(mended.found, n).copy() for n in ("values", "std", "weights", "origin")}
    return replace(mended, found=replace(mended.found, **arrays))


def _repair_of(values, std, origin, noise):
    found = ChannelRepair(values, np.full(values.shape, std), origin == Origin.MEASURED, origin, 3, np.empty(0), True)
    none = np.zeros(values.shape[1])
    return Mended(
        replace(found, warnings=("Missed",)), none + noise, none, 9.0, none.astype(np.int64), none, values[:0]
    )


def _two_of_markers(seed, bias=0.0, frames=300, noise=1.0):
    """A library's repair and the recording's own of six markers' coordinates; truth and measured."""
    rng = np.random.default_rng(seed)
    clean = 30.0 * np.sin(np.linspace(0, 6, frames)[:, None] + rng.uniform(0, 6, 6))
    measured = clean + noise * rng.standard_normal(clean.shape)
    measured[rng.random((frames, 2)).repeat(3, axis=1) < 0.1] = np.nan
    kind = np.where(np.isfinite(measured), Origin.MEASURED, Origin.FILLED).astype(np.uint8)
    one = _repair_of(clean + bias + 0.3 * rng.standard_normal(clean.shape), 0.3, kind, noise)
    other = _repair_of(clean + 0.3 * rng.standard_normal(clean.shape), 0.3, kind.copy(), noise)
    return one, other, measured, clean


@given(SEEDS)
@settings(max_examples=25, deadline=None)
def test_one_cloud_lies_between_both_and_what_is_missing_is_the_librarys(seed):
    one, other, measured, _ = _two_of_markers(seed, bias=1.0)
    found = of_one_cloud(_copied(one), other, measured, FPS).found
    seen = np.isfinite(measured)
    for c in range(6):
        apart, way = (x[seen[:, c], c] - one.found.values[seen[:, c], c] for x in (other.found.values, found.values))
        share = way @ apart / (apart @ apart)
        assert 0.0 <= share <= 1.0
        np.testing.assert_allclose(way, share * apart, atol=1e-9)
    np.testing.assert_array_equal(found.values[~seen], one.found.values[~seen])
    np.testing.assert_array_equal(found.std[~seen], one.found.std[~seen])
    assert (found.std[seen] >= 0.3 - 1e-9).all()
    assert found.warnings == ("Missed" + SAID,)
    alike = of_one_cloud(_copied(other), other, measured, FPS).found
    np.testing.assert_array_equal(alike.values, other.found.values)
    np.testing.assert_allclose(alike.std, other.found.std)


@given(SEEDS, st.floats(0.0, 5.0))
@settings(max_examples=25, deadline=None)
def test_a_library_that_is_more_wrong_than_it_says_is_left_behind(seed, bias):
    one, other, measured, clean = _two_of_markers(seed, bias)
    seen = np.isfinite(measured)

    def error(mended):
        return np.sqrt(np.square(mended.found.values - clean)[seen].mean())

    assert error(of_one_cloud(_copied(one), other, measured, FPS)) <= 1.05 * error(other)


@given(SEEDS, st.integers(1, 3))
@settings(max_examples=25, deadline=None)
def test_who_believes_a_sample_alone_is_wrong_unless_the_library_rejects_several_on_end(seed, run):
    one, other, measured, _ = _two_of_markers(seed)
    measured[100:200] = 0.0
    for mended in (one, other):
        mended.found.origin[100:200] = Origin.MEASURED
    one.found.origin[150 : 150 + run, :3] = Origin.REPAIRED
    other.found.origin[150, 3:] = Origin.REPAIRED
    found = of_one_cloud(_copied(one), other, measured, FPS).found
    reach = round(REACH * FPS)
    near = slice(150 - reach, 150 + run + reach)
    of_library = one.found if run == 1 else other.found
    np.testing.assert_allclose(found.values[near, :3], of_library.values[near, :3], atol=1e-9)
    assert (found.origin[150 : 150 + run, 0] == of_library.origin[150 : 150 + run, 0]).all()
    near = slice(150 - reach, 151 + reach)
    np.testing.assert_allclose(found.values[near, 3:], other.found.values[near, 3:], atol=1e-9)
    assert (found.origin[150, 3:] == Origin.REPAIRED).all()


def _part(data, name, first, last):
    """Some frames of a real recording of markers, by their bare names."""
    whole = read(data / "mocap" / "c3d" / f"{name}.c3d")
    assert isinstance(whole, Markers)
    names = [n.rpartition(":")[2] for n in whole.names]
    return Markers(names, whole.positions[first:last], whole.fps, up=whole.up)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("recorded", "library", "noise", "outliers"),
    [
        (("hdm05_bd_05-01_01_120", 3000, 3120), ("cmu_05_13", 0, 400), 0.001, 0.0),
        (("sfu_0005_SideSkip001", 0, 120), ("gt_squat", 0, 400), 0.01, 0.1),
    ],
)
def test_real_markers_are_no_worse_for_a_library_of_another_person_and_motion(data, recorded, library, noise, outliers):
    clean = every_other(_part(data, *recorded))
    spoilt = corrupt(clean, noise=noise, outliers=outliers, seed=4).recording
    found = Denoiser().fit([every_other(_part(data, *library))]).repair(spoilt)
    alone = repair_without_model(spoilt, "adaptive")
    assert any("misses this recording" in said and said.endswith(SAID) for said in found.warnings)

    def error(outcome):
        return np.sqrt(np.nanmean(np.square(outcome.recording.positions - clean.positions)[clean.present]))

    assert error(found) < 1.05 * error(alone)


@cache
def _own_patterns():
    """A walk with a gap of a shank and one of an arm that do not meet, three times: gaps, errors, deviations."""
    there, each = truth("walk", seconds=4.0, fps=60.0), []
    for starts in ((40, 90), (90, 150), (150, 40)):
        gaps = {joint: slice(start, start + 48) for joint, start in zip(("ltibia", "rhumerus"), starts, strict=True)}
        q = there.q.copy()
        for joint, gap in gaps.items():
            q[gap, _rows(there, joint)] = np.nan
        found = repair_without_model(there.with_q(q))
        each.append((gaps, found.recording.q - there.q, found.std))
    return each


@pytest.mark.slow
@pytest.mark.parametrize("joint", ["ltibia", "rhumerus"])
def test_gaps_filled_by_a_recordings_own_patterns_are_as_unsure_as_they_are_wrong(joint):
    """The patterns know of a gap what a first repair put there: elsewhere they know the truth."""
    rows = _rows(truth("walk", seconds=4.0, fps=60.0), joint)
    wrong, told = [], []
    for gaps, away, std in _own_patterns():
        wrong.append(np.square(away)[gaps[joint], rows].mean())
        told.append(np.square(std[gaps[joint], rows]).mean())
    assert np.sqrt(np.mean(wrong) / np.mean(told)) < 1.3
