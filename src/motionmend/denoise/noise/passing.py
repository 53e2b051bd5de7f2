"""Noise that comes and goes: by how much a recording is noisier, or quieter, than usual at each moment.

Noise is told from motion by its second differences over two frames: of noise they are as large as over one, of motion
six to sixteen times in the square. Where a channel is mostly noise, their logarithms, smoothed over a moment, say how
loud it is; what all channels share is sure sooner than what a channel says for itself.
"""

import numpy as np
from scipy.ndimage import gaussian_filter1d

from ...arrays import Bools, Floats, Ints
from ...numerics.gaussian import gaussian_smooth
from ...numerics.quantiles import median
from .swift import goes_with_speed, speeds

# s, of the Gaussian over which noise is taken to last; and frames that tell enough: no more are asked
WIDTH, FRAMES = 0.2, 6.0
GROWS = 2.0  # times in the square that second differences of motion are larger over two frames than over one
STEP, NOISE = 6.0, 6.0  # variance of steps over two frames to that over one; of noise in either, in its own
FAINT = {1: 0.3, 3: 0.05}  # degrees, and cm of markers: nobody is helped by following noise below that
HALF = 0.5  # of a moment tells of all of it
MUCH = 4.0  # times in the square
ONE_MOMENT = 0.67  # deviation of the logarithm of a variance that is told by so short a moment of one channel
STRAYS = 2.0  # such deviations that are not believed
ALIKE = 0.3  # of what all channels share nothing is believed up to here, however many they are: motion shares as much
FEW = 0.1  # of all channels: if no more are noise for the most part, what they share tells as little as much
# Outliers make a channel look louder here and there, at random; noise that passes lasts. The correlation of what two
# moments say, so many widths and so many seconds apart, of which nothing is believed and from which all is: bursts of
# outliers are no noise.
APART, BURST, BY_CHANCE, LASTING = 2.67, 0.27, 0.2, 0.5
BEYOND = 1.5  # times the square that the usual channel strays, of which for one channel nothing is believed
FEW_MOMENTS = 1.5  # times one by their number, of the correlation of one channel's, of which nothing is believed either
MOST = 4.0  # logarithm of a variance, beyond which a moment tells of no more
_LOG_MIDDLE = -0.5 * (np.euler_gamma + np.log(2.0))  # mean of log |N(0, 1)|
_UNKNOWN, _NOTHING = 0.05, 1e-6


def loudness(measured: Floats, fps: float, together: int = 1, joints: Ints | None = None) -> Floats:
    """(T, C) standard deviation of noise relative to the channel's usual; 1 throughout where no more can be told.

    Parameters
    ----------
    measured : (T, C) in degrees or cm, NaN = missing; outliers and all.
    fps : Hz.
    together : neighbouring columns that are as noisy as each other: 1 for angles, 3 for markers.
    joints : (C,) a number for each joint, alike where columns are angles of one; None = each has one of its own.
    """
    frames, channels = measured.shape
    width = min(WIDTH * fps, FRAMES)
    apart = max(1, round(max(APART * width, BURST * fps)))
    if frames <= 2 * apart:
        return np.ones(measured.shape)
    once, seen = _log_squares(measured, 1, width)
    twice, _ = _log_squares(measured, 2, width)
    faint = 2.0 * np.log(FAINT[together])
    # variance s + 6 n over one frame and 6 s + 6 n over two give n, the noise; all of it is the most there can be
    grown = np.exp(np.clip(twice - once, -MOST, MOST))
    noisy = (grown < GROWS) & (seen > _UNKNOWN)
    most = np.logaddexp(once - np.log(NOISE), faint)
    noise = np.logaddexp(once + np.log(np.clip((STEP - grown) / (STEP - 1.0), 0.2, None) / NOISE), faint)
    swift = goes_with_speed(
        noise,
        noisy,
        twice - once,
        speeds(measured, gaussian_smooth(np.exp(noise), width), fps, together, joints),
        width,
        faint,
    )
    noise, most = (one - gaussian_smooth(swift, width) for one in (noise, most))
    usual = np.array([median(noise[noisy[:, c], c]) if noisy[:, c].any() else np.inf for c in range(channels)])
    louder = np.where(noisy, noise - usual, np.minimum(most - usual, 0.0))
    tells = np.isfinite(louder) & (seen > _UNKNOWN) & (louder != 0.0)
    louder = np.where(tells, louder, 0.0)
    telling = np.maximum(tells.sum(axis=1, keepdims=True), 1)
    shared = louder.sum(axis=1, keepdims=True) / (telling + FEW * channels)
    differ = np.square(louder).sum(axis=1, keepdims=True) / telling - np.square(shared)
    shared *= _kept(np.square(shared), ALIKE**2 + STRAYS**2 * np.maximum(differ, ONE_MOMENT**2) / telling)
    own = _of_those_that_tell(np.where(tells, louder - shared, 0.0), tells, together, width)
    by_chance = ONE_MOMENT**2 / (together * np.maximum(seen[:, ::together], _UNKNOWN))
    # a single moment is believed if it goes far; a channel that goes up and down throughout is, in all its moments
    moment = _kept(np.square(own), STRAYS**2 * by_chance)
    throughout = _kept(np.square(np.clip(own, -MOST, MOST)).mean(axis=0), by_chance.mean(axis=0))
    own *= _lasting(own, apart, width) * np.maximum(moment, throughout)
    return np.asarray(np.exp(0.5 * (swift + shared + own.repeat(together, axis=1))))


