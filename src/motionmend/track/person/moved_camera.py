"""A camera that is bumped, or held in the hand: floor and walls are followed, what was seen behind people is not."""

from dataclasses import replace

import numpy as np

from ...arrays import Bools, Floats
from ...bodies.camera import DepthFrame
from .room import GRAZING, NOISE_NEAR, NOISE_STEEP, PLANE_AREA, Scene, bounding_planes, grid_of, slack

ROUNDS = 4  # of fitting
POINTS = 2000  # of an image that are looked at
NEAR = 0.15  # m, that a plane goes from one frame to the next
GAIN = 1.1  # times as much lies on a plane that has moved, where it is now, as where it was
SOME = 0.3  # of a plane's least area, that has to be seen of it
TOLD = 0.03  # m, that a plane is elsewhere at least; by less it was only not told well so far
MOVES = 1.0  # s, in which a camera that moved may move by less than that
AGAIN = 0.5  # s, from one search for planes that are nowhere near to the next
FAR, TURNED = 0.6, 15.0  # m and degrees, that a plane is elsewhere after a bump at most


def camera_followed(scene: Scene, frame: DepthFrame) -> Scene:
    """The scene with its floor and walls where they are in a frame.

    Parameters
    ----------
    scene : as known so far. frame : of its size.

    Returns
    -------
    The same scene where the camera stands still. Else nothing is known of what is behind anybody, and `moved` says when
    that was.
    """
    if not len(scene.planes):
        return scene
    depth = frame.depth
    for somebody in (scene.person, scene.others):
        if somebody is not None:
            depth = np.where(np.isnan(somebody), depth, np.float32(np.nan))
    points, area = grid_of(frame.camera, depth, POINTS)
    free = np.isfinite(area)
    cloud, weight = points[free], area[free]
    found = [_followed(plane, cloud, weight) for plane in scene.planes]
    lost = [k for k, (_, seen) in enumerate(found) if seen < SOME * PLANE_AREA]
    planes = np.array([plane for plane, _ in found])
    if lost and not frame.time - scene.watched < AGAIN:
        scene = replace(scene, watched=frame.time)
        fresh = bounding_planes(frame.camera, frame.depth, 0)
        for k in lost:
            planes[k] = _nearest(planes[k], fresh, cloud)
    least = 0.0 if frame.time - scene.moved < MOVES else TOLD
    stays = [_farthest_apart(*two, cloud) <= least for two in zip(scene.planes, planes, strict=True)]
    if all(stays):
        return scene
    planes[stays] = scene.planes[stays]
    nothing = np.full_like(scene.background, np.nan)
    return replace(scene, planes=planes, background=nothing, furniture=None, moved=frame.time)


def _followed(plane: Floats, cloud: Floats, weight: Floats) -> tuple[Floats, float]:
    """A plane where it is now, and m² of it that are seen there."""
    from ...kernels.planes import refit

    out = np.empty(7)
    refit(cloud, weight, plane, np.array([NEAR, NOISE_NEAR, NOISE_STEEP, GRAZING]), ROUNDS, out)
    close, before, now = out[4:].tolist()
    if close < SOME * PLANE_AREA or now < GAIN * before:
        return plane, before
    return out[:4], now


def _farthest_apart(before: Floats, after: Floats, cloud: Floats) -> float:
    """m, between two planes at the points (N, 3) m that lie on the second one."""
    on = cloud[_on(cloud, after)]
    return float(np.abs(on @ (after - before)[:3] + after[3] - before[3]).max(initial=0.0))


def _on(cloud: Floats, plane: Floats) -> Bools:
    """(N,) which of some points (N, 3) m lie on a plane."""
    return np.asarray(np.abs(cloud @ plane[:3] + plane[3]) < slack(cloud, plane[None])[:, 0])


def _nearest(plane: Floats, fresh: Floats, cloud: Floats) -> Floats:
    """Of planes (P, 4) that are seen the one that a plane may have become by a bump; the plane itself if none may."""
    alike = [one for one in fresh if one[:3] @ plane[:3] > np.cos(np.radians(TURNED))]
    middle = [cloud[_on(cloud, one)].mean(axis=0) for one in alike]
    away = [abs(float(at @ plane[:3] + plane[3])) for at in middle]
    best = int(np.argmin(away)) if away else -1
    return alike[best] if best >= 0 and away[best] < FAR else plane
