"""Published norms of human gait: joint curves over the cycle, and how stride and timing follow speed.

The Fourier coefficients are our own fit to landmarks (extremes, values at events and their times) of the sources, taken
to within a few degrees:

walking  D. A. Winter, The Biomechanics and Motor Control of Human Gait, 2nd ed., 1991, natural cadence: hip 20
         degrees flexed at heel contact, 11 extended at 50 %, 22 flexed at 86 %; knee 19 at 14 %, 7 at 38 %, 64 at
         72 %; ankle -5 at 6 %, 10 at 44 %, -20 at 64 %. The knee is kept 2 to 4 degrees from full extension.
running  T. F. Novacheck, The biomechanics of running, Gait Posture 7 (1998) 77-95: knee 42 degrees in stance, 18 at
         toe-off, 92 in swing; ankle 25 dorsiflexed in stance, -22 after toe-off; the thigh (given to the vertical,
         so with the pelvis' tilt taken off) from 33 forward to 22 back.
"""

from dataclasses import dataclass

import numpy as np

from ..arrays import Floats


@dataclass(frozen=True)
class Series:
    """A periodic curve: mean and harmonics, degrees, over the cycle from contact to contact of one foot."""

    mean: float
    cosines: tuple[float, ...]
    sines: tuple[float, ...]

    def __call__(self, phase: Floats) -> Floats:
        """Values in rad at `phase` (...) in cycles."""
        n = np.arange(1, len(self.cosines) + 1)
        turn = 2 * np.pi * np.multiply.outer(phase, n)
        degrees = self.mean + np.cos(turn) @ np.array(self.cosines) + np.sin(turn) @ np.array(self.sines)
        return np.asarray(np.radians(degrees))


@dataclass(frozen=True)
class Norm:
    """Sagittal curves of one gait. Thigh: forward of the vertical; knee: flexion; ankle: dorsiflexion."""

    thigh: Series
    knee: Series
    ankle: Series
    contact: float  # phase of the curves from which the foot stays where it is
    toe_off: float  # and until which it does
    flat: tuple[float, float, float, float]  # shares of stance: sole comes down, is down, heel starts up, is up


WALK = Norm(
    thigh=Series(7.47, (15.70, -2.93, -0.17, -0.07, -0.02, 0.0), (-4.19, -1.07, 1.15, -0.02, 0.08, 0.0)),
    knee=Series(24.49, (-3.53, -14.47, -0.44, -0.65, 0.28, 0.06), (-21.18, 7.83, 3.96, 0.42, 0.29, -0.25)),
    ankle=Series(-0.07, (-0.16, 0.87, -3.39, 2.00, -0.19, 0.16, 0.46), (7.16, -7.10, 0.79, -0.27, -1.13, 0.13, -0.13)),
    contact=0.02,
    toe_off=0.60,
    flat=(0.0, 0.24, 0.48, 0.85),
)
RUN = Norm(
    thigh=Series(11.70, (21.25, -5.53, -1.79, 0.04, -0.35, -0.10), (-12.93, 5.41, -1.18, 0.29, 0.31, 0.0)),
    knee=Series(44.90, (-11.14, -14.76, -2.32, 0.27, 0.21, -0.02), (-24.50, 17.56, 2.60, 1.01, 0.04, -0.04)),
    ankle=Series(1.67, (12.47, -7.68, -2.30, 1.58, -0.69, 0.01), (5.03, 6.49, -5.28, -0.13, 0.05, -0.52)),
    contact=0.01,
    toe_off=0.345,
    flat=(0.0, 0.36, 0.48, 0.80),
)


def walking_stride(speed: float, height: float) -> tuple[float, float, float]:
    """Stride length (m), stride time (s) and share of stance of a person of `height` m walking at `speed` m/s.

    Source: Grieve and Gear, Ergonomics 9 (1966) 379-399 (adults): strides a minute = 64.8 (v / stature)^0.57.
    Stance: Boulic, Magnenat-Thalmann and Thalmann, Vis. Comput. 6 (1990) 344-358: 0.752 T - 0.143 s of a cycle of T.
    """
    time = 60.0 / (64.8 * (speed / height) ** 0.57)
    return speed * time, time, float(np.clip(0.752 - 0.143 / time, 0.55, 0.68))


def running_stride(speed: float, height: float) -> tuple[float, float, float]:
    """Stride length (m), stride time (s) and share of stance of a person of `height` m running at `speed` m/s.

    Source: Cavanagh and Kram, Med. Sci. Sports Exerc. 21 (1989) 467-479: from 3.15 to 4.12 m/s the stride grows by
    28 % and its frequency by 4 % (so with speed to the power 0.15) from 1.38 Hz; pendulum scaling with stature.
    Stance: toe-off at 39 % of the cycle at 3.2 m/s and at 36 % at 3.9 m/s (Novacheck 1998).
    """
    froude = speed * np.sqrt(1.75 / height)
    time = float(1.0 / (1.38 * (froude / 3.15) ** 0.15) * np.sqrt(height / 1.75))
    return speed * time, time, float(np.clip(0.39 - 0.043 * (froude - 3.2), 0.28, 0.44))
