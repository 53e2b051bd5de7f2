"""Legs: where the ankle is when the foot rolls over the floor, and the joint angles that bring it there."""

from dataclasses import dataclass

import numpy as np

from ..arrays import Bools, Floats
from .body import LEG_TILT, SIDES, Build, rotation
from .curves import bump, quintic, step

BEND = np.radians(45.0)  # of the toes, the most the roll-over uses
LEAVING, LANDING = 20.0, 14.0  # frames of 1/240 s in which a leg goes over from contact to the norm, and back
CLEAR = 0.025  # m by which a leg is shorter in mid-swing than the norms have it, so that the toes clear the floor
CORNER = 6.0  # frames of 1/240 s, about 8 Hz: what movement holds (Winter 2009, sec. 3.4.4)
SOFT_KNEES, LEAST_KNEE = (np.radians(10.0), np.radians(25.0)), np.radians(3.0)  # standing, swinging
_BLEND = np.radians(10.0)  # pitch within which heel and ball share the pivot


def roll(b: Build, pitch: Floats) -> tuple[Floats, Floats, Floats]:
    """How the ankle moves when the foot pitches about the part of the sole that stands.

    Parameters
    ----------
    pitch : (...) rad, toes up positive: about the heel; toes down: about the ball with the toes flat, and when
        those are bent as far as they go, about their tips.

    Returns
    -------
    forward, up : (...) m, displacement of the ankle from its place above the flat foot.
    bend : (...) rad, of the toes, upward.
    """
    c, s = np.cos(pitch), np.sin(pitch)
    above = b.ankle_height - b.ball_height
    heel = (b.heel * c - b.ankle_height * s - b.heel, b.heel * s + b.ankle_height * c - b.ankle_height)
    bend = BEND * np.tanh(np.maximum(-pitch, 0.0) / BEND)
    excess = np.maximum(-pitch, 0.0) - bend
    ball = (
        b.ball - b.ball * c - above * s + b.toes * (1.0 - np.cos(excess)),
        -b.ball * s + above * c - above + b.toes * np.sin(excess),
    )
    share = step((pitch / _BLEND + 1.0) / 2.0)
    return share * heel[0] + (1 - share) * ball[0], share * heel[1] + (1 - share) * ball[1], bend


def ankle_over(b: Build, place: Floats, heading: Floats, pitch: Floats) -> Floats:
    """(T, 3) m: the ankle of a foot on the floor at `place` (T, 3) m, of given pitch and heading (T,) rad."""
    forward, up, _ = roll(b, pitch)
    ankle = place + np.stack([forward * np.sin(heading), 0 * forward, forward * np.cos(heading)], axis=1)
    ankle[:, 1] = b.ankle_height + up
    return ankle


@dataclass(frozen=True, eq=False)
class Feet:
    """Where both feet are while they stand and how the legs move while they do not; second axis 0 left, 1 right.

    Attributes
    ----------
    ankle : (T, 2, 3) m, world; between two contacts as in the nearer one.
    heading : (T, 2) rad about the vertical, 0 = z, positive to the left (x); between two contacts as in the nearer one.
    pitch : (T, 2) rad, toes up positive.
    bend : (T, 2) rad, toes against the foot, upward positive.
    standing : (T, 2) bool.
    free : (T, 2, 2) rad, in the air: thigh forward of the vertical, flexion of the knee.
    """

    ankle: Floats
    heading: Floats
    pitch: Floats
    bend: Floats
    standing: Bools
    free: Floats


