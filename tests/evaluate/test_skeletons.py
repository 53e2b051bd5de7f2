"""Joint angles whose channels have other names, compared by what both skeletons have."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from motionmend import samples
from motionmend.bodies.motion import Motion
from motionmend.bodies.skeleton import ROTATION
from motionmend.errors import MismatchError
from motionmend.evaluate import compare, compare_skeletons
from skeletons import turned_otherwise


@pytest.fixture(scope="module")
def walk() -> Motion:
    return samples.clip("walk", seconds=1.0, seed=3)


def respelt(motion: Motion, joints: dict[str, str] | None = None, prefix: str = "") -> Motion:
    """The same motion with every channel called otherwise, and joints too."""
    skeleton = motion.skeleton
    names = tuple(prefix + (joints or {}).get(name, name) for name in skeleton.names)
    channels = tuple(f"{name}#" for name in skeleton.dof_names)
    return Motion(replace(skeleton, names=names, dof_names=channels), motion.q, motion.fps)


def test_the_same_under_other_names_is_the_same(walk: Motion) -> None:
    found = compare_skeletons(walk, respelt(walk, prefix="Actor:"))
    assert (found.joints.frames, found.joints.missing["samples"]) == (walk.frames, 0)
    assert found.joints.mean_cm == pytest.approx(0.0, abs=1e-9)
    assert found.rms_deg == pytest.approx(0.0, abs=1e-5)
    assert "same name" in found.joints.notes[0]


def test_an_angle_that_is_off_is_found_at_its_joint(walk: Motion) -> None:
    q = walk.q.copy()
    q[:, walk.channels.index("lradius.rx")] += np.radians(3.0)
    found = compare_skeletons(walk, respelt(walk.with_q(q)))
    assert found.rms_deg_by_joint is not None
    assert found.rms_deg_by_joint.pop("lradius") == pytest.approx(3.0)
    assert max(value or 0.0 for value in found.rms_deg_by_joint.values()) < 1e-5
    assert found.joints.mean_cm_by_joint["lradius"] == pytest.approx(0.0, abs=1e-9)
    assert (found.joints.mean_cm_by_joint["lhand"] or 0.0) > 0.5


def test_other_joint_names_are_matched_by_what_they_are(walk: Motion) -> None:
    other = respelt(walk, {name: f"{name}_joint" for name in walk.skeleton.names if "head" not in name})
    found = compare_skeletons(walk, other)
    assert set(found.joints.mean_cm_by_joint) >= {"pelvis", "l_wrist", "r_ankle"}
    assert found.joints.mean_cm == pytest.approx(0.0, abs=1e-6)
    assert found.rms_deg is None
    assert "roles" in found.joints.notes[0]


def test_another_place_is_said_and_a_small_error_of_place_counts(walk: Motion) -> None:
    moved = []
    for metres in (0.1, 5.0):
        q = walk.q.copy()
        q[:, walk.channels.index("root.tx")] += metres
        moved.append(compare_skeletons(walk, respelt(walk.with_q(q))).joints)
    assert moved[0].mean_cm == pytest.approx(10.0)
    assert moved[1].mean_cm == pytest.approx(0.0, abs=1e-6)
    assert any("rigid motion" in note and "5 m" in note for note in moved[1].notes)


def test_angles_are_not_told_of_skeletons_that_rest_otherwise(walk: Motion) -> None:
    other = respelt(walk)
    turn = Rotation.from_euler("z", 30, degrees=True).as_matrix()
    offsets = np.array(other.skeleton.offsets)
    offsets[other.skeleton.names.index("lradius")] = offsets[other.skeleton.names.index("lradius")] @ turn.T
    found = compare_skeletons(walk, Motion(replace(other.skeleton, offsets=offsets), other.q, other.fps))
    assert (found.rms_deg, found.rms_deg_by_joint) == (None, None)
    assert "rest" in found.joints.notes[-1]
    slow = compare_skeletons(walk, replace(other, q=other.q[::2], fps=other.fps / 2))
    assert slow.rms_deg is None
    assert slow.joints.mean_cm == pytest.approx(0.0, abs=1e-6)


def test_what_is_missing_counts(walk: Motion) -> None:
    q = walk.q.copy()
    q[10:20, walk.channels.index("lhumerus.ry")] = np.nan
    found = compare_skeletons(walk, respelt(walk.with_q(q)))
    assert found.joints.missing["by_channel"]["lradius"] == 10
    assert (found.joints.mean_cm_counting_missing or 0.0) > (found.joints.mean_cm or 0.0)


def test_what_is_no_body_is_refused(walk: Motion) -> None:
    skeleton = walk.skeleton
    one = replace(
        skeleton,
        names=("box",),
        parents=np.array([-1]),
        offsets=skeleton.offsets[:1],
        dof_joint=np.zeros(1, np.int64),
        dof_axis=np.eye(3)[:1],
        dof_kind=np.array([ROTATION]),
        limits=np.array([[-np.inf, np.inf]]),
        dof_names=("box.x",),
    )
    with pytest.raises(MismatchError, match="same channels or joints"):
        compare_skeletons(walk, Motion(one, np.zeros((walk.frames, 1)), walk.fps))


def test_the_same_turned_in_another_order_is_the_same_and_not_compared_by_name(walk: Motion) -> None:
    other = turned_otherwise(walk, [walk.skeleton.names.index(name) for name in ("root", "lhumerus", "rfemur")])
    assert compare(walk, other).mean_cm > 1.0
    found = compare_skeletons(walk, other)
    assert found.joints.mean_cm == pytest.approx(0.0, abs=1e-9)
    assert found.rms_deg == pytest.approx(0.0, abs=1e-5)
    assert "another order" in found.joints.notes[0]
