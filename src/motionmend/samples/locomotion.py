"""Walking, running and turning: a cycle carried along a path, with every foot planted where it lands."""

from dataclasses import dataclass

import numpy as np

from ..arrays import Floats
from .arms import Arms, swung
from .body import Build, build
from .curves import bump, drift
from .gait import GRAVITY, Cycle, cycle, straightest
from .legs import Feet, ankle_over, leg_room
from .manner import RUN, WALK, Manner
from .person import Person
from .pose import Performance, Trunk


@dataclass(frozen=True, eq=False)
class Course:
    """Where to go and how fast: over time t (T,) s, the heading (T,) rad and the share of a full stride (T,)."""

    t: Floats
    heading: Floats
    stride: Floats


def travel(gait: str, speed: float, person: Person, course: Course, rng: np.random.Generator) -> Performance:
    """Walk or run along a course.

    Parameters
    ----------
    gait : `walk` or `run`.
    speed : m/s, of a full stride.
    person : whose build, manner and little irregularities.
    course : T frames.
    rng : of this trial.

    Returns
    -------
    Performance of T frames.
    """
    t = course.t
    c = cycle(gait, round(speed, 3), person.height)
    hurry = drift(rng, t, c.time, person.irregularity, 2)
    rate = (1.0 + hurry[:, 0]) / c.time
    phase = rng.random() + _integral(rate, t)
    stride = course.stride * (1.0 + hurry[:, 1])
    forward, left = _directions(course.heading)
    path = _integral((stride * c.length * rate)[:, None] * forward, t)
    manner = person.manner(WALK if gait == "walk" else RUN)
    feet = _feet(c, manner, person, phase, stride, path, course, rng)
    table = c(phase)
    wave = 2 * np.pi * phase
    vigour = np.minimum(stride, 1.2)
    sway = -manner.sway * np.cos(wave - 2 * np.pi * c.stance / 2)
    b = build(person.height)
    tall = b.standing - 0.012 * person.height
    root = path + (table[:, 4] * stride)[:, None] * forward + sway[:, None] * left
    root[:, 1] = tall + (table[:, 5] - tall) * vigour**2
    root[:, 1] -= _stoop(b, root, left, feet, straightest(gait, speed, person.height))
    trunk, arms = _upper_body(manner, person, c, root, wave, vigour, course, rng)
    return Performance(trunk, feet, arms)


def _stoop(b: Build, root: Floats, left: Floats, feet: Feet, flexed: float) -> Floats:
    """(T,) m by which the root goes down, slowly, where a standing foot is further off than in the even cycle."""
    from scipy.ndimage import gaussian_filter1d, maximum_filter1d

    excess = np.zeros(len(root))
    for side, mirror in enumerate((1, -1)):
        off = root + mirror * b.hip[0] * left - feet.ankle[:, side]
        short = off[:, 1] + b.hip[1] - leg_room(b, flexed, np.hypot(off[:, 0], off[:, 2]))
        excess = np.maximum(excess, np.where(feet.standing[:, side], short, 0.0))
    return np.asarray(gaussian_filter1d(maximum_filter1d(excess, 49), 24.0))


def _integral(rate: Floats, t: Floats) -> Floats:
    """(T, ...) the integral of the rate from the first frame, by trapezoids."""
    steps = (rate[1:] + rate[:-1]) / 2 * np.diff(t).reshape(-1, *([1] * (rate.ndim - 1)))
    return np.concatenate([np.zeros_like(rate[:1]), np.cumsum(steps, axis=0)])


def _directions(heading: Floats) -> tuple[Floats, Floats]:
    """(T, 3) unit vectors forward and to the left."""
    c, s, o = np.cos(heading), np.sin(heading), np.zeros_like(heading)
    return np.stack([s, o, c], axis=1), np.stack([c, o, -s], axis=1)


