"""Ridge regression of missing markers on those that are there, its strength cross-validated: the plain way to do it."""

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

import motionmend as mm
from motionmend.arrays import Bools, Floats, Ints
from motionmend.denoise.channels.cloud import CloudChannels
from motionmend.denoise.channels.layout import Layout
from motionmend.denoise.channels.recording import Channels, from_channels, to_channels

Guess = Callable[[Floats], Floats]

STRENGTHS = 10.0 ** np.arange(-4.0, 3.0, 0.5)  # of the mean variance of the features
FOLDS = 5


def fill_by_ridge(cut: mm.Markers, library: Sequence[mm.Markers], layout: Layout) -> mm.Markers:
    """Markers missing throughout, from the markers that are there, in the travelling frame.

    The library's frames are seen as the recording is: with the same markers missing, so that the frame is found from
    the same markers.
    """
    gone = tuple(name for name, seen in zip(cut.names, cut.present.any(axis=0), strict=True) if not seen)
    channels = to_channels(cut, layout)
    wanted = ~np.isfinite(channels.values).any(axis=0)
    x, y, fold = _examples(library, layout, gone, wanted)
    filled = np.where(wanted, 0.0, channels.values)
    there = _bridged(channels.values[:, ~wanted], x.mean(axis=0))
    filled[:, wanted] = _ridge(x, y, fold)(there)
    everywhere: Bools = np.ones(filled.shape, dtype=bool)
    return cut.with_positions(from_channels(channels, filled, everywhere, cut))


def _examples(
    library: Sequence[mm.Markers], layout: Layout, gone: tuple[str, ...], wanted: Bools
) -> tuple[Floats, Floats, Ints]:
    """Features (N, P), targets (N, W) in the frame of what is seen, and the fold of each frame."""
    features, targets, folds = [], [], []
    for number, clip in enumerate(library):
        seen = to_channels(mm.corrupt(clip, drop=gone).recording, layout)
        target = _in_frame_of(seen, clip)
        whole = np.isfinite(seen.values[:, ~wanted]).all(axis=1) & np.isfinite(target[:, wanted]).all(axis=1)
        features.append(seen.values[whole][:, ~wanted])
        targets.append(target[whole][:, wanted])
        pieces = np.arange(len(features[-1])) * FOLDS // max(1, len(features[-1]))
        folds.append(pieces if len(library) < FOLDS else np.full(len(features[-1]), number % FOLDS))
    return np.concatenate(features), np.concatenate(targets), np.concatenate(folds)


def _in_frame_of(seen: Channels, clip: mm.Markers) -> Floats:
    """All channels of the clip in the travelling frame that its seen part has."""
    assert isinstance(seen.inner, CloudChannels)
    travel = seen.inner.travel
    upright = clip.positions[:, seen.columns] @ seen.inner.righting.T
    at = np.einsum("tji,tmj->tmi", travel.rotations(), upright - travel.place[:, None])
    return np.asarray(100 * at.reshape(clip.frames, -1))


def _ridge(x: Floats, y: Floats, fold: Ints) -> Guess:
    """The regression of the strength that predicts held-out pieces best."""
    errors = np.zeros(len(STRENGTHS))
    for one in np.unique(fold):
        held = fold == one
        for number, guess in enumerate(_solved(x[~held], y[~held], STRENGTHS)):
            errors[number] += np.square(guess(x[held]) - y[held]).sum()
    return _solved(x, y, STRENGTHS[[errors.argmin()]])[0]


def _solved(x: Floats, y: Floats, strengths: Floats) -> list[Guess]:
    middle, target = x.mean(axis=0), y.mean(axis=0)
    spread = x.std(axis=0) + 1e-6
    scaled = (x - middle) / spread
    values, vectors = np.linalg.eigh(scaled.T @ scaled / len(x))
    turned = vectors.T @ (scaled.T @ (y - target) / len(x))
    weights = [vectors @ (turned / (np.maximum(values, 0.0) + strength)[:, None]) for strength in strengths]

    def guess(new: Floats, weight: Floats) -> Floats:
        return np.asarray(target + (new - middle) / spread @ weight)

    return [partial(guess, weight=weight) for weight in weights]


def _bridged(values: Floats, middle: Floats) -> Floats:
    """Few samples missing: the straight line between neighbours; a column never seen stays at its mean."""
    filled = values.copy()
    time = np.arange(len(values))
    for column, usual in zip(filled.T, middle, strict=True):
        known = np.isfinite(column)
        column[~known] = np.interp(time[~known], time[known], column[known]) if known.any() else usual
    return filled
