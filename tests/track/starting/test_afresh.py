"""A body that was taken up wrongly at the start, and explains the images badly ever since, is looked for anew."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionmend.bodies.camera import KINECT, DepthFrame
from motionmend.bodies.performer import Pose, Poses, rotation
from motionmend.bodies.surface import render
from motionmend.evaluate.sensor import sensed
from motionmend.numerics.neighbors import Neighbors
from motionmend.track import tracker
from motionmend.track.detect.joints import fit_detector
from motionmend.track.measure import first_seconds as measure
from motionmend.track.misread import odds_misread
from motionmend.track.readings.facing import about_face, faces_otherwise
from motionmend.track.settings import settings_of
from motionmend.track.starting.afresh import DOUBTED, FIRST, LAST, Afresh, better, watched
from motionmend.track.starting.look import taken_up
from motionmend.track.state import Facing
from motionmend.track.tracker import start, step
from walkers import BODY, DT, column, library, off, walk, walking


@pytest.fixture(scope="module")
def model():
    """The strides with a detector that has seen them from all sides."""
    strides = [walking(0.7 * k, (0.1 * (k % 5 - 2), 0.05, 2.6 + 0.2 * (k % 4)), 37.0 * k, 0.5) for k in range(160)]
    poses = Poses(*(np.array([getattr(one, name) for one in strides]) for name in ("translation", "root", "joints")))
    return replace(library(), detector=fit_detector(poses, [BODY], seed=0, count=160, trees=2))


def twisted(pose, much=1.0):
    """The pose with the pelvis turned to the camera, the chest farther and the legs against both."""
    joints = np.array(pose.joints)
    joints[column("chest", 1)] = 1.1 * much
    joints[column("l_thigh", 1)] -= 1.0 * much
    joints[column("r_thigh", 1)] -= 1.0 * much
    return Pose(pose.translation, rotation(np.array([0.0, 1.6 * much, 0.0])) @ pose.root, joints)


@cache
def seen(frames, heading, k):
    """Frame k of somebody who walks: drawn once for all tests, which takes longer than to follow them."""
    return DepthFrame(KINECT, sensed(render(BODY, walk(frames, heading)[k], KINECT).depth, KINECT, 0, k), None, k * DT)


@pytest.mark.slow
@pytest.mark.parametrize("heading", [75.0, -100.0])
def test_who_was_taken_up_wrongly_is_found(model, heading):
    """Such a pose is usual by now, and the questions of front and back, and left and right, lead nowhere."""
    poses = walk(40, heading)
    settings, state, errors = settings_of(), None, []
    for k, pose in enumerate(poses):
        frame = seen(40, heading, k)
        if state is None:
            begun = start(model, settings, frame, BODY, twisted(about_face(BODY, poses[0])))
            state = replace(begun, wrong=0.4, afresh=Afresh())
        state, estimate = step(model, settings, state, frame)
        errors.append(off(estimate.pose, pose))
    assert state.afresh is None
    assert min(errors[3:10]) > 0.1
    assert max(errors[-5:]) < 0.06


@pytest.mark.slow
@pytest.mark.parametrize(("heading", "much"), [(75.0, 0.8), (110.0, 0.8), (110.0, 0.6)])
def test_who_may_well_be_followed_wrongly_is_looked_for_as_well(model, heading, much):
    """Less twisted they were asked of front and back alone, half as long again and more, or to the end of a short take.

    What is found has to be clearly better: so little is needed for a look.
    """
    poses = walk(40, heading)[:22]
    settings, state, errors = settings_of(), None, []
    for k, pose in enumerate(poses):
        frame = seen(40, heading, k)
        if state is None:
            begun = start(model, settings, frame, BODY, twisted(about_face(BODY, poses[0]), much))
            state = replace(begun, wrong=0.2, afresh=Afresh())
        state, estimate = step(model, settings, state, frame)
        errors.append(off(estimate.pose, pose))
    assert min(errors[3 : round(FIRST / DT) - 1]) > 0.06
    assert max(errors[round(FIRST / DT) + 2 :]) < 0.03


@pytest.mark.slow
def test_what_was_told_of_front_and_back_goes_on_unless_it_is_another_reading_that_is_found(model, monkeypatch):
    looks = []

    def spied(sight, fit, ways):
        looks.append((sight, fit, ways))
        return taken_up(sight, fit, ways)

    monkeypatch.setattr(tracker, "taken_up", spied)
    poses, told = walk(20, 75.0), Facing(odds=-40.0, wait=9.0)
    state = None
    for frame in (seen(20, 75.0, k) for k in range(20)):
        if state is None:
            begun = start(model, settings_of(), frame, BODY, twisted(about_face(BODY, poses[0])))
            state = replace(begun, wrong=0.4, afresh=Afresh(), facing=told)
        state, _ = step(model, settings_of(), state, frame)
    (sight, fit, ways), *_ = looks
    fit = replace(fit, state=replace(fit.state, facing=told), wrong=0.9)
    for before, known in ((twisted(ways[0], 0.5), told), (twisted(about_face(BODY, ways[0]), 0.5), Facing(odds=0.0))):
        found = taken_up(sight, replace(fit, solution=replace(fit.solution, state=before)), ways)
        assert found is not None
        assert faces_otherwise(before, found.pose) == (known is not told)
        assert found.state.facing.odds == known.odds


@pytest.mark.slow
@pytest.mark.parametrize("is_given", [True, False])
def test_who_is_followed_rightly_is_never_looked_for(model, is_given):
    poses = walk(20, 30.0)
    state, open_for = None, 0
    for frame in (seen(20, 30.0, k) for k in range(20)):
        if state is None:
            state = start(model, settings_of(), frame, BODY, poses[0] if is_given else None)
        state, estimate = step(model, settings_of(), state, frame)
        open_for += state.afresh is not None
        assert state.afresh is None or not state.afresh.doubted
        assert "recovered" not in estimate.flags
    assert open_for == (0 if is_given else round(FIRST / DT) + 1)


@pytest.mark.slow
def test_nobody_is_looked_for_anew_while_measured(model, monkeypatch):
    """What a body explains badly that is not the person's says nothing of the pose."""
    before = []

    def spied(fitted, settings, state, frame):
        before.append(state)
        return step(fitted, settings, state, frame)

    monkeypatch.setattr(measure, "step", spied)
    measure.measure_person(model, settings_of(), [seen(12, 30.0, k) for k in range(0, 12, 3)])
    assert len(before) >= 4
    assert all(state.afresh is None for state in before)


