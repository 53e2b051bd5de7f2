"""What a look at a recording shows before anything is done to it: gaps, jumps, and joints to distrust."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Bools, Floats
from ..bodies.motion import Markers, Motion
from ..bodies.skeleton import ROTATION, wrapped
from ..denoise.faults.frozen import held_ends
from ..denoise.faults.slower import DRAWN, REPEATED, as_slower, ends_of_lines, shown_once
from ..errors import counted

JUMP = np.radians(60.0)  # rad between two frames: no joint turns that fast, an Euler angle does
FAST_TURN = np.radians(2500.0)  # rad/s; a pitcher's elbow reaches 2,400 degrees a second
FAST_MOVE = 15.0  # m/s; a sprinter's root reaches 12
FAST_MARKER = 25.0  # m/s; a hand or foot that strikes reaches 20
FLAT = 1e-9  # rad or m; less travel than this over a whole recording is none
OUTSIDE = np.radians(1.0)  # rad; limits are written in whole degrees


@dataclass(frozen=True)
class Jump:
    """Frames at which a channel is far from where it was one frame before (0 = the first frame).

    `wraps` says for each whether the angle only went round by a full turn, which no joint notices.
    """

    channel: str
    frames: tuple[int, ...]
    wraps: tuple[bool, ...]


@dataclass(frozen=True)
class Suspicion:
    """A joint's channel or a marker that may not be what it claims, and why."""

    name: str
    what: str
    detail: str


def missing_shares(recording: Motion | Markers) -> dict[str, float]:
    """Share of the frames that each channel or marker lacks, in [0, 1]."""
    shares = 1.0 - recording.present.mean(axis=0) if recording.frames else np.zeros(len(recording.channels))
    return dict(zip(labels(recording.channels), shares.tolist(), strict=True))


def labels(names: Sequence[str]) -> list[str]:
    """The names, a repeated one with its number, so that none is lost as a key."""
    seen: dict[str, int] = {}
    unique = []
    for name in names:
        seen[name] = seen.get(name, 0) + 1
        unique.append(name if seen[name] == 1 else f"{name}#{seen[name]}")
    return unique


def jumps(motion: Motion) -> tuple[Jump, ...]:
    """Rotation channels that change by more than 60 degrees from one frame to the next."""
    found = []
    for c in np.flatnonzero(motion.skeleton.dof_kind == ROTATION):
        step = np.diff(motion.q[:, c])
        at = np.flatnonzero(np.abs(step) > JUMP)
        if at.size:
            wraps = np.abs(wrapped(step[at])) <= JUMP
            found.append(Jump(motion.channels[c], tuple((at + 1).tolist()), tuple(wraps.tolist())))
    return tuple(found)


def leaps(names: Sequence[str], positions: Floats, times: Floats, fastest: float) -> tuple[Jump, ...]:
    """Frames in which points are farther from where they were one frame before than people go.

    Parameters
    ----------
    names : (P,) of the points.
    positions : (T, P, 3) m, NaN = missing.
    times : (T,) s.
    fastest : m/s.
    """
    step = np.diff(times)
    with np.errstate(invalid="ignore"):
        far = np.linalg.norm(np.diff(positions, axis=0), axis=2) > fastest * np.where(step > 0, step, np.inf)[:, None]
    found = []
    for p, name in enumerate(labels(names)):
        at = np.flatnonzero(far[:, p]) + 1
        if at.size:
            found.append(Jump(name, tuple(at.tolist()), (False,) * at.size))
    return tuple(found)


def listed(jumped: Sequence[Jump]) -> list[dict[str, str | int | bool]]:
    """Jumps one by one, as JSON has them."""
    return [
        {"channel": jump.channel, "frame": frame, "wrap": wrap}
        for jump in jumped
        for frame, wrap in zip(jump.frames, jump.wraps, strict=True)
    ]


def suspicions(recording: Motion | Markers) -> tuple[Suspicion, ...]:
    """Channels or markers outside their limits, never moving, held at an end, shown again, on lines, or too fast."""
    every, ends = "every channel" if isinstance(recording, Motion) else "every marker", held_ends(recording)
    held = tuple(
        Suspicion(every, "held", f"in the {which} {count} frames, to the last digit")
        for which, count in zip(("first", "last"), ends, strict=True)
        if count
    )
    if (shown := shown_once(recording)) is not None:
        held += (Suspicion(every, REPEATED, as_slower(recording, shown, REPEATED)),)
    elif (drawn := ends_of_lines(recording)) is not None:
        held += (Suspicion(every, DRAWN, as_slower(recording, drawn, DRAWN)),)
    return held + (_of_motion(recording) if isinstance(recording, Motion) else _of_markers(recording))


def _of_motion(motion: Motion) -> tuple[Suspicion, ...]:
    found = []
    for c, name in enumerate(motion.channels):
        values, limits = motion.q[:, c], motion.skeleton.limits[c]
        there = values[np.isfinite(values)]
        turns = motion.skeleton.dof_kind[c] == ROTATION
        if not there.size:
            continue
        if turns:
            excess = np.maximum(limits[0] - values, values - limits[1])
            outside = excess > OUTSIDE
            if outside.any():
                most = np.degrees(np.nanmax(excess))
                found.append(Suspicion(name, "outside limits", f"{_share(outside)}, by up to {most:.0f} degrees"))
        if motion.frames > 1 and np.ptp(there) <= FLAT:
            at = f"{round(np.degrees(there[0]), 1) + 0.0} degrees" if turns else f"{round(there[0], 3) + 0.0} m"
            found.append(Suspicion(name, "flat", f"at {at} throughout"))
        step = np.diff(values)
        speed = np.abs(wrapped(step) if turns else step) * motion.fps
        found += _fast(name, speed, FAST_TURN if turns else FAST_MOVE, turns)
    return tuple(found)


def _of_markers(markers: Markers) -> tuple[Suspicion, ...]:
    found = []
    for m, name in enumerate(markers.names):
        there = markers.positions[markers.present[:, m], m]
        if len(there) > 1 and float(np.ptp(there, axis=0).max()) <= FLAT:
            x, y, z = there[0]
            found.append(Suspicion(name, "flat", f"at ({x:.3f}, {y:.3f}, {z:.3f}) m throughout"))
        speed = np.linalg.norm(np.diff(markers.positions[:, m], axis=0), axis=1) * markers.fps
        found += _fast(name, speed, FAST_MARKER, False)
    return tuple(found)


def _fast(name: str, speed: Floats, limit: float, turns: bool) -> list[Suspicion]:
    fast = speed > limit
    if not fast.any():
        return []
    most = float(np.nanmax(speed))
    said = f"{np.degrees(most):.0f} degrees/s" if turns else f"{most:.0f} m/s"
    return [Suspicion(name, "extreme speed", f"{_share(fast)}, up to {said}")]


def _share(frames: Bools) -> str:
    count = int(frames.sum())
    return f"{counted(count, 'frame')} ({percent(count / frames.size)})"


def percent(share: float) -> str:
    """A share in [0, 1] for people."""
    return f"{100 * share:.0f} %" if share >= 0.1 else f"{100 * share:.2g} %"
