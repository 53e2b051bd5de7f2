"""Recordings without background: where somebody is cut off nothing is known, and who is apart is somebody else."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import motionmend as mm
from drawn_people import CAMERA, PERSON, picture, random_joints, turned
from motionmend.bodies.camera import DepthFrame
from motionmend.bodies.performer import DOFS, LANDMARKS, Pose, advance, landmarks, standing
from motionmend.bodies.surface import render
from motionmend.track.database import PoseDatabase
from motionmend.track.person.foreground import find_person, scene_of
from motionmend.track.person.pixels import person_of
from motionmend.track.person.standing import looked_at, with_furniture
from motionmend.track.person.window import lines_of, reached, untold

SIDES = ("top", "bottom", "left", "right")


def somebody(seed, far=3.0, aside=0.0):
    rng = np.random.default_rng(seed)
    pose = turned(standing((aside, 0.1, far)), rng.uniform(-3, 3))
    return Pose(pose.translation, pose.root, random_joints(rng))


def cut_off(depth, side, share):
    """The image without what is beyond a line, which leaves a share of the person's rows or columns; and beyond."""
    on = np.isfinite(depth)
    lines = np.flatnonzero(on.any(axis=1 if side in ("top", "bottom") else 0))
    at = int(lines[0] + (share if side in ("bottom", "right") else 1 - share) * (lines[-1] - lines[0]))
    beyond = np.zeros(depth.shape, bool)
    beyond[{"top": np.s_[:at], "bottom": np.s_[at + 1 :], "left": np.s_[:, :at], "right": np.s_[:, at + 1 :]}[side]] = (
        True
    )
    return np.where(beyond, np.float32(np.nan), depth), beyond


def first_seen(depth):
    return person_of(scene_of(DepthFrame(CAMERA, depth)), DepthFrame(CAMERA, depth), None, 1)


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10_000), side=st.sampled_from(("top", "bottom")), share=st.floats(0.45, 0.7))
def test_the_body_beyond_a_cut_is_nowhere_forbidden(seed, side, share):
    whole = render(PERSON, somebody(seed), CAMERA).depth
    depth, beyond = cut_off(whole, side, share)
    person, scene = first_seen(depth)
    cut = bool(scene.window.cut[SIDES.index(side)])
    assert person.free[beyond].any() != cut
    assert not cut or not person.free[np.isfinite(whole)].any()
    assert person.free[~beyond].mean() > 0.5  # beside the person nobody is, as ever


@pytest.mark.parametrize("side", ["top", "bottom"])
@pytest.mark.parametrize("share", [0.45, 0.6, 0.7])
def test_nine_of_ten_who_are_cut_off_are_known_to_be(side, share):
    found = []
    for seed in range(40):
        depth, _ = cut_off(render(PERSON, somebody(seed), CAMERA).depth, side, share)
        found.append(reached(None, lines_of(depth, CAMERA)).cut[SIDES.index(side)])
    assert np.mean(found) > 0.9


def test_whole_bodies_do_not_end_as_if_cut():
    found = [
        reached(None, lines_of(picture(somebody(k), rng=np.random.default_rng(k)).depth, CAMERA)).cut.any()
        for k in range(60)
    ]
    assert not any(found)


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize(("tall", "cut"), [(0.3, False), (0.55, False), (0.9, True)])
def test_the_straight_side_of_a_limb_is_no_cut_that_of_most_of_a_body_is(side, tall, cut):
    depth = np.full((CAMERA.height, CAMERA.width), np.nan, np.float32)
    depth[40:200, 140:180] = 2.5  # a trunk
    depth[120 - 60 : 120 - 60 + round(tall * CAMERA.fy / 2.5), 128:192] = 2.5  # and what hangs at its sides
    window = reached(None, lines_of(depth, CAMERA))
    assert window.cut[SIDES.index(side)] == cut


def in_blocks(depth, rows=4):
    """The image with what shows feet and floor taken away in blocks, as in recordings whose background was."""
    lines = np.flatnonzero(np.isfinite(depth).any(axis=1))
    end = (lines[-1] + 1) // rows * rows - rows
    return np.where(np.arange(len(depth))[:, None] < end, depth, np.float32(np.nan))


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10_000), far=st.floats(2.6, 5.0))
def test_feet_that_end_with_the_floor_are_not_cut_off_nor_is_who_crouches_there_later(seed, far):
    rng = np.random.default_rng(seed)
    pose = turned(standing((0.0, 0.1, far)), rng.uniform(-3, 3))
    depth = in_blocks(picture(pose, rng=rng).depth)
    window = reached(None, lines_of(depth, CAMERA))
    assert not window.cut.any()
    low, _ = cut_off(depth, "top", 0.5)
    assert not reached(window, lines_of(low, CAMERA)).cut[1]


@pytest.mark.parametrize("border", ["top", "bottom"])
def test_near_an_images_border_a_line_tells_nothing(border):
    depth = np.full((CAMERA.height, CAMERA.width), np.nan, np.float32)
    depth[{"top": np.s_[20:150, 100:220], "bottom": np.s_[90:220, 100:220]}[border]] = 2.5
    assert reached(None, lines_of(depth, CAMERA)).cut.tolist() == [border != "top", border != "bottom", True, True]


