"""What `track` writes: tables of joints in camera axes, or joint angles."""

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
    from ..bodies.handback import motion_of
    from ..bodies.templates import skeleton_of

    there = followed.postures.present.any(axis=1)
    poses = followed.poses
    translation, root, joints = (
        np.where(there.reshape(-1, *[1] * (values.ndim - 1)), values, np.nan)
        for values in (poses.translation, poses.root, poses.joints)
    )
    upright = Poses(translation, root, joints).moved(UPRIGHT, np.zeros(3))
    body = followed.performer
    return motion_of(upright, body, skeleton_of(body) if skeleton is None else skeleton, fps)
