"""Plain NumPy twins of the kernels that learn offsets and tell them: slow, short, and plainly right."""

import numpy as np

# ---- kernels/learning.py ---------------------------------------------------------


def learn(model, hyper, sample, value, size):
    """One local model (n, D), (n, P) with a sample more; a full one first loses the sample that matters least."""
    from motionmend.numerics.local_gp import Hyper, budget

    x, y = model
    if len(x) == size:
        kept = budget(x, y, Hyper(*hyper), size - 1)
        x, y = x[kept], y[kept]
    return np.vstack([x, sample]), np.vstack([y, value])


# ---- kernels/shapes.py -----------------------------------------------------------


def directions(postures, bones, weight):
    """Directions and lengths of bones."""
    along = postures[:, bones[:, 1]] - postures[:, bones[:, 0]]
    length = np.linalg.norm(along, axis=2, keepdims=True)
    return np.concatenate([weight * along / np.maximum(length, 1e-9), length], axis=2)


def apart(features, centre, columns):
    """Squared distances bone by bone."""
    return (((features - centre)[:, None] - columns.T) ** 2).sum(axis=3).swapaxes(1, 2)


def told(like, weights, joints, mean, scouts, spread, floor, familiar):
    """Offsets and their variance."""
    near = like[:, -1, : len(scouts)]
    known = np.minimum(np.einsum("ts,sr,tr->t", near, scouts, near), 1.0)
    offsets = np.tile(mean, (len(like), 1, 1))
    counts = np.minimum(known / familiar, 1.0)[:, None, None]
    offsets[:, joints] += counts * np.einsum("tkm,kmd->tkd", like[:, :-1], weights)
    return offsets, (1.0 - known)[:, None] * spread + floor
