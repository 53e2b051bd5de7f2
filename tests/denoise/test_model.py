"""The fitted denoiser on whole recordings: learning, repairing, saying what was done."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.bodies.motion import Markers, Motion, Origin
from motionmend.denoise import METHODS, Denoiser, DenoiserModel, repair_without_model
from motionmend.denoise.channels.joints import joint_rotation, root_rows
from motionmend.denoise.library.learning import examples, glitches
from motionmend.errors import MismatchError, UsageError
from motionmend.evaluate import compare, corrupt
from motionmend.io import read
from motionmend.samples import clip, markers
from performers import every_other, moved

FPS = 30.0
SETTINGS = Denoiser(window=12, fps=FPS, energy=0.99)


def walks(seeds, fps=FPS):
    return [clip("walk", seconds=3.0, fps=fps, seed=s) for s in seeds]


@pytest.fixture(scope="module")
def joints_model() -> DenoiserModel:
    return SETTINGS.fit(walks([1, 2, 3]))


@pytest.fixture(scope="module")
def markers_model() -> DenoiserModel:
    return SETTINGS.fit([every_other(markers(m)) for m in walks([1, 2, 3])])


@pytest.fixture(scope="module")
def walk() -> Motion:
    return clip("walk", seconds=3.0, fps=FPS, seed=9)


@pytest.fixture(scope="module")
def cloud(walk) -> Markers:
    """Two seconds: more than a stride, and more than any gap of the tests."""
    return every_other(markers(walk.at_frames(slice(0, 60))))


def spoiled(recording, **damage):
    return corrupt(recording, seed=4, **damage).recording


def test_noise_and_outliers_are_repaired(joints_model, walk):
    noisy = spoiled(walk, noise=np.radians(3), outliers=0.1)
    repaired = joints_model.repair(noisy, "paper")
    before, after = compare(walk, noisy), compare(walk, repaired.recording)
    assert after.rms_deg < 0.25 * before.rms_deg
    assert after.mean_cm < 0.3 * before.mean_cm
    assert repaired.converged
    assert (np.diff(repaired.cost) <= 1e-9 * repaired.cost[0]).all()


@pytest.mark.slow
def test_markers_are_repaired_and_filled(markers_model, cloud):
    gappy = spoiled(cloud, noise=0.005, gaps=0.15)
    repaired = markers_model.repair(gappy)
    filled = repaired.origin == Origin.FILLED
    assert filled.sum() == (~gappy.present).sum()
    error = np.linalg.norm(repaired.recording.positions - cloud.positions, axis=2)
    assert np.sqrt(np.mean(error[filled] ** 2)) < 0.06


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_every_method_keeps_frames_channels_and_accounts_for_every_sample(
    joints_model, markers_model, walk, cloud, method
):
    recording, model = (cloud, markers_model) if method == "pca" else (walk, joints_model)
    damage = {"noise": 0.003, "gaps": 0.05} if method == "pca" else {"noise": 0.02, "gaps": 0.05}
    damaged = spoiled(recording, **damage)
    repaired = model.repair(damaged, method)
    assert repaired.recording.channels == recording.channels
    assert repaired.recording.frames == recording.frames
    assert repaired.recording.fps == recording.fps
    assert sum(repaired.counts().values()) == recording.frames * len(recording.channels)
    missing = ~damaged.present
    lost = (repaired.origin == Origin.FILLED) | (repaired.origin == Origin.LEFT_OPEN)
    np.testing.assert_array_equal(lost, missing)
    np.testing.assert_array_equal(repaired.recording.present, repaired.origin != Origin.LEFT_OPEN)
    known = repaired.recording.present
    assert np.isfinite(repaired.std[known]).all()


@pytest.mark.parametrize("method", ["linear", "spline"])
def test_gap_fillers_leave_measured_samples_bit_for_bit(walk, method):
    damaged = spoiled(walk, gaps=0.1)
    repaired = repair_without_model(damaged, method)
    np.testing.assert_array_equal(repaired.recording.q[damaged.present], damaged.q[damaged.present])


@pytest.mark.slow
def test_a_repair_without_a_model_is_adaptive_unless_asked_otherwise(walk):
    damaged = spoiled(walk, gaps=0.1)
    plain, asked = repair_without_model(damaged), repair_without_model(damaged, "adaptive")
    np.testing.assert_array_equal(plain.recording.q, asked.recording.q)
    np.testing.assert_array_equal(plain.origin, asked.origin)


@pytest.fixture(scope="module", params=["motion", "markers"])
def at_home(request, joints_model, markers_model, walk, cloud):
    """A model, a recording, and its repair where it was recorded."""
    motion = request.param == "motion"
    clean, model = (walk.at_frames(slice(0, 60)), joints_model) if motion else (cloud, markers_model)
    damaged = spoiled(clean, noise=np.radians(2) if motion else 0.01, outliers=0.05)
    return model, damaged, model.repair(damaged).recording


@pytest.mark.slow
@given(angle=st.floats(-6, 6), x=st.floats(-9, 9), y=st.floats(-2, 2), z=st.floats(-9, 9))
@settings(max_examples=4)
def test_repair_commutes_with_walking_somewhere_else(at_home, angle, x, y, z):
    """A clip recorded elsewhere, facing elsewhere, is repaired the same, to 1e-6."""
    model, damaged, repaired = at_home
    shift = np.array([x, y, z])
    there = model.repair(moved(damaged, angle, shift)).recording
    here = moved(repaired, angle, shift)
    if isinstance(damaged, Motion):
        turns, _ = root_rows(here.skeleton)
        others = np.setdiff1d(np.arange(here.q.shape[1]), turns)
        assert np.abs((there.q - here.q)[:, others]).max() < 1e-6
        # one rotation has many Euler angles: compare the rotations
        one, other = (joint_rotation(m.skeleton, turns, m.q) for m in (there, here))
        assert np.abs(one - other).max() < 1e-6
    else:
        assert np.abs(there.positions - here.positions).max() < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("fps", [24.0, 50.0, 59.94, 120.0])
def test_any_rate_keeps_its_own_frames(joints_model, fps):
    clean = clip("walk", seconds=3.0, fps=fps, seed=9)
    noisy = spoiled(clean, noise=np.radians(3), outliers=0.05)
    repaired = joints_model.repair(noisy).recording
    assert repaired.q.shape == clean.q.shape
    assert compare(clean, repaired).rms_deg < 0.4 * compare(clean, noisy).rms_deg


@pytest.mark.slow
@pytest.mark.parametrize("frames", [1, 2, 3, 7, 12, 13])
def test_recordings_shorter_than_a_window_are_repaired_too(joints_model, walk, frames):
    short = walk.with_q(walk.q[:frames])
    repaired = joints_model.repair(short)
    assert repaired.recording.frames == frames
    assert np.isfinite(repaired.recording.q).all()


@pytest.mark.slow
def test_a_stretch_without_any_measurement_stays_open_and_is_said(joints_model, walk):
    q = walk.q.copy()
    q[20:75] = np.nan
    repaired = joints_model.repair(walk.with_q(q))
    assert (repaired.origin[40:50] == Origin.LEFT_OPEN).all()
    assert np.isnan(repaired.recording.q[40:50]).all()
    assert np.isnan(repaired.std[40:50]).all()
    assert any("left open" in w for w in repaired.warnings)


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.5, 2.0])
def test_the_stated_deviations_are_of_the_size_of_the_errors(joints_model, noise):
    errors, stated = [], []
    for seed in (9, 10, 11):
        truth = clip("walk", seconds=3.0, fps=FPS, seed=seed)
        repaired = joints_model.repair(spoiled(truth, noise=np.radians(noise), gaps=0.1))
        filled = repaired.origin == Origin.FILLED
        errors.append((repaired.recording.q - truth.q)[filled])
        stated.append(repaired.std[filled])
    ratio = np.sqrt(np.mean(np.square(np.concatenate(errors))) / np.mean(np.square(np.concatenate(stated))))
    assert 0.4 < ratio < 1.6


@pytest.mark.slow
def test_a_whole_arm_without_markers_is_filled_from_the_others(markers_model, cloud):
    arm = [i for i, n in enumerate(cloud.names) if n[1:] in ("UPA", "ELB", "FRM", "WRA", "WRB", "FIN")]
    positions = cloud.positions.copy()
    positions[:, arm] = np.nan
    repaired = markers_model.repair(cloud.with_positions(positions))
    error = np.linalg.norm(repaired.recording.positions - cloud.positions, axis=2)[:, arm]
    assert (repaired.origin[:, arm] == Origin.FILLED).all()
    assert error.mean() < 0.05


@pytest.mark.slow
def test_an_unknown_motion_is_said(joints_model):
    jump = clip("jump", seconds=3.0, fps=FPS, seed=2)
    assert any("may not know" in w for w in joints_model.repair(jump).warnings)


@pytest.mark.slow
def test_a_known_motion_is_not_called_unknown(joints_model, walk):
    noisy = spoiled(walk, noise=np.radians(5), outliers=0.2)
    assert not any("may not know" in w for w in joints_model.repair(noisy).warnings)


@pytest.mark.slow
def test_models_survive_taking_apart(joints_model, markers_model, walk, cloud):
    for model, recording in ((joints_model, walk), (markers_model, cloud)):
        again = DenoiserModel.from_arrays(*model.to_arrays())
        one, two = model.repair(recording), again.repair(recording)
        np.testing.assert_array_equal(one.std, two.std)
        values = (
            (one.recording.q, two.recording.q)
            if isinstance(recording, Motion)
            else (one.recording.positions, two.recording.positions)
        )
        np.testing.assert_array_equal(*values)


@pytest.mark.slow
def test_clips_in_any_order_give_the_same_repair(walk):
    clips = walks([1, 2, 3])
    one, two = SETTINGS.fit(clips), SETTINGS.fit(clips[::-1])
    np.testing.assert_allclose(one.repair(walk).recording.q, two.repair(walk).recording.q, atol=1e-6)


@pytest.mark.slow
def test_clips_at_another_rate_teach_the_same(walk):
    fast = SETTINGS.fit([clip("walk", seconds=3.0, fps=120.0, seed=s) for s in (1, 2, 3)])
    slow = SETTINGS.fit(walks([1, 2, 3]))
    noisy = spoiled(walk, noise=np.radians(2))
    errors = [compare(walk, m.repair(noisy).recording).rms_deg for m in (fast, slow)]
    assert errors[0] == pytest.approx(errors[1], rel=0.25)


def test_gaps_in_clips_are_bridged_or_cut_and_said():
    cloud = markers(clip("walk", seconds=3.0, fps=FPS, seed=1))
    positions = cloud.positions.copy()
    positions[20:23, 3] = np.nan
    positions[50:70, 5] = np.nan
    model = SETTINGS.fit([cloud.with_positions(positions), markers(clip("walk", seconds=3.0, fps=FPS, seed=2))])
    assert any("bridged" in note for note in model.notes)
    series = next(examples(cloud.with_positions(positions), model.layout, tail=0.0)).values
    assert np.isfinite(series[20:23]).all()
    assert np.isnan(series[50:70]).any()


def test_joints_that_fall_to_zeros_do_not_teach(joints_model, walk):
    q = walk.q.copy()
    humerus = [i for i, n in enumerate(walk.channels) if n.startswith("lhumerus")]
    q[:4, humerus] = 0.0
    (found,) = glitches(walk.with_q(q))
    assert found.rows.tolist() == humerus
    assert (found.start, found.stop) == (0, 4)
    assert next(examples(walk.with_q(q), joints_model.layout, tail=0.0)).lost == 4 * len(humerus)
    held = walk.q.copy()
    held[:, humerus] = 0.0
    assert glitches(walk.with_q(held)) == []


def test_calls_that_make_no_sense_say_so(joints_model, walk):
    with pytest.raises(UsageError, match="choose one of"):
        joints_model.repair(walk, "median")
    with pytest.raises(UsageError, match="estimator"):
        joints_model.repair(walk, robust="cauchy")
    with pytest.raises(UsageError, match="needs a model"):
        repair_without_model(walk, "paper")
    with pytest.raises(MismatchError, match="came none"):
        SETTINGS.fit([])
    with pytest.raises(MismatchError, match="longer clips"):
        SETTINGS.fit([walk.with_q(walk.q[:5])])
    with pytest.raises(UsageError):
        Denoiser(window=1)
    with pytest.raises(MismatchError, match="kind"):
        joints_model.repair(markers(walk))


def with_prop(cloud, prop):
    """The markers and one more at places (T, 3) m."""
    everything = np.concatenate([cloud.positions, prop[:, None]], axis=1)
    return Markers((*cloud.names, "PROP1"), everything, cloud.fps, up=cloud.up)


@pytest.mark.parametrize("method", ["paper", "kalman-data"])
def test_unknown_channels_are_left_and_said(markers_model, cloud, method):
    extra = with_prop(cloud, cloud.positions[:, 0] + 0.5)
    repaired = markers_model.repair(extra, method)
    np.testing.assert_array_equal(repaired.recording.positions[:, -1], extra.positions[:, -1])
    assert any("PROP1" in w and "left as recorded" in w for w in repaired.warnings)


@pytest.mark.slow
def test_unknown_channels_are_repaired_by_what_they_show_themselves(markers_model, cloud):
    """As without a library; the others stay what the library made of them, and their gaps are filled from all."""
    truth = with_prop(cloud, cloud.positions[:, 0] + 0.3)
    bad = corrupt(truth, noise=0.005, outliers=0.05, gaps=0.05, seed=3)
    positions = bad.recording.positions.copy()
    positions[40:46, -1] = np.nan
    bad_recording = bad.recording.with_positions(positions)
    repaired = markers_model.repair(bad_recording)
    off = np.linalg.norm(repaired.recording.positions - truth.positions, axis=2)[:, -1]
    assert np.sqrt(np.mean(np.square(off))) < 0.01
    assert repaired.origin[41, -1] == Origin.FILLED
    assert (repaired.origin[bad.outlier[:, -1] & np.isfinite(positions[:, -1, 0]), -1] == Origin.REPAIRED).all()
    assert repaired.noise[-1] == pytest.approx(0.005, rel=0.5)
    assert any("PROP1" in w and "repaired by what they show themselves" in w for w in repaired.warnings)
    assert not any("left as recorded" in w or "left open" in w for w in repaired.warnings)
    known = markers_model.repair(Markers(truth.names[:-1], positions[:, :-1], truth.fps, up=truth.up))
    both, seen = (repaired.recording.positions[:, :-1], known.recording.positions), known.origin < Origin.FILLED
    np.testing.assert_array_equal(both[0][seen], both[1][seen])


@pytest.mark.slow
def test_unknown_markers_leave_the_gaps_of_others_as_well_filled(markers_model, cloud):
    """A single draw's gaps are few, with errors of 0.85 to 1.11 times those without the unknown marker."""
    truth = with_prop(cloud, cloud.positions[:, 0] + 0.3)
    away = np.zeros(2)
    for seed in (3, 4, 5):
        bad = corrupt(truth, noise=0.005, outliers=0.05, gaps=0.05, seed=seed).recording.positions
        known = markers_model.repair(Markers(truth.names[:-1], bad[:, :-1], truth.fps, up=truth.up))
        both = markers_model.repair(truth.with_positions(bad)).recording.positions[:, :-1], known.recording.positions
        gaps = known.origin >= Origin.FILLED
        away += [np.square(np.linalg.norm(one - truth.positions[:, :-1], axis=2)[gaps]).sum() for one in both]
    assert away[0] < 1.1 * away[1]


