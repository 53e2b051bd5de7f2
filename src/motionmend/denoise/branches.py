"""Which of the angles that mean the same rotation are meant: whole turns, and the twins of three angles."""

import numpy as np

from ..arrays import Bools, Floats

FLIP = 200.0  # degrees, of three angles together: two branches lie 360 apart, so that shorter steps change none
HOLD = 1.0  # s after which it counts as much to be far from the centre as it counts once to step so far
_TURNS = np.array([(a, 0.0, c) for a in (-360.0, 0.0, 360.0) for c in (-360.0, 0.0, 360.0)])


def nearest_turn(angles: Floats, meant: Floats) -> Floats:
    """`angles` in degrees, each shifted by whole turns to be nearest `meant`; NaN in `meant` shifts nothing."""
    shift = 360.0 * np.round((angles - meant) / 360.0)
    return angles - np.where(np.isfinite(shift), shift, 0.0)


def nearest_triple(angles: Floats, meant: Floats, counted: Bools | None = None) -> Floats:
    """Of the triples of degrees (T, 3) that mean the same rotation, the one nearest `meant` (3,) or (T, 3).

    Rotations by (a, b, c) and (a + 180, 180 - b, c + 180) about axes at right angles are the same. Which of the two is
    nearer is judged by the angles that are `counted` (T, 3), None = all.
    """
    first, second = nearest_turn(angles, meant), nearest_turn(_twin(angles), meant)
    share = 1.0 if counted is None else counted.astype(float)
    away = (share * np.abs(second - meant)).sum(axis=1) < (share * np.abs(first - meant)).sum(axis=1)
    return np.where(away[:, None], second, first)


def steady_triple(angles: Floats, centre: Floats, fps: float) -> Floats:
    """Of the triples that mean the same rotations, those that stay about a centre without flipping to and fro.

    Where a motion passes between two branches the nearest one would change from frame to frame with the noise. The
    path of least steps is taken, each frame's distance beyond that of the nearest branch added over `HOLD` seconds.

    Parameters
    ----------
    angles : (T, 3) degrees, NaN = missing.
    centre : (3,) degrees.
    fps : Hz.

    Returns
    -------
    (T, 3) degrees; the nearest triples where these never flip.

    Source
    ------
    The path: Viterbi, IEEE Transactions on Information Theory 13(2), 1967.
    """
    nearest = nearest_triple(angles, centre)
    known = np.flatnonzero(np.isfinite(nearest).all(axis=1))
    whole = nearest[known]
    if len(whole) < 2 or np.abs(np.diff(whole, axis=0)).sum(axis=1).max() < FLIP:
        return nearest
    from ..kernels.branches import steadiest

    both = np.stack([whole, nearest_turn(_twin(whole), centre)], axis=1)
    chosen = steadiest(both, _TURNS, np.ascontiguousarray(centre), HOLD * fps)
    steady = nearest.copy()
    steady[known] = both[np.arange(len(whole)), chosen // len(_TURNS)] + _TURNS[chosen % len(_TURNS)]
    partly = np.flatnonzero(~np.isfinite(nearest).all(axis=1))
    meant = np.stack([np.interp(partly, known, steady[known, i]) for i in range(3)], axis=1)
    steady[partly] = nearest_triple(nearest[partly], meant)
    return steady


def _twin(angles: Floats) -> Floats:
    return np.stack([angles[:, 0] + 180.0, 180.0 - angles[:, 1], angles[:, 2] + 180.0], axis=1)
