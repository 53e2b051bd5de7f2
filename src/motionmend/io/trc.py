"""TRC: marker positions as tab-separated text, as OpenSim, Cortex and Pose2Sim exchange them.

Read leniently: any of the header's keys, any numbering of the coordinate line, blank or `NaN` or (0, 0, 0) for a
missing marker. Written as OpenSim wants it: eight keys, tabs (one behind the last cell too, without which OpenSim
loses a blank last marker), X1 Y1 Z1 ..., an empty line, blanks for missing markers.
"""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..arrays import Floats, frozen
from ..bodies.motion import Markers
from ..errors import FileError, counted
from .atomic import atomic
from .columns import cells_of, read_lines, read_rows, steady_rate, unended, with_points
from .marker_text import against_promise, coordinates_for_text, number_of, present_in_text, refuse_twice
from .units import metres_per_unit
from .vertical import up_of

_KEYS = (
    "DataRate",
    "CameraRate",
    "NumFrames",
    "NumMarkers",
    "Units",
    "OrigDataRate",
    "OrigDataStartFrame",
    "OrigNumFrames",
)
_WANTED = "a TRC file"
STATED = "DataRate says"  # begins the guess about a header whose rate is not that of the times


@dataclass(frozen=True, eq=False)
class TrcSource:
    """What a TRC file says beside names and positions: its header, unit, first frame number and time (s), and the time
    (T,) of each frame in s, as it says."""

    header: dict[str, str]
    metres: float
    first_frame: int
    start: float
    times: Floats


def read_trc(path: str | os.PathLike[str], fps: float | None = None) -> Markers:
    """Read the markers of a TRC file.

    Parameters
    ----------
    path : the file.
    fps : Hz, for a file with one frame and no DataRate.

    Returns
    -------
    markers : positions in metres.

    Raises
    ------
    FileError : not there, not a TRC file, or shorter than its header promises.
    """
    name = str(path)
    lines = read_lines(path, _WANTED)
    titles = next((k for k, line in enumerate(lines[:20]) if line.lstrip().lower().startswith("frame#")), None)
    if titles is None:
        raise FileError(f"{name}: wanted {_WANTED}, there is no line that starts with Frame#; check the file's ending")
    header = _header(lines[:titles])
    names = [title.strip() for title in lines[titles].split("\t")[2:] if title.strip()]
    if not names:
        raise FileError(f"{name}: wanted marker names behind Frame# and Time, came none; the file is damaged")
    refuse_twice(names, name)
    begin = next((k for k in range(titles + 1, len(lines)) if _starts_with_number(lines[k])), len(lines))
    lines[begin:] = [with_points(line, "\t") for line in lines[begin:]]
    rows = read_rows(lines[begin:], "\t", 2 + 3 * len(names), begin + 1, name)
    guesses = _promises(header, rows, names, name)
    rate, rate_guess = _rate(header, lines[begin:], rows, fps, name)
    file_xyz = rows[:, 2:].reshape(len(rows), len(names), 3)
    present, void_guesses = present_in_text(file_xyz)
    metres, unit_guess = metres_per_unit([header.get("Units", "")], file_xyz, present, "Units")
    positions = np.where(present[:, :, None], file_xyz * metres, np.nan)
    up, up_guess = up_of(names, positions)
    first = int(rows[0, 0]) if np.isfinite(rows[0, 0]) else 1
    start = float(rows[0, 1]) if np.isfinite(rows[0, 1]) else 0.0
    said = (*guesses, *rate_guess, *unit_guess, *void_guesses, *((up_guess,) if up_guess else ()))
    source = TrcSource(header, metres, first, start, frozen(rows[:, 1]))
    return Markers(tuple(names), positions, rate, up=up, source=source, guesses=said, warnings=unended(lines))


