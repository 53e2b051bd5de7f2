"""A piece of the person that nothing of the body is near: a limb, and the trunk with it, is laid into it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from ...arrays import Floats
from ...bodies.performer import LANDMARKS, Performer, Pose, landmarks
from ..readings.hypotheses import GAIN
from ..starting.reach import reach
from ..state import Fit, Sight
from ..terms.objective import refined
from ..terms.prior import strangeness
from ..terms.smooth import about
from .other_poses import LIMBS, Coarse, LeftOver, Limb, disagreement, left_over, opposite

CLAIMED = 0.012  # m^2 left over, from where on a limb is laid into it
LEAST = 0.006  # m^2, about a hand: a smaller piece is none, and one that shrinks by less is not claimed
TIP = 0.09  # m, from the end of a hand to the wrist, of a foot to the ankle
BAND = 0.05  # m, of the piece on either side of there whose middle is taken
INSIDE = 0.025  # m, from the skin to the joint
NEAR = 0.03  # share of the pixels that a pose may explain less before it is refined
EVEN = 0.1  # share of the pixels by which it is the likelier of two limbs that is in a piece, before it is refined
MOSTLY = 0.5  # of what is left over: a limb that is in there leaves less of it
STAYS = 0.3  # weight of where the other joints are, beside 1 of the limb's end


@final
@dataclass(frozen=True, eq=False)
class Way:
    """A pose whose `limb` is laid into a piece; `wrong` is the share of the person's pixels it explains wrongly."""

    limb: Limb
    pose: Pose
    wrong: float


def claimed(sight: Sight, fit: Fit, left: LeftOver, ways: Sequence[Way]) -> tuple[Fit, int]:
    """The fit, or one whose limb is in the largest piece that it leaves over, if that explains more.

    Noise leaves no piece as large as a hand over; so a limb may leap for it as far as it must. Nor may it stay left
    over because an arm in it bends as the library's do not: a piece of which most is explained makes up for that.

    Parameters
    ----------
    sight, fit : the frame, and how it is explained so far.
    left : what of the person that leaves over. ways : limbs laid into that (`laid_in`).

    Returns
    -------
    The fit, and how many limbs were moved.
    """
    performer, coarse, terms = fit.state.performer, sight.coarse, fit.terms
    if not ways or ways[0].wrong > fit.wrong + NEAR:
        return fit, 0
    way, moved, least = ways[0].pose, 0, fit.wrong - GAIN
    usual, share = strangeness(terms, fit.pose), _share(left, coarse)
    for some in (terms, about(terms, way)):  # from where the body was expected, and from here
        trial = refined(sight, fit, way, some)
        still = left_over(performer, trial.pose, coarse)
        odd = strangeness(terms, trial.pose) - usual
        if still.area < MOSTLY * left.area:
            odd = max(odd - share + _share(still, coarse), min(odd, 0.0))
        price = trial.wrong + odd
        if price < least and still.area < left.area - LEAST:
            fit, least, moved = trial, price, 1
    return fit, moved


def in_doubt(performer: Performer, pose: Pose, wrong: float, ways: Sequence[Way]) -> Floats:
    """(16,) m, the doubt about each joint while a piece of the person is left over that a limb may well be in.

    Such a limb is elsewhere in the pose, or its fellow on the other side is, and it in the fellow's place.

    Parameters
    ----------
    performer, pose : as tracked. wrong : share of the person's pixels that the pose explains wrongly.
    ways : limbs laid into the piece (`laid_in`).
    """
    if not ways or ways[0].wrong > wrong + NEAR:
        return np.zeros(len(LANDMARKS))
    likeliest = ways[0].limb
    ways = [way for way in ways if way.limb in (likeliest, opposite(likeliest))]
    away = np.array([((landmarks(performer, way.pose) - landmarks(performer, pose)) ** 2).sum(axis=1) for way in ways])
    share = np.exp(-np.array([way.wrong for way in ways]) / EVEN)
    return np.asarray(np.sqrt(share @ away / share.sum() / 3.0))


def _share(left: LeftOver, coarse: Coarse) -> float:
    """Of the person's pixels those that are left over."""
    return len(left.points) / max(coarse.pixels, 1)


def laid_in(performer: Performer, pose: Pose, coarse: Coarse, left: LeftOver) -> list[Way]:
    """The pose with a limb's end in the largest piece that is left over, each limb that reaches it in its turn.

    Parameters
    ----------
    performer, pose : as tracked.
    coarse : the frame.
    left : what of it the pose leaves over.

    Returns
    -------
    Poses, the best first; to be refined.
    """
    piece = _largest(left, coarse) if left.area > CLAIMED else left.points[:0]
    if len(piece) == 0 or float(piece[:, 2] @ piece[:, 2]) / (coarse.intrinsics[0] * coarse.intrinsics[1]) < LEAST:
        return []
    at = landmarks(performer, pose)
    ends = [(limb, _with_end_in(performer, pose, at, limb, piece)) for limb in LIMBS]
    ways = [Way(limb, way, disagreement(performer, way, coarse)) for limb, way in ends if way is not None]
    return sorted(ways, key=lambda way: way.wrong)


def _largest(left: LeftOver, coarse: Coarse) -> Floats:
    """(N, 3) m, of the points those of the largest piece that hangs together in the picture."""
    import cv2

    if not len(left.points):
        return left.points
    mask = np.zeros(coarse.seen.shape, np.uint8)
    mask[left.rows, left.columns] = 1
    _, labels = cv2.connectedComponents(cv2.dilate(mask, np.ones((3, 3), np.uint8)))
    piece = labels[left.rows, left.columns]
    return np.asarray(left.points[piece == int(np.argmax(np.bincount(piece, left.points[:, 2] ** 2)))])


def _with_end_in(performer: Performer, pose: Pose, at: Floats, limb: Limb, piece: Floats) -> Pose | None:
    """The pose near this one whose hand or foot is in the far end of the piece; None where the limb is too short."""
    middle, end = limb.landmarks
    length = np.linalg.norm(at[middle] - at[limb.begin]) + np.linalg.norm(at[end] - at[middle])
    away = np.linalg.norm(piece - at[limb.begin], axis=1)
    tip = float(np.percentile(away, 95))
    if tip > 1.3 * length + TIP:
        return None
    band = np.abs(away - max(tip - TIP, float(away.min()))) < BAND
    if not band.any():
        return None
    goal = piece[band].mean(axis=0)
    goal = goal * (1.0 + INSIDE / np.linalg.norm(goal))
    targets = at.copy()
    targets[middle] = np.nan
    targets[end] = goal
    weights = np.full(len(LANDMARKS), STAYS)
    weights[end] = 1.0
    return reach(performer, pose, targets, weights, rounds=8)[0]
