"""The path of least steps through the branches of three angles, against its plain twin."""

import numpy as np
import pytest

import naive_denoise as naive
from motionmend.kernels.branches import steadiest

TURNS = np.array([(a, 0.0, c) for a in (-360.0, 0.0, 360.0) for c in (-360.0, 0.0, 360.0)])


@pytest.mark.parametrize("frames", [1, 2, 40])
def test_the_path_is_the_plain_ones(rng, frames):
    triples = rng.uniform(-180, 180, (frames, 2, 3))
    for hold in (0.5, 30.0, 1e4):
        centre = rng.uniform(-180, 180, 3)
        found = steadiest(triples, TURNS, centre, hold)
        np.testing.assert_array_equal(found, naive.steadiest(triples, TURNS, centre, hold))


def test_no_other_path_costs_less(rng):
    triples, centre, hold = rng.uniform(-180, 180, (5, 2, 3)), np.zeros(3), 3.0
    turns = TURNS[3:5]
    branches = (triples[:, :, None] + turns).reshape(5, -1, 3)
    away = np.abs(branches - centre).sum(axis=2)

    def cost(path):
        taken = branches[np.arange(5), path]
        return np.abs(np.diff(taken, axis=0)).sum() + away[np.arange(5), path].sum() / hold

    every = np.stack(np.meshgrid(*[np.arange(4)] * 5), axis=-1).reshape(-1, 5)
    assert cost(steadiest(triples, turns, centre, hold)) == pytest.approx(min(map(cost, every)))
