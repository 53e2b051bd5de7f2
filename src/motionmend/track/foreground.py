"""Which pixels of a depth image are the person: scene planes, a background that is learned, the body-like surface.

A `Scene` is what is known of the room so far. Each frame, `find_person` takes away what lies on the room's floor and
walls and on the background seen before, and of the connected surfaces that are left keeps the one that is most like
a body with the pieces that hang together with it. `remember` then learns the background from everything else, the
farthest depth of each pixel, so that a mistake heals as soon as something farther is seen there.
"""

from dataclasses import dataclass, replace
from typing import TypeAlias, final

import numpy as np
from numpy.typing import NDArray

from ..arrays import Bools, Floats, Ints, Singles, frozen
from ..bodies.camera import Camera, DepthFrame
from ..bodies.surface import intrinsics
from ..errors import MismatchError
from .room import NOISE_NEAR, NOISE_STEEP, Scene, scene_of, slack

__all__ = ["Foreground", "Scene", "clean", "empty_scene", "find_person", "remember", "scene_of"]

Labels: TypeAlias = NDArray[np.int32]

# Neighbouring pixels of one limb differ by its slope and by noise, of two limbs by more than a hand's thickness.
JUMP_NEAR, JUMP_STEEP = 0.05, 0.004

# What a body may measure, in m and m^2 as seen from one side, from a seated child to a tall man in a coat.
LONGEST, SHORTEST = 2.5, 0.55
LARGEST, SMALLEST = 1.8, 0.04
USUAL_AREA, ARM_AREA = 0.5, 0.06

_REACH = 0.35  # m, between two pieces of one body
_ARM = 0.5  # m, between a body and a forearm that moves, the upper arm being hidden
BASELINE = 0.075  # m, from camera to projector (Kinect, Xtion); others cast narrower shadows or none
# Of normal noise |z - 2 z' + z''| is the standard deviation times this on average; half as much again for what
# neighbours share.
_OF_BENDS = 1.5 * float(np.sqrt(np.pi / 12.0))
_NEARER = 0.15  # m, than the person's middle is what may hide a part of them
_STEP = 0.15  # m, that a surface comes nearer or goes away from one frame to the next


@final
@dataclass(frozen=True, eq=False)
class Foreground:
    """The person in one frame.

    Attributes
    ----------
    depth : (H, W) float32 m, holes of one pixel filled, smoothed by a median; NaN everywhere but on the person.
    found : False for a frame with nobody in it; `depth` is then NaN throughout.
    place : (3,) m, middle of the person's visible surface in camera axes, NaN when nobody is there.
    free : (H, W) True where the person surely is not: something farther or the room itself is seen there, or, in a
        recording whose background was taken away, nothing is. Dropout in a room is neither person nor free, and so is
        what stands in the room nearer than the person, for they may be behind it.
    rim : (H, W) True where nothing is measured either, but so narrowly between the person and something farther that
        it is a camera's loss at a step in depth: the person ends before it. None = nowhere.
    """

    depth: Singles
    found: bool
    place: Floats
    free: Bools
    rim: Bools | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "depth", frozen(self.depth, np.float32))
        object.__setattr__(self, "place", frozen(self.place))
        object.__setattr__(self, "free", frozen(self.free, np.bool_))
        if self.rim is not None:
            object.__setattr__(self, "rim", frozen(self.rim, np.bool_))


def clean(depth: Singles, radius: int = 1) -> Singles:
    """Depth without holes of one pixel and without speckle.

    A hole is filled when six of its eight neighbours are measured: dropout inside a surface would otherwise look
    like an edge. Then every pixel becomes the median of what is measured in the window around it.

    Parameters
    ----------
    depth : (H, W) m, NaN = no return.
    radius : of the median's window in pixels, 1 for 3 x 3; 0 fills holes only.

    Returns
    -------
    (H, W) float32 m.
    """
    from ..kernels import regions

    depth = frozen(depth, np.float32)
    out, box = np.full(depth.shape, np.nan, np.float32), np.empty(4, np.int64)
    regions.extent(depth, box)
    rows, columns = about(box, depth.shape, radius + 1)
    out[rows, columns] = mended(depth[rows, columns], radius)
    return out


