"""Plain NumPy twins of what the tracker does with limbs: reaching, places, what is shown of a bone, how wide it is."""

import numpy as np

import naive_body
import naive_tracking
from motionmend.bodies.performer import DOFS, Pose, advance, landmarks, twists


def reach_within(performer, pose, moves, wanted, weight, stiffness, loose, rounds):
    """Levenberg-Marquardt over the landmarks (16, 3), steps of half a radian at most, limits by clipping."""
    low, high = performer.limits[6:].T
    stiff = np.concatenate((np.zeros(6), np.full(DOFS - 6, stiffness**2)))
    begin, damping = pose, 1e-4

    def cost_of(at):
        place, bent = landmarks(performer, at), at.joints - begin.joints
        return weight @ ((wanted - place) ** 2).sum(axis=1) + stiffness**2 * bent @ bent, place

    cost, place = cost_of(pose)
    for _ in range(rounds):
        turn = twists(performer, pose)
        slope = np.cross(turn[None, :, :3], place[:, None, :]) + turn[None, :, 3:]
        slope = np.where((moves & loose)[..., None], slope, 0.0)
        rows = (slope * weight[:, None, None]).transpose(0, 2, 1).reshape(-1, DOFS)
        normal = slope.transpose(0, 2, 1).reshape(-1, DOFS).T @ rows + np.diag(stiff)
        right = rows.T @ (wanted - place).ravel()
        right[6:] -= stiff[6:] * (pose.joints - begin.joints)
        right[~loose] = 0.0
        for _ in range(6):
            step = np.linalg.solve(normal + damping * np.eye(DOFS), right)
            step *= min(1.0, 0.5 / max(np.abs(step).max(), 1e-12))
            tried = advance(performer, pose, step)
            joints = np.where(loose[6:], np.clip(tried.joints, low, high), tried.joints)
            tried = Pose(tried.translation, tried.root, joints)
            new, at = cost_of(tried)
            if new < cost:
                break
            damping *= 8.0
        else:
            break
        gained, pose, cost, place, damping = cost - new, tried, new, at, damping / 4.0
        if gained < 1e-5 * cost + 1e-9:
            break
    return pose


def limb_places(performer, pose, limb, candidates):
    """(C, K, 3) the limb's landmarks with other joint coordinates, by whole chains."""
    found = []
    for row in candidates:
        joints = pose.joints.copy()
        joints[limb.columns] = row
        frames = naive_body.frames(performer.chain, pose.translation, pose.root, joints)
        bones, local = performer.landmark_bone[limb.landmarks], performer.landmark_place[limb.landmarks]
        found.append(np.einsum("kij,kj->ki", frames[bones, :3, :3], local) + frames[bones, :3, 3])
    return np.array(found)


def shown_and_denied(seen, free, rendered, bones, fit, count):
    """Pixels of each bone seen where they are rendered, not there, and unknown; `bones` (H, W), -1 = none."""
    with np.errstate(invalid="ignore"):
        apart = seen - rendered
        shown = (bones >= 0) & (np.abs(apart) < fit)
        denied = (bones >= 0) & ((apart > fit) | free)
    unknown = (bones >= 0) & np.isnan(seen) & ~free
    return [np.bincount(bones[where], minlength=count) for where in (shown, denied, unknown)]


def width_systems(points, directions, residuals, bones, frames, scale, trust):
    """(B, 10, 10) sums over matches (N, ...) of rows [x × n, n, stretches along the bone's axes, residual]."""
    systems = np.zeros((len(frames), 10, 10))
    for x, n, off, b in zip(points.astype(float), directions.astype(float), residuals, bones, strict=True):
        turn, origin = frames[b, :3, :3], frames[b, :3, 3]
        row = np.concatenate((np.cross(x, n), n, turn.T @ (x - origin) * (turn.T @ n), [off]))
        systems[b] += trust / (1.0 + (off / scale) ** 2) ** 2 * np.outer(row, row)
    return systems


