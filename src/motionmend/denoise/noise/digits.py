"""Recordings that were rounded: how coarse their digits are, and what that leaves open."""

from collections.abc import Callable

import numpy as np

from ...arrays import Floats, Ints
from ...bodies.motion import Markers, Motion
from ..channels.joints import CENTIMETRES, root_rows, unit
from ..channels.pieces import pieces

FINEST = 1e-6  # of a channel's range; steps no larger are as good as none
OFF = 0.05  # of a step, by which a difference may miss a whole number of them: single precision is as coarse
NEAR = 50  # steps; longer differences are too uncertain a number of them
ENOUGH = 4  # differences that are whole numbers of one step hardly by chance
SEARCHED = 40  # steps, each smaller than the one before
ASKED = 4096  # samples of a channel
LONGEST = 0.5  # s, of a run; in longer ones a body may have moved within the step
ALIKE = 1.0 / 3.0  # power of a run's length by which its samples tell less
TELLING = 0.035  # degrees or cm; what a step leaves open is then below any noise that is looked for


def coarseness(recording: Motion | Markers) -> Floats:
    """Step to which each channel was rounded, 0 = none; (D,) degrees and cm, or (M, 3) cm."""
    some = slice(None, None, max(1, recording.frames // ASKED))
    if isinstance(recording, Motion):
        scale = unit(recording.skeleton)
        kinds = np.asarray(recording.skeleton.dof_kind)
        found = np.zeros(len(scale))
        for kind in np.unique(kinds):
            rows = np.flatnonzero(kinds == kind)
            found[rows] = _alike([recording.q[some, row] * scale[row] for row in rows])
        return found
    columns = recording.positions[some].reshape(-1, 3 * len(recording.names)).T
    return _alike([CENTIMETRES * column for column in columns]).reshape(-1, 3)


def _alike(columns: list[Floats]) -> Floats:
    """(N,) steps of channels that one device wrote: those that tell too little take what fits all the others."""
    apart = [_differences(column) for column in columns]
    own = np.array([_step(one) if len(one) >= ENOUGH else np.nan for one in apart])
    told = own[np.isfinite(own)]
    if not len(told) or not (told > 0).any():
        return np.zeros(len(columns))
    usual = float(np.median(told))
    return np.array(
        [
            usual if usual > 0 and _whole(one, usual) else (0.0 if np.isnan(step) else step)
            for one, step in zip(apart, own, strict=True)
        ]
    )


def _differences(column: Floats) -> Floats:
    """Distances between neighbours among the values that occur."""
    values = np.sort(column[np.isfinite(column)])
    apart = values[1:] - values[:-1]
    return apart[apart > FINEST * max(values[-1] - values[0], 1.0)] if len(values) else apart


def _step(apart: Floats) -> float:
    """Greatest step of which all differences are whole numbers, 0 = none."""
    step, least = float(apart.min()), 10.0 * FINEST
    for _ in range(SEARCHED):
        if step < least:
            return 0.0
        step = float(apart[apart < 1.5 * step].mean()) if (apart < 1.5 * step).any() else step
        near = apart[apart < NEAR * step]
        if len(near) < max(ENOUGH, len(apart) // 2):
            return 0.0
        if _whole(apart, step):
            return step
        off = np.abs(near - step * np.rint(near / step))
        step = float(off[off > OFF * step].min())
    return 0.0


def _whole(apart: Floats, step: float) -> bool:
    near = apart[apart < NEAR * step]
    return bool((np.abs(near - step * np.rint(near / step)) <= OFF * step).all())


def rounding(recording: Motion | Markers, columns: Ints) -> Callable[[slice], Floats] | None:
    """Of some frames the variance (N, C) of what rounding took from each sample, as the layout's channels have it.

    What is rounded lies anywhere within a step. Samples that repeat are wrong by the same amount, so each of a run
    tells less; not as much less as if a run were one sample, for where it ends the motion is known within a frame.

    Parameters
    ----------
    recording : as it was read.
    columns : (N,) for each name of the layout the recording's channel or marker, -1 where it has none.

    Returns
    -------
    None for a recording that was rounded so finely that nobody could tell.
    """
    step = coarseness(recording)
    if step.max(initial=0.0) <= TELLING:
        return None
    here = np.flatnonzero(columns >= 0)

    def of(frames: slice) -> Floats:
        several = 3 if isinstance(recording, Markers) else 1
        values = recording.positions if isinstance(recording, Markers) else recording.q
        values = values[frames].reshape(-1, step.size)
        runs = np.minimum(run_lengths(values), max(1.0, LONGEST * recording.fps))
        found = np.square(step).ravel() / 12.0 * runs**ALIKE
        if isinstance(recording, Motion):
            for rows in root_rows(recording.skeleton):
                found[:, rows] = found[:, rows].sum(axis=1, keepdims=True) / max(len(rows), 1)
        else:
            found = found.reshape(-1, *step.shape).mean(axis=2)
        spread = np.zeros((len(found), len(columns)))
        spread[:, here] = found[:, columns[here]]
        return spread.repeat(several, axis=1)

    return of


def shaken(values: Floats, rounded: Callable[[slice], Floats]) -> Floats:
    """(T, C) channels with as much added at random as rounding took: a run of equal samples is no perfect stillness.

    Parameters
    ----------
    values : (T, C) degrees and cm, NaN = missing.
    rounded : of `rounding`.
    """
    noise, shaken = np.random.default_rng(0), values.copy()  # the same for the same recording
    for some in pieces(len(values)):
        shaken[some] += np.sqrt(rounded(some)) * noise.standard_normal(shaken[some].shape)
    return shaken


def run_lengths(values: Floats) -> Floats:
    """(T, N) how many equal samples on end each sample of the columns (T, N) is one of; a missing one stands alone."""
    lengths = np.empty(values.shape)
    for c in range(values.shape[1]):
        starts = np.flatnonzero(np.concatenate([[True], values[1:, c] != values[:-1, c]]))
        counts = np.diff(np.append(starts, len(values)))
        lengths[:, c] = counts.repeat(counts)
    return lengths
