"""Jumping: feet that stand side by side, leave the floor and meet it, and a root that falls freely between.

Heights, depths and the free fall follow the sources named below; how trunk and arms go along is our own, by eye.
"""

from dataclasses import dataclass

import numpy as np

from ..arrays import Bools, Floats, Ints
from .arms import Arms, swung
from .body import Build, build
from .curves import bump, drift, step, through
from .gait import GRAVITY
from .legs import Feet, ankle_over, roll
from .person import Person
from .pose import Performance, Trunk

WIDTH = 0.19  # m between the feet
TOE_OUT = np.radians(8.0)
_TOES_DOWN = np.radians(-45.0)  # pitch of the feet when they leave the floor
_TOES_LAND = np.radians(-16.0)


@dataclass(frozen=True)
class _Jump:
    """One jump: times in s, heights and places in m (the root's over standing and ahead of the feet)."""

    down: float  # crouching begins
    push: float
    off: float
    land: float
    low: float
    up: float
    depth: float
    give: float  # depth of the landing
    rise: float  # of the root at take-off over standing
    fall: float  # at landing
    speed: float  # m/s forward in the air
    ahead: float  # place of the root at take-off
    behind: float  # and at landing
    tuck: float  # rad, flexion of the knees in the air

    @property
    def distance(self) -> float:
        """m from where the feet leave to where they land."""
        return self.ahead + self.speed * (self.land - self.off) - self.behind


def jump(person: Person, t: Floats, speed: float, rng: np.random.Generator) -> Performance:
    """Jump again and again from a crouch, on the spot or forward; T = len(t).

    Heights and depths after Linthorne, Am. J. Phys. 69 (2001) 1198-1204: down by about 0.3 m, up by 0.2 to 0.4 m.

    Parameters
    ----------
    person, t : who, and the times, s.
    speed : scales the speed at take-off.
    rng : of this trial.
    """
    b = build(person.height)
    jumps = _jumps(b, person, t, speed, rng)
    stand = b.standing - 0.008 * person.height
    times, states, spots = [t[0] - 1.0], [np.zeros((3, 2))], [0.0]
    for j in jumps:
        feet = spots[-1]
        times += [j.down, j.push, j.off, j.land, j.low, j.up]
        off, on = _speed_at(j)
        most = 10 * j.depth / (j.push - j.down) ** 2  # a harder stop would have to begin with a rise
        states += [
            _state(0.0, feet),
            _state(-j.depth, feet - 0.38 * j.depth, up=min(0.6 * off**2 / j.depth, most)),
            _state(j.rise, feet + j.ahead, off, j.speed, -GRAVITY),
            _state(j.fall, feet + j.distance + j.behind, on, j.speed, -GRAVITY),
            _state(-j.give, feet + j.distance - 0.30 * j.give, up=2.0),
            _state(0.0, feet + j.distance),
        ]
        spots.append(feet + j.distance)
    path = through(t, np.array(times), np.array(states))
    sway = drift(rng, t, 1.5, 0.004, 3)
    root = np.stack(
        [sway[:, 0], stand + path[:, 0] + 0.3 * sway[:, 2], path[:, 1] - b.hip[2] + 0.02 + sway[:, 1]], axis=1
    )
    return _jumping(b, person, t, jumps, np.array(spots), root, rng)


def _state(height: float, ahead: float, rising: float = 0.0, going: float = 0.0, up: float = 0.0) -> Floats:
    """(3, 2) place, velocity and acceleration of the root: height over standing and way forward."""
    return np.array([[height, ahead], [rising, going], [up, 0.0]])


def _speed_at(j: _Jump) -> tuple[float, float]:
    """m/s upward at take-off and at landing, of the free fall between them."""
    lasts = j.land - j.off
    off = (j.fall - j.rise) / lasts + GRAVITY * lasts / 2
    return off, off - GRAVITY * lasts


