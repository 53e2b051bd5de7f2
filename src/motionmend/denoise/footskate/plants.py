"""Where feet stand and where they go in between: the first, second and last step of the footskate clean-up.

Source: Kovar, Schreiner and Gleicher 2002, "Footskate Cleanup for Motion Capture Editing", sections 4.1, 4.2 and 4.5.
The paper is told which frames are constrained; here contacts are found, so that some of them are not what they seem:
ends that roll on and off, shuffles, and feet that turn on the spot are taken out first.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...arrays import Bools, Floats, Ints, runs
from ...bodies.feet import Feet
from ...bodies.skeleton import ROTATION, Skeleton
from ...errors import MismatchError

# A standing point of a clean recording strays this far (m) from its place before it rolls on or off; upright and level,
# noisy ones stray further, by up to so many times their usual distance. A foot rolls on or off in this time (s).
CORE, UPRIGHT, LEVEL, ROLL = 0.01, 2, 3, 0.15
# A contact whose point goes further than this (m), and than nine times the usual strays of the clip, is more than
# one, and on the way from one to the other the foot is free for this time (s) to both sides.
SHUFFLE, PAUSE = 0.03, 0.06
# A foot that would have to turn by more than this to stand has turned by itself: its ball is let go.
TURNED = np.radians(40.0)
# The share of the blending time over which the velocity at the end of a contact dies away.
EASE = 1 / 3


@dataclass(frozen=True, eq=False)
class Leg:
    """One leg of a skeleton.

    Attributes
    ----------
    hip, knee, ankle : joint indices.
    ball, tip : where the toes begin and end, -1 where the skeleton does not say.
    dofs, toe_dofs : rotations that may change, from hip to ankle and of the toes.
    """

    hip: int
    knee: int
    ankle: int
    ball: int
    tip: int
    dofs: Ints
    toe_dofs: Ints

    @property
    def foot(self) -> list[int]:
        """The points that stand: the ankle for the heel, and the ball where there is one."""
        return [self.ankle] if self.ball < 0 else [self.ankle, self.ball]


@dataclass(frozen=True, eq=False)
class FootPlan:
    """Where one foot should be.

    Attributes
    ----------
    ankle, ball : (T, 3) m; the ball is the ankle where the foot has no other point.
    firmness : (T,) 1 where the foot is held, 0 where it stays as it was.
    """

    ankle: Floats
    ball: Floats
    firmness: Floats


def find_legs(body: Skeleton, feet: Feet) -> tuple[Leg, Leg]:
    """Left and right leg.

    Raises
    ------
    MismatchError : a leg without hip, knee and ankle.
    """
    legs = []
    turning = body.dof_kind == ROTATION
    for hip, knee, ankle, ball, tip in zip(feet.hips, feet.knees, feet.ankles, feet.toes, feet.ends, strict=True):
        if min(hip, knee) < 0:
            raise MismatchError(
                f"footskate clean-up needs joints that turn at hip and knee above '{body.names[ankle]}', "
                f"came {'one' if knee >= 0 else 'none'}"
            )
        path, joint = [], ankle
        while joint != body.parents[hip]:
            path.append(joint)
            joint = int(body.parents[joint])
        dofs = np.flatnonzero(turning & np.isin(body.dof_joint, path))
        toe_dofs = np.flatnonzero(turning & (body.dof_joint == ball) & (tip >= 0))
        legs.append(Leg(hip, knee, ankle, ball, tip, dofs, toe_dofs))
    return legs[0], legs[1]


def plan_foot(
    leg: Leg, before: Floats, standing: Bools, usable: Bools, up: Floats, fps: float, blend_s: float
) -> FootPlan:
    """Targets of one foot's ankle and ball on all frames (sections 4.1, 4.2 and 4.5).

    Parameters
    ----------
    before : (T, J, 3) m, all joints as recorded.
    standing : (T, P) contacts of the P points of `leg.foot`.
    usable : (T,) False where the leg is not known.
    up : (3,) unit vector against gravity.
    fps : Hz.
    blend_s : s over which changes fade, before and after each contact.
    """
    window = max(1, round(blend_s * fps))
    places = [before[:, joint] for joint in leg.foot]
    held = _plants(places, [_joined(stand, usable, fps) for stand in standing.T], up, fps)
    if leg.ball >= 0:
        _let_turn(held, places)
    stands = [np.isfinite(place[:, 0]) for place in held]
    firm = [_firmness(stand, usable, window) for stand in stands]
    change = [np.nan_to_num(place - was) for place, was in zip(held, places, strict=True)]
    if leg.ball < 0:
        goal = places[0] + _blend(change[0], stands[0], usable, window)
        return FootPlan(goal, goal, firm[0])
    goals = []
    for own, other in ((0, 1), (1, 0)):
        # A point that does not stand goes along with the foot's other point; what the foot turns by where both stand
        # is blended out (section 4.2). Jitter of the one is no reason to shake the other.
        follow = _blend(_calm(change[other], stands[other], window // 2), stands[other], usable, window)
        turn = _blend(np.where(stands[own][:, None], change[own] - follow, 0.0), stands[own], usable, window)
        goals.append(places[own] + follow + turn)
    # The foot keeps its length; the point that is held less gives way.
    along = goals[0] - goals[1]
    excess = along - _of_length(along, np.linalg.norm(places[0] - places[1], axis=1, keepdims=True))
    share = ((1 - firm[0] + 1e-9) / (2 - firm[0] - firm[1] + 2e-9))[:, None]
    return FootPlan(goals[0] - share * excess, goals[1] + (1 - share) * excess, np.maximum(*firm))


def _joined(stands: Bools, usable: Bools, fps: float) -> Bools:
    """Contacts (T,) with gaps of up to PAUSE closed where all is known: no foot is lifted and set down that fast."""
    pause = max(1, round(PAUSE * fps))
    joined = stands & usable
    for begin, end in runs(~stands & usable):
        if begin > 0 and end < len(stands) and joined[begin - 1] and joined[end] and end - begin <= pause:
            joined[begin:end] = True
    return joined


def _calm(change: Floats, stands: Bools, reach: int) -> Floats:
    """Changes (T, 3) averaged over `reach` frames to both sides, each contact by itself."""
    calm = change.copy()
    for begin, end in runs(stands):
        total = np.concatenate((np.zeros((1, 3)), np.cumsum(change[begin:end], axis=0)))
        frame = np.arange(end - begin)
        side = np.minimum(reach, np.minimum(frame, end - begin - 1 - frame))
        calm[begin:end] = (total[frame + side + 1] - total[frame - side]) / (2 * side + 1)[:, None]
    return calm


def _of_length(ways: Floats, length: Floats) -> Floats:
    """Vectors (T, 3) brought to `length` (T, 1) m."""
    return np.asarray(ways * (length / np.maximum(np.linalg.norm(ways, axis=1, keepdims=True), 1e-12)))


def _plants(places: Sequence[Floats], standing: Sequence[Bools], up: Floats, fps: float) -> list[Floats]:
    """For each point (T, 3), its held place during each contact, NaN elsewhere.

    Each contact is held at its average place (section 4.1), one that shuffles at several. The contacts of a foot are
    placed one after the other as they begin; one that begins while the foot's other point stands is moved to lie a
    foot's length from it, so that neighbours agree.
    """
    held = [np.full(place.shape, np.nan) for place in places]
    pause = max(1, round(PAUSE * fps))
    contacts = [
        (*_core(places[p], begin, end, up, fps), p) for p in range(len(places)) for begin, end in runs(standing[p])
    ]
    strays = [_away(places[p][begin:end]) for begin, end, p in contacts]
    farthest = max(SHUFFLE, 9 * float(np.median(np.concatenate(strays)))) if strays else SHUFFLE
    stays = [(*stay, p) for begin, end, p in contacts for stay in _stays(places[p], begin, end, farthest, pause)]
    for begin, end, point in sorted(stays):
        here = places[point][begin:end].mean(axis=0)
        for other in range(len(places)):
            if other != point and np.isfinite(held[other][begin]).all():
                anchor = held[other][begin]
                length = np.linalg.norm(places[point][begin] - places[other][begin])
                here = anchor + (here - anchor) * length / max(np.linalg.norm(here - anchor), 1e-12)
        held[point][begin:end] = here
    return held


def _away(place: Floats) -> Floats:
    """(n,) m, distances from the middle of a stay."""
    return np.asarray(np.linalg.norm(place - np.median(place, axis=0), axis=1))


def _let_turn(held: Sequence[Floats], places: Sequence[Floats]) -> None:
    """Let go of the stays of the ball (the second point) that would turn the foot too far about the ankle."""
    planned, was = held[1] - held[0], places[1] - places[0]
    lengths = np.linalg.norm(planned, axis=1) * np.linalg.norm(was, axis=1)
    cosine = np.divide(np.einsum("ti,ti->t", planned, was), lengths, out=np.ones(len(was)), where=lengths > 0)
    turned = cosine < np.cos(TURNED)  # False where only one of the points stands
    for begin, end in runs(np.isfinite(held[1][:, 0])):
        if turned[begin:end].any():
            held[1][begin:end] = np.nan


def _stays(place: Floats, begin: int, end: int, farthest: float, pause: int) -> list[tuple[int, int]]:
    """A contact cut where the foot shuffles or pivots to another place: nowhere `farthest` m from the stay's middle.

    Cut in two at the frame that leaves the least squared distances from the two averages, `pause` frames to both sides
    of which are free for the way between, for as long as need be.
    """
    if _away(place[begin:end]).max() <= farthest:
        return [(begin, end)]
    if end - begin <= 4 * pause:
        return []
    count = np.arange(1, end - begin)[:, None]
    total = np.cumsum(place[begin:end] - place[begin], axis=0)
    # The squares that two averages leave differ from cut to cut by the averages' own squares only.
    gain = (total[:-1] ** 2 / count + (total[-1] - total[:-1]) ** 2 / (end - begin - count)).sum(axis=1)
    cut = begin + 1 + int(np.argmax(gain))
    parts = [(begin, cut - pause), (cut + pause, end)]
    return [stay for a, b in parts if b - a > pause for stay in _stays(place, a, b, farthest, pause)]


def _core(place: Floats, begin: int, end: int, up: Floats, fps: float) -> tuple[int, int]:
    """The part of a contact that is held: without rolling on and off at its ends, where the point leaves its place."""
    away = place[begin:end] - np.median(place[begin:end], axis=0)
    upright = away @ up
    near = np.ones(end - begin, dtype=bool)
    for distance, times in ((np.abs(upright), UPRIGHT), (np.linalg.norm(away - upright[:, None] * up, axis=1), LEVEL)):
        near &= distance <= max(CORE, times * float(np.median(distance)))
    held = np.flatnonzero(near)
    if not len(held):
        return begin, end
    roll = round(ROLL * fps)
    return begin + min(int(held[0]), roll), end - min(end - begin - 1 - int(held[-1]), roll)


def _blend(change: Floats, known: Bools, usable: Bools, window: int) -> Floats:
    """Fade changes (T, 3), `known` on some frames, to 0 over `window` frames before and after; 0 on unusable frames.

    Section 4.5; between contacts closer than the window the one change passes into the other. The velocity at the edge
    of a contact fades as well, with the cubic's other basis function: a foot that still moves there does not jerk.
    """
    faded = np.where(known[:, None], change, 0.0)
    spans = runs(known)
    for index, (begin, end) in enumerate(spans):
        earlier = spans[index - 1][1] if index else -window
        later = spans[index + 1][0] if index + 1 < len(spans) else len(known) + window
        for edge, step, gap in ((end - 1, 1, later - end), (begin, -1, begin - earlier)):
            reach = min(window, gap + 1)
            inner = edge - step * min(2, end - begin - 1)
            slope = (change[edge] - change[inner]) / max(abs(edge - inner), 1)
            ease = max(1, round(reach * EASE))
            for k in range(1, reach):
                frame = edge + step * k
                if not 0 <= frame < len(known) or not usable[frame]:
                    break
                t = k / reach
                alpha = 2 * t**3 - 3 * t**2 + 1  # section 4.2
                faded[frame] += alpha * change[edge]
                if k < ease:
                    u = k / ease
                    faded[frame] += (u**3 - 2 * u**2 + u) * ease * slope
    return np.where(usable[:, None], faded, 0.0)


def _firmness(stands: Bools, usable: Bools, window: int) -> Floats:
    """(T,) 1 where the foot stands, fading to 0 as the changes do."""
    return _blend(stands[:, None] * np.ones(3), stands, usable, window)[:, 0]
