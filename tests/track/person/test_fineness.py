"""Cameras of other resolutions and lenses, made about as fine as the first Kinect."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.bodies.anatomy import average
from motionmend.bodies.camera import KINECT, Camera, DepthFrame
from motionmend.bodies.performer import standing
from motionmend.bodies.surface import render
from motionmend.track.frame.evidence import evidence_of
from motionmend.track.frame.observation import Observation
from motionmend.track.person.fineness import evened
from motionmend.track.settings import settings_of

FINE = Camera(640, 480, 571.26, 571.26, 320.0, 240.0)
WIDE = Camera(512, 512, 252.0, 252.0, 256.0, 256.0)


@pytest.mark.slow
@given(st.floats(-0.4, 0.4), st.floats(-0.4, 0.4), st.floats(1.0, 4.0), st.sampled_from([2, 3]))
@settings(max_examples=20, deadline=None)
def test_a_plane_stays_where_it_is(right, down, away, step):
    camera = Camera(640, 480, step * KINECT.fx, step * KINECT.fx, 320.0, 240.0)
    u, v = np.meshgrid(np.arange(640), np.arange(480))
    rays = np.stack(((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, np.ones(u.shape)), axis=-1)
    normal = np.array([right, down, 1.0])
    seen = evened(DepthFrame(camera, (away / (rays @ normal)).astype(np.float32)))
    points = seen.camera.points(seen.depth)[1:-1, 1:-1]
    np.testing.assert_allclose(points @ normal, away, rtol=2e-4)


def test_noise_is_averaged_out_and_outlines_stay(rng):
    true = render(average(), standing((0.0, 0.1, 2.8)), FINE).depth
    noisy = (true + rng.normal(0, 0.01, true.shape)).astype(np.float32)
    seen = evened(DepthFrame(FINE, noisy)).depth
    clean = evened(DepthFrame(FINE, true)).depth
    inside = np.isfinite(seen) & np.isfinite(clean)
    assert np.median(np.abs(seen - clean)[inside]) < 0.6 * np.median(np.abs(noisy - true)[np.isfinite(true)])
    # Half of a block or more: no pixel beside the body, and no limb eaten away.
    assert np.isfinite(clean).sum() == pytest.approx(np.isfinite(true).sum() / 4, rel=0.04)


@given(st.floats(100, 2000))
def test_what_was_evened_stays(fx):
    once = evened(DepthFrame(Camera(64, 48, fx, fx, 32.0, 24.0), np.full((48, 64), 2.0, np.float32)))
    assert evened(once) is once


def test_colours_are_those_of_the_block():
    color = np.zeros((480, 640, 3), np.uint8)
    color[:, 1::2] = 200
    seen = evened(DepthFrame(FINE, np.full((480, 640), 2.0, np.float32), color))
    assert (seen.color[:, :-1] == 100).all()


def test_a_wide_lens_keeps_all_its_pixels():
    """A body has as many of them as before a Kinect, however wide the image is."""
    frame = DepthFrame(WIDE, np.full((512, 512), 3.0, np.float32))
    assert evened(frame) is frame


@pytest.mark.parametrize("camera", [KINECT, FINE, WIDE])
def test_a_pixel_of_the_raster_is_two_centimetres_of_a_body(camera):
    """At a person's usual distance, by any camera; farther off it does not grow."""
    for away in (2.8, 5.0):
        seen = evened(DepthFrame(camera, render(average(), standing((0.0, 0.1, away)), camera).depth))
        free = np.isnan(seen.depth)
        evidence = evidence_of(Observation(seen.camera, seen.depth, free, 0.0), settings_of("default"))
        assert 0.012 < away / evidence.camera.fx < 0.028


@pytest.mark.parametrize("none", [0.0, -1.5, np.inf, -np.inf])
@pytest.mark.parametrize("camera", [KINECT, FINE])
def test_what_is_no_distance_is_no_return(camera, none):
    depth = np.full((camera.height, camera.width), 2.5, np.float32)
    depth[: camera.height // 2] = none
    bare = np.where(depth == 2.5, depth, np.float32(np.nan))
    np.testing.assert_array_equal(evened(DepthFrame(camera, depth)).depth, evened(DepthFrame(camera, bare)).depth)


@pytest.mark.parametrize("camera", [KINECT, FINE])
def test_what_blends_a_body_and_the_wall_behind_is_of_neither(camera):
    """Flying pixels, and the bridges of images made finer than they were measured: limbs grew by them."""
    true = render(average(), standing((0.0, 0.1, 2.8)), camera).depth
    sharp = np.where(np.isfinite(true), true, np.float32(3.8))
    blurred = cv2.GaussianBlur(sharp, (0, 0), 1.2 * camera.fx / KINECT.fx)
    seen = evened(DepthFrame(camera, blurred))
    wanted = evened(DepthFrame(camera, sharp))
    amid = (seen.depth > 3.1) & (seen.depth < 3.6)
    assert amid.sum() < 0.02 * (wanted.depth < 3.5).sum()  # 0.08 and more as they come
    within = cv2.erode((wanted.depth < 3.5).astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
    assert np.isfinite(seen.depth[within]).mean() > 0.98  # nothing but the rim goes
    assert evened(seen) is seen


def test_a_floor_seen_along_itself_stays():
    """Farther by a leap from row to row, all the way to the wall: a camera that lies on it."""
    down = np.maximum(np.arange(240.0) - 119.0, 1e-3)[:, None]
    floor = np.minimum(0.15 * KINECT.fy / down, 8.0) * np.ones((1, 320))
    frame = DepthFrame(KINECT, floor.astype(np.float32))
    assert evened(frame) is frame
