"""How deep points are inside solids and which way is out, against the plain twin and the true distance."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import naive_tracking as naive
from motionmend.bodies import anatomy
from motionmend.bodies.performer import DOFS, MOVES, advance, bone_frames, standing, twists
from motionmend.bodies.solids import CONE, ELLIPSOID
from motionmend.kernels import raycast
from motionmend.kernels.inside import inside, kept_out
from motionmend.track.terms.view import BONES_MOVED, MOVED_FIRST

BODY = anatomy.average()
TRUNK, FOREARMS = BODY.trunk_and_forearms


def sums_of(pose, clear, scale=0.03):
    """Cost, normal matrix and right side that the kernel adds to nothing."""
    normal, right = np.zeros((DOFS, DOFS)), np.zeros(DOFS)
    shell = BODY.solids.arrays
    placed = np.empty((len(shell.carriers), 3, 4))
    raycast.place(bone_frames(BODY, pose), shell.carriers, shell.centers, shell.turns, placed)
    cost = kept_out(
        placed,
        twists(BODY, pose),
        MOVED_FIRST,
        BONES_MOVED,
        shell,
        TRUNK,
        FOREARMS,
        np.array(clear),
        scale**2,
        200.0,
        normal,
        right,
    )
    return cost, normal, right


def folded(seed):
    """Arms anywhere about the trunk."""
    return advance(BODY, standing(), np.r_[np.zeros(3), 0.7 * np.random.default_rng(seed).normal(size=DOFS - 3)])


@pytest.mark.slow
@given(seed=st.integers(0, 10_000), clear=st.sampled_from([0.0, 0.05, 0.2]))
@settings(max_examples=30)
def test_the_sums_are_those_of_the_twin(seed, clear):
    pose = folded(seed)
    wanted = naive.kept_out(BODY, pose, TRUNK, FOREARMS, (clear, 0.5 * clear), 0.03, 200.0)
    for got, expected in zip(sums_of(pose, (clear, 0.5 * clear)), wanted, strict=True):
        np.testing.assert_allclose(got, expected, rtol=1e-8, atol=1e-9)


@given(seed=st.integers(0, 10_000))
@settings(max_examples=30)
def test_only_what_moves_a_forearm_against_the_trunk_is_asked_to_move(seed):
    cost, normal, right = sums_of(folded(seed), (1.0, 1.0))
    both = MOVES[BODY.solids.bone[FOREARMS]].any(axis=0) & ~MOVES[0]
    assert cost > 0.0
    assert (right[~both] == 0.0).all()
    assert (normal[~both] == 0.0).all()
    np.testing.assert_allclose(normal, normal.T, rtol=1e-12)


def test_a_forearm_beside_the_trunk_is_left_alone():
    cost, normal, right = sums_of(standing(), (0.0, 0.0))
    assert (cost, np.abs(normal).max(), np.abs(right).max()) == (0.0, 0.0, 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("kind", [ELLIPSOID, CONE])
def test_near_the_surface_depths_are_distances_and_the_way_out_is_the_shortest(kind, rng):
    size, taper = np.array([0.16, 0.25, 0.11]), 0.15 if kind == CONE else 0.0
    placed = np.concatenate((Rotation.random(random_state=2).as_matrix(), [[0.3], [-0.2], [2.5]]), axis=1)
    angle, high = rng.uniform(0, 2 * np.pi, 20_000), rng.uniform(-0.7, 0.7, 20_000)
    wide = 1.0 + taper * high if kind == CONE else np.sqrt(1.0 - high**2)
    local = np.stack((wide * np.cos(angle) * size[0], high * size[1], wide * np.sin(angle) * size[2]), axis=1)
    surface = local @ placed[:, :3].T + placed[:, 3]
    for step in (-0.02, 0.02):
        for n in np.flatnonzero(np.abs(high) < 0.4)[:40]:
            at_surface, _, *out = inside(placed, np.uint8(kind), size, taper, *surface[n])
            assert abs(at_surface) < 1e-9
            point = surface[n] - step * np.array(out)
            deep, share, *out = inside(placed, np.uint8(kind), size, taper, *point)
            away = surface - point
            nearest = np.argmin(np.linalg.norm(away, axis=1))
            assert share == 1.0
            assert abs(deep) == pytest.approx(np.linalg.norm(away[nearest]), rel=0.2)
            assert np.sign(deep) == np.sign(step)
            assert np.linalg.norm(out) == pytest.approx(1.0)
            assert np.sign(step) * (out @ away[nearest]) > 0.9 * np.linalg.norm(away[nearest])


def test_beyond_a_cone_s_ends_nothing_is_inside_and_on_an_axis_there_is_no_way_out():
    size = np.array([0.1, 0.2, 0.1])
    assert inside(np.eye(3, 4), CONE, size, 0.0, 0.02, 0.21, 0.0)[0] < 0.0
    assert inside(np.eye(3, 4), CONE, size, 0.0, 0.0, 0.0, 0.0)[0] < 0.0
    assert 0.0 < inside(np.eye(3, 4), CONE, size, 0.0, 0.02, 0.18, 0.0)[1] < 1.0
