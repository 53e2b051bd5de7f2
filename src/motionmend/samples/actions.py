"""The five actions, each a performance over given times."""

import numpy as np

from ..arrays import Floats
from .curves import bump, drift, step
from .locomotion import Course, travel
from .person import Person
from .pose import Performance

WALKING, RUNNING = 1.35, 3.0  # m/s at a stature of 1.75 m (Winter 1991, natural cadence; Novacheck 1998)


def walk(person: Person, t: Floats, speed: float, rng: np.random.Generator) -> Performance:
    """Walk on, nearly straight, at `speed` times the natural speed; T = len(t)."""
    heading = drift(rng, t, 3.0, np.radians(2.0))[:, 0]
    return travel("walk", _scaled(WALKING, person, speed), person, Course(t, heading, np.ones_like(t)), rng)


def run(person: Person, t: Floats, speed: float, rng: np.random.Generator) -> Performance:
    """Run on, nearly straight, at `speed` times a middle speed; T = len(t)."""
    heading = drift(rng, t, 3.0, np.radians(2.0))[:, 0]
    return travel("run", _scaled(RUNNING, person, speed), person, Course(t, heading, np.ones_like(t)), rng)


def turn(person: Person, t: Floats, speed: float, rng: np.random.Generator) -> Performance:
    """Walk along curves and turn on the spot by steps, in turns; T = len(t)."""
    heading, stride = np.zeros_like(t), np.ones_like(t)
    at, spot = -0.5, bool(rng.integers(2))
    while at < t[-1]:
        side = rng.choice([-1.0, 1.0])
        angle = np.radians(rng.uniform(90.0, 180.0) if spot else rng.uniform(50.0, 110.0))
        lasts = angle / np.radians(38.0 if spot else 30.0)
        heading += side * angle * step((t - at) / lasts)
        if spot:
            stride -= 0.92 * bump(t, at - 0.7, at + 0.3, at + lasts - 0.3, at + lasts + 0.7)
        else:
            stride -= 0.15 * bump(t, at - 0.3, at + 0.4, at + lasts - 0.4, at + lasts + 0.3)
        at += lasts + rng.uniform(0.9, 1.4)
        spot = not spot
    return travel("walk", _scaled(0.9 * WALKING, person, speed), person, Course(t, heading, stride), rng)


def _scaled(natural: float, person: Person, speed: float) -> float:
    """m/s: walkers of different stature are alike at equal Froude numbers (Alexander, J. Zool. 201 (1983) 135-152)."""
    return natural * speed * float(np.sqrt(person.height / 1.75)) * (1.0 + 0.06 * person.style)
