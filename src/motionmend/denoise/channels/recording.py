"""What the bases see: recordings as channels in degrees and centimetres, free of place, heading and jumps."""

from dataclasses import dataclass, replace

import numpy as np

from ...arrays import Bools, Floats, Ints
from ...bodies.motion import Markers, Motion
from ...bodies.skeleton import ROTATION
from ...errors import MismatchError
from .cloud import CloudChannels, cloud_channels, positions_of
from .joints import JointChannels, into_angles, joint_channels, own_middle, unit
from .layout import Layout, kind_of, names_of
from .pieces import pieces

ROUNDING = 1e-12  # rad, m; sums of a hundred thousand terms of a turn or a metre are off by less
LEAST_SHARED = 0.6  # a model fits a recording that holds at least this share of its channels


@dataclass(frozen=True, eq=False)
class Channels:
    """A recording as the model's channels.

    Attributes
    ----------
    values : (T, C) degrees and centimetres, NaN = missing; model order.
    columns : (N,) for each name of the layout the recording's channel or marker, -1 where it has none.
    inner : what it takes to come back.
    """

    values: Floats
    columns: Ints
    inner: JointChannels | CloudChannels

    def way_back(self) -> "Channels":
        """The same without the values: those of a long recording need as much memory as the recording."""
        return replace(self, values=np.empty((0, self.values.shape[1])))


def to_channels(recording: Motion | Markers, layout: Layout) -> Channels:
    """A recording as the layout's channels; a name the recording lacks is missing throughout.

    Raises
    ------
    MismatchError : another kind, or fewer than six in ten of the layout's names are there.
    """
    if kind_of(recording) != layout.kind:
        raise MismatchError(
            f"the model knows {_plural(layout.kind)}, the recording holds {_plural(kind_of(recording))}: "
            "use a model fitted on files of this kind"
        )
    own = {name: i for i, name in enumerate(names_of(recording))}
    columns = np.array([own.get(name, -1) for name in layout.names], dtype=np.int64)
    shared = int((columns >= 0).sum())
    if shared < LEAST_SHARED * len(columns):
        lacking = [n for n, c in zip(layout.names, columns, strict=True) if c < 0]
        raise MismatchError(
            f"the recording has {shared} of the model's {len(columns)} {_word(layout.kind)} "
            f"(lacks {', '.join(lacking[:4])}{', ...' if len(lacking) > 4 else ''}): "
            "use a model fitted on this skeleton or marker set"
        )
    if isinstance(recording, Motion):
        values, frame = joint_channels(recording, _centre_for(recording, layout, columns))
        unknown = np.setdiff1d(np.arange(values.shape[1]), columns)
        return Channels(_picked(values, columns), columns, JointChannels(frame, unknown, values[:, unknown]))
    assert layout.anchors is not None
    positions = _picked(recording.positions, columns)
    cloud = cloud_channels(positions, recording.fps, recording.up, layout.anchors, layout.up, layout.heading)
    return Channels(cloud.values, columns, cloud)


def from_channels(channels: Channels, repaired: Floats, trusted: Bools, recording: Motion | Markers) -> Floats:
    """The recording's own values from repaired channels (T, C).

    Returns
    -------
    (T, D) rad and m for motions, (T, M, 3) m for markers; what the layout does not know stays as it was, and so does
    each value that came back but for rounding: a channel that is zero throughout holds no 1e-17.
    """
    here = np.flatnonzero(channels.columns >= 0)
    to = channels.columns[here]
    if isinstance(recording, Motion):
        assert isinstance(channels.inner, JointChannels)
        unknown = channels.inner.columns
        values, believed = np.empty(recording.q.shape), np.empty(recording.q.shape, dtype=bool)
        for some in pieces(recording.frames):
            values[some, to] = repaired[some, here]
            believed[some] = np.isfinite(recording.q[some])
            believed[some, to] &= trusted[some, here]
        values[:, unknown] = channels.inner.values
        into_angles(values, channels.inner.travel, believed, recording)
        values[:, unknown] = recording.q[:, unknown]
        return _but_for_rounding(values, recording.q)
    assert isinstance(channels.inner, CloudChannels)
    positions = recording.positions.copy()
    positions[:, to] = positions_of(channels.inner, repaired)[:, here]
    return _but_for_rounding(positions, recording.positions)


def _but_for_rounding(values: Floats, recorded: Floats) -> Floats:
    """Values (T, ...), and what was recorded where they are as good as that."""
    for some in pieces(len(values)):
        same = np.abs(values[some] - recorded[some]) < ROUNDING
        values[some][same] = recorded[some][same]
    return values


def si_unit(recording: Motion | Markers, layout: Layout, columns: Ints) -> Floats:
    """(C,) radians or metres per channel unit."""
    if isinstance(recording, Motion):
        per_channel = 1.0 / unit(recording.skeleton)
        return np.where(columns >= 0, per_channel[columns], np.nan)
    return np.full(layout.columns, 0.01)


def _centre_for(recording: Motion, layout: Layout, columns: Ints) -> Floats:
    """(D,) degrees: where each angle of a recording lies by the layout, by itself where that does not know it."""
    angular = recording.skeleton.dof_kind == ROTATION
    centre = own_middle(recording, np.setdiff1d(np.flatnonzero(angular), columns))
    known = columns >= 0
    known[known] = angular[columns[known]]
    centre[columns[known]] = layout.centre[known]
    return centre


def _picked(values: Floats, columns: Ints) -> Floats:
    """Columns of `values` (T, N, ...) in the layout's order, NaN where the recording has none; no copy of the same."""
    if np.array_equal(columns, np.arange(values.shape[1])):
        return values
    picked = np.full((len(values), len(columns), *values.shape[2:]), np.nan)
    here = np.flatnonzero(columns >= 0)
    for some in pieces(len(values)):
        picked[some, here] = values[some, columns[here]]
    return picked


def _plural(kind: str) -> str:
    return "joint angles" if kind == "motion" else "markers"


def _word(kind: str) -> str:
    return "channels" if kind == "motion" else "markers"
