"""Recordings over time: joint angles, markers, and what a repair made of them."""

from dataclasses import dataclass, field, replace
from enum import IntEnum
from typing import Any, Generic, TypeVar, final

import numpy as np

from ..arrays import Bools, Bytes, Floats, Ints, Singles, frozen
from ..errors import MismatchError
from .skeleton import Skeleton


@final
@dataclass(frozen=True, eq=False)
class Motion:
    """Joint angles and root translation of one skeleton over time.

    Attributes
    ----------
    skeleton : the body, D degrees of freedom.
    q : (T, D) in radians and metres, NaN = missing; columns are the rows of the skeleton's DOF table.
    fps : frames per second, Hz.
    source : what the file's own writer needs to give back everything that is not motion; opaque outside `io`.
    guesses : one sentence for each thing the file did not say and the reader supposed.
    warnings : one sentence for each thing that may be wrong with the file.
    """

    skeleton: Skeleton
    q: Floats
    fps: float
    source: Any = None
    guesses: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "q", frozen(self.q))
        if self.q.ndim != 2 or self.q.shape[1] != len(self.skeleton.dof_names):
            raise MismatchError(
                f"a motion of this skeleton needs (frames, {len(self.skeleton.dof_names)}) values, came {self.q.shape}"
            )
        _check_rate(self.fps)

    @property
    def frames(self) -> int:
        """T, the number of frames."""
        return int(self.q.shape[0])

    @property
    def channels(self) -> tuple[str, ...]:
        """(D,) names of the columns of `q`."""
        return self.skeleton.dof_names

    @property
    def present(self) -> Bools:
        """(T, D) True where a sample was recorded."""
        return np.isfinite(self.q)

    @property
    def values(self) -> Floats:
        """(T, D) `q`, by the name that markers have as well."""
        return self.q

    def with_q(self, q: Floats) -> "Motion":
        """The same recording with other values (T, D) in radians and metres."""
        return replace(self, q=q)

    def with_values(self, values: Floats) -> "Motion":
        """`with_q`, by the name that markers have as well."""
        return self.with_q(values)

    def at_frames(self, frames: slice | Ints) -> "Motion":
        """These frames alone, at the same rate."""
        return self.with_q(self.q[frames])


@final
@dataclass(frozen=True, eq=False)
class Markers:
    """Marker positions over time.

    Attributes
    ----------
    names : (M,) as the file spells them.
    positions : (T, M, 3) m, NaN = missing.
    fps : frames per second, Hz.
    residuals : (T, M) m, the capture system's own residual, -1 = missing; None where the format has none.
    up : (3,) unit vector against gravity.
    source, guesses, warnings : as in `Motion`.
    """

    names: tuple[str, ...]
    positions: Floats
    fps: float
    residuals: Floats | None = None
    up: Floats = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    source: Any = None
    guesses: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "names", tuple(self.names))
        object.__setattr__(self, "positions", frozen(self.positions))
        object.__setattr__(self, "up", frozen(self.up))
        if self.positions.ndim != 3 or self.positions.shape[1:] != (len(self.names), 3):
            raise MismatchError(
                f"{len(self.names)} marker names need (frames, {len(self.names)}, 3) positions, "
                f"came {self.positions.shape}"
            )
        if self.residuals is not None:
            object.__setattr__(self, "residuals", frozen(self.residuals))
            if self.residuals.shape != self.positions.shape[:2]:
                raise MismatchError(
                    f"residuals must be {self.positions.shape[:2]} like the positions, came {self.residuals.shape}"
                )
        _check_rate(self.fps)

    @property
    def frames(self) -> int:
        """T, the number of frames."""
        return int(self.positions.shape[0])

    @property
    def channels(self) -> tuple[str, ...]:
        """(M,) marker names."""
        return self.names

    @property
    def present(self) -> Bools:
        """(T, M) True where the marker was seen."""
        return np.asarray(np.isfinite(self.positions).all(axis=2))

    @property
    def values(self) -> Floats:
        """(T, M, 3) `positions`, by the name that motions have as well."""
        return self.positions

    def with_positions(self, positions: Floats) -> "Markers":
        """The same recording with other positions (T, M, 3) in metres; residuals stay as they were."""
        return replace(self, positions=positions)

    def with_values(self, values: Floats) -> "Markers":
        """`with_positions`, by the name that motions have as well."""
        return self.with_positions(values)

    def at_frames(self, frames: slice | Ints) -> "Markers":
        """These frames alone, with their residuals, at the same rate."""
        residuals = None if self.residuals is None else self.residuals[frames]
        return replace(self, positions=self.positions[frames], residuals=residuals)


class Origin(IntEnum):
    """Where a sample of a repaired recording comes from."""

    MEASURED = 0  # the recording's own sample, at most smoothed within its noise
    REPAIRED = 1  # recorded, rejected as an outlier and replaced
    FILLED = 2  # missing in the recording, filled
    LEFT_OPEN = 3  # missing in the recording and still missing: nothing supports a value


Recording = TypeVar("Recording", Motion, Markers)


@dataclass(frozen=True, eq=False)
class Repaired(Generic[Recording]):
    """A repaired recording and all that is known about the repair. C = D channels or M markers.

    Attributes
    ----------
    recording : same channels, frames and rate as the input.
    origin : (T, C) of `Origin`.
    std : (T, C) float32 standard deviation of each sample, rad or m; NaN where left open.
    weights : (T, C) float32 robust weight of each recorded sample in [0, 1]; 0 where missing.
    method : the method's name.
    iterations : of the optimisation; 0 for a filter.
    cost : (iterations + 1,) objective after each iteration; empty for a filter.
    converged : whether the change of cost fell below the tolerance.
    warnings : one sentence each.
    noise : (C,) standard deviation of each channel's noise as the recording told it, rad or m, NaN = not told; None
        where the method does not ask.
    """

    recording: Recording
    origin: Bytes
    std: Singles
    weights: Singles
    method: str
    iterations: int = 0
    cost: Floats = field(default_factory=lambda: np.empty(0))
    converged: bool = True
    warnings: tuple[str, ...] = ()
    noise: Floats | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "origin", frozen(self.origin, np.uint8))
        object.__setattr__(self, "cost", frozen(self.cost))
        for name in ("std", "weights"):  # of a long recording they need as much memory as what they are about
            object.__setattr__(self, name, frozen(getattr(self, name), np.float32))
        shape = (self.recording.frames, len(self.recording.channels))
        for name in ("origin", "std", "weights"):
            if getattr(self, name).shape != shape:
                raise MismatchError(f"{name} must be {shape}, came {getattr(self, name).shape}")
        if self.noise is not None:
            object.__setattr__(self, "noise", frozen(self.noise))
            if self.noise.shape != shape[1:]:
                raise MismatchError(f"noise must be {shape[1:]}, came {self.noise.shape}")

    def counts(self) -> dict[str, int]:
        """How many samples were measured, repaired, filled and left open."""
        return {o.name.lower(): int((self.origin == o).sum()) for o in Origin}

    def counts_by_channel(self) -> dict[str, dict[str, int]]:
        """The same for each channel or marker, by name."""
        return {
            name: {o.name.lower(): int((self.origin[:, c] == o).sum()) for o in Origin}
            for c, name in enumerate(self.recording.channels)
        }


def _check_rate(fps: float) -> None:
    if not (np.isfinite(fps) and fps > 0):
        raise MismatchError(f"a recording needs a frame rate above 0 Hz, came {fps}")
