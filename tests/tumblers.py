"""Stiff bodies with markers on them that fly and turn."""

import numpy as np


def tumbling(markers, frames, fps, rng, swing):
    """(T, 9 M) cm: three bodies of M markers each, which turn by `swing` rad to either side about once a second."""
    time = np.arange(frames) / fps
    parts = []
    for _ in range(3):
        home = rng.uniform(-15.0, 15.0, (markers, 3))
        angle = swing * np.sin(2.0 * np.pi * 0.9 * time + rng.uniform(0.0, 6.0))
        cos, sin, nil, one = np.cos(angle), np.sin(angle), 0.0 * angle, 1.0 + 0.0 * angle
        turn = np.stack([cos, -sin, nil, sin, cos, nil, nil, nil, one], axis=1).reshape(-1, 3, 3)
        way = 80.0 * np.sin(2.0 * np.pi * rng.uniform(0.3, 1.2, 3) * time[:, None] + rng.uniform(0.0, 6.0, 3))
        parts.append(np.einsum("tij,mj->tmi", turn, home) + way[:, None])
    return np.concatenate(parts, axis=1).reshape(frames, -1)