def _jumps(b: Build, person: Person, t: Floats, speed: float, rng: np.random.Generator) -> list[_Jump]:
    """The jumps of one trial, one after the other until time is up."""
    jumps: list[_Jump] = []
    at = float(rng.uniform(0.1, 0.5))
    size = person.height / 1.75
    _, heel, _ = roll(b, np.array([_TOES_DOWN, _TOES_LAND]))
    while at < t[-1] + 1.0:
        height = float(np.clip(rng.uniform(0.16, 0.34) * speed**2 * (1 + 0.15 * person.style), 0.06, 0.5))
        off = float(np.sqrt(2 * GRAVITY * height))
        depth = float(rng.uniform(0.10, 0.13)) * off * size
        give = float(rng.uniform(0.11, 0.13)) * off * size
        # The faster the body, the further from straight the legs leave the floor and meet it: they need time to stop.
        rise, fall = float(heel[0]) - 0.013 * off * size, float(heel[1]) - 0.020 * off * size
        push = at + float(rng.uniform(0.5, 0.65))
        leave = push + 1.9 * (depth + rise) / off
        air = (off + float(np.sqrt(off**2 + 2 * GRAVITY * (rise - fall)))) / GRAVITY
        land = leave + air
        low = land + 1.7 * (give + fall) / (GRAVITY * air - off)
        up = low + float(rng.uniform(0.7, 0.9))
        forward = float(rng.choice([0.0, 1.0])) * float(rng.uniform(0.2, 0.9)) * speed
        jumps.append(
            _Jump(
                down=at,
                push=push,
                off=leave,
                land=land,
                low=low,
                up=up,
                depth=depth,
                give=give,
                rise=rise,
                fall=fall,
                speed=forward,
                ahead=0.06 + 0.06 * forward,
                behind=0.02 - 0.10 * forward,
                tuck=float(np.radians(rng.uniform(10.0, 45.0))),
            )
        )
        at = up + float(rng.uniform(0.15, 0.5))
    return jumps


def _jumping(
    b: Build, person: Person, t: Floats, jumps: list[_Jump], spots: Floats, root: Floats, rng: np.random.Generator
) -> Performance:
    """Feet, trunk and arms to go with the root's path."""
    pitch, knee, thigh = np.zeros_like(t), np.full_like(t, np.radians(12.0)), np.full_like(t, np.radians(6.0))
    lean, swing, fold = np.zeros_like(t), np.zeros_like(t), np.zeros_like(t)
    standing, spot = np.ones(len(t), dtype=bool), np.zeros(len(t), dtype=np.int64)
    for n, j in enumerate(jumps):
        air = j.land - j.off
        standing &= (t <= j.off) | (t >= j.land)
        spot[t > j.off + air / 2] = n + 1
        pitch += 1.15 * _TOES_DOWN * step((t - j.off + 0.16) / 0.26)
        pitch += (_TOES_LAND - 1.15 * _TOES_DOWN) * step((t - j.off - 0.10) / (air - 0.10))
        pitch -= _TOES_LAND * step((t - j.land) / 0.13)
        aloft = bump(t, j.off, j.off + 0.45 * air, j.off + 0.55 * air, j.land)
        knee += j.tuck * aloft
        thigh += (0.55 * j.tuck + 0.25 * j.speed * step((t - j.off) / air)) * aloft
        down, pushing = step((t - j.down) / (j.push - j.down)), step((t - j.push + 0.05) / (j.off - j.push + 0.05))
        landing, rising = step((t - j.land + 0.05) / (j.low - j.land + 0.05)), step((t - j.low) / (j.up - j.low))
        lean += np.radians(150.0 * j.depth) * (down - pushing) + np.radians(130.0 * j.give) * (landing - rising)
        high = np.radians((105.0 + 30.0 * person.style) * (1 + 0.1 * person.traits[5]))
        swing += np.radians(-42.0) * down + (high + np.radians(42.0)) * step(
            (t - j.push + 0.06) / (j.off - j.push + 0.14)
        )
        swing -= (high - np.radians(15.0)) * step((t - j.off - 0.12) / (j.low - j.off - 0.12))
        swing -= np.radians(15.0) * rising
        fold += np.radians(22.0) * (down - pushing) + np.radians(9.0) * (pushing - rising)
        fold += np.radians(18.0) * (landing - rising)
    wander = drift(rng, t, 1.2, np.radians(1.2), 8)
    place = np.stack([0 * spots, 0 * spots, spots], axis=1)
    feet = side_by_side(b, person, place, spot, pitch, standing, np.stack([thigh, knee], axis=1), rng)
    tilt = np.radians(4.0) + 0.45 * lean
    trunk = Trunk(
        root=root,
        heading=wander[:, 0],
        tilt=tilt,
        roll=0.3 * wander[:, 1],
        spine=np.stack(
            [person.stoop + 0.5 * lean - np.radians(4.0) + wander[:, 2], wander[:, 3], wander[:, 4]], axis=1
        ),
        neck=np.stack([person.gaze - 0.6 * lean + wander[:, 5], wander[:, 6], 0.5 * wander[:, 7]], axis=1),
    )
    return Performance(trunk, feet, _both(t, person, swing, fold, rng))


