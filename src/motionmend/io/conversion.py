"""What a recording's file says that another format has no place for, and by which number its frames are counted."""

import struct

import numpy as np

from ..bodies.motion import Markers, Motion
from ..bodies.postures import Postures
from ..errors import counted
from .amc import AmcSource
from .c3d import C3dSource
from .c3d_chain import GROUP
from .c3d_layout import Layout
from .qualisys import QualisysSource
from .table import TableSource, uneven_times
from .trc import TrcSource

_EVENTS_AT, _EVENTS_KEY = 298, 12_345  # of a C3D's header, in bytes; the number of events follows
_TOLD = {"POINT", "ANALOG", "FORCE_PLATFORM", "EVENT", "EVENT_CONTEXT", "TRIAL", "MOTIONMEND"}  # groups told by content


def not_in(ending: str, recording: Motion | Markers | Postures) -> tuple[str, ...]:
    """A sentence about what the file of a recording has and one of another format will not; none where nothing is lost.

    Parameters
    ----------
    ending : of the file to be, lower case with the dot.
    recording : as it was read, or repaired.
    """
    lost: tuple[str, ...] = ()
    source = recording.source
    if isinstance(recording, Postures):
        lost = _beside(recording) if ending != ".csv" else ()
    elif isinstance(source, C3dSource) and ending != ".c3d":
        lost = _of_c3d(source, recording)
    elif isinstance(source, TableSource) and ending != ".csv" and source.beside is not None:
        lost = _beside(source.beside)
    elif isinstance(source, QualisysSource) and ending != ".tsv":
        events = sum(line.upper().startswith("EVENT") for line in source.head)
        lost = (counted(events, "event"),) if events else ()
    elif isinstance(source, AmcSource) and ending != ".amc":
        assert isinstance(recording, Motion)
        lost = ("joint limits",) if np.isfinite(recording.skeleton.limits).any() else ()
        lost += ("comments",) if source.comments else ()
    return (f"a {ending} has no place for all that the file says, and lacks {', '.join(lost)}",) if lost else ()


def first_frame(recording: Motion | Markers) -> int | None:
    """The number that the file gives its first frame; None where it gives none, or counts from 0 or 1."""
    source = recording.source
    number: float | None = None
    if isinstance(source, C3dSource):
        number = source.layout.first_frame
    elif isinstance(source, TrcSource):
        number = source.first_frame
    elif isinstance(source, QualisysSource) and source.numbered is not None:
        number = source.numbered[0]
    elif isinstance(source, AmcSource) and len(source.numbers):
        number = int(source.numbers[0])
    return None if number is None or number in (0, 1) else int(number)


def _beside(table: Postures) -> tuple[str, ...]:
    """What a table of joints has beside their positions."""
    kinds = (("deviations", table.std), ("reliabilities", table.reliability), ("states", table.state))
    found = tuple(words for words, values in kinds if values is not None)
    return (*found, *(("times as they are",) if uneven_times(table.times) else ()))


def _of_c3d(source: C3dSource, recording: Motion | Markers) -> tuple[str, ...]:
    layout = source.layout
    events = max(int(layout.number("EVENT", "USED")), _header_events(source.raw, layout))
    analog = max(int(layout.number("ANALOG", "USED")), int(layout.analogs > 0))
    found = [
        counted(number, what)
        for number, what in (
            (events, "event"),
            (analog, "analog channel"),
            (int(layout.number("FORCE_PLATFORM", "USED")), "force plate"),
        )
        if number
    ]
    others = layout.points - len(source.markers)
    if others:
        found.append(f"{counted(others, 'point')} that are no markers (computed, or without a label)")
    residuals = recording.residuals if isinstance(recording, Markers) else None
    if residuals is not None and (residuals > 0).any():
        found.append("residuals")
    groups = sorted({r.name.strip().upper() for r in layout.records if r.kind == GROUP} - _TOLD)
    if groups:
        found.append(f"parameters of {', '.join(groups)}")
    return tuple(found)


def _header_events(raw: bytes, layout: Layout) -> int:
    key, number = struct.unpack_from(layout.order + "2H", raw, _EVENTS_AT)
    return int(number) if key == _EVENTS_KEY else 0
