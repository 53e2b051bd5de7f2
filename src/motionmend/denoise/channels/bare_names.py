"""Joints called by a namespace before a colon (`mixamorig7:LeftArm`): who exported them is not what they are."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from ...bodies.motion import Motion, Recording, Repaired


def bare(names: Sequence[str]) -> tuple[str, ...]:
    """Channels' names from the last colon on, as they are where two of them would be called the same."""
    after = tuple(name.rpartition(":")[2].strip() for name in names)
    return after if len(set(after)) == len(after) else tuple(names)


def called_barely(motion: Motion) -> Motion:
    """The motion with its channels called so."""
    names = bare(motion.skeleton.dof_names)
    if names == motion.skeleton.dof_names:
        return motion
    return replace(motion, skeleton=replace(motion.skeleton, dof_names=names))


def by_bare_names(repair: Callable[[Recording], Repaired[Recording]], recording: Recording) -> Repaired[Recording]:
    """Repair a recording by a library that knows bare names; markers are always so called."""
    if not isinstance(recording, Motion) or (barely := called_barely(recording)) is recording:
        return repair(recording)
    outcome: Repaired[Motion] = repair(barely)
    return replace(outcome, recording=replace(outcome.recording, skeleton=recording.skeleton))
