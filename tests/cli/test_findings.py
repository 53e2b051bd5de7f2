"""What a look at a recording must find, in motions that can be reckoned by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionmend.arrays import Floats
from motionmend.bodies.motion import Markers, Motion
from motionmend.bodies.skeleton import Skeleton
from motionmend.cli.findings import Jump, jumps, labels, missing_shares, percent, suspicions

FPS = 100.0


def hinge(degrees: Floats, metres: Floats | None = None) -> Motion:
    """One joint that slides along y and turns about z, limited to half a turn to either side."""
    skeleton = Skeleton(
        names=("root",),
        parents=np.array([-1]),
        offsets=np.zeros((1, 3)),
        dof_names=("root.ty", "root.rz"),
        dof_joint=np.array([0, 0]),
        dof_axis=np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
        dof_kind=np.array([1, 0]),
        limits=np.array([[-np.inf, np.inf], [-np.pi, np.pi]]),
    )
    slide = np.linspace(0.0, 0.01, len(degrees)) if metres is None else metres
    return Motion(skeleton, np.stack([slide, np.radians(degrees)], axis=1), FPS)


def found(recording: Motion | Markers) -> dict[tuple[str, str], str]:
    return {(one.name, one.what): one.detail for one in suspicions(recording)}


def test_a_turn_past_180_degrees_is_a_wrap_and_a_flip_is_none() -> None:
    motion = hinge(np.array([170.0, 179.0, -172.0, -165.0, -40.0, -39.0]))
    assert jumps(motion) == (Jump("root.rz", (2, 4), (True, False)),)


def test_a_slide_is_no_jump_and_missing_samples_are_none() -> None:
    assert jumps(hinge(np.array([0.0, np.nan, 90.0]), np.array([0.0, 5.0, 0.0]))) == ()


@given(st.lists(st.floats(-59, 59), min_size=1, max_size=20))
def test_steps_below_60_degrees_are_never_jumps(steps: list[float]) -> None:
    assert jumps(hinge(np.concatenate([[0.0], np.cumsum(steps)]))) == ()


@given(st.integers(-3, 3), st.integers(0, 5))
def test_whole_turns_are_wraps_wherever_they_come(turns: int, at: int) -> None:
    angle = np.linspace(0.0, 10.0, 8)
    angle[at + 1 :] += 360.0 * turns
    assert [jump.wraps for jump in jumps(hinge(angle))] == ([(True,)] if turns else [])


def test_a_calm_hinge_is_not_suspicious() -> None:
    assert suspicions(hinge(np.linspace(0, 30, 50))) == ()


def test_angles_outside_their_limits_are_suspicious() -> None:
    angle = np.linspace(150.3, 195.3, 46)  # 15 of them more than a degree beyond 180
    assert found(hinge(angle)) == {("root.rz", "outside limits"): "15 frames (33 %), by up to 15 degrees"}


def test_a_channel_that_never_moves_is_suspicious() -> None:
    assert found(hinge(np.full(10, 7.0)))[("root.rz", "flat")] == "at 7.0 degrees throughout"


def test_what_is_faster_than_people_is_suspicious() -> None:
    angle = np.array([0.0, 1.0, 51.0, 52.0])  # 50 degrees in 0.01 s
    slide = np.array([0.0, 0.01, 0.02, 0.52])  # 0.5 m in 0.01 s
    assert found(hinge(angle, slide)) == {
        ("root.rz", "extreme speed"): "1 frame (33 %), up to 5000 degrees/s",
        ("root.ty", "extreme speed"): "1 frame (33 %), up to 50 m/s",
    }


def test_markers_that_stand_still_or_leap_are_suspicious() -> None:
    positions = np.zeros((5, 3, 3))
    positions[:, 0] = (1.0, 2.0, 3.0)
    positions[:, 1, 0] = (0.0, 0.01, 0.02, 0.52, 0.53)
    positions[:, 2, 1] = np.arange(5) * 0.01
    positions[2, 2] = np.nan
    markers = Markers(("STILL", "LEAP", "CALM"), positions, FPS)
    assert found(markers) == {
        ("STILL", "flat"): "at (1.000, 2.000, 3.000) m throughout",
        ("LEAP", "extreme speed"): "1 frame (25 %), up to 50 m/s",
    }
    assert missing_shares(markers) == {"STILL": 0.0, "LEAP": 0.0, "CALM": pytest.approx(0.2)}


def test_repeated_names_keep_apart() -> None:
    assert labels(["a", "b", "a", "a"]) == ["a", "b", "a#2", "a#3"]


@pytest.mark.parametrize(("share", "said"), [(0.0, "0 %"), (0.00123, "0.12 %"), (0.0996, "10 %"), (1.0, "100 %")])
def test_shares_for_people(share: float, said: str) -> None:
    assert percent(share) == said
