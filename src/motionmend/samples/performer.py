"""Clips of the performer, one or many."""

from collections.abc import Iterable

import numpy as np

from ..bodies.motion import Motion
from ..errors import UsageError
from .actions import run, turn, walk
from .body import build, skeleton
from .person import person
from .pose import joint_angles
from .reaching import reach
from .standing import jump

_PERFORM = {"walk": walk, "run": run, "jump": jump, "reach": reach, "turn": turn}
ACTIONS = tuple(_PERFORM)
RATE = 240  # Hz, at which clips are made before they are sampled
_MARGIN = 3 * RATE  # frames before and after, so that steps cut by the clip's ends are whole


def clip(
    action: str,
    *,
    seconds: float,
    fps: float = 120.0,
    seed: int = 0,
    speed: float = 1.0,
    style: float = 0.0,
    height: float = 1.75,
) -> Motion:
    """One recording of the performer.

    The same arguments give the same clip, and another rate the same movement sampled otherwise. Joint angles have
    no jumps and stay within the skeleton's limits; standing feet stay where they are.

    Parameters
    ----------
    action : one of `ACTIONS`.
    seconds : length, s; the clip has seconds · fps frames, rounded.
    fps : Hz.
    seed : whose small habits and whose irregularities, and the choices of the trial (what to reach for, where to turn).
    speed : 0.5 to 1.6 times the natural speed: 1.35 m/s walking, 3 m/s running, both growing with stature; of jumps the
        speed at take-off, of reaching that of the hands.
    style : -1 (weary) to 1 (brisk).
    height : stature, m, 1 to 2.5.

    Returns
    -------
    Motion
        T frames of the 62 DOFs of `skeleton(height)`, rad and m, y up, the floor at 0, setting out along z.

    Raises
    ------
    UsageError
        An unknown action, or a number out of its range.
    """
    if action not in _PERFORM:
        raise UsageError(f"action must be one of {', '.join(ACTIONS)}, came {action!r}")
    for name, value, low, high in (("speed", speed, 0.5, 1.6), ("style", style, -1.0, 1.0)):
        if not low <= value <= high:
            raise UsageError(f"{name} must be between {low} and {high}, came {value}")
    if not (np.isfinite(fps) and fps > 0 and np.isfinite(seconds) and round(seconds * fps) >= 1):
        raise UsageError(f"a clip needs a frame or more, came {seconds} s at {fps} Hz")
    if seed < 0:
        raise UsageError(f"seed must be 0 or above, came {seed}")
    from scipy.interpolate import CubicSpline

    body = skeleton(height)
    times = np.arange(round(seconds * fps)) / fps
    made = np.arange(-_MARGIN, int(np.ceil(times[-1] * RATE)) + _MARGIN + 1) / RATE
    who = person(height, style, np.random.default_rng([seed, 0]))
    trial = np.random.default_rng([seed, 1 + ACTIONS.index(action)])
    q = joint_angles(body, build(height), _PERFORM[action](who, made, speed, trial))
    q = CubicSpline(made[_MARGIN - 2 : 2 - _MARGIN or None], q[_MARGIN - 2 : 2 - _MARGIN or None])(times)
    for column in (0, 2):  # sets out from the origin
        q[:, column] -= q[0, column]
    return Motion(body, q, fps)


def library(
    actions: Iterable[str] = ACTIONS, seeds: Iterable[int] = range(3), *, seconds: float = 8.0, fps: float = 120.0
) -> tuple[Motion, ...]:
    """Clips of several people: each seed is one person, of stature, style and speed of their own, in every action.

    Parameters
    ----------
    actions : of `ACTIONS`.
    seeds : one person each.
    seconds, fps : of every clip, s and Hz.

    Returns
    -------
    Clips person by person, for each the actions in the order given.
    """
    wanted = tuple(actions)
    clips = []
    for seed in seeds:
        rng = np.random.default_rng([seed, len(ACTIONS) + 1])
        height = float(np.round(np.clip(rng.normal(1.72, 0.09), 1.5, 1.95), 2))
        style = float(np.round(rng.uniform(-0.8, 0.8), 2))
        speed = float(np.round(rng.uniform(0.85, 1.15), 2))
        clips += [
            clip(action, seconds=seconds, fps=fps, seed=seed, speed=speed, style=style, height=height)
            for action in wanted
        ]
    return tuple(clips)