def write_trc(path: str | os.PathLike[str], markers: Markers) -> None:
    """Write markers to a TRC file: in the unit, with the first frame and the original rate of the TRC file they
    came from; else in millimetres from frame 1 and time 0.

    Raises
    ------
    FileError : a name that a TRC file cannot hold, or the file cannot be written.
    """
    fresh = TrcSource({"Units": "mm"}, 0.001, 1, 0.0, np.zeros(0))
    source = markers.source if isinstance(markers.source, TrcSource) else fresh
    rate = f"{markers.fps:.9g}"
    header = {"CameraRate": rate, "OrigDataRate": rate, "OrigDataStartFrame": "1", "OrigNumFrames": markers.frames}
    header |= {key: value for key, value in source.header.items() if key in _KEYS}
    unit = {1.0: "m", 0.01: "cm", 0.001: "mm"}.get(source.metres, header.get("Units", "m"))
    header |= {"DataRate": rate, "NumFrames": markers.frames, "NumMarkers": len(markers.names), "Units": unit}
    count = len(markers.names)
    lines = [
        f"PathFileType\t4\t(X/Y/Z)\t{Path(path).name}",
        "\t".join(_KEYS),
        "\t".join(str(header[key]) for key in _KEYS),
        "Frame#\tTime\t" + "".join(f"{name}\t\t\t" for name in markers.names),
        "\t\t" + "".join(f"X{k}\tY{k}\tZ{k}\t" for k in range(1, count + 1)),
        "",
    ]
    rows = coordinates_for_text(markers, source.metres, path, _WANTED)
    times = cells_of(source.start + np.arange(markers.frames) / markers.fps)
    for k, (time, row) in enumerate(zip(times, rows, strict=True)):
        lines.append("\t".join([str(source.first_frame + k), time, *cells_of(row)]) + "\t")
    with atomic(path) as temporary:
        temporary.write_bytes(("\n".join(lines) + "\n").encode())


def _header(lines: Sequence[str]) -> dict[str, str]:
    """Keys and values of the two lines that start with DataRate and follow it."""
    at = next((k for k, line in enumerate(lines[:-1]) if line.split()[:1] == ["DataRate"]), None)
    if at is None:
        return {}
    return dict(zip(lines[at].split(), with_points(lines[at + 1], "\t").split(), strict=False))


def _starts_with_number(line: str) -> bool:
    try:
        float(line.split("\t", 1)[0])
    except ValueError:
        return False
    return True


def _promises(header: dict[str, str], rows: Floats, names: Sequence[str], name: str) -> tuple[str, ...]:
    frames, markers, first = (
        number_of(header.get(key, "")) for key in ("NumFrames", "NumMarkers", "OrigDataStartFrame")
    )
    if frames > len(rows) and first and rows[0, 0] > first:  # no file that is cut off at its end begins so
        said: tuple[str, ...] = (
            f"the header says {counted(int(frames), 'frame')} from {first:g} on, the rows are {rows[0, 0]:g} to "
            f"{rows[-1, 0]:g}: took them for a part that was cut out",
        )
    else:
        said = against_promise(frames, len(rows), "NumFrames", name)
    if int(markers) not in (0, len(names)):
        said += (f"the header says {counted(int(markers), 'marker')}, the file names {len(names)}: took those",)
    return said


def _rate(
    header: dict[str, str], lines: Sequence[str], rows: Floats, fps: float | None, name: str
) -> tuple[float, tuple[str, ...]]:
    """Hz, by the times where they are those of a rate, and what is said of it."""
    stated, steps = number_of(header.get("DataRate", "")), len(rows) - 1
    span = float(rows[-1, 1] - rows[0, 1])
    if stated and (not steps or not np.isfinite(span) or abs(span * stated - steps) <= 0.01 * len(rows) + 0.5):
        return stated, ()
    if not steps:
        if fps is None:
            raise FileError(f"{name}: wanted a DataRate, this TRC file states none; give it with --fps")
        return fps, (f"the file states no frame rate: took {fps:g} Hz as given",)
    differ = f"{STATED} {stated:g} Hz, the times span {span:g} s: took"
    try:
        rate, said = steady_rate(rows[:, 1], [line.split("\t", 2)[1] for line in lines[: len(rows)]], name)
    except FileError:
        if not stated:
            raise
        return stated, (f"{differ} {stated:g} Hz",)
    if not stated:
        return rate, (f"DataRate is missing: took {rate:g} Hz from the times", *said)
    return rate, ("; ".join([f"{differ} {rate:g} Hz, as they do", *said]),)
