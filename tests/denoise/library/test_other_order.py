"""Joints that turn in another order than in the library's clips."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from motionmend.bodies.motion import Origin
from motionmend.bodies.skeleton import ROTATION, positions
from motionmend.denoise import Denoiser, repair_without_model
from motionmend.denoise.channels.rotation_order import in_order, in_order_of, reordered
from motionmend.denoise.library.other_order import rewritten
from motionmend.errors import MismatchError
from motionmend.evaluate import corrupt
from performers import clips, joints_model, truth
from skeletons import turned_otherwise


def _skewed(motion):
    """With two axes of each arm's and thigh's joint not at right angles."""
    skeleton = motion.skeleton
    axes = skeleton.dof_axis.copy()
    for joint in _joints(motion, "lhumerus", "rfemur"):
        row = skeleton.dofs_of(joint)[0]
        axes[row] = axes[row] + 0.2 * axes[row + 1]
        axes[row] /= np.linalg.norm(axes[row])
    return replace(motion, skeleton=replace(skeleton, dof_axis=axes))


def _joints(motion, *names):
    return [motion.skeleton.names.index(name) for name in names]


def _all_balls(motion):
    skeleton = motion.skeleton
    turns = [
        int((skeleton.dof_kind[skeleton.dofs_of(joint)] == ROTATION).sum()) for joint in range(len(skeleton.names))
    ]
    return [joint for joint, count in enumerate(turns) if count == 3]


@cache
def _told_in_the_other_order():
    """A model of the clips, every ball joint of theirs turned in the other order."""
    return Denoiser(window=20, fps=30.0).fit([turned_otherwise(clip, _all_balls(clip)) for clip in clips()])


def _off(recording, clean):
    """Mean distance in m of the joints from where they are, about the root."""
    one, other = positions(recording.skeleton, recording.q), positions(clean.skeleton, clean.q)
    return np.linalg.norm((one - one[:, :1]) - (other - other[:, :1]), axis=2).mean()


@given(st.integers(0, 2**32 - 1), st.permutations(range(3)), st.permutations(range(3)))
def test_angles_of_one_order_are_the_same_rotation_in_another(seed, one, other):
    rng = np.random.default_rng(seed)
    angles = rng.uniform(-180.0, 180.0, (20, 3))
    angles[3] = (30.0, 90.0, -40.0)  # a pole
    angles[5, 1] = np.nan
    frame = Rotation.random(random_state=rng).as_matrix()
    axes, wanted = frame[list(one)], frame[list(other)]
    written = in_order(angles, axes, wanted)

    def rotations(these, about):
        turned = Rotation.identity(len(these))
        for k in range(3):
            turned = turned * Rotation.from_rotvec(np.radians(these[:, k : k + 1]) * about[k])
        return turned

    known = np.arange(20) != 5
    assert np.isnan(written[5]).all()
    between = rotations(angles[known], axes).inv() * rotations(written[known], wanted)
    assert between.magnitude().max() < 1e-6
    assert np.abs(written[known, 1]).max() <= 90.0 + 1e-9


def test_a_motion_in_another_order_moves_as_before():
    clean = truth("walk")
    other = turned_otherwise(clean, _all_balls(clean))
    back = in_order_of(other, clean.skeleton.dof_names)
    assert back.skeleton.dof_names == clean.skeleton.dof_names
    np.testing.assert_allclose(back.skeleton.dof_axis, clean.skeleton.dof_axis)
    np.testing.assert_allclose(positions(back.skeleton, back.q), positions(clean.skeleton, clean.q), atol=1e-9)
    assert in_order_of(clean, clean.skeleton.dof_names) is clean


@pytest.mark.slow
@pytest.mark.parametrize("gaps", [0.0, 0.1])
def test_a_library_in_another_order_does_as_well_as_one_in_the_recordings(gaps):
    clean = truth("walk")
    other = turned_otherwise(clean, _all_balls(clean))
    bad = corrupt(other, noise=np.radians(2.0), outliers=0.05, gaps=gaps, seed=1).recording
    outcome = joints_model().repair(bad)
    assert outcome.recording.skeleton is other.skeleton
    assert "turn in another order than in the library's clips: these were written in the" in outcome.warnings[0]
    told = _told_in_the_other_order().repair(bad)
    assert _off(outcome.recording, clean) < 1.1 * _off(told.recording, clean)
    assert np.isfinite(outcome.recording.q).all()


@pytest.mark.slow
@pytest.mark.parametrize("window", [3, 5, 10])
def test_one_clip_and_a_short_window_are_enough(window):
    clip = clips()[0]
    model = Denoiser(window=window, fps=30.0).fit([clip])
    clean = truth("walk")
    outcome = model.repair(turned_otherwise(clean, _all_balls(clean)))
    assert "these were written in the recording's order" in outcome.warnings[0]


@pytest.mark.slow
def test_the_rewritten_library_has_the_bends_of_clips_in_that_order():
    clean = truth("walk")
    turned = turned_otherwise(clean, _all_balls(clean))
    model = joints_model()
    layout, library = rewritten(model.layout, model.library, reordered(turned.skeleton, model.layout.names))
    told = _told_in_the_other_order()
    order = [told.layout.names.index(name) for name in layout.names]
    moving = np.diag(told.library.bends[0]) > 1e-6
    for k in range(len(library.rates)):
        ratio = np.diag(library.bends[k])[moving[order]] / np.diag(told.library.bends[k])[order][moving[order]]
        assert 0.5 < np.median(ratio) < 2.0
        np.linalg.cholesky(library.bends[k] + 1e-9 * np.eye(len(order)))


@pytest.mark.slow
def test_what_cannot_be_written_so_is_repaired_by_what_it_shows_itself_and_it_is_said():
    clean = truth("walk")
    other = _skewed(turned_otherwise(clean, _joints(clean, "lhumerus", "rfemur")))
    bad = corrupt(other, noise=np.radians(2.0), outliers=0.05, seed=1).recording
    outcome = joints_model().repair(bad)
    assert outcome.recording.skeleton is other.skeleton
    assert outcome.warnings[0].startswith("rfemur, lhumerus turn in another order than in the library's clips")
    off = [
        np.linalg.norm(positions(other.skeleton, q) - positions(clean.skeleton, clean.q), axis=2).mean()
        for q in (bad.q, outcome.recording.q)
    ]
    assert off[1] < 0.5 * off[0]
    assert set(np.unique(outcome.origin)) <= {Origin.MEASURED, Origin.REPAIRED}


@pytest.mark.slow
def test_a_library_in_the_same_order_is_used_as_any():
    clean = truth("walk")
    joints = _joints(clean, "root", "lhumerus", "rhumerus", "lfemur", "rfemur", "thorax")
    model = Denoiser(window=20, fps=30.0).fit([turned_otherwise(clip, joints) for clip in clips()])
    outcome = model.repair(turned_otherwise(clean, joints))
    assert not any("another order" in said for said in outcome.warnings)


@pytest.mark.slow
def test_clips_of_both_orders_teach_as_clips_of_one():
    both = list(clips())
    both[1] = turned_otherwise(both[1], _all_balls(both[1]))
    model, one = Denoiser(window=20, fps=30.0).fit(both), joints_model()
    assert model.layout.names == one.layout.names
    np.testing.assert_allclose(model.layout.centre, one.layout.centre, atol=1e-6)
    np.testing.assert_allclose(model.bases.values, one.bases.values, rtol=1e-6)
    np.testing.assert_allclose(model.library.bends, one.library.bends, rtol=1e-6, atol=1e-8)


def test_clips_whose_axes_are_not_square_are_not_mixed():
    both = list(clips())
    both[1] = _skewed(turned_otherwise(both[1], _joints(both[1], "lhumerus", "rfemur")))
    with pytest.raises(MismatchError, match="in this one others do so: rfemur, lhumerus;"):
        Denoiser(window=20, fps=30.0).fit(both)


@pytest.mark.slow
def test_a_library_of_another_pose_at_rest_is_not_asked_of_the_joints_that_rest_otherwise():
    """Thighs at 0 degrees in the clips and at 150 here."""
    clean = truth("walk")
    skeleton = clean.skeleton
    q = clean.q.copy()
    q[:, [skeleton.dof_names.index(f"{side}femur.rx") for side in "lr"]] += np.radians(150.0)
    other = clean.with_q(q)
    bad = corrupt(other, noise=np.radians(2.0), outliers=0.05, seed=1).recording
    outcome = joints_model().repair(bad)
    assert any(said.startswith("lfemur, rfemur mostly lie more than 50 degrees beyond") for said in outcome.warnings)
    alone = repair_without_model(bad)
    rows = np.concatenate([skeleton.dofs_of(joint) for joint in _joints(clean, "lfemur", "rfemur")])
    off = [np.sqrt(np.mean(np.square((one.recording.q - q)[:, rows]))) for one in (outcome, alone)]
    assert off[0] < 1.2 * off[1]
    assert not any("beyond all that" in said for said in joints_model().repair(clean).warnings)
