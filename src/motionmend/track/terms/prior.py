"""Poses like those that followed similar ones in a library of motion (section 3.5)."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from ...arrays import Floats, frozen
from ...bodies.performer import Pose
from ...kernels.bone_systems import about_mean
from ...numerics.least_squares import inverse
from ...numerics.local_pca import LocalPca, local_pca, moments
from ..database import PoseDatabase
from ..settings import TrackSettings
from .contract import Share, Term
from .view import Sums, View


@final
@dataclass(frozen=True, eq=False)
class PriorTerm:
    """A quadratic about a mean pose; the root is left out.

    Attributes
    ----------
    mean : (28,) rad. form : (28, 28), the quadratic form, weight included.
    """

    mean: Floats
    form: Floats
    name: str = "prior"

    def residual(self, view: View) -> float:
        """The weighted cost at a pose."""
        return self.cost(view.pose)

    def cost(self, pose: Pose) -> float:
        """The same without a picture."""
        away = pose.joints - self.mean
        return float(away @ self.form @ away)

    def linearize(self, view: View, sums: Sums, iteration: int) -> Share:
        """Equation 3.13."""
        return Share(about_mean(view.pose.joints, self.mean, self.form, sums.normal, sums.right))


def prior_term(
    database: PoseDatabase, pose: Pose, settings: TrackSettings, trust: Floats | None = None
) -> PriorTerm | None:
    """The local model of what follows poses like `pose`; None without a database.

    Parameters
    ----------
    database : poses in the order of their clips.
    pose : of the frame before.
    trust : (28,) in [0, 1], how well each joint coordinate of the pose is known; all alike when not given.
    """
    if not len(database):
        return None
    weights = None if trust is None else np.maximum(trust, 0.02)
    index, distance = database.search.nearest(pose.joints, settings.neighbors, weights)
    follow = database.following(index, settings.following)
    samples = database.joints[follow.ravel()]
    if settings.spread <= 0.0:
        model: LocalPca = local_pca(samples, settings.energy)
        return PriorTerm(frozen(model.mean), frozen(settings.prior * model.rest()))  # eq. 3.12: (U Uᵀ - I)² = I - U Uᵀ
    # Near neighbours count more; and where even they are far, the library has little to say of this pose.
    near = distance**2 / max(1.0 if weights is None else float(weights.sum()) / len(weights), 1e-9) / len(pose.joints)
    scale = near[len(near) // 2] + settings.spread**2
    share = np.repeat(1.0 / (1.0 + near / scale), follow.shape[1])
    mean, covariance = moments(samples, share)
    covariance.ravel()[:: len(covariance) + 1] += settings.spread**2 + float(near[0])
    return PriorTerm(frozen(mean), frozen(settings.prior * settings.spread**2 * inverse(covariance)))


def strangeness(terms: Sequence[Term], pose: Pose) -> float:
    """What the prior among the terms says against a pose; 0 without one."""
    return sum(term.cost(pose) for term in terms if isinstance(term, PriorTerm))


def said_against(terms: Sequence[Term]) -> tuple[Floats, Floats]:
    """Mean (28,) and quadratic form (28, 28) of the prior among the terms; empty without one."""
    for term in terms:
        if isinstance(term, PriorTerm):
            return term.mean, term.form
    return np.empty(0), np.empty((0, 0))
