"""What stands for joints without any sample is as unsure as it is wrong, and is named."""

import numpy as np
import pytest

from motionmend.bodies.motion import Markers, Origin
from motionmend.denoise import Denoiser
from motionmend.denoise.outcome import opened_where_unsure
from motionmend.samples import clip, markers
from performers import FPS, joints_model, markers_model, truth


def held_otherwise(motion, seed, degrees=8.0):
    """Somebody who holds every joint otherwise than the library's people do, by about so many degrees throughout."""
    off = np.random.default_rng(seed).normal(scale=np.radians(degrees), size=motion.q.shape[1])
    off[motion.skeleton.dof_joint == 0] = 0.0
    return motion.with_q(motion.q + off)


def hidden(motion, joint):
    """The motion without any sample of a joint, and the columns of that."""
    rows = np.flatnonzero([name.rpartition(".")[0] == joint for name in motion.skeleton.dof_names])
    q = motion.q.copy()
    q[:, rows] = np.nan
    return motion.with_q(q), rows


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_joints_never_seen_are_as_unsure_as_they_are_wrong(seed):
    there = held_otherwise(truth(seconds=2.5), seed)
    moving = [there.skeleton.names[joint] for joint in np.unique(there.skeleton.dof_joint)[1:]]
    wrong, told = [], []
    for joint in moving[seed::4]:
        gone, rows = hidden(there, joint)
        repaired = joints_model().repair(gone)
        wrong.append(np.square(np.degrees(repaired.recording.q - there.q)[:, rows]).mean())
        told.append(np.square(np.degrees(repaired.std[:, rows])).mean())
    assert len(wrong) >= 4
    assert 0.4 < np.sqrt(np.mean(wrong) / np.mean(told)) < 1.8


@pytest.mark.slow
def test_a_joint_never_seen_is_named_and_left_open_where_that_is_too_unsure():
    there = held_otherwise(truth(), 1)
    gone, rows = hidden(there, "lfemur")
    repaired = joints_model().repair(gone)
    assert any("never seen" in said and "lfemur (" in said for said in repaired.warnings)
    assert (repaired.origin[:, rows] == Origin.FILLED).all()
    opened = opened_where_unsure(repaired, np.radians(2.0))
    assert (opened.origin[:, rows] == Origin.LEFT_OPEN).all()


@pytest.mark.slow
def test_nothing_is_said_of_joints_that_are_seen():
    assert not any("never seen" in said for said in joints_model().repair(truth()).warnings)
    assert not any("never seen" in said for said in markers_model().repair(markers(truth())).warnings)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [4])
def test_markers_never_seen_by_a_library_of_one_clip_are_as_unsure_as_they_are_wrong(seed):
    def halved(motion):  # still three on a limb; the effort grows with their number squared
        every = markers(motion)
        return Markers(every.names[::2], every.positions[:, ::2], FPS, up=every.up)

    model = Denoiser(window=20, fps=FPS).fit([halved(clip("walk", seconds=8.0, fps=FPS, seed=1, style=-0.4))])
    there = halved(clip("walk", seconds=5.0, fps=FPS, seed=seed, style=0.8))
    wrong, told = [], []
    for marker in range(seed // 2, len(there.names), 8):
        gone = there.positions.copy()
        gone[:, marker] = np.nan
        repaired = model.repair(there.with_positions(gone))
        wrong.append(np.square(repaired.recording.positions - there.positions)[:, marker].mean())
        told.append(np.square(repaired.std[:, marker]).mean())
    assert np.sqrt(np.mean(wrong) / np.mean(told)) < 1.8
