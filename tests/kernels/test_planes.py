"""A floor or a wall fitted anew: as its plain twin does it, and to the plane that points were drawn on."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionmend.arrays import frozen
from motionmend.kernels.planes import refit
from naive_tracking import refit_plane

LIMITS = np.array([0.15, 0.015, 0.007, 0.1])


def drawn(seed, count=400, noise=0.004, clutter=60):
    """Points of a plane before a camera, m² that each stands for, the plane, and one that it was a moment ago."""
    rng = np.random.default_rng(seed)
    normal = np.array([rng.normal(0, 0.2), -1.0, rng.normal(0, 0.2)])
    plane = np.append(normal / np.linalg.norm(normal), rng.uniform(0.8, 1.5))
    cloud = np.column_stack([rng.uniform(-1.5, 1.5, count), np.zeros(count), rng.uniform(1.5, 4.5, count)])
    cloud[:, 1] = -(cloud[:, [0, 2]] @ plane[[0, 2]] + plane[3]) / plane[1]
    cloud[:, 1] += rng.normal(0, noise, count)
    cloud[:clutter, 1] -= rng.uniform(0.1, 1.0, clutter)
    before = plane + np.append(rng.normal(0, 0.008, 3), rng.normal(0, 0.01))
    before /= np.linalg.norm(before[:3])
    return cloud, rng.uniform(5e-4, 2e-3, count), plane, frozen(before)


@given(st.integers(0, 2**32 - 1), st.integers(1, 4))
def test_it_is_its_twin(seed, rounds):
    cloud, area, _, before = drawn(seed)
    out = np.empty(7)
    refit(cloud, area, before, LIMITS, rounds, out)
    np.testing.assert_allclose(out, refit_plane(cloud, area, before, LIMITS, rounds), rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize("seed", range(8))
def test_it_finds_where_a_plane_is_now(seed):
    cloud, area, plane, before = drawn(seed)
    out = np.empty(7)
    refit(cloud, area, before, LIMITS, 4, out)
    assert np.abs(cloud @ out[:3] + out[3] - (cloud @ plane[:3] + plane[3])).max() < 0.004
    assert out[6] >= out[5]


@pytest.mark.parametrize("count", [0, 1, 2])
def test_of_too_few_points_the_plane_stays(count):
    cloud, area, _, before = drawn(0, 400)
    out = np.empty(7)
    refit(cloud[100 : 100 + count], area[100 : 100 + count], before, LIMITS, 4, out)
    np.testing.assert_array_equal(out[:4], before)
    assert out[5] == out[6]
