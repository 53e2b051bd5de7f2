"""Small noisy depth images with a step in them."""

import numpy as np

from motionmend.arrays import frozen

INTRINSICS = np.array([30.0, 28.0, 15.5, 11.5])


def stepped(rng, missing=0.25):
    """(18, 22) m, read-only as frames are: two walls side by side, a share of the pixels missing."""
    depth = (2.0 + 0.02 * rng.normal(size=(18, 22))).astype(np.float32)
    depth[:, 11:] += 0.6
    depth[rng.uniform(size=depth.shape) < missing] = np.nan
    return frozen(depth, np.float32)
