"""From repaired channels to a repaired recording that says where each sample comes from."""

from dataclasses import replace

import numpy as np

from ..arrays import Bools, Bytes, Floats, Ints, Singles, runs
from ..bodies.motion import Markers, Motion, Origin, Recording, Repaired
from ..bodies.skeleton import ROTATION
from ..errors import counted
from ..numerics.robust import ESTIMATORS
from .bases.certainty import TRUSTED
from .bases.optimise import SCALE
from .bases.repair import ChannelRepair
from .channels.joints import joint_rotation, root_rows, unit
from .channels.layout import Layout
from .channels.pieces import pieces
from .channels.recording import Channels, from_channels, si_unit
from .rivals.filtered import Filtered
from .too_short import GUESS, GUESS_PLACE

OFF, NEAR, STEP = np.radians([60.0, 8.0, 30.0])  # of a root: turned far, hardly, and as no frame to the next is
AS_RECORDED = np.radians(1.0)  # deviation of a root that is left as it was, at least
LEFT_OPEN = "left open: nothing near supports a value"


def repaired_recording(
    recording: Recording,
    layout: Layout,
    channels: Channels,
    found: ChannelRepair,
    method: str,
    noise: Floats | None = None,
    values: Floats | None = None,
) -> Repaired[Recording]:
    """Bring a channel repair, and the noise (C,) it found, back into the recording's own channels, frames and units.

    Its values may have been `brought_back` already.
    """
    values = brought_back(recording, channels, found) if values is None else values
    scale = si_unit(recording, layout, channels.columns)
    origin, std, weights = _own_columns(recording, layout, channels, found, scale)
    warnings = list(found.warnings)
    if isinstance(recording, Motion):
        warnings += _root_as_recorded(recording, values, std, weights)
        _judge_root(recording, values, origin)
        warnings += _root_never_leapt(recording, values, origin, std, weights)
    warnings += left_open(origin)
    unknown = np.setdiff1d(np.arange(len(recording.channels)), channels.columns)
    if len(unknown):
        warnings.append(left_as_recorded(recording, unknown))
    lacking = [n for n, c in zip(layout.names, channels.columns, strict=True) if c < 0]
    if lacking:
        warnings.append(f"the recording lacks {', '.join(lacking[:6])}{', ...' if len(lacking) > 6 else ''}")
    return Repaired(
        recording=recording.with_values(values),
        origin=origin,
        std=std,
        weights=weights,
        method=method,
        iterations=found.iterations,
        cost=found.cost,
        converged=found.converged,
        warnings=tuple(warnings),
        noise=None if noise is None else _own_noise(recording, layout, channels, noise * scale),
    )


def brought_back(recording: Motion | Markers, channels: Channels, found: ChannelRepair) -> Floats:
    """The values of a channel repair in the recording's own channels: (T, D) rad and m, or (T, M, 3) m."""
    return from_channels(channels, found.values, found.weights >= TRUSTED, recording)


def not_known(recording: Motion | Markers, unknown: Ints, done: str) -> str:
    """The sentence that names the channels or markers that no clip has taught, and what was done to them."""
    names = [recording.channels[c] for c in unknown]
    return f"the model does not know {', '.join(names[:6])}{', ...' if len(names) > 6 else ''}: {done}"


def left_as_recorded(recording: Motion | Markers, unknown: Ints) -> str:
    """That of a method that does nothing to them."""
    return not_known(recording, unknown, "left as recorded")


def left_open(origin: Bytes) -> tuple[str, ...]:
    """The sentence that says how many samples (T, C) were left open; none where none was."""
    left = int((origin == Origin.LEFT_OPEN).sum())
    which = "1 missing sample was" if left == 1 else f"{left} missing samples were"
    return (f"{which} {LEFT_OPEN}",) if left else ()


def classic_outcome(
    recording: Recording, layout: Layout, channels: Channels, filtered: Filtered, method: str
) -> Repaired[Recording]:
    """A filter's or gap filler's channels as a repaired recording; measured samples that did not change stay exact."""
    present = np.isfinite(channels.values)
    origin = np.empty(present.shape, dtype=np.uint8)
    same = True
    for some in pieces(len(present)):
        here, values = present[some], filtered.values[some]
        gap = np.where(np.isfinite(values), Origin.FILLED, Origin.LEFT_OPEN)
        origin[some] = np.where(here, Origin.MEASURED, gap)
        same = same and np.array_equal(values[here], channels.values[some][here])
    found = ChannelRepair(filtered.values, filtered.std, present, origin, 0, np.empty(0), True)
    outcome = repaired_recording(recording, layout, channels, found, method)
    if not same:
        return outcome
    values = outcome.recording.values.copy()
    for some in pieces(recording.frames):
        here = _present(recording, some)
        values[some][here] = recording.values[some][here]
    return replace(outcome, recording=recording.with_values(values))


