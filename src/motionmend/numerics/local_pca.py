"""A linear model of a few samples: what of a point they cannot explain (section 3.5)."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ..arrays import Floats


@final
@dataclass(frozen=True, eq=False)
class LocalPca:
    """Mean and principal directions of samples in n dimensions.

    Attributes
    ----------
    mean : (n,).
    basis : (n, e) orthonormal, strongest first.
    variances : (n,) of all n directions, strongest first; beyond the basis they are what is left out.
    """

    mean: Floats
    basis: Floats
    variances: Floats

    def rest(self) -> Floats:
        """I - U Uᵀ (n, n): takes a difference from the mean to the part the basis cannot explain (eq. 3.12)."""
        return np.eye(len(self.mean)) - self.basis @ self.basis.T


def local_pca(samples: Floats, energy: float = 0.95) -> LocalPca:
    """Principal components of `samples` (N, n) that hold at least `energy` of the variance (eq. 3.10-3.11).

    Parameters
    ----------
    samples : (N, n), at least one.
    energy : share, in (0, 1].
    """
    mean, covariance = moments(samples)
    values, vectors = np.linalg.eigh(covariance)  # eq. 3.10
    values, vectors = np.maximum(values[::-1], 0.0), vectors[:, ::-1]
    total = values.sum()
    # Eq. 3.11; rounding may leave the whole sum a hair under the share asked for.
    kept = 0 if total <= 0 else int(np.searchsorted(np.cumsum(values) / total, energy - 1e-12) + 1)
    kept = min(kept, len(values))
    return LocalPca(mean, np.ascontiguousarray(vectors[:, :kept]), values)


def moments(samples: Floats, weights: Floats | None = None) -> tuple[Floats, Floats]:
    """Mean (n,) and covariance (n, n) of samples (N, n) by weights (N,), not negative; equal when not given."""
    if weights is None:
        mean = samples.mean(axis=0)
        centred = samples - mean
        return mean, centred.T @ centred / max(len(samples) - 1, 1)
    share = weights / weights.sum()
    mean = share @ samples
    centred = samples - mean
    return mean, (centred * share[:, None]).T @ centred / max(1.0 - float(share @ share), 1e-9)
