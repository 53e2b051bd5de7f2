"""What the travelling frame makes of noise."""

import numpy as np
import pytest

from motionmend.denoise.channels.travel import noise_followed, slow_part, travel

UP = np.array([0.0, 1.0, 0.0])


@pytest.mark.slow
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
