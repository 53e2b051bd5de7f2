"""Which pixels of a depth image are the person: scene planes, a background that is learned, the body-like surface.

A `Scene` is what is known of the room so far. Each frame, `find_person` takes away what lies on the room's floor and
walls and on the background seen before, and of the connected surfaces that are left keeps the one that is most like
a body with the pieces that hang together with it. `remember` then learns the background from everything else, the
farthest depth of each pixel, so that a mistake heals as soon as something farther is seen there.
"""

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from ...arrays import Bools, Floats, Singles, frozen
from ...bodies.camera import Camera, DepthFrame
from ...bodies.surface import intrinsics
from ...errors import MismatchError
from .fineness import evened
from .passers import passers, passers_pixels
from .room import NOISE_NEAR, NOISE_STEEP, Scene, first_whole, scene_of, slack, told_again
from .surfaces import JUMP_NEAR, STEP, about, box_of, hidden, joined, most_like_a_body, surfaces_of
from .window import Window, lines_of, reached, untold

__all__ = [
    "Foreground",
    "Scene",
    "clean",
    "empty_scene",
    "find_person",
    "first_whole",
    "remember",
    "scene_of",
    "told_again",
]

BASELINE = 0.075  # m, from camera to projector (Kinect, Xtion); others cast narrower shadows or none
CLOSING = 5  # px; dropout inside the person is narrower
ROOM = 0.05  # share of an image's pixels that show something beside people, from which on there is a room
_CLOSING = np.ones((CLOSING, CLOSING), np.uint8)
_MISSED = 1.0  # s without the person, after which a passer is taken for them
_NEARER = 0.15  # m, than the person's middle is what may hide a part of them


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
        recording whose background was taken away, nothing is. Dropout in a room is neither person nor free but at
        their rim while nobody else is in view; nor is what stands in the room nearer than the person, for they may be
        behind it, or what is narrower than `CLOSING` amid them.
    rim : (H, W) True where nothing is measured, but so narrowly between the person and something farther that it is a
        camera's loss at a step in depth: the person ends before it. None = nowhere.
    others : (H, W) m, who else is there, NaN beside; None = nobody (`passers`).
    stirred : share of the person's pixels with the room seen behind them before.
    window : the part of the images in which anything is measured, where the background was taken away; else None.
    """

    depth: Singles
    found: bool
    place: Floats
    free: Bools
    rim: Bools | None = None
    others: Singles | None = None
    stirred: float = 0.0
    window: Window | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "depth", frozen(self.depth, np.float32))
        object.__setattr__(self, "place", frozen(self.place))
        object.__setattr__(self, "free", frozen(self.free, np.bool_))
        if self.rim is not None:
            object.__setattr__(self, "rim", frozen(self.rim, np.bool_))
        if self.others is not None:
            object.__setattr__(self, "others", frozen(self.others, np.float32))


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
    from ...kernels import regions

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
    from ...kernels import regions

    out = np.empty(part.shape, np.float32)
    if part.size:
        regions.mend(frozen(part, np.float32), radius, 6, JUMP_NEAR, out)
    return out


def empty_scene(frames: list[DepthFrame], seed: int = 0) -> Scene:
    """The room from frames with nobody in them: planes from the first whole one, the background the farthest of all.

    As fine as `step` looks at frames of this camera (`fineness.evened`).

    Raises
    ------
    MismatchError : when there is no frame, or frames of several sizes.
    """
    if not frames:
        raise MismatchError("a background needs at least one frame, came none")
    frames = [evened(frame) for frame in frames]
    scene = scene_of(frames[first_whole(frames)], seed)
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
    from ...kernels import scene as kernels

    depth = _sized(scene, frame)
    numbers = intrinsics(frame.camera)
    before = np.empty(depth.shape, np.bool_)
    kernels.before_scene(depth, numbers, scene.planes, scene.background, NOISE_NEAR, NOISE_STEEP, before)
    seen = surfaces_of(scene, depth, before, numbers)
    strange = passers(seen, scene, depth, last)
    main = most_like_a_body(seen, scene.alive, strange, last)
    if main < 0 or (strange[main] and not _gone(scene, frame.time, depth)):
        return _nobody(np.isfinite(depth), passers_pixels(seen, depth, strange, []))
    kept = joined(main, seen, np.zeros_like(strange) if strange[main] else strange)
    mask = seen.pixels_of(kept)
    mask |= _enclosed(depth, mask, scene, frame.camera)
    box, person = box_of(mask, mask.shape, radius + CLOSING), np.full(depth.shape, np.nan, np.float32)
    person[box] = part = mended(np.where(mask[box], depth[box], np.float32(np.nan)), radius)
    rows, columns = np.nonzero(np.isfinite(part))
    some = slice(None, None, 1 + len(rows) // 2000)
    z = part[rows[some], columns[some]].astype(np.float64)
    x = (columns[some] + box[1].start - numbers[2]) * z / numbers[0]
    y = (rows[some] + box[0].start - numbers[3]) * z / numbers[1]
    middle = np.array([np.median(x), np.median(y), np.median(z)])
    others = passers_pixels(seen, depth, strange, kept)
    apart = beside(np.isfinite(part))
    window, somebody = None, mask
    if scene.bare:
        somebody = mask | seen.pixels_of([s for s, like in seen.likeness.items() if like > 0.0 or strange[s]])
    if np.count_nonzero(np.isfinite(depth) & ~somebody) > ROOM * depth.size:
        free = np.isfinite(depth) & ~before & ~np.isfinite(person)
    else:  # the background was taken away
        free = np.ones(depth.shape, np.bool_)
        free[box] = apart
        if scene.bare:
            lines = lines_of(depth, frame.camera)
            window = reached(scene.window, lines)
            away = None if window is None else untold(window, lines)
            free = free if away is None else free & ~away
    kernels.hiding(depth, numbers, scene.planes, NOISE_NEAR, NOISE_STEEP, float(middle[2]) - _NEARER, free)
    rim = np.zeros(depth.shape, np.bool_)
    kernels.gaps(depth, person, free, BASELINE * numbers[0], rim)
    if others is None:  # in whose shadow a limb may be
        free |= rim
    # Between limbs dropout is as narrow as such gaps are, and what shows of the room may be beside its pixel.
    free[box] &= apart
    return Foreground(person, True, middle, free, rim, others, float(seen.measures[main, 11]), window)


def remember(scene: Scene, frame: DepthFrame, person: Foreground) -> Scene:
    """The scene with this frame's background learned: all that is measured, but the person and what is beside it.

    Raises
    ------
    MismatchError : a frame of another size than the scene.
    """
    import cv2

    from ...kernels import scene as kernels

    depth = _sized(scene, frame)
    body = np.isfinite(person.depth)
    seen = np.isfinite(depth) & ~body
    if not person.found and scene.person is not None:
        # Who was there a moment ago, and is not told apart now, has not become furniture.
        with np.errstate(invalid="ignore"):
            seen &= ~(np.abs(depth - scene.person) < STEP)
    if person.others is not None:
        # Nor have passers; and while they hide the person, what comes into view beside them may be the person.
        seen &= np.isnan(person.others) & (person.found | np.isfinite(scene.background))
    if person.found:
        scene = replace(scene, person=person.depth, since=frame.time, stirred=max(scene.stirred, person.stirred))
    scene = scene if scene.others is None and person.others is None else replace(scene, others=person.others)
    # Who is not told apart for a while leaves what was taken away so; a room that comes into view is one.
    window = person.window if person.found or np.count_nonzero(seen) > ROOM * seen.size else scene.window
    scene = scene if window is scene.window else replace(scene, window=window)
    if not seen.any() or window is not None:
        return scene
    if person.found:
        # Beside the person only what is clearly behind them: a piece of them that was missed must not be learned.
        margin = int(np.ceil(0.15 * frame.camera.fx / person.place[2]))
        rows, columns = box_of(body, depth.shape, margin)
        beside = np.where(body[rows, columns], person.depth[rows, columns], np.float32(-1.0))
        beside = cv2.dilate(beside, np.ones((1, 2 * margin + 1), np.uint8))
        beside = cv2.dilate(beside, np.ones((2 * margin + 1, 1), np.uint8))
        seen[rows, columns] &= depth[rows, columns] > beside + 0.25
    background = scene.background.copy()
    # What was learned at the person's own depth was a piece of them.
    kernels.farthest(depth, seen, person.depth, NOISE_NEAR, NOISE_STEEP, background)
    return replace(scene, background=background)


def _gone(scene: Scene, time: float, depth: Singles) -> bool:
    """Whether the person has not been seen for a while though nothing hides the place where they were."""
    return time - scene.since > _MISSED and not hidden(depth, scene.person)


def _nobody(free: Bools, others: Singles | None = None) -> Foreground:
    return Foreground(np.full(free.shape, np.nan), False, np.full(3, np.nan), free, others=others)


def beside(person: Bools) -> Bools:
    """Pixels where the person surely is not, of a recording whose background was taken away.

    Parameters
    ----------
    person : (h, w) where they are; holes in them stay unknown.
    """
    import cv2

    return np.asarray(cv2.morphologyEx(person.view(np.uint8), cv2.MORPH_CLOSE, _CLOSING) == 0)


def _enclosed(depth: Singles, mask: Bools, scene: Scene, camera: Camera) -> Bools:
    """Pixels amid the person, as deep as they are, that a background learned from them by mistake has taken away."""
    import cv2

    if np.isnan(scene.background).all():
        return np.zeros_like(mask)
    rows, columns = box_of(mask, depth.shape, 2)
    part, inside = depth[rows, columns], mask[rows, columns]
    middle = float(np.median(part[inside]))
    window = np.ones((2 * int(np.ceil(0.08 * camera.fx / middle)) + 1,) * 2, np.uint8)
    near = cv2.erode(np.where(inside, part, np.float32(np.inf)), window)
    far = cv2.dilate(np.where(inside, part, np.float32(-np.inf)), window)
    closed = cv2.morphologyEx(inside.astype(np.uint8), cv2.MORPH_CLOSE, window) > 0
    within = closed & ~inside & (part > near - JUMP_NEAR) & (part < far + JUMP_NEAR)
    if scene.furniture is not None:
        within &= ~scene.furniture[rows, columns]  # a whole recording told it
    # Not the floor between the feet: that was never mistaken.
    at = np.argwhere(within) + np.array([rows.start, columns.start])
    points = camera.unproject(at[:, ::-1], part[within].astype(np.float64))
    heights = points @ scene.planes[:, :3].T + scene.planes[:, 3]
    within[within] = ~(heights < slack(points, scene.planes)).any(axis=1)
    out = np.zeros_like(mask)
    out[rows, columns] = within
    return out


def _sized(scene: Scene, frame: DepthFrame) -> Singles:
    if frame.depth.shape != scene.background.shape:
        raise MismatchError(f"the scene is {scene.background.shape}, came a frame of {frame.depth.shape}")
    return np.ascontiguousarray(frame.depth, np.float32)
