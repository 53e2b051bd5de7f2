"""What is filled far from sure is said with how much and where; what is sure, or said elsewhere, is not."""

import numpy as np

from motionmend.bodies.motion import Origin, Repaired
from motionmend.denoise.gaps.unsure import hardly_known
from motionmend.samples import markers
from performers import truth

UNSURE = 0.08  # m, and 0.3 rad = 17 degrees


def outcome_of(recording, filled, std):
    origin = np.where(filled, Origin.FILLED, Origin.MEASURED).astype(np.uint8)
    return Repaired(
        recording, origin, np.where(filled, std, 0.001).astype(np.float32), (~filled).astype(np.float32), "adaptive"
    )


def gap(shape, channel, start, stop):
    filled = np.zeros(shape, dtype=bool)
    filled[start:stop, channel] = True
    return filled


def test_markers_and_angles_that_are_hardly_known_are_named_with_how_far():
    walk = truth("walk")
    body = markers(walk)
    (said,) = hardly_known(outcome_of(body, gap(body.positions.shape[:2], 3, 20, 50), UNSURE))
    assert said.startswith(f"30 of 30 filled samples are less sure than 5 cm, up to 8: {body.names[3]} (30)")
    (said,) = hardly_known(outcome_of(walk, gap(walk.q.shape, 10, 20, 50), 0.3))
    assert said.startswith(f"30 of 30 filled samples are less sure than 10 degrees, up to 17: {walk.channels[10]} (30)")


def test_what_is_sure_or_hardly_any_is_not():
    body = markers(truth("walk"))
    shape = body.positions.shape[:2]
    assert hardly_known(outcome_of(body, gap(shape, 3, 20, 50), 0.02)) == ()
    much = gap(shape, slice(None), 10, 60)
    std = np.full(shape, 0.01)
    std[20, 5] = UNSURE
    assert hardly_known(outcome_of(body, much, std)) == ()
    assert hardly_known(outcome_of(body, np.zeros(shape, dtype=bool), UNSURE)) == ()


def test_who_comes_into_view_or_is_never_seen_is_said_elsewhere():
    body = markers(truth("walk"))
    shape = body.positions.shape[:2]
    for start, stop in ((0, 40), (shape[0] - 40, shape[0]), (0, shape[0])):
        assert hardly_known(outcome_of(body, gap(shape, 3, start, stop), UNSURE)) == ()


def test_a_roots_places_are_no_angles():
    walk = truth("walk")
    assert hardly_known(outcome_of(walk, gap(walk.q.shape, 0, 20, 50), 0.3)) == ()
