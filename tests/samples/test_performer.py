"""Every clip of the performer is smooth, plausible and repeatable, and each action is what its name says."""

import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.bodies.feet import contacts, foot_joints, skate
from motionmend.bodies.skeleton import positions
from motionmend.errors import UsageError
from motionmend.samples import ACTIONS, clip, library
from motionmend.samples.gait import GRAVITY

PEOPLE = st.fixed_dictionaries(
    {
        "seed": st.integers(0, 10_000),
        "speed": st.floats(0.5, 1.6),
        "style": st.floats(-1.0, 1.0),
        "height": st.floats(1.4, 2.0),
    }
)


def places(motion):
    """Positions by joint name: (T, 3) m each."""
    return dict(zip(motion.skeleton.names, np.moveaxis(positions(motion.skeleton, motion.q), 1, 0), strict=True))


def channel(motion, name):
    return motion.q[:, motion.channels.index(name)]


def feet(motion):
    return positions(motion.skeleton, motion.q)[:, foot_joints(motion.skeleton).joints]


@pytest.mark.slow
@pytest.mark.parametrize("action", ACTIONS)
@settings(max_examples=8)
@given(who=PEOPLE)
def test_every_clip_is_smooth_within_limits_and_on_the_floor(action, who):
    motion = clip(action, seconds=4, **who)
    s, q = motion.skeleton, motion.q
    assert q.shape == (480, 62)
    assert np.isfinite(q).all()
    assert np.all((q >= s.limits[:, 0]) & (q <= s.limits[:, 1]))
    assert np.degrees(np.abs(np.diff(q[:, 3:], axis=0))).max() < 15.0  # a frame; CMU's jumps are above 60
    at = positions(s, q)
    jerk = np.linalg.norm(np.diff(at, 3, axis=0), axis=2) * 120.0**3
    assert jerk.max() < 60_000  # m/s^3; clean recordings of people reach 60,000 to 500,000
    assert at[..., 1].min() > -0.02  # m
    # cm/s; clean recordings of people: 4 (jumps), 7 (walks), 21 (runs)
    assert 100 * skate(feet(motion), 120.0, s.up) < (8.0 if action == "run" else 5.0)


@pytest.mark.parametrize("action", ACTIONS)
def test_the_same_arguments_give_the_same_bytes_and_another_seed_another_clip(action):
    first, again = clip(action, seconds=2, seed=5), clip(action, seconds=2, seed=5)
    assert first.q.tobytes() == again.q.tobytes()
    assert not np.allclose(first.q, clip(action, seconds=2, seed=6).q, atol=0.01)


@pytest.mark.parametrize("action", ACTIONS)
def test_the_rate_samples_one_and_the_same_movement(action):
    fine, coarse = clip(action, seconds=3, fps=120.0, seed=2), clip(action, seconds=3, fps=30.0, seed=2)
    assert (fine.frames, coarse.frames) == (360, 90)
    np.testing.assert_allclose(coarse.q, fine.q[::4], atol=1e-9)
    longer = clip(action, seconds=2, fps=120.0, seed=2)
    assert longer.frames == 240


def test_a_clip_sets_out_from_the_origin_upright():
    for action in ACTIONS:
        at = places(clip(action, seconds=1, seed=1))
        np.testing.assert_allclose(at["root"][0, [0, 2]], 0.0, atol=1e-12)
        assert at["head_end"][0, 1] > at["root"][0, 1] > at["lfoot"][0, 1]


def test_eight_seconds_are_made_in_a_second():
    clip("walk", seconds=1)
    for action in ACTIONS:
        start = time.perf_counter()
        clip(action, seconds=8, seed=3, speed=1.1)
        assert time.perf_counter() - start < 1.0


@settings(max_examples=8)
@given(seed=st.integers(0, 1000), speed=st.floats(0.7, 1.4), height=st.floats(1.5, 1.95))
def test_a_walker_walks_as_fast_as_asked_and_never_flies(seed, speed, height):
    motion = clip("walk", seconds=8, seed=seed, speed=speed, height=height)
    gone = channel(motion, "root.tz")[-1] / 8
    assert gone == pytest.approx(1.35 * speed * np.sqrt(height / 1.75), rel=0.08)
    standing = contacts(feet(motion), 120.0, motion.skeleton.up)
    assert standing.any(axis=1).mean() > 0.97
    assert 0.3 < standing.mean() < 0.7


def test_arms_swing_against_the_legs_and_the_trunk_against_the_pelvis():
    for action in ("walk", "run"):
        motion = clip(action, seconds=6, seed=4)
        at = places(motion)
        ahead = {name: at[name][:, 2] - at["root"][:, 2] for name in ("lhand", "rhand", "lfoot", "rfoot")}
        assert np.corrcoef(ahead["lhand"], ahead["rfoot"])[0, 1] > 0.7
        assert np.corrcoef(ahead["lhand"], ahead["lfoot"])[0, 1] < -0.7
        pelvis = channel(motion, "root.ry")
        thorax = pelvis + sum(channel(motion, f"{j}.ry") for j in ("lowerback", "upperback", "thorax"))
        assert np.corrcoef(pelvis - pelvis.mean(), thorax - thorax.mean())[0, 1] < 0.0


def test_cycles_are_alike_but_not_the_same():
    motion = clip("walk", seconds=20, seed=8)
    knee = np.degrees(channel(motion, "ltibia.rx"))
    peaks = np.flatnonzero((knee[1:-1] > knee[:-2]) & (knee[1:-1] >= knee[2:]) & (knee[1:-1] > 50)) + 1
    strides = np.diff(peaks) / 120.0
    assert 0.003 < strides.std() / strides.mean() < 0.05


