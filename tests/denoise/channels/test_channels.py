"""Laws of the channels: exact way back, no place, no heading, no jumps."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from motionmend.bodies.motion import Markers, Motion
from motionmend.denoise.channels.branches import nearest_triple, nearest_turn, steady_triple, steady_turn
from motionmend.denoise.channels.cloud import main_heading
from motionmend.denoise.channels.layout import along_main_heading, learn_layout, own_layout
from motionmend.denoise.channels.recording import from_channels, to_channels
from motionmend.denoise.channels.travel import travel
from motionmend.errors import MismatchError
from motionmend.io import read
from motionmend.samples import clip, markers
from performers import moved

ANGLES = st.floats(-400, 400)


@pytest.fixture(scope="module")
def walk() -> Motion:
    return clip("walk", seconds=2.0, fps=60.0, seed=1)


def recordings():
    motion = clip("turn", seconds=2.0, fps=60.0, seed=2)
    return [motion, markers(motion)]


@pytest.mark.parametrize("recording", recordings(), ids=["motion", "markers"])
def test_the_way_there_and_back_is_exact(recording):
    layout = learn_layout([recording])
    channels = to_channels(recording, layout)
    back = from_channels(channels, channels.values, np.isfinite(channels.values), recording)
    values = recording.q if isinstance(recording, Motion) else recording.positions
    np.testing.assert_allclose(back, values, atol=1e-10)


def test_what_comes_back_but_for_rounding_is_what_was_recorded(walk):
    q = np.array(walk.q)
    q[:, 20] = 0.0
    channels = to_channels(walk.with_q(q), learn_layout([walk]))
    back = from_channels(channels, channels.values + 1e-13, np.isfinite(channels.values), walk.with_q(q))
    np.testing.assert_array_equal(back, q)


@pytest.mark.slow
@pytest.mark.parametrize("recording", recordings(), ids=["motion", "markers"])
@given(angle=st.floats(-6, 6), x=st.floats(-20, 20), y=st.floats(-20, 20))
@settings(max_examples=8)
def test_channels_do_not_change_with_place_and_heading(recording, angle, x, y):
    layout = learn_layout([recording])
    here = to_channels(recording, layout).values
    there = to_channels(moved(recording, angle, np.array([x, 1.0, y])), layout).values
    np.testing.assert_allclose(there, here, atol=1e-5)


@given(angle=ANGLES, line=st.floats(-1.5, 1.5))
def test_the_way_that_markers_go_is_found_and_turns_with_them(angle, line):
    rng = np.random.default_rng(1)
    up = np.array([0.0, 1.0, 0.0])
    steps = rng.standard_normal((60, 4, 1)) * np.array([np.cos(line), 0.0, -np.sin(line)])  # to and fro along one line
    steps += 0.05 * rng.standard_normal(steps.shape) + np.array([0.0, 3.0, 0.0]) * rng.standard_normal((60, 4, 1))
    steps[rng.random((60, 4)) < 0.2] = np.nan
    positions = np.cumsum(np.nan_to_num(steps), axis=0)
    start = main_heading(np.zeros((2, 1, 3)) + np.array([[[0.0, 0, 0]], [[1.0, 0, 0]]]), up)
    turned = positions @ Rotation.from_rotvec(np.radians(angle) * up).as_matrix().T
    for way, wanted in ((positions, line), (turned, line + np.radians(angle))):
        off = np.angle(np.exp(2j * (main_heading(way, up) - start - wanted))) / 2  # to and fro are one
        assert abs(off) < 0.02


def test_a_recording_of_itself_has_the_same_channels_facing_elsewhere():
    recording = markers(clip("walk", seconds=1.0, fps=30.0, seed=2))
    turned = moved(recording, 0.7, np.zeros(3))
    here, there = (to_channels(one, along_main_heading(own_layout(one), one)) for one in (recording, turned))
    np.testing.assert_allclose(there.values, here.values, atol=1e-8)
    back = from_channels(there, there.values, np.isfinite(there.values), turned)
    np.testing.assert_array_equal(back, turned.positions)  # what was recorded, not all but for rounding


def test_markers_keep_their_frame_when_pelvis_markers_are_missing():
    recording = markers(clip("walk", seconds=2.0, fps=60.0, seed=3))
    layout = learn_layout([recording])
    gone = recording.positions.copy()
    lost = list(layout.anchors.indices[:2])
    gone[20:60, lost] = np.nan
    whole = to_channels(recording, layout).values.reshape(recording.frames, -1, 3)
    without = to_channels(recording.with_positions(gone), layout).values.reshape(recording.frames, -1, 3)
    others = np.setdiff1d(np.arange(len(recording.names)), lost)
    assert np.abs(without[:, others] - whole[:, others]).max() < 1.5  # cm


def test_markers_keep_their_frame_when_anchors_are_outliers(rng):
    recording = markers(clip("walk", seconds=2.0, fps=60.0, seed=3))
    layout = learn_layout([recording])
    spoiled = recording.positions.copy()
    hit = rng.random(spoiled.shape[:2]) < 0.1
    spoiled[hit] += rng.normal(scale=0.3, size=(int(hit.sum()), 3))
    whole = to_channels(recording, layout).values.reshape(recording.frames, -1, 3)
    after = to_channels(recording.with_positions(spoiled), layout).values.reshape(recording.frames, -1, 3)
    assert np.abs((after - whole)[~hit]).max() < 3.0  # cm, of markers that were not touched


@given(st.lists(ANGLES, min_size=3, max_size=3), st.lists(ANGLES, min_size=3, max_size=3))
def test_the_nearest_triple_means_the_same_rotation(angles, meant):
    found = nearest_triple(np.array([angles]), np.array([meant]))[0]
    before = Rotation.from_euler("XYZ", angles, degrees=True).as_matrix()
    np.testing.assert_allclose(Rotation.from_euler("XYZ", found, degrees=True).as_matrix(), before, atol=1e-9)
    plain = nearest_turn(np.array(angles), np.array(meant))
    assert np.abs(found - meant).sum() <= np.abs(plain - meant).sum() + 1e-9


@given(st.integers(0, 10**6), st.floats(20.0, 200.0))
@settings(max_examples=20, deadline=None)
def test_a_motion_between_two_branches_does_not_flip_with_the_noise(seed, fps):
    """The nearest branch would change from frame to frame where the middle angle is at a right angle to its centre."""
    rng = np.random.default_rng(seed)
    frames = 60
    t = np.linspace(0.0, 2.0 * np.pi, frames)
    smooth = np.stack([90.0 + 8.0 * np.sin(t), 90.0 + 5.0 * np.sin(2.0 * t), 90.0 - 6.0 * np.cos(t)], axis=1)
    noisy = smooth + rng.normal(0.0, 3.0, smooth.shape)
    assert np.ptp(nearest_triple(noisy, np.zeros(3)), axis=0).max() > 100.0
    turns = Rotation.from_euler("XYZ", noisy, degrees=True).as_matrix()
    shuffled = nearest_triple(noisy, rng.uniform(-180.0, 180.0, noisy.shape))  # any branch in any frame
    for angles in (noisy, shuffled):
        angles = np.where(rng.random((frames, 1)) < 0.1, np.nan, angles)
        steady = steady_triple(angles, np.zeros(3), fps)
        known = np.isfinite(angles).all(axis=1)
        assert np.ptp(steady[known], axis=0).max() < 60.0
        found = Rotation.from_euler("XYZ", steady[known], degrees=True).as_matrix()
        np.testing.assert_allclose(found, turns[known], atol=1e-9)


def test_a_motion_that_stays_in_the_other_branch_goes_there():
    """A flip of a few frames is smoothed over, one for many seconds is not."""
    stay = np.array([[10.0, 0.0, 0.0]] * 30 + [[170.0, 10.0, 170.0]] * 600 + [[10.0, 0.0, 0.0]] * 30)
    steady = steady_triple(stay, np.zeros(3), 30.0)
    assert np.abs(steady[60:600]).max() < 175.0
    np.testing.assert_allclose(steady, nearest_triple(stay, np.zeros(3)), atol=1e-9)


@given(st.integers(0, 10**6), st.floats(20.0, 200.0))
@settings(max_examples=20, deadline=None)
def test_an_angle_half_a_turn_from_its_middle_does_not_leap_with_the_noise(seed, fps):
    rng = np.random.default_rng(seed)
    smooth = 180.0 + 8.0 * np.sin(np.linspace(0.0, 2.0 * np.pi, 60))
    angles = (smooth + rng.normal(0.0, 3.0, 60)) + 360.0 * rng.integers(-1, 2, 60)  # any turn in any frame
    angles[rng.random(60) < 0.1] = np.nan
    known = np.isfinite(angles)
    assert np.ptp(nearest_turn(angles[known], np.zeros(known.sum()))) > 180.0
    steady = steady_turn(angles, 0.0, fps)
    np.testing.assert_array_equal(np.isnan(steady), ~known)
    assert np.ptp(steady[known]) < 60.0
    turns = (steady - angles)[known] / 360.0
    np.testing.assert_allclose(turns, np.round(turns), atol=1e-9)


def test_an_angle_that_stays_beyond_half_a_turn_goes_to_the_nearer_side():
    stay = np.concatenate([np.zeros(30), np.linspace(0.0, 200.0, 10), np.full(600, 200.0), np.zeros(30)])
    steady = steady_turn(stay, 0.0, 30.0)
    np.testing.assert_allclose(steady[60:600], -160.0, atol=1e-9)
    assert steady_turn(stay[:50], 0.0, 30.0).max() == pytest.approx(200.0)  # for a moment it stays where it goes


def test_a_hinge_that_passes_half_a_turn_has_no_leap_in_its_channel(walk):
    row = 10  # of an ankle that turns about two axes
    q = walk.q.copy()
    q[40:60, row] = q[:, row].mean() + np.radians(180.0 + 15.0 * np.sin(np.arange(20.0)))
    q[30:40, row] = np.linspace(q[29, row], q[40, row], 10)
    q[60:70, row] = np.linspace(q[59, row], q[70, row], 10)
    turning = walk.with_q(q)
    values = to_channels(turning, learn_layout([walk])).values
    assert np.abs(np.diff(values[:, row])).max() < 60.0
    channels = to_channels(turning, learn_layout([walk]))
    back = from_channels(channels, channels.values, np.isfinite(channels.values), turning)
    np.testing.assert_allclose(back, q, atol=1e-9)


def test_whole_turns_in_the_file_make_no_jump_and_come_back(walk):
    q = walk.q.copy()
    q[30:70, 20] += 2 * np.pi
    q[50:, 0:6][:, -1] -= 2 * np.pi
    jumpy = walk.with_q(q)
    layout = learn_layout([walk])
    channels = to_channels(jumpy, layout)
    np.testing.assert_allclose(channels.values, to_channels(walk, layout).values, atol=1e-9)
    back = from_channels(channels, channels.values, np.isfinite(channels.values), jumpy)
    np.testing.assert_allclose(back, q, atol=1e-9)


def test_an_outlier_of_a_full_turn_does_not_move_the_branch(walk):
    """The repaired sample lies where its neighbours are, not a turn away."""
    q = walk.q.copy()
    q[40, 25] += np.radians(250)
    layout = learn_layout([walk])
    channels = to_channels(walk.with_q(q), layout)
    trusted = np.isfinite(channels.values)
    trusted[40, 25] = False
    clean = to_channels(walk, layout).values
    back = from_channels(channels, clean, trusted, walk.with_q(q))
    np.testing.assert_allclose(back, walk.q, atol=1e-9)


def test_a_steady_spin_leaves_nothing_in_the_heading_channel():
    fps, turns_per_s = 60.0, 1.2
    time = np.arange(240) / fps
    frame = travel(np.zeros((240, 3)), 2 * np.pi * turns_per_s * time, fps, np.array([0.0, 1.0, 0.0]))
    left = np.angle(np.exp(1j * (2 * np.pi * turns_per_s * time - frame.heading)))
    assert np.abs(left[30:-30]).max() < 0.02


def test_kinds_and_channel_sets_must_agree(walk):
    cloud = markers(walk)
    with pytest.raises(MismatchError, match="fit two models"):
        learn_layout([walk, cloud])
    with pytest.raises(MismatchError, match="use a model fitted on files of this kind"):
        to_channels(cloud, learn_layout([walk]))
    few = Markers(cloud.names[:10], cloud.positions[:, :10], cloud.fps, up=cloud.up)
    with pytest.raises(MismatchError, match="lacks"):
        to_channels(few, learn_layout([cloud]))


def test_other_subjects_prefix_and_marker_order_are_matched_by_name(walk):
    cloud = markers(walk)
    order = np.random.default_rng(5).permutation(len(cloud.names))
    other = Markers(
        tuple(f"Someone:{cloud.names[i]}" for i in order), cloud.positions[:, order], cloud.fps, up=cloud.up
    )
    layout = learn_layout([cloud])
    np.testing.assert_allclose(to_channels(other, layout).values, to_channels(cloud, layout).values, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["amc/05/05_06.amc", "amc/131/131_04.amc", "amc/86/86_01.amc", "bvh/10_04.bvh"])
def test_real_recordings_come_back_exactly(data, name):
    recording = read(data / "mocap" / name)
    channels = to_channels(recording, learn_layout([recording]))
    back = from_channels(channels, channels.values, np.isfinite(channels.values), recording)
    np.testing.assert_allclose(back, recording.q, atol=1e-9)
