"""The cycle of walking and running: what the norms make of a person of given stature at given speed."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from ..arrays import Floats
from .body import Build, build
from .curves import bump
from .legs import leg_room, roll
from .norms import RUN, WALK, Norm, running_stride, walking_stride

GRAVITY = 9.81  # m/s^2
_SAMPLES = 240  # of a cycle's tables
_PHASE = np.arange(_SAMPLES) / _SAMPLES


@dataclass(frozen=True, eq=False)
class Cycle:
    """One gait of one person at one speed, as functions of the phase: cycles since contact of the right foot.

    Attributes
    ----------
    length, time : of a stride, m and s.
    stance : share of the cycle a foot stands.
    ahead : m, from the path point to where the foot lands (the floor point below its ankle when flat). The path
        point moves on evenly, one length in a cycle.
    table : phase (...) to (..., 6), rad and m. Of the right leg as the norms have it: thigh forward of the vertical,
        knee; pitch of its foot and bend of its toes. Of the root: how far it is ahead of the path point; its
        height.
    """

    length: float
    time: float
    stance: float
    ahead: float
    table: Any

    def __call__(self, phase: Floats) -> Floats:
        """(..., 6) the table at any phase."""
        return np.asarray(self.table(np.mod(phase, 1.0)))


def straightest(gait: str, speed: float, height: float) -> float:
    """The least flexion of a standing knee, rad: more at higher speed, where the leg has less time to give way."""
    froude = speed * float(np.sqrt(1.75 / height))
    return float(np.radians(10.0 + 12.0 * max(0.0, froude - 1.3) if gait == "walk" else 23.0 + 4.0 * (froude - 3.0)))


@lru_cache(maxsize=64)
def cycle(gait: str, speed: float, height: float) -> Cycle:
    """The cycle of `gait` (`walk` or `run`) at `speed` m/s for a stature of `height` m.

    The thigh's swing is scaled until the standing foot carries the root over just one stride length.
    """
    from scipy.interpolate import CubicSpline

    norm, stride = (WALK, walking_stride) if gait == "walk" else (RUN, running_stride)
    length, time, stance = stride(speed, height)
    b = build(height)
    swing, before, missed = 1.1, 1.0, _carry(b, _leg(b, norm, stance, 1.0), stance)[0] - length
    for _ in range(8):  # secant steps: the stride grows almost linearly with the swing
        miss = _carry(b, _leg(b, norm, stance, swing), stance)[0] - length
        if abs(miss) < 1e-4:
            break
        swing, before, missed = swing - miss * (swing - before) / (miss - missed), swing, miss
    leg = _leg(b, norm, stance, swing)
    surge = _carry(b, leg, stance)[1]
    bob = _ballistic(time, stance) if gait == "run" else _pendulum(speed)
    ahead, hips = _place(b, leg, stance, length, surge, bob, straightest(gait, speed, height))
    bend = roll(b, leg.pitch)[2] * (1.0 - bump(_PHASE, stance, stance + 0.28, 0.95, 1.0))
    columns = np.stack([leg.thigh, leg.knee, leg.pitch, bend, surge, hips - b.hip[1]], axis=1)
    table = CubicSpline(np.arange(_SAMPLES + 1) / _SAMPLES, np.vstack([columns, columns[:1]]), bc_type="periodic")
    return Cycle(length, time, stance, ahead + b.hip[2], table)


@dataclass(frozen=True, eq=False)
class _Leg:
    """The right leg over the cycle, (N,): angles in rad; m from the hip to the floor point below the flat ankle."""

    thigh: Floats
    knee: Floats
    pitch: Floats
    forward: Floats
    up: Floats


def _leg(b: Build, norm: Norm, stance: float, swing: float) -> _Leg:
    """The norms with the thigh's swing scaled, the foot flat in mid-stance.

    Their phases are shifted so that contact comes at 0 and toe-off at `stance`.
    """
    span = norm.toe_off - norm.contact - stance
    phase = _PHASE + norm.contact + span * (np.sin(np.pi * _PHASE) / np.sin(np.pi * stance)) ** 2
    mean = np.radians(norm.thigh.mean)
    thigh = mean + swing * (norm.thigh(phase) - mean)
    knee, ankle = norm.knee(phase), norm.ankle(phase)
    knee = knee * (1.0 + 0.3 * (swing - 1.0) * (knee / knee.max()) ** 2)  # who swings further folds the leg more
    start, down, rising, up = np.array(norm.flat) * stance
    pitch = (thigh - knee + ankle) * (1.0 - bump(_PHASE, start - 1e-9, down, rising, up))
    rolled_forward, rolled_up, _ = roll(b, pitch)
    return _Leg(
        thigh,
        knee,
        pitch,
        b.thigh * np.sin(thigh) + b.shank * np.sin(thigh - knee) - rolled_forward,
        -b.thigh * np.cos(thigh) - b.shank * np.cos(thigh - knee) - b.ankle_height - rolled_up,
    )


def _carry(b: Build, leg: _Leg, stance: float) -> tuple[float, Floats]:
    """Root motion from the standing foot: stride length (m) and surge (N,) m with which the foot slides least.

    The surge is the root's running before and behind its even progress, twice a cycle.
    """
    speed = (np.roll(leg.forward, -1) - np.roll(leg.forward, 1)) * _SAMPLES / 2
    weight = np.sqrt(_stands(stance))
    turn = 4 * np.pi * np.outer(_PHASE, [1, 2])
    basis = np.hstack([np.ones((_SAMPLES, 1)), np.cos(turn), np.sin(turn)])
    # The ridge keeps the surge near what is seen in people, about 1 cm.
    ridge = np.sqrt(_SAMPLES) * 0.9 * np.diag([0.0, 1.0, 1.0, 1.0, 1.0])
    rows = np.vstack([basis * weight[:, None], ridge])
    length, *rest = np.linalg.lstsq(rows, np.concatenate([-speed * weight, np.zeros(5)]), rcond=None)[0]
    c, s = np.array(rest[:2]) / [1, 2], np.array(rest[2:]) / [1, 2]
    return float(length), (np.sin(turn) @ c - np.cos(turn) @ s) / (4 * np.pi)


def _stands(stance: float) -> Floats:
    """(N,) how surely the foot stands: 0 at contact and toe-off, 1 in between."""
    return bump(_PHASE, 0.0, 0.15 * stance, 0.85 * stance, stance)


def _place(
    b: Build, leg: _Leg, stance: float, length: float, surge: Floats, bob: Floats, straight: float
) -> tuple[float, Floats]:
    """Where the foot lands, m ahead of the path point below the hips, and the hips' height (N,) m.

    The foot's place is the one the norms have on average, shifted by what the legs' length asks for. The height is
    the norms' on average, with the given bob, lowered until no standing knee is straighter than `straight`, rad.
    """
    weight = _stands(stance)
    mean = float(np.average(leg.forward + surge + length * _PHASE, weights=weight))
    hips = float(np.average(-leg.up - bob, weights=weight)) + bob
    rolled_forward, rolled_up, _ = roll(b, leg.pitch)

    def excess(ahead: float) -> float:
        forward = ahead - length * _PHASE - surge + rolled_forward
        room = leg_room(b, straight, forward) + b.ankle_height + rolled_up
        return max(0.0, float((hips - room)[stance >= _PHASE].max()))

    shifts = np.linspace(-0.12, 0.12, 49)
    shift = float(min(shifts, key=lambda s: excess(mean + s) + 0.05 * abs(s)))
    return mean + shift, hips - excess(mean + shift)


def _pendulum(speed: float) -> Floats:
    """(N,) m: rise and fall of a walker's root about its mean, lowest when both feet stand.

    Source: Boulic, Magnenat-Thalmann and Thalmann 1990 (see `norms`): amplitude 0.015 of the hip's height times the
    speed in hip heights per second, so 0.015 s times the speed, and sin(2 pi (2 t - 0.35)).
    """
    return np.asarray(0.015 * min(speed, 2.0) * np.sin(2 * np.pi * (2 * _PHASE - 0.35)))


def _ballistic(time: float, stance: float) -> Floats:
    """(N,) m: a runner's root about its mean: free fall in flight, a half sine of force in contact."""
    step, contact = time / 2, time * stance
    t = np.mod(_PHASE * time, step)
    pushed = np.minimum(t, contact)
    push = pushed - contact / np.pi * np.sin(np.pi * pushed / contact) + 2 * (t - pushed)
    height = GRAVITY * (step / 2 * push - t**2 / 2 - (step - contact) / 2 * t)
    return np.asarray(height - height.mean())
