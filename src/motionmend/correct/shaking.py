"""How much all of a sensor's joints shake at once, told while frames come: what is usual then is no sign of failing.

Noise turns back on itself: of white noise one second difference points against the next, by two thirds of its size. A
body's motion is slower than that, and its second differences point the same way. What most joints do is the sensor's
restlessness; a joint that shakes alone may fail.
"""

from dataclasses import dataclass, replace
from math import exp, sqrt

import numpy as np

from ..arrays import Floats, frozen
from ..kernels import shaking as kernel

SECONDS = 0.5  # in which all but a share of 1 / e of what was said before is forgotten
MOST = 0.05  # m; what goes to and fro by more is not noise
SMOOTHED = 0.5  # of the deviation, taken for noise in what is put out: with all of it a wrong frame is felt for longer
UNEVEN = 0.25  # of the step before; differences of uneven steps do not tell
LONGEST = 0.2  # s between frames that tell
BENT = 3.767  # median size of the second difference of white noise in space, by the deviation of a coordinate
USUAL = 1 / 8  # of those; more would hide who fails: at a half of them failing limbs shake no more than others do


@dataclass(frozen=True, eq=False)
class Shaking:
    """What is known of it after a frame.

    Attributes
    ----------
    bent : (J, 3) m, second differences in this frame; NaN = not known.
    step : s since the frame before; NaN = not known.
    variance : m² of a coordinate of the median joint; below 0 where joints move rather than shake.
    frames : that told of it.
    """

    bent: Floats
    step: float
    variance: float
    frames: int

    @property
    def deviation(self) -> float:
        """In m, of a coordinate."""
        return sqrt(max(self.variance, 0.0))

    @property
    def noise(self) -> float:
        """In m, of a coordinate, that is smoothed away live."""
        return SMOOTHED * self.deviation


def calm(joints: int) -> Shaking:
    """Before the first frame."""
    return Shaking(np.full((joints, 3), np.nan), np.nan, 0.0, 0)


def shaken(before: Shaking, rows: Floats, last: Floats, earlier: Floats, seconds: float) -> Shaking:
    """One frame on.

    Parameters
    ----------
    rows, last, earlier : (J, 3) m, positions of this frame and the two before it, NaN = missing.
    seconds : since the frame before.
    """
    if not 0.0 < seconds < LONGEST:
        return replace(calm(len(rows)), variance=before.variance, frames=before.frames)
    bent, turned = kernel.turned_back(rows, last, earlier, before.bent)
    even = abs(seconds - before.step) < UNEVEN * before.step
    if not even or turned != turned:  # NaN
        return Shaking(bent, seconds, before.variance, before.frames)
    share = max(1.0 / (before.frames + 1), 1.0 - exp(-seconds / SECONDS))
    told = min(max(turned, -(MOST**2)), MOST**2)
    return Shaking(bent, seconds, before.variance + share * (told - before.variance), before.frames + 1)


def usual_jerk(jerk: Floats, shaking: Shaking, size: float) -> Floats:
    """(J,) usual size of second differences, standard metres, of who shakes so: what comes of it is usual.

    Parameters
    ----------
    jerk : (J,) the same as the sensor has it that was learned from.
    size : of the person by that of the standard body.
    """
    if shaking.variance <= 0.0:
        return frozen(jerk)
    return frozen(np.maximum(jerk, USUAL * BENT * shaking.deviation / size))