@pytest.mark.slow
def test_joint_angles_that_a_library_does_not_know_are_repaired_too(joints_model, walk):
    """A model of some of a skeleton's channels repairs all of them."""
    named = tuple(name.replace("humerus", "upperarm") for name in walk.channels)
    truth = Motion(replace(walk.skeleton, dof_names=named), walk.q, walk.fps)
    bad = spoiled(truth, noise=np.radians(3.0), outliers=0.05)
    repaired = joints_model.repair(bad)
    strange = np.array([channel not in joints_model.layout.names for channel in truth.channels])
    before, after = (np.sqrt(np.mean(np.square((one.q - truth.q)[:, strange]))) for one in (bad, repaired.recording))
    assert strange.any()
    assert after < 0.3 * before


@pytest.mark.slow
def test_long_bursts_of_outliers_of_markers_are_filled_from_the_others(cloud):
    """Without a library: half a second of nonsense says as little as a gap."""
    positions = cloud.positions + np.random.default_rng(0).normal(0, 0.002, cloud.positions.shape)
    gappy = positions.copy()
    for marker, start in ((3, 10), (11, 38), (17, 22)):
        burst = slice(start, start + 15)
        positions[burst, marker] += np.random.default_rng(marker).uniform(-0.4, 0.4, (15, 3))
        gappy[burst, marker] = np.nan
    wild, gap = (repair_without_model(cloud.with_positions(p), "adaptive") for p in (positions, gappy))
    hidden = ~np.isfinite(gappy).all(axis=2)
    off, usual = (np.linalg.norm(r.recording.positions - cloud.positions, axis=2)[hidden] for r in (wild, gap))
    assert (wild.origin[hidden] == Origin.REPAIRED).mean() > 0.9
    assert np.sqrt(np.mean(np.square(off))) < 1.3 * np.sqrt(np.mean(np.square(usual)))


