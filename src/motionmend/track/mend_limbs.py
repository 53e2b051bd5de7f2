"""Limbs that explain too little are tried elsewhere; what explains the frame clearly better is taken."""

from typing import TYPE_CHECKING

import numpy as np

from ..arrays import Floats
from ..bodies.performer import Pose, landmarks
from ..numerics.least_squares import Solution
from .certainty import ENOUGH, explained_by_bone
from .evidence import Evidence
from .limbs import LIMBS, Coarse, disagreement, limb_costs, with_limb
from .model import TrackerModel
from .prior_term import strangeness
from .settings import TrackSettings
from .smooth_term import about
from .solve import solve_pose
from .terms import Term

if TYPE_CHECKING:
    from .tracker import TrackState

GAIN = 0.008  # share of the person's pixels that a limb's new pose must explain better
STRANGE = 1.0  # share of the pixels that one unit of the prior's cost weighs
STEP = 0.2  # m, by which an arm or leg may leap for twice that gain
ALIKE = 0.006  # share of the pixels by which two poses of a limb are hardly told apart
SUSPECT = 0.01  # share of pixels explained wrongly beyond the usual that makes every limb be looked for
TRIED = 2  # of each limb's candidates are refined


def mend_limbs(
    model: TrackerModel,
    settings: TrackSettings,
    state: "TrackState",
    evidence: Evidence,
    coarse: Coarse,
    terms: list[Term],
    expected: Pose,
    solution: Solution[Pose],
) -> tuple[Solution[Pose], int, Floats]:
    """Look for each limb among poses of the library and about where it is.

    Returns
    -------
    The solution, a better one if there is; how many limbs were moved; and (16,) m, the doubt about each joint.
    """
    performer = state.performer
    doubt = np.zeros(16)
    moved = 0
    wrong = disagreement(performer, solution.state, coarse)
    shown = explained_by_bone(performer, solution.state, coarse, evidence.weight)
    usual = state.wrong if np.isfinite(state.wrong) else 0.0
    for number, limb in enumerate(LIMBS):
        hidden = min(shown[b] for b in limb.shown) <= ENOUGH
        if wrong < usual + SUSPECT and not hidden:
            continue
        pose = solution.state
        place = landmarks(performer, expected)
        now = np.stack((pose.joints[limb.columns], expected.joints[limb.columns]))
        candidates = np.concatenate((now, model.limb_shapes[number]))
        costs = limb_costs(performer, pose, limb, candidates, coarse)
        better = [(costs[i], with_limb(pose, limb, candidates[i])) for i in np.argsort(costs, kind="stable")[:TRIED]]
        better = [(cost, way) for cost, way in better if cost < wrong - 0.5 * GAIN]
        if wrong >= usual + SUSPECT:
            # A limb that is lost pulls the body with it: it is looked for from where the body was expected, too.
            before = limb_costs(performer, expected, limb, candidates, coarse)
            i = int(np.argmin(before))
            if before[i] < min(before[1], wrong) + 0.5 * GAIN:
                better.append((before[i], with_limb(expected, limb, candidates[i])))
        for _, way in sorted(better, key=lambda one: one[0])[:TRIED]:
            begun = about(terms, with_limb(expected, limb, way.joints[limb.columns]))
            trial = solve_pose(performer, evidence, begun, way, settings, 5)
            after = disagreement(performer, trial.state, coarse)
            odd = STRANGE * (strangeness(terms, trial.state) - strangeness(terms, solution.state))
            leap = np.linalg.norm(landmarks(performer, trial.state) - place, axis=1)[limb.landmarks].mean()
            if after + odd < wrong - GAIN * (1.0 + leap / STEP):
                solution, wrong = trial, after
                moved += 1
                break
        # Poses that explain the frame as well: how far apart they have the joints is what is not known.
        alike = np.exp(-np.maximum(costs - costs[0], 0.0) / ALIKE)
        alike[0] = 1.0
        if alike[1:].sum() > 0.05:
            marks = limb.landmarks
            base = landmarks(performer, pose)[marks]
            near = np.flatnonzero(alike > 0.02)
            away = np.array([landmarks(performer, with_limb(pose, limb, candidates[i]))[marks] - base for i in near])
            share = alike[near] / alike.sum()
            doubt[marks] = np.sqrt((share[:, None] * (away**2).sum(axis=2)).sum(axis=0) / 3.0)
    return solution, moved, doubt
