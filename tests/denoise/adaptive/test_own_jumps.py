"""What jumps in a recording by itself, and outliers."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import motionmend as mm
from motionmend.bodies.motion import Origin
from motionmend.bodies.skeleton import ROTATION
from motionmend.denoise.adaptive.own_jumps import channels_beside, channels_that_meet, own_jumps
from performers import truth

SEEDS = st.integers(0, 10**6)
FRAMES, CHANNELS, FPS = 200, 12, 30.0
PAIRS = np.kron(np.eye(CHANNELS // 2, dtype=bool), np.ones((2, 2), dtype=bool)) & ~np.eye(CHANNELS, dtype=bool)


def _moving(rng):
    """(T, C) degrees, and how far a lone sample is off that bends as sharply as the sharpest moment (C,)."""
    t = np.arange(FRAMES)[:, None] / 30.0
    values = 20.0 * np.sin(2.0 * np.pi * t * rng.uniform(0.5, 1.5, CHANNELS) + rng.uniform(0.0, 6.0, CHANNELS))
    return values, 0.5 * np.abs(np.diff(values, n=2, axis=0)).max(axis=0)


def _jumps(rng, values, size, count, paired):
    """Samples off by so much (C,), never two beside each other in a channel: measured, and where."""
    frames = rng.choice(np.arange(2, FRAMES - 2, 3), count, replace=False)
    hit = np.zeros(values.shape, dtype=bool)
    channels = rng.integers(0, CHANNELS, count)
    hit[frames, channels] = True
    if paired:
        hit[frames, channels ^ 1] = True
    return values + np.where(hit, rng.choice([-1.0, 1.0], values.shape) * size, 0.0), hit


@given(SEEDS, st.floats(1.0, 2.0))
@settings(max_examples=20, deadline=None)
def test_so_is_a_lone_one_in_a_take_of_a_few_frames(seed, times):
    rng = np.random.default_rng(seed)
    values = _moving(rng)[0][:14]
    off = times * 0.5 * np.abs(np.diff(values, n=2, axis=0)).max(axis=0)
    hit = np.zeros(values.shape, dtype=bool)
    hit[rng.integers(2, 12), rng.integers(0, CHANNELS)] = True
    np.testing.assert_array_equal(own_jumps(values + hit * off, hit, values, PAIRS, FPS), hit)


@given(SEEDS, st.integers(1, 12), st.floats(1.0, 3.0))
@settings(max_examples=40, deadline=None)
def test_a_few_jumps_hardly_sharper_than_the_motion_are_its_own(seed, count, times):
    rng = np.random.default_rng(seed)
    values, sharpest = _moving(rng)
    measured, hit = _jumps(rng, values, times * sharpest, count, paired=False)
    np.testing.assert_array_equal(own_jumps(measured, hit, values, PAIRS, FPS), hit)


@given(SEEDS, st.integers(6, 40), st.floats(0.5, 80.0))
@settings(max_examples=40, deadline=None)
def test_what_stays_off_by_little_is_its_own_however_long(seed, length, off):
    """As where a solver turns two joints against each other; by much it is a slip."""
    rng = np.random.default_rng(seed)
    values = _moving(rng)[0]
    hit = np.zeros(values.shape, dtype=bool)
    first, channel = rng.integers(2, FRAMES - length - 2), rng.integers(CHANNELS)
    hit[first : first + length, channel] = True
    back = own_jumps(values + off * hit, hit, values, PAIRS, FPS)
    if off < 9.9:
        np.testing.assert_array_equal(back, hit)
    elif off > 40.0 and length > 0.25 * FPS:
        assert not back.any()


@given(SEEDS, st.integers(1, 60), st.floats(40.0, 80.0))
@settings(max_examples=40, deadline=None)
def test_what_lies_anywhere_one_by_one_is_an_outlier(seed, count, off):
    rng = np.random.default_rng(seed)
    values, _ = _moving(rng)
    measured, hit = _jumps(rng, values, np.full(CHANNELS, off), count, paired=False)
    assert not own_jumps(measured, hit, values, PAIRS, FPS).any()


def test_what_two_joints_beside_each_other_leap_alike_is_their_own():
    """Six times as sharp as the motion; but one leap, not two that happen to be as far."""
    beside, found = np.zeros_like(PAIRS), []
    beside[:2, :2] = PAIRS[:2, :2]
    for seed in range(20):
        rng = np.random.default_rng(seed)
        values, sharpest = _moving(rng)
        hit = np.zeros(values.shape, dtype=bool)
        hit[rng.choice(np.arange(2, FRAMES - 2, 3), 2, replace=False), :2] = True
        off = 6.0 * sharpest[:2].max() * hit
        against = off * np.where(np.arange(CHANNELS) == 1, -1.0, 1.0)
        ways = ((off, beside), (off, None), (against, beside), (against, None))
        backs = [own_jumps(values + by, hit, values, np.zeros_like(PAIRS), FPS, which) for by, which in ways]
        np.testing.assert_array_equal(backs[2], backs[3])
        found.append([back[hit].mean() for back in backs])
    alike, unheard, *_ = np.mean(found, axis=0)
    assert alike > 0.8
    assert unheard < 0.2


TRIPLES = np.kron(np.eye(CHANNELS // 3, dtype=bool), np.ones((3, 3), dtype=bool)) & ~np.eye(CHANNELS, dtype=bool)


@given(SEEDS, st.integers(12, 30))
@settings(max_examples=40, deadline=None)
def test_a_joint_that_is_wrong_as_a_whole_is_an_outlier_if_that_happens_again(seed, count):
    """All angles of a joint in one frame: nothing here comes alone, and for all that it is no jump of its own."""
    rng = np.random.default_rng(seed)
    values, sharpest = _moving(rng)
    hit = np.zeros(values.shape, dtype=bool)
    frames = rng.choice(np.arange(2, FRAMES - 2, 3), count, replace=False)
    for frame, joint in zip(frames, rng.integers(0, CHANNELS // 3, count), strict=True):
        hit[frame, 3 * joint : 3 * joint + 3] = True
    off = sharpest * rng.uniform(15.0, 25.0, hit.shape) * rng.choice((-1.0, 1.0), hit.shape)
    assert not own_jumps(values + hit * off, hit, values, TRIPLES, FPS).any()


@given(SEEDS, st.integers(3, 6))
@settings(max_examples=20, deadline=None)
def test_a_joint_that_passes_to_other_angles_for_a_moment_does_so_itself(seed, length):
    """One way of turning for another: far, but of several frames on end, and only once."""
    rng = np.random.default_rng(seed)
    values, sharpest = _moving(rng)
    hit = np.zeros(values.shape, dtype=bool)
    hit[90 : 90 + length, 3:5] = True
    assert own_jumps(values + hit * 8.0 * sharpest, hit, values, TRIPLES, FPS)[hit].all()


@given(SEEDS)
@settings(max_examples=40, deadline=None)
def test_among_many_outliers_one_more_is_likelier_one_unless_it_goes_with_another(seed):
    rng = np.random.default_rng(seed)
    values, sharpest = _moving(rng)
    measured, hit = _jumps(rng, values, np.full(CHANNELS, 50.0), 20, paired=False)
    # one by one: what follows within a moment is a burst
    near = np.append(np.flatnonzero(hit[:, 4:6].any(axis=1)), -FRAMES)
    apart = np.abs(np.arange(FRAMES)[:, None] - near).min(axis=1) > 8
    free = np.flatnonzero(~hit.any(axis=1) & apart & (np.arange(FRAMES) % 20 == 10))
    for partners, wanted in (((4,), False), ((4, 5), True)):
        here, where = measured.copy(), hit.copy()
        for frame in free[:4]:
            where[frame, partners] = True
            here[frame, partners] += 8.0 * sharpest[list(partners)]
        back = own_jumps(here, where, values, PAIRS, FPS)
        assert not back[hit].any()
        assert (back[where & ~hit] == wanted).all()


@given(SEEDS, st.permutations(range(CHANNELS)))
@settings(max_examples=20, deadline=None)
def test_the_order_of_the_channels_does_not_matter(seed, order):
    rng = np.random.default_rng(seed)
    values, sharpest = _moving(rng)
    measured, hit = _jumps(rng, values, 5.0 * sharpest, 15, paired=True)
    found = own_jumps(measured, hit, values, PAIRS, FPS)
    other = own_jumps(measured[:, order], hit[:, order], values[:, order], PAIRS[np.ix_(order, order)], FPS)
    np.testing.assert_array_equal(other, found[:, order])


@pytest.mark.slow
def test_a_burst_in_linked_channels_is_no_jump_of_its_own():
    """Channels of joints that meet jump together where a limb is lost, too, but then for more than a moment."""
    shares = []
    for seed in range(100):
        rng = np.random.default_rng(seed)
        values, sharpest = _moving(rng)
        length = int(rng.integers(12, 41))
        hit = np.zeros(values.shape, dtype=bool)
        hit[80 : 80 + length, 4:6] = rng.random((length, 2)) < 0.8
        measured = values + np.where(hit, rng.choice([-1.0, 1.0], values.shape) * 6.0 * sharpest, 0.0)
        shares.append(own_jumps(measured, hit, values, PAIRS, FPS).mean(where=hit))
    assert np.mean(shares) < 0.02
    assert np.percentile(shares, 95) < 0.1


@given(SEEDS, st.integers(5, CHANNELS), st.integers(1, 8), st.floats(1.0, 4.0))
@settings(max_examples=40, deadline=None)
def test_what_a_whole_limb_does_at_once_is_no_jump_of_its_own(seed, limb, length, times):
    """Of a chain of joints that meet, however short it is and hardly sharper than the motion."""
    rng = np.random.default_rng(seed)
    values, sharpest = _moving(rng)
    chain = np.abs(np.subtract.outer(np.arange(CHANNELS), np.arange(CHANNELS))) == 1
    lost = np.zeros(values.shape, dtype=bool)
    lost[80 : 80 + length, :limb] = True
    few = np.zeros(values.shape, dtype=bool)
    few[40, :2] = True
    measured = values + (lost | few) * times * sharpest
    np.testing.assert_array_equal(own_jumps(measured, lost | few, values, chain, FPS), few)


@pytest.mark.slow
@pytest.mark.parametrize("fps", [30, 120])
@pytest.mark.parametrize("length", [1, 3])
def test_an_arm_that_is_off_for_a_moment_is_put_right(data, fps, length):
    whole = mm.read(data / "mocap" / "amc" / "07" / "07_05.amc")
    clean = mm.Motion(whole.skeleton, whole.q[:: round(whole.fps / fps)][:240], float(fps))
    arm = [k for k, name in enumerate(clean.channels) if name.startswith(("lhumerus", "lradius", "lwrist", "lhand"))]
    rng = np.random.default_rng(3)
    q, hit = clean.q + np.radians(1.0) * rng.standard_normal(clean.q.shape), np.zeros(clean.q.shape, dtype=bool)
    for first in rng.choice(np.arange(8, clean.frames - 12, 9), 3, replace=False):
        q[first : first + length, arm] += np.radians(rng.uniform(15.0, 55.0, len(arm)) * rng.choice((-1, 1), len(arm)))
        hit[first : first + length, arm] = True
    outcome = mm.repair_without_model(clean.with_q(q))
    assert (outcome.origin[hit] == Origin.REPAIRED).mean() > 0.95
    assert np.degrees(np.sqrt(np.mean(np.square(outcome.recording.q - clean.q)[hit]))) < 4.0


@pytest.mark.slow
@pytest.mark.parametrize(("clip", "fps"), [("07/07_09", 120), ("14/14_33", 30), ("135/135_07", 30)])
def test_joints_that_are_off_as_a_whole_for_a_frame_are_put_right(data, clip, fps):
    """One in two hundred samples of a joint, all its angles at once: what a wrong marker does to a solver."""
    whole = mm.read(data / "mocap" / "amc" / f"{clip}.amc")
    clean = mm.Motion(whole.skeleton, whole.q[:: round(whole.fps / fps)][:240], float(fps))
    rng = np.random.default_rng(5)
    q, hit = clean.q + np.radians(0.3) * rng.standard_normal(clean.q.shape), np.zeros(clean.q.shape, dtype=bool)
    for joint in range(1, len(clean.skeleton.names)):
        rows = clean.skeleton.dofs_of(joint)
        frames = np.flatnonzero(rng.random(clean.frames) < 0.005)
        off = np.radians(
            rng.uniform(15.0, 45.0, (len(frames), len(rows))) * rng.choice((-1, 1), (len(frames), len(rows)))
        )
        q[np.ix_(frames, rows)] += off
        hit[np.ix_(frames, rows)] = True
    outcome = mm.repair_without_model(clean.with_q(q))
    several = np.array([len(clean.skeleton.dofs_of(joint)) > 1 for joint in clean.skeleton.dof_joint])
    assert (outcome.origin[:, several][hit[:, several]] == Origin.REPAIRED).mean() > 0.9


def test_zeros_that_are_written_for_what_is_not_known_are_never_its_own(rng):
    values, sharpest = _moving(rng)
    measured, hit = _jumps(rng, values + 5.0, sharpest, 6, paired=True)
    assert own_jumps(measured, hit, values + 5.0, PAIRS, FPS)[hit].all()
    assert not own_jumps(np.where(hit, 0.0, measured), hit, values + 5.0, PAIRS, FPS).any()
    assert not own_jumps(measured, np.zeros_like(hit), values + 5.0, PAIRS, FPS).any()


def test_in_a_few_frames_no_end_is_the_wrong_one():
    """A knee that leaves its limit in the middle of a take of eight frames."""
    measured = np.array([[5.0, 5.1, 5.2, 5.3, 18.7, 31.2, 44.2, 56.3]]).T
    outlier = measured > 10.0
    values = np.where(outlier, 5.0, measured)
    assert own_jumps(measured, outlier, values, np.zeros((1, 1), dtype=bool), 30.0)[outlier].all()
    alone = np.zeros_like(outlier)
    alone[7] = True
    assert not own_jumps(measured, alone, values, np.zeros((1, 1), dtype=bool), 30.0).any()


def test_channels_of_a_joint_and_of_its_parent_and_children_meet():
    skeleton = truth().skeleton
    columns = np.append(np.arange(len(skeleton.dof_names)), -1)
    met = channels_that_meet(skeleton, columns)
    for c, row in enumerate(columns[:-1]):
        for other, to in enumerate(columns[:-1]):
            one, two = skeleton.dof_joint[row], skeleton.dof_joint[to]
            assert met[c, other] == (
                c != other and (one == two or skeleton.parents[one] == two or skeleton.parents[two] == one)
            )
    assert not met[-1].any()
    assert not met[:, -1].any()


def test_angles_of_joints_that_hang_on_one_are_beside_each_other():
    skeleton = truth().skeleton
    columns = np.append(np.arange(len(skeleton.dof_names)), -1)
    beside = channels_beside(skeleton, columns)
    one, other = np.nonzero(beside)
    assert len(one)
    np.testing.assert_array_equal(beside, beside.T)
    joint = skeleton.dof_joint
    assert (joint[one] != joint[other]).all()
    np.testing.assert_array_equal(skeleton.parents[joint[one]], skeleton.parents[joint[other]])
    assert (skeleton.dof_kind[np.stack([one, other])] == ROTATION).all()
    assert not beside[-1].any()


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_a_few_outliers_in_a_clean_recording_are_all_found(seed):
    clean = truth("run", seconds=8.0)
    bad = mm.corrupt(clean, outliers=0.0005, seed=seed)
    found = mm.repair_without_model(bad.recording, "adaptive").origin == Origin.REPAIRED
    joints = (clean.skeleton.dof_kind == ROTATION) & (clean.skeleton.dof_joint > 0)
    assert (bad.outlier & joints).sum() >= 3
    assert found[bad.outlier & joints].mean() > 0.9


@pytest.mark.slow
@pytest.mark.parametrize(("clip", "fps"), [("07/07_01", 30), ("05/05_14", 30), ("05/05_13", 30), ("16/16_17", 120)])
def test_real_clean_clips_with_jumps_of_their_own_are_left_alone(data, clip, fps):
    whole = mm.read(data / "mocap" / "amc" / f"{clip}.amc")
    first = max(0, whole.frames // 2 - 480)
    clean = mm.Motion(whole.skeleton, whole.q[first : first + 960 : round(whole.fps / fps)], float(fps))
    outcome = mm.repair_without_model(clean, "adaptive")
    joints = (clean.skeleton.dof_kind == ROTATION) & (clean.skeleton.dof_joint > 0)
    fingers = np.array([any(part in name for part in ("hand", "finger", "thumb", "toe")) for name in clean.channels])
    away = np.degrees(outcome.recording.q - clean.q)[:, joints & ~fingers]
    assert np.sqrt(np.mean(np.square(away))) < 0.3


@pytest.mark.slow
def test_what_is_left_as_its_own_leap_is_said_and_where():
    clean = truth("walk", seconds=8.0)
    channel = clean.channels[np.flatnonzero(clean.skeleton.dof_joint == 3)[0]]
    q = clean.q.copy()
    q[[40, 120, 190], clean.channels.index(channel)] += np.radians(8.0)
    outcome = mm.repair_without_model(clean.with_q(q))
    left = np.degrees(np.abs(outcome.recording.q - q))[[40, 120, 190], clean.channels.index(channel)] < 0.5
    said = [warning for warning in outcome.warnings if "leap like outliers" in warning]
    assert len(said) == int(left.any())
    assert all(f"{channel} ({left.sum()})" in sentence for sentence in said)
    noisy = mm.corrupt(clean, noise=np.radians(2.0), outliers=0.05, seed=1).recording
    assert not any("leap like" in warning for warning in mm.repair_without_model(noisy).warnings)