@pytest.mark.slow
@pytest.mark.parametrize("library", [True, False])
def test_frames_without_any_marker_are_no_accident(markers_model, cloud, library):
    """All markers lost for ten frames, and some others besides."""
    positions = cloud.positions.copy()
    positions[25:35] = np.nan
    positions[45:50, :5] = np.nan
    lost = cloud.with_positions(positions)
    repaired = markers_model.repair(lost) if library else repair_without_model(lost, "adaptive")
    assert (repaired.origin[~lost.present] >= Origin.FILLED).all()
    assert np.isfinite(repaired.recording.positions[45:50]).all()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("learn", "held_out"),
    [
        (["16_15", "16_16", "16_21", "16_22", "16_31"], "16_32"),
        ([f"09_{i:02d}" for i in (1, 2, 3, 4, 5, 6, 7, 10)], "09_08"),
    ],
)
def test_real_motions_of_one_person(data, learn, held_out):
    """On outliers the method must beat every filter that knows no library (claim D12)."""
    folder = data / "mocap" / "amc"
    subject = held_out.split("_")[0]
    model = Denoiser().fit([read(folder / subject / f"{name}.amc") for name in learn])
    truth = read(folder / subject / f"{held_out}.amc").at_frames(slice(0, 240))  # two strides
    noisy = spoiled(truth, noise=np.radians(3), outliers=0.2)
    ours = compare(truth, model.repair(noisy).recording).rms_deg
    for method in ("gaussian", "savgol", "butterworth", "kalman"):
        assert ours < compare(truth, repair_without_model(noisy, method).recording).rms_deg


