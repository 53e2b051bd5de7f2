"""Plain NumPy twins of the tracker's kernels: slow, short, and plainly right."""

from dataclasses import replace

import numpy as np

from motionmend.bodies.performer import bone_frames, twists
from motionmend.bodies.solids import CONE, Solids

# ---- kernels/match.py ------------------------------------------------------------


def nearest_in_window(pixels, points, target, half, gate, tones=None, target_tones=None, tone_weight=0.0):
    """Distances (N,) to the nearest point in the window, NaN where none is within the gate, and their flat indices."""
    height, width = target.shape[:2]
    best = np.full(len(pixels), np.nan)
    index = np.full(len(pixels), -1)
    for i, (row, column) in enumerate(pixels):
        for r in range(max(0, row - half), min(height, row + half + 1)):
            for c in range(max(0, column - half), min(width, column + half + 1)):
                distance = np.linalg.norm(target[r, c].astype(float) - points[i].astype(float))
                if tone_weight > 0 and np.isfinite(tones[i]) and np.isfinite(target_tones[r, c]):
                    distance = np.hypot(distance, np.sqrt(tone_weight) * (float(target_tones[r, c]) - float(tones[i])))
                if distance < gate and not distance >= best[i]:
                    best[i], index[i] = distance, r * width + c
    return best, index


def bone_system(points, normals, residuals, along, scale, weight):
    """(6, 6) and (6,) of one bone's matches: rows [x × n, n] and, for the part in all directions, [x × e, e]."""
    hessian, gradient, cost = np.zeros((6, 6)), np.zeros(6), 0.0
    for x, n, r in zip(points, normals, residuals, strict=True):
        squared = along * (n @ r) ** 2 + (1 - along) * (r @ r)
        w = weight if np.isinf(scale) else weight * (scale**2 / (scale**2 + squared)) ** 2
        cost += weight * squared if np.isinf(scale) else weight * squared * scale**2 / (scale**2 + squared)
        for direction, share in [(n, along), *((e, 1 - along) for e in np.eye(3))]:
            row = np.concatenate((np.cross(x, direction), direction))
            hessian += w * share * np.outer(row, row)
            gradient += w * share * row * (direction @ r)
    return hessian, gradient, cost


def assembled(hessian, gradient, twists, moves):
    """Chain rule over all bones: (D, D) and (D,)."""
    normal, right = np.zeros((len(twists), len(twists))), np.zeros(len(twists))
    for b in range(len(hessian)):
        full = np.triu(hessian[b]) + np.triu(hessian[b], 1).T
        slope = twists * moves[b][:, None]
        normal += slope @ full @ slope.T
        right += slope @ gradient[b]
    return normal, right


def outward_shift(row, column, free):
    """Rows and columns to the nearest pixel that is not free, squared distance; None when all are."""
    rows, columns = np.nonzero(~free)
    if not len(rows):
        return None
    return int(((rows - row) ** 2 + (columns - column) ** 2).min())


def near_sides(depth, unknown, jump):
    """(H, W) True beside an empty or much farther pixel that is not unknown."""
    edge = np.zeros(depth.shape, bool)
    for r, c in np.argwhere(np.isfinite(depth)):
        for dr, dc in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            y, x = r + dr, c + dc
            if 0 <= y < depth.shape[0] and 0 <= x < depth.shape[1] and not unknown[y, x]:
                edge[r, c] |= np.isnan(depth[y, x]) or depth[y, x] > depth[r, c] + np.float32(jump)
    return edge


def joint_spread(covariance, twists, moved, point):
    """Root of a third of the trace of a point's covariance."""
    slope = np.where(moved[:, None], np.cross(twists[:, :3], point) + twists[:, 3:], 0.0)
    return np.sqrt(np.trace(slope.T @ covariance @ slope) / 3)


# ---- kernels/limbs.py ------------------------------------------------------------


def disagreement(seen, free, rendered, most, without=None):
    """Sum over pixels: unknown 0, only one of both 1, or 0.7 next to the other, else the capped difference.

    `without` : rendered without a limb, whose outline has no margin then.
    """
    both = np.isfinite(seen) & np.isfinite(rendered)
    missed, claimed = np.isfinite(seen) & np.isnan(rendered), np.isnan(seen) & free & np.isfinite(rendered)
    model = np.isfinite(rendered if without is None else without)
    total = np.minimum(1.0, np.abs(seen[both].astype(float) - rendered[both]) / most).sum()
    for fault, body in ((missed, model), (claimed, np.isfinite(seen))):
        grown = np.pad(body, 1)
        near = grown[2:, 1:-1] | grown[:-2, 1:-1] | grown[1:-1, 2:] | grown[1:-1, :-2]
        total += np.where(near[fault], 0.7, 1.0).sum()
    return total