@pytest.mark.parametrize("side", SIDES)
def test_a_cut_is_remembered_until_something_is_beyond(side):
    whole = render(PERSON, standing((0.0, 0.1, 3.0)), CAMERA).depth
    depth, beyond = cut_off(whole, side, 0.6)
    window = reached(None, lines_of(depth, CAMERA))
    assert window.cut[SIDES.index(side)]
    nothing = np.full(depth.shape, np.nan, np.float32)
    assert reached(window, lines_of(nothing, CAMERA)) is window
    inner, _ = cut_off(depth, side, 0.7)  # somebody who does not reach the line now
    assert untold(reached(window, lines_of(inner, CAMERA)), lines_of(inner, CAMERA))[beyond].all()
    assert not reached(window, lines_of(whole, CAMERA)).cut[SIDES.index(side)]


def test_rows_without_anything_amid_the_person_hide_them():
    whole = render(PERSON, somebody(5), CAMERA).depth
    depth = np.array(whole)
    depth[110:135] = np.nan
    person, _ = person_of(scene_of(DepthFrame(CAMERA, depth)), DepthFrame(CAMERA, depth), None, 1)
    assert not person.free[110:135].any()
    assert not person.free[np.isfinite(whole)].any()


def walked(frames=24):
    """Somebody who steps aside and lifts the arms."""
    speed = np.zeros(DOFS)
    speed[[0, 4, 12, 20]] = 0.3, 0.4, 0.5, 0.4
    return [advance(PERSON, standing((0.0, 0.1, 2.6)), speed * t / 30.0) for t in range(frames)]


POSES = walked()
MODEL = mm.TrackerModel(PoseDatabase(np.array([pose.joints for pose in POSES]), np.full(len(POSES), len(POSES) - 1)))
PLACES = np.array([landmarks(PERSON, pose) for pose in POSES])


def followed(depths, start=0):
    frames = [DepthFrame(CAMERA, depth, None, t / 30.0) for t, depth in enumerate(depths)]
    return mm.track.follow(MODEL, frames, PERSON, POSES[start])


@pytest.mark.slow
@pytest.mark.parametrize(("first", "last"), [(150, 240), (0, 92), (118, 136)])
def test_who_is_cut_off_is_not_squeezed_into_what_is_seen(first, last):
    depths = [np.array(render(PERSON, pose, CAMERA).depth) for pose in POSES]
    for depth in depths:
        depth[first:last] = np.nan
    tracked = followed(depths)
    assert tracked.seen.all()
    off = np.linalg.norm(tracked.joints - PLACES, axis=2)
    rows = CAMERA.project(PLACES)[..., 1]
    assert off[(rows < first - 5) | (rows > last + 5)].max() < 0.05
    assert (off < np.maximum(0.05, 3 * tracked.std)).all()
    if last == CAMERA.height:
        ankles = [LANDMARKS.index(name) for name in ("l_ankle", "r_ankle")]
        assert tracked.held[5:, ankles].all()


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10_000), far=st.floats(2.8, 4.0), behind=st.floats(-0.3, 0.9))
def test_one_body_hangs_together_and_two_that_are_apart_do_not(seed, far, behind):
    alone = render(PERSON, somebody(seed, far), CAMERA).depth
    person, scene = person_of(scene_of(DepthFrame(CAMERA, alone)), DepthFrame(CAMERA, alone), None, 0)
    assert np.isfinite(person.depth[np.isfinite(alone)]).all()
    # and somebody else comes into view beside them
    other = render(PERSON, turned(standing((1.6, 0.1, far + behind)), seed), CAMERA).depth
    both = np.fmin(alone, other)
    person, _ = person_of(scene, DepthFrame(CAMERA, both, None, 0.1), person.place, 0)
    theirs = np.isfinite(person.depth) & (np.abs(both - alone) < 1e-6)
    assert theirs.sum() > 0.95 * np.isfinite(person.depth).sum()
    assert theirs.sum() > 0.9 * np.isfinite(alone).sum()
    assert person.free.mean() > 0.5


def test_who_walks_through_without_background_is_not_followed():
    depths = []
    for t, pose in enumerate(POSES):
        other = turned(standing((1.9 - 0.03 * t, 0.1, 3.4)), 1.6)
        depths.append(np.fmin(render(PERSON, pose, CAMERA).depth, render(PERSON, other, CAMERA).depth))
    tracked = followed(depths)
    assert tracked.seen.all()
    assert np.linalg.norm(tracked.joints - PLACES, axis=2).max() < 0.06


def test_a_table_before_the_person_is_furniture_where_no_room_is_behind(rng):
    frames = []
    for t, pose in enumerate(POSES):
        depth = np.array(picture(pose, rng=rng).depth)
        front = 1.7 + rng.normal(0, 0.0015, (90, 260)) * 1.7**2
        depth[150:, 30:290] = front.astype(np.float32)
        frames.append(DepthFrame(CAMERA, depth, None, t / 30.0))
    scene = with_furniture([frames[k] for k in looked_at(len(frames))])
    assert scene is not None
    for frame, pose in zip(frames, POSES, strict=True):
        found = np.isfinite(find_person(scene, frame).depth)
        theirs = np.isfinite(render(PERSON, pose, CAMERA).depth[:150])
        assert not found[152:].any()
        assert (found[:150] & theirs).sum() > 0.9 * theirs.sum()


def test_who_stands_alone_is_no_furniture_whatever_they_do(rng):
    frames = [picture(POSES[0], rng=rng, time=t / 30.0) for t in range(12)]
    assert with_furniture(frames) is None
