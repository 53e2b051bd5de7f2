"""Pixels and points."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionmend.bodies.camera import KINECT, Camera, DepthFrame
from motionmend.errors import MismatchError


@given(st.floats(-2, 2), st.floats(-2, 2), st.floats(0.2, 9))
def test_what_is_projected_comes_back(x, y, z):
    pixel = KINECT.project((x, y, z))
    np.testing.assert_allclose(KINECT.unproject(pixel, z), (x, y, z), rtol=0, atol=1e-12)


def test_what_is_behind_has_no_pixel():
    assert np.isnan(KINECT.project([(0.0, 0.0, -1.0), (0.0, 0.0, 0.0)])).all()


def test_the_kinect_sees_57_by_43_degrees():
    assert 2 * np.degrees(np.arctan(160 / KINECT.fx)) == pytest.approx(58.5, abs=0.6)
    assert 2 * np.degrees(np.arctan(120 / KINECT.fy)) == pytest.approx(45.6, abs=0.6)


@given(st.integers(1, 9))
def test_every_nth_pixel_sees_the_same_ray(step):
    thin = KINECT.every(step)
    assert (thin.width, thin.height) == (len(range(0, 320, step)), len(range(0, 240, step)))
    np.testing.assert_allclose(
        thin.unproject((1.0, 2.0), 2.5), KINECT.unproject((1.0 * step, 2.0 * step), 2.5), rtol=0, atol=1e-12
    )


@given(st.integers(1, 9))
def test_every_nth_pixel_of_a_frame_is_what_that_camera_sees(step):
    depth = np.arange(240 * 320, dtype=np.float32).reshape(240, 320)
    color = np.stack([depth % 251] * 3, axis=-1).astype(np.uint8)
    thin = DepthFrame(KINECT, depth, color, 0.4).every(step)
    assert (thin.camera, thin.time) == (KINECT.every(step), 0.4)
    np.testing.assert_array_equal(thin.depth, depth[::step, ::step])
    np.testing.assert_array_equal(thin.color, color[::step, ::step])
    assert DepthFrame(KINECT, depth).every(step).color is None


def test_points_of_an_image():
    depth = np.full((240, 320), 2.0, dtype=np.float32)
    depth[0, 0] = np.nan
    points = KINECT.points(depth)
    assert np.isnan(points[0, 0]).all()
    np.testing.assert_allclose(points[100, 30], KINECT.unproject((30, 100), 2.0))


def test_images_of_another_size_are_refused():
    with pytest.raises(MismatchError, match="depth images are"):
        DepthFrame(KINECT, np.zeros((10, 10)))
    with pytest.raises(MismatchError, match="colour images are"):
        DepthFrame(KINECT, np.zeros((240, 320)), np.zeros((240, 320)))
    with pytest.raises(MismatchError, match="fx"):
        Camera(320, 240, 0.0, 285.0, 160.0, 120.0)


@given(st.floats(50, 2000), st.floats(50, 500))
def test_a_step_brings_a_camera_near_a_focal_length(fx, focal):
    camera = Camera(640, 480, fx, fx, 320.0, 240.0)
    ratio = camera.every(camera.step_to(focal)).fx / focal
    assert 2 / 3 - 1e-9 <= ratio <= 1.5 + 1e-9 or (fx < focal and ratio == fx / focal)


@pytest.mark.parametrize("time", [np.nan, np.inf])
def test_a_time_that_is_no_number_is_refused(time):
    with pytest.raises(MismatchError, match="the time of a frame in s was wanted"):
        DepthFrame(KINECT, np.ones((240, 320)), None, time)
