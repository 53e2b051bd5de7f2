"""A frame on its way to another process: nothing of it is lost."""

import pickle

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.bodies.camera import Camera
from motionmend.track.frame.observation import Observation


@given(st.integers(1, 40), st.integers(1, 40), st.floats(0.0, 1.0), st.booleans(), st.integers(0, 2**32 - 1))
@settings(max_examples=60, deadline=None)
def test_an_observation_comes_out_of_a_pickle_as_it_went_in(width, height, share, more, seed):
    rng = np.random.default_rng(seed)
    depth = np.where(rng.random((height, width)) < share**3, rng.uniform(0.5, 4.0, (height, width)), np.nan)
    free = rng.random((height, width)) < 0.5
    intensity = rng.uniform(0.0, 255.0, (height, width)) if more else None
    rim = rng.random((height, width)) < 0.1 if more else None
    went = Observation(Camera(width, height, 100.0, 101.0, width / 2, height / 3), depth, free, 1.25, intensity, rim)
    came = pickle.loads(pickle.dumps(went))
    assert (came.camera, came.time) == (went.camera, went.time)
    for name in ("depth", "free", "intensity", "rim"):
        one, other = getattr(went, name), getattr(came, name)
        if one is None:
            assert other is None
        else:
            np.testing.assert_array_equal(one, other)
            assert (other.dtype, other.flags.writeable) == (one.dtype, False)


def test_what_shows_little_of_a_person_travels_as_little():
    depth = np.full((240, 320), np.nan)
    depth[60:180, 140:190] = 2.5
    seen = Observation(Camera(320, 240, 285.0, 285.0, 160.0, 120.0), depth, np.isnan(depth), 0.0)
    assert len(pickle.dumps(seen)) < (seen.depth.nbytes + seen.free.nbytes) / 8