def leg_angles(b: Build, root: Floats, turned: Floats, feet: Feet) -> dict[str, Floats]:
    """(T,) rad by DOF name: legs that keep standing feet in place and swing freely, and smoothly, between.

    A leg is four numbers: how far aside and how turned its plane is, the direction from hip to ankle in that plane,
    and the square of their distance, in which a nearly straight knee is as smooth as a bent one. The foot points
    where heading and pitch say.

    Parameters
    ----------
    root : (T, 3) m, place of the root.
    turned : (T, 3, 3) its rotation.
    """
    angles: dict[str, Floats] = {}
    lean = np.arctan2(turned[:, 2, 1], turned[:, 1, 1])  # of the pelvis, to first order
    for side, s in enumerate(SIDES):
        leg, heading = _standing_leg(b, root, turned, feet, side), feet.heading[:, side].copy()
        thigh, knee = feet.free[:, side].T
        hang = np.arctan2(b.shank * np.sin(knee), b.thigh + b.shank * np.cos(knee)) - thigh - lean
        free = np.stack([0 * hang, 0 * hang, hang, _squared(b, knee)], axis=1)
        for lift, land in _swings(feet.standing[:, side]):
            span, swing = slice(lift + 1, land), land - lift
            since = np.arange(1.0, swing)
            off, on = _state(leg[lift - 6 : lift + 1]), _state(leg[land : land + 7][::-1])
            on[1] *= -1.0
            leg[span, :2] = quintic(since, swing, off[:, :2], on[:, :2])
            excess = leg - free
            off, on = _state(excess[lift - 6 : lift + 1, 2:]), _state(excess[land : land + 7, 2:][::-1])
            leg[span, 2:] = free[span, 2:]
            leg[span, 3] -= 2 * CLEAR * np.sqrt(free[span, 3]) * bump(since / swing, 0.0, 0.4, 0.6, 1.0)
            for apart, longest, state in ((since, LEAVING, off), (swing - since, LANDING, on)):
                ease = min(longest, swing / 2)
                leg[span, 2:] += quintic(np.minimum(apart, ease), ease, state, np.zeros((3, 2)))
            heading[span] = heading[lift] + (heading[land] - heading[lift]) * step(since / swing)
        aside, turn, direction, squared = _smooth(leg).T
        knee = np.arccos(
            (_reach(b, squared, feet.standing[:, side]) - b.thigh**2 - b.shank**2) / (2 * b.thigh * b.shank)
        )
        flexion = direction - np.arctan2(b.shank * np.sin(knee), b.thigh + b.shank * np.cos(knee))
        shank = turned @ rotation(2, aside) @ rotation(1, turn) @ rotation(0, flexion + knee)
        across, lifted = _foot(b, heading, feet.pitch[:, side], shank)
        angles |= {
            f"{s}femur.rz": aside - (1 - 2 * side) * LEG_TILT,
            f"{s}femur.ry": turn,
            f"{s}femur.rx": flexion,
            f"{s}tibia.rx": knee,
            f"{s}foot.rz": across,
            f"{s}foot.rx": lifted,
            f"{s}toes.rx": -feet.bend[:, side],
        }
    return angles


def _swings(standing: Bools) -> list[tuple[int, int]]:
    """Last frame of every contact and first of the next."""
    change = np.diff(standing.astype(np.int8))
    lifts, lands = np.flatnonzero(change == -1), np.flatnonzero(change == 1) + 1
    after = [(int(lift), int(lands[lands > lift][0])) for lift in lifts if (lands > lift).any()]
    return [(lift, land) for lift, land in after if lift >= 6 and land < len(standing) - 6]


def _state(run: Floats) -> Floats:
    """(3, C) value, slope and curvature, per frame, at the last of seven frames (7, C), by a parabola through them."""
    frames = np.arange(-6, 1)
    fit = np.linalg.pinv(np.stack([frames**0, frames, frames**2 / 2], axis=1)) @ run
    fit[0] = run[-1]
    return np.asarray(fit)


def _smooth(leg: Floats) -> Floats:
    """(T, 4) the leg without corners. What a Gaussian takes away is smoothed and given back once, so that the even
    course of a standing leg stays where it is (Tukey's twicing)."""
    from scipy.ndimage import gaussian_filter1d

    once = gaussian_filter1d(leg, CORNER, axis=0, mode="nearest")
    return once + gaussian_filter1d(leg - once, CORNER, axis=0, mode="nearest")


