"""Body parts of depth pixels: walks down trees of depth differences, and the densest places of their votes.

The depth images come with everything that is not the person put at one far depth, so that a probe beside the body
tells the same whatever stands behind it.
"""

import numpy as np

from ..arrays import Floats, Singles
from .compile import compiled


@compiled
def probed(depth: Singles, row: int, column: int, down: float, across: float, far: float) -> float:
    """Depth (down, across) pixels beside a pixel; `far` outside the image."""
    r = row + int(np.floor(down + 0.5))
    c = column + int(np.floor(across + 0.5))
    if r < 0 or c < 0 or r >= depth.shape[0] or c >= depth.shape[1]:
        return far
    return float(depth[r, c])


@compiled
def differences(
    depth: Singles,
    rows: np.ndarray,
    columns: np.ndarray,
    fx: float,
    fy: float,
    far: float,
    clip: float,
    probes: Singles,
    out: Singles,
) -> None:
    """Feature f = d(x + u / d(x)) - d(x + v / d(x)) of every pixel (Shotton et al. 2011, eq. 1).

    Parameters
    ----------
    depth : (H, W) m along z, finite; `far` wherever the person is not.
    rows, columns : (N,) int32 pixels of the person.
    fx, fy : focal lengths in pixels: probes are in metres, so that cameras may differ.
    far : m, depth of what is not the person.
    clip : m, differences are held within ± this.
    probes : (F, 4) m: across and down of u, across and down of v.
    out : (N, F) m, written.
    """
    for i in range(len(rows)):
        row, column = rows[i], columns[i]
        z = float(depth[row, column])
        x, y = fx / z, fy / z
        for f in range(len(probes)):
            one = probed(depth, row, column, probes[f, 1] * y, probes[f, 0] * x, far)
            other = probed(depth, row, column, probes[f, 3] * y, probes[f, 2] * x, far)
            out[i, f] = min(max(one - other, -clip), clip)


@compiled
def leaves(
    depth: Singles,
    rows: np.ndarray,
    columns: np.ndarray,
    fx: float,
    fy: float,
    far: float,
    clip: float,
    probes: Singles,
    thresholds: Floats,
    children: np.ndarray,
    roots: np.ndarray,
    out: np.ndarray,
) -> None:
    """The leaf that each pixel reaches in each tree.

    Parameters
    ----------
    depth, rows, columns, fx, fy, far, clip : as of `differences`.
    probes : (M, 4) m, of every node of all trees.
    thresholds : (M,) m: to the first child when the feature is not greater.
    children : (M, 2) int32 nodes; a leaf has -1 - (its number) in both places.
    roots : (R,) int32 node of each tree's root.
    out : (N, R) int32 leaf numbers, written.
    """
    for i in range(len(rows)):
        row, column = rows[i], columns[i]
        z = float(depth[row, column])
        x, y = fx / z, fy / z
        for tree in range(len(roots)):
            node = roots[tree]
            while children[node, 0] >= 0:
                one = probed(depth, row, column, probes[node, 1] * y, probes[node, 0] * x, far)
                other = z
                if probes[node, 2] != 0.0 or probes[node, 3] != 0.0:
                    other = probed(depth, row, column, probes[node, 3] * y, probes[node, 2] * x, far)
                feature = np.float32(min(max(one - other, -clip), clip))
                node = children[node, 0] if feature <= thresholds[node] else children[node, 1]
            out[i, tree] = -1 - children[node, 0]


@compiled
def votes(
    reached: np.ndarray,
    parts: Singles,
    offsets: Singles,
    points: Floats,
    area: Floats,
    joint: int,
    least: float,
    places: Floats,
    weights: Floats,
) -> int:
    """Where the pixels say that a joint is: the mean of their leaves' votes, each as likely as the leaf says.

    Parameters
    ----------
    reached : (N, R) int32 leaves.
    parts : (L, C) probabilities of the parts.
    offsets : (L, C, 3) m, from a pixel to the joint of the part.
    points : (N, 3) m, of the pixels.
    area : (N,) m^2 that a pixel stands for.
    joint : which part.
    least : pixels that are less likely of the part have no vote.
    places : (N, 3) m, written.
    weights : (N,) m^2, written: area times squared probability.

    Returns
    -------
    How many voted.
    """
    count = 0
    trees = reached.shape[1]
    for i in range(len(points)):
        total, x, y, z = 0.0, 0.0, 0.0, 0.0
        for tree in range(trees):
            leaf = reached[i, tree]
            share = parts[leaf, joint]
            total += share
            x += share * offsets[leaf, joint, 0]
            y += share * offsets[leaf, joint, 1]
            z += share * offsets[leaf, joint, 2]
        if total <= least * trees:
            continue
        places[count, 0] = points[i, 0] + x / total
        places[count, 1] = points[i, 1] + y / total
        places[count, 2] = points[i, 2] + z / total
        weights[count] = area[i] * (total / trees) ** 2
        count += 1
    return count


@compiled
def densest(
    points: Floats, weights: Floats, bandwidth: float, apart: float, rounds: int, places: Floats, masses: Floats
) -> int:
    """Modes of weighted points by mean shift with the Epanechnikov profile (Comaniciu & Meer 2002).

    A mode's mass is the sum of the weights within the bandwidth, each times 1 - (distance / bandwidth)^2.
    Points that went into a mode start no second one, so the modes come apart by at least `apart`.

    Parameters
    ----------
    points : (N, 3) m.
    weights : (N,) not negative.
    bandwidth : m.
    apart : m.
    rounds : most steps of each climb.
    places : (K, 3) m, written, the heaviest first.
    masses : (K,) written.

    Returns
    -------
    How many modes were found, at most K.
    """
    free = weights.copy()
    found = 0
    square = bandwidth * bandwidth
    for _ in range(4 * len(places)):  # two climbs may end on one mode
        if found == len(places):
            break
        start = -1
        for i in range(len(points)):
            if free[i] > 0.0 and (start < 0 or free[i] > free[start]):
                start = i
        if start < 0:
            break
        x, y, z = points[start, 0], points[start, 1], points[start, 2]
        for _step in range(rounds):
            total, sx, sy, sz = 0.0, 0.0, 0.0, 0.0
            for i in range(len(points)):
                dx, dy, dz = points[i, 0] - x, points[i, 1] - y, points[i, 2] - z
                if dx * dx + dy * dy + dz * dz < square:
                    w = weights[i]
                    total += w
                    sx += w * points[i, 0]
                    sy += w * points[i, 1]
                    sz += w * points[i, 2]
            nx, ny, nz = sx / total, sy / total, sz / total
            moved = (nx - x) ** 2 + (ny - y) ** 2 + (nz - z) ** 2
            x, y, z = nx, ny, nz
            if moved < 1e-8:
                break
        mass = 0.0
        for i in range(len(points)):
            distance = (points[i, 0] - x) ** 2 + (points[i, 1] - y) ** 2 + (points[i, 2] - z) ** 2
            if distance < square:
                mass += weights[i] * (1.0 - distance / square)
            if distance < apart * apart:
                free[i] = 0.0
        free[start] = 0.0
        known = False
        for k in range(found):
            gap = (places[k, 0] - x) ** 2 + (places[k, 1] - y) ** 2 + (places[k, 2] - z) ** 2
            if gap < apart * apart:
                known = True
        if known:
            continue
        place = found
        while place > 0 and masses[place - 1] < mass:
            masses[place] = masses[place - 1]
            for k in range(3):
                places[place, k] = places[place - 1, k]
            place -= 1
        masses[place] = mass
        places[place, 0], places[place, 1], places[place, 2] = x, y, z
        found += 1
    return found
