"""What a repair did to every sample, as JSON: counts, deviations, and runs of samples that were not measured."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from ..arrays import Bools, Bytes, Floats, runs
from ..bodies.motion import Markers, Motion, Origin, Repaired
from ..bodies.skeleton import ROTATION
from .findings import labels

DIGITS = 3  # significant digits of a standard deviation


def provenance(repaired: Repaired[Any]) -> dict[str, Any]:
    """Entries `counts`, `channels`, `noise`, `std`, `runs`, `iterations`, `cost` and `converged` of a .mend.json.

    `noise` is what the recording told of itself: for each channel the standard deviation of its noise and the share of
    its recorded samples that were outliers; null where the method does not ask. Standard deviations are in degrees for
    angles and in metres else, as each entry says with its `unit`. `runs` lists for each channel or marker, by origin,
    the stretches of frames that were not measured: [first frame from 0, number of frames, standard deviation]. The last
    is one number where it is the same throughout, else one for each frame; it is absent where a gap was left open.
    """
    names = labels(repaired.recording.channels)
    _, unit = _units(repaired.recording)
    return {
        "counts": repaired.counts(),
        "channels": {name: _counts(repaired.origin[:, c]) for c, name in enumerate(names)},
        "noise": _noise(repaired, names),
        "std": {name: _spread(_std(repaired, c), unit[c]) for c, name in enumerate(names)},
        "runs": Runs(repaired, names),
        "iterations": repaired.iterations,
        "cost": [_short(cost, 10) for cost in repaired.cost],
        "converged": repaired.converged,
    }


def numbering(recording: Motion | Markers) -> dict[str, int]:
    """The entry `first_frame`: by which number the file calls its first frame, where that is neither 0 nor 1.

    Frames in a .mend.json are counted from 0, whatever number the file has for them.
    """
    from ..io.conversion import first_frame

    number = first_frame(recording)
    return {} if number is None else {"first_frame": number}


class Runs(Mapping[str, dict[str, list[list[Any]]]]):
    """The entry `runs` of `provenance`: each channel's are made when they are asked for, and not held.

    Of a long recording those of all channels together need as much memory as its samples.
    """

    def __init__(self, repaired: Repaired[Any], names: Sequence[str]) -> None:
        touched = (repaired.origin != Origin.MEASURED).any(axis=0)
        self._repaired = repaired
        self._columns = {name: c for c, name in enumerate(names) if touched[c]}

    def __getitem__(self, name: str) -> dict[str, list[list[Any]]]:
        column = self._columns[name]
        return runs_of(self._repaired.origin[:, column], _std(self._repaired, column))

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)


def repaired_from(said: Mapping[str, Any], recording: Motion | Markers) -> Repaired[Any] | None:
    """What was done to a recording, as the .mend.json beside it says; None where that tells of no single sample.

    Parameters
    ----------
    said : what `provenance` or the tracker wrote. Deviations of measured samples are not in it, and NaN here.
    recording : that was written with it.

    Raises
    ------
    KeyError, TypeError, ValueError : when it is not of this form.
    """
    runs = said["joint_runs"] if "joint_runs" in said else said.get("runs")
    if runs is None or ("joint_runs" in said and isinstance(recording, Motion)):
        return None  # joints as they were seen, of which the angles were made: no single angle's origin
    columns = {name: c for c, name in enumerate(labels(recording.channels))}
    origin = np.zeros((recording.frames, len(columns)), np.uint8)
    std = np.full(origin.shape, np.nan, np.float32)
    scale, _ = _units(recording)
    for name, kinds in runs.items():
        for kind, stretches in kinds.items():
            for first, frames, *sure in stretches:
                if not 0 <= first < first + frames <= recording.frames:
                    raise ValueError(f"{name}: frames {first} to {first + frames - 1} of {recording.frames}")
                at = slice(first, first + frames), columns[name]
                origin[at] = Origin[kind.upper()]
                std[at] = np.asarray(sure[0]) / scale[columns[name]] if sure else np.nan
    cost = said["cost"] if isinstance(said["cost"], list) else []
    return Repaired(
        recording,
        origin,
        std,
        np.where(origin == Origin.MEASURED, 1.0, 0.0),
        str(said["method"]),
        int(said["iterations"]),
        np.asarray(cost, np.float64),
        bool(said["converged"]),
        tuple(str(line) for line in said["warnings"]),
    )


def mask_runs(mask: Bools) -> list[tuple[int, int]]:
    """First frame and number of frames of each stretch where a mask (T,) is True."""
    return [(start, stop - start) for start, stop in runs(mask)]


def _counts(origin: Bytes) -> dict[str, int]:
    return {o.name.lower(): int((origin == o).sum()) for o in Origin}


def _units(recording: Motion | Markers) -> tuple[Floats, list[str]]:
    """Per channel: what a standard deviation is multiplied with to be written, and the unit it has then."""
    if not isinstance(recording, Motion):
        return np.ones(len(recording.channels)), ["m"] * len(recording.channels)
    turns = recording.skeleton.dof_kind == ROTATION
    return np.where(turns, np.degrees(1.0), 1.0), ["deg" if turn else "m" for turn in turns]


def _std(repaired: Repaired[Any], column: int) -> Floats:
    """(T,) standard deviations of a channel as they are written."""
    return np.asarray(repaired.std[:, column] * _units(repaired.recording)[0][column])


def _spread(std: Floats, unit: str) -> dict[str, Any]:
    there = std[np.isfinite(std)]
    if not there.size:
        return {"unit": unit, "mean": None, "max": None}
    return {"unit": unit, "mean": _short(float(there.mean())), "max": _short(float(there.max()))}


def _noise(repaired: Repaired[Any], names: list[str]) -> dict[str, dict[str, Any]] | None:
    if repaired.noise is None:
        return None
    scale, unit = _units(repaired.recording)
    recorded = np.isin(repaired.origin, (Origin.MEASURED, Origin.REPAIRED)).sum(axis=0)
    share = (repaired.origin == Origin.REPAIRED).sum(axis=0) / np.maximum(recorded, 1)
    return {
        name: {
            "unit": unit[c],
            "value": _short(float(value)) if np.isfinite(value) else None,
            "outliers": _short(float(share[c])) if recorded[c] else None,
        }
        for c, (name, value) in enumerate(zip(names, repaired.noise * scale, strict=True))
    }


def runs_of(origin: Bytes, std: Floats) -> dict[str, list[list[Any]]]:
    """Of one channel the stretches that were not measured, by origin: [first frame, number of frames, deviations].

    Parameters
    ----------
    origin : (T,) of `Origin`. std : (T,) in the unit they are written in.
    """
    found: dict[str, list[list[Any]]] = {}
    for kind in (Origin.REPAIRED, Origin.FILLED, Origin.LEFT_OPEN):
        for first, frames in mask_runs(origin == kind):
            run: list[Any] = [first, frames]
            if kind is not Origin.LEFT_OPEN:
                values = [_short(value) for value in std[first : first + frames]]
                run.append(values[0] if len(set(values)) == 1 else values)
            found.setdefault(kind.name.lower(), []).append(run)
    return found


def _short(value: float, digits: int = DIGITS) -> float:
    return float(f"{value:.{digits}g}")
