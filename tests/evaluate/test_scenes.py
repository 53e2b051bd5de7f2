"""Scenes made from motions: what the camera must see of a known body, and what a sensor makes of it."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend import samples
from motionmend.bodies import performer as bodies
from motionmend.bodies.camera import KINECT
from motionmend.bodies.rig import motion_landmarks, rig_of
from motionmend.bodies.skeleton import forward, rest_positions
from motionmend.bodies.surface import render
from motionmend.bodies.templates import performer_of, poses_of
from motionmend.evaluate.scenes import Plane, behind, painted, performed, room, strange, view
from motionmend.evaluate.sensor import KINECT_SENSOR, Sensor, sensed
from motionmend.evaluate.strangers import depth_of, stranger

CLIP = samples.clip("walk", seconds=0.3, fps=10.0)
LAND = motion_landmarks(CLIP)
UP = np.array([0.0, 1.0, 0.0])


@settings(max_examples=25, deadline=None)
@given(st.floats(-180, 180), st.floats(-40, 60), st.floats(1.0, 6.0), st.sampled_from(((0, 1, 0), (0, 0, 1))))
def test_the_camera_looks_at_its_target_the_right_way_up(yaw, rise, distance, up):
    target = np.array([0.3, 1.0, -0.7])
    seen = view(target, np.array(up, dtype=float), distance, yaw, rise)
    np.testing.assert_allclose(seen.turn @ target + seen.shift, (0, 0, distance), rtol=0, atol=1e-9)
    np.testing.assert_allclose(seen.turn @ seen.turn.T, np.eye(3), rtol=0, atol=1e-12)
    assert np.linalg.det(seen.turn) == pytest.approx(1.0)
    above = seen.turn @ (target + 0.1 * np.array(up)) + seen.shift
    assert above[1] < 0  # y is down
    assert abs(above[0]) < 1e-9


def test_floor_and_walls_are_where_they_are_said_to_be():
    seen = view(LAND[0, 0], UP, 3.0, rise=10.0)
    planes = room(seen, 0.0, UP)
    depth = behind(np.full((240, 320), np.nan, dtype=np.float32), KINECT, planes)
    assert np.isfinite(depth).all()
    world = (KINECT.points(depth) - seen.shift) @ seen.turn
    assert world[..., 1].min() == pytest.approx(0.0, abs=1e-4)  # nothing below the floor
    assert np.mean(np.abs(world[..., 1]) < 1e-3) > 0.2
    near = np.full((240, 320), 1.0, dtype=np.float32)
    np.testing.assert_array_equal(behind(near, KINECT, (Plane((0.0, 0.0, -1.0), -4.0),)), near)


def test_a_stranger_wraps_the_skeletons_own_joints():
    body = stranger(CLIP.skeleton, seed=4)
    for yaw in (0.0, 75.0, 180.0):
        seen = view(LAND[0, 0], UP, 3.0, yaw)
        frame = next(strange(CLIP, body, seen))
        place = LAND[0] @ seen.turn.T + seen.shift
        u, v = np.round(KINECT.project(place)).astype(int).T
        there = frame.depth[v, u]
        assert np.isfinite(there).mean() > 0.9  # joints lie on the silhouette
        inside = place[:, 2] - there
        assert np.nanmin(inside) > -0.03  # and behind its skin, not before it
        assert 0.02 < np.nanmedian(inside) < 0.25
        area = np.isfinite(frame.depth).sum() * (3.0 / KINECT.fx) ** 2
        assert 0.25 < area < 1.0  # m², a person's


def test_a_strangers_waist_lies_about_the_pelvis_even_where_hips_lie_ahead_of_it():
    """As waist markers do on CMU's skeletons, whose hips are 4 cm ahead of the root."""
    skeleton = CLIP.skeleton
    rig = rig_of(skeleton)
    left, up, ahead = rig.rests[0].T
    offsets = skeleton.offsets.copy()
    offsets[list(rig.roles.feet.hips)] += 0.04 * ahead
    for who in (skeleton, replace(skeleton, offsets=offsets)):
        body, rest = stranger(who, 3, girth=1.0), rest_positions(who)
        points = rest[body.joint] + body.place - rest[rig.roles.pelvis]
        waist = (np.abs(points @ up) < 0.03) & (np.abs(points @ left) < 0.08)
        front = (points @ ahead + body.radius)[waist].max()
        back = (points @ ahead - body.radius)[waist].min()
        assert abs(front + back) / 2 < 0.02


def test_strangers_differ_from_each_other_and_from_the_performer():
    seen = view(LAND[0, 0], UP, 3.0)
    slim, stout = (next(strange(CLIP, stranger(CLIP.skeleton, 1, girth), seen)).depth for girth in (0.85, 1.3))
    assert np.isfinite(stout).sum() > 1.15 * np.isfinite(slim).sum()
    np.testing.assert_array_equal(next(strange(CLIP, stranger(CLIP.skeleton, 1, 0.85), seen)).depth, slim)
    person = performer_of(CLIP.skeleton)
    own = next(performed(poses_of(CLIP, person).poses.moved(seen.turn, seen.shift), person)).depth
    usual = next(strange(CLIP, stranger(CLIP.skeleton, 1, 1.0), seen)).depth
    both = np.isfinite(own) & np.isfinite(usual)
    assert both.sum() > 0.7 * np.isfinite(own).sum()  # the same pose
    assert np.abs(own - usual)[both].mean() > 0.004  # another surface


