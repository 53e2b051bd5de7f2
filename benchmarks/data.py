"""Recordings to measure on: a seeded performer of 62 degrees of freedom, so that the gate runs anywhere."""

import os
from functools import lru_cache
from pathlib import Path

import numpy as np
from scipy.signal import butter, sosfiltfilt
from threadpoolctl import threadpool_limits

from motionmend.arrays import Floats
from motionmend.bodies.motion import Markers, Motion
from motionmend.bodies.skeleton import ROTATION, TRANSLATION, Skeleton, positions
from motionmend.denoise.channels.layout import Layout, learn_layout
from motionmend.denoise.channels.recording import to_channels
from motionmend.evaluate import corrupt
from motionmend.io import read
from motionmend.numerics.ssa import Eigenbases, eigenbases, lag_covariance

FPS, WINDOW, ENERGY = 30.0, 20, 0.99  # the dissertation's rate, window and share of the variance
SEED = 2012
NOISE, OUTLIERS, GAPS = 1.0, 0.02, 0.02  # degrees; shares of the samples
REAL_WALKS = (15, 16, 21, 22, 31, 32)

# joint, parent, offset in m, axes it turns about: the joint angles that CMU's recordings have
_BODY = (
    ("root", "", (0.0, 0.0, 0.0), "xyz"),
    ("lowerback", "root", (0.0, 0.03, 0.0), "xyz"),
    ("upperback", "lowerback", (0.0, 0.12, 0.0), "xyz"),
    ("thorax", "upperback", (0.0, 0.12, 0.0), "xyz"),
    ("lowerneck", "thorax", (0.0, 0.15, 0.0), "xyz"),
    ("upperneck", "lowerneck", (0.0, 0.08, 0.0), "xyz"),
    ("head", "upperneck", (0.0, 0.08, 0.0), "xyz"),
    ("head_end", "head", (0.0, 0.10, 0.0), ""),
)
_ARM = (
    ("clavicle", "thorax", (0.03, 0.10, 0.0), "yz"),
    ("humerus", "clavicle", (0.16, 0.03, 0.0), "xyz"),
    ("radius", "humerus", (0.28, 0.0, 0.0), "x"),
    ("wrist", "radius", (0.24, 0.0, 0.0), "y"),
    ("hand", "wrist", (0.03, 0.0, 0.0), "xz"),
    ("fingers", "hand", (0.08, 0.0, 0.0), "x"),
    ("thumb", "hand", (0.03, 0.0, 0.03), "xz"),
)
_LEG = (
    ("femur", "root", (0.10, -0.05, 0.0), "xyz"),
    ("tibia", "femur", (0.0, -0.42, 0.0), "x"),
    ("foot", "tibia", (0.0, -0.42, 0.0), "xz"),
    ("toes", "foot", (0.0, -0.05, 0.14), "x"),
)
_LATENTS = 16  # independent smooth signals that drive all joints
_FALL = 0.82  # each as much weaker than the one before
_FASTEST = 1.9  # Hz
_TREMBLE = 0.05  # degrees of each channel's own


def skeleton() -> Skeleton:
    """A body of 30 joints and 62 degrees of freedom, 1.7 m tall."""
    rows = list(_BODY)
    for side, sign in (("l", 1.0), ("r", -1.0)):
        own = {name for name, *_ in (*_ARM, *_LEG)}
        for name, parent, (x, y, z), axes in (*_ARM, *_LEG):
            rows.append((side + name, side + parent if parent in own else parent, (sign * x, y, z), axes))
    names = [name for name, *_ in rows]
    dofs = [("root", TRANSLATION, axis) for axis in "xyz"]
    dofs += [(name, ROTATION, axis) for name, _, _, axes in rows for axis in axes]
    return Skeleton(
        names=tuple(names),
        parents=np.array([names.index(parent) if parent else -1 for _, parent, _, _ in rows]),
        offsets=np.array([offset for _, _, offset, _ in rows]),
        dof_names=tuple(f"{name}.{'r' if kind == ROTATION else 't'}{axis}" for name, kind, axis in dofs),
        dof_joint=np.array([names.index(name) for name, _, _ in dofs]),
        dof_axis=np.array([np.eye(3)["xyz".index(axis)] for _, _, axis in dofs]),
        dof_kind=np.array([kind for _, kind, _ in dofs]),
        limits=np.tile([-np.inf, np.inf], (len(dofs), 1)),
    )


