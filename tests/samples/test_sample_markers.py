"""The 41 markers: where they sit, and that they keep to their bones."""

import numpy as np
import pytest

from motionmend.bodies.motion import Motion
from motionmend.bodies.skeleton import Skeleton
from motionmend.errors import MismatchError
from motionmend.evaluate import corrupt
from motionmend.samples import clip, markers
from motionmend.samples.markers import NAMES

MOTION = clip("walk", seconds=2, seed=1)
MARKERS = markers(MOTION)
PLACE = dict(zip(MARKERS.names, np.moveaxis(MARKERS.positions, 1, 0), strict=True))


def test_the_set_is_cmus():
    assert len(set(NAMES)) == 41
    assert {"LFHD", "C7", "T10", "CLAV", "STRN", "RBAC", "LSHO", "RFIN", "LFWT", "RBWT", "LMT5", "RHEE"} <= set(NAMES)
    assert MARKERS.names == NAMES
    assert MARKERS.present.all()
    np.testing.assert_array_equal(MARKERS.up, MOTION.skeleton.up)
    assert MARKERS.fps == MOTION.fps


@pytest.mark.parametrize(
    "group",
    [
        ("LFHD", "RFHD", "LBHD", "RBHD"),
        ("C7", "T10", "CLAV", "STRN", "RBAC"),
        ("LFWT", "RFWT", "LBWT", "RBWT"),
        ("LTHI", "LKNE"),
        ("RSHN", "RANK"),
        ("LHEE", "LTOE", "LMT5"),
        ("RUPA", "RELB"),
    ],
)
def test_markers_of_one_bone_keep_their_distances(group):
    for one in group:
        for other in group:
            distance = np.linalg.norm(PLACE[one] - PLACE[other], axis=1)
            assert np.ptp(distance) < 1e-9


def test_markers_lie_where_their_names_say():
    at = {name: place.mean(axis=0) - PLACE["LFWT"].mean(axis=0) for name, place in PLACE.items()}
    assert at["LFHD"][1] > at["C7"][1] > at["T10"][1] > at["LFWT"][1] > at["LKNE"][1] > at["LANK"][1] > at["LHEE"][1]
    for name in ("LFHD", "LSHO", "LELB", "LFWT", "LKNE", "LTOE"):
        assert at[name][0] > at["R" + name[1:]][0]  # left is x
    for front, back in (("LFHD", "LBHD"), ("CLAV", "C7"), ("STRN", "T10"), ("LFWT", "LBWT"), ("LTOE", "LHEE")):
        assert at[front][2] > at[back][2]
    assert at["RBAC"][0] < at["C7"][0]
    assert PLACE["LHEE"][:, 1].min() > 0.0


def test_markers_follow_the_whole_body():
    q = MOTION.q.copy()
    q[:, :3] += [1.0, 0.5, -2.0]
    moved = markers(MOTION.with_q(q))
    np.testing.assert_allclose(moved.positions - MARKERS.positions, np.broadcast_to([1.0, 0.5, -2.0], (240, 41, 3)))


def test_a_missing_joint_takes_its_markers_along():
    holed = markers(corrupt(MOTION, drop=["lfemur"]).recording)
    gone = {name for name, seen in zip(NAMES, holed.present.all(axis=0), strict=True) if not seen}
    assert gone == {"LTHI", "LKNE", "LSHN", "LANK", "LHEE", "LTOE", "LMT5"}


def test_markers_grow_with_the_body():
    small, large = (markers(clip("reach", seconds=0.1, seed=1, height=h)) for h in (1.5, 1.8))
    width = [
        np.linalg.norm(m.positions[0, NAMES.index("LFHD")] - m.positions[0, NAMES.index("RFHD")])
        for m in (small, large)
    ]
    assert width[1] / width[0] == pytest.approx(1.2)


def test_a_body_without_the_bones_is_refused():
    stick = Skeleton(
        ("base",),
        np.array([-1]),
        np.zeros((1, 3)),
        ("base.x",),
        np.array([0]),
        np.array([[1.0, 0, 0]]),
        np.array([0]),
        np.full((1, 2), [-np.inf, np.inf]),
    )
    with pytest.raises(MismatchError, match="lacks"):
        markers(Motion(stick, np.zeros((2, 1)), 30.0))


def test_a_real_cmu_body_wears_them_too(data):
    from motionmend.io import read

    walk = read(data / "mocap" / "amc" / "02" / "02_01.amc", fps=120)
    worn, seen = markers(walk), read(data / "mocap" / "c3d" / "cmu_02_01.c3d")
    assert worn.present.all()
    # The same walk was recorded with these markers; places on the skin differ by a few centimetres from ours.
    real = {
        name.rpartition(":")[2]: place
        for name, place in zip(seen.names, np.moveaxis(seen.positions, 1, 0), strict=True)
    }
    for one, other in (("LFWT", "RBWT"), ("LKNE", "LANK"), ("C7", "STRN"), ("LELB", "LWRA"), ("RHEE", "RTOE")):
        ours = np.linalg.norm(worn.positions[:, NAMES.index(one)] - worn.positions[:, NAMES.index(other)], axis=1)
        theirs = np.nanmedian(np.linalg.norm(real[one] - real[other], axis=1))
        assert np.median(ours) == pytest.approx(theirs, abs=0.07)
