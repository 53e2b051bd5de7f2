"""The connected surfaces of a depth image, which of them is most like a body, and which hang together with it."""

from dataclasses import dataclass
from typing import TypeAlias, final

import numpy as np
from numpy.typing import NDArray

from ...arrays import Bools, Floats, Ints, Singles
from .room import NOISE_NEAR, NOISE_STEEP, Scene

Labels: TypeAlias = NDArray[np.int32]

# Neighbouring pixels of one limb differ by its slope and by noise, of two limbs by more than a hand's thickness.
JUMP_NEAR, JUMP_STEEP = 0.05, 0.004

# What a body may measure, in m and m^2 as seen from one side, from a seated child to a tall man in a coat.
LONGEST, SHORTEST = 2.5, 0.55
LARGEST, SMALLEST = 1.8, 0.04
USUAL_AREA, ARM_AREA = 0.5, 0.06
SOMEBODY = 0.1  # m^2, a fifth of a body

STEP = 0.15  # m, that a surface comes nearer or goes away from one frame to the next
MOVES = 50.0  # times more like a person is what is before a known background
STRANGE = 0.02  # of its likeness that a passer's surface keeps
BOTH, EACH, HIGH = 0.6, 0.2, 0.9  # m² of two people beside each other, m² of each and m that each is high, at least
_REACH = 0.35  # m, between two pieces of one body
_ARM = 0.5  # m, between a body and a forearm that moves, the upper arm being hidden
_HIDES = 0.15  # m, nearer than the person was
_IN_SIGHT = 0.5  # share of the person's pixels that a surface which they are one with a passer in has at least
_COVERED = 0.5  # share of the person's pixels with something nearer before them, from which on they are hidden
# Of normal noise |z - 2 z' + z''| is the standard deviation times this on average; half as much again for what
# neighbours share.
_OF_BENDS = 1.5 * float(np.sqrt(np.pi / 12.0))


@final
@dataclass(frozen=True, eq=False)
class Surfaces:
    """S connected surfaces of one frame.

    Attributes
    ----------
    labels : (H, W) number of the surface, -1 = none.
    measures : (S, 14) of each, see `regions.measures`.
    clouds : points (N, 3) in m of those large enough to count.
    likeness : of the same, how much each is like a body by its shape; 0 = not at all.
    known, elsewhere : (S,) share of each that was the person's when they were last seen, and a passer's just now.
    """

    labels: Labels
    measures: Floats
    clouds: dict[int, Floats]
    likeness: dict[int, float]
    known: Floats
    elsewhere: Floats

    def pixels_of(self, some: list[int]) -> Bools:
        """(H, W) True on some of them."""
        keep = np.zeros(len(self.measures) + 1, bool)  # the last for pixels of no surface
        keep[some] = True
        return np.asarray(keep.take(self.labels))


def surfaces_of(scene: Scene, depth: Singles, before: Bools, intrinsics: Floats) -> Surfaces:
    """The surfaces of what is before the room.

    Parameters
    ----------
    scene : the room as known so far.
    depth : (H, W) m.
    before : (H, W) True where something is nearer than floor, walls and the background.
    intrinsics : (4,) fx, fy, cx, cy in px.
    """
    from ...kernels import regions

    labels = np.empty(depth.shape, np.int32)
    count = regions.surfaces(depth, before, JUMP_NEAR, JUMP_STEEP, labels)
    count = _parted(depth, labels, count, scene, intrinsics)
    measures = np.empty((count, 14))
    # Where the background was taken away there is no furniture either.
    moved = (before if scene.window is not None else before & np.isfinite(scene.background)).view(np.uint8)
    regions.measures(depth, labels, moved, intrinsics, measures)
    size = measures[:, 1]
    large = np.flatnonzero((size > 0.0005) & (measures[:, 0] >= 8))  # a noisy camera's frame has thousands of specks
    order = large[np.argsort(-size[large], kind="stable")[:24]]
    clouds = _clouds(depth, labels, measures, order, intrinsics)
    known, elsewhere = (_shared(depth, labels, measures[:, 0], there) for there in (scene.person, scene.others))
    # Noise hides the relief of who is far away, and arms raised make tall ones longer: who was a moment ago, and surely
    # was no furniture, has not become a board. What is left in sight of who is being hidden may be as flat as one.
    theirs = scene.alive & (known > 0.5) & (size > 0.5 * USUAL_AREA)
    likeness = {s: _likeness(measures[s], cloud, theirs=bool(theirs[s])) for s, cloud in clouds.items()}
    return Surfaces(labels, measures, clouds, likeness, known, elsewhere)


