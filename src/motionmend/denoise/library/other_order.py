"""Joints that turn in another order than in the clips, or rest in another pose: a library speaks of other angles."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ...arrays import Floats, Ints
from ...bodies.motion import Motion, Recording, Repaired
from ...bodies.skeleton import ROTATION, turned_in_other_order
from ...errors import MismatchError, few
from ..channels.branches import FLIP, nearest_triple, nearest_turn, steady_triple
from ..channels.joints import DEGREES, middle, triples
from ..channels.layout import Layout
from ..channels.rotation_order import Reordered, in_order
from .exemplars import Library, mean_bends, typical_bends

OTHERWISE = " (of another kind)"
FAR = 50.0  # degrees; postures of other people and motions lie up to 40 beyond what a library of walks shows


def by_what_is_meant(
    repair: Callable[[Recording], Repaired[Recording]], recording: Recording, layout: Layout, library: Library
) -> Repaired[Recording]:
    """Repair a recording by a library, but for joints whose angles mean another thing in its clips: these it knows not.

    They turn in another order there, or about axes that lie otherwise as the body rests.

    Parameters
    ----------
    repair : by the library; what it does not know by name it leaves to the recording itself.
    recording : motion or markers; markers have no order.
    layout, library : of the clips.

    Raises
    ------
    MismatchError
        Too few joints turn as in the clips, or what `repair` raises.
    """
    if not isinstance(recording, Motion):
        return repair(recording)
    return _by_what_is_meant(repair, recording, *_meaning_another_thing(recording, layout, library))


def _by_what_is_meant(
    repair: Callable[[Motion], Repaired[Motion]], motion: Motion, joints: set[int], said: tuple[str, ...]
) -> Repaired[Motion]:
    """Repair a motion with other names for the angles of these joints, and say why."""
    if not joints:
        return repair(motion)
    try:
        outcome = repair(_called_otherwise(motion, joints))
    except MismatchError as error:
        raise MismatchError(f"{said[0]} ({error})") from None
    as_it_was = replace(outcome.recording, skeleton=motion.skeleton)
    return replace(outcome, recording=as_it_was, warnings=(*said, *outcome.warnings))


def _meaning_another_thing(motion: Motion, layout: Layout, library: Library) -> tuple[set[int], tuple[str, ...]]:
    """Joints whose angles do so, and a sentence for each kind of them."""
    names, said = motion.skeleton.names, list[str]()
    turned, apart = turned_in_other_order(motion.skeleton, layout.names), _nowhere_near(motion, layout, library)
    if len(turned):
        said.append(
            f"{few([names[joint] for joint in turned])} turn in another order than in the library's clips, whose "
            "angles mean another thing and are not used for them: a library of clips in this order, or this recording "
            "written in theirs, would help"
        )
    if len(apart):
        said.append(
            f"{few([names[joint] for joint in apart])} mostly lie more than {FAR:.0f} degrees beyond all that the "
            "library's clips do, as of another pose at rest: what it knows is not used for them"
        )
    return {*turned.tolist(), *apart.tolist()}, tuple(said)


def _nowhere_near(motion: Motion, layout: Layout, library: Library) -> Ints:
    """Joints but the root that are mostly more than `FAR` beyond what they do in any of a library's windows."""
    skeleton, column_of = motion.skeleton, {name: column for column, name in enumerate(layout.names)}
    if not len(library.exemplars):
        return np.zeros(0, dtype=np.int64)
    least, most = library.exemplars.min(axis=(0, 1)), library.exemplars.max(axis=(0, 1))
    balls = {int(skeleton.dof_joint[rows[0]]) for rows in triples(skeleton)}
    found = []
    for joint in range(1, len(skeleton.names)):
        rows = skeleton.dofs_of(joint)
        rows = rows[skeleton.dof_kind[rows] == ROTATION]
        columns = [column_of[name] for row in rows if (name := skeleton.dof_names[row]) in column_of]
        if not len(rows) or len(columns) < len(rows):
            continue
        centre, nearest = layout.centre[columns], nearest_triple if joint in balls else nearest_turn
        angles = nearest(motion.q[:, rows] * DEGREES, np.broadcast_to(centre, (motion.frames, len(rows))))
        usual = np.array([np.median(one[np.isfinite(one)]) if np.isfinite(one).any() else np.nan for one in angles.T])
        if (np.fmax(least[columns] - usual, usual - most[columns]) > FAR).any():
            found.append(joint)
    return np.array(found, dtype=np.int64)


def rewritten(layout: Layout, library: Library, joints: Sequence[Reordered]) -> tuple[Layout, Library]:
    """A library's layout and exemplars with joints in the order of a recording.

    How sharply the rewritten angles bend is read off the exemplars; from rate to rate the three of a joint change
    together, by as much as all three of them did in the clips.

    Parameters
    ----------
    layout, library : of joint angles, degrees and cm.
    joints : `reordered` by the layout's names.
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
