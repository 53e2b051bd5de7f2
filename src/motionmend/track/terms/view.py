"""The body at one pose as the terms see it, and the sums that the terms add to."""

from dataclasses import dataclass, field
from typing import final

import numpy as np
from numpy.typing import NDArray

from ...arrays import Floats, Ints, Singles
from ...bodies.performer import DOFS, MOVES, PARENTS, Performer, Pose
from ...kernels import bone_systems, raycast, rendered
from ..frame.evidence import Evidence

BONES_MOVED = np.flatnonzero(MOVES.ravel()) % DOFS  # degrees of freedom that move bone 0, then bone 1, ...
MOVED_FIRST = np.concatenate(([0], np.cumsum(MOVES.sum(axis=1)))).astype(np.int64)


@final
@dataclass(frozen=True, eq=False)
class View:
    """A performer in a pose, seen by the camera of the evidence.

    Attributes
    ----------
    pose : the pose.
    placed : (B, 4, 4) camera from bone. twists : (34, 6).
    depth : (h, w) m, NaN = nothing. solid : (h, w), -1 = nothing. solid_placed : (P, 3, 4) camera from solid.
    performer : whose view it is.
    pixels, samples, normals, bones : (N, 2), (N, 3), (N, 3), (N,) of every n-th pixel.
    """

    pose: Pose
    placed: Floats
    twists: Floats
    depth: Singles
    solid: NDArray[np.int16]
    solid_placed: Floats
    performer: Performer
    pixels: Ints
    samples: Singles
    normals: Singles
    bones: Ints


@final
@dataclass(eq=False)
class Sums:
    """What the terms add to: a 6 x 6 system per bone and one of all degrees of freedom.

    Attributes
    ----------
    hessian, gradient : (B, 6, 6) upper triangles and (B, 6).
    normal, right : (34, 34) and (34,).
    """

    hessian: Floats = field(default_factory=lambda: np.zeros((len(PARENTS), 6, 6)))
    gradient: Floats = field(default_factory=lambda: np.zeros((len(PARENTS), 6)))
    normal: Floats = field(default_factory=lambda: np.zeros((DOFS, DOFS)))
    right: Floats = field(default_factory=lambda: np.zeros(DOFS))

    def assembled(self, view: View) -> tuple[Floats, Floats]:
        """Normal matrix and right side of everything added so far."""
        normal, right = self.normal.copy(), self.right.copy()
        bone_systems.assemble(self.hessian, self.gradient, view.twists, MOVED_FIRST, BONES_MOVED, normal, right)
        return normal, right


def view_of(performer: Performer, pose: Pose, evidence: Evidence, every: int) -> View:
    """Cast the performer onto the raster of the evidence.

    Parameters
    ----------
    performer, pose : what is cast.
    evidence : of the frame: intrinsics, and depth (H, W) for the shape.
    every : every so-many-th row's and column's pixel is a sample (section 3.6: every fourth).
    """
    shape, solids = evidence.depth.shape, len(performer.solids)
    # No larger than needed: large arrays come from the system page by page, each time anew.
    most = -(-shape[0] // every) * -(-shape[1] // every)
    placed, moving = np.empty((len(PARENTS), 4, 4)), np.empty((DOFS, 6))
    solid_placed, parts = np.empty((solids, 3, 4)), np.empty((solids, raycast.PARTS))
    depth, solid = np.empty(shape, np.float32), np.empty(shape, np.int16)
    pixels, bones = np.empty((most, 2), np.int64), np.empty(most, np.int64)
    samples, normals = np.empty((most, 3), np.float32), np.empty((most, 3), np.float32)
    count = rendered.sampled(
        performer.chain,
        pose.arrays,
        performer.solids.arrays,
        evidence.intrinsics,
        every,
        placed,
        moving,
        solid_placed,
        parts,
        depth,
        solid,
        pixels,
        samples,
        normals,
        bones,
    )
    return View(
        pose,
        placed,
        moving,
        depth,
        solid,
        solid_placed,
        performer,
        pixels[:count],
        samples[:count],
        normals[:count],
        bones[:count],
    )
