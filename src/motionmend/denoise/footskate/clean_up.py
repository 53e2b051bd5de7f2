"""Feet that stand, stand still: footskate clean-up after Kovar, Schreiner and Gleicher.

Source: Kovar, Schreiner and Gleicher 2002, "Footskate Cleanup for Motion Capture Editing", Symposium on Computer
Animation. What differs, and why:

- Skeletons of recordings have no joint at the heel: the ankle takes its place, which hardly moves while the heel
  stands.
- The paper lengthens the leg where the damped knee does not reach. A recording's skeleton is rigid, so the root
  gives way instead: one least-squares problem places it where both knees reach and where its path stays smooth,
  in place of projecting each frame by itself and averaging afterwards.
- A knee that must straighten in a few frames is evened out over time; the foot then misses its place by millimetres.
- The toes keep their direction instead of being turned up out of the floor: it is not known where the floor is.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...arrays import Bools, Floats, Ints, frozen, runs
from ...bodies import feet as floor
from ...bodies.ik import solve
from ...bodies.motion import Motion
from ...bodies.skeleton import ROTATION, TRANSLATION, Skeleton, forward, positions
from ...errors import MismatchError, UsageError
from .plants import FootPlan, Leg, find_legs, plan_foot

# Up to this angle between thigh and shank the knee is free; from there to straight it is damped more and more, as
# the same step changes the distance from hip to ankle less and less (the paper's rho).
FREE_KNEE = np.radians(160.0)
# The root's way: a leg's miss counts 1, shifting the root this much, its acceleration by the fourth power of this
# share of the blending time.
ROOT_REST, ROOT_TIME = 0.02, 1 / 6
# A held leg stretches freely to 99.9 % of its length (a knee bent by 5 degrees), and never beyond 99.98 % (2 degrees).
NEARLY_STRAIGHT, STRAIGHT = 0.999, 0.9998
# The time (s) over which the change of a knee is evened out the more, the straighter it is beyond this angle.
POP, BENT = 0.06, np.radians(140.0)
# The miss (m) that weighs as much as turning a joint by a radian: a foot at its limits is missed, not met by swivelling
# the whole leg.
TURN_COST = 0.02
ROOM = np.radians(10)
# From straight to this angle a knee is bent either way by noise alone.
BACKWARDS = np.radians(3.0)


@dataclass(frozen=True, eq=False)
class FootskateResult:
    """A motion whose standing feet stand still.

    Attributes
    ----------
    motion : the same recording; only the legs and the root's place differ, and only near contacts.
    contacts : (T, P) the contacts as found or given, False where the legs are not known.
    points : (P,) names of the joints held: left ankle, left toes, right ankle, right toes.
    moved : (T,) m, the furthest that any joint was moved; 0 in frames that are untouched, NaN where unknown.
    skate_before, skate_after : mean horizontal speed of `points` during `contacts`, m/s; NaN without contacts.
    warnings : one sentence each.
    """

    motion: Motion
    contacts: Bools
    points: tuple[str, ...]
    moved: Floats
    skate_before: float
    skate_after: float
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "contacts", frozen(self.contacts, np.bool_))
        object.__setattr__(self, "moved", frozen(self.moved))


def clean_footskate(motion: Motion, *, contacts: Bools | None = None, blend_s: float = 0.25) -> FootskateResult:
    """Hold ankles and toes where they stand, let legs and root follow, and blend the change out around each contact.

    Parameters
    ----------
    motion : a recording of a skeleton with two legs; frames with NaN in the legs or the root stay as they are.
    contacts : (T, P) True where the joints of `bodies.feet.foot_joints(skeleton).joints` stand; found in the motion
        when not given.
    blend_s : s before and after each contact over which the change fades (L frames in the paper).

    Raises
    ------
    MismatchError : a body without two legs of hip, knee and ankle, or contacts of another shape.
    UsageError : a blending time that is not above 0.

    Source
    ------
    Kovar, Schreiner and Gleicher 2002, section 4; the module says what differs.
    """
    if not blend_s > 0:
        raise UsageError(f"footskate clean-up needs a blending time above 0 s, came {blend_s}")
    body, fps = motion.skeleton, motion.fps
    feet = floor.foot_joints(body)
    legs = find_legs(body, feet)
    free = _with_room(body, motion.q)
    before, turns = forward(body, motion.q)
    points = feet.joints
    standing = floor.contacts(before[:, points], fps, body.up) if contacts is None else np.asarray(contacts, dtype=bool)
    if standing.shape != (motion.frames, len(points)):
        raise MismatchError(
            f"contacts must be {(motion.frames, len(points))} for {', '.join(body.names[p] for p in points)}, "
            f"came {standing.shape}"
        )
    usable = _known(before[:, [joint for leg in legs for joint in (leg.ankle, leg.ball, leg.tip) if joint >= 0]])
    standing = standing & usable[:, None]

    plans = [
        plan_foot(leg, before, standing[:, np.isin(points, leg.foot)], usable, body.up, fps, blend_s) for leg in legs
    ]
    shift, warnings = _root_shift(body, legs, plans, before, usable, ROOT_TIME * blend_s * fps)
    held = np.maximum(*(plan.firmness for plan in plans)) > 0
    touched = np.flatnonzero(usable & (held | (shift != 0).any(axis=1)))
    q = _move_root(body, motion.q, shift, touched)
    for leg, plan in zip(legs, plans, strict=True):
        q[touched] = _bend(free, leg, plan, before, turns, shift, touched, q[touched], fps)
    after = positions(body, q)
    return FootskateResult(
        motion=motion.with_q(q),
        contacts=standing,
        points=tuple(body.names[point] for point in points),
        moved=np.where(usable, np.nan_to_num(np.linalg.norm(after - before, axis=2)).max(axis=1), np.nan),
        skate_before=floor.skate_during(before[:, points], standing, fps, body.up),
        skate_after=floor.skate_during(after[:, points], standing, fps, body.up),
        warnings=feet.guesses + warnings,
    )


def _with_room(body: Skeleton, q: Floats) -> Skeleton:
    """The body with its limits widened to what this clip does, and by ROOM more."""
    low = np.where(np.isfinite(q), q, np.inf).min(axis=0, initial=np.inf)
    high = np.where(np.isfinite(q), q, -np.inf).max(axis=0, initial=-np.inf)
    widest = np.stack((np.minimum(body.limits[:, 0], low) - ROOM, np.maximum(body.limits[:, 1], high) + ROOM), axis=1)
    return replace(body, limits=widest)


def _known(places: Floats) -> Bools:
    """(T,) True where all of (T, n, 3) are finite."""
    return np.asarray(np.isfinite(places).all(axis=(1, 2)))


# --- Section 4.3: the root --------------------------------------------------------------------------------------------


def _root_shift(
    body: Skeleton, legs: Sequence[Leg], plans: Sequence[FootPlan], before: Floats, usable: Bools, smooth: float
) -> tuple[Floats, tuple[str, ...]]:
    """(T, 3) m by which the root gives way to legs that would have to straighten or fold too suddenly.

    Minimises  sum (u·r - miss)² + ROOT_REST sum |r|² + smooth⁴ sum |r'' |²  with u the way from hip to ankle and
    `miss` the part of the distance that the damped knee refuses (section 4.4), re-linearised three times.
    """
    shift = np.zeros((len(before), 3))
    if _root_axes(body) is None:
        return shift, ("the root has no three translations of its own: it stays where it is",)
    for begin, end in runs(usable & (np.maximum(*(plan.firmness for plan in plans)) > 0)):
        here = slice(begin, end)
        for _ in range(3):
            pull = [_refusal(leg, plan, before, shift, here) for leg, plan in zip(legs, plans, strict=True)]
            shift[here] = _smooth_shift(pull, shift[here], smooth, begin > 0, end < len(before))
    return shift, ()


def _refusal(leg: Leg, plan: FootPlan, before: Floats, shift: Floats, here: slice) -> tuple[Floats, Floats, Floats]:
    """Direction from hip to goal (n, 3), distance the knee refuses (n,) m, weight (n,)."""
    hip, knee, ankle = before[here, leg.hip], before[here, leg.knee], before[here, leg.ankle]
    way = plan.ankle[here] - hip - shift[here]
    asked = np.linalg.norm(way, axis=1)
    return way / asked[:, None], asked - _damped_reach(hip, knee, ankle, asked), plan.firmness[here]


def _damped_reach(hip: Floats, knee: Floats, ankle: Floats, asked: Floats) -> Floats:
    """(n,) m, the distance from hip to ankle after a knee damped near extension turns towards `asked` (section 4.4)."""
    thigh, shank = np.linalg.norm(knee - hip, axis=1), np.linalg.norm(ankle - knee, axis=1)
    was = _knee_angle(np.linalg.norm(ankle - hip, axis=1), thigh, shank)
    turned = was + _free_turn(_knee_angle(asked, thigh, shank)) - _free_turn(was)
    return np.asarray(np.sqrt(thigh**2 + shank**2 - 2 * thigh * shank * np.cos(np.clip(turned, 0.0, np.pi))))


def _knee_angle(distance: Floats, thigh: Floats, shank: Floats) -> Floats:
    """Angle between thigh and shank (rad, pi = straight) that puts hip and ankle this far apart."""
    cosine = (thigh**2 + shank**2 - distance**2) / (2 * thigh * shank)
    return np.asarray(np.arccos(np.clip(cosine, -1.0, 1.0)))


def _free_turn(angle: Floats) -> Floats:
    """Integral from 0 to `angle` of the knee's damping: 1 up to FREE_KNEE, then alpha down to 0 at pi (section 4.4)."""
    u = np.clip((angle - FREE_KNEE) / (np.pi - FREE_KNEE), 0.0, 1.0)
    return np.asarray(np.minimum(angle, FREE_KNEE) + (np.pi - FREE_KNEE) * (u**4 / 2 - u**3 + u))


