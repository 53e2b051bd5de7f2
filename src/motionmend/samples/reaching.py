"""Reaching: hands that go to places around a standing person, the trunk going after them.

The hands' timing follows the source named below; how much the trunk, knees and head help is our own, by eye.
"""

from dataclasses import dataclass

import numpy as np

from ..arrays import Floats
from .arms import Arms, shoulder, stretched
from .body import Build, build
from .curves import drift, step
from .person import Person
from .pose import Performance, Trunk, thorax_frame
from .standing import side_by_side

_HANGING = np.array([0.11, -0.95, 0.14])  # of the arm's length: the left wrist from the shoulder, in the thorax' axes


@dataclass(frozen=True, eq=False)
class _Act:
    """Where both hands go and how the body helps; x left, y up, z forward of where the person stands, m and rad.

    Attributes
    ----------
    hands : (2, 3) places of the left and right wrist, NaN = hanging.
    body : (8,) lean forward, twist to the left, bend to the right, drop of the root, its shift left and forward, and of
        the neck, beyond the trunk's, the bend forward and the turn to the left.
    lasts, rests : s, on the way and there.
    """

    hands: Floats
    body: Floats
    lasts: float
    rests: float


def reach(person: Person, t: Floats, speed: float, rng: np.random.Generator) -> Performance:
    """Reach for places high and low, near and far, with one hand, the other or both; T = len(t).

    Hands go by minimum-jerk steps (Flash and Hogan 1985), the trunk with them and a little later.

    Parameters
    ----------
    person, t : who, and the times, s.
    speed : scales how fast the hands go.
    rng : of this trial.
    """
    b = build(person.height)
    acts = _plan(person, t, speed, rng)
    wander = drift(rng, t, 1.4, 1.0, 12)
    bodies = np.stack([act.body for act in acts])
    trunk = _trunk(b, person, _shares(t, acts, 0.07) @ bodies, wander)
    arms = _arms(b, _trunk(b, person, bodies, np.zeros((len(acts), 12))), acts, _shares(t, acts, 0.0), wander)
    still = np.zeros_like(t)
    nowhere, standing = np.zeros(len(t), dtype=np.int64), np.ones(len(t), dtype=bool)
    feet = side_by_side(b, person, np.zeros((1, 3)), nowhere, still, standing, np.zeros((len(t), 2)), rng)
    return Performance(trunk, feet, arms)


def _trunk(b: Build, person: Person, body: Floats, wander: Floats) -> Trunk:
    """The trunk for `body` (T, 8) as in `_Act` and what it wanders about (T, 12) standard normal."""
    lean, twist, side, drop, aside, ahead, nod, look = body.T
    tall = b.standing - 0.008 * person.height
    root = np.stack([aside, tall - drop, ahead - b.hip[2] + 0.02], axis=1)
    return Trunk(
        root=root + wander[:, :3] * (0.004, 0.0015, 0.004),
        heading=0.25 * twist + np.radians(0.8) * wander[:, 3],
        tilt=np.radians(4.0) + 0.5 * lean,
        roll=-0.2 * side,
        spine=np.stack([person.stoop - np.radians(4.0) + 0.5 * lean, 0.75 * twist, 0.8 * side], axis=1)
        + np.radians(0.8) * wander[:, 4:7],
        neck=np.stack([person.gaze + nod, look, -0.3 * side], axis=1) + np.radians(1.0) * wander[:, 7:10],
    )


def _plan(person: Person, t: Floats, speed: float, rng: np.random.Generator) -> list[_Act]:
    """What to reach for, one after the other until time is up; begins and, now and then, ends with hanging arms."""
    h = person.height
    hang = _Act(np.full((2, 3), np.nan), np.zeros(8), 0.8, float(rng.uniform(0.2, 0.6)))
    acts, at = [hang], t[0] + 1.0
    while at < t[-1]:
        which = int(rng.integers(4)) if np.isfinite(acts[-1].hands).any() else int(rng.integers(3))
        if which == 3:
            act = _Act(hang.hands, hang.body, float(rng.uniform(0.9, 1.2)) / speed, float(rng.uniform(0.3, 0.8)))
        else:
            act = _going(h, which, speed, rng)
        acts.append(act)
        at += act.lasts + act.rests
    return acts