def pca_outcome(markers: Markers) -> Repaired[Markers]:
    """Markers filled from their own intercorrelations (Gloersen and Federolf 2016)."""
    from .rivals.marker_gaps import fill_pca

    filtered = fill_pca(markers.positions)
    present = markers.present
    positions = filtered.values.reshape(markers.positions.shape)
    open_ = ~np.isfinite(positions).all(axis=2)
    origin = np.where(present, Origin.MEASURED, np.where(open_, Origin.LEFT_OPEN, Origin.FILLED))
    return Repaired(
        recording=markers.with_positions(positions),
        origin=origin.astype(np.uint8),
        std=filtered.std.astype(np.float32),
        weights=present.astype(np.float32),
        method="pca",
        warnings=left_open(origin),
    )


def opened_where_unsure(
    outcome: Repaired[Recording], max_std: float | Floats, limit: str = "the limit"
) -> Repaired[Recording]:
    """Leave filled samples open whose standard deviation exceeds a limit, and say which gaps they were.

    Parameters
    ----------
    max_std : of all samples, or of each, (T, C) or what becomes that by broadcasting; rad for the angles of motions
        (their translations stay), m for markers.
    limit : what it is called.
    """
    recording = outcome.recording
    unsure = (outcome.origin == Origin.FILLED) & (outcome.std > max_std)
    if isinstance(recording, Motion):
        unsure &= recording.skeleton.dof_kind == ROTATION
    if not unsure.any():
        return outcome
    values, origin, std = recording.values.copy(), outcome.origin.copy(), outcome.std.copy()
    values[unsure], origin[unsure], std[unsure] = np.nan, Origin.LEFT_OPEN, np.nan
    hit = unsure.any(axis=0)
    names = [name for name, here in zip(recording.channels, hit, strict=True) if here]
    said = (
        f"{int(unsure.sum())} filled samples were left open again, their deviation being above {limit}: "
        f"{', '.join(names[:6])}{', ...' if len(names) > 6 else ''}"
    )
    return replace(
        outcome,
        recording=recording.with_values(values),
        origin=origin,
        std=std,
        warnings=(*outcome.warnings, said),
    )


def _own_columns(
    recording: Motion | Markers, layout: Layout, channels: Channels, found: ChannelRepair, scale: Floats
) -> tuple[Bytes, Singles, Singles]:
    """Origin, std (rad or m) and weights (T, D or M) in the recording's own channel order."""
    shape = recording.frames, len(recording.channels)
    origin, std, weights = np.empty(shape, np.uint8), np.full(shape, np.nan, np.float32), np.empty(shape, np.float32)
    here = np.flatnonzero(channels.columns >= 0)
    to = channels.columns[here]
    for some in pieces(recording.frames):
        present = _present(recording, some)
        origin[some] = np.where(present, Origin.MEASURED, Origin.LEFT_OPEN)
        weights[some] = present
        kind, spread, weight = found.origin[some], found.std[some] * scale, found.weights[some]
        if isinstance(recording, Markers):
            by_marker = (len(present), len(layout.names), 3)
            # a marker is repaired, filled or open when any of its coordinates is: the codes rise in that order
            kind, weight = kind.reshape(by_marker).max(axis=2), weight.reshape(by_marker).min(axis=2)
            spread = np.sqrt(np.square(spread.reshape(by_marker)).mean(axis=2))
        origin[some, to], std[some, to], weights[some, to] = kind[:, here], spread[:, here], weight[:, here]
    return origin, std, weights


def _own_noise(recording: Motion | Markers, layout: Layout, channels: Channels, noise: Floats) -> Floats:
    """(D,) or (M,): noise of the layout's channels, rad or m, in the recording's own order; NaN where unknown."""
    own = np.full(len(recording.channels), np.nan)
    here = np.flatnonzero(channels.columns >= 0)
    if isinstance(recording, Markers):
        noise = np.sqrt(np.square(noise.reshape(len(layout.names), 3)).mean(axis=1))
    own[channels.columns[here]] = noise[here]
    return own


