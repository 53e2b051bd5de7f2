"""A frame that moves with a group of markers: places in it hardly change while the body moves."""

from dataclasses import dataclass

import numpy as np

from ...arrays import Floats, Ints

ANCHORS = 5  # at most, of a frame
FAR = 0.02  # a marker a metre away is as bad a guide as a near one whose distance changes by this much, m
_EVEN = 0.01  # m; anchors steadier than this count the same
_ROUNDS = 2


@dataclass(frozen=True, eq=False)
class SegmentFrame:
    """Anchors and their mean shape.

    Attributes
    ----------
    anchors : (A,) markers; fewer than three give a frame that travels but does not turn.
    weights : (A,) sum 1.
    shape : (A, 3) m.
    """

    anchors: Ints
    weights: Floats
    shape: Floats

    def at(self, positions: Floats) -> tuple[Floats, Floats]:
        """Place (T, 3) and axes (T, 3, 3, columns) of the frame for markers (T, M, 3) with all anchors seen."""
        seen = np.ascontiguousarray(positions[:, self.anchors])
        if len(self.anchors) < 3:
            return np.einsum("a,tai->ti", self.weights, seen), np.broadcast_to(np.eye(3), (len(seen), 3, 3))
        from ...kernels.turned import places_and_axes

        place, axes = places_and_axes(
            seen, self.weights, self.weights[:, None] * (self.shape - self.weights @ self.shape)
        )
        return place, axes


def segment_frame(positions: Floats, anchors: Ints, unsteadiness: Floats) -> SegmentFrame:
    """The frame of some anchors.

    Parameters
    ----------
    positions : (T, M, 3) m, frames in which all anchors are seen; at least one.
    anchors : (A,) markers.
    unsteadiness : (A,) m, how much the distance of each to what is sought changes; steady ones weigh more.
    """
    weights = 1.0 / np.square(unsteadiness + _EVEN)
    weights = weights / weights.sum()
    # any one frame to start from; the mean shape does not depend on it
    frame = SegmentFrame(anchors, weights, positions[len(positions) // 2, anchors])
    for _ in range(_ROUNDS if len(anchors) >= 3 else 0):
        place, axes = frame.at(positions)
        frame = SegmentFrame(anchors, weights, within(positions[:, anchors], place, axes).mean(axis=0))
    return frame


def within(positions: Floats, place: Floats, axes: Floats) -> Floats:
    """Markers (T, M, 3) as seen in frames at `place` (T, 3) with `axes` (T, 3, 3)."""
    return np.asarray((positions - place[:, None]) @ axes)


def without(inside: Floats, place: Floats, axes: Floats) -> Floats:
    """Places (T, M, 3) in frames back in the world."""
    return np.asarray(inside @ axes.transpose(0, 2, 1) + place[:, None])


def unsteadiness(positions: Floats, least: int, most: int = 300) -> Floats:
    """(M, M) m: how much the distance of two markers changes over time, and a little of how far apart they are.

    inf where fewer than `least` of the `most` frames looked at show both, and of a marker with itself.
    """
    some = positions[np.unique(np.linspace(0, len(positions) - 1, min(most, len(positions))).astype(np.int64))]
    seen = np.asarray(np.isfinite(some).all(axis=2))
    count = seen.shape[1]
    found = np.full((count, count), np.inf)
    known = np.where(seen[..., None], some, 0.0)
    for marker in range(count):
        both = seen & seen[:, [marker]]
        number = np.maximum(both.sum(axis=0), 1)
        away = np.where(both, np.sqrt(np.square(known - known[:, [marker]]).sum(axis=2)), 0.0)
        mean = away.sum(axis=0) / number
        spread = np.sqrt(np.where(both, np.square(away - mean), 0.0).sum(axis=0) / number)
        enough = both.sum(axis=0) >= min(least, len(some))
        enough[marker] = False
        found[marker, enough] = (spread + FAR * mean)[enough]
    return found