def _going(h: float, which: int, speed: float, rng: np.random.Generator) -> _Act:
    """Reach with the left (0), the right (1) or both hands (2), for a place drawn at random."""
    height = float(rng.uniform(0.22, 1.12)) * h
    low = max(0.0, 0.66 * h - height)
    far = float(rng.uniform(0.24, 0.44)) * h * (1.0 - 0.25 * low / h)
    out = float(np.radians(rng.uniform(-15.0, 70.0))) if which < 2 else float(np.radians(rng.uniform(-25.0, 25.0)))
    azimuth = -out if which == 1 else out
    place = np.array([far * np.sin(azimuth), height, far * np.cos(azimuth)])
    hands = np.full((2, 3), np.nan)
    for side in (0, 1) if which == 2 else (which,):
        own = 0.07 * h * (1 - 2 * side) if which == 2 else 0.04 * h * (1 - 2 * side)
        hands[side] = place + own * np.array([np.cos(azimuth), 0.0, -np.sin(azimuth)])
    lean = np.radians(4.0 + 95.0 * low / h) + 0.35 * max(0.0, far / h - 0.30) / 0.14
    twist = 0.45 * azimuth + (0.15 * (2 * which - 1) * (1 if which < 2 else 0))
    eyes = 0.93 * h - 0.6 * low
    nod = np.arctan2(eyes - height, far + 0.1 * h) * 0.6 - 0.55 * lean
    body = np.array(
        [
            lean,
            twist,
            (0.10 * (2 * which - 1) if which < 2 else 0.0) * (1.0 - 2.0 * min(1.0, max(0.0, height / h - 0.7) / 0.4)),
            0.42 * low,
            0.02 * h * np.sin(azimuth),
            -0.13 * h * np.sin(lean) * 0.8 + 0.012 * h,
            np.clip(nod, np.radians(-35.0), np.radians(40.0)),
            np.clip(0.8 * azimuth - twist, np.radians(-50.0), np.radians(50.0)),
        ]
    )
    lasts = (0.75 + 0.5 * low / h + float(rng.uniform(0.0, 0.3))) / speed
    return _Act(hands, body, lasts, float(rng.uniform(0.15, 0.6)))


def _shares(t: Floats, acts: list[_Act], late: float) -> Floats:
    """(T, K) how much of each act there is at each time; they sum to one."""
    shares = np.zeros((len(t), len(acts)))
    shares[:, 0] = 1.0
    at = t[0] + 1.0 + late
    for k, act in enumerate(acts[1:], start=1):
        gone = step((t - at) / act.lasts)
        shares[:, k] += gone
        shares[:, k - 1] -= gone
        at += act.lasts + act.rests
    return shares


def _arms(b: Build, trunks: Trunk, acts: list[_Act], shares: Floats, wander: Floats) -> Arms:
    """Arms whose wrists go to where the acts want them, seen from the thorax that each act has (K frames of `trunks`).

    From place to place a hand goes in a bow around the shoulder, in front of the body.
    """
    ends, frames = thorax_frame(b, trunks)
    length = b.upper_arm + b.forearm
    moving = 1.0 - np.sum(shares**2, axis=1)
    upper: list[Floats] = []
    fold: list[Floats] = []
    elbow: list[Floats] = []
    clavicle: list[Floats] = []
    for side, mirror in enumerate((1, -1)):
        places = np.stack([act.hands[side] for act in acts])
        away = np.isfinite(places).all(axis=1)
        raised = np.where(away, np.clip(np.nan_to_num(places[:, 1]) / b.height - 0.6, 0.0, 0.5), 0.0)
        girdles = np.stack([np.radians(6.0) * away, np.radians(1.0) + np.radians(32.0) * raised], axis=1)
        wanted = (np.swapaxes(frames, 1, 2) @ (places - ends)[:, :, None])[:, :, 0] - shoulder(b, side, girdles)
        wanted[:, 2] = np.maximum(wanted[:, 2], 0.15 * length)  # nobody reaches behind their back
        wanted[~away] = length * _HANGING * (mirror, 1, 1)
        to = shares @ wanted + (0.8 * length * moving * (shares @ away))[:, None] * np.array([0.2 * mirror, 0.0, 1.0])
        to *= (shares @ np.linalg.norm(wanted, axis=1) / np.linalg.norm(to, axis=1))[:, None]
        to += 0.004 * wander[:, [9, 10 + side, 9]]
        girdle = shares @ girdles
        for part, values in zip((upper, fold, elbow), stretched(b, side, to), strict=True):
            part.append(values)
        clavicle.append(girdle)
    bent = np.stack(elbow, axis=1)
    return Arms(
        np.stack(upper, axis=1),
        np.stack(fold, axis=1),
        bent,
        np.stack(clavicle, axis=1),
        np.radians(14.0) + 0.15 * (bent - np.radians(30.0)),
        np.radians(-6.0) + 0.1 * bent,
    )
