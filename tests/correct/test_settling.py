"""What is put out is steady and keeps its bones: jumps do not ring, limbs thrown about leave nothing behind."""

import numpy as np
import pytest
from sensed_people import NAMES, truth

from motionmend.correct.settling import bones_outward, settled_frame, unborn


def lengths_of(positions: np.ndarray, bones: np.ndarray) -> np.ndarray:
    return np.linalg.norm(positions[bones[:, 1]] - positions[bones[:, 0]], axis=1)


@pytest.mark.parametrize("fps", [30.0, 60.0, 120.0])
def test_a_jump_does_not_ring_at_any_rate(fps: float) -> None:
    """What live steadying makes of a step overshoots by no more at 120 Hz than at 30."""
    bones, prior = bones_outward(NAMES), np.full(len(NAMES) - 1, np.nan)
    still = truth("walk", 3)[0]
    body, seen = unborn(len(NAMES), len(bones)), []
    for k in range(round(3 * fps)):
        away = np.array([0.1, 0.0, 0.0]) * (k > fps)
        body, placed = settled_frame(body, still + away, k / fps, np.ones(len(NAMES)), bones, prior)
        seen.append(placed[0, 0] - still[0, 0])
    assert max(seen) < 0.115
    assert seen[-1] == pytest.approx(0.1, abs=1e-3)


@pytest.mark.parametrize("trusted", [0.0, 1.0])
def test_a_limb_that_was_thrown_about_leaves_nothing_behind(trusted: float) -> None:
    """Live bones of a limb that failed for a second: soon after it is where it would be had it never failed."""
    bones, prior = bones_outward(NAMES), np.full(len(NAMES) - 1, np.nan)
    moving, rng = truth("walk", 3, seconds=5.0), np.random.default_rng(0)
    arm = np.array([name in ("ElbowLeft", "WristLeft", "HandLeft") for name in NAMES])
    bodies, placed = [unborn(len(NAMES), len(bones))] * 2, [moving[0]] * 2
    for k in range(len(moving)):
        failing = 20 <= k < 50
        for which in (0, 1):
            posture, trust = moving[k].copy(), np.ones(len(NAMES))
            if which and failing:
                posture[arm] += 0.7 * (posture[0] - posture[arm]) + 0.05 * rng.standard_normal((arm.sum(), 3))
                trust[arm] = trusted
            bodies[which], placed[which] = settled_frame(bodies[which], posture, k / 30.0, trust, bones, prior)
        if k == 49:
            assert np.linalg.norm(placed[1] - placed[0], axis=1)[arm].mean() > 0.1
    assert len(moving) > 100
    # Lengths that a limb showed while it was believed take a minute to be forgotten.
    assert np.linalg.norm(placed[1] - placed[0], axis=1).max() < (0.002 if trusted == 0.0 else 0.01)


@pytest.mark.parametrize("fps", [30.0, 120.0])
def test_live_bones_are_learned_within_a_second_and_hold(fps: float) -> None:
    """A sensor's bones that swing with the posture do not make the person's swing; what stays is followed."""
    bones = bones_outward(NAMES)
    still = truth("walk", 3)[0]
    times = np.arange(round(5 * fps)) / fps
    body, seen, given = unborn(len(NAMES), len(bones)), [], []
    for time in times:
        swings = still * (1.0 + 0.1 * np.sin(2.0 * np.pi * time / 4.0) + (0.2 if time < 0.1 else 0.0))
        prior = np.full(len(bones), np.nan)
        body, placed = settled_frame(body, swings, time, np.ones(len(NAMES)), bones, prior)
        given.append(lengths_of(swings, bones))
        seen.append(lengths_of(placed, bones))
    learned, some = times > 1.0, np.array(given)[0] > 0.02
    varied, came = (np.ptp(np.array(one)[learned][:, some], axis=0) for one in (seen, given))
    assert (varied < 0.15 * came).all()
    for time in times[-1] + np.arange(1, 180.0, 0.2):
        body, placed = settled_frame(body, 1.2 * still, time, np.ones(len(NAMES)), bones, prior)
    np.testing.assert_allclose(lengths_of(placed, bones)[some], lengths_of(1.2 * still, bones)[some], rtol=0.03)


