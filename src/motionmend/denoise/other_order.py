"""Joints that turn in another order than in the clips: what a library says of angles so called is of other angles."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from ..bodies.motion import Motion, Recording, Repaired
from ..bodies.skeleton import ROTATION, turned_in_other_order
from ..errors import MismatchError

OTHERWISE = " (in another order)"
NAMED = 4


def by_what_is_meant(
    repair: Callable[[Recording], Repaired[Recording]], recording: Recording, names: Sequence[str]
) -> Repaired[Recording]:
    """Repair a recording by a library, but for joints that turn in another order than its clips': these it knows not.

    Parameters
    ----------
    repair : by the library; what it does not know by name it leaves to the recording itself.
    recording : motion or markers; markers have no order.
    names : the library's channels, in the order of its clips.

    Raises
    ------
    MismatchError
        Too few joints turn as in the clips, or what `repair` raises.
    """
    if not isinstance(recording, Motion) or not len(joints := turned_in_other_order(recording.skeleton, names)):
        return repair(recording)
    skeleton = recording.skeleton
    named = ", ".join(skeleton.names[j] for j in joints[:NAMED]) + (", ..." if len(joints) > NAMED else "")
    said = (
        f"{named} turn in another order than in the library's clips, whose angles mean another thing and are not used "
        "for them: a library of clips in this order, or this recording written in theirs, would help"
    )
    called = _called_otherwise(recording, set(joints.tolist()))
    try:
        outcome: Repaired[Motion] = repair(called)
    except MismatchError as error:
        raise MismatchError(f"{said} ({error})") from None
    as_it_was = replace(outcome.recording, skeleton=skeleton)
    return replace(outcome, recording=as_it_was, warnings=(said, *outcome.warnings))


def _called_otherwise(motion: Motion, joints: set[int]) -> Motion:
    """The motion with other names for these joints' angles."""
    skeleton = motion.skeleton
    names = tuple(
        name + OTHERWISE if kind == ROTATION and joint in joints else name
        for name, joint, kind in zip(skeleton.dof_names, skeleton.dof_joint, skeleton.dof_kind, strict=True)
    )
    return replace(motion, skeleton=replace(skeleton, dof_names=names))