def _smooth_shift(
    pull: Sequence[tuple[Floats, Floats, Floats]], shift: Floats, smooth: float, rises: bool, falls: bool
) -> Floats:
    """The least-squares shift (n, 3); it starts from and returns to 0 where the span has frames around it."""
    from scipy.linalg import solveh_banded

    frames = len(shift)
    band = np.zeros((7, frames, 3))  # lower band: entry [k, t, i] couples unknown 3t+i with 3t+i+k
    right = np.zeros((frames, 3))
    band[0] += ROOT_REST
    for way, miss, weight in pull:
        goal = miss + (way * shift).sum(axis=1)
        right += (weight * goal)[:, None] * way
        for k in range(3):
            for i in range(3 - k):
                band[k, :, i] += weight * way[:, i] * way[:, i + k]
    # the first of three frames each; the middle one accelerates
    first = np.arange(-2 if rises else 0, frames if falls else frames - 2)
    for a, one in enumerate((1.0, -2.0, 1.0)):
        for b, two in list(enumerate((1.0, -2.0, 1.0)))[a:]:
            inside = (first + a >= 0) & (first + b < frames)
            np.add.at(band[3 * (b - a)], first[inside] + a, smooth**4 * one * two)
    return np.asarray(solveh_banded(band.reshape(7, -1), right.reshape(-1), lower=True).reshape(frames, 3))