def followed(seen: np.ndarray, times: np.ndarray) -> np.ndarray:
    """(T, J, 3) joints without bones, as they come out live."""
    nothing, body, frames = np.zeros((0, 2), dtype=np.int64), unborn(seen.shape[1], 0), []
    for row, time in zip(seen, times, strict=True):
        body, placed = settled_frame(body, row, float(time), np.ones(seen.shape[1]), nothing, np.zeros(0))
        frames.append(placed)
    return np.stack(frames)


@pytest.mark.parametrize(("action", "fps"), [("reach", 30), ("walk", 30), ("jump", 30), ("reach", 15)])
def test_live_steps_are_nearer_to_the_truth_and_places_as_near(action: str, fps: int) -> None:
    """Who is followed by what they did before lags behind hardly more than they trembled, even in a jump."""
    true = truth(action, 3)[:: 30 // fps]
    seen = true + 0.006 * np.random.default_rng(0).standard_normal(true.shape)
    found = followed(seen, np.arange(len(seen)) / fps)
    off = [np.square(one - true).mean() for one in (found, seen)]
    steps = [np.square(np.diff(one - true, axis=0)).mean() for one in (found, seen)]
    assert off[0] < (1.2 if action == "jump" else 1.0) * off[1]
    assert steps[0] < 0.65 * steps[1]


@pytest.mark.parametrize("fps", [10.0, 30.0, 120.0])
def test_who_walks_on_is_not_late(fps: float) -> None:
    gliding = np.zeros((round(2 * fps), 1, 3))
    gliding[:, 0, 0] = 1.5 * np.arange(len(gliding)) / fps
    late = gliding - followed(gliding, np.arange(len(gliding)) / fps)
    assert np.abs(late[round(fps) :]).max() < 1e-3
    assert np.abs(late).max() < 0.03


@pytest.mark.parametrize("fps", [10.0, 30.0, 120.0])
def test_a_clean_sensor_is_hardly_changed(fps: float) -> None:
    times = np.arange(round(4 * fps)) / fps
    true = np.zeros((len(times), 1, 3))
    true[:, 0, 0], true[:, 0, 1] = 0.3 * np.sin(2.0 * np.pi * times), 0.1 * np.sin(4.0 * np.pi * times)
    off = np.linalg.norm(followed(true, times) - true, axis=2)
    assert np.sqrt(np.square(off).mean()) < 0.012 * (30.0 / fps if fps < 30.0 else 1.0)


@pytest.mark.parametrize("stamps", ["stand still", "go back", "each twice", "whole seconds"])
def test_times_that_say_nothing_leave_frames_as_they_came(stamps: str) -> None:
    true = truth("walk", 3)[:90]
    regular = np.arange(len(true)) / 30.0
    told = {
        "stand still": np.arange(len(true)) * 1e-6,
        "go back": np.maximum.accumulate(np.where(regular < 1.0, regular, regular - 0.5)) + 1e-6 * np.arange(len(true)),
        "each twice": np.floor(regular * 15.0) / 15.0 + 1e-6 * np.arange(len(true)),
        "whole seconds": np.floor(regular) + 1e-6 * np.arange(len(true)),
    }
    seen = true + 0.002 * np.random.default_rng(0).standard_normal(true.shape)
    off = np.linalg.norm(followed(seen, told[stamps]) - true, axis=2)
    assert np.sqrt(np.square(off).mean()) < 1.3 * np.sqrt(np.square(np.linalg.norm(seen - true, axis=2)).mean())
    assert off.max() < 0.04


def test_frames_that_arrive_unevenly_went_by_evenly() -> None:
    true, rng = truth("walk", 3), np.random.default_rng(1)
    times = np.arange(len(true)) / 30.0
    seen = true + 0.005 * rng.standard_normal(true.shape)
    arrived = times + 0.006 * rng.standard_normal(len(times))
    off = [np.square(followed(seen, one) - true).mean() for one in (times, arrived)]
    assert off[1] < 1.3 * off[0]
