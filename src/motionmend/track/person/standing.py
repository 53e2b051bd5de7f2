"""Furniture told from people before anybody is followed: it keeps its place for a whole recording; somebody does not.

A box that is nearer and larger than the person looks more like somebody than they do, from the first frame to the last.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...arrays import Bools, Floats, Singles, frozen
from ...bodies.camera import Camera, DepthFrame
from ...bodies.surface import intrinsics
from .desks import top_in, vertical
from .fineness import evened
from .room import NOISE_NEAR, NOISE_STEEP, Scene, first_whole, scene_of
from .surfaces import SOMEBODY, Surfaces, is_board, joined, most_like_a_body, surfaces_of

LOOKED_AT = 24  # frames of a recording, spread over all of it
SEEN, SAME = 0.5, 0.9  # share of them in which a pixel is measured, and of those in which it is the same
STILL = 0.98  # share of such pixels in a piece of furniture; dropout and noise are at its rim
RIM = 2  # px
# m, standard deviation of the mean depth of a quarter of a surface beside that of all, and times that of its noise:
# nobody stands so still
SWAY, CLEARLY = 0.002, 4.0
QUARTERS = 4
LONG = 1.5  # s, in which who stands still sways: 109 of 110 ends of real recordings of 0.8 s did, all of 1.2 s
LEAVES = 0.2  # m, nearer than what is seen behind them later is somebody who moves
MOST = 12  # pieces
_WINDOW = np.ones((2 * RIM + 1, 2 * RIM + 1), np.uint8)


def looked_at(frames: int) -> list[int]:
    """Which frames, counted from 0, of a recording of so many tell its furniture."""
    return [int(k) for k in np.unique(np.linspace(0, frames - 1, LOOKED_AT).astype(int))]


def with_furniture(frames: Sequence[DepthFrame]) -> Scene | None:
    """The room of a recording with the furniture in it that looks like a body and never moves, while somebody does.

    Parameters
    ----------
    frames : those of `looked_at`.

    Returns
    -------
    The scene before the first frame; `still` where nobody moves in a room for so long that whoever stands there sways.
    None where nobody moves in less time, or no such furniture is: then nothing is known.
    """
    import cv2

    even = [evened(frame) for frame in frames]
    if len(even) < 3 or len({frame.depth.shape for frame in even}) > 1:
        return None
    camera, depths = even[0].camera, frozen(np.stack([frame.depth for frame in even]), np.float32)
    whole = first_whole(even)
    room = bare = scene_of(even[whole])
    scene = None
    stays, leaving = stays_of(depths, camera.fx * camera.fy)
    alone = room.bare  # nothing is seen behind who moves: that they sway has to tell
    walks = leaving >= SOMEBODY
    somebody_sways, likely = walks and not alone, False
    up = vertical(room.planes)
    for _ in range(MOST):
        seen, main = likest(room, depths[whole], camera)
        likely |= main >= 0
        first = [main] if main >= 0 else []
        # What of a table is not learned as background, for it is too near the person, would be taken for a limb.
        large = [s for s in seen.clouds if seen.measures[s, 1] > SOMEBODY and s != main]
        # Where no room is behind it, only what is flat: of somebody who stands still there little else is known.
        large = [s for s in large if not alone or is_board(seen.measures[s], seen.clouds[s])]
        standing = None
        for s in first + large:
            mask = seen.pixels_of([s])
            moves = sways(depths, stays, inner_of(mask))
            somebody_sways |= moves
            # Who only moves the hands leaves nothing: what is most like a body is not furniture then.
            told = not moves and (walks or alone or s != main)
            standing = mask if told and standing is None else standing
        if standing is None and up is not None:
            # A desk hangs together with who sits at it.
            surfaces = [seen.pixels_of([s]) for s in first + large]
            tops = [top_in(camera, stays, depths[whole], surface, up) for surface in surfaces]
            standing = next((top for top in tops if top is not None and not sways(depths, stays, inner_of(top))), None)
        if standing is None:
            break
        nearest = np.where(standing & np.isfinite(stays), stays, np.float32(np.inf))
        nearest = cv2.erode(nearest, _WINDOW, borderType=cv2.BORDER_REPLICATE)
        there = np.isfinite(nearest)
        furniture = there if room.furniture is None else there | room.furniture
        room = scene = replace(room, background=np.where(there, nearest, room.background), furniture=furniture)
    if not somebody_sways:
        lasts = even[-1].time - even[0].time
        return replace(bare, still=True) if likely and not alone and lasts >= LONG and len(even) >= QUARTERS else None
    if scene is None:
        return None
    # What else stays is the room: but not somebody's feet.
    somebody = np.zeros(depths[0].shape, np.bool_)
    for depth in depths:
        seen, main = likest(scene, depth, camera)
        if main >= 0:
            somebody |= seen.pixels_of(joined(main, seen, np.zeros(len(seen.measures), np.bool_)))
    if alone and not somebody.any():
        return None
    apart = cv2.dilate(somebody.view(np.uint8), _WINDOW) == 0
    return replace(scene, background=np.where(apart & np.isnan(scene.background), stays, scene.background))


def likest(room: Scene, depth: Singles, camera: Camera, last: Floats | None = None) -> tuple[Surfaces, int]:
    """The surfaces before a room and which is most like a body; -1 = none.

    Parameters
    ----------
    room : as known. depth : (H, W) m. last : (3,) m, where the person is, if known.
    """
    from ...kernels import scene as kernels

    depth = frozen(depth, np.float32)
    before, numbers = np.empty(depth.shape, np.bool_), intrinsics(camera)
    kernels.before_scene(depth, numbers, room.planes, room.background, NOISE_NEAR, NOISE_STEEP, before)
    seen = surfaces_of(room, depth, before, numbers)
    return seen, most_like_a_body(seen, False, np.zeros(len(seen.measures), np.bool_), last)


def inner_of(surface: Bools) -> Bools:
    """(H, W) True on a surface (H, W) without its rim, where dropout and noise are."""
    import cv2

    return np.asarray(cv2.erode(surface.view(np.uint8), _WINDOW) > 0)


def sways(depths: Singles, stays: Singles, inner: Bools) -> bool:
    """Whether a surface moves, be it by as little as people who stand or sit still: head, trunk or legs as a whole.

    Parameters
    ----------
    depths : (N, H, W) m, NaN = no return.
    stays : (H, W) m, what is always the same (`stays_of`).
    inner : (H, W) True within the surface, rows from head to feet.
    """
    if not inner.any() or np.isfinite(stays[inner]).mean() < STILL:
        return True
    offs, noises = [], []
    for part in np.array_split(depths[:, inner].astype(np.float64), QUARTERS, axis=1):  # row by row
        part = part[:, np.isfinite(part).any(axis=0)]
        if not part.size:
            return False
        middle = np.nanmedian(part, axis=0)
        same = np.abs(part - middle) < NOISE_NEAR + NOISE_STEEP * np.square(middle)
        off, count = np.where(same, part - middle, 0.0), same.sum(axis=1)
        hidden = count < 0.5 * count.max()  # somebody walks before it
        offs.append(np.where(hidden, np.nan, off.sum(axis=1) / np.maximum(count, 1)))
        noises.append(np.sqrt(np.square(off).sum() / count.sum() / count[~hidden].mean()))
    beside = np.array(offs) - np.mean(offs, axis=0)  # a camera's depths drift together
    shown = np.isfinite(beside).all(axis=0)
    return bool((beside[:, shown].std(axis=1) > np.maximum(SWAY, CLEARLY * np.array(noises))).any())


def stays_of(depths: Singles, focal: float) -> tuple[Singles, float]:
    """(H, W) m, what is always the same, at its farthest, NaN where nothing is; and m² of somebody who moves, at most.

    Parameters
    ----------
    depths : (N, H, W) m, NaN = no return.
    focal : px², product of both focal lengths.
    """
    import cv2

    ordered = np.sort(depths, axis=0)  # what is not measured comes last
    count = np.isfinite(depths).sum(axis=0)
    middle, farthest = (
        np.take_along_axis(ordered, np.maximum(count - 1, 0)[None] // part, axis=0)[0] for part in (2, 1)
    )
    same = np.abs(depths - middle) < NOISE_NEAR + NOISE_STEEP * np.square(middle)
    still = (count >= SEEN * len(depths)) & (same.sum(axis=0) >= SAME * count)
    stays = np.where(still, np.where(same, depths, np.float32(-np.inf)).max(axis=0), np.float32(np.nan))
    leaving = 0.0
    for depth in depths:
        moves = np.isfinite(depth) & (depth < farthest - LEAVES) & ~still
        moves = cv2.morphologyEx(moves.view(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8)) > 0
        leaving = max(leaving, float(np.square(depth[moves], dtype=np.float64).sum()) / focal)
    return stays, leaving