def _of_those_that_tell(louder: Floats, tells: Bools, together: int, width: float) -> Floats:
    """(T, N) mean of neighbouring columns (T, C) that tell; where none does, as those that do about that moment."""
    counts = tells.reshape(len(louder), -1, together).sum(axis=2)
    own = louder.reshape(len(louder), -1, together).sum(axis=2) / np.maximum(counts, 1)
    told = gaussian_smooth((counts > 0).astype(np.float64), width)
    return np.where(counts > 0, own, gaussian_smooth(own, width) / np.maximum(told, HALF))


def without_floor(louder: Floats, level: Floats, together: int = 1) -> Floats:
    """(T, C) how loud it is where the noise of each channel (C,) is `level`.

    `loudness` (T, C) says it of noise and what is faint together, and is taken at its word where it says much.
    """
    faint = np.square(FAINT[together]) * np.maximum(np.square(louder) - MUCH, 0.0)
    return np.asarray(np.sqrt(np.square(louder) + faint / np.square(level)))


def _log_squares(measured: Floats, lag: int, width: float) -> tuple[Floats, Floats]:
    """(T, C) smoothed logarithm of the squared second differences over `lag` frames, and the share that is there."""
    bend = np.full(measured.shape, np.nan)
    bend[lag:-lag] = measured[: -2 * lag] - 2.0 * measured[lag:-lag] + measured[2 * lag :]
    known = np.isfinite(bend)
    logs = np.log(np.maximum(np.abs(np.where(known, bend, 1.0)), _NOTHING)) - _LOG_MIDDLE
    seen = gaussian_filter1d(known.astype(np.float64), width, axis=0, mode="constant")
    smooth = gaussian_filter1d(np.where(known, 2.0 * logs, 0.0), width, axis=0, mode="constant")
    return smooth / np.maximum(seen, _NOTHING), seen


def _kept(square: Floats, by_chance: Floats) -> Floats:
    """0 to 1: what is kept of a value by its square and that of what it may be by chance; of a mean, Wiener's factor.

    Source
    ------
    Breiman, Better subset regression using the nonnegative garrote, Technometrics 37(4), 1995.
    """
    return np.asarray(np.maximum(1.0 - by_chance / np.maximum(square, _NOTHING), 0.0))


def _lasting(own: Floats, apart: int, width: float) -> Floats:
    """(N,) 0 to 1: whether what each channel says for itself (T, N) lasts, by itself or as all do."""
    held = np.clip(own, -MOST, MOST)
    alike, square = (held[apart:] * held[:-apart]).mean(axis=0), np.square(held).mean(axis=0)
    # one channel's moments may be alike by chance, the more so the fewer there are apart from each other; but hardly
    # by more than the usual channel strays at all
    chance = FEW_MOMENTS * 2.0 * np.sqrt(np.pi) * width / max(1, len(own) - apart)
    each = alike / np.maximum(square, _NOTHING) - chance
    each *= _kept(alike, np.full(alike.shape, BEYOND * np.median(square)))
    all_ = alike.mean() / max(square.mean(), _NOTHING)
    return np.asarray(np.clip((np.maximum(each, all_) - BY_CHANCE) / (LASTING - BY_CHANCE), 0.0, 1.0))
