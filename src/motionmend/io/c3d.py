"""C3D: what optical motion capture systems write.

The file is read by our own code (`c3d_layout`), which the tests hold against ezc3d and py-c3d: ezc3d 1.7 ends the
whole process on some damaged files, reads 65,535 frames of a longer file without a word, and takes the camera mask
for the residual. The header counts to 65,535 frames; of more, TRIAL:ACTUAL_END_FIELD (two 16-bit words, the low one
first) and POINT:LONG_FRAMES say how many, and both are written; of a piece of a long trial TRIAL says which it is.
Writing changes the bytes of the file that was read: positions and fourth words of the markers, POINT:SCALE when the
file held integers, and a group MOTIONMEND (`c3d_listing`). Everything else - header, events, analog samples, force
plates, parameters of any type, computed and unlabelled points, camera masks - stays as it was, byte for byte.

Missing are points with residual -1, with NaN, and at (0, 0, 0). A missing point is written as (0, 0, 0) with residual
-1, as the standard wants it. A filled or replaced point gets residual 0 and no cameras.
"""

import os
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import Bools, Bytes, Floats
from ..bodies.motion import Markers, Origin, Repaired
from ..errors import FileError, MismatchError
from .atomic import atomic
from .c3d_chain import with_values
from .c3d_fresh import METRES, blank
from .c3d_layout import Layout, assemble, frames_of, parse
from .c3d_listing import listed_counts, listed_method, listed_points, read_origin, with_listing, without_listing
from .c3d_points import sort_points
from .text import LARGEST
from .units import metres_per_unit
from .vertical import up_of

_NANOMETRE = 1e-9


@dataclass(frozen=True, eq=False)
class C3dSource:
    """A C3D file as it was read, and which of its points are the markers."""

    raw: bytes = field(repr=False)
    layout: Layout = field(repr=False)
    frames: int
    labels: tuple[str, ...]
    markers: tuple[int, ...]
    metres: float


def read_c3d(path: str | os.PathLike[str], fps: float | None = None) -> Markers:
    """Read the markers of a C3D file.

    Parameters
    ----------
    path : the file.
    fps : Hz, for a file that states no rate.

    Returns
    -------
    markers : labelled, measured points; computed and unlabelled ones are set aside (see `c3d_points`) and stay in the
        file. Positions and residuals in metres.

    Raises
    ------
    FileError : not there, not a C3D file, damaged, cut off, without markers or frames, or longer than it says.
    """
    name = str(path)
    try:
        raw = Path(path).read_bytes()
    except OSError as failure:
        raise FileError(f"{name}: wanted a C3D file, cannot open it: {failure.strerror}; check the path") from None
    layout = parse(raw, name)
    frames, notes = frames_of(raw, layout, name)
    rows = layout.rows(raw, frames)
    with np.errstate(invalid="ignore"):  # a damaged file may hold any bits
        xyz = layout.coordinates(rows).astype(np.float64)
    fourth = layout.fourth_words(rows)
    present = _present(xyz, fourth)
    labels = (layout.texts("POINT", "LABELS") + ("",) * layout.points)[: layout.points]
    ours = listed_points(layout)
    ever, seen = np.asarray(present.any(axis=0)), np.asarray((fourth > 0).any(axis=0))
    points = sort_points(layout, labels, ever, seen, ours)
    if not points.markers:
        raise FileError(f"{name}: wanted labelled markers, none of its {layout.points} points is one; label them first")
    chosen = list(points.markers)
    metres, unit_guess = metres_per_unit(
        layout.texts("POINT", "UNITS"), xyz[:, chosen], present[:, chosen], "POINT:UNITS"
    )
    positions = np.where(present[:, chosen, None], xyz[:, chosen] * metres, np.nan)
    names, renamed = _unique([labels[k] for k in chosen])
    screen = next(iter(layout.texts("POINT", "Y_SCREEN")), None)
    up, up_guess = up_of(names, positions, screen)
    rate, rate_guess = _rate(layout, fps, name)
    source = C3dSource(raw, layout, frames, labels, points.markers, metres)
    missing = (fourth[:, chosen] >= 0) & ~present[:, chosen]
    with np.errstate(invalid="ignore"):
        far = int((np.abs(xyz[:, chosen][missing]) > LARGEST).any(axis=1).sum())
    void = (f"{far} positions beyond {LARGEST:g} were taken as missing",) if far else ()
    step = (
        f"the file holds whole steps of {layout.scale * metres * 1000.0:.3g} mm: what is written of it are real numbers"
    )
    steps = (step,) if layout.integers else ()
    said = (*notes, *unit_guess, *rate_guess, *points.guesses, *renamed, *void, *steps, *_repaired_before(layout))
    return Markers(
        names=names,
        positions=positions,
        fps=rate,
        residuals=np.where(present[:, chosen], (fourth[:, chosen] & 0xFF) * abs(layout.scale) * metres, -1.0),
        up=up,
        source=source,
        guesses=said if up_guess is None else (*said, up_guess),
    )


