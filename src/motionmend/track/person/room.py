"""The room that a camera which stands still looks at: its floor and walls, and what was seen behind the person."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from ...arrays import Bools, Floats, Singles, frozen
from ...bodies.camera import Camera, DepthFrame
from .window import Window

# A structured-light camera's axial noise is about 1.9 mm at 1 m and grows with the square of the depth (Nguyen et al.
# 2012); three standard deviations, and the width of a depth step of its 11 bits.
NOISE_NEAR, NOISE_STEEP = 0.015, 0.007

STIRRED = 0.15  # share of a body's pixels with the room seen behind them before, from which on it is no furniture
PLANE_AREA = 1.3  # m^2, of a floor or a wall: more than a person's front
GRAZING = 0.1  # cosine, at which a plane is looked along at most: so much of its area faces the camera
BEYOND = 0.02  # share of the points that may lie behind a floor or a wall
MORE = 1.25, 0.02  # times as much of the image, and a share of it more, from where on a frame tells the room anew
WHOLE = 0.8  # of what is usually measured, or was, below which a frame does not tell of a room
LEFT = 0.25  # of a plane's least area, that it has in the next frame at least if it is one


@final
@dataclass(frozen=True, eq=False)
class Scene:
    """What is known of a room seen by a camera that stands still.

    Attributes
    ----------
    planes : (P, 4) unit normal towards the camera and offset in m, in camera axes: normal · x + offset is the height
        of a point above the plane.
    background : (H, W) float32 m, the farthest surface seen at each pixel, NaN where none was.
    person : (H, W) float32 m, who was last seen, NaN beside; None before anybody was.
    others : (H, W) float32 m, who else was in the last frame, NaN beside; None = nobody (`passers`).
    since : s, when that was; NaN before.
    stirred : most of the person's pixels so far, as a share, that had the room behind them seen before.
    vouched : whether who was last seen is a person for sure: pointed at, or well explained by a body.
    window : the part of the images in which anything is measured, where the background was taken away; else None.
    shown : share of the image in which the frame that planes were told of has depth.
    told : s, when that was; NaN once a later frame has borne them out, or where nobody asks.
    moved : s, when the camera was last seen to move; NaN = never. watched : s, when planes were last looked for anew.
    still : whether what is most like a body never moves in all of the recording (`standing.with_furniture`).
    furniture : (H, W) True on what was told to be furniture before anybody was followed; None = nothing.
    """

    planes: Floats
    background: Singles
    person: Singles | None = None
    others: Singles | None = None
    since: float = float("nan")
    stirred: float = 0.0
    vouched: bool = False
    window: Window | None = None
    shown: float = 1.0
    told: float = float("nan")
    moved: float = float("nan")
    watched: float = float("nan")
    still: bool = False
    furniture: Bools | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "planes", frozen(self.planes))
        object.__setattr__(self, "background", frozen(self.background, np.float32))
        if self.person is not None:
            object.__setattr__(self, "person", frozen(self.person, np.float32))
        if self.others is not None:
            object.__setattr__(self, "others", frozen(self.others, np.float32))
        if self.furniture is not None:
            object.__setattr__(self, "furniture", frozen(self.furniture, np.bool_))

    @property
    def alive(self) -> bool:
        """Whether who was last seen is surely no furniture: that stays where it is."""
        return self.vouched or self.stirred > STIRRED

    @property
    def bare(self) -> bool:
        """Whether nothing is known of a room: so it stays where the background was taken away."""
        if self.window is not None:
            return True  # from then on no background is learned
        return not len(self.planes) and not bool(np.isfinite(self.background).any())


def scene_of(frame: DepthFrame, seed: int = 0) -> Scene:
    """The room from one frame: its floor and walls; of the background nothing is known yet.

    A plane belongs to the room when it is larger than a person and nearly nothing lies behind it. Candidates are
    drawn from points close to each other (RANSAC, Fischler & Bolles 1981) and fitted to what supports them.

    Parameters
    ----------
    frame : with or without a person in it, with or without a background.
    seed : of the draws; the same frame and seed give the same planes.
    """
    unknown = np.full(frame.depth.shape, np.nan, np.float32)
    planes = bounding_planes(frame.camera, frame.depth, seed)
    return Scene(planes, unknown, shown=_share(frame), told=frame.time)


def told_again(scene: Scene, frame: DepthFrame, seed: int = 0) -> Scene:
    """The scene, with floor and walls told anew where a frame shows that they are not known, or not so.

    A first image may be blank, or lack rows or most of its pixels: then the first that shows clearly more tells, and so
    on. What a damaged image has for a wall the next one does not bear out. All that came of such an image is forgotten,
    for who is not told apart is learned as background; but not what was learned since somebody is surely followed.

    Parameters
    ----------
    scene : as known so far. frame : of its size. seed : as for `scene_of`.
    """
    share = _share(frame)
    if share > MORE[0] * scene.shown + MORE[1]:
        fresh = scene_of(frame, seed)
        if not len(fresh.planes):
            return replace(scene, shown=share)
        return (
            replace(scene, planes=fresh.planes, shown=share, told=frame.time, window=None) if scene.vouched else fresh
        )
    if not (frame.time > scene.told and share >= WHOLE * scene.shown):
        return scene
    if _borne_out(scene.planes, frame):
        return replace(scene, told=float("nan"))
    return replace(scene_of(frame, seed), vouched=scene.vouched)


def first_whole(frames: Sequence[DepthFrame]) -> int:
    """Number of the first of some frames, one at least, that has as much depth as most of them."""
    shares = [_share(frame) for frame in frames]
    return next(k for k, share in enumerate(shares) if share >= WHOLE * float(np.median(shares)))


def _share(frame: DepthFrame) -> float:
    """Share of an image's pixels that have depth."""
    return np.count_nonzero(np.isfinite(frame.depth)) / frame.depth.size


