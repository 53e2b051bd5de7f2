"""Positions and Jacobians down the tree: the compiled kernels against plain NumPy."""

import numpy as np

from motionmend.bodies.skeleton import forward, jacobian, positions

from . import data, twins
from .metric import Direction, Metric
from .timing import Plan, race, ratio

POSES = 20  # of the reading twin and of the Jacobian


def run(plan: Plan) -> list[Metric]:
    """All measurements of the suite."""
    found: list[Metric] = []
    for frames in plan.frames:
        # the long one moves with the pages that its results need anew, so it informs and does not decide
        direction: Direction = "info" if frames == plan.frames[-1] else "higher"
        found += _forward(frames, plan.rounds, direction)
    return found + _poses(plan.rounds)


def _forward(frames: int, rounds: int, direction: Direction) -> list[Metric]:
    """All joints of all frames, against all frames at once in NumPy."""
    key = f"kinematics.forward.{frames}"
    moved = data.motion(frames)
    body, q = moved.skeleton, moved.q
    for ours, plain in zip(forward(body, q[:50]), twins.forward(body, q[:50]), strict=True):
        if not np.allclose(ours, plain, rtol=0.0, atol=1e-9):
            raise AssertionError(f"{key}: ours and the plain kinematics disagree, their times cannot be compared")
    times = race(
        {
            "ours": lambda: forward(body, q),
            "plain": lambda: twins.forward(body, q),
            "positions": lambda: positions(body, q),
        },
        rounds,
    )
    return [
        ratio(f"{key}.plain_over_ours", times["plain"], times["ours"], direction),
        times["ours"].rate(f"{key}.rate", frames, "frames/s"),
        times["plain"].rate(f"{key}.plain_rate", frames, "frames/s"),
        times["positions"].rate(f"kinematics.positions.{frames}.rate", frames, "frames/s"),
    ]


def _poses(rounds: int) -> list[Metric]:
    """A few poses, against the tests' own twins: one matrix at a time, and finite differences."""
    moved = data.motion(POSES)
    body, q, loops = moved.skeleton, moved.q, twins.of_tests()
    if not np.allclose(jacobian(body, q[0]), loops.chain_jacobian(body, q[0]), rtol=0.0, atol=1e-6):
        raise AssertionError("kinematics.jacobian: ours and the finite differences disagree")
    times = race(
        {
            "forward": lambda: forward(body, q),
            "loops": lambda: loops.chain_forward(body, q),
            "jacobian": lambda: jacobian(body, q[0]),
            "differences": lambda: loops.chain_jacobian(body, q[0]),
        },
        rounds,
    )
    return [
        ratio(f"kinematics.forward.{POSES}.loops_over_ours", times["loops"], times["forward"]),
        ratio("kinematics.jacobian.1.differences_over_ours", times["differences"], times["jacobian"]),
        times["jacobian"].rate("kinematics.jacobian.1.rate", 1, "poses/s"),
    ]
