"""What speaks against a body: lengths that nobody has, and pixels that it leaves unexplained throughout."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drawn_people import picture
from motionmend.bodies import anatomy
from motionmend.bodies.performer import BONES, standing
from motionmend.track.database import PoseDatabase
from motionmend.track.measure.plausible import doubts
from motionmend.track.model import TrackerModel
from motionmend.track.recording import follow

ADULT = anatomy.average()
FITTING = np.full(30, 0.15)


def sized(size):
    return ADULT.stretched(np.full((1, 3), size))


@pytest.mark.slow
@given(st.floats(0.42, 1.35), st.integers(0, 10**6))
def test_nobody_from_a_small_child_to_the_tallest_is_doubted(size, seed):
    limbs = np.random.default_rng(seed).normal(1.0, 0.015, (len(BONES), 3))
    assert doubts(ADULT.stretched(size * limbs), FITTING) == ()


@pytest.mark.parametrize(("size", "said"), [(2.4, "2.4 times"), (1.6, "1.6 times"), (0.2, "0.2 times")])
def test_lengths_that_nobody_has_are_said(size, said):
    (found,) = doubts(sized(size), FITTING)
    assert said in found


def test_what_is_explained_badly_throughout_is_said_and_for_a_moment_is_not():
    (found,) = doubts(ADULT, np.full(30, 0.37))
    assert "37 % of the person's pixels" in found
    assert doubts(ADULT, np.where(np.arange(30) < 14, 0.5, 0.15)) == ()
    assert doubts(ADULT, np.full(30, np.nan)) == ()


@pytest.mark.slow
def test_who_is_followed_with_the_body_of_another_is_told(rng):
    model = TrackerModel(PoseDatabase(np.zeros((0, 28)), np.zeros(0, np.int64)))
    pose = standing((0.0, 0.05, 2.4))
    child = [picture(pose, person=sized(0.63), rng=rng, time=k / 30) for k in range(8)]
    assert any("not this person's" in said for said in follow(model, child, ADULT, pose).warnings)
    assert follow(model, child, sized(0.63), pose).warnings == ()
