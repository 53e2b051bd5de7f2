"""Laws of the damage: its amount, its masks, its streams."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.bodies.motion import Markers, Motion
from motionmend.bodies.skeleton import ROTATION, TRANSLATION
from motionmend.errors import UsageError
from motionmend.evaluate import corrupt
from motionmend.evaluate.corrupt import OUTLIER_ANGLE, OUTLIER_MARKER, OUTLIER_TRANSLATION
from motionmend.samples import clip, markers

MOTION = clip("walk", seconds=4, seed=1)
MARKERS = markers(MOTION)
RECORDINGS = st.sampled_from([MOTION, MARKERS])
SHARES = st.floats(0.0, 0.6)
SEEDS = st.integers(0, 1000)


def values(recording):
    """(T, C, 1 or 3) the numbers of a recording, a sample in each row."""
    return recording.q[:, :, None] if isinstance(recording, Motion) else recording.positions


@settings(max_examples=20)
@given(RECORDINGS, st.sampled_from([0.0, 0.001, 0.05]), SHARES, SHARES, SEEDS)
def test_masks_say_exactly_what_changed(recording, noise, outliers, gaps, seed):
    spoilt = corrupt(recording, noise=noise, outliers=outliers, gaps=gaps, seed=seed)
    clean, found = values(recording), values(spoilt.recording)
    assert np.array_equal(np.isnan(found).any(axis=2), spoilt.missing)
    assert np.array_equal(spoilt.recording.present, ~spoilt.missing)
    assert not (spoilt.outlier & spoilt.missing).any()
    changed = (found != clean).any(axis=2) & ~spoilt.missing
    assert np.array_equal(changed, (spoilt.outlier | spoilt.noise) & ~spoilt.missing)
    assert spoilt.noise.any() == (noise > 0)


@settings(max_examples=20)
@given(RECORDINGS, SHARES, SHARES, SEEDS)
def test_shares_are_reached(recording, outliers, gaps, seed):
    samples = recording.present.size
    assert corrupt(recording, outliers=outliers, seed=seed).outlier.sum() == round(outliers * samples)
    missing = corrupt(recording, gaps=gaps, seed=seed).missing.sum()
    burst = round(0.1 * recording.fps) * 3  # the last burst is cut, to 0.1 s at the least, for all DOFs of a joint
    assert 0 <= missing - round(gaps * samples) <= burst


@settings(max_examples=10)
@given(RECORDINGS, SEEDS)
def test_one_seed_one_result(recording, seed):
    options = {"noise": 0.02, "outliers": 0.1, "gaps": 0.2, "seed": seed}
    first, second = corrupt(recording, **options), corrupt(recording, **options)
    np.testing.assert_array_equal(values(first.recording), values(second.recording))
    other = corrupt(recording, **{**options, "seed": seed + 1})
    assert not np.array_equal(values(first.recording), values(other.recording), equal_nan=True)


@settings(max_examples=10)
@given(RECORDINGS, SHARES, SHARES, SEEDS)
def test_each_kind_has_its_own_stream(recording, outliers, gaps, seed):
    alone = corrupt(recording, noise=0.02, seed=seed)
    joined = corrupt(recording, noise=0.02, outliers=outliers, gaps=gaps, seed=seed)
    same = ~joined.missing & ~joined.outlier
    np.testing.assert_array_equal(values(joined.recording)[same], values(alone.recording)[same])
    holes = corrupt(recording, gaps=gaps, seed=seed)
    np.testing.assert_array_equal(joined.missing, holes.missing)
    jumps = corrupt(recording, outliers=outliers, seed=seed)
    np.testing.assert_array_equal(joined.outlier, jumps.outlier & ~joined.missing)


def test_noise_of_a_motion_has_the_size_asked_for_and_a_centimetre_per_degree():
    spoilt = corrupt(MOTION, noise=np.radians(2.0), seed=3).recording
    off = spoilt.q - MOTION.q
    turns = MOTION.skeleton.dof_kind == ROTATION
    assert np.degrees(off[:, turns].std()) == pytest.approx(2.0, rel=0.03)
    assert off[:, ~turns].std() == pytest.approx(0.02, rel=0.1)
    assert abs(np.corrcoef(off[1:, turns].ravel(), off[:-1, turns].ravel())[0, 1]) < 0.03


def test_noise_of_markers_is_per_coordinate():
    off = corrupt(MARKERS, noise=0.01, seed=3).recording.positions - MARKERS.positions
    assert off.std() == pytest.approx(0.01, rel=0.02)
    assert abs(np.corrcoef(off[..., 0].ravel(), off[..., 1].ravel())[0, 1]) < 0.03


def test_outliers_of_a_motion_are_as_large_as_said_and_of_either_sign():
    spoilt = corrupt(MOTION, outliers=0.3, seed=5)
    off = spoilt.recording.q - MOTION.q
    for kind, (low, high) in ((ROTATION, OUTLIER_ANGLE), (TRANSLATION, OUTLIER_TRANSLATION)):
        hits = off[:, MOTION.skeleton.dof_kind == kind][spoilt.outlier[:, MOTION.skeleton.dof_kind == kind]]
        assert np.all((np.abs(hits) >= low - 1e-9) & (np.abs(hits) <= high + 1e-9))
        assert np.abs(hits).mean() == pytest.approx((low + high) / 2, rel=0.05)
        assert np.mean(hits > 0) == pytest.approx(0.5, abs=0.05)


def test_outliers_of_markers_go_anywhere():
    spoilt = corrupt(MARKERS, outliers=0.3, seed=5)
    off = (spoilt.recording.positions - MARKERS.positions)[spoilt.outlier]
    length = np.linalg.norm(off, axis=1)
    assert length.min() >= OUTLIER_MARKER[0] - 1e-9
    assert length.max() <= OUTLIER_MARKER[1] + 1e-9
    np.testing.assert_allclose((off / length[:, None]).mean(axis=0), 0.0, atol=0.03)


def test_gaps_come_in_bursts_joint_by_joint_and_never_at_the_root():
    spoilt = corrupt(MOTION, gaps=0.05, seed=2)
    skeleton = MOTION.skeleton
    assert not spoilt.missing[:, skeleton.dofs_of(0)].any()
    lengths = []
    for joint in np.unique(skeleton.dof_joint):
        columns = spoilt.missing[:, skeleton.dofs_of(int(joint))]
        assert (columns == columns[:, :1]).all()
        edges = np.flatnonzero(np.diff(np.concatenate(([0], columns[:, 0].astype(int), [0]))))
        starts, ends = edges[::2], edges[1::2]
        lengths += [int(e - s) for s, e in zip(starts, ends, strict=True) if s > 0 and e < MOTION.frames]
    assert min(lengths) >= round(0.1 * MOTION.fps)
    assert max(lengths) <= round(2.0 * MOTION.fps) * 2  # two bursts may meet


def test_samples_missing_before_stay_missing_and_are_not_hit():
    holed = corrupt(MARKERS, gaps=0.3, seed=9)
    twice = corrupt(holed.recording, noise=0.01, outliers=0.5, gaps=0.1, seed=10)
    assert twice.missing[holed.missing].all()
    assert not twice.outlier[holed.missing].any()
    assert not twice.noise[holed.missing].any()


def test_a_missing_marker_has_residual_minus_one():
    measured = Markers(MARKERS.names, MARKERS.positions, 120.0, residuals=np.full(MARKERS.positions.shape[:2], 0.5))
    spoilt = corrupt(measured, gaps=0.2, drop=["C7"], seed=1)
    np.testing.assert_array_equal(spoilt.recording.residuals, np.where(spoilt.missing, -1.0, 0.5))


@pytest.mark.parametrize(
    ("name", "channels"),
    [("lfemur", {"lfemur.rz", "lfemur.ry", "lfemur.rx"}), ("ltibia.rx", {"ltibia.rx"}), ("root.ty", {"root.ty"})],
)
def test_drop_takes_joints_and_channels(name, channels):
    missing = corrupt(MOTION, drop=[name]).missing
    gone = {c for c, lost in zip(MOTION.channels, missing.all(axis=0), strict=True) if lost}
    assert gone == channels
    assert missing.sum() == len(channels) * MOTION.frames


def test_drop_takes_markers_with_and_without_the_subject():
    named = Markers(tuple(f"Ada:{n}" for n in MARKERS.names), MARKERS.positions, 120.0)
    for name in ("Ada:LFHD", "LFHD"):
        missing = corrupt(named, drop=[name]).missing
        assert missing[:, 0].all()
        assert missing[:, 1:].sum() == 0


@pytest.mark.parametrize("name", ["lfemr", "LFEMUR", "LFemur"])
def test_a_name_that_is_not_there_is_named_with_its_like(name):
    with pytest.raises(UsageError, match=rf"{name}.*lfemur") as caught:
        corrupt(MOTION, drop=[name])
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "wrong", [{"noise": -1.0}, {"noise": np.nan}, {"outliers": 1.5}, {"gaps": -0.1}, {"seed": -1}, {"gaps": 0.99}]
)
def test_amounts_that_make_no_sense_are_refused(wrong):
    with pytest.raises(UsageError):
        corrupt(MOTION, **wrong)


def test_all_markers_can_go():
    assert corrupt(MARKERS, gaps=1.0).missing.all()
