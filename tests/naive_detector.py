"""Plain NumPy twins of the kernels that find people: `kernels/forest.py`, `regions.py` and `scene.py`."""

import numpy as np

# ---- kernels/forest.py -----------------------------------------------------------


def difference(depth, row, column, fx, fy, far, clip, probe):
    """Shotton's feature of one pixel."""
    values = []
    for across, down in (probe[:2], probe[2:]):
        z = float(depth[row, column])
        r = row + int(np.floor(float(down) * (fy / z) + 0.5))
        c = column + int(np.floor(float(across) * (fx / z) + 0.5))
        inside = 0 <= r < depth.shape[0] and 0 <= c < depth.shape[1]
        values.append(float(depth[r, c]) if inside else far)
    return np.float32(np.clip(values[0] - values[1], -clip, clip))


def leaf(depth, row, column, fx, fy, far, clip, probes, thresholds, children, root):
    """The leaf one pixel reaches."""
    node = root
    while children[node, 0] >= 0:
        feature = difference(depth, row, column, fx, fy, far, clip, probes[node])
        node = children[node, int(feature > thresholds[node])]
    return -1 - children[node, 0]


def mean_votes(reached, parts, offsets, points, area, joint, least):
    """Votes and weights of the pixels likely enough to be of a part."""
    share = parts[reached, joint].astype(float)
    likely = share.mean(axis=1) > least
    offset = (share[..., None] * offsets[reached, joint]).sum(axis=1)[likely] / share.sum(axis=1)[likely, None]
    return points[likely] + offset, area[likely] * share.mean(axis=1)[likely] ** 2


def climb(points, weights, bandwidth, start, rounds=200):
    """Mean shift from one place."""
    place = start
    for _ in range(rounds):
        near = np.linalg.norm(points - place, axis=1) < bandwidth
        place = weights[near] @ points[near] / weights[near].sum()
    return place


def mass(points, weights, bandwidth, place):
    """Epanechnikov-weighted sum at a place."""
    gap = np.linalg.norm(points - place, axis=1) / bandwidth
    return float((weights * np.maximum(1 - gap**2, 0)).sum())


# ---- kernels/regions.py ----------------------------------------------------------


def points(depth, intrinsics):
    """(H, W, 3) m."""
    fx, fy, cx, cy = intrinsics
    v, u = np.mgrid[: depth.shape[0], : depth.shape[1]]
    z = depth.astype(float)
    return np.stack([(u - cx) * z / fx, (v - cy) * z / fy, z], axis=-1)


