"""How far joints may be from a pose that the image denies."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionmend.bodies.camera import KINECT, DepthFrame
from motionmend.bodies.performer import BONES, LANDMARKS, landmarks
from motionmend.bodies.surface import render
from motionmend.track.limbs.certainty import NOBODYS, WITHIN, astray, bare_of
from motionmend.track.settings import settings_of
from motionmend.track.tracker import start, step
from walkers import BODY, DT, as_sensed, library, walk

SHARES = st.floats(0.0, 1.0)
SHOWN = np.full(len(BONES), 40.0)


@given(SHARES, SHARES, SHARES)
def test_the_more_is_explained_wrongly_the_less_sure(usual, one, other):
    nothing = np.zeros(len(BONES))
    less, more = (astray(SHOWN, nothing, nothing, wrong, usual) for wrong in sorted((one, other)))
    assert (more >= less).all()
    assert (less >= 0.0).all()


@given(SHARES)
def test_what_is_usual_excuses_little_of_the_body_but_not_a_third(usual):
    nothing = np.zeros(len(BONES))
    assert not astray(SHOWN, nothing, nothing, min(usual, NOBODYS), usual).any()
    assert (astray(SHOWN, nothing, nothing, 0.45, usual) > 0.1).all()
    np.testing.assert_array_equal(
        astray(SHOWN, nothing, nothing, usual, np.nan), astray(SHOWN, nothing, nothing, usual, usual)
    )


def test_a_limb_that_is_not_there_is_in_doubt_alone():
    denied = np.where([bone.startswith("l_forearm") for bone in BONES], 60.0, 0.0)
    found = astray(np.where(denied > 0, 0.0, SHOWN), denied, np.zeros(len(BONES)), 0.1, 0.1)
    assert 0 < np.count_nonzero(found) < 4
    assert found.max() > 0.2


def bare(arm, unknown, before, elapsed):
    """Of an arm of 40 samples, so many of which lie where nothing is measured."""
    nothing = np.zeros(len(BONES))
    return bare_of(before, np.where(arm, 40.0 - unknown, SHOWN), nothing, np.where(arm, unknown, 0.0), elapsed)


def test_a_limb_that_mostly_lies_where_nothing_is_measured_is_in_doubt_if_it_goes_on():
    """Arms behind the back were laid into the sensor's shadow and the outline's lost pixels: no pixel denied them."""
    nothing, never = np.zeros(len(BONES)), np.full(len(BONES), np.nan)
    arm = np.array([bone.startswith("l_forearm") for bone in BONES])

    def doubt(share):
        return astray(SHOWN, nothing, share, 0.1, 0.1)

    assert 0.05 < doubt(bare(arm, 26.0, never, 0.0)).max() < 0.1
    assert 0 < np.count_nonzero(doubt(bare(arm, 26.0, never, 0.0))) < 4
    assert not doubt(bare(arm, 12.0, never, 0.0)).any()
    share = bare(arm, 8.0, never, 0.0)
    doubts = []
    for _ in range(30):
        share = bare(arm, 26.0, share, 1 / 30)
        doubts.append(doubt(share).max())
    assert doubts[0] == 0.0
    assert doubts[3] < 0.05 < doubts[-1]
    assert (np.diff(doubts) >= 0.0).all()


@pytest.mark.slow
@pytest.mark.parametrize("heading", [0.0, 60.0])
def test_how_deep_a_joint_lies_beneath_the_surface_is_not_known_of_who_is_stouter(heading):
    """Every pixel agrees on where the surface is: half of these joints were out of 95 % of what was said."""
    wide = np.ones((len(BONES), 3))
    wide[[BONES.index(bone) for bone in ("pelvis", "chest")]] = 1.3, 1.0, 1.3
    stout = replace(BODY, solids=BODY.stretched(wide).solids)  # the same joints beneath another surface
    settings, model = settings_of(), library()
    deep, state, off = [LANDMARKS.index(name) for name in WITHIN], None, []
    for k, pose in enumerate(walk(12, heading)):
        frame = DepthFrame(KINECT, as_sensed(render(stout, pose, KINECT).depth, KINECT, 0, k), None, k * DT)
        state = start(model, settings, frame, BODY, pose) if state is None else state
        state, estimate = step(model, settings, state, frame)
        off.append((np.linalg.norm(estimate.landmarks - landmarks(stout, pose), axis=1) / estimate.std)[deep])
    within = 2.795  # standard deviations of one coordinate, in which 95 % of the distances in space are
    assert np.mean(np.array(off) < within) > 0.9