def most_like_a_body(seen: Surfaces, alive: bool, strange: Bools, last: Floats | None) -> int:
    """The surface that is most likely the person, or the largest piece of them; -1 = nobody is there.

    Parameters
    ----------
    seen : the surfaces.
    alive : whether who was last seen is no furniture.
    strange : (S,) those of passers.
    last : (3,) m, where the person was, if known.
    """
    best, most = -1, 0.0
    for s, like in seen.likeness.items():
        # What moves before a known background is no furniture, nor is who did so before.
        moves = max(seen.measures[s, 11], seen.known[s]) if alive else seen.measures[s, 11]
        score = like * (1.0 + MOVES * moves) * (STRANGE if strange[s] else 1.0)
        if last is not None and np.isfinite(last).all():
            gap = float(np.min(np.linalg.norm(seen.clouds[s] - last, axis=1)))
            score *= 0.1 + 0.9 / (1.0 + (gap / 0.5) ** 2)
        if score > most:
            best, most = s, float(score)
    return best if best >= 0 else _largest_piece(seen, strange)


def _largest_piece(seen: Surfaces, strange: Bools) -> int:
    """The piece most like a body, none of which is long enough for one, where the person was a moment ago and pieces
    that hang together are: an arm across it cuts a child's body in two. -1 = there is none."""
    best, most = -1, 0.0
    for s in np.flatnonzero((seen.known > 0.5) & ~strange).tolist():
        like = _likeness(seen.measures[s], seen.clouds[s], shortest=0.0) if s in seen.clouds else 0.0
        if like > most:
            lows, highs = (seen.measures[joined(s, seen, strange), k : k + 4 : 2] for k in (2, 3))
            if (highs.max(axis=0) - lows.min(axis=0)).max() >= SHORTEST:
                best, most = s, like
    return best


def hidden(depth: Singles, person: Singles | None) -> bool:
    """Whether something stands before the place where the person was last seen.

    Parameters
    ----------
    depth : (H, W) m. person : (H, W) m, NaN beside; None = never seen.
    """
    if person is None:
        return False
    there = np.isfinite(person)
    with np.errstate(invalid="ignore"):
        return bool(np.mean(depth[there] < person[there] - _HIDES) > _COVERED)


def two_bodies(one: Floats, other: Floats) -> bool:
    """Whether two surfaces, `measures` (14,) of each, are a body's each, seen beside each other.

    An arm before somebody cuts them in two across, and neither half is high; a post does from top to bottom, and both
    together are one body at most.
    """
    areas, highs = (one[1], other[1]), (one[5] - one[4], other[5] - other[4])
    return bool(min(areas) > EACH and sum(areas) > BOTH and min(highs) > HIGH)