def motion(frames: int, fps: float = FPS, seed: int = SEED) -> Motion:
    """The performer moving about: smooth joint angles that depend on each other, walking where the heading goes."""
    body = skeleton()
    rng = np.random.default_rng(seed)
    mixing = np.random.default_rng(SEED).standard_normal((_LATENTS, len(body.dof_names))) / np.sqrt(_LATENTS)
    latents = _smooth(rng, frames, _LATENTS, fps, _FASTEST) * (35.0 * _FALL ** np.arange(_LATENTS))
    degrees = latents @ mixing + _TREMBLE * rng.standard_normal((frames, len(body.dof_names)))
    heading = np.cumsum(_smooth(rng, frames, 1, fps, 0.1)[:, 0]) * 0.5 / fps
    speed = 1.0 + 0.3 * _smooth(rng, frames, 1, fps, 0.2)[:, 0]
    q = np.radians(degrees)
    q[:, :3] = 0.01 * degrees[:, :3]
    q[:, 0] += np.cumsum(speed * np.sin(heading)) / fps
    q[:, 1] += 0.95
    q[:, 2] += np.cumsum(speed * np.cos(heading)) / fps
    q[:, 3:6] *= 0.3
    q[:, 4] += heading
    return Motion(body, q, fps)


def spoiled(clean: Motion, *, gaps: float = GAPS) -> Motion:
    """The motion with noise, outliers and, unless `gaps` is 0, bursts of missing samples."""
    return corrupt(clean, noise=np.radians(NOISE), outliers=OUTLIERS, gaps=gaps, seed=SEED).recording


def markers(frames: int, fps: float = 120.0) -> Markers:
    """41 markers at the performer's joints and beside them, a tenth of the samples missing in bursts."""
    moved = motion(frames, fps)
    joints = positions(moved.skeleton, moved.q)
    beside = joints[:, :11] + np.array([0.05, 0.0, 0.05])
    names = (*moved.skeleton.names, *(f"{name}_2" for name in moved.skeleton.names[:11]))
    whole = Markers(names, np.concatenate([joints, beside], axis=1), fps, up=moved.skeleton.up)
    return corrupt(whole, gaps=0.1, seed=SEED).recording


@lru_cache(maxsize=1)
def learned() -> tuple[Layout, Eigenbases]:
    """Layout and bases from 10,000 clean frames of the performer."""
    clean = motion(10_000)
    with threadpool_limits(1):
        layout = learn_layout([clean])
        return layout, eigenbases(lag_covariance(to_channels(clean, layout).values, WINDOW), ENERGY)


def channels(recording: Motion) -> Floats:
    """(T, 62) degrees and centimetres, as the learned layout has them."""
    return to_channels(recording, learned()[0]).values


def real_folder() -> Path | None:
    """The folder of real recordings below MOTIONMEND_DATA, None where it is not set or holds none."""
    named = os.environ.get("MOTIONMEND_DATA")
    folder = Path(named) / "mocap" if named else None
    return folder if folder is not None and folder.is_dir() else None


def real_clips(folder: Path) -> list[Motion]:
    """Walks of one person, CMU joint angles at 120 Hz, as many of them as are there."""
    files = [folder / "amc" / "16" / f"16_{trial}.amc" for trial in REAL_WALKS]
    found = [read(file, fps=120.0) for file in files if file.exists()]
    return [clip for clip in found if isinstance(clip, Motion)]


def _smooth(rng: np.random.Generator, frames: int, count: int, fps: float, fastest: float) -> Floats:
    """(T, count) band-limited noise of unit variance."""
    margin = int(10 * fps / fastest)
    noise = rng.standard_normal((frames + 2 * margin, count))
    slow = sosfiltfilt(butter(4, fastest, fs=fps, output="sos"), noise, axis=0)
    return np.asarray(slow[margin:-margin] / slow.std(axis=0))
