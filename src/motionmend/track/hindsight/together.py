"""All frames of a stretch solved together: what each of them shows, and that bodies do not jerk.

Frame by frame a pose is a compromise between the image and what was expected and is usual: the prior has to be strong
enough that no limb is lost, and there is time for one pixel in sixteen. Once it is known which account of each limb is
taken (`hindsight`) none is lost any more. So the prior is let go, the image is as fine as the camera gives it, and what
holds a pose beside it is the line between those before and after: the most likely path of all frames at once, by
Gauss-Newton (Bell 1994). Its systems are those of the frames, with bands between them.
"""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import TypeVar, final

import numpy as np
from threadpoolctl import threadpool_limits

from ...arrays import Bools, Floats
from ...bodies.performer import DOFS, Performer, Pose, advance, rotation, rotation_vector
from ...numerics.chained import chained
from ...numerics.least_squares import System
from ..frame.evidence import Evidence, evidence_of
from ..model import TrackerModel
from ..settings import TrackSettings
from ..state import TrackState
from ..terms.contract import Term
from ..terms.edge import EdgeTerm
from ..terms.freespace import FreespaceTerm
from ..terms.objective import PAUSE, terms_of
from ..terms.smooth import about
from ..terms.solve import LONGEST, linearized
from ..terms.surface import SurfaceTerm

FIRST, THIN, FULL = 1, 2, 1  # rounds of Gauss-Newton: with what the tracker looked at, half of the image, all of it
EVERY = 2  # every n-th row and column of it is a sample
FURTHER = 1.8  # times each step: as points are matched anew every time, all are too short (over-relaxation)
MARGIN = 0.3  # m about the person's pixels that are worked on: a limb that is wrong by more would not come back
LOOSER = 0.25  # of the prior's weight while following
CLOSER = 0.6  # of the estimator's scale while following: what is farther off is clothes, or another limb
YIELDING = 0.5  # of the weight of free space while following, where outlines are rough
HELD = 1e-3  # weight per m² and rad² of what separates a pose from where a round begins
STIFF = 1.0  # the same of what separates it from the line between its neighbours, at `RATE`
UNSEEN = 30.0  # more of it for coordinates of which nothing is seen: what few pixels say of them is not to be bent to
RATE = 30.0  # Hz; what accelerations at random make of a step has a variance that grows with the cube of its length
THREADS, AT_ONCE = 2, 8  # that work on frames side by side, and how many frames one of them takes at a time
LEAP = 0.1  # m and rad, the scale of Geman and McClure's weight of the same: one account of a limb may follow another
One = TypeVar("One")
Other = TypeVar("Other")
Made = TypeVar("Made")


def solved_together(
    model: TrackerModel,
    settings: TrackSettings,
    body: Performer,
    states: Sequence[TrackState],
    poses: Sequence[Pose | None],
) -> list[Pose | None]:
    """The poses of successive frames, solved together with what binds them.

    Parameters
    ----------
    model, settings : as for `tracker.step`.
    body : whose lengths and widths are used.
    states : after each frame, with its observation.
    poses : to begin from, near the truth; None where nobody is followed.

    Returns
    -------
    In the same order; None where there was none.
    """
    wish = replace(
        settings,
        prior=LOOSER * settings.prior,
        scale=CLOSER * settings.scale,
        freespace=YIELDING * settings.freespace,
        smooth=HELD,
    )
    closer = replace(wish, raster=1, every=EVERY)
    thin = replace(closer, every=EVERY + 1)
    out = list(poses)
    times = np.array([state.time for state in states])
    seen = np.array([state.evidence is not None for state in states])
    there = seen & np.array([pose is not None for pose in poses])
    one_each = threadpool_limits(1, user_api="blas")  # its own threads would wait for work on the cores that ours need
    with one_each, ThreadPoolExecutor(min(THREADS, os.cpu_count() or 1)) as pool:
        for first, last in _runs(there, times):
            some = [pose for pose in poses[first:last] if pose is not None]
            unseen = 1.0 - np.array([state.trust for state in states[first:last]])
            stiff = np.concatenate([np.full((last - first, 6), STIFF), STIFF + UNSEEN * unseen**4], axis=1)
            # Not side by side: what is mostly Python takes longer on two threads than on one.
            frames = list(map(partial(_first, model, wish, body), states[first:last], some))
            finer = list(map(partial(_closer, closer), states[first:last], frames))
            thinned = [_thinned(thin, frame) for frame in finer]
            for asked in (*[frames] * FIRST, *[thinned] * THIN, *[finer] * FULL):
                some = _moved(_each(pool, partial(_system, body), asked, some), body, some, times[first:last], stiff)
            out[first:last] = some
    return out