def _standing_leg(b: Build, root: Floats, turned: Floats, feet: Feet, side: int) -> Floats:
    """(T, 4) rad, rad, rad, m^2: aside, turn, direction and squared length of a leg whose ankle is where it stands.

    The thigh is rotation z (aside) · y (turn) · x (flexion) of one hanging straight down; the knee points where the
    foot points.
    """
    back = np.swapaxes(turned, 1, 2)
    hip = root + turned @ (np.array(b.hip) * (1 - 2 * side, 1, 1))
    u = _apply(back, feet.ankle[:, side] - hip)
    squared = np.sum(u * u, axis=1)
    heading = feet.heading[:, side]
    left = _apply(back, np.stack([np.cos(heading), 0 * heading, -np.sin(heading)], axis=1))
    left -= (np.sum(left * u, axis=1) / squared)[:, None] * u
    left /= np.linalg.norm(left, axis=1, keepdims=True)  # the axis of the knee
    turn, aside = np.arcsin(-left[:, 2]), np.arctan2(left[:, 1], left[:, 0])
    down = _apply(np.swapaxes(rotation(2, aside) @ rotation(1, turn), 1, 2), u)
    return np.stack([aside, turn, np.arctan2(-down[:, 2], -down[:, 1]), squared], axis=1)


def _squared(b: Build, knee: Floats | float) -> Floats:
    """(...) m^2: squared distance from hip to ankle with the knee flexed (...) rad."""
    return np.asarray(b.thigh**2 + b.shank**2 + 2 * b.thigh * b.shank * np.cos(knee))


def _reach(b: Build, squared: Floats, standing: Bools) -> Floats:
    """(T,) m^2: the squared length, eased towards a knee that is not quite straight, from further off in the air."""
    from scipy.ndimage import gaussian_filter1d

    air = gaussian_filter1d((~standing).astype(np.float64), CORNER)
    stood, swung = (_eased(squared, _squared(b, knee), _squared(b, LEAST_KNEE)) for knee in SOFT_KNEES)
    return stood + air * (swung - stood)


def _eased(values: Floats, near: Floats, far: Floats) -> Floats:
    """(T,) the values up to `near`, those beyond drawn in smoothly so that none passes `far`."""
    return np.minimum(values, near) + (far - near) * np.tanh(np.maximum(values - near, 0.0) / (far - near))


def leg_room(b: Build, flexed: float, level: Floats) -> Floats:
    """(...) m: how high above an ankle, `level` (...) m away, the hip is with the knee flexed by `flexed` rad."""
    return np.asarray(np.sqrt(np.maximum(_squared(b, flexed) - level**2, 0.0)))


def _foot(b: Build, heading: Floats, pitch: Floats, shank: Floats) -> tuple[Floats, Floats]:
    """(T,) rz and rx of the foot that point it by heading and pitch, the shank's frame (T, 3, 3) given."""
    slope = np.arctan2(b.ankle_height - b.ball_height, b.ball)  # of the bone from ankle to ball, downward
    level = np.cos(pitch - slope)
    pointing = np.stack([np.sin(heading) * level, np.sin(pitch - slope), np.cos(heading) * level], axis=1)
    g = _apply(np.swapaxes(shank, 1, 2), pointing)
    g = np.stack([g[:, 0], -g[:, 2], g[:, 1]], axis=1)  # into the foot's own axes: a quarter turn about x
    return np.arctan2(g[:, 0], -g[:, 1]), np.arcsin(np.clip(-g[:, 2], -1.0, 1.0)) - slope


def _apply(rotations: Floats, vectors: Floats) -> Floats:
    """(T, 3) each vector turned by its rotation."""
    return np.asarray((rotations @ vectors[:, :, None])[:, :, 0])
