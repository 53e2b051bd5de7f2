"""Joints followed along their courses, against the plain twin."""

import numpy as np
import pytest

import naive_throwing as naive
from motionmend.kernels import throwing as kernel


@pytest.mark.parametrize("missing", [0, 3, 18, 19, 20])
def test_joints_off_the_line_are_told_as_by_the_twin(missing: int) -> None:
    rng = np.random.default_rng(missing)
    rows, last, earlier = rng.normal(0.0, 0.05, (3, 20, 3))
    last[rng.permutation(20)[:missing]] = np.nan
    for got, wanted in zip(
        kernel.off_line(rows, last, earlier, 0.03, 0.06, 0.01),
        naive.off_line(rows, last, earlier, 0.03, 0.06, 0.01),
        strict=True,
    ):
        np.testing.assert_allclose(got, wanted)


def test_joints_are_followed_as_by_the_twin() -> None:
    rng = np.random.default_rng(0)
    motion = wanted = np.full((6, kernel.STATE), np.nan)
    for t in range(12):
        rows = np.outer([0.02 * t] * 6, [1.0, 0.5, 0.0]) + 0.01 * rng.normal(size=(6, 3))
        rows[rng.random(6) < 0.2] = np.nan
        rows[rng.random(6) < 0.3] += 0.1
        motion, *told = kernel.along(rows, 1 / 30, motion, 0.01)
        wanted, *meant = naive.along(rows, 1 / 30, wanted, 0.01)
        for got, one in zip((motion, *told), (wanted, *meant), strict=True):
            np.testing.assert_allclose(got, one, rtol=1e-8, atol=1e-12)
