"""Joints that turn in another order than in the clips: what a library says of angles so called is of other angles."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ..arrays import Floats
from ..bodies.motion import Motion, Recording, Repaired
from ..bodies.skeleton import ROTATION, turned_in_other_order
from ..errors import MismatchError
from .branches import FLIP, nearest_triple, steady_triple
from .joints import middle
from .layout import Layout
from .library import Library, mean_bends, typical_bends
from .rotation_order import Reordered, few, in_order

OTHERWISE = " (in another order)"


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
    turned = few([skeleton.names[joint] for joint in joints])
    said = (
        f"{turned} turn in another order than in the library's clips, whose angles mean another thing and are not used "
        "for them: a library of clips in this order, or this recording written in theirs, would help"
    )
    called = _called_otherwise(recording, set(joints.tolist()))
    try:
        outcome: Repaired[Motion] = repair(called)
    except MismatchError as error:
        raise MismatchError(f"{said} ({error})") from None
    as_it_was = replace(outcome.recording, skeleton=skeleton)
    return replace(outcome, recording=as_it_was, warnings=(said, *outcome.warnings))


def rewritten(layout: Layout, library: Library, joints: Sequence[Reordered]) -> tuple[Layout, Library]:
    """A library's layout and exemplars with joints in the order of a recording.

    How sharply the rewritten angles bend is read off the exemplars; from rate to rate the three of a joint change
    together, by as much as all three of them did in the clips.
    """
    names, centre = list(layout.names), layout.centre.copy()
    windows = library.exemplars.astype(np.float64)
    bends = np.diagonal(library.bends, axis1=1, axis2=2).copy()
    own_bends = np.diagonal(mean_bends(windows)).copy()
    column_of = {name: column for column, name in enumerate(layout.names)}
    for joint in joints:
        columns = [column_of[joint.names[k]] for k in joint.in_clips]
        for column, name in zip(columns, joint.names, strict=True):
            names[column] = name
        if joint.root:
            continue  # its channels are a rotation vector's x, y and z, in whatever order it turns
        axes = np.array(joint.axes)
        windows[:, :, columns], centre[columns] = _in_order(
            windows[:, :, columns], axes[list(joint.in_clips)], axes, library.rate
        )
        bends[:, columns] = bends[:, columns].mean(axis=1, keepdims=True)
        own_bends[columns] = own_bends[columns].mean()
    exemplars = np.array(windows, dtype=np.float32)
    grown = np.sqrt(bends / np.where(own_bends > 0, own_bends, np.inf))
    return replace(layout, names=tuple(names), centre=centre), replace(
        library,
        bends=np.einsum("ri,ij,rj->rij", grown, mean_bends(exemplars), grown),
        exemplars=exemplars,
        typical=typical_bends(exemplars),
    )


def _in_order(windows: Floats, axes: Floats, wanted: Floats, rate: float) -> tuple[Floats, Floats]:
    """Windows (N, M, 3) of a joint's angles in another order, without leaps, and the middle (3,) they stay about."""
    angles = in_order(windows.reshape(-1, 3), axes, wanted)
    centre = middle(angles, np.ones(3, dtype=bool))
    series = nearest_triple(angles, centre).reshape(windows.shape)
    for k in np.flatnonzero(np.abs(np.diff(series, axis=1)).sum(axis=2).max(axis=1, initial=0.0) >= FLIP):
        series[k] = steady_triple(series[k], centre, rate)
    return series, centre


def _called_otherwise(motion: Motion, joints: set[int]) -> Motion:
    """The motion with other names for these joints' angles."""
    skeleton = motion.skeleton
    names = tuple(
        name + OTHERWISE if kind == ROTATION and joint in joints else name
        for name, joint, kind in zip(skeleton.dof_names, skeleton.dof_joint, skeleton.dof_kind, strict=True)
    )
    return replace(motion, skeleton=replace(skeleton, dof_names=names))
