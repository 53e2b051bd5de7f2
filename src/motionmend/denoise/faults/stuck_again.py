"""Markers that were stuck on again, or knocked aside: they leap once by a few centimetres and go on with their body.

Before and after each goes as rigidly with those about it as ever, so that nothing tells which place is the right one.
It is said, with the frame and how far, and both are left as measured.
"""

from dataclasses import dataclass

import numpy as np

from ...arrays import Bools, Bytes, Floats
from ...bodies.motion import Markers, Motion, Origin
from ..channels.cloud import distance_change
from ..channels.joints import CENTIMETRES
from ..gaps.markers import LEAST_FRAMES
from ..gaps.segment_frame import ANCHORS, segment_frame, within
from .displaced import lasting
from .held import SAID

NEAREST, FARTHEST = 0.018, 0.06  # m; skin slips by less, and what leaps by more is elsewhere or another marker
LASTS, BESIDE = 0.2, 0.1  # s for which it is in either place, and of them beside the leap that tell how far it leaps
ALIKE = 0.4  # of the leap: what the moment about it differs by at most, and at least what all before and after shows
CALM, NEARLY_ALL = 0.4, 0.99  # of the leap, that so many steps from frame to frame are less than
LOOKED = 300  # frames that tell who is steady


@dataclass(frozen=True)
class Leap:
    """A marker that is in another place on its body from some frame on: its number, the frame, and how far, m."""

    marker: int
    first: int
    away: float


def stuck_again(positions: Floats, fps: float) -> tuple[Leap, ...]:
    """Markers that leap once, and stay there with those about them.

    Parameters
    ----------
    positions : (T, M, 3) m as recorded, NaN = missing or not believed.
    fps : Hz.
    """
    frames, markers = positions.shape[:2]
    long, short = max(LEAST_FRAMES, round(LASTS * fps)), max(3, round(BESIDE * fps))
    if markers <= ANCHORS or frames < 2 * long:
        return ()
    unsteady = distance_change(positions[:: max(1, frames // LOOKED)])
    np.fill_diagonal(unsteady, np.inf)
    found = []
    for marker in range(markers):
        about = np.argsort(unsteady[marker], kind="stable")[:ANCHORS]
        if np.isfinite(unsteady[marker, about]).all():
            leap = _leap(positions[:, [*about, marker]], unsteady[marker, about], long, short)
            if leap is not None:
                found.append(Leap(marker, *leap))
    together = [one.first for one in found]
    return tuple(one for one in found if together.count(one.first) == 1)  # who leap at once change places


def said_of_stuck_again(recording: Motion | Markers, origin: Bytes) -> tuple[str, ...]:
    """A sentence for each marker that leaps once and stays, where its samples (T, M) were left as measured."""
    if not isinstance(recording, Markers):
        return ()
    rejected = lasting(origin == Origin.REPAIRED, recording.fps) | (origin >= Origin.FILLED)
    found = stuck_again(np.where(rejected[..., None], np.nan, recording.positions), recording.fps)
    return tuple(
        f"{recording.names[leap.marker]}: from frame {leap.first} on it is {CENTIMETRES * leap.away:.1f} cm from where "
        "it was among the markers about it before, as one that was stuck on again; both places were left as measured"
        for leap in found[:SAID]
    )


def _leap(places: Floats, unsteady: Floats, long: int, short: int) -> tuple[int, float] | None:
    """The frame to which the last of some markers (T, G, 3) m leaps for good among the others, and how far."""
    seen: Bools = np.asarray(np.isfinite(places).all(axis=(1, 2)))
    here = np.flatnonzero(seen)
    if len(here) < 2 * long:
        return None
    some = places[here]
    frame = segment_frame(some[:: max(1, len(some) // LOOKED)], np.arange(some.shape[1] - 1), unsteady)
    inside = within(some[:, -1:], *frame.at(some))[:, 0]
    steps = np.diff(inside, axis=0)
    size = np.linalg.norm(steps, axis=1)
    at = int(size[long - 1 : len(size) - long + 1].argmax()) + long - 1
    if not NEAREST < size[at] < FARTHEST or here[at + 1] - here[at] > 1:
        return None
    others = np.delete(size, at)
    beside = np.median(inside[at + 1 : at + 1 + short], axis=0) - np.median(inside[at + 1 - short : at + 1], axis=0)
    all_ = np.median(inside[at + 1 :], axis=0) - np.median(inside[: at + 1], axis=0)
    leap = steps[at]
    # how limbs bend moves a marker among the others as well, the more the longer it is looked at
    if np.linalg.norm(leap - beside) > ALIKE * size[at] or leap @ all_ < ALIKE * size[at] ** 2:
        return None
    if others.max() > (1.0 - ALIKE) * size[at]:
        return None
    if np.quantile(others, NEARLY_ALL) > CALM * size[at]:
        return None
    return int(here[at + 1]), float(np.linalg.norm(beside))
