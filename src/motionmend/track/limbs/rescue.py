"""The whole body tried otherwise: turned, moved, in the poses that followed similar ones in the library."""

import numpy as np

from ...bodies.performer import Performer, Pose, rotation
from ...numerics.least_squares import Solution
from ..frame.evidence import Evidence, listed, middle
from ..model import TrackerModel
from ..settings import TrackSettings
from ..state import TrackState
from ..terms.contract import Term
from ..terms.smooth import about
from ..terms.solve import solve_pose
from .other_poses import Coarse, cast_parts, disagreement, disagreements

TURNS = (-40.0, -20.0, 20.0, 40.0)  # degrees about the vertical: a fast turn between two frames
GAIN = 0.01  # share of the pixels that another pose must explain better


def rescued(
    model: TrackerModel,
    settings: TrackSettings,
    state: TrackState,
    evidence: Evidence,
    coarse: Coarse,
    terms: list[Term],
    solution: Solution[Pose],
    wrong: float,
) -> tuple[Solution[Pose], float]:
    """The solution, or what Gauss-Newton makes of the likeliest other beginning, and its share explained wrongly.

    Other beginnings are the pose before, moved to where the person is and turned about the vertical, and what followed
    the library's nearest poses.

    Parameters
    ----------
    model : the library of poses.
    settings : of the tracker.
    state : after the frame before; it has a pose.
    evidence, coarse : what the frame says, and its coarse raster.
    terms : made for this frame.
    solution : that does not explain the frame.
    wrong : share of the person's pixels it explains wrongly, 0 to 1.
    """
    performer = state.performer
    assert state.pose is not None
    here = [solution.state, moved_to(performer, solution.state, evidence, coarse), state.pose]
    tried = [*here[1:], *(about_vertical(pose, degrees) for pose in here[:2] for degrees in TURNS)]
    if len(model.database):
        index, _ = model.database.search.nearest(state.pose.joints, 24)
        ahead = model.database.following(index[::3], 2)[:, -1]
        tried += [Pose(here[1].translation, here[1].root, model.database.joints[i]) for i in ahead]
    likeliest = tried[int(np.argmin(disagreements(performer, tried, coarse)))]
    trial = solve_pose(
        performer, evidence, about(terms, likeliest), likeliest, settings, max(settings.iterations // 2, 1)
    )
    after = disagreement(performer, trial.state, coarse)
    return (trial, after) if after < wrong - GAIN else (solution, wrong)


def about_vertical(pose: Pose, degrees: float) -> Pose:
    """The pose turned about the camera's vertical through its root."""
    return Pose(pose.translation, rotation(np.array([0.0, np.radians(degrees), 0.0])) @ pose.root, pose.joints)


def turned(pose: Pose, count: int) -> list[Pose]:
    """The pose at `count` headings all round, its own first."""
    return [about_vertical(pose, 360.0 * k / count) for k in range(count)]


def moved_to(performer: Performer, pose: Pose, evidence: Evidence, coarse: Coarse) -> Pose:
    """The pose moved, in m, to where the person is: what is seen of both has the same middle (medians)."""
    depth, _ = cast_parts(performer, pose, coarse)
    points, seen = listed(depth, coarse.intrinsics, 1)[1], middle(evidence.samples)
    if not len(points):
        return Pose(seen + np.array([0.0, 0.0, 0.1]), pose.root, pose.joints)  # half a body's depth
    return Pose(pose.translation + seen - middle(points), pose.root, pose.joints)
