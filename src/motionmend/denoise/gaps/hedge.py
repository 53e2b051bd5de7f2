"""Two ways to fill a gap in one: where the first is unsure, the second counts as far as it is sure."""

import numpy as np

from ...arrays import Floats
from ..channels.cloud import orientation_tensor
from ..rivals.filtered import Filtered
from ..rivals.marker_gaps import fill_pca

HEDGED = 0.02  # m; gaps less sure than this are filled by principal components as well, whose own deviations flatter
ALIKE = 0.5  # correlation of the errors of both


def hedged(places: Floats, std: Floats, positions: Floats) -> tuple[Floats, Floats]:
    """Where deviations are large, mix in what the principal components of the whole body say, as sure as they are.

    Parameters
    ----------
    places : (T, M, 3) m, gaps filled.
    std : (T, M) m per coordinate where filled, NaN elsewhere.
    positions : (T, M, 3) m with the gaps.

    Returns
    -------
    Places and std of the mixture, of least variance if the errors' correlation is `ALIKE`.

    Source
    ------
    Bates and Granger, The combination of forecasts, Operational Research Quarterly 20(4), 1969, equation 1.
    """
    # a gap is taken as a whole, so that nothing jumps where the deviation passes the limit
    lost = ~np.isfinite(positions).all(axis=2)
    gap = np.cumsum(np.diff(lost, axis=0, prepend=False), axis=0)
    unsure = np.zeros(std.shape, dtype=bool)
    for frame, marker in np.argwhere(lost & (np.nan_to_num(std) > HEDGED)):
        if not unsure[frame, marker]:
            unsure[:, marker] |= gap[:, marker] == gap[frame, marker]
    if not unsure.any():
        return places, std
    # its components depend on the axes: these turn with the recording
    axes = np.linalg.eigh(orientation_tensor(positions))[1]
    other = fill_pca(positions @ axes, unsure)
    rows = np.nonzero(unsure & other.filled & np.isfinite(std) & np.isfinite(other.std))
    one, two = std[rows], other.std[rows]
    share = _share_of_second(one, two)
    mixed, doubt = places.copy(), std.copy()
    mixed[rows] += share[:, None] * (other.values[rows] @ axes.T - places[rows])
    common = ALIKE * one * two
    doubt[rows] = np.sqrt(((1.0 - share) * one) ** 2 + (share * two) ** 2 + 2.0 * share * (1.0 - share) * common)
    return mixed, doubt


def filled_both_ways(taught: Filtered, alone: Filtered) -> Filtered:
    """Gaps as a library that may not know the motion fills them and as the recording alone does, in one.

    Both start from the same samples and may err alike: the mixture is no surer than they are.

    Parameters
    ----------
    taught : the library's, markers (T, M, 3) m; it says where anything is filled.
    alone : of the same markers, of which the recording alone may leave more open.

    Returns
    -------
    What only the library fills stays as it is; the rest of least variance, as in `hedged`.

    Source
    ------
    Bates and Granger, The combination of forecasts, Operational Research Quarterly 20(4), 1969, equation 1.
    """
    rows = np.nonzero(taught.filled & alone.filled & np.isfinite(taught.std) & np.isfinite(alone.std))
    one, two = taught.std[rows], alone.std[rows]
    share = _share_of_second(one, two)
    values, std = taught.values.copy(), taught.std.copy()
    values[rows] += share[:, None] * (alone.values[rows] - values[rows])
    std[rows] = np.sqrt((1.0 - share) * np.square(one) + share * np.square(two))
    return Filtered(values, std, taught.filled)


def _share_of_second(one: Floats, two: Floats) -> Floats:
    """How much of the second of two fillings to take by their deviations, for the least variance."""
    common = ALIKE * one * two
    return np.clip((one**2 - common) / np.maximum(one**2 + two**2 - 2.0 * common, 1e-12), 0.0, 1.0)