def mended(depth, radius, enough, jump):
    """Holes of one pixel filled with the nearer surface's median, then a median of what is measured."""
    filled = depth.copy()
    for r, c in np.argwhere(np.isnan(depth)):
        ring = depth[max(r - 1, 0) : r + 2, max(c - 1, 0) : c + 2].ravel()
        ring = np.sort(ring[~np.isnan(ring)])
        if len(ring) >= enough:
            near = ring[: 1 + int(np.argmin(np.append(ring[1:] - ring[0] < jump, False)))]
            filled[r, c] = near[len(near) // 2]
    out = np.full_like(depth, np.nan)
    for r, c in np.argwhere(~np.isnan(filled)):
        window = filled[max(r - radius, 0) : r + radius + 1, max(c - radius, 0) : c + radius + 1]
        out[r, c] = np.nanmedian(window)
    return out


def blocks(depth, step, near, steep):
    """One depth for each block: the mean of what lies on the surface of its median."""
    out = np.full((-(-depth.shape[0] // step), -(-depth.shape[1] // step)), np.nan, np.float32)
    for r, c in np.ndindex(*out.shape):
        block = depth[r * step : (r + 1) * step, c * step : (c + 1) * step]
        there = np.sort(block[~np.isnan(block)].astype(float))
        if len(there) and 2 * len(there) >= block.size:
            middle = there[(len(there) - 1) // 2]
            out[r, c] = there[np.abs(there - middle) <= near + steep * middle**2].mean()
    return out


def bridges(depth, near, steep, longest):
    """Pixels within two to `longest` leaps the same way along a line, with something measured beyond both ends."""
    between = np.zeros(depth.shape, bool)
    for lines, marks in ((depth, between), (depth.T, between.T)):
        for line, mark in zip(lines, marks, strict=True):
            step = np.diff(line)
            with np.errstate(invalid="ignore"):
                leap = np.where(np.abs(step) > near + steep * np.fmin(line[:-1], line[1:]) ** 2, np.sign(step), 0.0)
            ends = np.flatnonzero(np.diff(leap) != 0) + 1
            for first, last in zip([0, *ends], [*ends, len(leap)], strict=True):
                inside = first > 0 and last < len(leap) and np.isfinite(step[[first - 1, last]]).all()
                if leap[first] and inside and 2 <= last - first <= longest:
                    mark[first + 1 : last] = True
    return between


def surfaces(depth, inside, near, steep):
    """Connected surfaces by flooding from each first pixel."""
    out = np.full(depth.shape, -1)
    count = 0
    for start in map(tuple, np.argwhere(inside)):
        if out[start] >= 0:
            continue
        out[start] = count
        edge = [start]
        while edge:
            r, c = edge.pop()
            for q in ((r - 1, c), (r + 1, c), (r, c - 1), (r, c + 1)):
                if not (0 <= q[0] < depth.shape[0] and 0 <= q[1] < depth.shape[1]) or not inside[q] or out[q] >= 0:
                    continue
                later = max((r, c), q)  # the threshold is of the pixel that comes later in the image
                if abs(depth[q] - depth[r, c]) < near + steep * depth[later] ** 2:
                    out[q] = count
                    edge.append(q)
        count += 1
    return out, count


def measures(depth, labels, moved, intrinsics, count):
    """Size and place of each surface."""
    world = points(depth, intrinsics)
    border = np.zeros(depth.shape, bool)
    border[[0, -1]] = border[:, [0, -1]] = True
    rows = []
    for s in range(count):
        own = labels == s
        at = world[own]
        box = np.stack([at.min(axis=0), at.max(axis=0)], axis=1).ravel()
        area = (at[:, 2] ** 2).sum() / (intrinsics[0] * intrinsics[1])
        three = own[:, 2:] & own[:, 1:-1] & own[:, :-2]
        bent = np.abs(np.diff(depth.astype(float), 2, axis=1))[three]
        rough = bent.mean() if three.any() else np.nan
        rows.append([own.sum(), area, *box, *at.mean(axis=0), moved[own].mean(), border[own].mean(), rough])
    return np.array(rows).reshape(count, 14)


# ---- kernels/scene.py ------------------------------------------------------------


def before_scene(depth, intrinsics, planes, background, near, steep):
    """Measured pixels in front of background and planes."""
    depth, background = depth.astype(float), background.astype(float)
    out = np.isfinite(depth) & ~(background - depth < near + steep * depth**2)
    world = points(depth, intrinsics)
    for plane in planes:
        along = world @ plane[:3]
        out &= ~(along + plane[3] < near + steep * depth * np.abs(along))
    return out


def hiding(depth, intrinsics, planes, near, steep, closest, free):
    """Free pixels but for those of things nearer than the person that stand clear of the planes."""
    nowhere = np.full(depth.shape, np.nan, np.float32)
    return free & ~(before_scene(depth, intrinsics, planes, nowhere, near, steep) & (depth < closest))


def farthest(depth, seen, person, near, steep, background):
    """The farthest background seen at each pixel; what lies on the person there is forgotten."""
    z = depth.astype(float)
    piece = np.isfinite(person) & (background - z < near + steep * z**2)
    known = np.where(piece, np.float32(np.nan), background)
    return np.fmax(known, np.where(seen, depth, np.float32(np.nan)))


def gaps(depth, person, free, reach, lost=2):
    """Narrow gaps between the person and something farther."""
    rim = np.zeros(depth.shape, bool)
    for turn in range(4):  # each way is to the right in an image turned so often
        d, p, f = (np.rot90(image, turn) for image in (depth, person, free))
        m = np.rot90(rim, turn)  # a view
        for r, c in np.argwhere(~np.isnan(p)):
            ends = np.flatnonzero(~np.isnan(d[r, c + 1 :]) | ~np.isnan(p[r, c + 1 :]))
            if not len(ends) or not f[r, c + 1 + ends[0]]:
                continue
            near, far, count = float(p[r, c]), float(d[r, c + 1 + ends[0]]), int(ends[0])
            widest = lost + (reach * (1 / near - 1 / far) if turn % 2 == 0 else 0.0)
            if far >= near and count <= widest:
                m[r, c + 1 : c + 1 + count] = True
    return rim
