"""Joints and markers called by who exported them or who wears them: `mixamorig7:LeftArm`, `Bob_LFHD`."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from ...bodies.motion import Markers, Motion, Recording, Repaired

SEPARATORS = "_-|./ "  # between a subject and a marker's name, beside the colon


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


def by_bare_names(
    repair: Callable[[Recording], Repaired[Recording]], recording: Recording, taught: Sequence[str]
) -> Repaired[Recording]:
    """Repair a recording by a library that knows other names of its channels.

    Parameters
    ----------
    repair : by that library.
    recording : joints may be called by a namespace before a colon; markers by a subject before any of `SEPARATORS`.
    taught : the library's names.
    """
    if isinstance(recording, Markers):
        if (called := called_as_taught(recording.names, taught)) == recording.names:
            return repair(recording)
        of_markers: Repaired[Markers] = repair(replace(recording, names=called))
        return replace(of_markers, recording=replace(of_markers.recording, names=recording.names))
    if (barely := called_barely(recording)) is recording:
        return repair(recording)
    outcome: Repaired[Motion] = repair(barely)
    return replace(outcome, recording=replace(outcome.recording, skeleton=recording.skeleton))


def bare_name(name: str) -> str:
    """A marker's name without the subject before the colon, in capitals: what clips of other people share."""
    return name.rpartition(":")[2].strip().upper()


def called_as_taught(names: Sequence[str], taught: Sequence[str]) -> tuple[str, ...]:
    """Markers' names as a library spells them, where all that differs is the subject they all begin with."""
    own = [bare_name(name) for name in names]
    known = {without_subject(name, taught): name for name in taught}
    meant = tuple(known.get(without_subject(name, own), name) for name in own)
    more = len(set(meant) & set(taught)) > len(set(own) & set(taught))
    return meant if more and len(set(meant)) == len(meant) else tuple(names)


def without_subject(name: str, names: Sequence[str]) -> str:
    """A name without what all names begin with, up to the last separator in that."""
    if len(names) < 2:
        return name
    first, last = min(names), max(names)  # in their order: what these two share all others do
    shared = next((k for k, (a, b) in enumerate(zip(first, last, strict=False)) if a != b), min(len(first), len(last)))
    return name[max(first.rfind(separator, 0, shared) for separator in SEPARATORS) + 1 :]