def mended(part: Singles, radius: int) -> Singles:
    """As `clean`, of a part of an image that has nothing measured on its border, or the image's own.

    Parameters
    ----------
    part : (h, w) m, NaN = no return; not changed.
    radius : of the median's window, px; at most 3.

    Returns
    -------
    (h, w) float32 m.
    """
    from ..kernels import regions

    out = np.empty(part.shape, np.float32)
    if part.size:
        regions.mend(part.copy(), radius, 6, JUMP_NEAR, out)
    return out


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


def empty_scene(frames: list[DepthFrame], seed: int = 0) -> Scene:
    """The room from frames with nobody in them: planes from the first, and the background, the farthest of all.

    Raises
    ------
    MismatchError : when there is no frame, or frames of several sizes.
    """
    if not frames:
        raise MismatchError("a background needs at least one frame, came none")
    scene = scene_of(frames[0], seed)
    nobody = _nobody(np.isfinite(frames[0].depth))
    for frame in frames:
        scene = remember(scene, frame, nobody)
    return scene


def find_person(scene: Scene, frame: DepthFrame, last: Floats | None = None, radius: int = 1) -> Foreground:
    """The person's pixels of one frame.

    Parameters
    ----------
    scene : the room as known so far.
    frame : the depth image.
    last : (3,) m, where the person was in the frame before, if known.
    radius : of the median's window (see `clean`).

    Raises
    ------
    MismatchError : a frame of another size than the scene.
    """
    from ..kernels import regions

    depth = _sized(scene, frame)
    numbers = intrinsics(frame.camera)
    before = np.empty(depth.shape, np.bool_)
    regions.before_scene(depth, numbers, scene.planes, scene.background, NOISE_NEAR, NOISE_STEEP, before)
    labels = np.empty(depth.shape, np.int32)
    count = regions.surfaces(depth, before, JUMP_NEAR, JUMP_STEEP, labels)
    measures = np.empty((count, 14))
    moved = (before & np.isfinite(scene.background)).view(np.uint8)
    regions.measures(depth, labels, moved, numbers, measures)
    mask = _body(depth, labels, measures, _known(depth, labels, measures, scene.person), numbers, last)
    if mask is None:
        return _nobody(np.isfinite(depth))
    mask |= _enclosed(depth, mask, scene, frame.camera)
    person = clean(np.where(mask, depth, np.float32(np.nan)), radius)
    rows, columns = np.nonzero(np.isfinite(person))
    some = slice(None, None, 1 + len(rows) // 2000)
    z = person[rows[some], columns[some]].astype(np.float64)
    x = (columns[some] - numbers[2]) * z / numbers[0]
    y = (rows[some] - numbers[3]) * z / numbers[1]
    middle = np.array([np.median(x), np.median(y), np.median(z)])
    free = _free(depth, before, mask, np.isfinite(person))
    regions.hiding(depth, numbers, scene.planes, NOISE_NEAR, NOISE_STEEP, float(middle[2]) - _NEARER, free)
    rim = np.zeros(depth.shape, np.bool_)
    regions.gaps(depth, person, free, BASELINE * numbers[0], rim)
    return Foreground(person, True, middle, free, rim)


def remember(scene: Scene, frame: DepthFrame, person: Foreground) -> Scene:
    """The scene with this frame's background learned: all that is measured, but the person and what is beside it.

    Raises
    ------
    MismatchError : a frame of another size than the scene.
    """
    import cv2

    depth = _sized(scene, frame)
    body = np.isfinite(person.depth)
    seen = np.isfinite(depth) & ~body
    if not person.found and scene.person is not None:
        # Who was there a moment ago, and is not told apart now, has not become furniture.
        with np.errstate(invalid="ignore"):
            seen &= ~(np.abs(depth - scene.person) < _STEP)
    scene = replace(scene, person=person.depth) if person.found else scene
    if not seen.any():
        return scene
    known = scene.background
    if person.found:
        # What was learned at the person's own depth was a piece of them.
        slack = NOISE_NEAR + NOISE_STEEP * depth**2
        known = np.where(body & (known - depth < slack), np.float32(np.nan), known)
        # Beside the person only what is clearly behind them: a piece of them that was missed must not be learned.
        margin = int(np.ceil(0.15 * frame.camera.fx / person.place[2]))
        rows, columns = _box(body, depth.shape, margin)
        beside = np.where(body[rows, columns], person.depth[rows, columns], np.float32(-1.0))
        beside = cv2.dilate(beside, np.ones((1, 2 * margin + 1), np.uint8))
        beside = cv2.dilate(beside, np.ones((2 * margin + 1, 1), np.uint8))
        seen[rows, columns] &= depth[rows, columns] > beside + 0.25
    farthest = np.fmax(known, np.where(seen, depth, np.float32(np.nan)))
    return replace(scene, background=farthest)


def _nobody(free: Bools) -> Foreground:
    return Foreground(np.full(free.shape, np.nan), False, np.full(3, np.nan), free)


def _free(depth: Singles, before: Bools, mask: Bools, person: Bools) -> Bools:
    """Pixels where the person surely is not."""
    measured = np.isfinite(depth)
    if np.mean(measured & ~mask) > 0.05:
        return np.asarray(measured & ~before & ~person)
    # Next to nothing is measured beside the person: the background was taken away. Holes in the person stay unknown.
    import cv2

    closed = cv2.morphologyEx(person.astype(np.uint8), cv2.MORPH_CLOSE, np.ones((5, 5), np.uint8))
    return np.asarray(closed == 0)


def _enclosed(depth: Singles, mask: Bools, scene: Scene, camera: Camera) -> Bools:
    """Pixels amid the person, as deep as they are, that a background learned from them by mistake has taken away."""
    import cv2

    if np.isnan(scene.background).all():
        return np.zeros_like(mask)
    rows, columns = _box(mask, depth.shape, 2)
    part, inside = depth[rows, columns], mask[rows, columns]
    middle = float(np.median(part[inside]))
    window = np.ones((2 * int(np.ceil(0.08 * camera.fx / middle)) + 1,) * 2, np.uint8)
    near = cv2.erode(np.where(inside, part, np.float32(np.inf)), window)
    far = cv2.dilate(np.where(inside, part, np.float32(-np.inf)), window)
    closed = cv2.morphologyEx(inside.astype(np.uint8), cv2.MORPH_CLOSE, window) > 0
    out = np.zeros_like(mask)
    out[rows, columns] = closed & ~inside & (part > near - JUMP_NEAR) & (part < far + JUMP_NEAR)
    # Not the floor between the feet: that was never mistaken.
    points = camera.unproject(np.argwhere(out)[:, ::-1], depth[out].astype(np.float64))
    heights = points @ scene.planes[:, :3].T + scene.planes[:, 3]
    out[out] = ~(heights < slack(points, scene.planes)).any(axis=1)
    return out


def _sized(scene: Scene, frame: DepthFrame) -> Singles:
    if frame.depth.shape != scene.background.shape:
        raise MismatchError(f"the scene is {scene.background.shape}, came a frame of {frame.depth.shape}")
    return np.ascontiguousarray(frame.depth, np.float32)


def _box(inside: Bools, shape: tuple[int, ...], margin: int) -> tuple[slice, slice]:
    """Rows and columns that hold all of `inside`, and a margin."""
    rows, columns = np.flatnonzero(inside.any(axis=1)), np.flatnonzero(inside.any(axis=0))
    box = (rows[0], rows[-1], columns[0], columns[-1]) if len(rows) else (0, -1, 0, -1)
    return about(np.array(box), shape, margin)


def _known(depth: Singles, labels: Labels, measures: Floats, person: Singles | None) -> Floats:
    """(S,) share of each surface that was the person's when they were last seen."""
    if person is None:
        return np.zeros(len(measures))
    rows, columns = _box(np.isfinite(person), depth.shape, 0)
    part = labels[rows, columns]
    with np.errstate(invalid="ignore"):
        same = (part >= 0) & (np.abs(depth[rows, columns] - person[rows, columns]) < _STEP)
    return np.bincount(part[same], minlength=len(measures)) / np.maximum(measures[:, 0], 1.0)


def _body(
    depth: Singles, labels: Labels, measures: Floats, known: Floats, intrinsics: Floats, last: Floats | None
) -> Bools | None:
    """(H, W) True on the surface most like a body and on the pieces that hang together with it; None = nobody."""
    size = measures[:, 1]
    order = np.argsort(-size, kind="stable")[:24]
    order = order[(size[order] > 0.0005) & (measures[order, 0] >= 8)]
    clouds = _clouds(depth, labels, measures, order, intrinsics)
    scores = {s: _likeness(measures[s], cloud, last) for s, cloud in clouds.items()}
    main = max(scores, key=lambda s: scores[s], default=-1)
    if main < 0 or scores[main] <= 0.0:
        return None
    keep = np.zeros(len(measures) + 1, bool)  # the last for pixels of no surface
    keep[_joined(main, clouds, measures, known)] = True
    return np.asarray(keep[labels])


def _joined(main: int, clouds: dict[int, Floats], measures: Floats, known: Floats) -> list[int]:
    """The surfaces that belong to a body one of which is `main`."""
    from scipy.spatial import cKDTree

    size, lows, highs = measures[:, 1], measures[:, 2:8:2], measures[:, 3:9:2]
    kept, low, high, total = [main], lows[main], highs[main], size[main]
    gaps = {s: np.inf for s in clouds if s != main}
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
            near = gap < (_ARM if arm or was else _REACH if size[s] < max(0.25 * size[main], ARM_AREA) else 0.12)
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


def _clouds(
    depth: Singles, labels: Labels, measures: Floats, wanted: Ints, intrinsics: Floats, most: int = 300
) -> dict[int, Floats]:
    """Points (N, 3) in m of each wanted surface, N at most `most`."""
    from ..kernels import regions

    slot = np.full(len(measures), -1, np.int64)
    slot[wanted] = np.arange(len(wanted))
    step = np.maximum(np.ceil(measures[:, 0] / most), 1).astype(np.int64)
    points, counts = np.empty((len(wanted), most, 3)), np.zeros(len(wanted), np.int64)
    regions.sampled(depth, labels, slot, step, intrinsics, points, counts)
    return {int(s): points[k, : counts[k]] for k, s in enumerate(wanted)}


def _likeness(measure: Floats, cloud: Floats, last: Floats | None) -> float:
    """How much a surface is like a body; 0 = not at all."""
    area = measure[1]
    extent = measure[3:9:2] - measure[2:8:2]
    # A person's size is bounded; of one who is partly out of view less is asked.
    if not SMALLEST < area < LARGEST or extent.max() > LONGEST or extent[:2].max() < SHORTEST * (measure[12] == 0):
        return 0.0
    spread = np.cov(cloud.T)
    flat = np.sqrt(max(np.linalg.eigvalsh(spread)[0], 0.0))
    still = measure[11] < 0.5
    # What the worst of cameras adds at this depth, or less where the surface itself is smoother than that.
    noise = np.fmin(0.3 * NOISE_STEEP * measure[10] ** 2, _OF_BENDS * measure[13])
    if still and flat < np.hypot(NOISE_NEAR, noise):  # relief and noise add as variances
        return 0.0  # a board, a table top
    score = float(np.exp(-0.5 * (np.log(area / USUAL_AREA) / 0.7) ** 2))
    score *= 1.0 + 50.0 * measure[11]  # what moves before a known background is no furniture
    score /= 1.0 + (measure[10] / 4.0) ** 2  # who is filmed stands in front
    if last is not None and np.isfinite(last).all():
        gap = float(np.min(np.linalg.norm(cloud - last, axis=1)))
        score *= 0.1 + 0.9 / (1.0 + (gap / 0.5) ** 2)
    return float(score)
