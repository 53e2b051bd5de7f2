"""The rigid motion that brings one cloud of points onto another."""

import numpy as np

from ..arrays import Floats
from ..errors import MismatchError


def rigid_fit(source: Floats, target: Floats, weights: Floats | None = None) -> tuple[Floats, Floats]:
    """Rotation R (3, 3) and translation t (3,) that minimise the weighted sum of |R s + t - g|², never a mirroring.

    Kabsch 1976, doi:10.1107/S0567739476001873; sign of the determinant after Umeyama 1991, doi:10.1109/34.88573.

    Parameters
    ----------
    source, target : (N, 3) m; rows with a NaN in either do not count.
    weights : (N,) >= 0; all alike when None.

    Raises
    ------
    MismatchError : fewer than three points in common.
    """
    there = np.isfinite(source).all(axis=1) & np.isfinite(target).all(axis=1)
    weight: Floats = np.where(there, 1.0 if weights is None else weights, 0.0)
    if int((weight > 0).sum()) < 3:
        raise MismatchError(f"a rigid fit needs three points in common, came {int((weight > 0).sum())}")
    one, other, share = source[there], target[there], (weight / weight.sum())[there]
    middle, wanted = np.asarray(share @ one), np.asarray(share @ other)
    left, _, right = np.linalg.svd(((one - middle) * share[:, None]).T @ (other - wanted))
    sign = np.array([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    rotation = (left * sign @ right).T
    return rotation, wanted - rotation @ middle
