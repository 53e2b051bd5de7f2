"""Plain NumPy twins of what the tracker does with limbs: reaching, places, what is shown of a bone."""

import numpy as np

import naive_body
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
    """Pixels of each bone that are seen where they are rendered, and that are not; `bones` (H, W), -1 = none."""
    with np.errstate(invalid="ignore"):
        apart = seen - rendered
        shown = (bones >= 0) & (np.abs(apart) < fit)
        denied = (bones >= 0) & ((apart > fit) | free)
    return [np.bincount(bones[where], minlength=count) for where in (shown, denied)]
