"""How wrong a smoother is, read from the recording itself, and how two are best combined."""

import numpy as np

from ..arrays import Floats
from .walk import NORMAL_MEDIAN


def stein_risk(residual: Floats, own: Floats, noise: Floats) -> Floats:
    """Mean square error of smoothed channels, bias included, without knowing the truth.

    The residual's mean square is the noise's, less twice the noise that a smoothed sample takes over from its own
    sample, plus the whole error of the smoother. Median deviations stand for mean squares, so that a few outliers
    count as neither noise nor error.

    Parameters
    ----------
    residual : (T, C), recorded less smoothed, NaN = not recorded.
    own : (T, C), (T, 1) or (1, C), by how much a smoothed sample moves when its own recorded sample moves by 1.
    noise : (C,) or (T, C), standard deviation of the recording's white noise.

    Returns
    -------
    (C,) in the square of the channel's unit; may fall below 0 by chance where the error is small beside the noise. NaN
    where nothing was recorded or the noise is not known.

    Source
    ------
    Stein, Estimation of the mean of a multivariate normal distribution, Annals of Statistics 9(6), 1981, theorem 1.
    """
    recorded = np.isfinite(residual)
    taken = np.where(recorded, (1.0 - 2.0 * own) * np.square(noise), 0.0)
    known = recorded.any(axis=0) & np.isfinite(taken).all(axis=0)
    risk = np.full(residual.shape[1], np.nan)
    if known.any():
        spread = np.nanmedian(np.abs(residual[:, known]), axis=0) / NORMAL_MEDIAN
        risk[known] = np.square(spread) - taken[:, known].sum(axis=0) / recorded[:, known].sum(axis=0)
    return risk


def excess(risk: Floats, variance: Floats, recorded: Floats) -> Floats:
    """Mean square (C,) by which a smoother is more wrong than it says: `risk` (C,) over its own `variance` (T, C).

    `recorded` (T, C) is NaN where no sample was recorded; what is not known counts as nothing.
    """
    said = np.where(np.isfinite(recorded), np.nan_to_num(variance), 0.0).sum(axis=0)
    count = np.maximum(np.isfinite(recorded).sum(axis=0), 1)
    return np.asarray(np.maximum(np.nan_to_num(risk - said / count), 0.0))


def share_of_second(first_var: Floats, second_var: Floats, apart: Floats) -> Floats:
    """How much of the second of two estimates of the same to take, the rest of the first, for the least variance.

    Parameters
    ----------
    first_var, second_var : (C,) variances of their errors.
    apart : (C,) mean square by which they lie apart, which tells how alike they err.

    Returns
    -------
    (C,) from 0 to 1; half where they lie nowhere apart.

    Source
    ------
    Bates and Granger, The combination of forecasts, Operational Research Quarterly 20(4), 1969, equation 1.
    """
    surer = np.divide(first_var - second_var, apart, out=np.zeros_like(apart), where=apart > 0)
    return np.asarray(np.clip(0.5 + 0.5 * surer, 0.0, 1.0))
