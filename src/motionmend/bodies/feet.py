"""Feet: which joints or markers they are, when they stand on the floor, and how much they slide while they do."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ..arrays import Bools, Floats, Ints, runs
from ..errors import MismatchError
from .skeleton import ROTATION, Skeleton, rest_positions

ANKLES = ("ankle", "foot")
TOES = ("toes", "toebase", "toe", "ball", "forefoot", "footindex", "bigtoe")
MARKERS = (
    "ank|ankle|lma|mma|lmal|mmal|hee|heel|hel|cal|calc|calcaneus|toe|toetip|bigtoe|smalltoe|hallux|"
    "mt\\d?|\\dmt|mtp?\\d?|d\\dmt|met\\d|\\dmet|p\\dmt|lateralfoot|medialfoot|posteriorfoot|latfoot|medfoot|"
    "footindex|foot"
)
# A planted foot of a clean recording moves at less than 0.1 m/s (joint centres wander as the skin does), a swinging one
# at 1 to 4 m/s; between them lies rolling over heel and toes. A foot counts as standing once it is slower than LANDED
# and until it is faster than LEFT.
LANDED, LEFT = 0.2, 0.4  # m/s
# This holds for rising and for gliding alike. Noise moves planted feet too: the limits rise with the speed at which the
# clip's low feet mostly move, LANDED to twice that speed, but no further than the slowest swing.
SLOWEST_SWING = 0.9  # m/s
# How far above its own lowest level, the height at which it stands, a point may be to land and to stay. A heel is
# 0.03 m up soon after it has left the floor; floors and skeleton fits vary by 0.02 m.
LOW, STILL_LOW = 0.03, 0.04  # m
# A point whose lowest level lies this far above that of the lowest point never stands: ankles lie 0.06 to 0.12 m up.
NEVER_DOWN = 0.2  # m
# The shortest contact and the shortest pause in one. Sprinters' feet stand for 0.09 s.
SHORTEST = 0.08  # s
# Speeds are slopes over this time: one step either way at 30 Hz, long enough at 120 Hz for jitter to average out.
SPEED_SPAN = 1 / 15  # s
# Skate is measured on steps of this length, within a contact, so that it means the same at every frame rate.
SKATE_STEP = 1 / 30  # s

RIG = re.compile(r"^(?:mixamorig\d*|bip\d*|valvebiped|armature|def|jnt|bone)(?=[lr])")


@dataclass(frozen=True)
class Feet:
    """The legs of a skeleton as joint indices, left before right; -1 where the skeleton has no such joint.

    Attributes
    ----------
    hips, knees, ankles : (2,) where thigh, shank and foot begin.
    toes : (2,) the ball of the foot, where the toes begin.
    ends : (2,) the tip of the toes.
    guesses : one sentence for each thing the names did not say.
    """

    hips: tuple[int, int]
    knees: tuple[int, int]
    ankles: tuple[int, int]
    toes: tuple[int, int]
    ends: tuple[int, int]
    guesses: tuple[str, ...] = ()

    @property
    def joints(self) -> Ints:
        """(P,) left ankle, left toes, right ankle, right toes, as far as the skeleton has them."""
        both = [joint for side in (0, 1) for joint in (self.ankles[side], self.toes[side]) if joint >= 0]
        return np.array(both, dtype=np.int64)


@dataclass(frozen=True)
class FootMarkers:
    """The markers on the feet and ankles of each side, indices into the names given."""

    left: tuple[int, ...]
    right: tuple[int, ...]

    @property
    def markers(self) -> Ints:
        """(P,) left, then right."""
        return np.array(self.left + self.right, dtype=np.int64)


def foot_joints(skeleton: Skeleton) -> Feet:
    """Find the legs by the joints' names, or failing that as the two lowest chain ends at rest.

    Parameters
    ----------
    skeleton : any body; the names of CMU (`lfoot`, `ltoes`), of the usual BVH rigs (`LeftFoot`, `LeftToeBase`,
        `LeftAnkle`, `lFoot`, `Foot_L`, `mixamorig:LeftFoot`), of SMPL (`L_Ankle`, `L_Foot`) and of sensors
        (`AnkleLeft`, `FootLeft`) are known.

    Raises
    ------
    MismatchError : a body without two chain ends, which has no feet.
    """
    ankles, toes = _named_feet(skeleton)
    guesses: tuple[str, ...] = ()
    if min(ankles) < 0:
        ankles = _lowest_ends(skeleton)
        toes = (first_child(skeleton, ankles[0]), first_child(skeleton, ankles[1]))
        guesses = (
            f"no joint is named as an ankle: the two lowest chain ends at rest are taken as feet, left "
            f"'{skeleton.names[ankles[0]]}', right '{skeleton.names[ankles[1]]}'",
        )
    ends = tuple(first_child(skeleton, toe) if toe >= 0 else -1 for toe in toes)
    shared = set(upwards(skeleton, ankles[0])) & set(upwards(skeleton, ankles[1]))
    knees, hips = [-1, -1], [-1, -1]
    for side in (0, 1):
        path = [joint for joint in upwards(skeleton, ankles[side]) if joint not in shared]
        knees[side], hips[side] = _knee_and_hip(skeleton, path)
    return Feet(
        hips=(hips[0], hips[1]),
        knees=(knees[0], knees[1]),
        ankles=ankles,
        toes=toes,
        ends=(ends[0], ends[1]),
        guesses=guesses,
    )


def foot_markers(names: Sequence[str]) -> FootMarkers:
    """Find the markers on feet and ankles by their names.

    Parameters
    ----------
    names : (M,) as the file spells them; `subject:LHEE`, `LANK`, `LTOE`, `LMT5`, `L.Heel`, `L_Foot_1MT` and the like.

    Returns
    -------
    FootMarkers : empty sides where nothing is named so.
    """
    found: dict[str, list[int]] = {"l": [], "r": []}
    for index, name in enumerate(names):
        for side, part in named_sides(name):
            if re.fullmatch(MARKERS, part) or re.fullmatch(f"foot(?:{MARKERS})", part):
                found[side].append(index)
                break
    return FootMarkers(tuple(found["l"]), tuple(found["r"]))


def _named_feet(skeleton: Skeleton) -> tuple[tuple[int, int], tuple[int, int]]:
    """Ankles and toes by name, left and right; -1 where there is none."""
    by_side: dict[str, dict[str, int]] = {"l": {}, "r": {}}
    for joint, name in enumerate(skeleton.names):
        for side, part in named_sides(name):
            if part in ANKLES + TOES:
                by_side[side].setdefault(part, joint)
                break
    ankles, toes = [-1, -1], [-1, -1]
    for index, side in enumerate("lr"):
        parts = by_side[side]
        # SMPL and the sensors say ankle, then foot; the animation rigs say foot, then toes.
        ankles[index] = parts.get("ankle", parts.get("foot", -1))
        named = [parts[part] for part in TOES if part in parts]
        named += [parts["foot"]] if "ankle" in parts and "foot" in parts else []
        below = [joint for joint in named if ankles[index] in upwards(skeleton, joint)[1:]]
        toes[index] = below[0] if below else first_child(skeleton, ankles[index])
    return (ankles[0], ankles[1]), (toes[0], toes[1])


def named_sides(name: str) -> list[tuple[str, str]]:
    """What a name may say: ('l' or 'r', the rest of it in small letters), most literal first."""
    plain = re.sub(r"[^a-z0-9]", "", name.rsplit(":", 1)[-1].lower())
    plain = RIG.sub("", re.sub(r"(?:joint|bone|jnt)$", "", plain))
    readings = []
    for word, side in (("left", "l"), ("right", "r"), ("l", "l"), ("r", "r")):
        if plain.startswith(word):
            readings.append((side, plain[len(word) :]))
        # A lone letter at the end is a side only where it stands apart: Foot_L and FootL, not Heel.
        if plain.endswith(word) and (len(word) > 1 or re.search(r"(?:[ ._-][lrLR]|[a-z][LR])$", name)):
            readings.append((side, plain[: -len(word)]))
    return readings


def upwards(skeleton: Skeleton, joint: int) -> list[int]:
    """The joint and all above it, root last."""
    path = []
    while joint >= 0:
        path.append(joint)
        joint = int(skeleton.parents[joint])
    return path


def first_child(skeleton: Skeleton, joint: int) -> int:
    """The first joint below that lies elsewhere, -1 where there is none."""
    if joint < 0:
        return -1
    for below in np.flatnonzero(skeleton.parents == joint):
        if np.linalg.norm(skeleton.offsets[below]) > 1e-6:
            return int(below)
        deeper = first_child(skeleton, int(below))
        if deeper >= 0:
            return deeper
    return -1


def _knee_and_hip(skeleton: Skeleton, path: list[int]) -> tuple[int, int]:
    """Knee and hip on the path up from the ankle: the turning joints with a long bone below them.

    Rigs put twist joints along the shank and fixed or idle joints between pelvis and thigh; a bone of a leg is
    longer than a fifth of the leg.
    """
    rest = rest_positions(skeleton)
    length = sum(float(np.linalg.norm(rest[a] - rest[b])) for a, b in pairwise(path))
    found = [path[0]]
    for joint in path[1:]:
        turns = np.any(skeleton.dof_kind[skeleton.dofs_of(joint)] == ROTATION)
        if turns and np.linalg.norm(rest[joint] - rest[found[-1]]) > 0.2 * length:
            found.append(joint)
    return (found[1] if len(found) > 1 else -1), (found[2] if len(found) > 2 else -1)


def _lowest_ends(skeleton: Skeleton) -> tuple[int, int]:
    """Ankles, left and right, of the two legs that reach lowest at rest."""
    rest = rest_positions(skeleton)
    height = rest @ skeleton.up
    leaves = [joint for joint in range(len(skeleton.names)) if joint not in set(skeleton.parents.tolist())]
    leaves.sort(key=lambda joint: (height[joint], joint))
    legs: list[list[int]] = []
    for leaf in leaves:
        path = upwards(skeleton, leaf)
        # A second toe of the same foot shares most of its path; the other leg leaves it at the pelvis.
        alone = [[joint for joint in path if joint not in other] for other in legs]
        if all(sum(np.linalg.norm(skeleton.offsets[list(own)], axis=1)) > 0.3 * np.ptp(height) for own in alone):
            legs.append(path)
        if len(legs) == 2:
            break
    if len(legs) < 2:
        raise MismatchError(f"feet need a body with two legs, came one of {len(leaves)} chain ends that has none")
    shared = set(legs[0]) & set(legs[1])
    ankles = []
    for path in legs:
        own = [joint for joint in path if joint not in shared]
        longest = sorted(own, key=lambda joint: -float(np.linalg.norm(skeleton.offsets[joint])))[:2]
        ankles.append(min(longest, key=own.index))  # the lower of the two long bones, shank and thigh, ends there
    toes = [first_child(skeleton, ankle) for ankle in ankles]
    forward = sum((rest[toe] - rest[ankle] for ankle, toe in zip(ankles, toes, strict=True) if toe >= 0), np.zeros(3))
    forward = forward - skeleton.up * (skeleton.up @ forward)
    left = np.cross(skeleton.up, forward) if np.linalg.norm(forward) > 1e-6 else np.array([1.0, 0.0, 0.0])
    first, second = sorted(ankles, key=lambda ankle: -float(rest[ankle] @ left))
    return first, second


def contacts(positions: Floats, fps: float, up: Floats) -> Bools:
    """When each point of the feet stands on the floor: low for this clip and slow, for long enough.

    The floor is found in the clip itself, as a plane under the slow low points that may be tilted a little where the
    clip walks far enough to tell (recordings' floors are off by up to 0.03 m a step), and each point has its own
    height above it. Contact begins below one limit of height and speed and ends above a higher one.

    Parameters
    ----------
    positions : (T, P, 3) m, joints or markers of the feet, NaN = missing.
    fps : Hz.
    up : (3,) unit vector against gravity.

    Returns
    -------
    (T, P) True while in contact; False where the point is missing.
    """
    positions = _checked(positions)
    seen = np.isfinite(positions).all(axis=2)
    if not seen.any():
        return np.zeros(seen.shape, dtype=bool)
    velocity = _velocities(positions, fps)
    rising = np.abs(velocity @ up)
    gliding = np.linalg.norm(velocity - (velocity @ up)[..., None] * up, axis=2)
    height = _heights(positions, np.hypot(rising, gliding), up)
    known = seen & np.isfinite(rising)
    low: Bools = known & (height < LOW)
    sure: Bools = low
    maybe: Bools = known & (height < STILL_LOW)
    for speed in (rising, gliding):
        usual = float(np.median(speed[low])) if low.any() else 0.0
        landed = float(np.clip(2 * usual, LANDED, SLOWEST_SWING / 1.5))
        sure = sure & (speed < landed)
        maybe = maybe & (speed < min(landed * LEFT / LANDED, SLOWEST_SWING))
    shortest = max(2, round(SHORTEST * fps))
    standing = np.zeros(seen.shape, dtype=bool)
    for point in range(positions.shape[1]):
        standing[:, point] = _steady(sure[:, point], maybe[:, point], shortest)
    return standing & seen


def skate(positions: Floats, fps: float, up: Floats) -> float:
    """Mean horizontal speed in m/s of the points of the feet while in contact, by the contacts of this very motion.

    Parameters and the NaN for a clip without contact: as in `contacts` and `skate_during`.
    """
    return skate_during(positions, contacts(positions, fps, up), fps, up)


def skate_during(positions: Floats, standing: Bools, fps: float, up: Floats) -> float:
    """Mean horizontal speed in m/s during given contacts, so that a repair can be judged by the truth's contacts.

    Parameters
    ----------
    positions : (T, P, 3) m, NaN = missing.
    standing : (T, P) True while in contact.
    fps : Hz.
    up : (3,) unit vector against gravity.

    Returns
    -------
    float : lower is better, 0 for feet that do not move; NaN where nothing stays in contact for 1/30 s.

    Raises
    ------
    MismatchError : contacts that do not fit the positions.
    """
    positions = _checked(positions)
    if np.shape(standing) != positions.shape[:2]:
        raise MismatchError(f"contacts must be {positions.shape[:2]} like the positions, came {np.shape(standing)}")
    step = max(1, round(SKATE_STEP * fps))
    frames = len(positions)
    if frames <= step:
        return float("nan")
    held = np.ones((frames - step, positions.shape[1]), dtype=bool)
    for lag in range(step + 1):
        held &= standing[lag : frames - step + lag]
    moved = positions[step:] - positions[:-step]
    level = moved - (moved @ up)[..., None] * up
    speeds = np.linalg.norm(level, axis=2)[held] * fps / step
    speeds = speeds[np.isfinite(speeds)]
    return float(speeds.mean()) if len(speeds) else float("nan")


def _checked(positions: Floats) -> Floats:
    if np.ndim(positions) != 3 or np.shape(positions)[2] != 3:
        raise MismatchError(f"feet need (frames, points, 3) positions, came {np.shape(positions)}")
    return np.asarray(positions, dtype=np.float64)


def _velocities(positions: Floats, fps: float) -> Floats:
    """(T, P, 3) m/s, least-squares slope over SPEED_SPAN; NaN where fewer than two samples are seen."""
    reach = max(1, round(SPEED_SPAN / 2 * fps))
    frames = len(positions)
    padded = np.pad(positions, ((reach, reach), (0, 0), (0, 0)), constant_values=np.nan)
    seen: Bools = np.asarray(np.isfinite(padded).all(axis=2))
    padded = np.where(seen[..., None], padded, 0.0)
    count, sum_t, sum_tt = (np.zeros(positions.shape[:2]) for _ in range(3))
    sum_x, sum_tx = np.zeros(positions.shape), np.zeros(positions.shape)
    for lag in range(-reach, reach + 1):
        here = slice(reach + lag, reach + lag + frames)
        x, known = padded[here], seen[here]
        count += known
        sum_t += lag * known
        sum_tt += lag * lag * known
        sum_x += x
        sum_tx += lag * x
    spread = count * sum_tt - sum_t**2
    slope = np.divide(
        count[..., None] * sum_tx - sum_t[..., None] * sum_x,
        spread[..., None],
        out=np.full(positions.shape, np.nan),
        where=spread[..., None] > 0,
    )
    return np.asarray(slope * fps)


def _heights(positions: Floats, speed: Floats, up: Floats) -> Floats:
    """(T, P) m above the level at which each point stands; inf for a point that never comes down, NaN if missing."""
    across = np.linalg.svd(up[None, :])[2][1:]  # two level directions
    height = positions @ up
    level = positions @ across.T
    seen = np.isfinite(height)
    level = level - np.nanmedian(level[seen], axis=0)
    slow = seen & (np.nan_to_num(speed, nan=np.inf) < SLOWEST_SWING)
    tilt = np.zeros(2)
    for _ in range(5):
        flat = height - level @ tilt
        lowest = _levels(flat, slow if slow.any() else seen)
        above = flat - lowest
        standing = slow & (np.abs(above) < STILL_LOW)
        tilt = _tilt(level, height - lowest, standing)
    flat = height - level @ tilt
    lowest = _levels(flat, slow if slow.any() else seen)
    never = lowest > np.nanmin(lowest) + NEVER_DOWN
    return np.asarray(np.where(never & seen, np.inf, flat - lowest))


def _levels(height: Floats, usable: Bools) -> Floats:
    """(P,) m, the height at which each point stands: the middle of its lowest slow heights, inf where it has none."""
    levels = np.full(height.shape[1], np.inf)
    for point in range(height.shape[1]):
        slow = height[usable[:, point], point]
        if len(slow):
            levels[point] = np.median(slow[slow <= np.quantile(slow, 0.02) + LOW])
    return levels


def _tilt(level: Floats, height: Floats, standing: Bools) -> Floats:
    """(2,) slope of the floor along the two level directions, m/m; drawn to 0 unless the clip shows otherwise.

    Each sample counts with 0.02 m of its own, a slope with 0.02; frames of one stand are not independent, so that all
    samples together count as 20.
    """
    place, rise = level[standing], height[standing]
    if len(rise) < 10:
        return np.zeros(2)
    share = min(1.0, 20 / len(rise)) / 0.02**2
    centred = place - place.mean(axis=0)
    normal = share * centred.T @ centred + np.eye(2) / 0.02**2
    return np.asarray(np.linalg.solve(normal, share * centred.T @ (rise - rise.mean())))


def _steady(sure: Bools, maybe: Bools, shortest: int) -> Bools:
    """Runs of `maybe` that hold a `sure` frame, with pauses shorter than `shortest` closed, then short runs dropped."""
    state = maybe.copy()
    for begin, end in runs(maybe):
        state[begin:end] = sure[begin:end].any()
    for begin, end in runs(~state):
        if begin > 0 and end < len(state) and end - begin < shortest:
            state[begin:end] = True
    for begin, end in runs(state):
        state[begin:end] = end - begin >= shortest
    return state