def joined(main: int, seen: Surfaces, strange: Bools) -> list[int]:
    """The surfaces that belong to a body one of which is `main`.

    Parameters
    ----------
    main : number of its surface.
    seen : the surfaces.
    strange : (S,) True for those of somebody else, which are left out.
    """
    from scipy.spatial import cKDTree

    clouds, measures, known = seen.clouds, seen.measures, seen.known
    size, lows, highs = measures[:, 1], measures[:, 2:8:2], measures[:, 3:9:2]
    kept, low, high, total = [main], lows[main], highs[main], size[main]
    gaps = {s: np.inf for s in clouds if s != main and not strange[s]}
    newest = main
    while gaps:
        tree = cKDTree(clouds[newest])
        for s in gaps:
            apart = np.maximum(lows[s] - highs[newest], lows[newest] - highs[s])
            if apart.max() < _ARM:
                gap, _ = tree.query(clouds[s], distance_upper_bound=_ARM)
                gaps[s] = min(gaps[s], float(np.min(gap)))
        fitting = []
        for s, gap in gaps.items():
            # A limb behind or before another one is apart by less than an arm's length, and small.
            was = known[s] > 0.5
            arm = measures[s, 11] > 0.5 and size[s] < ARM_AREA
            # So is the other half of who moves fast, which was not there a moment ago: both are one body at most.
            piece = size[s] < max(0.25 * size[main], ARM_AREA)
            piece |= measures[s, 11] > 0.5 and total + size[s] < USUAL_AREA
            near = gap < (_ARM if arm or was else _REACH if piece else 0.12)
            wide = (np.maximum(high, highs[s]) - np.minimum(low, lows[s])).max()
            # Where the person walks over known ground, a piece that has always been there is none of theirs.
            stays = measures[main, 11] > 0.5 > measures[s, 11] and not was
            # Of two that are alike in size one is somebody else, unless both are halves of one: an arm across the
            # body cuts it in two.
            half = was or size[s] < 0.6 * size[main] or total + size[s] < USUAL_AREA
            if near and not stays and half and total + size[s] < LARGEST and wide < LONGEST:
                fitting.append((gap, s))
        if not fitting:
            break
        newest = min(fitting)[1]
        del gaps[newest]
        kept.append(newest)
        total += size[newest]
        low, high = np.minimum(low, lows[newest]), np.maximum(high, highs[newest])
    return kept


def about(box: Ints, shape: tuple[int, ...], margin: int) -> tuple[slice, slice]:
    """Rows and columns of a box and a margin about it, as far as they are within an image.

    Parameters
    ----------
    box : (4,) px, first and last row, first and last column, as `regions.extent` writes it; (0, -1, 0, -1) = empty.
    shape : (H, W) px, of the image.
    margin : px on every side; an empty box has none.
    """
    if box[1] < box[0]:
        return slice(0, 0), slice(0, 0)
    return (
        slice(max(int(box[0]) - margin, 0), min(int(box[1]) + margin + 1, shape[0])),
        slice(max(int(box[2]) - margin, 0), min(int(box[3]) + margin + 1, shape[1])),
    )


def box_of(inside: Bools, shape: tuple[int, ...], margin: int) -> tuple[slice, slice]:
    """Rows and columns that hold all of `inside` (H, W) and a margin in px, within an image of `shape` (H, W)."""
    rows, columns = np.flatnonzero(inside.any(axis=1)), np.flatnonzero(inside.any(axis=0))
    box = (rows[0], rows[-1], columns[0], columns[-1]) if len(rows) else (0, -1, 0, -1)
    return about(np.array(box), shape, margin)


def _parted(depth: Singles, labels: Labels, count: int, scene: Scene, intrinsics: Floats) -> int:
    """Give what was a passer's a moment ago, or a door's, a number of its own where it touches the person.

    All of such a surface passed for the passer's, and nobody was followed, or for the person's, whose body explains no
    two. How many surfaces there are then; `labels`, of `count` of them, is written.
    """
    if scene.person is None or scene.others is None or not (scene.vouched and count):
        return count
    with np.errstate(invalid="ignore"):
        theirs = (labels >= 0) & (np.abs(depth - scene.others) < STEP)
        # Who is hidden was last seen some time ago; passers are those of the last frame.
        own = (labels >= 0) & (np.abs(depth - scene.person) < STEP) & ~theirs
    shown = np.bincount(labels[own], minlength=count)
    main = int(np.argmax(shown))
    box = box_of(labels == main, labels.shape, 0)
    inside = labels[box] == main
    theirs, own, part = theirs[box] & inside, own[box] & inside, depth[box]
    area = float(np.square(part[theirs], dtype=np.float64).sum() / (intrinsics[0] * intrinsics[1]))
    if area < SOMEBODY or shown[main] < _IN_SIGHT * np.count_nonzero(np.isfinite(scene.person)):
        return count
    labels[box][inside & _nearer(part, theirs, own, float(intrinsics[0]))] = count
    return count + 1


