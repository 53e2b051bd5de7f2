"""Who sits at a desk: one surface with it, of which the level top never moves."""

import numpy as np
import pytest

from drawn_people import CAMERA, PERSON, in_room, picture
from motionmend.bodies.camera import DepthFrame
from motionmend.bodies.performer import Pose, standing
from motionmend.bodies.surface import render
from motionmend.track.detect.joints import _behind
from motionmend.track.person.desks import top_in, vertical
from motionmend.track.person.foreground import find_person
from motionmend.track.person.standing import with_furniture

BACK, FRONT, TOP = 2.5, 1.8, 0.32  # m, the desk's edges from the camera, and how far below it its top is
UP = np.array([0.0, -1.0, 0.0])


def desk():
    """(H, W) m, a desk's top that reaches to the person, and a panel down to the floor before it."""
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width].astype(np.float64)
    with np.errstate(divide="ignore"):
        away = np.where(v > CAMERA.cy, TOP * CAMERA.fy / np.maximum(v - CAMERA.cy, 1e-9), np.inf)
    top = np.where((away > FRONT) & (away < BACK), away, np.inf)
    depth = np.minimum(top, np.where((v - CAMERA.cy) * FRONT >= TOP * CAMERA.fy, FRONT, np.inf))
    with np.errstate(invalid="ignore"):
        depth[np.abs((u - CAMERA.cx) * depth) > 0.7 * CAMERA.fx] = np.inf
    return depth


@pytest.mark.slow
def test_a_desk_is_told_from_who_sits_at_it(rng):
    base, table, frames, shown = standing((0.0, 0.1, 2.55)), desk(), [], []
    for k in range(12):
        joints = np.array(base.joints)
        joints[:-8] += rng.normal(0, 0.05, len(joints) - 8)
        pose = Pose(base.translation + np.array([0.0, 0.0, 0.006 * np.sin(1.3 * k)]), base.root, joints)
        noisy = table + rng.normal(0, 0.0015, table.shape) * np.where(np.isfinite(table), table, 0.0) ** 2
        depth = np.fmin(in_room(picture(pose, rng=rng), rng=rng).depth, noisy.astype(np.float32))
        frames.append(DepthFrame(CAMERA, depth, None, k / 5.0))
        shown.append(render(PERSON, pose, CAMERA).depth < table)
    scene = with_furniture(frames)
    assert scene is not None
    for k in (0, 11):
        found = np.isfinite(find_person(scene, frames[k]).depth)
        assert (found & shown[k]).sum() > 0.9 * shown[k].sum()
        assert (found & ~shown[k]).sum() < 0.1 * shown[k].sum()


def test_a_level_piece_is_a_desk_and_nothing_of_a_person_is():
    table, person = desk().astype(np.float32), render(PERSON, standing((0.0, 0.1, 2.55)), CAMERA).depth
    both = np.fmin(person, table)
    both[~np.isfinite(both)] = np.nan
    top = top_in(CAMERA, both, both, np.isfinite(both), UP)
    assert top is not None
    assert (top & ~(table == both)).sum() < 0.03 * top.sum()
    assert top_in(CAMERA, table, table, np.isfinite(table), UP) is None  # with nobody at it
    for far in (1.2, 2.4, 4.0):
        alone = render(PERSON, standing((0.0, 0.1, far)), CAMERA).depth
        assert top_in(CAMERA, alone, alone, np.isfinite(alone), UP) is None


def test_who_ends_at_a_desk_is_cut_off_and_who_shows_below_it_is_not():
    person = render(PERSON, standing((0.0, 0.1, 2.55)), CAMERA).depth
    rows = np.arange(CAMERA.height)[:, None] * np.ones((1, CAMERA.width))
    for low, ends in ((240, True), (150, False)):
        furniture = (rows > 130) & (rows < low)
        behind = DepthFrame(CAMERA, np.where(furniture, np.float32(np.nan), person), None, 0.0)
        assert _behind(behind, furniture) == ends
        assert not _behind(behind, None)


@pytest.mark.parametrize("lean", [-20.0, 0.0, 30.0])
def test_up_is_told_from_the_floor_or_else_from_walls(lean):
    lean = np.radians(lean)
    floor = np.array([0.0, -np.cos(lean), -np.sin(lean), 1.0])
    wall = np.array([0.0, np.sin(lean), -np.cos(lean), 4.0])
    for planes in ([floor], [wall], [wall, floor], [wall, np.array([1.0, 0.0, 0.0, 2.0])]):
        np.testing.assert_allclose(vertical(np.array(planes)), floor[:3], atol=1e-9)
    assert vertical(np.empty((0, 4))) is None