def _root_as_recorded(motion: Motion, values: Floats, std: Singles, weights: Singles) -> list[str]:
    """Give the root's own samples back, in place, where its others are unknown; says of which none is known ever.

    Place and orientation are channels of their own as a whole: a frame that lacks one of the three has none of them.
    Where no frame has all, nothing tells where the body is, or where it faces, and what is missing of it stays open.
    """
    said: list[str] = []
    turns, moves = root_rows(motion.skeleton)
    for rows, guess in ((turns, GUESS), (moves, GUESS_PLACE)):
        present = np.isfinite(motion.q[:, rows])
        lost = present & ~np.isfinite(values[:, rows])
        if len(rows) and not present.all(axis=1).any():
            lost[:] = True
            names = ", ".join(motion.channels[row] for row in rows)
            said.append(f"no frame has all of {names}: of these what was measured is kept, the rest left open")
        for row, back, there in zip(rows, lost.T, present.T, strict=True):
            values[back, row] = motion.q[back, row]
            std[back, row] = np.where(there[back], guess, np.nan)
            weights[back, row] = there[back]
    return said


def _root_never_leapt(motion: Motion, values: Floats, origin: Bytes, std: Singles, weights: Singles) -> list[str]:
    """Give the root's orientation back, in place, where it was turned far though as recorded it never leapt; says so.

    Upside down a body has no heading, and its turn in the travelling frame leaps where the body does not.
    """
    turns, _ = root_rows(motion.skeleton)
    if len(turns) != 3:
        return []
    asked = np.isfinite(motion.q[:, turns]).all(axis=1) & np.isfinite(values[:, turns]).all(axis=1)
    if not (np.abs(values[asked][:, turns] - motion.q[asked][:, turns]) > OFF).any():
        return []
    recorded = joint_rotation(motion.skeleton, turns, motion.q)
    off = _apart(recorded, joint_rotation(motion.skeleton, turns, values))
    steps = _apart(recorded[1:], recorded[:-1])
    turned = np.zeros(len(off), dtype=np.bool_)
    for start, stop in runs(off > OFF):
        while start > 0 and off[start - 1] > NEAR:
            start -= 1
        while stop < len(off) and off[stop] > NEAR:
            stop += 1
        # what leapt away did so where it begins or ends
        whole = stop - start == len(off)
        turned[start:stop] = not whole and bool((steps[max(start - 1, 0) : stop] < STEP).all())
    if not turned.any():
        return []
    about = std[np.ix_(~turned, turns)]
    least = float(np.nanmedian(about)) if np.isfinite(about).any() else GUESS
    rows = np.ix_(turned, turns)
    values[rows], origin[rows], weights[rows] = motion.q[rows], Origin.MEASURED, 1.0
    std[rows] = max(least, AS_RECORDED)
    return [
        f"the root's orientation in {counted(int(turned.sum()), 'frame')} is as recorded: it never leapt there, as it "
        "would have to if it was wrong"
    ]


def _apart(one: Floats, other: Floats) -> Floats:
    """(T,) rad between rotations (T, 3, 3); 0 where one is missing."""
    trace = np.einsum("tij,tij->t", np.nan_to_num(one), np.nan_to_num(other))
    known = np.isfinite(one).all(axis=(1, 2)) & np.isfinite(other).all(axis=(1, 2))
    return np.where(known, np.arccos(np.clip(0.5 * (trace - 1.0), -1.0, 1.0)), 0.0)


def _judge_root(motion: Motion, values: Floats, origin: Bytes) -> None:
    """Set the origin of the root's own channels by how far they moved: in the travelling frame they are mixed."""
    skeleton = motion.skeleton
    for rows in root_rows(skeleton):
        spoilt = (origin[:, rows] != Origin.MEASURED).any(axis=1)  # of the one orientation, or place, that they make
        for row in rows:
            present: Bools = np.isfinite(motion.q[:, row])
            moved = np.abs(values[:, row] - motion.q[:, row]) * unit(skeleton)[row]
            far = ESTIMATORS["welsch"].weight(np.nan_to_num(moved), SCALE) < TRUSTED
            kept = np.where(far & spoilt, Origin.REPAIRED, Origin.MEASURED)
            open_ = np.where(np.isfinite(values[:, row]), Origin.FILLED, Origin.LEFT_OPEN)
            origin[:, row] = np.where(present, kept, open_)


def _present(recording: Motion | Markers, frames: slice) -> Bools:
    """(N, C) True where a sample of these frames was recorded."""
    if isinstance(recording, Motion):
        return np.isfinite(recording.q[frames])
    return np.asarray(np.isfinite(recording.positions[frames]).all(axis=2))
