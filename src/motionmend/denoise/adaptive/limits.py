"""Joint-angle limits (section 2.4): what a repair makes up stays within what the joint can do."""

from dataclasses import dataclass, replace

import numpy as np

from ...arrays import Bools, Bytes, Floats, Ints, Singles
from ...bodies.motion import Motion, Origin, Repaired
from ...bodies.skeleton import ROTATION
from ...errors import few
from ..bases.repair import ChannelRepair
from ..channels.branches import nearest_turn
from ..channels.joints import DEGREES, root_rows

BROKEN = 0.02  # of the measured samples beyond a limit: it is the limit that is wrong
SURELY = 2.0  # deviations beyond a limit that count as beyond
ROUNDED = 1.0  # degrees; limits are written in whole ones
BEYOND_SEEN = 0.25  # of a library's range of an angle that others may go further
BEYOND_SEEN_LEAST = 5.0  # degrees


@dataclass(frozen=True, eq=False)
class Inside:
    """A channel held within limits.

    Attributes
    ----------
    frames, values : (N,) of the samples that were brought inside, and where to.
    broken : share of the measured samples that lie beyond a limit, of a channel left alone because of it; else 0.
    """

    frames: Ints
    values: Floats
    broken: float


def brought_inside(values: Floats, std: Floats | Singles, origin: Bytes, limits: Floats, made_up: Bools) -> Inside:
    """Bring samples of a channel that a repair made up to the nearest value within limits.

    What was measured and believed is never moved: it widens the limits to what the joint has surely been seen to do,
    and where it often lies beyond them, by more than it is unsure, the limits are wrong and the channel is left alone.

    Parameters
    ----------
    values, std : (T,) degrees, NaN = left open.
    origin : (T,) of `Origin`.
    limits : (2,) degrees, infinite where there is none.
    made_up : (T,) samples that may be moved.

    Returns
    -------
    Angles keep their whole turns.
    """
    low, high = limits
    middle = 0.5 * (low + high) if np.isfinite(limits).all() else np.nan
    turned = nearest_turn(values, np.broadcast_to(middle, values.shape))
    measured = (origin == Origin.MEASURED) & np.isfinite(turned)
    believed, doubt = turned[measured], SURELY * np.nan_to_num(std[measured].astype(np.float64))
    excess = np.maximum(low - believed, believed - high)
    share = float((excess > ROUNDED + doubt).sum()) / max(len(believed), 1)
    if share > BROKEN:
        return Inside(np.empty(0, dtype=np.int64), np.empty(0), share)
    low = min(low, (believed + doubt).min(initial=np.inf))
    high = max(high, (believed - doubt).max(initial=-np.inf))
    held = np.clip(turned, low, high)
    frames = np.flatnonzero(made_up & (held != turned) & np.isfinite(turned))
    return Inside(frames, values[frames] + held[frames] - turned[frames], 0.0)


def within_body_limits(outcome: Repaired[Motion], seen: Floats | None = None) -> Repaired[Motion]:
    """Hold repaired and filled joint angles within the skeleton's limits, and say so.

    Deviations stay as they were: a value at its limit is no further from a truth within than the value beyond it was.
    A skeleton without limits changes nothing.

    Parameters
    ----------
    outcome : of a repair.
    seen : (D, 2) degrees, between which the clips of a library lie, NaN = not known. Clean clips go beyond the limits
        that files state often enough; where they do, the limits are wrong.
    """
    motion = outcome.recording
    skeleton = motion.skeleton
    limits = np.where((skeleton.dof_kind == ROTATION)[:, None], skeleton.limits * DEGREES, [-np.inf, np.inf])
    limits[np.concatenate(root_rows(skeleton))] = -np.inf, np.inf
    if seen is not None:
        limits = np.stack([np.fmin(limits[:, 0], seen[:, 0]), np.fmax(limits[:, 1], seen[:, 1])], axis=1)
    q, hit, moved, broken = motion.q, list[str](), 0, dict[str, float]()
    for d in np.flatnonzero(np.isfinite(limits).any(axis=1)):
        origin = outcome.origin[:, d]
        made_up = (origin == Origin.REPAIRED) | (origin == Origin.FILLED)
        inside = brought_inside(motion.q[:, d] * DEGREES, outcome.std[:, d] * DEGREES, origin, limits[d], made_up)
        if inside.broken:
            broken[skeleton.dof_names[d]] = inside.broken
        if len(inside.frames):
            q = motion.q.copy() if q is motion.q else q
            q[inside.frames, d] = inside.values / DEGREES
            hit.append(skeleton.dof_names[d])
            moved += len(inside.frames)
    said = list(outcome.warnings)
    if hit:
        said.append(
            f"{moved} repaired or filled samples lay outside the skeleton's limits and were brought inside: {few(hit)}"
        )
    if broken:
        worst = [f"{name} in {share:.0%}" for name, share in sorted(broken.items(), key=lambda one: -one[1])]
        said.append(f"limits that the recording itself breaks were left alone: {few(worst)} of the frames measured")
    return replace(outcome, recording=motion.with_q(q), warnings=tuple(said)) if hit or broken else outcome


def seen_between(exemplars: Singles, angular: Bools) -> Floats:
    """(C, 2) degrees between which windows (N, M, C) of clean clips lie; NaN where not `angular` (C,), or no clips."""
    found = np.full((exemplars.shape[2], 2), np.nan)
    if exemplars.shape[0]:
        found[angular, 0] = exemplars.min(axis=(0, 1))[angular]
        found[angular, 1] = exemplars.max(axis=(0, 1))[angular]
    return found


def within_seen(found: ChannelRepair, seen: Floats) -> ChannelRepair:
    """Hold filled angles within what the clips of a library do, and a margin.

    Parameters
    ----------
    found : (T, C) degrees.
    seen : (C, 2) degrees, of `seen_between`.
    """
    low, high = seen.T
    margin = np.maximum(BEYOND_SEEN * (high - low), BEYOND_SEEN_LEAST)
    limits = np.stack([low - margin, high + margin], axis=1)
    held = limits[:, 1] - limits[:, 0] < 360.0  # not where nothing is known
    limits = np.where(held[:, None], limits, [-np.inf, np.inf])
    values = found.values
    for c in np.flatnonzero(np.isfinite(limits).any(axis=1)):
        origin = found.origin[:, c]
        inside = brought_inside(found.values[:, c], found.std[:, c], origin, limits[c], origin == Origin.FILLED)
        if len(inside.frames):
            values = found.values.copy() if values is found.values else values
            values[inside.frames, c] = inside.values
    return found if values is found.values else replace(found, values=values)
