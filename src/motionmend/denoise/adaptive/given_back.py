"""Motion that a repair took for noise is given back: what it left of the recording has to be white, and is not there.

A library of people who do not tremble, or any smoother, takes a tremble away and calls it noise. But noise is as strong
at all frequencies, and so is what a good repair leaves of it, or weaker where the repair follows the samples.
"""

from dataclasses import dataclass

import numpy as np
from scipy.fft import dct, idct
from scipy.special import fdtrc

from ...arrays import Bools, Floats
from ...errors import few

BANDWIDTH = 1.0  # Hz over which the strength of what is left is averaged
WHITE = 2 / 3  # of the highest frequency there is: above it motion is no stronger than noise
# How seldom noise alone looks so strong: about any frequency of any channel; about one, of all channels together; and
# about that one in a channel then.
FALSELY, BY_CHANCE, AMONG_MANY = 0.01, 1e-4, 0.05
TOGETHER, MOST_USUAL = 1.2, 10.0  # times as strong as noise on average: what many channels show; none counts for more
FEWEST = 6  # frequencies that tell how strong the noise is
LEAST_SEEN = 0.5  # of a channel's samples
SWINGS = 0.5  # degrees or cm, root mean square: what is said
_NOTHING = 1e-12


@dataclass(frozen=True, eq=False)
class GivenBack:
    """What is given back. (C,) where nothing else is said, channel units.

    Attributes
    ----------
    motion : (T, C).
    variance : (T, C) of the noise that comes with it.
    quieter : what is left of the deviation of the noise; 1 where nothing is given back.
    about : Hz, of what is strongest; 0 where nothing is.
    """

    motion: Floats
    variance: Floats
    quieter: Floats
    about: Floats


def given_back(measured: Floats, believed: Bools, values: Floats, louder: Floats, fps: float) -> GivenBack | None:
    """What of the samples' distance to a repair is stronger about some frequency than noise is; None where nothing is.

    Parameters
    ----------
    measured, values : (T, C) samples, NaN = missing, and the repair, channel units.
    believed : (T, C) True where a sample is there and not rejected.
    louder : (T, C) times its channel's usual that the noise is at each moment: what comes in bursts looks like motion
        here and there, however white it is.
    fps : Hz.

    Source
    ------
    Wiener's filter of what is left, which is noise of the strength at high frequencies and motion beside it.
    """
    frames, seen = len(measured), believed.mean(axis=0)
    first = round(WHITE * frames)  # a cosine of index k makes k half turns in T frames
    if frames - first < FEWEST:
        return None
    left = np.where(believed, measured - values, 0.0) / louder
    cosines = dct(left, axis=0, norm="ortho")
    power = np.square(cosines) / np.maximum(seen, LEAST_SEEN)
    white = power[first:].mean(axis=0)
    half = max(1, round(BANDWIDTH * frames / fps))
    strength, count = _averaged(power, half)
    asked = (seen >= LEAST_SEEN) & (white > _NOTHING)
    if not asked.any():
        return None
    stronger = strength / np.maximum(white, _NOTHING)
    usual = np.minimum(stronger[:, asked], MOST_USUAL).mean(axis=1, keepdims=True)
    many = float(asked.sum())
    together = (usual > TOGETHER) & (fdtrc(count * many, (frames - first) * many, usual) < BY_CHANCE)
    chance = fdtrc(count, float(frames - first), stronger)
    apart = many * first / (2 * half + 1)  # bands that tell of their own
    told = (chance < FALSELY / apart) | (together & (chance < AMONG_MANY))
    told[first:] = False
    told &= asked
    if not told.any():
        return None
    share = np.where(told, 1.0 - 1.0 / np.maximum(stronger, 1.0), 0.0)
    motion = louder * idct(share * cosines, axis=0, norm="ortho")
    some = told.any(axis=0)
    return GivenBack(
        motion=motion,
        variance=white * share.mean(axis=0) * np.square(louder),
        quieter=np.sqrt(1.0 - (share * power).sum(axis=0) / np.maximum(power.sum(axis=0), _NOTHING)),
        about=np.where(some, (share * strength).argmax(axis=0) * 0.5 * fps / frames, 0.0),
    )


def _averaged(power: Floats, half: int) -> tuple[Floats, Floats]:
    """(T, C) means over 2 `half` + 1 frequencies about each, and (T, 1) of how many that there are."""
    total = np.concatenate([np.zeros((1, power.shape[1])), np.cumsum(power, axis=0)])
    at = np.arange(len(power))
    low, high = np.maximum(at - half, 0), np.minimum(at + half + 1, len(power))
    count = (high - low)[:, None].astype(np.float64)
    return (total[high] - total[low]) / count, count


def said_of_swings(swings: Floats, pace: Floats, names: tuple[str, ...]) -> tuple[str, ...]:
    """A sentence that names the channels that swing as a library does not know; none where there are none.

    Parameters
    ----------
    swings, pace : (C,) root mean square, degrees or cm, and Hz.
    names : of the channels.
    """
    most = np.argsort(-swings, kind="stable")
    most = most[swings[most] >= SWINGS]
    if not len(most):
        return ()
    listed = few([f"{names[c]} ({swings[c]:.1f} degrees or cm)" for c in most])
    return (
        f"what swings at about {np.median(pace[most]):.1f} Hz, and not so in the library's clips, was taken for "
        f"motion, not for noise: {listed}",
    )
