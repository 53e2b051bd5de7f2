"""Plain NumPy twins of the performer's kernels: frames, increments, ray-casting, reaching."""

import numpy as np
from scipy.spatial.transform import Rotation

# ---- kernels/articulated.py -------------------------------------------------------


def frames(chain, translation, root, joints):
    """(B, 4, 4), world from bone, by products of 4x4 matrices."""
    parents, offsets, rests, first, axes = chain
    placed = np.empty((len(parents), 4, 4))
    for b, parent in enumerate(parents):
        step = np.eye(4)
        if parent < 0:
            step[:3, :3], step[:3, 3] = root, translation
            placed[b] = step
            continue
        rows = slice(first[b], first[b + 1])
        turn = Rotation.from_rotvec(joints[rows] @ axes[rows]).as_matrix()
        step[:3, :3], step[:3, 3] = rests[b] @ turn, offsets[b]
        placed[b] = placed[parent] @ step
    return placed


def advance(translation, root, joints, delta):
    """A pose after an increment, the root turned from the left."""
    return translation + delta[:3], Rotation.from_rotvec(delta[3:6]).as_matrix() @ root, joints + delta[6:]


def twists(chain, translation, root, joints, step=1e-6):
    """Central differences of the frames, (B, D, 6): what each degree of freedom does to each bone."""
    dofs = 6 + len(joints)
    before = frames(chain, translation, root, joints)
    result = np.zeros((len(before), dofs, 6))
    for d in range(dofs):
        delta = np.zeros(dofs)
        delta[d] = step
        ahead, behind = (frames(chain, *advance(translation, root, joints, sign * delta)) for sign in (1, -1))
        slope = (ahead - behind) / (2 * step)
        for b in range(len(before)):
            spin = slope[b, :3, :3] @ before[b, :3, :3].T
            omega = np.array([spin[2, 1] - spin[1, 2], spin[0, 2] - spin[2, 0], spin[1, 0] - spin[0, 1]]) / 2
            result[b, d] = [*omega, *(slope[b, :3, 3] - np.cross(omega, before[b, :3, 3]))]
    return result


# ---- kernels/raycast.py -----------------------------------------------------------


def place(placed_bones, solids):
    """(P, 3, 4), world from solid."""
    result = np.empty((len(solids), 3, 4))
    for s, b in enumerate(solids.bone):
        result[s, :, :3] = placed_bones[b, :3, :3] @ solids.turn[s]
        result[s, :, 3] = placed_bones[b, :3, :3] @ solids.center[s] + placed_bones[b, :3, 3]
    return result


def first_meeting(origin, directions, kind, taper):
    """Where origin + z·directions (N, 3), in half extents, first enter a solid; inf where they miss.

    Every surface is tried, the unit sphere or the side x² + w² = (1 + taper·y)² and both flat ends, both roots each.
    """
    ox, oy, ow = origin
    dx, dy, dw = directions.T
    if kind == 0:
        a, b, c = dx * dx + dy * dy + dw * dw, ox * dx + oy * dy + ow * dw, ox * ox + oy * oy + ow * ow - 1
    else:
        e0, e1 = 1 + taper * oy, taper * dy
        a, b, c = dx * dx + dw * dw - e1 * e1, ox * dx + ow * dw - e0 * e1, ox * ox + ow * ow - e0 * e0
    candidates = []
    with np.errstate(invalid="ignore", divide="ignore"):
        for sign in (-1, 1):
            z = (-b + sign * np.sqrt(b * b - a * c)) / a
            inside = (kind == 0) | (np.abs(oy + z * dy) <= 1)
            candidates.append(np.where(inside & (z > 0), z, np.inf))
        for end in (-1, 1) if kind == 1 else ():
            z = (end - oy) / dy
            inside = (ox + z * dx) ** 2 + (ow + z * dw) ** 2 <= (1 + taper * end) ** 2
            candidates.append(np.where(inside & (z > 0), z, np.inf))
    return np.min(candidates, axis=0)


def cast(placed, solids, camera, pixels):
    """Depth (N,) and solid (N,) at pixels (N, 2): every solid for every ray."""
    u, v = np.asarray(pixels, dtype=float).T
    rays = np.stack(((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, np.ones(len(u))), axis=1)
    depth = np.empty((len(solids), len(u)))
    for s in range(len(solids)):
        turn, center = placed[s, :, :3], placed[s, :, 3]
        origin, directions = turn.T @ -center / solids.size[s], rays @ turn / solids.size[s]
        depth[s] = first_meeting(origin, directions, solids.kind[s], solids.taper[s])
    nearest = depth.min(axis=0)
    return nearest, np.where(np.isfinite(nearest), depth.argmin(axis=0), -1)