def _both(t: Floats, person: Person, swing: Floats, fold: Floats, rng: np.random.Generator) -> Arms:
    """Both arms doing the same, nearly."""
    own = np.stack([drift(rng, t, 0.9, 1.0, 2) for _ in range(4)], axis=2)  # (T, 2, 4)
    size = 1.0 + 0.2 * person.uneven * np.array([1.0, -1.0])
    moved = swing[:, None] * size
    raised = np.sin(np.clip(moved, 0.0, np.pi) / 2) ** 2
    return swung(
        swing=np.radians(-2.0 + 2.0 * own[:, :, 0]) + moved,
        away=np.radians(9.0 + person.traits[7] + 1.2 * own[:, :, 1]) + np.radians(4.0) * raised,
        inward=np.radians(15.0 + 2.0 * own[:, :, 2]),
        elbow=np.radians(18.0 + 2.0 * own[:, :, 3] + 2.0 * person.traits[6]) + fold[:, None] * size,
        clavicle=np.stack([np.radians(3.0) * raised, np.radians(1.0) + np.radians(14.0) * raised], axis=2),
        wrist=np.radians(14.0 + own[:, :, 0]),
        hand=np.radians(-4.0 + 2.0 * own[:, :, 1]) - 0.15 * fold[:, None],
    )


def side_by_side(
    b: Build,
    person: Person,
    place: Floats,
    spot: Ints,
    pitch: Floats,
    standing: Bools,
    free: Floats,
    rng: np.random.Generator,
) -> Feet:
    """Feet that stand either side of `place[spot]`: (S, 3) m and (T,) index; not quite alike, as people's are."""
    ankle, heading = [], []
    for mirror in (1, -1):
        apart = np.zeros((len(place), 3))
        apart[:, 0] = mirror * WIDTH / 2 * (1 - 0.15 * person.style)
        apart[:, [0, 2]] += 0.012 * rng.standard_normal((len(place), 2))
        facing = mirror * (TOE_OUT + np.radians(2.0) * person.traits[1]) + 0.03 * rng.standard_normal(len(place))
        ankle.append(ankle_over(b, (place + apart)[spot], facing[spot], pitch))
        heading.append(facing[spot])
    return Feet(
        np.stack(ankle, axis=1),
        np.stack(heading, axis=1),
        _twice(pitch),
        _twice(roll(b, pitch)[2]),
        np.stack([standing, standing], axis=1),
        _twice(free),
    )


def _twice(values: Floats) -> Floats:
    """(T, 2, ...) the same for both sides."""
    return np.stack([values, values], axis=1)
