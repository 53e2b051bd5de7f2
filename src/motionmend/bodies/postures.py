"""Joint positions over time, as depth sensors report them and as trackers and correctors give them back."""

from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np

from ..arrays import Bools, Bytes, Floats, frozen
from ..errors import MismatchError

NOT_TRACKED, INFERRED, TRACKED = 0, 1, 2


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
        """Hz: one over the median step of `times`; NaN for fewer than two frames, or times that do not rise."""
        step = float(np.median(np.diff(self.times))) if self.frames > 1 else 0.0
        return 1.0 / step if step > 0.0 else float("nan")

    def with_positions(self, positions: Floats) -> "Postures":
        """The same recording with other positions (T, J, 3) in metres; all else stays as it was."""
        return replace(self, positions=positions)