@pytest.mark.slow
def test_a_fast_dance_without_noise_is_left_alone(data):
    """Its swings of two and three frames are no bursts, nor gaps."""
    whole = read(data / "mocap" / "bvh" / "60_10_salsa.bvh")
    salsa = replace(whole.with_q(whole.q[360:960:4]), fps=30.0)
    assert compare(salsa, repair_without_model(salsa, "adaptive").recording).rms_deg < 0.4


@pytest.mark.slow
def test_real_markers_with_real_gaps(data):
    whole = read(data / "mocap" / "c3d" / "sfu_0005_SideSkip001.c3d")
    recording = whole.at_frames(slice(780, 940))  # of one frame to twenty-two, in seven markers
    assert (~recording.present).any(axis=0).sum() == 7
    repaired = Denoiser().fit([recording]).repair(recording)
    assert (repaired.origin == Origin.FILLED).sum() == (~recording.present).sum()
    assert np.isfinite(repaired.recording.positions).all()


@pytest.mark.slow
def test_a_recording_with_another_vertical_is_repaired_the_same(markers_model, cloud):
    gappy = spoiled(cloud, noise=0.003, gaps=0.1)
    upright = markers_model.repair(gappy).recording.positions
    for axes in ([2, 0, 1], [1, 2, 0]):
        turned = Markers(cloud.names, gappy.positions[:, :, axes], cloud.fps, up=cloud.up[axes])
        assert np.abs(markers_model.repair(turned).recording.positions - upright[:, :, axes]).max() < 1e-6
    over = Markers(cloud.names, gappy.positions * [1, -1, -1], cloud.fps, up=-cloud.up)
    assert np.abs(markers_model.repair(over).recording.positions - upright * [1, -1, -1]).max() < 1e-6


