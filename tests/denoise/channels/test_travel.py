"""What the travelling frame makes of noise, and how sure the root's place is."""

import numpy as np
import pytest

from motionmend.denoise import repair_without_model
from motionmend.denoise.channels.joints import joint_channels, own_middle, root_deviations, root_rows
from motionmend.denoise.channels.travel import noise_followed, slow_part, travel
from motionmend.evaluate import corrupt
from performers import joints_model, truth

UP = np.array([0.0, 1.0, 0.0])


@pytest.mark.parametrize("fps", [30.0, 60.0])
def test_a_frame_errs_by_as_much_noise_as_it_is_said_to_follow(fps, rng):
    """Somebody stands under noise, and is not seen for a while."""
    noise, frames, draws = 0.02, 120, 300
    places, turns, said = [], [], []
    for _ in range(draws):
        place = noise * rng.standard_normal((frames, 3))
        heading = 0.05 * rng.standard_normal(frames)
        place[50:62] = np.nan
        frame = travel(place, heading, fps, UP)
        places.append(frame.place)
        turns.append(frame.heading)
        said.append(noise_followed(frame, place, heading, fps))
    by_place, by_heading = np.mean(said, axis=0)
    # at the ends and in the gap the constant of the two variances is another: there no less is said than is
    inner = np.r_[15:47, 65:105]
    for share, paths, unit in ((by_place, places, noise), (by_heading, np.array(turns)[..., None], 0.05)):
        wrong = np.std(paths, axis=(0, 2)) / unit
        np.testing.assert_allclose(np.sqrt(share)[inner], wrong[inner], rtol=0.2)
        assert (np.sqrt(share)[15:105] > 0.8 * wrong[15:105]).all()
        assert (np.sqrt(share)[15:105] < 1.4 * wrong[15:105]).all()
    assert by_place[56] > 1.2 * by_place[30]


@pytest.mark.parametrize("fps", [30.0, 120.0])
def test_of_each_cosine_as_much_is_left_as_is_said(fps):
    frames = round(10 * fps)
    share = slow_part(frames, fps)
    for k in (2, 10, 20, 40, 100):  # half cycles in ten seconds
        wave = np.cos(np.pi * k * (np.arange(frames) + 0.5) / frames)
        place = 0.005 * np.outer(wave, [1.0, 0.0, 0.0])
        followed = travel(place, np.zeros(frames), fps, UP).place[:, 0]
        # but where much of it is followed the ends pull straight lines
        assert abs(followed @ wave / (0.005 * wave @ wave) - share[k - 1]) < 0.06
    assert (np.diff(share) <= 0.0).all()


def test_deviations_of_the_place_turn_with_the_body():
    clean = truth("walk", seconds=3.0)
    _, moves = root_rows(clean.skeleton)
    _, frame = joint_channels(clean, own_middle(clean))
    std = np.full(clean.q.shape, 0.1)
    std[:, moves] = 0.01, 0.02, 0.03
    noise = np.full(clean.q.shape[1], 0.02)
    nowhere = np.zeros(clean.q.shape[1], dtype=bool)
    found = root_deviations(std, noise, frame, clean, nowhere)
    # along the file's axes as in the frame's, all in all; the vertical is the same in both
    np.testing.assert_allclose(np.square(found[:, moves]).sum(axis=1), np.square([0.01, 0.02, 0.03]).sum())
    upward = int(np.argmax(np.abs(clean.skeleton.dof_axis[moves] @ clean.skeleton.up)))
    np.testing.assert_allclose(found[:, moves[upward]], std[:, moves[upward]])
    others = np.setdiff1d(np.arange(clean.q.shape[1]), moves)
    np.testing.assert_array_equal(found[:, others], std[:, others])
    more = root_deviations(std, noise, frame, clean, ~nowhere)
    assert (more[:, moves] > found[:, moves]).all()


@pytest.mark.parametrize(("taught", "noise"), [(False, 1.0), (False, 1.5), (True, 1.0), (True, 3.0)])
def test_the_root_s_place_is_as_unsure_as_it_is_wrong(taught, noise):
    """Places are in noise of a centimetre for each degree."""
    within = []
    for seed, action in enumerate(("walk", "run", "reach", "turn", "walk", "jump")):
        clean = truth(action, seconds=5.0, fps=(30.0, 60.0)[seed % 2])
        noisy = corrupt(clean, noise=np.radians(noise), seed=seed).recording
        outcome = joints_model().repair(noisy) if taught else repair_without_model(noisy)
        _, moves = root_rows(clean.skeleton)
        off = np.abs(outcome.recording.q - clean.q)[:, moves] / outcome.std[:, moves]
        within.append([(off < 1.0).mean(), (off < 1.96).mean()])
    one, two = np.mean(within, axis=0)
    assert abs(one - 0.68) < 0.1, within
    assert 0.89 < two < 0.99, within
