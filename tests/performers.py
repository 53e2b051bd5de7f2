"""The synthetic performer's denoisers, and channels spoilt in a known way."""

from functools import lru_cache

import numpy as np

from motionmend.bodies.motion import Markers
from motionmend.bodies.skeleton import TRANSLATION
from motionmend.denoise import Denoiser, repair_without_model
from motionmend.denoise.adaptive.blocks import mend_channels
from motionmend.denoise.channels.joints import joint_rotation, root_angles, root_rows
from motionmend.denoise.channels.recording import to_channels
from motionmend.denoise.channels.travel import turn
from motionmend.denoise.library.local_prior import Prior, neighbourhood
from motionmend.numerics.ssa import at_rate
from motionmend.samples import clip, markers

FPS = 30.0


@lru_cache(maxsize=1)
def clips():
    people = ((1, -0.4), (2, 0.0), (3, 0.4))
    return tuple(
        clip(action, seconds=4.0, fps=FPS, seed=seed, style=style)
        for action in ("walk", "turn", "reach")
        for seed, style in people
    )


@lru_cache(maxsize=1)
def joints_model():
    return Denoiser(window=20, fps=FPS).fit(clips())


@lru_cache(maxsize=1)
def markers_model():
    return Denoiser(window=20, fps=FPS).fit([markers(c) for c in clips()])


def every_other(cloud):
    """Half of the markers, some on every limb: repairs take half the time, and fill gaps by the same ways."""
    return Markers(cloud.names[::2], cloud.positions[:, ::2], cloud.fps, up=cloud.up)


@lru_cache(maxsize=1)
def half_the_markers_model():
    return Denoiser(window=20, fps=FPS).fit([every_other(markers(c)) for c in clips()])


@lru_cache(maxsize=8)
def truth(action="walk", seed=9, seconds=5.0, fps=FPS):
    """A clip of somebody the models do not know."""
    return clip(action, seconds=seconds, fps=fps, seed=seed)


def channels_of(recording):
    """(T, C) degrees and cm."""
    model = joints_model() if hasattr(recording, "q") else markers_model()
    return to_channels(recording, model.layout).values


def spoilt(values, noise, outliers, seed=0):
    """(T, C) with noise and a share of samples 15 to 55 off; and where those are."""
    rng = np.random.default_rng(seed)
    hit = rng.random(values.shape) < outliers
    off = rng.choice([-1.0, 1.0], values.shape) * rng.uniform(15.0, 55.0, values.shape)
    return values + noise * rng.standard_normal(values.shape) + np.where(hit, off, 0.0), hit


def prior_of(model, fps=FPS):
    """What the model's library says of clean motion at a rate."""
    bases, stride = at_rate(model.bases, model.settings.fps, fps)
    return Prior(model.library.usual_bends(fps), bases, stride)


def mend(measured, fps=FPS, library=True, near=True):
    """`mend_channels` with the joints model's library, as `repair` does; or with no more than its bends."""
    model = joints_model()
    prior = prior_of(model, fps)
    if not library:
        return mend_channels(measured, Prior(prior.bends, None), fps)
    closer = neighbourhood(model.library, model.bases, model.settings.fps) if near else None
    return mend_channels(measured, prior, fps, near=closer)


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def f1(found, hit):
    """2 true / (found + there)."""
    return 2.0 * float((found & hit).sum()) / max(1, int(found.sum()) + int(hit.sum()))


def moved(recording, angle, shift):
    """The recording turned about the vertical and carried elsewhere."""
    if isinstance(recording, Markers):
        turned = recording.positions @ turn(np.array([angle]), recording.up)[0].T
        return recording.with_positions(turned + shift)
    skeleton = recording.skeleton
    turns, moves = root_rows(skeleton)
    about = turn(np.array([angle]), skeleton.up)[0]
    q = recording.q.copy()
    rotation = joint_rotation(skeleton, turns, q)
    q[:, turns] = np.radians(root_angles(skeleton, turns, about @ rotation))
    place = skeleton.offsets[0] + q[:, moves] @ skeleton.dof_axis[moves]
    q[:, moves] = (place @ about.T + shift - skeleton.offsets[0]) @ np.linalg.inv(skeleton.dof_axis[moves])
    return recording.with_q(q)


def lessened(clean, noise):
    """What a repair without a library leaves of noise (T, D), rad and half as much in m, in the angles that move: its
    share, root mean square, and how many of its own deviations each sample is off."""
    turns = np.asarray(clean.skeleton.dof_kind) != TRANSLATION
    noise = noise * np.where(turns, 1.0, 0.5)
    repaired = repair_without_model(clean.with_q(clean.q + noise), "adaptive")
    moving = turns & (np.ptp(clean.q, axis=0) > 1e-3)
    off = np.abs(repaired.recording.q - clean.q)[:, moving]
    return np.sqrt(np.square(off).mean() / np.square(noise[:, moving]).mean()), off / repaired.std[:, moving]
