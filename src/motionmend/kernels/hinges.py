"""Limbs turned about their joints until these bend no farther than bodies do."""

from math import acos, cos, sin, sqrt

import numpy as np

from ..arrays import Bools, Floats, Ints
from .compile import compiled


@compiled
def bend_back(positions: Floats, trust: Floats, joints: Ints, limits: Floats, below: Bools, believed: float) -> Floats:
    """Positions in which no joint bends beyond its limits, unless it is trusted.

    What hangs below a joint that bends too far is turned about it, in the plane of its two bones: no bone changes its
    length. Of what is beyond the limit as much stays as the least trusted of the three joints has trust beyond
    `believed`: all at 1.

    Parameters
    ----------
    positions : (T, J, 3) m; a joint with a NaN among its three is passed over.
    trust : (T, J) in [0, 1].
    joints : (H, 3) upper end, the joint, lower end; from the root outward.
    limits : (H, 2) rad, least and most angle between the two bones.
    below : (H, J) the lower end and what hangs on it.
    believed : trust up to which nothing beyond a limit stays.

    Returns
    -------
    (T, J, 3).

    Source
    ------
    The turn is by Rodrigues' formula.
    """
    bent = positions.copy()
    u, v, n = np.empty(3), np.empty(3), np.empty(3)
    for t in range(len(positions)):
        for h in range(len(joints)):
            p, j, c = joints[h, 0], joints[h, 1], joints[h, 2]
            first, second = 0.0, 0.0
            for d in range(3):
                u[d], v[d] = bent[t, p, d] - bent[t, j, d], bent[t, c, d] - bent[t, j, d]
                first += u[d] * u[d]
                second += v[d] * v[d]
            if not (first > 1e-12 and second > 1e-12):
                continue
            cosine = 0.0
            for d in range(3):
                u[d], v[d] = u[d] / sqrt(first), v[d] / sqrt(second)
                cosine += u[d] * v[d]
            angle = acos(min(max(cosine, -1.0), 1.0))
            wanted = min(max(angle, limits[h, 0]), limits[h, 1])
            sure = min(trust[t, p], trust[t, j], trust[t, c])
            left = min(max((sure - believed) / (1.0 - believed), 0.0), 1.0)
            turn = (1.0 - left) * (wanted - angle)
            if turn == 0.0:
                continue
            n[0] = u[1] * v[2] - u[2] * v[1]
            n[1] = u[2] * v[0] - u[0] * v[2]
            n[2] = u[0] * v[1] - u[1] * v[0]
            size = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])
            if size < 1e-9:  # straight or folded up: any axis across serves
                least = 0
                for d in range(1, 3):
                    if abs(u[d]) < abs(u[least]):
                        least = d
                for d in range(3):
                    n[d] = -u[least] * u[d]
                n[least] += 1.0
                size = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])
            for d in range(3):
                n[d] /= size
            co, si = cos(turn), sin(turn)
            for k in range(positions.shape[1]):
                if not below[h, k]:
                    continue
                x, y, z = bent[t, k, 0] - bent[t, j, 0], bent[t, k, 1] - bent[t, j, 1], bent[t, k, 2] - bent[t, j, 2]
                along = (n[0] * x + n[1] * y + n[2] * z) * (1.0 - co)
                bent[t, k, 0] = bent[t, j, 0] + co * x + si * (n[1] * z - n[2] * y) + along * n[0]
                bent[t, k, 1] = bent[t, j, 1] + co * y + si * (n[2] * x - n[0] * z) + along * n[1]
                bent[t, k, 2] = bent[t, j, 2] + co * z + si * (n[0] * y - n[1] * x) + along * n[2]
    return bent
