"""Joint-angle limits (section 2.4): what a repair makes up stays within what the joint can do."""

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Bools, Bytes, Floats, Singles
from ..bodies.motion import Motion, Origin, Repaired
from ..bodies.skeleton import ROTATION
from .branches import nearest_turn
from .joints import DEGREES, root_rows
from .repair import ChannelRepair

BROKEN = 0.02  # of the measured samples beyond a limit: it is the limit that is wrong
SURELY = 2.0  # deviations beyond a limit that count as beyond
ROUNDED = 1.0  # degrees; limits are written in whole ones
BEYOND_SEEN = 0.25  # of a library's range of an angle that others may go further
BEYOND_SEEN_LEAST = 5.0  # degrees


@dataclass(frozen=True, eq=False)
class Inside:
    """Channels held within limits.

    Attributes
    ----------
    values : (T, C) the channels.
    moved : (T, C) True where a sample was brought inside.
    broken : (C,) share of the measured samples that lie beyond a limit, for channels left alone because of it; else 0.
    """

    values: Floats
    moved: Bools
    broken: Floats


def brought_inside(values: Floats, std: Floats, origin: Bytes, limits: Floats, made_up: Bools) -> Inside:
    """Bring samples that a repair made up to the nearest value within limits.

    What was measured and believed is never moved: it widens the limits to what the joint has surely been seen to do,
    and where it often lies beyond them, by more than it is unsure, the limits are wrong and the channel is left alone.

    Parameters
    ----------
    values, std : (T, C) degrees, NaN = left open.
    origin : (T, C) of `Origin`.
    limits : (C, 2) degrees, infinite where there is none.
    made_up : (T, C) samples that may be moved.

    Returns
    -------
    Angles keep their whole turns.
    """
    both: Bools = np.asarray(np.isfinite(limits).all(axis=1, keepdims=True))
    middle = np.where(both, np.where(both, limits, 0.0).mean(axis=1, keepdims=True), np.nan)[:, 0]
    turned = nearest_turn(values, np.broadcast_to(middle, values.shape))
    measured = (origin == Origin.MEASURED) & np.isfinite(turned)
    low, high = limits.T
    excess = np.maximum(low - turned, turned - high)
    doubt = SURELY * np.nan_to_num(std)
    surely = measured & (excess > ROUNDED + doubt)
    share = surely.sum(axis=0) / np.maximum(measured.sum(axis=0), 1)
    broken = np.where(share > BROKEN, share, 0.0)
    low = np.minimum(low, np.where(measured, turned + doubt, np.inf).min(axis=0, initial=np.inf))
    high = np.maximum(high, np.where(measured, turned - doubt, -np.inf).max(axis=0, initial=-np.inf))
    held = np.clip(turned, low, high)
    moved = made_up & (held != turned) & np.isfinite(turned) & (broken == 0.0)
    return Inside(np.where(moved, values + held - turned, values), moved, broken)


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
    made_up = (outcome.origin == Origin.REPAIRED) | (outcome.origin == Origin.FILLED)
    std = np.full(motion.q.shape, np.nan) if outcome.std is None else outcome.std * DEGREES
    inside = brought_inside(motion.q * DEGREES, std, outcome.origin, limits, made_up)
    said = list(outcome.warnings)
    hit = np.flatnonzero(inside.moved.any(axis=0))
    if len(hit):
        said.append(
            f"{int(inside.moved.sum())} repaired or filled samples lay outside the skeleton's limits and were brought "
            f"inside: {_some([skeleton.dof_names[d] for d in hit])}"
        )
    wrong = np.flatnonzero(inside.broken)
    if len(wrong):
        worst = [f"{skeleton.dof_names[d]} in {inside.broken[d]:.0%}" for d in wrong[np.argsort(-inside.broken[wrong])]]
        said.append(f"limits that the recording itself breaks were left alone: {_some(worst)} of the frames measured")
    q = np.where(inside.moved, inside.values / DEGREES, motion.q)
    return replace(outcome, recording=motion.with_q(q), warnings=tuple(said))


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
    inside = brought_inside(found.values, found.std, found.origin, limits, found.origin == Origin.FILLED)
    return replace(found, values=inside.values) if inside.moved.any() else found


def _some(names: list[str]) -> str:
    return f"{', '.join(names[:6])}{', ...' if len(names) > 6 else ''}"
