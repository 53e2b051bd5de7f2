"""A floor or a wall from one frame to the next: fitted anew to what is near it, and how much of it is seen."""

import numpy as np

from ..arrays import Floats
from .compile import compiled


@compiled
def refit(cloud: Floats, area: Floats, plane: Floats, limits: Floats, rounds: int, out: Floats) -> None:
    """Fit a plane to the points near it, then to those that lie on it.

    Parameters
    ----------
    cloud : (N, 3) m, camera axes. area : (N,) m² that each stands for, facing the camera.
    plane : (4,) unit normal and offset in m, to begin with.
    limits : (4,) m by which points near a plane are farther off it than its own; m, and share of the depth that is seen
        head-on, by which its own are off it at most; least cosine at which a plane is looked along.
    rounds : of fitting.
    out : (7,) written: the plane, and m² of what is near it, lies on it as it was, and as it is now.
    """
    a, b, c, d = plane[0], plane[1], plane[2], plane[3]
    out[4], out[5], out[6] = 0.0, 0.0, 0.0
    normal, side = np.empty((3, 3)), np.empty(3)
    one, two = np.empty(3), np.empty(3)  # across the normal
    for turn in range(rounds + 1):
        least = min(abs(a), abs(b), abs(c))
        one[:] = 0.0
        one[0 if abs(a) == least else 1 if abs(b) == least else 2] = 1.0
        along = one[0] * a + one[1] * b + one[2] * c
        one[0], one[1], one[2] = one[0] - along * a, one[1] - along * b, one[2] - along * c
        one /= np.sqrt((one**2).sum())
        two[0], two[1], two[2] = b * one[2] - c * one[1], c * one[0] - a * one[2], a * one[1] - b * one[0]
        normal[:], side[:] = 0.0, 0.0
        seen = 0.0
        for i in range(len(cloud)):
            x, y, z = cloud[i, 0], cloud[i, 1], cloud[i, 2]
            height = a * x + b * y + c * z + d
            slope = abs(a * x + b * y + c * z)
            off = limits[1] + limits[2] * z * slope
            on = abs(height) < off
            near = turn == 0 and abs(height) < off + limits[0]
            if near or on:
                size = area[i] / max(slope / np.sqrt(x * x + y * y + z * z), limits[3])
                if on:
                    seen += size
                if near:
                    out[4] += size
                # Each point counts by the area it stands for over the variance of its depth.
                trust = area[i] / z**4
                u = one[0] * x + one[1] * y + one[2] * z
                v = two[0] * x + two[1] * y + two[2] * z
                normal[0, 0] += trust * u * u
                normal[0, 1] += trust * u * v
                normal[0, 2] += trust * u
                normal[1, 1] += trust * v * v
                normal[1, 2] += trust * v
                normal[2, 2] += trust
                side[0] -= trust * u * height
                side[1] -= trust * v * height
                side[2] -= trust * height
        if turn == 0:
            out[5] = seen
        out[6] = seen
        normal[1, 0], normal[2, 0], normal[2, 1] = normal[0, 1], normal[0, 2], normal[1, 2]
        if turn == rounds or abs(np.linalg.det(normal)) <= 1e-12 * normal[2, 2] ** 3:
            break
        step = np.linalg.solve(normal, side)
        a += step[0] * one[0] + step[1] * two[0]
        b += step[0] * one[1] + step[1] * two[1]
        c += step[0] * one[2] + step[1] * two[2]
        d += step[2]
        length = np.sqrt(a * a + b * b + c * c)
        a, b, c, d = a / length, b / length, c / length, d / length
    out[0], out[1], out[2], out[3] = a, b, c, d
