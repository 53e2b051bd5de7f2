"""Which of the angles that mean the same rotation are meant: whole turns, and the twins of three angles."""

import numpy as np

from ...arrays import Bools, Floats

FLIP = 200.0  # degrees, of three angles together: two branches lie 360 apart, so that shorter steps change none
HALF_TURN = 180.0  # degrees, of one angle: no longer step is the shorter way round
HOLD = 1.0  # s after which it counts as much to be far from the centre as it counts once to step so far
_WHOLE = (-360.0, 0.0, 360.0)
_TURNS = np.array([(a, 0.0, c) for a in _WHOLE for c in _WHOLE])
_TURNS_OF_ONE = np.array([(a, 0.0, 0.0) for a in _WHOLE])


def nearest_turn(angles: Floats, meant: Floats) -> Floats:
    """`angles` in degrees, each shifted by whole turns to be nearest `meant`; NaN in `meant` shifts nothing."""
    shift = 360.0 * np.round((angles - meant) / 360.0)
    return angles - np.where(np.isfinite(shift), shift, 0.0)


def steady_turn(angles: Floats, centre: float, fps: float) -> Floats:
    """`angles` (T,) degrees shifted by whole turns to stay about a centre without leaping there and back.

    What passes half a turn from the centre leaps by a whole one if each sample is taken nearest to it, and what is
    put between two such samples means neither. The path is that of `steady_triple`.

    Parameters
    ----------
    angles : (T,) degrees, NaN = missing.
    centre : degrees.
    fps : Hz.

    Returns
    -------
    (T,) degrees; the nearest turns where these never leap.
    """
    nearest = nearest_turn(angles, np.full(angles.shape, centre))
    known = np.flatnonzero(np.isfinite(nearest))
    if len(known) < 2 or np.abs(np.diff(nearest[known])).max() <= HALF_TURN:
        return nearest
    from ...kernels.branches import steadiest

    alone = np.zeros((len(known), 1, 3))
    alone[:, 0, 0] = nearest[known]
    nearest[known] += _TURNS_OF_ONE[steadiest(alone, _TURNS_OF_ONE, np.array([centre, 0.0, 0.0]), HOLD * fps), 0]
    return nearest


def nearest_triple(angles: Floats, meant: Floats, counted: Bools | None = None) -> Floats:
    """Of the triples of degrees (T, 3) that mean the same rotation, the one nearest `meant` (3,) or (T, 3).

    Rotations by (a, b, c) and (a + 180, 180 - b, c + 180) about axes at right angles are the same. Which of the two is
    nearer is judged by the angles that are `counted` (T, 3), None = all.
    """
    first, second = nearest_turn(angles, meant), nearest_turn(twin(angles), meant)
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
    from ...kernels.branches import steadiest

    both = np.stack([whole, nearest_turn(twin(whole), centre)], axis=1)
    chosen = steadiest(both, _TURNS, np.ascontiguousarray(centre), HOLD * fps)
    steady = nearest.copy()
    steady[known] = both[np.arange(len(whole)), chosen // len(_TURNS)] + _TURNS[chosen % len(_TURNS)]
    partly = np.flatnonzero(~np.isfinite(nearest).all(axis=1))
    meant = np.stack([np.interp(partly, known, steady[known, i]) for i in range(3)], axis=1)
    steady[partly] = nearest_triple(nearest[partly], meant)
    return steady


def twin(angles: Floats) -> Floats:
    """The other triples (T, 3) degrees of the same rotations about axes at right angles."""
    return np.stack([angles[:, 0] + 180.0, 180.0 - angles[:, 1], angles[:, 2] + 180.0], axis=1)