def test_what_is_seen_of_a_stranger_says_which_joint_carries_it():
    body = stranger(CLIP.skeleton, 2)
    seen = view(LAND[1, 0], UP, 3.0)
    position, turned = forward(CLIP.skeleton, CLIP.q[1:2])
    depth, joint = depth_of(body, position[0], turned[0], KINECT, seen.turn, seen.shift)
    assert np.all((joint >= 0) == np.isfinite(depth))
    names = {CLIP.skeleton.names[j] for j in np.unique(joint[joint >= 0])}
    assert {"head", "thorax", "lfemur", "rtibia", "lhand", "rfoot"} <= names
    head = np.isfinite(depth) & (joint == CLIP.skeleton.names.index("head"))
    at = position[0, CLIP.skeleton.names.index("head_end")] @ seen.turn.T + seen.shift
    assert np.linalg.norm(KINECT.points(depth)[head] - at, axis=1).max() < 0.25


def test_colours_keep_their_place_on_the_body():
    person = performer_of(CLIP.skeleton)
    pose = bodies.standing((0.0, 0.0, 3.0))
    near = render(person, pose, KINECT)
    aside = render(person, bodies.Pose(np.array([0.3, 0.0, 3.0]), pose.root, pose.joints), KINECT)
    color, moved = painted(near), painted(aside)
    assert color[near.solid < 0].max() == 0
    assert color[near.solid >= 0].std() > 25
    # 0.3 m at 3 m are 28.56 px: nearly the same picture 29 columns on, quite another one at its place.
    both = (near.solid[:, :291] >= 0) & (aside.solid[:, 29:] == near.solid[:, :291])
    shift = np.abs(moved[:, 29:].astype(int) - color[:, :291])[both].mean()
    still = (near.solid >= 0) & (aside.solid >= 0)
    stay = np.abs(moved.astype(int) - color)[still].mean()
    assert shift < 0.6 * stay


def flat(z):
    return np.full((240, 320), z, dtype=np.float32)


@pytest.mark.parametrize("z", [1.0, 2.0, 4.0])
def test_noise_grows_with_the_square_of_the_distance_and_comes_in_steps(z):
    quiet = replace(KINECT_SENSOR, edge=0.0, speckle=0.0, holes=0.0, lateral=0.0)
    got = sensed(flat(z), KINECT, 3, sensor=quiet)
    step = z * z / (KINECT.fx * 2 * 0.075 * 8)
    noise = 0.0012 + 0.0019 * (z - 0.4) ** 2
    assert np.nanstd(got) == pytest.approx(np.hypot(noise, step / np.sqrt(12)), rel=0.1)
    assert np.nanmean(got) == pytest.approx(z, abs=0.1 * step + 2e-3)
    levels = np.unique(got[np.isfinite(got)])
    assert np.median(np.diff(levels)) == pytest.approx(step, rel=0.1)


def test_the_same_seed_gives_the_same_noise_and_frames_differ():
    one = sensed(flat(2.0), KINECT, 5, 7)
    np.testing.assert_array_equal(sensed(flat(2.0), KINECT, 5, 7), one)
    assert np.mean(sensed(flat(2.0), KINECT, 5, 8) != one) > 0.3
    assert np.mean(sensed(flat(2.0), KINECT, 6, 7) != one) > 0.3


def test_nothing_gives_nothing():
    assert np.isnan(sensed(flat(np.nan), KINECT, 0)).all()
    assert np.isnan(sensed(flat(20.0), KINECT, 0)).all()


def test_a_body_casts_a_shadow_on_the_wall_on_one_side_and_loses_edge_pixels():
    depth = flat(3.5)
    depth[60:180, 120:200] = 2.0
    clean = Sensor(floor=0.0, growth=0.0, lateral=0.0, edge=0.0, speckle=0.0, holes=0.0, grazing=1e-6)
    got = sensed(depth, KINECT, 0, sensor=clean)
    lost = np.isnan(got[120])
    wide = KINECT.fx * 0.075 * (1 / 2.0 - 1 / 3.5)  # px, where the projector's view of the wall is blocked
    assert lost.sum() == pytest.approx(wide, abs=1.5)
    sides = np.flatnonzero(lost)
    assert sides.max() < 120 or sides.min() >= 200


@pytest.mark.parametrize("behind", [3.5, np.nan])
def test_edges_lose_their_share_whatever_is_behind(behind):
    depth = flat(behind)
    depth[60:180, 120:200] = 2.0
    edging = Sensor(floor=0.0, growth=0.0, lateral=0.0, edge=0.5, speckle=0.0, holes=0.0, baseline=0.0)
    edged = np.isnan(sensed(depth, KINECT, 0, sensor=edging))
    inner = np.zeros_like(edged)
    inner[60:180, 120:200] = True
    inner[61:179, 121:199] = False
    assert edged[inner].mean() == pytest.approx(0.5, abs=0.1)
    rim = np.zeros_like(edged)
    rim[59:181, 119:201] = True
    rim[61:179, 121:199] = False
    assert not (edged & np.isfinite(depth))[~rim].any()