def between_turns(before: Floats, after: Floats, share: Floats | float) -> Floats:
    """The rotations (..., 3, 3) so far on the way from some to others, 0 to 1: (..., 1)."""
    return np.asarray(rotation(share * rotation_vector(after @ before.swapaxes(-1, -2))) @ before)


@final
@dataclass(frozen=True, eq=False)
class _Asked:
    """What one frame is asked: terms made for its evidence."""

    settings: TrackSettings
    evidence: Evidence
    terms: list[Term]


def _first(model: TrackerModel, settings: TrackSettings, body: Performer, state: TrackState, pose: Pose) -> _Asked:
    assert state.evidence is not None
    at = replace(state, performer=body, pose=pose)
    return _Asked(settings, state.evidence, terms_of(model, settings, at, state.evidence, pose))


def _closer(settings: TrackSettings, state: TrackState, asked: _Asked) -> _Asked:
    """The same of all that the frame shows."""
    assert state.observation is not None
    evidence = evidence_of(state.observation, settings, MARGIN)
    assert evidence is not None
    return _asked_of(asked, settings, evidence)


def _thinned(settings: TrackSettings, asked: _Asked) -> _Asked:
    """The same of every other observed sample, and about as many of the body's: the way there needs no more."""
    seen = asked.evidence
    pixels = seen.pixels[::2].copy()
    evidence = replace(
        seen,
        pixels=pixels,
        samples=seen.samples[::2].copy(),
        edge_pixels=seen.edge_pixels[::2].copy(),
        edge_samples=seen.edge_samples[::2].copy(),
        weight=seen.weight * len(seen.pixels) / max(len(pixels), 1),  # together they count as much as all did
    )
    return _asked_of(asked, settings, evidence)


def _asked_of(asked: _Asked, settings: TrackSettings, evidence: Evidence) -> _Asked:
    """The same of other evidence; what is usual stays as it was found."""
    terms = [
        replace(term, evidence=evidence, settings=settings)
        if isinstance(term, SurfaceTerm | EdgeTerm | FreespaceTerm)
        else term
        for term in asked.terms
    ]
    return _Asked(settings, evidence, terms)


def _each(
    pool: ThreadPoolExecutor, task: Callable[[One, Other], Made], ones: Sequence[One], others: Sequence[Other]
) -> list[Made]:
    """What the task makes of each pair, in order; the kernels let threads run side by side."""

    def some(first: int) -> list[Made]:
        at = slice(first, first + AT_ONCE)
        return [task(one, other) for one, other in zip(ones[at], others[at], strict=True)]

    return [made for few in pool.map(some, range(0, len(ones), AT_ONCE)) for made in few]


def _system(body: Performer, asked: _Asked, pose: Pose) -> System:
    return linearized(body, asked.evidence, about(asked.terms, pose), pose, asked.settings)


def _moved(
    systems: Sequence[System], body: Performer, poses: Sequence[Pose], times: Floats, stiff: Floats
) -> list[Pose]:
    """One round: the poses a step further; `stiff` (T, 34) is the weight of the line between neighbours at `RATE`."""
    normal, right = (np.array([getattr(one, name) for one in systems]) for name in ("normal", "right"))
    bent, stiffness, share = np.zeros(right.shape), np.zeros(right.shape), np.zeros(len(times))
    way, joints = np.array([pose.translation for pose in poses]), np.array([pose.joints for pose in poses])
    span = times[2:] - times[:-2]
    share[1:-1] = (times[1:-1] - times[:-2]) / span
    for part, columns in ((way, slice(0, 3)), (joints, slice(6, DOFS))):
        bent[1:-1, columns] = part[1:-1] - part[:-2] - share[1:-1, None] * (part[2:] - part[:-2])
    root = np.array([pose.root for pose in poses])
    turned = between_turns(root[:-2], root[2:], share[1:-1, None])
    bent[1:-1, 3:6] = rotation_vector(root[1:-1] @ turned.swapaxes(1, 2))
    stiffness[1:-1] = stiff[1:-1] * (2.0 / RATE / span[:, None]) ** 3 * (1.0 + (bent[1:-1] / LEAP) ** 2) ** -2.0
    steps = FURTHER * chained(normal, right, bent, stiffness, share)
    steps *= np.minimum(1.0, LONGEST / np.maximum(np.abs(steps).max(axis=1, keepdims=True), LONGEST))
    return [advance(body, pose, step) for pose, step in zip(poses, steps, strict=True)]


def _runs(there: Bools, times: Floats) -> list[tuple[int, int]]:
    """First and one past the last of frames that follow each other without a pause."""
    step = np.diff(times)
    parted = ~there[1:] | ~there[:-1] | ~((step > 0.0) & (step < PAUSE))
    ends = [0, *(np.flatnonzero(parted) + 1).tolist(), len(times)]
    return [(one, other) for one, other in pairwise(ends) if there[one]]