def _nearer(depth: Singles, to: Bools, than: Bools, focal: float) -> Bools:
    """(h, w) which pixels of (h, w) m are nearer to some of them than to others, by the nearest in the image of each.

    Parameters
    ----------
    to, than : (h, w) True on some, neither empty. focal : px.
    """
    import cv2

    apart = []
    for some in (to, than):
        away, nearest = cv2.distanceTransformWithLabels(
            (~some).view(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
        )
        deep = np.zeros(int(nearest.max()) + 1, np.float32)
        deep[nearest[some]] = depth[some]
        apart.append(np.hypot(away * depth / focal, depth - deep[nearest]))
    return np.asarray(apart[0] < apart[1])


def _clouds(
    depth: Singles, labels: Labels, measures: Floats, wanted: Ints, intrinsics: Floats, most: int = 300
) -> dict[int, Floats]:
    """Points (N, 3) in m of each wanted surface, N at most `most`."""
    from ...kernels import regions

    slot = np.full(len(measures), -1, np.int64)
    slot[wanted] = np.arange(len(wanted))
    step = np.maximum(np.ceil(measures[:, 0] / most), 1).astype(np.int64)
    points, counts = np.empty((len(wanted), most, 3)), np.zeros(len(wanted), np.int64)
    regions.sampled(depth, labels, slot, step, intrinsics, points, counts)
    return {int(s): points[k, : counts[k]] for k, s in enumerate(wanted)}


def _shared(depth: Singles, labels: Labels, pixels: Floats, before: Singles | None) -> Floats:
    """(S,) share of each surface, of so many pixels (S,), that lies where something was before, (H, W) m."""
    if before is None:
        return np.zeros(len(pixels))
    box = box_of(np.isfinite(before), before.shape, 0)
    part = labels[box]
    with np.errstate(invalid="ignore"):
        same = (part >= 0) & (np.abs(depth[box] - before[box]) < STEP)
    return np.asarray(np.bincount(part[same], minlength=len(pixels)) / np.maximum(pixels, 1.0))


def is_board(measure: Floats, cloud: Floats) -> bool:
    """Whether a surface, `measures` (14,) and points (N, 3) in m of it, has no relief: a board, a table top."""
    flat = np.sqrt(max(np.linalg.eigvalsh(np.cov(cloud.T))[0], 0.0))
    # What the worst of cameras adds at this depth, or less where the surface itself is smoother than that.
    noise = np.fmin(0.3 * NOISE_STEEP * measure[10] ** 2, _OF_BENDS * measure[13])
    return bool(flat < np.hypot(NOISE_NEAR, noise))  # relief and noise add as variances


def _likeness(measure: Floats, cloud: Floats, shortest: float = SHORTEST, *, theirs: bool = False) -> float:
    """How much a surface is like a body by its shape and place; 0 = not at all. Of `theirs` less is asked."""
    area = measure[1]
    extent = measure[3:9:2] - measure[2:8:2]
    # A person's size is bounded; of one who is partly out of view less is asked.
    if not SMALLEST < area < LARGEST or extent[:2].max() < shortest * (measure[12] == 0):
        return 0.0
    if not theirs and (extent.max() > LONGEST or (measure[11] < 0.5 and is_board(measure, cloud))):
        return 0.0
    score = float(np.exp(-0.5 * (np.log(area / USUAL_AREA) / 0.7) ** 2))
    score /= 1.0 + (measure[10] / 4.0) ** 2  # who is filmed stands in front
    return float(score)