@given(st.lists(st.floats(0.0, 0.2), max_size=60))
def test_it_is_looked_for_ever_more_seldom_and_not_for_good(frames):
    search, pose = library().database.search, twisted(walking(0.5, (0, 0, 3), 0.0))
    afresh, looks = Afresh(), []
    for elapsed in frames:
        if afresh is not None and afresh.due:
            assert afresh.doubted
            looks.append(afresh.look)
            afresh = afresh.later
        if afresh is not None:
            afresh = watched(afresh, elapsed, odds_misread(search, pose, 0.5))
    assert looks == [FIRST * 2**k for k in range(len(looks))]
    assert all(look <= LAST for look in looks)


def test_only_who_bends_strangely_and_explains_badly_ever_since_is_doubted():
    search = library().database.search
    right, wrong = walking(0.5, (0, 0, 3), 0.0), twisted(walking(0.5, (0, 0, 3), 0.0))
    assert watched(Afresh(), DT, odds_misread(search, wrong, 0.5)).doubted
    assert not watched(Afresh(), DT, odds_misread(search, right, 0.5)).doubted
    assert not watched(Afresh(), DT, odds_misread(search, right, 0.15)).doubted
    assert not watched(Afresh(), DT, odds_misread(Neighbors(np.empty((0, 28))), wrong, 0.5)).doubted
    assert not Afresh().doubted
    lately = Afresh(odds=-8.0 * 14, frames=14, time=14 * DT)
    assert not watched(lately, DT, odds_misread(search, wrong, 0.5)).doubted
    assert odds_misread(search, wrong, 0.5) > DOUBTED


def test_only_what_is_clearly_better_and_likely_right_is_taken():
    search = library().database.search
    right, wrong = walking(0.5, (0, 0, 3), 0.0), twisted(walking(0.5, (0, 0, 3), 0.0))
    assert better(search, wrong, 0.3, right, 0.2)
    assert not better(search, right, 0.3, wrong, 0.3)
    assert not better(search, wrong, 0.9, wrong, 0.7)  # better, but no good either
    assert not better(search, right, 0.21, right, 0.2)
    assert better(search, wrong, 0.3, right, 0.2, 1.0)
    assert not better(search, wrong, 0.3, right, 0.2, -1e3)  # something else speaks against it


@pytest.mark.slow
def test_who_is_lost_is_looked_for_in_one_frame_of_four_and_found_when_they_are_back(model, monkeypatch):
    """A look takes as long as many frames: something that no pose explains had one in every frame or two."""
    looks, found = [], tracker.look_for_body

    def spied(*args):
        looks.append(args)
        return found(*args)

    monkeypatch.setattr(tracker, "look_for_body", spied)
    poses = walk(40, 30.0)
    rows, columns = np.mgrid[: KINECT.height, : KINECT.width]
    wide = 1.0 - ((columns - KINECT.cx) ** 2 + (rows - KINECT.cy) ** 2) / 80.0**2
    ball = np.where(wide > 0.0, 2.7 - 0.7 * np.sqrt(np.maximum(wide, 0.0)), np.nan).astype(np.float32)
    state, flags, errors = start(model, settings_of(), seen(40, 30.0, 0), BODY, poses[0]), [], []
    for k in range(len(poses)):
        begun = len(looks)
        frame = DepthFrame(KINECT, ball, None, k * DT) if 4 <= k < 28 else seen(40, 30.0, k)
        state, estimate = step(model, settings_of(), state, frame)
        assert len(looks) - begun <= 1
        flags.append("lost" in estimate.flags)
        errors.append(off(estimate.pose, poses[k]))
    assert all(flags[5:28])
    assert 5 <= len(looks) <= 8
    assert max(errors[-5:]) < 0.06
