"""The spatial term: offsets from a posture's shape, on drawn postures."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.arrays import Floats
from motionmend.correct.anatomy import Anatomy, anatomy
from motionmend.correct.spatial import (
    Processes,
    fit_processes,
    mirrored_postures,
    shape_features,
)

NAMES = (
    "HipCenter",
    "Spine",
    "ShoulderCenter",
    "Head",
    "ShoulderLeft",
    "ElbowLeft",
    "WristLeft",
    "ShoulderRight",
    "ElbowRight",
    "WristRight",
    "HipLeft",
    "KneeLeft",
    "AnkleLeft",
    "HipRight",
    "KneeRight",
    "AnkleRight",
)
seeds = st.integers(0, 2**32 - 1)


@pytest.fixture(scope="module")
def body() -> Anatomy:
    return anatomy(NAMES)


def postures(count: int, rng: np.random.Generator) -> Floats:
    return rng.normal(size=(len(NAMES), 3)) * 0.4 + rng.normal(size=(count, len(NAMES), 3)) * 0.1


def bent(standard: Floats, body: Anatomy) -> Floats:
    """Offsets that a joint's own bones tell: a tenth of the mean of its neighbours' places about it."""
    offsets = np.zeros(standard.shape)
    for parent, child in body.bones:
        offsets[:, child] += 0.1 * (standard[:, parent] - standard[:, child])
    return offsets


def fitted(body: Anatomy, seed: int, count: int = 200, points: int = 60) -> tuple[Processes, Floats]:
    rng = np.random.default_rng(seed)
    standard = postures(count, rng)
    return fit_processes(standard, bent(standard, body), body, points=points, seed=0), standard


@settings(max_examples=4)
@given(seed=seeds)
def test_what_is_predicted_is_the_sum_over_the_points_as_far_as_the_posture_is_known(body: Anatomy, seed: int) -> None:
    found, standard = fitted(body, seed)
    strange = np.random.default_rng(seed).normal(size=(70, len(NAMES), 3)) * np.linspace(0.0, 0.6, 70)[:, None, None]
    features = shape_features(standard[:70] + strange, body)  # more than are taken at once
    offsets, _ = found.predict(features)

    def known(features: Floats) -> Floats:
        scouts = found.points[: len(found.scouts)]
        near = np.exp(-0.5 * ((features[:, None] - scouts) ** 2).sum(axis=3) @ found.whole[0])
        return np.einsum("ts,sr,tr->t", near, found.scouts, near)

    counts = np.minimum(known(features - found.centre) / (0.75 * np.median(known(found.points))), 1.0)
    assert counts[0] == 1.0
    assert counts[-1] < 0.8
    apart = ((features - found.centre)[:, None] - found.points) ** 2  # (T, M, B, 4)
    for k, j in enumerate(found.told):
        like = np.exp(-0.5 * apart.sum(axis=3) @ found.share[k])
        told = found.mean[j] + counts[:, None] * (like @ found.weights[k])
        np.testing.assert_allclose(offsets[:, j], told, atol=1e-6)


@settings(max_examples=4)
@given(seed=seeds)
def test_mirrored_people_get_mirrored_offsets(body: Anatomy, seed: int) -> None:
    found, standard = fitted(body, seed)
    offsets, variance = found.predict(shape_features(standard, body))
    other, unsure = found.predict(shape_features(mirrored_postures(standard, body), body))
    np.testing.assert_allclose(other, mirrored_postures(offsets, body), atol=1e-6)
    np.testing.assert_allclose(found.floor[body.mirror], found.floor, rtol=0.2)
    np.testing.assert_allclose(unsure - found.floor, (variance - found.floor)[:, body.mirror], atol=1e-6)
    strange = standard * np.linspace(1.0, 2.0, len(standard))[:, None, None]  # and of postures that are hardly known
    offsets, _ = found.predict(shape_features(strange, body))
    other, _ = found.predict(shape_features(mirrored_postures(strange, body), body))
    np.testing.assert_allclose(other, mirrored_postures(offsets, body), atol=1e-6)


@pytest.mark.slow
@settings(max_examples=4)
@given(seed=seeds)
def test_offsets_that_shape_tells_are_learned(body: Anatomy, seed: int) -> None:
    found, _ = fitted(body, seed, count=300, points=200)
    rng = np.random.default_rng(seed)
    standard = postures(300, rng)
    truth = bent(standard, body)
    offsets, _ = found.predict(shape_features(standard, body))
    assert np.linalg.norm(offsets - truth) < 0.6 * np.linalg.norm(truth - found.mean)


@settings(max_examples=4)
@given(seed=seeds)
def test_far_from_all_points_the_mean_is_given_and_the_variance_is_largest(body: Anatomy, seed: int) -> None:
    found, standard = fitted(body, seed)
    offsets, far = found.predict(shape_features(100.0 * standard[:5], body))
    np.testing.assert_allclose(offsets, np.broadcast_to(found.mean, offsets.shape), atol=1e-9)
    _, near = found.predict(shape_features(standard, body))
    assert (far.min(axis=0) >= near.max(axis=0) - 1e-12).all()
    assert (near >= found.floor).all()


@settings(max_examples=4)
@given(seed=seeds)
def test_the_floor_is_what_samples_left_out_tell(body: Anatomy, seed: int) -> None:
    rng = np.random.default_rng(seed)
    standard = postures(300, rng)
    noisy = 0.05 * rng.normal(size=standard.shape)  # nothing that shape tells
    found = fit_processes(standard, noisy, body, points=60)
    assert (found.floor > 0.6 * 0.05**2).all()  # Student's weights take a fifth from noise that has no outliers
    assert (found.floor < 1.4 * 0.05**2).all()


def test_a_joint_without_truth_stays(body: Anatomy) -> None:
    rng = np.random.default_rng(3)
    standard = postures(100, rng)
    offsets = bent(standard, body)
    offsets[:, 3] = np.nan
    found, _ = fit_processes(standard, offsets, body, points=40).predict(shape_features(standard, body))
    assert not found[:, 3].any()
    assert np.isfinite(found).all()


@pytest.mark.slow
@settings(max_examples=4)
@given(seed=seeds)
def test_a_few_wrong_truths_weigh_little(body: Anatomy, seed: int) -> None:
    rng = np.random.default_rng(seed)
    standard = postures(400, rng)
    offsets = bent(standard, body)
    spoilt = offsets.copy()
    spoilt[rng.permutation(400)[:20]] += 5.0  # metres: the other leg, another person
    features = shape_features(standard, body)
    clean, _ = fit_processes(standard, offsets, body, points=100).predict(features)
    found, _ = fit_processes(standard, spoilt, body, points=100).predict(features)
    assert np.abs(found - clean).mean() < 0.02


def test_one_frame_is_enough_to_say_something(body: Anatomy) -> None:
    standard = postures(1, np.random.default_rng(0))
    found = fit_processes(standard, np.full_like(standard, 0.02), body)
    offsets, variance = found.predict(shape_features(standard, body))
    assert np.isfinite(offsets).all()
    assert np.isfinite(variance).all()
