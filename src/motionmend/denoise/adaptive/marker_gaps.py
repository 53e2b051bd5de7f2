"""Gaps of markers in a repair of their channels, taken from the markers about them."""

from dataclasses import replace

import numpy as np

from ...bodies.motion import Markers, Origin, Repaired
from ..channels.cloud import in_metres
from ..channels.joints import CENTIMETRES
from ..channels.layout import Layout, names_of
from ..gaps.hedge import filled_both_ways
from ..gaps.markers import fill_gaps
from ..library.markers import MarkerLibrary
from ..outliers.bursts import long_runs, short_runs
from ..rivals.filtered import Filtered
from .blocks import Mended


def with_gaps_filled(mended: Mended, fps: float, postures: MarkerLibrary | None, beside: bool) -> Mended:
    """Gaps but the shortest, and long bursts of outliers, taken from the markers about them: what walks cannot know.

    In the travelling frame, so that a recording made elsewhere, facing elsewhere, is filled the same. A library that
    may not know the motion is believed `beside` what the recording alone tells of its gaps.
    """
    found = mended.found
    unseen = found.origin != Origin.MEASURED
    short = short_runs(unseen, fps) & (found.origin == Origin.FILLED)
    missing = (found.origin >= Origin.FILLED) & ~short
    lost = missing | long_runs(unseen, fps)
    if not lost.any():
        return mended
    frames = len(found.values)
    known = in_metres(np.where(lost, np.nan, found.values))
    filled = fill_gaps(known, fps, library=postures)
    if beside:
        filled = filled_both_ways(filled, fill_gaps(known, fps))
    three = np.isfinite(filled.values).all(axis=2).repeat(3, axis=1)
    places = np.where(three, CENTIMETRES * filled.values.reshape(frames, -1), np.nan)
    spread = np.where(three, CENTIMETRES * filled.std.repeat(3, axis=1), np.nan)
    kind = np.where(three, Origin.FILLED, Origin.LEFT_OPEN).astype(np.uint8)
    taken = missing | (lost & three)
    return replace(
        mended,
        found=replace(
            found,
            values=np.where(taken, places, found.values),
            std=np.where(taken, spread, found.std),
            origin=np.where(missing, kind, found.origin),
        ),
    )


def filled_from_all(outcome: Repaired[Markers], layout: Layout) -> Repaired[Markers]:
    """Gaps of markers that the library knows, filled beside it from all markers: the nearest may be others."""
    taught = np.isin(names_of(outcome.recording), layout.names)
    missing = outcome.origin >= Origin.FILLED
    short = short_runs(outcome.origin != Origin.MEASURED, outcome.recording.fps)
    filled = taught & (outcome.origin == Origin.FILLED) & ~short
    if taught.all() or not filled.any():
        return outcome
    markers = outcome.recording
    known = np.where(missing[..., None], np.nan, markers.positions)
    both = filled_both_ways(
        Filtered(markers.positions, outcome.std.astype(np.float64), filled), fill_gaps(known, markers.fps)
    )
    return replace(outcome, recording=markers.with_positions(both.values), std=both.std.astype(np.float32))
