"""Kernels of one live frame of correction against their plain twins.

What a model has learned is read-only, as here: kernels are compiled for either kind of array.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import naive_correct as naive
import naive_offsets
from motionmend.arrays import frozen
from motionmend.bodies.joint_sets import KINECT20
from motionmend.correct.anatomy import anatomy, following
from motionmend.kernels import bones, hops, one_side, origins, proportions, shaking, shapes, sighting, steadying
from motionmend.kernels import following as kernel
from motionmend.kernels import learning as gp
from motionmend.numerics.local_gp import Hyper, covariance, factor

BODY = anatomy(KINECT20.names)
JOINTS, BONES = len(BODY.names), len(BODY.bones)
TREE = BODY.bones[np.argsort(BODY.bones[:, 1])]


def some_posture(rng: np.random.Generator, missing: int = 2) -> np.ndarray:
    rows = rng.normal(0.0, 0.4, (JOINTS, 3))
    rows[rng.permutation(JOINTS)[:missing]] = np.nan
    return rows


def some_belief(rng: np.random.Generator, factors: int) -> tuple[np.ndarray, np.ndarray]:
    root = rng.normal(size=(2 * factors, 2 * factors))
    return rng.normal(size=2 * factors), root @ root.T / factors + np.eye(2 * factors)


def same(got, wanted, **near) -> None:
    for one, other in zip(got, wanted, strict=True):
        np.testing.assert_allclose(one, other, **({"rtol": 1e-9, "atol": 1e-9} | near))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_a_posture_is_followed_as_by_its_twin(seed: int) -> None:
    rng = np.random.default_rng(seed)
    mean, loadings = rng.normal(0.0, 0.5, (JOINTS, 3)), rng.normal(0.0, 0.1, (JOINTS, 3, 4))
    noise, weights = rng.uniform(1e-4, 1e-3, JOINTS), np.append(rng.uniform(0.3, 1.0, 8), -4.0)
    lasting, belief = np.array([8.0, 1.0]), some_belief(rng, 4)
    before = (
        rng.normal(0.0, 0.01, (JOINTS, 3)),
        rng.uniform(0.01, 0.6, JOINTS),
        rng.uniform(0.0, 2.0, JOINTS),
        rng.uniform(0.0, 2.0, JOINTS),
    )
    standard = mean + loadings @ belief[0][:4] + rng.normal(0.0, 0.03, (JOINTS, 3))
    standard[3] += 0.5
    standard[7] = np.nan
    raw, bone, best, told = (rng.uniform(0.0, 2.0, (JOINTS, 3))[:, :k].squeeze().copy() for k in (1, 1, 1, 3))
    place = loadings @ belief[0][:4]
    place_cov = np.stack([row @ belief[1][:4, :4] @ row.T for row in loadings])
    seconds = 0.0 if seed == 3 else 1 / 30
    repeated = np.arange(JOINTS) == 5
    leaps = (
        rng.uniform(size=JOINTS) < 0.3,
        rng.uniform(size=JOINTS) < 0.2,
        np.where(rng.uniform(size=JOINTS) < 0.5, np.inf, rng.uniform(0.0, 8.0, JOINTS)),
    )
    standard[9] += 0.3
    apart = BODY.bones, np.where(rng.uniform(size=BONES) < 0.3, rng.uniform(size=BONES), 0.0)
    got = kernel.follow(
        *map(frozen, (mean, loadings, noise, weights)), lasting, *before, *belief, place, place_cov,
        standard, seconds, kernel.Signs(raw, bone, best, told, repeated, *leaps[:2], *apart), leaps[2],
    )  # fmt: skip
    wanted = naive.follow(
        (mean, loadings, noise),
        weights,
        lasting,
        before,
        belief,
        standard,
        seconds,
        raw,
        bone,
        best,
        told,
        repeated,
        leaps,
        apart,
    )
    same(got, wanted, rtol=1e-5, atol=1e-6)
    assert got[3][7] == 1.0


@given(
    st.integers(0, 50),
    st.floats(0.0, 1.2),
    st.sampled_from([-1.0, 0.0, 0.03, 0.1, np.inf]),
    st.sampled_from([0, 3, JOINTS]),
)
@settings(max_examples=60, deadline=None)
def test_who_leaps_is_told_as_by_the_twin(seed: int, far: float, seconds: float, missing: int) -> None:
    rng = np.random.default_rng(seed)
    rows, way = some_posture(rng, missing), rng.normal(size=3)
    before = rows - far * way / np.linalg.norm(way) + rng.normal(0.0, 0.02, rows.shape)
    before[rng.permutation(JOINTS)[:4]] += 3.0  # some joints fail
    assert sighting.leapt(rows, before, seconds) == naive.leapt(rows, before, seconds)
    told = rows, before, seconds, rng.uniform(0.0, 3.0, JOINTS)
    np.testing.assert_array_equal(sighting.strayed(*told), naive.strayed(*told))


@given(st.integers(0, 200), st.floats(0.05, 1.0), st.sampled_from([-1.0, 0.0, 0.03, 0.1, np.inf]))
@settings(max_examples=60, deadline=None)
def test_who_hops_is_told_as_by_the_twin(seed: int, far: float, seconds: float) -> None:
    rng = np.random.default_rng(seed)
    earlier = some_posture(rng, 2)
    before = earlier + rng.normal(0.0, 0.03, earlier.shape)
    rows = before + rng.normal(0.0, 0.03, earlier.shape)
    mirror = rng.permutation(JOINTS)
    some = rng.permutation(JOINTS)
    rows[some[:5]] += far * rng.normal(size=(5, 3))
    rows[some[5:8]] = before[mirror[some[5:8]]]
    told = rows, before, earlier, seconds, mirror
    np.testing.assert_array_equal(hops.hopped(*told), naive.hopped(*told))
    np.testing.assert_array_equal(hops.leaps(*told), naive.leaps(*told))


@pytest.mark.slow
def test_only_what_can_be_a_person_is_believed_as_by_the_twin() -> None:
    postures = np.stack([some_posture(np.random.default_rng(seed)) for seed in range(7)])
    postures[1, 3], postures[1, 5, 1] = 0.0, np.inf
    postures[2, 4, 2], postures[2, 6, 0] = 250.0, 0.0
    postures[3] = 1.5
    postures[4, 2:] = np.nan  # two joints in one place may be
    postures[4, :2] = 1.5
    postures[5] = np.nan
    postures[6, :-1] = 0.0  # one joint alone
    got = sighting.believable(postures, 100.0, 1e-3)
    np.testing.assert_array_equal(got, naive.believable(postures, 100.0, 1e-3))
    assert np.isnan(got[3]).all()
    assert np.isfinite(got[4, :2]).all()


@given(st.integers(0, 10_000), st.integers(0, JOINTS - 1), st.floats(0.0, 1.0), st.integers(0, 4))
@settings(max_examples=60, deadline=None)
def test_the_joint_from_which_others_are_given_is_told_as_by_the_twin(seed: int, j: int, off: float, gone: int) -> None:
    rng = np.random.default_rng(seed)
    posture = some_posture(rng, gone)
    posture -= np.nan_to_num(posture[j]) + off * rng.normal(size=3)
    posture[j] = 0.0
    assert origins.origin_of(posture) == naive.origin_of(posture)
    posture[(j + 1) % JOINTS] = 0.0
    assert origins.origin_of(posture) == -1


@pytest.mark.slow
@pytest.mark.parametrize("said", [True, False])
def test_a_frame_is_received_as_by_the_twin(said: bool) -> None:
    rng = np.random.default_rng(2)
    positions, to_model = some_posture(rng), rng.permutation(JOINTS)[:-2]
    positions[4], to_model[3] = 0.0, -1
    told = positions, rng.integers(0, 3, JOINTS if said else 0).astype(np.uint8), to_model, 100.0, 1e-3
    same(sighting.received(*told), naive.received(*told))


@given(st.integers(0, 10_000), st.integers(0, JOINTS), st.booleans())
@settings(max_examples=30)
def test_a_person_is_placed_as_by_its_twin(seed: int, missing: int, met: bool) -> None:
    rng = np.random.default_rng(seed)
    rows, failing = some_posture(rng, missing), rng.uniform(0.0, 1.0, JOINTS)
    count = rng.integers(0, 60, BONES).astype(float) if met else np.zeros(BONES)
    sums = np.stack([count * rng.uniform(0.1, 0.5, BONES), count])
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    told = (
        rows, failing, sums, BODY.bones, BODY.across, BODY.trunk, frozen(rng.uniform(0.1, 0.5, BONES)),
        frozen(rng.normal(0.0, 0.2, (JOINTS, 3))), rng.normal(size=2), turn, rng.normal(size=3), 1.1,
    )  # fmt: skip
    same(sighting.place(*told), naive.place(*told))


@given(st.integers(0, 10_000), st.booleans(), st.booleans(), st.integers(0, 1))
@settings(max_examples=30)
def test_who_is_seen_from_one_side_is_placed_as_by_the_twin(seed: int, met: bool, shoulder: bool, side: int) -> None:
    rng = np.random.default_rng(seed)
    rows, failing = some_posture(rng, 0), rng.uniform(0.0, 1.0, JOINTS)
    rows[BODY.across[:, side]] = np.nan
    if not shoulder:
        rows[BODY.across[1:, 1 - side]] = np.nan
    told = (
        rows, failing, np.zeros((2, BONES)), BODY.bones, BODY.across, BODY.trunk, frozen(rng.uniform(0.1, 0.5, BONES)),
        frozen(rng.normal(0.0, 0.2, (JOINTS, 3))), rng.normal(size=2) * met, np.eye(3), rng.normal(size=3), 1.1,
    )  # fmt: skip
    same(sighting.place(*told), naive.place(*told))


@given(st.integers(0, 10_000), st.integers(0, 1), st.floats(-3.1, 3.1))
@settings(max_examples=30)
def test_one_side_of_the_trunk_tells_where_it_faces(seed: int, side: int, heading: float) -> None:
    """The standard body itself, turned: at once if nothing was known, in seconds if it was thought to face away."""
    rng = np.random.default_rng(seed)
    standard = np.zeros((JOINTS, 3))
    standard[BODY.trunk] = rng.normal(0.0, 0.02, (int(BODY.trunk.sum()), 3))
    standard[BODY.across[:, 0], 0] += 0.15
    standard[BODY.across[:, 1], 0] -= 0.15
    cos, sin = np.cos(heading), np.sin(heading)
    rows = standard @ np.array([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]])
    rows[BODY.across[:, side]] = np.nan
    trust = np.isfinite(rows).all(axis=1).astype(float)
    told = rows, trust, BODY.trunk, BODY.across, frozen(standard)
    found = one_side.facing(*told, np.zeros(2))
    np.testing.assert_allclose(found / np.hypot(*found), [cos, sin], atol=1e-9)
    found = np.array([np.cos(heading + 3.0), np.sin(heading + 3.0)])
    for _ in range(300):
        found = one_side.facing(*told, found)
    assert found / np.hypot(*found) @ [cos, sin] > 0.99
    trust[BODY.across] = 0.0  # the spine alone says nothing
    np.testing.assert_array_equal(one_side.facing(*told, np.zeros(2)), 0.0)


@pytest.mark.slow
@given(st.integers(0, 10_000), st.integers(0, 6), st.floats(0.005, 0.3))
@settings(max_examples=40)
def test_sides_are_found_changed_as_by_the_twin(seed: int, missing: int, spread: float) -> None:
    rng = np.random.default_rng(seed)
    place, own = rng.normal(0.0, 0.3, (JOINTS, 3)), rng.normal(0.0, 0.01, (JOINTS, 3))
    mean, noise = rng.normal(0.0, 0.3, (JOINTS, 3)), rng.uniform(0.5, 2.0, JOINTS) * spread**2
    standard = (place + own + mean + rng.normal(0.0, spread, (JOINTS, 3)))[
        np.where(rng.uniform(size=JOINTS) < 0.3, BODY.mirror, np.arange(JOINTS))
    ]
    standard[rng.permutation(JOINTS)[:missing]] = np.nan
    cov = np.tile(np.eye(3) * spread**2, (JOINTS, 1, 1))
    last = standard[np.where(rng.uniform(size=JOINTS) < 0.5, BODY.mirror, np.arange(JOINTS))]
    crossed = rng.uniform(size=JOINTS) < 0.3
    told = (standard, last, standard, place, cov, frozen(mean), own, frozen(noise), crossed, BODY.mirror)
    got, wanted = sighting.crossed(*told), naive.crossed(*told)
    np.testing.assert_array_equal(got[0], wanted[0])
    assert got[1] == wanted[1]


@pytest.mark.slow
@pytest.mark.parametrize("told", [True, False])
@pytest.mark.parametrize("still", [0, 3, JOINTS - 4])
@pytest.mark.parametrize("rounded", [0, 1, 6])
def test_signs_of_failure_and_lengths_are_those_of_the_twins(told: bool, still: int, rounded: int) -> None:
    rng = np.random.default_rng(5)
    rows, before, earlier = some_posture(rng), some_posture(rng), some_posture(rng, 0)
    rows[:still] = before[:still] = earlier[:still]
    rows[-rounded:, 1] = before[-rounded:, 1] if rounded else rows[:, 1]
    usual, spread, jerk = (rng.uniform(0.05, 0.5, n) for n in (BONES, BONES, JOINTS))
    states = rng.integers(0, 3, JOINTS if told else 0).astype(np.uint8)
    every = (rows, before, earlier, 1.2, usual, BODY.bones, BODY.twins, spread, frozen(jerk), states)
    got = sighting.signs(*every)
    same(got, naive.signs(*every))
    assert got[6].sum() == (still if (still, rounded) in ((3, 0), (3, 1)) else 0)
    assert np.isfinite(np.concatenate([one.ravel() for one in got[1:]])).all()
    count = rng.uniform(0, 600, BONES)
    sums, failing = np.stack([0.3 * count, count]), rng.uniform(0.0, 0.6, JOINTS)
    varied = sums, spread, got[0], failing, BODY.bones, frozen(rng.uniform(0.05, 0.5, BONES)), 1 / 30
    same(proportions.counted(*varied), naive.counted(*varied))
    for times in (1.0, 9.0):
        wide = times * spread, frozen(varied[5]), 2.0
        same([proportions.unsteadiness(*wide)], [naive.unsteadiness(*wide)])


@given(seed=st.integers(0, 99), size=st.floats(0.6, 1.5), far=st.floats(0.0, 0.3))
@settings(deadline=None)
def test_a_bone_is_as_odd_as_its_twin_and_little_more(seed: int, size: float, far: float) -> None:
    rng = np.random.default_rng(seed)
    standard = frozen(rng.uniform(0.2, 0.5, BONES))
    usual = size * (standard + far * rng.normal(size=BONES))
    got = proportions.likely(usual, size, standard, BODY.twins)
    same([got], [naive.likely(usual, size, standard, BODY.twins)])
    alike = size * (standard + far)
    same([proportions.likely(alike, size, standard, BODY.twins)], [alike])
    sided = np.flatnonzero(BODY.twins != np.arange(BONES))
    alike[sided[0]] += size
    found = proportions.likely(alike, size, standard, BODY.twins)
    assert found[sided[0]] == pytest.approx(size * (standard[sided[0]] + far + 0.05))
    same([np.delete(found, sided[0])], [np.delete(alike, sided[0])])


@given(st.integers(0, 100), st.floats(0.6, 1.0))
@settings(max_examples=20, deadline=None)
def test_a_bone_that_is_trusted_in_most_frames_tells_of_kinship_as_much_as_one_in_all(seed: int, share: float) -> None:
    """Of few frames those that vary are trusted in fewer, and it is the short ones that differ between sensors."""
    rng = np.random.default_rng(seed)
    lengths, count = frozen(rng.uniform(0.2, 0.5, BONES)), np.full(BONES, 100.0)
    mean = lengths + 0.03 * rng.normal(size=BONES)
    fewer = np.where(rng.random(BONES) < 0.5, share, 1.0) * count
    fewer[0] = 100.0
    got = [proportions.kinship(np.stack([k * mean, k]), lengths, BODY.twins, BODY.parts) for k in (count, fewer)]
    assert got[0] == pytest.approx(got[1], rel=1e-9)


@pytest.mark.parametrize("unseen", [0, 4, BONES])
@pytest.mark.parametrize("off", [0.0, 0.02, 0.15])
def test_kinship_is_that_of_the_twin(unseen: int, off: float) -> None:
    rng = np.random.default_rng(unseen)
    lengths, count = frozen(rng.uniform(0.2, 0.5, BONES)), rng.uniform(100, 200, BONES)
    count[rng.permutation(BONES)[:unseen]] = 0.0
    sums = np.stack([1.1 * count * (lengths + off * (-1.0) ** np.arange(BONES)), count])
    every = (sums, lengths, BODY.twins, BODY.parts)
    got = proportions.kinship(*every)
    assert got == pytest.approx(naive.kinship(*every), rel=1e-9)
    assert unseen == BONES or (got > 0.9) == (off < 0.05)


@pytest.mark.slow
@pytest.mark.parametrize("missing", [0, 3, JOINTS])
def test_a_posture_is_given_back_as_by_its_twin(missing: int) -> None:
    rng = np.random.default_rng(missing)
    to_model = rng.permutation(JOINTS)
    to_model[5] = -1
    lost = np.setdiff1d(np.arange(JOINTS), to_model)
    given_rows = some_posture(rng, missing)
    rows = np.where((to_model >= 0)[:, None], given_rows[to_model], np.nan)
    rows[np.flatnonzero(to_model >= 0)[:4]] = rng.normal(size=(4, 3))  # sides changed back: where the sensor has none
    given_rows = given_rows.copy()
    given_rows[to_model[np.flatnonzero(to_model >= 0)[:2]]] = np.nan
    own = np.zeros((JOINTS, JOINTS))
    own[to_model[to_model >= 0], np.flatnonzero(to_model >= 0)] = 1.0
    spread = following(BODY.names, ~np.isin(np.arange(JOINTS), lost)) @ own
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    upright, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    told = (
        frozen(given_rows), rows, rng.uniform(size=JOINTS) < 0.2, turn, rng.normal(size=3), 0.9, upright,
        rng.normal(size=(JOINTS, 3)), rng.uniform(0.0, 0.1, JOINTS), rng.uniform(0.0, 1.0, JOINTS), to_model, spread,
    )  # fmt: skip
    placed, deviation, reliable = np.empty((JOINTS, 3)), np.empty(JOINTS), np.empty(JOINTS)
    sighting.given_back(*told, placed, deviation, reliable)
    same((placed, deviation, reliable), naive.given_back(*told))


def some_motion(rng, places):
    """As `steady_frame` leaves it."""
    speed, small = 0.01 * rng.normal(size=(JOINTS, 3)), 1e-5 * rng.uniform(1.0, 2.0, (JOINTS, 3))
    surprise = 0.01 * rng.normal(size=(JOINTS, 3))
    return np.hstack([places, speed, small[:, :2], 0.1 * small[:, :1], 0.1 * small[:, 2:], surprise])


def some_later(rng, frames):
    """Places in later frames, one joint never seen, another not at last, and s between them; once a long while."""
    later = np.array([some_posture(rng, 1) for _ in range(frames)]).reshape(frames, JOINTS, 3)
    later[:, 2], later[1:, 3] = np.nan, np.nan
    steps = np.full(frames, 1 / 30)
    steps[3:] = 0.7
    return later, steps


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.0, 0.03])
@pytest.mark.parametrize("seconds", [np.nan, 0.0, 1 / 120, 1 / 30, 0.1, 0.6])
def test_a_frame_is_steadied_as_by_its_twin(seconds: float, noise: float) -> None:
    rng = np.random.default_rng(9)
    positions, motion = some_posture(rng, 1), some_motion(rng, some_posture(rng, 1))
    later, steps = some_later(rng, 4)
    got, wanted = (one.steady_frame(positions, seconds, motion, later, steps, noise) for one in (steadying, naive))
    same(got, wanted, atol=1e-13)


@pytest.mark.parametrize("missing", [0, 3, JOINTS - shaking.FEWEST, JOINTS - shaking.FEWEST + 1, JOINTS])
def test_how_far_joints_turn_back_is_told_as_by_the_twin(missing: int) -> None:
    rng = np.random.default_rng(missing)
    rows, last, earlier, before = (some_posture(rng, 0) for _ in range(4))
    rows[rng.permutation(JOINTS)[:missing]] = np.nan
    same(shaking.turned_back(rows, last, earlier, before), naive.turned_back(rows, last, earlier, before))


@pytest.mark.slow
@pytest.mark.parametrize("belief", [1.0, 0.3])
@pytest.mark.parametrize("known", [True, False])
def test_a_live_frame_settles_as_its_twin_and_has_its_lengths(known: bool, belief: float) -> None:
    rng = np.random.default_rng(8)
    positions, trust, prior = some_posture(rng, 1), rng.uniform(0.0, 1.0, JOINTS), rng.uniform(0.1, 0.4, BONES)
    prior[2] = np.nan
    last, earlier, yielded = (some_posture(rng, 1 if known else JOINTS) for _ in range(3))
    earlier[::2] = last[::2] + 0.003 * rng.normal(size=last[::2].shape)  # some are at rest
    count = rng.uniform(0, 0.6, BONES) if known else np.zeros(BONES)
    count[1::4] = bones.ACQUAINTED_SECONDS if known else 0.0
    sums = np.stack([np.where(count > 0, 0.3, 0.0), count])
    times = (1 / 30, 1 / 30) if known else (np.nan, np.nan)
    state = (
        last,
        earlier,
        sums,
        yielded,
        times[0],
        some_motion(rng, last) if known else np.full((JOINTS, steadying.STATE), np.nan),
    )
    state = (*state, *some_later(rng, 3 if known else 0), 0.01)
    got = bones.settle_frame(positions, trust, TREE, prior, belief, *times, *state)
    same(got, naive.settle_frame(positions, trust, TREE, prior, belief, times, *state))
    whole = np.isfinite(got[0][TREE]).all(axis=(1, 2))
    found = np.linalg.norm(got[0][TREE[:, 1]] - got[0][TREE[:, 0]], axis=1)
    length, seen = got[1]
    begun = belief * bones.PRIOR_SECONDS
    usual = (seen * length + begun * prior) / (seen + begun)
    clear = whole & np.isfinite(prior)
    np.testing.assert_allclose(found[clear], usual[clear], rtol=1e-9)


@pytest.mark.slow
@given(st.integers(0, 1000), st.integers(1, 5))
@settings(max_examples=15)
def test_a_full_model_gives_up_the_sample_that_matters_least(seed: int, depth: int) -> None:
    rng = np.random.default_rng(seed)
    size, hyper = 8, np.array([0.8, 0.2, 1.5, 0.05])
    arrays = [
        np.full((1, 2, 3), np.nan), np.zeros((1, 2, size, 3)), np.zeros((1, 2, size, depth)),
        np.zeros((1, 2, size, size)), np.zeros((1, 2, size, depth)), np.zeros((1, 2), np.int64), np.ones((1, 2, 4)),
    ]  # fmt: skip
    model = np.zeros((0, 3)), np.zeros((0, depth))
    for _ in range(size + 5):
        sample, value = rng.normal(size=3), rng.normal(size=depth)
        gp.learn(*arrays, sample[None], value[None], np.array([True]), hyper, 0.0)
        model = naive_offsets.learn(model, hyper, sample, value, size)
    centres, inputs, outputs, lower, weights, counts, _ = (one[0, 0] for one in arrays)
    assert counts == size
    same((inputs, outputs, centres), (*model, model[0].mean(axis=0)))
    assert np.allclose(np.tril(lower), factor(model[0], Hyper(*hyper)), atol=1e-8)
    noisy = covariance(model[0], model[0], Hyper(*hyper)) + hyper[3] * np.eye(size)
    np.testing.assert_allclose(weights, np.linalg.solve(noisy, model[1]), rtol=1e-6, atol=1e-8)


@given(st.integers(0, 10_000), st.integers(0, 3))
@settings(max_examples=20)
def test_shapes_and_how_far_they_are_apart_are_those_of_the_twins(seed: int, frames: int) -> None:
    rng = np.random.default_rng(seed)
    postures = rng.normal(0.0, 0.4, (frames, JOINTS, 3))
    postures[:, BODY.bones[2]] = 0.1  # a bone without length
    found = shapes.directions(postures, BODY.bones, 0.15)
    same([found], [naive_offsets.directions(postures, BODY.bones, 0.15)])
    columns = frozen(rng.normal(0.0, 0.2, (4, BONES, 7)), np.float32)
    told = found, frozen(rng.normal(0.0, 0.2, (BONES, 4))), columns
    same([shapes.apart(*told)], [naive_offsets.apart(*told)], rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("frames", [1, 3])
def test_points_tell_offsets_as_their_twin(frames: int) -> None:
    rng = np.random.default_rng(frames)
    joints, few = np.array([4, 0, 7]), rng.normal(0.0, 0.3, (5, 5))
    like = rng.uniform(0.0, 1.0, (frames, 4, 8)).astype(np.float32)
    like[0, -1, :5] = 0.01  # far from the scouts; the others are nearer than can be
    fixed = (rng.normal(size=(3, 8, 3)), joints, rng.normal(size=(JOINTS, 3)), few @ few.T + np.eye(5))
    fixed = *fixed, *rng.uniform(0.0, 1.0, (2, JOINTS))
    offsets, variance = np.empty((frames, JOINTS, 3)), np.empty((frames, JOINTS))
    kinds = (np.float64, np.int64, np.float64, np.float32, np.float64, np.float64)
    shapes.told(like, *(frozen(one, kind) for one, kind in zip(fixed, kinds, strict=True)), 0.8, offsets, variance)
    same((offsets, variance), naive_offsets.told(like, *fixed, 0.8), rtol=1e-5, atol=1e-6)
    assert (np.abs(offsets[0] - fixed[2]) < 0.1).all()  # like no point: the mean
    assert (variance[0] > fixed[5]).all()
