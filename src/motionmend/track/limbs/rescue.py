"""The whole body tried otherwise: turned, moved, in the poses that followed similar ones in the library."""

import numpy as np

from ...bodies.performer import Performer, Pose, rotation
from ..frame.evidence import Evidence, listed, middle
from ..state import Fit, Sight
from ..terms.objective import refined
from ..terms.smooth import about
from .other_poses import Coarse, cast_parts, disagreements

TURNS = (-40.0, -20.0, 20.0, 40.0)  # degrees about the vertical: a fast turn between two frames
GAIN = 0.01  # share of the pixels that another pose must explain better


def rescued(sight: Sight, fit: Fit) -> Fit:
    """The fit, or what Gauss-Newton makes of the likeliest other beginning.

    Other beginnings are the pose before, moved to where the person is and turned about the vertical, and what followed
    the library's nearest poses.

    Parameters
    ----------
    sight : the frame.
    fit : that does not explain it; its state has a pose.
    """
    performer, before, database, coarse = fit.state.performer, fit.state.pose, sight.model.database, sight.coarse
    assert before is not None
    here = [fit.pose, moved_to(performer, fit.pose, sight.evidence, coarse), before]
    tried = [*here[1:], *(about_vertical(pose, degrees) for pose in here[:2] for degrees in TURNS)]
    if len(database):
        index, _ = database.search.nearest(before.joints, 24)
        ahead = database.following(index[::3], 2)[:, -1]
        tried += [Pose(here[1].translation, here[1].root, database.joints[i]) for i in ahead]
    likeliest = tried[int(np.argmin(disagreements(performer, tried, coarse)))]
    trial = refined(sight, fit, likeliest, about(fit.terms, likeliest), max(sight.settings.iterations // 2, 1))
    return trial if trial.wrong < fit.wrong - GAIN else fit


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
