"""Several people in one recording of markers, each repaired by a library that knows one."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionmend.bodies.motion import Markers, Origin
from motionmend.denoise import repair_without_model
from motionmend.denoise.several_people import by_people, people_in
from motionmend.errors import MismatchError
from motionmend.evaluate import corrupt
from motionmend.samples import markers
from performers import every_other, half_the_markers_model, truth


def _called(cloud, subject):
    return replace(cloud, names=tuple(subject + name for name in cloud.names))


def _side_by_side(*clouds):
    return replace(
        clouds[0],
        names=tuple(name for cloud in clouds for name in cloud.names),
        positions=np.concatenate([cloud.positions for cloud in clouds], axis=1),
    )


FRAMES = slice(0, 45)  # who is who is told by names, not by time


def _two():
    ann = corrupt(every_other(markers(truth("walk"))).at_frames(FRAMES), noise=0.002, gaps=0.15, seed=1).recording
    bob = corrupt(every_other(markers(truth("jump"))).at_frames(FRAMES), noise=0.002, gaps=0.15, seed=2).recording
    return ann, replace(bob, positions=bob.positions + np.array([2.0, 0.0, 0.0]), up=ann.up)


@cache
def _repaired():
    """Both, called by their names, and each alone."""
    ann, bob = _two()
    repair = half_the_markers_model().repair
    return repair(_side_by_side(_called(ann, "Ann:"), _called(bob, "Bob:"))), repair(ann), repair(bob)


@pytest.mark.slow
def test_everybody_is_repaired_as_if_they_were_alone():
    together, *each = _repaired()
    assert together.warnings[0] == "2 people in one recording, each repaired on their own: Ann, Bob"
    for k, alone in enumerate(each):
        names = alone.recording.names
        theirs = slice(k * len(names), (k + 1) * len(names))
        assert together.recording.names[theirs] == tuple(f"{('Ann:', 'Bob:')[k]}{name}" for name in names)
        np.testing.assert_array_equal(together.recording.positions[:, theirs], alone.recording.positions)
        np.testing.assert_array_equal(together.origin[:, theirs], alone.origin)
        np.testing.assert_array_equal(together.std[:, theirs], alone.std)
        np.testing.assert_array_equal(together.weights[:, theirs], alone.weights)
        np.testing.assert_array_equal(together.noise[theirs], alone.noise)


@pytest.mark.slow
def test_a_ball_and_somebody_of_whom_little_is_there_are_said_to_be_unknown():
    ann, bob = _two()
    ball = Markers(("Ball:1", f"Cat:{ann.names[0]}"), ann.positions[:, :2] + 1.0, ann.fps, up=ann.up)
    both = _side_by_side(_called(ann, "Ann_"), ball, _called(bob, "Bob_"))
    repaired = half_the_markers_model().repair(both)
    assert repaired.recording.names == both.names
    count = len(ann.names)
    np.testing.assert_array_equal(
        repaired.recording.positions[:, count + 2 :], _repaired()[0].recording.positions[:, count:]
    )
    assert any("Ann: the model does not know Ball:1, Cat:" in said for said in repaired.warnings)


def test_a_crowd_of_which_nobody_wears_enough_is_still_refused():
    ann, bob = _two()
    few = len(ann.names) // 3
    some = [replace(one, names=one.names[:few], positions=one.positions[:, :few]) for one in (ann, bob)]
    with pytest.raises(MismatchError, match="of the model's"):
        half_the_markers_model().repair(_side_by_side(_called(some[0], "Ann:"), _called(some[1], "Bob:")))


@given(
    st.lists(st.sampled_from("ABCDEFGH"), min_size=1, max_size=4, unique=True),
    st.sampled_from(":_-|./ "),
    st.randoms(use_true_random=False),
)
def test_whoever_wears_the_library_s_markers_is_found_in_any_order(subjects, between, chance):
    taught = ("LFHD", "L_ANK", "C7", "RTOE", "STRN")
    names = [f"{who}{between}{name}" for who in subjects for name in taught]
    chance.shuffle(names)
    people = people_in(names, taught)
    assert {who.rstrip(between) for who in people} == set(subjects)
    for who, theirs in people.items():
        assert sorted(theirs.values()) == sorted(taught)
        assert all(names[m] == who + name for m, name in theirs.items())


def test_a_library_of_two_people_sees_no_crowd_in_its_own():
    taught = ("ANN:LFHD", "ANN:C7", "BOB:LFHD", "BOB:C7")
    assert len(people_in(taught, taught)) == 1


@pytest.mark.parametrize("which", [np.s_[:5], np.s_[:]])
def test_labels_that_two_people_bear_of_each_other_are_given_back_and_it_is_said(which):
    ann, bob = (every_other(markers(truth(action, fps=60.0))).at_frames(slice(0, 90)) for action in ("walk", "jump"))
    bob = replace(bob, positions=bob.positions + np.array([0.8, 0.0, 0.0]), up=ann.up)
    clean = _side_by_side(_called(ann, "Ann:"), _called(bob, "Bob:"))
    count = len(ann.names)
    theirs = np.arange(count)[which]
    positions = clean.positions.copy()
    positions[30:60, theirs], positions[30:60, theirs + count] = (
        clean.positions[30:60, theirs + count],
        clean.positions[30:60, theirs],
    )
    spoilt = clean.with_positions(positions)

    def as_it_is(one):
        return repair_without_model(one, "linear")

    outcome = by_people(as_it_is, spoilt, ann.names, labels=True)
    np.testing.assert_array_equal(outcome.recording.positions, clean.positions)
    wrong = (positions != clean.positions).any(axis=2)
    np.testing.assert_array_equal(outcome.origin, np.where(wrong, Origin.REPAIRED, Origin.MEASURED))
    assert sum("labels were swapped in frames 30 to 59 and are put right" in said for said in outcome.warnings) == len(
        theirs
    )
    np.testing.assert_array_equal(by_people(as_it_is, spoilt, ann.names).recording.positions, positions)
    assert by_people(as_it_is, clean, ann.names, labels=True).warnings[1:] == ()
