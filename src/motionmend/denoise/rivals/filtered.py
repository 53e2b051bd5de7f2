"""What a classic method gives back."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...arrays import Bools, Floats, frozen
from ...errors import MismatchError
from ...numerics.walk import noise_level

TOGETHER = 1 << 22  # values of a long recording that are looked at together


@dataclass(frozen=True, eq=False)
class Filtered:
    """Channels (T, C), or markers (T, M, 3), after a filter or gap filler, in the units they came in.

    Attributes
    ----------
    values : (T, C) or (T, M, 3); NaN where left open, never where a sample was measured.
    std : (T, C) or (T, M), the method's own standard deviation of each sample (of each coordinate of a marker);
        NaN where left open, and where the recording is too short to tell.
    filled : (T, C) or (T, M), True where nothing was measured and now stands a value.
    """

    values: Floats
    std: Floats
    filled: Bools

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", frozen(self.values))
        object.__setattr__(self, "std", frozen(self.std))
        object.__setattr__(self, "filled", frozen(self.filled, np.bool_))
        if not self.std.shape == self.filled.shape == self.values.shape[:2]:
            raise MismatchError(
                f"std and filled must be {self.values.shape[:2]}, came {self.std.shape} and {self.filled.shape}"
            )


def check_channels(values: Floats, fps: float) -> None:
    """Refuse what is not an array (T, C) of channels at a rate in Hz."""
    if values.ndim != 2:
        raise MismatchError(f"channels must be (frames, channels), came {values.shape}")
    if not (np.isfinite(fps) and fps > 0):
        raise MismatchError(f"a recording needs a frame rate above 0 Hz, came {fps}")


def marker_std(positions: Floats, seen: Bools) -> Floats:
    """(T, M) noise level per coordinate of markers (T, M, 3) where they are seen (T, M), NaN elsewhere."""
    level = noise_level(positions.reshape(len(positions), 3 * seen.shape[1])).reshape(-1, 3)
    return np.where(seen, np.sqrt(np.square(level).mean(axis=1)), np.nan)


def channelwise(method: Callable[[Floats, float], Filtered], values: Floats, fps: float) -> Filtered:
    """Apply a method that looks at each channel by itself; of a long recording to a few channels at a time.

    Parameters
    ----------
    method : of channels and Hz.
    values : (T, C) in any unit, NaN = missing.
    fps : Hz.
    """
    frames, channels = values.shape
    together = max(1, TOGETHER // max(frames, 1))
    if together >= channels:
        return method(values, fps)
    result, std, filled = np.empty(values.shape), np.empty(values.shape), np.empty(values.shape, dtype=bool)
    for first in range(0, channels, together):
        own = slice(first, first + together)
        found = method(np.ascontiguousarray(values[:, own]), fps)
        result[:, own], std[:, own], filled[:, own] = found.values, found.std, found.filled
    return Filtered(result, std, filled)