def write_c3d(path: str | os.PathLike[str], markers: Markers, repaired: Repaired[Markers] | None = None) -> None:
    """Write markers to a C3D file: into a copy of the file they came from, or into a new one.

    Parameters
    ----------
    path : where to; what stands there is replaced.
    markers : as `read_c3d` gave them, with other positions or residuals; or from anywhere else.
    repaired : says which samples were filled or replaced; they are listed in the group MOTIONMEND.

    Raises
    ------
    MismatchError : markers, frames or rate are not those of the file they came from.
    FileError : more markers than a C3D file can name, or the file cannot be written.
    """
    if isinstance(markers.source, C3dSource):
        source = markers.source
        _fits(markers, source)
    else:
        raw, everyone = blank(markers, str(path)), tuple(range(len(markers.names)))
        source = C3dSource(raw, parse(raw, str(path)), markers.frames, markers.names, everyone, METRES)
    content = _into(source, markers, repaired, str(path))
    with atomic(path) as temporary:
        temporary.write_bytes(content)


def _present(xyz: NDArray[Any], fourth: NDArray[np.int16]) -> Bools:
    """(T, P) whether a point was measured: no residual below zero, no NaN nor beyond `LARGEST`, not at the origin."""
    with np.errstate(invalid="ignore"):  # a damaged file may hold any bits
        x, y, z = np.moveaxis(xyz, 2, 0)  # one after the other: numpy is slow along an axis of three
        within = (np.abs(x) <= LARGEST) & (np.abs(y) <= LARGEST) & (np.abs(z) <= LARGEST)
        return np.asarray((fourth >= 0) & within & ((x != 0.0) | (y != 0.0) | (z != 0.0)))


