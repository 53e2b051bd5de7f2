"""From repaired channels to a repaired recording that says where each sample comes from."""

from dataclasses import replace

import numpy as np

from ..arrays import Bools, Bytes, Floats
from ..bodies.motion import Markers, Motion, Origin, Recording, Repaired
from ..bodies.skeleton import ROTATION
from ..numerics.robust import ESTIMATORS
from .certainty import TRUSTED
from .channels import Channels, from_channels, si_unit
from .filtered import Filtered
from .joints import root_rows, unit
from .layout import Layout
from .optimise import SCALE
from .repair import ChannelRepair


def repaired_recording(
    recording: Recording,
    layout: Layout,
    channels: Channels,
    found: ChannelRepair,
    method: str,
    noise: Floats | None = None,
) -> Repaired[Recording]:
    """Bring a channel repair, and the noise (C,) it found, back into the recording's own channels, frames and units."""
    trusted = found.weights >= TRUSTED
    values = from_channels(channels, found.values, trusted, recording)
    scale = si_unit(recording, layout, channels.columns)
    own = _own_columns(recording, layout, channels, found, scale)
    origin, std, weights = own
    if isinstance(recording, Motion):
        origin = _root_origin(recording, values, origin)
    warnings = list(found.warnings)
    warnings += left_open(origin)
    unknown = [n for c, n in enumerate(recording.channels) if c not in set(channels.columns.tolist())]
    if unknown:
        warnings.append(
            f"the model does not know {', '.join(unknown[:6])}{', ...' if len(unknown) > 6 else ''}: left as recorded"
        )
    lacking = [n for n, c in zip(layout.names, channels.columns, strict=True) if c < 0]
    if lacking:
        warnings.append(f"the recording lacks {', '.join(lacking[:6])}{', ...' if len(lacking) > 6 else ''}")
    return Repaired(
        recording=_with_values(recording, values),
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


def left_open(origin: Bytes) -> tuple[str, ...]:
    """The sentence that says how many samples (T, C) were left open; none where none was."""
    left = int((origin == Origin.LEFT_OPEN).sum())
    return (f"{left} missing samples were left open: nothing near them supports a value",) if left else ()


def classic_outcome(
    recording: Recording, layout: Layout, channels: Channels, filtered: Filtered, method: str
) -> Repaired[Recording]:
    """A filter's or gap filler's channels as a repaired recording; measured samples that did not change stay exact."""
    present = np.isfinite(channels.values)
    open_ = ~np.isfinite(filtered.values)
    origin = np.where(present, Origin.MEASURED, np.where(open_, Origin.LEFT_OPEN, Origin.FILLED))
    found = ChannelRepair(
        filtered.values,
        filtered.std,
        present.astype(float),
        origin.astype(np.uint8),
        0,
        np.empty(0),
        True,
    )
    outcome = repaired_recording(recording, layout, channels, found, method)
    if not np.array_equal(filtered.values[present], channels.values[present]):
        return outcome
    values = np.where(
        recording.present[..., None] if isinstance(recording, Markers) else recording.present,
        _values(recording),
        _values(outcome.recording),
    )
    return replace(outcome, recording=_with_values(recording, values))


def pca_outcome(markers: Markers) -> Repaired[Markers]:
    """Markers filled from their own intercorrelations (Gloersen and Federolf 2016)."""
    from .gaps import fill_pca

    filtered = fill_pca(markers.positions)
    present = markers.present
    positions = filtered.values.reshape(markers.positions.shape)
    open_ = ~np.isfinite(positions).all(axis=2)
    origin = np.where(present, Origin.MEASURED, np.where(open_, Origin.LEFT_OPEN, Origin.FILLED))
    return Repaired(
        recording=markers.with_positions(positions),
        origin=origin.astype(np.uint8),
        std=filtered.std,
        weights=present.astype(float),
        method="pca",
        warnings=left_open(origin),
    )


def opened_where_unsure(outcome: Repaired[Recording], max_std: float) -> Repaired[Recording]:
    """Leave filled samples open whose standard deviation exceeds a limit, and say which gaps they were.

    Parameters
    ----------
    max_std : rad for the angles of motions (their translations stay), m for markers.
    """
    recording = outcome.recording
    unsure = (outcome.origin == Origin.FILLED) & (outcome.std > max_std)
    if isinstance(recording, Motion):
        unsure &= recording.skeleton.dof_kind == ROTATION
    if not unsure.any():
        return outcome
    values = _values(recording).copy()
    values[unsure] = np.nan
    hit = unsure.any(axis=0)
    names = [name for name, here in zip(recording.channels, hit, strict=True) if here]
    said = (
        f"{int(unsure.sum())} filled samples were left open again, their deviation being above the limit: "
        f"{', '.join(names[:6])}{', ...' if len(names) > 6 else ''}"
    )
    return replace(
        outcome,
        recording=_with_values(recording, values),
        origin=np.where(unsure, Origin.LEFT_OPEN, outcome.origin).astype(np.uint8),
        std=np.where(unsure, np.nan, outcome.std),
        warnings=(*outcome.warnings, said),
    )


def _own_columns(
    recording: Motion | Markers, layout: Layout, channels: Channels, found: ChannelRepair, scale: Floats
) -> tuple[Bytes, Floats, Floats]:
    """Origin, std (rad or m) and weights (T, D or M) in the recording's own channel order."""
    present = recording.present
    origin = np.where(present, Origin.MEASURED, Origin.LEFT_OPEN).astype(np.uint8)
    std = np.full(present.shape, np.nan)
    weights = present.astype(float)
    here = np.flatnonzero(channels.columns >= 0)
    to = channels.columns[here]
    if isinstance(recording, Motion):
        origin[:, to] = found.origin[:, here]
        std[:, to] = (found.std * scale)[:, here]
        weights[:, to] = found.weights[:, here]
        return origin, std, weights
    by_marker = (len(present), len(layout.names), 3)
    # a marker is repaired, filled or open when any of its coordinates is: the codes rise in that order
    origin[:, to] = found.origin.reshape(by_marker).max(axis=2)[:, here]
    std[:, to] = np.sqrt(np.square((found.std * scale).reshape(by_marker)).mean(axis=2))[:, here]
    weights[:, to] = found.weights.reshape(by_marker).min(axis=2)[:, here]
    return origin, std, weights


def _own_noise(recording: Motion | Markers, layout: Layout, channels: Channels, noise: Floats) -> Floats:
    """(D,) or (M,): noise of the layout's channels, rad or m, in the recording's own order; NaN where unknown."""
    own = np.full(len(recording.channels), np.nan)
    here = np.flatnonzero(channels.columns >= 0)
    if isinstance(recording, Markers):
        noise = np.sqrt(np.square(noise.reshape(len(layout.names), 3)).mean(axis=1))
    own[channels.columns[here]] = noise[here]
    return own


def _root_origin(motion: Motion, values: Floats, origin: Bytes) -> Bytes:
    """Judge the root's own channels by how far they moved: in the travelling frame they are mixed."""
    skeleton = motion.skeleton
    rows = np.concatenate(root_rows(skeleton))
    if len(rows) == 0:
        return origin
    origin = origin.copy()
    present: Bools = motion.present[:, rows]
    moved = np.abs(values[:, rows] - motion.q[:, rows]) * unit(skeleton)[rows]
    far = ESTIMATORS["welsch"].weight(np.nan_to_num(moved), SCALE) < TRUSTED
    kept = np.where(far & (origin[:, rows] != Origin.MEASURED), Origin.REPAIRED, Origin.MEASURED)
    open_ = np.where(np.isfinite(values[:, rows]), Origin.FILLED, Origin.LEFT_OPEN)
    origin[:, rows] = np.where(present, kept, open_)
    return origin


def _values(recording: Motion | Markers) -> Floats:
    return recording.q if isinstance(recording, Motion) else recording.positions


def _with_values(recording: Recording, values: Floats) -> Recording:
    if isinstance(recording, Motion):
        return recording.with_q(values)
    return recording.with_positions(values)
