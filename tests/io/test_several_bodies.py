"""One person of the several bodies in a file is followed by place, whatever numbers a sensor gives them."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sensor_files import azure, ntu, standing

from motionmend.arrays import Floats
from motionmend.bodies.joint_sets import AZURE32, KINECT25
from motionmend.io.sensor import read_postures
from motionmend.io.several_bodies import Body, one_person

FRAMES = 40


def three(joints: int = 6) -> list[Floats]:
    """Three people (T, J, 3) m who walk past each other, half a metre apart when nearest."""
    rng, x = np.random.default_rng(5), np.linspace(-1.0, 1.0, FRAMES)
    ways = [
        np.stack([side * x, np.zeros(FRAMES), np.full(FRAMES, far)], axis=1)
        for side, far in zip((1, -1, 0.3), (2.0, 2.5, 3.0), strict=True)
    ]
    return [way[:, None] + rng.normal(scale=0.3, size=(1, joints, 3)) for way in ways]


@pytest.mark.slow
@settings(max_examples=30)
@given(st.lists(st.permutations([0, 1, 2]), min_size=FRAMES, max_size=FRAMES), st.booleans())
def test_numbers_that_change_places_in_any_frame_change_nothing(numbers: list[list[int]], shared: bool) -> None:
    people = three()
    frames = [
        [Body(0 if shared else n, one[t]) for n, one in zip(numbers[t], people, strict=True)] for t in range(FRAMES)
    ]
    found, said = one_person(frames, np.arange(FRAMES) / 30)
    assert (found == 0).all()
    assert any("3 people" in one for one in said) or (not shared and all(n == numbers[0] for n in numbers))
    assert any("have the number 0 in 40 frames" in one for one in said) == shared


@pytest.mark.parametrize("kind", ["ntu", "azure"])
def test_who_exchanges_numbers_is_followed_in_files(tmp_path: Path, kind: str) -> None:
    """The one who is exchanged for another halfway, and the other leaves."""
    joints = KINECT25 if kind == "ntu" else AZURE32
    person, other = standing(joints, 60, 1), standing(joints, 60, 2) + np.array([1.2, 0.0, 0.0])
    other[50:] = np.nan
    first, second = person.copy(), other.copy()
    first[30:], second[30:] = other[30:], person[30:]
    if kind == "ntu":
        states = np.full(person.shape[:2], 2.0)
        found = read_postures(ntu(tmp_path / "a.skeleton", {"1": (first, states), "2": (second, states)}, 60))
    else:
        found = read_postures(azure(tmp_path / "a.json", {1: first, 2: second}, [33_333 * t for t in range(60)]))
    np.testing.assert_allclose(found.positions, person, atol=1e-12)
    assert any("change places at 1.00 s" in guess for guess in found.guesses)
    assert any("took the one who begins as 1" in guess and "60 of 60" in guess for guess in found.guesses)


def test_a_leap_of_one_number_alone_stays_with_it() -> None:
    """Nobody else is there to be taken for it: what a correction makes of the leap is not the reader's."""
    person = three()[0]
    person[10] += 2.0
    found, said = one_person([[Body("a", one)] for one in person], np.arange(FRAMES) / 30)
    assert (found == 0).all()
    assert said == ()


@pytest.mark.filterwarnings("error")
def test_places_beyond_all_bounds_tell_nothing_and_nothing_is_printed_of_them(tmp_path: Path) -> None:
    places = standing(AZURE32, 4)
    spoilt = places.copy()
    spoilt[1, 3], spoilt[2, 4] = 1e297, np.inf
    path = azure(tmp_path / "a.json", {1: spoilt}, [0, 33_333, 66_667, 100_000])
    found = read_postures(path).positions
    assert not np.isfinite(found[[1, 2], [3, 4]]).any()
    kept = np.isfinite(found).all(axis=2)
    assert kept.sum() == kept.size - 2
    np.testing.assert_allclose(found[kept], places[kept], atol=1e-6)