def _root_axes(body: Skeleton) -> tuple[Ints, Floats] | None:
    """The root's three translations that act in the world's axes: DOF rows and axes (3, 3); None without."""
    rows = body.dofs_of(0)
    turning = np.flatnonzero(body.dof_kind[rows] == ROTATION)
    rows = rows[: turning[0]] if len(turning) else rows
    rows = rows[body.dof_kind[rows] == TRANSLATION]
    if len(rows) != 3 or abs(np.linalg.det(body.dof_axis[rows])) < 1e-6:
        return None
    return rows, np.asarray(body.dof_axis[rows])


def _move_root(body: Skeleton, q: Floats, shift: Floats, rows: Ints) -> Floats:
    """A writeable copy of the poses (T, D) with the root moved by `shift` (T, 3) m in the frames `rows`."""
    moved = q.copy()
    axes = _root_axes(body)
    if axes is not None:
        moved[np.ix_(rows, axes[0])] += shift[rows] @ np.linalg.inv(axes[1])
    return moved


# --- Section 4.4: the legs --------------------------------------------------------------------------------------------


def _bend(
    body: Skeleton,
    leg: Leg,
    plan: FootPlan,
    before: Floats,
    turns: Floats,
    shift: Floats,
    rows: Ints,
    q: Floats,
    fps: float,
) -> Floats:
    """Poses (n, D) whose ankle and ball are where the plan wants them.

    The knee's place follows from the two bones in closed form; it leads the joint angles to the right bend, and they
    are then settled on ankle and ball alone. The toes keep their direction in the world.
    """
    if not len(rows):
        return q
    hip = before[rows, leg.hip] + shift[rows]
    thigh = np.linalg.norm(before[rows, leg.knee] - before[rows, leg.hip], axis=1)
    shank = np.linalg.norm(before[rows, leg.ankle] - before[rows, leg.knee], axis=1)
    way = plan.ankle[rows] - hip
    asked = np.linalg.norm(way, axis=1)
    # A held foot is reached as far as the leg goes; on the way in and out the knee's damping comes first.
    near, full = NEARLY_STRAIGHT * (thigh + shank), STRAIGHT * (thigh + shank)
    stretched = near + (full - near) * -np.expm1(-np.maximum(asked - near, 0.0) / (full - near))
    damped = _damped_reach(before[rows, leg.hip], before[rows, leg.knee], before[rows, leg.ankle], asked)
    was = np.linalg.norm(before[rows, leg.ankle] - before[rows, leg.hip], axis=1)
    firm = plan.firmness[rows]
    reached = firm * np.minimum(asked, stretched) + (1 - firm) * damped
    reached = _without_pops(reached, was, thigh, shank, firm, rows, POP * fps)
    way /= asked[:, None]
    ankle = hip + way * reached[:, None]
    ball = plan.ball[rows] + ankle - plan.ankle[rows]
    knee = _knee_place(leg, before, turns, rows, hip, way, reached, thigh, shank, firm)
    joints, goals = [leg.knee, leg.ankle], [knee, ankle]
    if leg.ball >= 0:
        joints, goals = [*joints, leg.ball], [*goals, ball]
    led = solve(body, q, joints, np.stack(goals, axis=1), rest_weight=TURN_COST, movable=leg.dofs)
    bent = solve(body, led.q, joints[1:], np.stack(goals[1:], axis=1), rest_weight=TURN_COST, movable=leg.dofs).q
    if len(leg.toe_dofs):
        tip = positions(body, bent)[:, leg.ball] + before[rows, leg.tip] - before[rows, leg.ball]
        bent = solve(body, bent, [leg.tip], tip[:, None], movable=leg.toe_dofs).q
    return bent


