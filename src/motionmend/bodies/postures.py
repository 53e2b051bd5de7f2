"""Joint positions over time, as depth sensors report them and as trackers and correctors give them back."""

from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np

from ..arrays import Bools, Bytes, Floats, frozen
from ..errors import MismatchError

NOT_TRACKED, INFERRED, TRACKED = 0, 1, 2
ROUNDED = (1e-2, 1e-3)  # s; what recorders round times to
_DROPPED = 1.5  # times the median step; one longer than this spans a frame that was dropped


@final
@dataclass(frozen=True, eq=False)
class Postures:
    """Positions of J joints over T frames.

    Attributes
    ----------
    names : (J,) as the file or the sensor spells them.
    positions : (T, J, 3) m, NaN = missing.
    times : (T,) s, the recording's own.
    state : (T, J) 2 tracked, 1 inferred, 0 not tracked; None where the source does not say.
    std : (T, J) m, standard deviation of each joint's position (one coordinate); None = not known.
    reliability : (T, J) in [0, 1]; None = not known.
    source, guesses, warnings : as in `Motion`.
    """

    names: tuple[str, ...]
    positions: Floats
    times: Floats
    state: Bytes | None = None
    std: Floats | None = None
    reliability: Floats | None = None
    source: Any = None
    guesses: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "names", tuple(self.names))
        object.__setattr__(self, "positions", frozen(self.positions))
        object.__setattr__(self, "times", frozen(self.times))
        if self.positions.ndim != 3 or self.positions.shape[1:] != (len(self.names), 3):
            raise MismatchError(
                f"{len(self.names)} joint names need (frames, {len(self.names)}, 3) positions, "
                f"came {self.positions.shape}"
            )
        if self.times.shape != self.positions.shape[:1]:
            raise MismatchError(f"{self.frames} frames need as many times, came {self.times.shape}")
        for name, dtype in (("state", np.uint8), ("std", np.float64), ("reliability", np.float64)):
            values = getattr(self, name)
            if values is None:
                continue
            object.__setattr__(self, name, frozen(values, dtype))
            if getattr(self, name).shape != self.positions.shape[:2]:
                raise MismatchError(f"{name} must be {self.positions.shape[:2]}, came {getattr(self, name).shape}")

    @property
    def frames(self) -> int:
        """T, the number of frames."""
        return int(self.positions.shape[0])

    @property
    def present(self) -> Bools:
        """(T, J) True where the joint has a position."""
        return np.asarray(np.isfinite(self.positions).all(axis=2))

    @property
    def fps(self) -> float:
        """Hz: one over the median step of `times`, or over the mean one of times that are an even clock's in few
        decimals, most of whose steps are too short or too long; NaN for fewer than two frames, or times that do not
        rise."""
        step = usual_step(self.times)
        return 1.0 / step if step > 0.0 else float("nan")

    def with_positions(self, positions: Floats) -> "Postures":
        """The same recording with other positions (T, J, 3) in metres; all else stays as it was."""
        return replace(self, positions=positions)


def usual_step(times: Floats) -> float:
    """Time from a frame to the next where none was dropped, s; 0 for fewer than two frames.

    Parameters
    ----------
    times : (T,) s.
    """
    if len(times) < 2:
        return 0.0
    steps = np.diff(times)
    median = float(np.median(steps))
    usual = steps[steps < _DROPPED * median]
    for unit in ROUNDED:
        whole = np.abs(times / unit - np.rint(times / unit)).max() < 1e-6 and 2.0 * unit <= median
        if whole and np.abs(usual - usual.mean()).max() < 1.01 * unit:  # 30 Hz: 33 ms, 33 ms, 34 ms
            return float(usual.mean())
    return median