def test_left_and_right_do_the_same_half_a_cycle_apart():
    motion = clip("walk", seconds=20, seed=9)
    for joint in ("tibia.rx", "femur.rx", "radius.rx"):
        left, right = channel(motion, f"l{joint}"), channel(motion, f"r{joint}")
        assert np.ptp(left) == pytest.approx(np.ptp(right), rel=0.25)
        assert left.mean() == pytest.approx(right.mean(), abs=np.radians(6))


def test_a_runner_flies_twice_a_stride_and_falls_freely():
    motion = clip("run", seconds=6, seed=4)
    standing = contacts(feet(motion), 120.0, motion.skeleton.up).any(axis=1)
    assert 0.2 < 1 - standing.mean() < 0.7
    fall = np.gradient(np.gradient(channel(motion, "root.ty"), 1 / 120), 1 / 120)
    assert np.mean(np.abs(fall + GRAVITY) < 1.0) > 0.15  # of the time
    assert fall.min() > -GRAVITY * 1.15


@settings(max_examples=8)
@given(seed=st.integers(0, 1000), speed=st.floats(0.7, 1.3))
def test_a_jumper_leaves_the_floor_on_a_parabola_and_comes_down_on_it(seed, speed):
    motion = clip("jump", seconds=8, seed=seed, speed=speed)
    at = places(motion)
    lowest = np.minimum.reduce([at[f"{s}{j}"][:, 1] for s in "lr" for j in ("foot", "toes", "toes_end")])
    air = lowest > 0.05
    assert 0.05 < air.mean() < 0.5
    fall = np.gradient(np.gradient(channel(motion, "root.ty"), 1 / 120), 1 / 120)
    np.testing.assert_allclose(fall[air], -GRAVITY, atol=0.5)
    knees = np.degrees(channel(motion, "ltibia.rx"))
    assert knees.max() > 70  # crouches
    assert channel(motion, "root.ty").max() > channel(motion, "root.ty")[0] + 0.1


@settings(max_examples=8)
@given(seed=st.integers(0, 1000))
def test_who_reaches_stands_still_with_the_feet_and_goes_far_with_a_hand(seed):
    motion = clip("reach", seconds=8, seed=seed)
    at = places(motion)
    for joint in ("lfoot", "rfoot", "ltoes", "rtoes"):
        assert np.ptp(at[joint], axis=0).max() < 0.005
    travel = max(np.ptp(at[f"{s}hand"], axis=0).max() for s in "lr")
    assert travel > 0.3
    assert fastest_hand(motion) < 7.0


def fastest_hand(motion):
    """m/s of the right one."""
    return np.linalg.norm(np.diff(places(motion)["rhand"], axis=0), axis=1).max() * motion.fps


@pytest.mark.slow
def test_hands_reach_seldom_faster_than_six_metres_a_second():
    speeds = [fastest_hand(clip("reach", seconds=8, fps=60, seed=seed)) for seed in range(30)]
    assert np.mean(np.less(speeds, 6.0)) > 0.9
    assert np.median(speeds) > 1.5


@settings(max_examples=8)
@given(seed=st.integers(0, 1000))
def test_who_turns_faces_elsewhere_in_the_end_without_a_jump(seed):
    motion = clip("turn", seconds=8, seed=seed)
    heading = np.unwrap(channel(motion, "root.ry"))
    np.testing.assert_allclose(heading, channel(motion, "root.ry"))
    assert np.degrees(np.ptp(heading)) > 45
    across = np.degrees(np.abs(np.diff(motion.q[:, 3:6], axis=0))).max()
    assert across < 3.0  # a frame, the pelvis' Euler angles, past a quarter turn too


def test_style_is_seen():
    weary, brisk = (clip("walk", seconds=6, seed=1, style=style) for style in (-1.0, 1.0))
    assert np.ptp(channel(brisk, "lhumerus.rx")) > 1.5 * np.ptp(channel(weary, "lhumerus.rx"))

    def stoop(motion):
        return sum(channel(motion, f"{j}.rx").mean() for j in ("root", "lowerback", "upperback", "thorax"))

    assert np.degrees(stoop(weary) - stoop(brisk)) > 4


def test_a_library_holds_different_people_in_every_action():
    clips = library(("walk", "reach"), (0, 1), seconds=1.0, fps=60.0)
    assert len(clips) == 4
    assert {c.frames for c in clips} == {60}
    assert not np.allclose(clips[0].skeleton.offsets, clips[2].skeleton.offsets)
    np.testing.assert_array_equal(clips[0].skeleton.offsets, clips[1].skeleton.offsets)


@pytest.mark.parametrize(
    ("action", "options"),
    [
        ("fly", {}),
        ("walk", {"speed": 3.0}),
        ("walk", {"style": -2.0}),
        ("walk", {"fps": 0.0}),
        ("walk", {"seconds": 0.0}),
        ("walk", {"seed": -1}),
        ("walk", {"height": 3.0}),
        ("walk", {"seconds": np.inf}),
    ],
)
def test_what_nobody_does_is_refused_in_one_line(action, options):
    with pytest.raises(UsageError) as caught:
        clip(action, **{"seconds": 1.0, **options})
    assert "\n" not in str(caught.value)


def test_clips_are_written_and_read_back(tmp_path):
    from motionmend.io import read, write

    motion = clip("turn", seconds=1, seed=7)
    for name in ("turn.amc", "turn.bvh"):
        write(tmp_path / name, motion)
        back = read(tmp_path / name, fps=120.0)
        there, here = places(motion), places(back)
        for joint in ("root", "lhand", "rtoes", "head"):
            np.testing.assert_allclose(here[joint], there[joint], atol=1e-5)