def _without_pops(
    reached: Floats, was: Floats, thigh: Floats, shank: Floats, firm: Floats, rows: Ints, reach: float
) -> Floats:
    """Distances (n,) m from hip to ankle, the knee's change averaged over `reach` frames the more the straighter it is.

    There a millimetre of distance is ten degrees of knee: giving up the one on a few frames spares the other.
    """
    angle, old = _knee_angle(reached, thigh, shank), _knee_angle(was, thigh, shank)
    change = np.zeros(rows[-1] - rows[0] + 1)
    change[rows - rows[0]] = angle - old
    kernel = np.hanning(2 * max(1, round(reach)) + 1)
    smooth = old + np.convolve(change, kernel / kernel.sum(), mode="same")[rows - rows[0]]
    u = np.clip((np.maximum(angle, old) - BENT) / (np.pi - BENT), 0.0, 1.0)
    share = 1 - firm * (1 - 3 * u**2 + 2 * u**3)
    mixed = np.clip(angle + share * (smooth - angle), 0.0, np.pi)
    return np.asarray(np.sqrt(thigh**2 + shank**2 - 2 * thigh * shank * np.cos(mixed)))


def _knee_place(
    leg: Leg,
    before: Floats,
    turns: Floats,
    rows: Ints,
    hip: Floats,
    way: Floats,
    distance: Floats,
    thigh: Floats,
    shank: Floats,
    firmness: Floats,
) -> Floats:
    """(n, 3) m, the knee of a leg from `hip` along `way`, bent to the side to which this clip's knee bends.

    A leg that was recorded bent backwards (a straight knee and noise) is brought over as the foot's hold grows firm.
    """
    upper, lower = before[:, leg.knee] - before[:, leg.hip], before[:, leg.ankle] - before[:, leg.knee]
    bends = np.cross(upper, lower)
    axis = np.nanmean(np.einsum("tji,tj->ti", turns[:, leg.hip], bends), axis=0)
    axis /= max(float(np.linalg.norm(axis)), 1e-12)
    hinge = turns[rows, leg.hip] @ axis
    ahead = np.cross(way, hinge)
    ahead /= np.maximum(np.linalg.norm(ahead, axis=1, keepdims=True), 1e-12)
    along = (distance**2 + thigh**2 - shank**2) / (2 * distance)
    out = np.sqrt(np.maximum(thigh**2 - along**2, 0.0))
    flexion = np.arcsin(np.clip(np.einsum("ti,ti->t", bends[rows], hinge) / (thigh * shank), -1.0, 1.0))
    forward_side = np.clip(flexion / (2 * BACKWARDS) + 0.5, 0.0, 1.0)
    out = out * (forward_side + (1 - forward_side) * (2 * firmness - 1))
    return np.asarray(hip + along[:, None] * way + out[:, None] * ahead)
