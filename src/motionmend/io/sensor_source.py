"""What every reader of sensor skeletons needs beside the rows: times in seconds, absent joints."""

from dataclasses import dataclass

import numpy as np

from ..arrays import Bools, Bytes, Floats
from ..bodies.postures import NOT_TRACKED
from ..errors import UsageError, counted
from .text import LARGEST

USUAL_FPS = 30.0  # of every depth sensor read here, Hz
_UNITS = {"seconds": 1.0, "milliseconds": 1e-3, "microseconds": 1e-6, "100 ns ticks": 1e-7, "nanoseconds": 1e-9}
_LONG_UNITS = {"seconds": 1.0, "minutes": 60.0, "hours": 3600.0, "days": 86400.0}  # as spreadsheets and MATLAB count
COUNTED = "times go from number to number and count as seconds, 1 Hz: do they count frames? Then call the column frame"
_QUICKEST = 1e-3  # from one frame to the next; what is less is of a unit longer than a second


@dataclass(frozen=True)
class SensorSource:
    """What is known of a recording beside its postures: in words what it is."""

    kind: str


def seconds_of(stamps: Floats, told: str | None = None) -> tuple[Floats, tuple[str, ...], tuple[str, ...]]:
    """Time stamps as seconds, of a unit that is told or must be guessed.

    It is the one in which the median step is nearest to a sensor's usual 1/30 s; a thousandfold lies between
    most of them.

    Parameters
    ----------
    stamps : (T,) as the file has them.
    told : their unit, a key of `_UNITS`.

    Returns
    -------
    times (T,) s, what was guessed, and what is wrong with them. A missing stamp is interpolated.
    """
    known = np.isfinite(stamps)
    warnings: list[str] = []
    if not known.any():
        return even_times(len(stamps), None)[0], (), ("there are no times: took 30 Hz",)
    if not known.all():
        warnings.append(f"{int((~known).sum())} time stamps are no numbers: interpolated")
        places = np.arange(len(stamps))
        stamps = np.interp(places, places[known], stamps[known])
    if len(stamps) == 1 and told is None:
        return np.zeros(1), ("one frame: its time was taken as 0 s",), ()
    steps = np.diff(stamps)
    rising = steps[steps > 0]
    if not rising.size and len(stamps) > 1:
        return even_times(len(stamps), None)[0], (), ("the times do not rise: took 30 Hz instead",)
    if rising.size < steps.size:
        warnings.append(f"{int((steps <= 0).sum())} of {len(stamps)} times do not rise")
    if told is not None:
        return stamps * _UNITS[told], (), tuple(warnings)
    step = float(np.median(rising))
    units = _UNITS if step >= _QUICKEST else _LONG_UNITS
    unit = min(units, key=lambda name: abs(np.log(step * units[name] * USUAL_FPS)))
    guessed = () if unit == "seconds" else (f"times were taken as {unit}: {1 / (step * units[unit]):.3g} Hz",)
    return stamps * units[unit], guessed, tuple(warnings)


def counts_frames(stamps: Floats) -> bool:
    """Whether a column (T,) counts 0, 1, 2, perhaps with some left out: as seconds no sensor is so slow, as
    milliseconds none so fast."""
    steps = np.diff(stamps)
    return len(steps) > 0 and bool(np.median(steps) == 1.0 and (steps >= 1.0).all() and (stamps % 1.0 == 0.0).all())


def counted_as_seconds(times: Floats) -> tuple[str, ...]:
    """A sentence about times (T,) that were taken as s and may be the frames' numbers; none where they are not."""
    return (COUNTED,) if counts_frames(times) else ()


def even_times(frames: int, fps: float | None, why: str = "the file has no times") -> tuple[Floats, tuple[str, ...]]:
    """(T,) s of a file without times, or for another reason why, and a sentence about the rate.

    Raises
    ------
    UsageError : a rate that is none.
    """
    if fps is not None and not 0 < fps < np.inf:
        raise UsageError(f"a frame rate above 0 Hz is wanted, came {fps}")
    said = f"took {fps:g} Hz as given" if fps else f"took {USUAL_FPS:g} Hz"
    return np.arange(frames) / (fps or USUAL_FPS), (f"{why}: {said}",)


def with_absent(positions: Floats, state: Bytes | None) -> tuple[Floats, tuple[str, ...]]:
    """(T, J, 3) with NaN where a joint has no position: it is not finite, at exactly (0, 0, 0) where that is not the
    joint from which all others are given, or not tracked in a frame in which no joint is, which recorders write when
    nobody is there. Of those that are nowhere it is said.

    Parameters
    ----------
    positions : (T, J, 3) m.
    state : (T, J) or None.
    """
    beyond: Bools = np.asarray((np.abs(positions) > LARGEST).any(axis=2))
    zero: Bools = np.asarray(~positions.any(axis=2))
    alone = np.flatnonzero(zero.sum(axis=1) == 1)
    if len(alone):
        from ..kernels.origins import origin_of  # compiled code, which few files need

        roots = [origin_of(np.ascontiguousarray(positions[t], dtype=np.float64)) for t in alone]
        zero[alone] &= np.not_equal.outer(roots, np.arange(zero.shape[1]))
    absent: Bools = np.asarray(beyond | np.isnan(positions).any(axis=2) | zero)
    nowhere = int(beyond.sum())
    said = (f"{counted(nowhere, 'position')} infinite or absurdly far away: taken as missing",) if nowhere else ()
    if state is not None:
        absent |= (state == NOT_TRACKED).all(axis=1)[:, None]
    return np.where(absent[:, :, None], np.nan, positions), said


def states_of(values: Floats) -> tuple[Bytes, tuple[str, ...]]:
    """Tracking states (T, J) from a file's numbers; what is none of 0, 1, 2 counts as not tracked, and is said."""
    right = np.isin(values, (0.0, 1.0, 2.0))
    wrong = int((~right).sum())
    said = (f"{wrong} tracking states are none of 0, 1, 2: taken as not tracked",) if wrong else ()
    return np.where(right, values, NOT_TRACKED).astype(np.uint8), said


def spread_states(present: Bools, state: Bytes | None) -> Bytes | None:
    """States (T, J) of a recording in which frames without the person are empty: those are not tracked."""
    return None if state is None else np.where(present, state, NOT_TRACKED).astype(np.uint8)
