"""What `track` writes: tables of joints in camera axes, or joint angles."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..bodies.motion import Motion
from ..bodies.performer import Poses
from .inputs import ending

if TYPE_CHECKING:
    from ..bodies.skeleton import Skeleton
    from .following import Followed

UPRIGHT = np.diag((1.0, -1.0, -1.0))  # from camera axes (y down, z forward) to y up, z towards the camera


def write_followed(path: Path, followed: "Followed", skeleton: "Skeleton | None", fps: float) -> None:
    """Write joints (.csv) or joint angles (.bvh, .amc); the file is whole or not there.

    Parameters
    ----------
    path : its ending says which.
    followed : what the tracker made of a recording.
    skeleton : whose angles are written; None writes those of the performer itself.
    fps : Hz.

    Raises
    ------
    FileError : the file cannot be written.
    """
    if ending(path) == ".csv":
        from ..io.joint_table import write_joint_table

        write_joint_table(path, followed.postures)
        return
    from ..io import write

    write(path, followed_motion(followed, skeleton, fps))


def followed_motion(followed: "Followed", skeleton: "Skeleton | None", fps: float) -> Motion:
    """Joint angles of what was followed, y up; missing in frames without the person.

    Parameters
    ----------
    followed, skeleton, fps : as for `write_followed`.
    """
    from ..bodies.templates import motion_of

    there = np.isfinite(followed.poses.joints).all(axis=1)
    first = int(np.flatnonzero(there)[0])
    poses = followed.poses
    whole = Poses(*(_filled(getattr(poses, name), there, first) for name in ("translation", "root", "joints")))
    motion = motion_of(whole.moved(UPRIGHT, np.zeros(3)), followed.performer, skeleton, fps)
    q = motion.q.copy()
    q[~followed.postures.present.any(axis=1)] = np.nan
    return replace(motion, q=q)


def _filled(values: np.ndarray, there: np.ndarray, first: int) -> np.ndarray:
    """The same with what comes before the first pose made equal to it."""
    whole = values.copy()
    whole[~there] = values[first]
    return whole
