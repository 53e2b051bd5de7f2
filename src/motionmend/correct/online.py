"""Learning while correcting: what a person's bones made of the offsets in clear frames is predicted in later ones.

Nobody tells the truth live. But a clear frame, whose joints are all trusted and whose posture is well known, shows
this person's bones, and what they add to the predicted offset is worth remembering for like postures. Only reliable and
certain samples are taken (section 4.2.3), memory is bounded, and what was learned has no more say than its certainty
gives it.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Bools, Floats
from ..numerics.local_gp import Hyper, Mixture, predict
from ..numerics.online_gp import learned

MODELS, SIZE, NEAREST = 6, 24, 3  # per joint: the whole memory
TRUSTED = 0.9  # reliability of a sample worth learning
PAUSE = 0.2  # s between samples: neighbours in time say the same
SIGNAL, NOISE = 0.01, 0.05  # standard metres: how much bones add, and how much of a frame's is chance
LENGTH = 0.3  # standard metres between postures that no longer resemble each other
LIMIT = 0.02  # standard metres; no remembered shift is larger


@dataclass(frozen=True, eq=False)
class Memory:
    """What was learned since the first frame: local models per joint, and when a sample was last taken, s."""

    mixture: Mixture
    time: float


def blank(joints: int, inputs: int) -> Memory:
    """Nothing learned yet."""
    shape = (joints, MODELS)
    return Memory(
        Mixture(
            np.full((*shape, inputs), np.nan),
            np.zeros((*shape, SIZE, inputs)),
            np.zeros((*shape, SIZE, 3)),
            np.zeros((*shape, SIZE, SIZE)),
            np.zeros((*shape, SIZE, 3)),
            np.zeros(shape, np.int64),
            np.ones((*shape, 4)),
        ),
        -np.inf,
    )


def remembered(memory: Memory, inputs: Floats) -> Floats:
    """(J, 3) the shift that was learned for postures like this one, standard units; 0 where nothing was.

    Parameters
    ----------
    inputs : (J, D) each joint's neighbours.
    """
    mean, _ = predict(memory.mixture, inputs[None], NEAREST)
    size = np.sqrt((mean[0] ** 2).sum(axis=1, keepdims=True))
    return np.asarray(mean[0] * np.minimum(1.0, LIMIT / np.maximum(size, 1e-12)))


def taken_in(memory: Memory, time: float, inputs: Floats, shifts: Floats, reliable: Floats, certain: Bools) -> Memory:
    """The memory after a frame.

    Parameters
    ----------
    time : s.
    inputs : (J, D) each joint's neighbours.
    shifts : (J, 3) what a person's bones added to the predicted offset, standard units; NaN = not known. Live, to that
        and what was remembered: what comes back of it is no news.
    reliable : (J,) in [0, 1].
    certain : (J,) joints whose offset is well known.
    """
    if time - memory.time < PAUSE:
        return memory
    worth = (reliable > TRUSTED) & certain & np.isfinite(shifts).all(axis=1)
    worth &= np.isfinite(inputs).all(axis=1) & (np.abs(np.nan_to_num(shifts)).max(axis=1) < 3.0 * LIMIT)
    if not worth.any():
        return memory
    fresh = Hyper(SIGNAL**2, 0.25 * SIGNAL**2, 1.0 / LENGTH**2, NOISE**2)
    return replace(memory, mixture=learned(memory.mixture, inputs, shifts, worth, fresh), time=time)
