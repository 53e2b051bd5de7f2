"""Joints called by a namespace before a colon."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from motionmend.denoise import Denoiser
from motionmend.denoise.channels.bare_names import called_as_taught, called_barely
from motionmend.denoise.model import DenoiserModel
from motionmend.errors import MismatchError
from motionmend.evaluate import corrupt
from motionmend.samples import markers
from performers import clips, every_other, half_the_markers_model, joints_model, truth


def _of(namespace, motion):
    names = tuple(f"{namespace}:{name}" for name in motion.skeleton.dof_names)
    return replace(motion, skeleton=replace(motion.skeleton, dof_names=names))


@pytest.mark.slow
def test_a_recording_of_another_namespace_is_repaired_as_one_without():
    bad = corrupt(truth("walk"), noise=np.radians(2.0), outliers=0.05, gaps=0.1, seed=1).recording
    plain, named = joints_model().repair(bad), joints_model().repair(_of("mixamorig7", bad))
    np.testing.assert_array_equal(named.recording.q, plain.recording.q)
    np.testing.assert_array_equal(named.std, plain.std)
    assert named.recording.channels == _of("mixamorig7", bad).channels
    assert named.warnings == plain.warnings


@pytest.mark.slow
def test_clips_of_several_namespaces_teach_as_clips_of_none():
    model = Denoiser(window=20, fps=30.0).fit([_of(f"actor{k}", clip) for k, clip in enumerate(clips())])
    assert model.layout.names == joints_model().layout.names
    np.testing.assert_array_equal(model.bases.values, joints_model().bases.values)


def test_a_model_saved_with_a_namespace_is_read_without():
    arrays, header = joints_model().to_arrays()
    header = header | {"names": [f"old:{name}" for name in header["names"]]}
    assert DenoiserModel.from_arrays(arrays, header).layout.names == joints_model().layout.names


def test_two_bodies_of_one_file_keep_their_namespaces():
    motion = truth("walk")
    names = list(motion.skeleton.dof_names)
    names[0], names[1] = "a:x", "b:x"
    two = replace(motion, skeleton=replace(motion.skeleton, dof_names=tuple(names)))
    assert called_barely(two) is two
    assert called_barely(motion) is motion


def test_other_channels_are_still_refused():
    motion = truth("walk")
    other = replace(
        motion, skeleton=replace(motion.skeleton, dof_names=tuple(f"a:{k}" for k in range(motion.q.shape[1])))
    )
    with pytest.raises(MismatchError, match="the recording has 0 of the model's"):
        joints_model().repair(other)


@cache
def _gappy():
    """A second of markers, and their repair by the names of the library."""
    bad = corrupt(_second_of_markers(), noise=0.002, gaps=0.1, seed=1).recording
    return bad, half_the_markers_model().repair(bad)


def _second_of_markers():
    return every_other(markers(truth("walk"))).at_frames(slice(0, 30))


@pytest.mark.slow
@pytest.mark.parametrize("subject", ["Bob_", "Bob Smith-", "Rig|", "take.3/", "a:Bob_"])
def test_markers_called_by_a_subject_are_those_of_the_library(subject):
    bad, plain = _gappy()
    named = replace(bad, names=tuple(subject + name for name in bad.names))
    repaired = half_the_markers_model().repair(named)
    np.testing.assert_array_equal(repaired.recording.positions, plain.recording.positions)
    assert repaired.recording.names == named.names
    assert repaired.warnings == plain.warnings


@pytest.mark.slow
def test_a_library_of_a_subject_knows_others():
    taught = [every_other(markers(clip)) for clip in clips()]
    named = [replace(clip, names=tuple(f"Ann_{name}" for name in clip.names)) for clip in taught]
    bad = corrupt(_second_of_markers(), noise=0.002, seed=1).recording
    repaired = Denoiser(window=20, fps=30.0).fit(named).repair(bad)
    plain = half_the_markers_model().repair(bad)
    np.testing.assert_allclose(repaired.recording.positions, plain.recording.positions, atol=1e-6)


def test_what_all_markers_share_is_no_subject_where_the_library_says_it_too():
    names = ("L_KNEE", "L_HEEL", "L_TOE")
    assert called_as_taught(names, ("L_KNEE", "L_HEEL", "L_TOE", "R_KNEE", "R_HEEL", "R_TOE")) == names
    assert called_as_taught(("A_X", "A_Y", "B_Z"), ("X", "Y", "Z")) == ("A_X", "A_Y", "B_Z")
    assert called_as_taught(("X", "Y"), ("Ann_X".upper(), "Ann_Y".upper())) == ("ANN_X", "ANN_Y")
    assert called_as_taught((), ("X",)) == ()
