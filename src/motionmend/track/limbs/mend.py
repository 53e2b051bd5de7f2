"""Limbs that explain too little are tried elsewhere; what explains the frame clearly better is taken."""

from dataclasses import dataclass
from typing import final

import numpy as np

from ...arrays import Floats
from ...bodies.performer import Performer, Pose, landmarks
from ..readings.hypotheses import GAIN, STEP
from ..state import Fit, Hypothesis, Sight
from ..terms.objective import refined
from ..terms.prior import said_against, strangeness
from ..terms.smooth import about
from .certainty import DENIED, ENOUGH, shown_and_denied
from .other_poses import SEARCHED, Limb, Searched, draws, limb_places, limb_search, with_limb

STRANGE = 1.0  # share of the pixels that one unit of the prior's cost weighs
ALIKE = 0.006  # share of the pixels by which two poses of a limb are hardly told apart
SUSPECT = 1.08  # times the usual share of pixels explained wrongly, above which limbs are looked for
WORTH = 0.25 * GAIN  # a gain from where on a pose that was not taken is worth following
SPREADS = (0.3, 0.15)  # rad, of poses of a limb drawn about the best, in each round
KEPT, DRAWN = 6, 24  # how many best those are, and how many poses are drawn about them
CLOSER = 3  # of all looks at limbs, those that promise most, about whose best poses others are drawn
DRAWS = tuple(draws(np.random.default_rng(0), limb, SPREADS, KEPT, DRAWN) for limb in SEARCHED)
TRIED = 1  # of all limbs' candidates is refined: the rest wait for the next frame


@final
@dataclass(frozen=True, eq=False)
class _Look:
    """One limb looked for among a library's poses.

    Attributes
    ----------
    number : of `SEARCHED`. body : from where.
    elite : (E, n) rad, the cheapest poses, the cheapest first. price : of that, a share of the pixels.
    here : what the limb costs as it is. most : what another pose may cost to be better.
    """

    number: int
    body: Pose
    elite: Floats
    price: float
    here: float
    most: float


def mend_limbs(sight: Sight, fit: Fit, unclaimed: bool = False) -> tuple[Fit, int, Floats, Hypothesis | None]:
    """Look for each limb among poses of the library and about where it is.

    Parameters
    ----------
    sight, fit : the frame, and how it is explained so far.
    unclaimed : a piece of the person has nothing of the body near it.

    Returns
    -------
    The fit, a better one if there is; how many limbs were moved; (16,) m, the doubt about each joint; and the pose
    that lost against it, if frames to come may say otherwise.
    """
    state, coarse, expected = fit.state, sight.coarse, fit.expected
    performer = state.performer
    doubt = np.zeros(16)
    shown, denied, _ = shown_and_denied(performer, fit.pose, coarse, sight.evidence.weight)
    usual = state.wrong if np.isfinite(state.wrong) else 0.0
    worse, much = (unclaimed or fit.wrong >= SUSPECT * usual + least for least in (0.01, 0.025))
    pose, place = fit.pose, landmarks(performer, expected)
    mean, form = said_against(fit.terms)
    form = STRANGE * form
    looks: list[_Look] = []
    for number, limb in enumerate(SEARCHED):
        hidden = min(shown[b] for b in limb.shown) <= ENOUGH
        against = max(denied[b] / (shown[b] + denied[b] + ENOUGH) for b in limb.shown)
        # Where all limbs are suspect the arms have their turn in one frame, the legs in the next.
        due = much and number // 2 == state.searched % 2
        if not (hidden or due or (worse and against > DENIED)):
            continue
        now = np.stack((pose.joints[limb.columns], expected.joints[limb.columns]))
        candidates = np.concatenate((now, sight.model.limb_shapes[number]))
        found = limb_search(performer, pose, limb, candidates, coarse, mean=mean, form=form)
        here = float(found.costs[0])  # as the search counts, which leaves no margin about the limb
        looks.append(_Look(number, pose, _elite(candidates, found), found.price, here, here - 0.5 * GAIN))
        if hidden:
            doubt[limb.landmarks] = _doubt(performer, pose, limb, candidates, found.costs)
        if worse:
            # A limb that is lost pulls the body with it: it is looked for from where the body was expected, too.
            found = limb_search(performer, expected, limb, candidates, coarse, mean=mean, form=form)
            most = min(float(found.costs[1]) - 0.5 * GAIN, here + GAIN)
            looks.append(_Look(number, expected, _elite(candidates, found), found.price, here, most))
    better: list[tuple[float, int, Pose]] = []
    for look in sorted(looks, key=lambda one: one.price - one.here)[:CLOSER]:
        limb, drawn = SEARCHED[look.number], DRAWS[look.number]
        found = limb_search(performer, look.body, limb, look.elite, coarse, drawn, mean, form)
        if found.price < look.most:
            better.append((found.price - look.here, look.number, with_limb(look.body, limb, found.best)))
    moved, hypothesis = 0, None
    for _, number, way in sorted(better, key=lambda one: one[0])[:TRIED]:
        limb = SEARCHED[number]
        trial = refined(sight, fit, way, about(fit.terms, with_limb(expected, limb, way.joints[limb.columns])))
        odd = STRANGE * (strangeness(fit.terms, trial.pose) - strangeness(fit.terms, fit.pose))
        leap = np.linalg.norm(landmarks(performer, trial.pose) - place, axis=1)[limb.landmarks].mean()
        gain = fit.wrong - trial.wrong - odd
        if gain > GAIN * (1.0 + (leap / STEP) ** 2):
            hypothesis = Hypothesis(fit.pose, -gain)
            fit, moved = trial, moved + 1
        elif gain > WORTH:
            hypothesis = Hypothesis(trial.pose, gain)
    return fit, moved, doubt, hypothesis


def _elite(candidates: Floats, found: Searched) -> Floats:
    """The `KEPT` cheapest of candidates (C, n), the cheapest first."""
    return candidates[np.argsort(found.prices, kind="stable")[:KEPT]]


def _doubt(performer: Performer, pose: Pose, limb: Limb, candidates: Floats, costs: Floats) -> Floats:
    """(n,) m, how far poses of a limb that explain the frame as well have its joints from where they are."""
    alike = np.exp(-np.maximum(costs - costs[0], 0.0) / ALIKE)
    near = np.flatnonzero(alike > 0.02)
    away = limb_places(performer, pose, limb, candidates[near]) - landmarks(performer, pose)[limb.landmarks]
    share = alike[near] / alike[near].sum()
    return np.asarray(np.sqrt((share[:, None] * (away**2).sum(axis=2)).sum(axis=0) / 3.0))