def _borne_out(planes: Floats, frame: DepthFrame) -> bool:
    """Whether each of planes (P, 4) is in a frame, too."""
    points, area = grid_of(frame.camera, frame.depth)
    free = np.isfinite(area)
    cloud, weight = points[free], area[free]
    for plane in planes:
        on = np.abs(cloud @ plane[:3] + plane[3]) < slack(cloud, plane[None])[:, 0]
        if spread(cloud[on], weight[on], plane).sum() < LEFT * PLANE_AREA:
            return False
    return True


def bounding_planes(camera: Camera, depth: Singles, seed: int, most: int = 4, draws: int = 400) -> Floats:
    """(P, 4) floors and walls, the largest first: unit normals towards the camera and offsets in m.

    Parameters
    ----------
    camera, depth : of one image, (H, W) m, NaN = no return.
    seed : of the draws. most : how many planes at most. draws : candidates for each.
    """
    points, area = grid_of(camera, depth)
    rng = np.random.default_rng(seed)
    free = np.isfinite(area)
    every = points[free]
    planes: list[Floats] = []
    for _ in range(most):
        if area[free].sum() < GRAZING * PLANE_AREA:
            break
        candidates = _drawn(points, free, rng, draws)
        if not len(candidates):
            break
        cloud, weight = points[free], area[free]
        supported = _support(cloud, weight, candidates)
        best = None
        for i in np.argsort(-supported)[:20]:
            if supported[i] < GRAZING * PLANE_AREA:
                break
            plane = refitted(cloud, weight, candidates[i])
            behind = every @ plane[:3] + plane[3] < -2.0 * slack(every, plane[None])[:, 0]
            on = np.abs(cloud @ plane[:3] + plane[3]) < slack(cloud, plane[None])[:, 0]
            size = float(spread(cloud[on], weight[on], plane).sum())
            # Behind a floor or a wall is nothing: what lies behind a table top or a person's front is much.
            if size >= PLANE_AREA and np.mean(behind) < BEYOND and (best is None or size > best[0]):
                best = (size, plane)
        if best is None:
            break
        planes.append(best[1])
        off = np.abs(points @ best[1][:3] + best[1][3])
        with np.errstate(invalid="ignore"):
            free &= off >= slack(points, best[1][None])[..., 0]
    return np.array(planes).reshape(-1, 4)