def _feet(
    c: Cycle,
    manner: Manner,
    person: Person,
    phase: Floats,
    stride: Floats,
    path: Floats,
    course: Course,
    rng: np.random.Generator,
) -> Feet:
    """Both feet as they stand, in place and heading, and as the norms swing them between."""
    b = build(person.height)
    effort = (0.3 + 0.7 * np.minimum(stride, 1.1))[:, None]
    ankle, heading, pitch, bend, standing, free = [], [], [], [], [], []
    for side, mirror in enumerate((1, -1)):
        own = phase + (0.5 if side == 0 else 0.0)
        table = c(own)
        contact = np.round(own - c.stance / 2).astype(int)  # the one a frame belongs to or is nearest to
        steps = np.arange(contact[0], contact[-1] + 1)
        middle = np.interp(steps + c.stance / 2, own, course.t)
        facing = np.interp(middle, course.t, course.heading)
        forward, left = _directions(facing)
        reach = np.interp(middle, course.t, stride) * (c.ahead - c.length * c.stance / 2)
        place = np.stack([np.interp(middle, course.t, path[:, i]) for i in range(3)], axis=1)
        place += reach[:, None] * forward + mirror * manner.width / 2 * left
        place[:, [0, 2]] += 0.004 * rng.standard_normal((len(steps), 2))
        facing += np.radians(mirror * manner.toe_out + 0.7 * rng.standard_normal(len(steps)))
        pitched = table[:, 2] * effort[:, 0] ** 1.5
        held = contact - contact[0]
        ankle.append(ankle_over(b, place[held], facing[held], pitched))
        heading.append(facing[held])
        pitch.append(pitched)
        bend.append(table[:, 3] * effort[:, 0] ** 1.5)
        standing.append(np.mod(own, 1.0) <= c.stance)
        marching = (1.0 - effort[:, 0]) * bump(np.mod(own, 1.0), c.stance, c.stance + 0.15, 0.85, 1.0)
        lifted = np.outer(marching, np.radians([26.0, 56.0]))  # steps in place lift the foot
        free.append(table[:, :2] * effort + lifted)
    return Feet(*(np.stack(part, axis=1) for part in (ankle, heading, pitch, bend, standing, free)))


def _upper_body(
    manner: Manner,
    person: Person,
    c: Cycle,
    root: Floats,
    wave: Floats,
    vigour: Floats,
    course: Course,
    rng: np.random.Generator,
) -> tuple[Trunk, Arms]:
    """Pelvis, trunk, head and arms at the phase `wave` (T,) rad of the right leg's cycle."""
    t = course.t
    loose = 1.0 + drift(rng, t, c.time, 3 * person.irregularity, 4)
    turn = np.radians(manner.turn) * np.cos(wave) * vigour
    drop = -np.radians(manner.drop) * (np.cos(wave - 0.9) + 0.2 * np.cos(2 * wave)) * vigour * loose[:, 0]
    nod = np.radians(1.2) * np.cos(2 * wave - 0.8) * vigour
    rate = np.gradient(course.heading, t)
    bank = np.arctan(rate * vigour * c.length / c.time / GRAVITY)  # leaning into the curve: left side down
    tilt = np.radians(manner.tilt) * (0.5 + 0.5 * vigour) + nod
    lean = np.radians(manner.lean) * (0.4 + 0.6 * vigour) + 0.3 * nod
    counter = np.radians(manner.counter) * np.cos(wave - 0.1) * vigour * loose[:, 1]
    wander = drift(rng, t, 1.2, np.radians(1.0), 6)
    twist = -(turn + counter) + wander[:, 0]
    look = _glance(course, t) + wander[:, 1]
    spine = np.stack([lean - tilt + wander[:, 2], twist, -drop * 0.9 + 0.3 * bank + wander[:, 3] * 0.5], axis=1)
    neck = np.stack(
        [person.gaze - 0.8 * lean + wander[:, 4], counter * 0.8 + look, 0.15 * drop + wander[:, 5] * 0.5], axis=1
    )
    trunk = Trunk(root, course.heading + turn, tilt, drop - bank, spine, neck)
    return trunk, _arms(manner, person, wave, vigour, loose[:, 2:])


def _glance(course: Course, t: Floats) -> Floats:
    """(T,) rad: the head turns about 0.3 s before the body does.

    Source: Grasso, Prevost, Ivanenko and Berthoz, Neurosci. Lett. 253 (1998) 115-118.
    """
    ahead = np.interp(t + 0.35, t, course.heading) - course.heading
    return np.asarray(np.radians(50.0) * np.tanh(ahead / np.radians(50.0)))


def _arms(manner: Manner, person: Person, wave: Floats, vigour: Floats, loose: Floats) -> Arms:
    """Arms that swing against the legs, the elbow bending most when the arm is in front."""
    own = wave[:, None] + np.array([np.pi, 0.0]) - 0.1
    size = vigour[:, None] * loose * (1.0 + person.uneven * np.array([1.0, -1.0]))
    ahead = (-np.cos(own) + 0.1 * np.cos(2 * own - 0.5)) * size
    later = (-np.cos(own - 0.35) + 0.15 * np.cos(2 * own)) * size
    return swung(
        swing=np.radians(manner.hang + manner.swing * ahead),
        away=np.radians(manner.abduction) * (1.0 + 0.12 * np.cos(2 * own)),
        inward=np.radians(manner.inward) * (1.0 + 0.15 * ahead),
        elbow=np.radians(manner.elbow + manner.elbow_swing * later),
        clavicle=np.radians(np.stack([3.0 * ahead, 1.0 + 0.7 * ahead], axis=2)),
        wrist=np.radians(14.0 + 5.0 * ahead),
        hand=np.radians(-4.0 + 5.0 * np.cos(own - 1.0) * size),
    )