def widths_from_model(pixels, points, normals, bones, frames, target, free, focal, reach, half, gate, scale, trust):
    """Model points (N, 3) along their normals to the nearest of `target` (H, W, 3); where nobody is, sideways."""
    out = free[tuple(pixels.T)]
    _, index = naive_tracking.nearest_in_window(pixels, points, target, half, gate)
    hit = ~out & (index >= 0)
    off = np.einsum("ni,ni->n", target.reshape(-1, 3)[index[hit]] - points[hit], normals[hit].astype(float))
    found = width_systems(points[hit], normals[hit], off, bones[hit], frames, scale, trust)
    rows, columns = np.nonzero(~free)
    aside, carried, shifts = [], [], []
    for (row, column), point, bone in zip(pixels[out], points[out], bones[out], strict=True):
        down, across = rows - row, columns - column
        ring, squared = np.maximum(np.abs(down), np.abs(across)), down**2 + across**2
        # Of the nearest the first met on the way outward, row by row.
        order = np.lexsort((across, down, ring, squared))
        near = order[(ring[order] <= reach) & (squared[order] < (reach + 1) ** 2)][:1]
        for k in near:
            aside.append(point)
            carried.append(bone)
            shifts.append(np.array([across[k], down[k], 0.0]) / focal * float(point[2]))
    size = np.linalg.norm(shifts, axis=1)
    found += width_systems(np.array(aside), shifts / size[:, None], size, carried, frames, scale, trust)
    return found, hit, size


def widths_from_seen(pixels, samples, model, bones, frames, half, gate, scale, trust):
    """To observed points (N, 3) beside the model (H, W, 3), on bones (H, W), its nearest points straight."""
    beside = np.isnan(model[tuple(pixels.T)]).any(axis=1)
    _, index = naive_tracking.nearest_in_window(pixels, samples, model, half, gate)
    hit = beside & (index >= 0)
    points = model.reshape(-1, 3)[index[hit]]
    away = samples[hit] - points
    size = np.linalg.norm(away, axis=1)
    return width_systems(points, away / size[:, None], size, bones.ravel()[index[hit]], frames, scale, trust), hit


def judged(seen, free, rendered, bones, gate, count):
    """Whole images: wrongness, pixels left over, of bones, denied, and how many of person, body, either, these two."""
    person, model = np.isfinite(seen), bones >= 0
    both = person & model
    apart = np.zeros(seen.shape)
    apart[both] = seen[both].astype(float) - rendered[both]
    near = both & (np.abs(apart) < gate)
    loose = person & ~_beside(near) & ~near
    denied = (model & ~person & free & ~_beside(person)) | (both & (apart > gate))
    either = person | (model & free)
    off = np.where(both, np.minimum(np.abs(apart) / gate, 1.0), 1.0)[either].sum()
    parts = [np.bincount(bones[where], minlength=count) for where in (model, denied)]
    return off, np.argwhere(loose), *parts, [person.sum(), model.sum(), either.sum(), loose.sum(), denied.sum()]


def _beside(mask):
    wide = np.pad(mask, 1)
    return wide[:-2, 1:-1] | wide[2:, 1:-1] | wide[1:-1, :-2] | wide[1:-1, 2:]


def narrowed(cost, some, limits, drawn):
    """The cross-entropy method with what is drawn given: the best of `some` (C, n), and what each of those costs."""
    first = costs = np.array([cost(row) for row in some])
    for picks, noise in zip(drawn.picks, drawn.noise, strict=True):
        best = np.argsort(costs, kind="stable")[: drawn.kept]
        some, costs = some[best], costs[best]
        fresh = np.clip(some[picks] + noise, *limits.T)
        some, costs = np.concatenate((some, fresh)), np.append(costs, [cost(row) for row in fresh])
    return first, some[np.argmin(costs)], costs.min()