def grid_of(camera: Camera, depth: Singles, count: int = 5000) -> tuple[Floats, Floats]:
    """(h, w, 3) m, points of every few pixels of every few rows, and (h, w) m² that each stands for, facing the camera.

    Both are NaN where nothing is measured; `count` is about how many there are.
    """
    step = max(1, round(np.sqrt(depth.size / count)))
    grid = np.asarray(depth[::step, ::step], np.float64)
    rows, columns = np.mgrid[0 : depth.shape[0] : step, 0 : depth.shape[1] : step]
    points = np.stack([(columns - camera.cx) * grid / camera.fx, (rows - camera.cy) * grid / camera.fy, grid], axis=-1)
    return points, grid**2 / (camera.fx * camera.fy) * step**2


def slack(points: Floats, planes: Floats) -> Floats:
    """(..., K) m, how far from planes (K, 4) their own points (..., 3) in m may be measured."""
    return np.asarray(NOISE_NEAR + NOISE_STEEP * points[..., 2:] * np.abs(points @ planes[:, :3].T))


def _drawn(points: Floats, free: Bools, rng: np.random.Generator, draws: int) -> Floats:
    """(N, 4) planes through three free points near each other in the image."""
    rows, columns = np.nonzero(free)
    if len(rows) < 3:
        return np.empty((0, 4))
    pick = rng.integers(len(rows), size=draws)
    shift = rng.integers(-12, 13, size=(2, 2, draws))
    corners = [points[rows[pick], columns[pick]]]
    good = np.ones(draws, bool)
    for dr, dc in shift:
        r = np.clip(rows[pick] + dr, 0, free.shape[0] - 1)
        c = np.clip(columns[pick] + dc, 0, free.shape[1] - 1)
        good &= free[r, c]
        corners.append(points[r, c])
    a, b, c = (corner[good] for corner in corners)
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    normal, a = normal[length > 1e-3] / length[length > 1e-3, None], a[length > 1e-3]
    offset = -np.einsum("ij,ij->i", normal, a)
    towards = np.where(offset < 0, -1.0, 1.0)  # the camera, at 0, lies above every plane
    return np.column_stack([normal * towards[:, None], offset * towards])


def _support(cloud: Floats, weight: Floats, planes: Floats) -> Floats:
    """(N,) m^2 of points on each plane."""
    return np.asarray(weight @ (np.abs(cloud @ planes[:, :3].T + planes[:, 3]) < slack(cloud, planes)))


def spread(cloud: Floats, weight: Floats, plane: Floats) -> Floats:
    """(N,) m^2 that points of a plane stand for on it, as they face the camera (N,) m^2."""
    towards = np.abs(cloud @ plane[:3]) / np.linalg.norm(cloud, axis=1)
    return np.asarray(weight / np.maximum(towards, GRAZING))


def refitted(cloud: Floats, weight: Floats, plane: Floats) -> Floats:
    """The plane fitted to what lies on it."""
    for _ in range(3):
        on = np.abs(cloud @ plane[:3] + plane[3]) < slack(cloud, plane[None])[:, 0]
        if on.sum() < 10:
            break
        # Each point counts by the area it stands for over the variance of its depth.
        trust = weight[on] / cloud[on, 2] ** 4
        middle = np.average(cloud[on], axis=0, weights=trust)
        spread = (cloud[on] - middle).T @ ((cloud[on] - middle) * trust[:, None])
        normal = np.linalg.eigh(spread)[1][:, 0]
        offset = -float(normal @ middle)
        plane = np.append(normal, offset) * (1.0 if offset >= 0 else -1.0)
    return plane
