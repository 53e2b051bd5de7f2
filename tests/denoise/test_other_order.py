"""Joints that turn in another order than in the library's clips."""

import numpy as np
import pytest
from performers import clips, joints_model, truth

from motionmend.bodies.motion import Origin
from motionmend.bodies.skeleton import positions
from motionmend.denoise import Denoiser
from motionmend.errors import MismatchError
from motionmend.evaluate import corrupt
from skeletons import turned_otherwise


def _joints(motion, *names):
    return [motion.skeleton.names.index(name) for name in names]


def test_they_are_repaired_by_what_they_show_themselves_and_it_is_said():
    clean = truth("walk")
    other = turned_otherwise(clean, _joints(clean, "lhumerus", "rfemur"))
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


def test_a_library_in_the_same_order_is_used_as_any():
    clean = truth("walk")
    joints = _joints(clean, "root", "lhumerus", "rhumerus", "lfemur", "rfemur", "thorax")
    model = Denoiser(window=20, fps=30.0).fit([turned_otherwise(clip, joints) for clip in clips()])
    outcome = model.repair(turned_otherwise(clean, joints))
    assert not any("another order" in said for said in outcome.warnings)


def test_clips_of_both_orders_are_not_mixed():
    both = list(clips())
    both[1] = turned_otherwise(both[1], _joints(both[1], "lhumerus"))
    with pytest.raises(MismatchError, match="the same order, in this one others do so: lhumerus;"):
        Denoiser(window=20, fps=30.0).fit(both)