@pytest.mark.slow
def test_clips_with_different_verticals_teach_one_model(cloud):
    clouds = [every_other(markers(m)) for m in walks([1, 2])]
    lying = Markers(clouds[1].names, clouds[1].positions[:, :, [2, 0, 1]], FPS, up=clouds[1].up[[2, 0, 1]])
    one, two = SETTINGS.fit(clouds), SETTINGS.fit([clouds[0], lying])
    noisy = spoiled(cloud, noise=0.005)
    np.testing.assert_allclose(one.repair(noisy).recording.positions, two.repair(noisy).recording.positions, atol=1e-6)


def test_filters_need_no_body(walk):
    cloud = markers(walk)
    two = Markers(cloud.names[:2], cloud.positions[:, :2], cloud.fps, up=cloud.up)
    gappy = spoiled(two, gaps=0.1)
    for method in ("linear", "gaussian"):
        assert repair_without_model(gappy, method).counts()["filled"] > 0


@pytest.mark.slow
def test_a_repeated_marker_name_costs_only_itself(markers_model, cloud):
    cloud = cloud.at_frames(slice(0, 30))  # what a marker is called is no matter of time
    names = (*cloud.names[:-1], cloud.names[0])
    repaired = markers_model.repair(Markers(names, cloud.positions, cloud.fps, up=cloud.up))
    assert repaired.recording.names == names
    assert any("lacks" in w for w in repaired.warnings)