def without_limb(body, limb):
    """The performer but for the solids of a limb."""
    bone, *others = body.solids.arrays
    kept = ~np.isin(bone, limb.bones)
    return replace(body, solids=Solids(bone[kept], *(part[kept] for part in others)))


# ---- kernels/inside.py -----------------------------------------------------------


def depth_inside(frame, solids, s, point):
    """How deep a point is inside solid s, to first order; how much that counts; the way out."""
    x = solids.turn[s].T @ (frame[:3, :3].T @ (point - frame[:3, 3]) - solids.center[s])
    radii, share = solids.size[s].copy(), 1.0
    if solids.kind[s] == CONE:
        share = np.clip((radii[1] - abs(x[1])) / 0.04, 0.0, 1.0)
        radii[[0, 2]] *= 1.0 + solids.taper[s] * x[1] / radii[1]
        x[1] = 0.0
    far = np.linalg.norm(x / radii)
    slope = x / radii**2 / far
    out = frame[:3, :3] @ solids.turn[s] @ slope / np.linalg.norm(slope)
    return (1.0 - far) / np.linalg.norm(slope), share, out


def ball(solids, s):
    """The radius of a ball about solid s that holds it."""
    x, y, z = solids.size[s]
    return np.hypot(max(x, z) * (1.0 + abs(solids.taper[s])), y) if solids.kind[s] == CONE else max(x, y, z)


def kept_out(body, pose, trunk, limbs, clear, scale, weight):
    """Cost, (34, 34) and (34,): Geman and McClure's squares of how deep points along limbs are in the trunk."""
    frames, moving, solids = bone_frames(body, pose), twists(body, pose), body.solids
    cost, normal, right = 0.0, np.zeros((len(moving), len(moving))), np.zeros(len(moving))
    for limb, margin in zip(limbs, clear, strict=True):
        bone = solids.bone[limb]
        for along in (-1.5, -1.0, -0.4, 0.3, 1.0):
            local = solids.center[limb] + along * solids.size[limb, 1] * solids.turn[limb][:, 1]
            point = frames[bone][:3, :3] @ local + frames[bone][:3, 3]
            for s in trunk:
                carrier = solids.bone[s]
                deep, share, out = depth_inside(frames[carrier], solids, s, point)
                middle = frames[carrier][:3, :3] @ solids.center[s] + frames[carrier][:3, 3]
                near = np.linalg.norm(point - middle) <= ball(solids, s) + margin
                deep = max(deep + margin, 0.0) * near
                speeds = (np.cross(moving[:, :3], point) + moving[:, 3:]) @ out
                slope = speeds * (body.moves[bone].astype(float) - body.moves[carrier])
                shrink = scale**2 / (scale**2 + deep**2)
                cost += weight * share * shrink * deep**2
                normal += weight * share * shrink**2 * np.outer(slope, slope) * (deep > 0.0)
                right += weight * share * shrink**2 * deep * slope
    return cost, normal, right


def refit_plane(cloud, area, plane, limits, rounds):
    """The plane, and m² of what is near it, on it as it was, and as it is now; by least squares from SVDs."""
    near, still, steep, grazing = limits

    def on(plane, more=0.0):
        slope = np.abs(cloud @ plane[:3])
        return np.abs(cloud @ plane[:3] + plane[3]) < still + steep * cloud[:, 2] * slope + more

    def seen(plane, of, some):
        slope = np.abs(cloud @ of[:3]) / np.linalg.norm(cloud, axis=1)
        return float((area / np.maximum(slope, grazing))[some].sum())

    close = on(plane, near)
    out = plane
    for turn in range(rounds):
        some = close if turn == 0 else on(out)
        root = np.sqrt(area[some]) / cloud[some, 2] ** 2
        across = np.linalg.svd(out[None, :3])[2][1:]
        columns = np.column_stack([cloud[some] @ across.T, np.ones(some.sum())])
        step = np.linalg.lstsq(columns * root[:, None], -(cloud[some] @ out[:3] + out[3]) * root, rcond=None)[0]
        out = out + np.append(step[:2] @ across, step[2])
        out = out / np.linalg.norm(out[:3])
    return np.append(out, [seen(plane, plane, close), seen(plane, plane, on(plane)), seen(out, out, on(out))])