def _unique(labels: Sequence[str]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Labels with #2, #3, ... where one comes again, and what to say about it."""
    seen: Counter[str] = Counter()
    names = []
    for label in labels:
        seen[label] += 1
        names.append(label if seen[label] == 1 else f"{label}#{seen[label]}")
    again = [label for label, count in seen.items() if count > 1]
    if not again:
        return tuple(names), ()
    return tuple(names), (f"labels used more than once were told apart by #2, #3, ...: {', '.join(again)}",)


def _rate(layout: Layout, fps: float | None, name: str) -> tuple[float, tuple[str, ...]]:
    stated, header = _shortest(layout.number("POINT", "RATE")), _shortest(layout.header_rate)
    if stated > 0:
        if header > 0 and abs(header - stated) > 1e-3 * stated:
            return stated, (f"POINT:RATE says {stated:g} Hz, the header {header:g} Hz: took {stated:g} Hz",)
        return stated, ()
    if header > 0:
        return header, (f"POINT:RATE is missing: took {header:g} Hz from the header",)
    if fps is None:
        raise FileError(f"{name}: wanted a frame rate, this C3D file states none; give it with --fps")
    return fps, (f"the file states no frame rate: took {fps:g} Hz as given",)


def _shortest(value: float) -> float:
    """The shortest decimal number that is stored as this 32-bit float: 119.88, not 119.87999725."""
    return float(str(np.float32(value)))


def _repaired_before(layout: Layout) -> tuple[str, ...]:
    filled, replaced = listed_counts(layout)
    if not filled + replaced:
        return ()
    return (f"{filled} samples were filled and {replaced} replaced by an earlier repair (group MOTIONMEND)",)


def _fits(markers: Markers, source: C3dSource) -> None:
    names, _ = _unique([source.labels[k] for k in source.markers])
    rate, _ = _rate(source.layout, markers.fps, "source")
    if markers.frames != source.frames or markers.names != names or abs(markers.fps - rate) > 1e-6 * rate:
        raise MismatchError(
            f"markers from a C3D file go back into it: wanted {source.frames} frames of its {len(names)} markers at "
            f"{rate:g} Hz, came {markers.frames} of {len(markers.names)} at {markers.fps:g} Hz; "
            f"set source=None to write a new file"
        )


def _into(source: C3dSource, markers: Markers, repaired: Repaired[Markers] | None, name: str) -> bytes:
    """The file's bytes with other markers."""
    layout, chosen = source.layout, list(source.markers)
    rows = layout.rows(source.raw, source.frames)
    fourth = layout.fourth_words(rows)
    was = _present(layout.coordinates(rows), fourth)[:, chosen]
    origin = _origin(source, markers, repaired, fourth, was)
    fourth = fourth[:, chosen]
    raw, records = source.raw, without_listing(layout.records)
    if layout.integers:
        stored = layout.encode(_as_floats(layout, rows))
        word = layout.encode(np.array([-layout.scale], np.float32)).astype("<u4").tobytes()
        records = with_values(records, layout.find("POINT", "SCALE"), word)
        raw = raw[:12] + word + raw[16:]
    else:
        stored = rows.copy()
    four = stored[:, : 4 * layout.points].reshape(source.frames, layout.points, 4)[:, chosen]
    here = markers.present
    four[here, :3] = layout.encode(_coordinates(markers.positions[here] / source.metres, source.metres, name))
    lost = ~here & (fourth >= 0)
    four[lost, :3] = 0
    words = _fourth_words(fourth, markers, origin, layout, source.metres)
    changed = (words != fourth) & (here | lost)
    four[changed, 3] = layout.encode(words[changed].astype(np.float32))
    for k, place in enumerate(chosen):
        stored[:, 4 * place : 4 * place + 4] = four[:, k]
    method = listed_method(layout) if repaired is None else repaired.method
    if method is not None or (origin == Origin.FILLED).any():
        whole = np.zeros((source.frames, layout.points), np.uint8)
        whole[:, chosen] = origin
        records = with_listing(layout, records, source.labels, whole, method or "", name)
    return assemble(raw, layout, source.frames, records, stored.astype("<u4").tobytes(), name)


def _origin(
    source: C3dSource, markers: Markers, repaired: Repaired[Markers] | None, fourth: NDArray[np.int16], was: Bools
) -> Bytes:
    """(T, M) of `Origin`: what this repair did, and what an earlier one had done."""
    before = read_origin(source.layout, fourth)[:, list(source.markers)]
    now = np.where(markers.present & ~was, Origin.FILLED, Origin.MEASURED).astype(np.uint8)
    if repaired is None:
        # A new file holds what the recording holds; nothing in it was filled.
        now = now if isinstance(markers.source, C3dSource) else np.zeros_like(now)
    elif repaired.origin.shape != now.shape:
        raise MismatchError(f"the repair is of {repaired.origin.shape} samples, the recording has {now.shape}")
    else:
        now = repaired.origin
    merged = np.where(now == Origin.MEASURED, before, now)
    missing = Origin.MEASURED if repaired is None and listed_method(source.layout) is None else Origin.LEFT_OPEN
    return np.where(markers.present, merged, missing).astype(np.uint8)


def _as_floats(layout: Layout, rows: NDArray[Any]) -> NDArray[np.float32]:
    """(T, row) integers as a file with floats holds them: scaled points, everything else by value."""
    floats = rows.astype(np.float32)
    if "UNSIGNED" in layout.texts("ANALOG", "FORMAT"):
        floats[:, 4 * layout.points :] = rows[:, 4 * layout.points :].astype(np.uint16)
    points = floats[:, : 4 * layout.points].reshape(len(rows), layout.points, 4)
    points[:, :, :3] = layout.coordinates(rows)
    return floats


def _coordinates(values: Floats, metres: float, name: str) -> NDArray[np.float32]:
    """(N, 3) in the file's unit; a point exactly on the origin, which would read as missing, moves by a nanometre."""
    narrowed = values.astype(np.float32)
    if not np.isfinite(narrowed).all():
        raise FileError(f"{name}: wanted positions that a C3D file can hold, came {np.abs(values).max():.3g}")
    narrowed[~narrowed.any(axis=1), 0] = _NANOMETRE / metres
    return narrowed


def _fourth_words(
    old: NDArray[np.int16], markers: Markers, origin: Bytes, layout: Layout, metres: float
) -> NDArray[np.int16]:
    """(T, M) camera mask and residual of every marker; -1 where missing."""
    new = np.where(old < 0, 0, old)
    if markers.residuals is not None:
        steps = np.clip(np.rint(markers.residuals / metres / abs(layout.scale)), 0, 255).astype(np.int16)
        new = np.where(new & 0xFF == steps, new, (new & 0x7F00) | steps)
    new = np.where(np.isin(origin, (Origin.FILLED, Origin.REPAIRED)), 0, new)
    return np.where(markers.present, new, -1).astype(np.int16)
