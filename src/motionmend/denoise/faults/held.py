"""Samples that a noisy recording holds still to the last digit: a sensor that has lost what it follows repeats itself.

What was held, or fell to a constant, is smooth and cannot be told from motion by how it moves. But noise never says the
same twice: where a channel is noisy, a run of equal samples tells nothing, and is filled like a gap.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.ndimage import uniform_filter1d

from ...arrays import Bools, Bytes, Floats, Ints, runs
from ...bodies.motion import Markers, Motion, Origin, Recording, Repaired
from ..channels.joints import CENTIMETRES, root_rows, unit
from ..noise.digits import coarseness
from ..noise.level import first_noise
from ..noise.quiet import quiet_bends
from .frozen import at_limit

LEAST_REPEATS = 2  # of a sample
LONG = 1.3  # s; what stands still for longer may be at a limit, or have come to rest for good
MOST_AT_ONCE = 0.5  # of a channel's samples; what is still for longer is as likely at home there
MOST_HELD = 0.3  # of a channel's samples: one that often repeats itself is drawn so
# unless it does for so many seconds on end, and hardly ever else: share of the other samples that may repeat theirs
ON_END, ELSE = 0.3, 0.02
BY_CHANCE = 0.01  # runs that may be found in a recording where there are none
# rad and m; a channel less noisy than that is as good as clean, and what stands still in it may be at rest
NOISY_ANGLE, NOISY_MARKER = np.radians(0.3), 0.0005
ROUNDED = 0.5  # of the step to which a channel was rounded: noise that rounding alone may pass for
ABOUT = 0.5  # s before and after, in which a channel has to be noisy
HIDES = 0.2  # of a channel's samples: if so many are held, a repair that takes them for measured finds too little noise
THERE = 0.35  # of the channel's noise, that the samples about have to show
SAID = 6  # channels that a warning names at most
_FEW = 1e-6
_NOTHING = 1e-300
_TWICE = 2.0 * np.sqrt(np.pi)  # two draws of N(0, 1) lie within u of each other with probability 2 u / this


def held(recording: Motion | Markers) -> Bools:
    """(T, C) True where a sample repeats those before it as noise does not. The first of such a run is not among them.

    By chance a sample of noise s in steps of u is that before with probability u / (2 s sqrt(pi)): runs of it are asked
    to be so long that in this recording hardly one comes about.
    """
    found: Bools = np.zeros((recording.frames, len(recording.channels)), dtype=bool)
    long, on_end = round(LONG * recording.fps), round(ON_END * recording.fps)
    for channel in _able(recording):
        values = _channel(recording, channel)  # one at a time: a recording may be long
        steps = np.abs(np.diff(values, axis=0))
        same = (steps == 0.0).all(axis=1)
        repeated = runs(same)  # the step before frame t has number t - 1
        often = same.sum() > MOST_HELD * len(values)
        if often:  # or for long
            lasts = on_end if _hardly_else(same, on_end) else long
            repeated = [(start, stop) for start, stop in repeated if stop - start > lasts]
            often = same.sum() - sum(stop - start for start, stop in repeated) > MOST_HELD * len(values)
        if often or not repeated:
            continue
        noise = first_noise(np.where(np.pad(same, (1, 0))[:, None], np.nan, values))
        finest = np.where(steps > 0.0, steps, np.inf).min(axis=0)
        chance = float(np.minimum(finest / (_TWICE * noise), 1.0).prod())
        if chance == 1.0:
            continue
        repeats = np.log(BY_CHANCE / found.size) / np.log(max(chance, _NOTHING))
        least = max(LEAST_REPEATS, int(np.ceil(repeats)))
        for start, stop in repeated:
            if stop - start >= least and (stop - start <= long or _left_behind(values, start, stop + 1)):
                found[start + 1 : stop + 1, channel] = True
    return found


def _hardly_else(same: Bools, on_end: int) -> bool:
    """Whether what repeats itself (T - 1,) does so for more than so many steps on end, and hardly ever else."""
    lasts = sum(stop - start for start, stop in runs(same) if stop - start > on_end)
    return bool(same.sum() - lasts <= ELSE * (len(same) - lasts))


def _left_behind(values: Floats, start: int, stop: int) -> bool:
    """Whether a channel (T, N) that is still for long came from elsewhere, goes elsewhere, and is at no limit."""
    inside = start > 0 and stop < len(values) and stop - start <= MOST_AT_ONCE * len(values)
    return inside and not at_limit(values, start, stop)


def _able(recording: Motion | Markers) -> Ints:
    """The channels or markers that are asked; not the root, whose channels mean nothing alone."""
    every = np.arange(len(recording.channels))
    if isinstance(recording, Motion):
        return np.setdiff1d(every, np.concatenate(root_rows(recording.skeleton)))
    return every


def _channel(recording: Motion | Markers, channel: int) -> Floats:
    """(T, 1) degrees or (T, 3) cm."""
    if isinstance(recording, Motion):
        return np.asarray(recording.q[:, [channel]] * unit(recording.skeleton)[channel])
    return np.asarray(CENTIMETRES * recording.positions[:, channel])


def in_noise(still: Bools, outcome: Repaired[Motion] | Repaired[Markers], recording: Motion | Markers) -> Bools:
    """(T, C) of these samples those of channels that the repair found noisy.

    Noisier than their own rounding, for what was rounded repeats itself wherever it moves slowly; and noisy just there,
    for noise that comes and goes leaves rests alone where it is gone.
    """
    if not still.any():
        return still
    step = coarseness(recording)
    if isinstance(recording, Motion):
        scale, least = unit(recording.skeleton), NOISY_ANGLE
    else:
        scale, least, step = np.full(len(step), CENTIMETRES), NOISY_MARKER, step.max(axis=1)
    noise = scale * (0.0 if outcome.noise is None else np.nan_to_num(outcome.noise))
    hidden = still.mean(axis=0) > HIDES
    others = float(np.median(noise[~hidden])) if not hidden.all() else 0.0  # noise hardly comes upon one channel alone
    for channel in np.flatnonzero(hidden).tolist():
        seen = np.where(still[:, channel, None], np.nan, _channel(recording, channel))
        noise[channel] = max(noise[channel], min(_white(seen), others))
    noisy = noise >= np.maximum(scale * least, ROUNDED * step)
    found: Bools = np.zeros(still.shape, dtype=bool)
    for channel in np.flatnonzero(still.any(axis=0) & noisy).tolist():
        seen = np.where(still[:, channel, None], np.nan, _channel(recording, channel))
        about = _noise_about(seen, recording.fps)
        # the repair's own figure may have grown by what was held, and the mean over all frames by outliers
        told = about[np.isfinite(about)]
        usual = min(noise[channel], np.sqrt(np.square(told).sum() / max(len(told), 1)))
        calm = still[:, channel] & (about < THERE * usual)
        found[:, channel] = still[:, channel] & ~calm
        for start, stop in _long(still[:, channel], recording.fps):
            found[start:stop, channel] = not (calm[start] or calm[stop - 1])  # in its midst hardly a sample tells
    return found


def for_long(still: Bools, fps: float) -> Bools:
    """Of samples that were held (T, C) those of runs that are longer than `LONG`."""
    found: Bools = np.zeros(still.shape, dtype=bool)
    for channel in np.flatnonzero(still.any(axis=0)):
        for start, stop in _long(still[:, channel], fps):
            found[start:stop, channel] = True
    return found


def _long(still: Bools, fps: float) -> list[tuple[int, int]]:
    return [(start, stop) for start, stop in runs(still) if stop - start > round(LONG * fps)]


def _white(seen: Floats) -> float:
    """Standard deviation of the white noise in a channel (T, N), NaN = not seen, as second differences tell it: over
    two frames those of motion are six times as large in the square as over one, those of noise no larger."""
    white = np.clip(6.0 * quiet_bends(seen, 1) - quiet_bends(seen, 2), 0.0, None) / 30.0
    return float(np.sqrt(np.nan_to_num(white).mean()))


def _noise_about(seen: Floats, fps: float) -> Floats:
    """(T,) most noise that there can be about each frame of a channel (T, N), NaN = not seen; inf where none is."""
    third = np.full(seen.shape, np.nan)
    third[2:-1] = np.diff(seen, n=3, axis=0) / np.sqrt(20.0)  # which multiply white noise by that
    known = np.isfinite(third).all(axis=1)
    square = np.where(known, np.square(np.nan_to_num(third)).mean(axis=1), 0.0)
    span = 2 * round(ABOUT * fps) + 1
    told, total = (uniform_filter1d(one, span, mode="constant") for one in (known.astype(np.float64), square))
    return np.asarray(np.sqrt(np.where(told > _FEW, total / np.maximum(told, _FEW), np.inf)))


def without(recording: Recording, still: Bools) -> Recording:
    """The recording with these samples (T, C) missing."""
    if isinstance(recording, Motion):
        return recording.with_q(np.where(still, np.nan, recording.q))
    assert isinstance(recording, Markers)
    return recording.with_positions(np.where(still[..., None], np.nan, recording.positions))


def told(outcome: Repaired[Recording], still: Bools, away: Bools, stood: Bools) -> Repaired[Recording]:
    """The repair of a recording `without` these samples (T, C): `recorded_but_lost`, and said.

    Parameters
    ----------
    outcome : of the recording without them.
    still : samples that were held.
    away : samples of markers that were `displaced`, or of a root that was `thrown`.
    stood : samples of markers that `stood_still`, or `stood_joints`.
    """
    said = []
    if still.any():
        said.append(
            f"{int(still.sum())} samples repeat the one before to the last digit, which noise does not, and were taken "
            f"as missing: {named(outcome.recording, still)}"
        )
    if away.any():
        said.append(
            f"{int(away.sum())} samples of {_what(outcome.recording)} were taken as missing: "
            f"{named(outcome.recording, away)}"
        )
    if stood.any():
        said.append(
            f"{int(stood.sum())} samples of {_who_stood(outcome.recording)} were taken as missing: "
            f"{named(outcome.recording, stood)}"
        )
    return recorded_but_lost(outcome, still | away | stood, said)


def recorded_but_lost(outcome: Repaired[Recording], lost: Bools, said: Sequence[str]) -> Repaired[Recording]:
    """The repair of a recording `without` samples that it has: they were recorded, so they are repaired, not filled.

    Parameters
    ----------
    outcome : of the recording without them.
    lost : (T, C) these samples.
    said : a sentence for each kind of them, after those of the repair.
    """
    origin: Bytes = np.where(lost & (outcome.origin == Origin.FILLED), Origin.REPAIRED, outcome.origin).astype(np.uint8)
    return replace(outcome, origin=origin, warnings=(*outcome.warnings, *said))


def _what(recording: Motion | Markers) -> str:
    if isinstance(recording, Motion):
        return "a root that leapt away and back, as no body can,"
    return "markers that leapt away from where those about them have them"


def _who_stood(recording: Motion | Markers) -> str:
    if isinstance(recording, Motion):
        return "joints that stood still in noise and leapt on, as no joint can,"
    return "markers that stood still while those about them went on, and leapt back to these,"


def named(recording: Motion | Markers, samples: Bools) -> str:
    """The names of the channels that have any of these samples (T, C), the first of them."""
    names = [recording.channels[c] for c in np.flatnonzero(samples.any(axis=0))]
    return f"{', '.join(names[:SAID])}{', ...' if len(names) > SAID else ''}"
