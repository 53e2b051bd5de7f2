"""The body at one pose as the terms see it, and the sums that the terms add to."""

from dataclasses import dataclass, field
from typing import final

import numpy as np
from numpy.typing import NDArray

from ..arrays import Floats, Ints, Singles
from ..bodies.performer import AXES, DOFS, FIRST, MOVES, PARENTS, RESTS, Performer, Pose
from ..kernels import articulated, match, raycast, rendered
from .evidence import Evidence

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
    depth : (h, w) m, NaN = nothing.
    points : (h, w, 3) m. solid : (h, w), -1 = nothing. solid_placed : (P, 3, 4) camera from solid.
    performer : whose view it is.
    pixels, samples, normals, bones : (N, 2), (N, 3), (N, 3), (N,) of every n-th pixel.
    """

    pose: Pose
    placed: Floats
    twists: Floats
    depth: Singles
    points: Singles
    solid: NDArray[np.int16]
    solid_placed: Floats
    performer: Performer
    pixels: Ints
    samples: Singles
    normals: Singles
    bones: Ints

    def found(self, index: Ints) -> tuple[Singles, Singles, Ints]:
        """Points (N, 3), normals (N, 3) and bones (N,) of pixels by their flat index (N,), -1 = none."""
        solids = self.performer.solids
        samples, normals = np.empty((len(index), 3), np.float32), np.empty((len(index), 3), np.float32)
        bones = np.empty(len(index), np.int64)
        rendered.describe_found(
            index,
            self.points,
            self.solid,
            self.solid_placed,
            solids.kind,
            solids.size,
            solids.taper,
            solids.bone,
            samples,
            normals,
            bones,
        )
        return samples, normals, bones


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
        match.assemble(self.hessian, self.gradient, view.twists, MOVED_FIRST, BONES_MOVED, normal, right)
        return normal, right


def view_of(performer: Performer, pose: Pose, evidence: Evidence, every: int) -> View:
    """Cast the performer onto the raster of the evidence.

    Parameters
    ----------
    performer, pose : what is cast.
    evidence : of the frame: intrinsics, and depth (H, W) for the shape.
    every : every so-many-th row's and column's pixel is a sample (section 3.6: every fourth).
    """
    solids = performer.solids
    placed, twists = np.empty((len(PARENTS), 4, 4)), np.empty((DOFS, 6))
    articulated.frames(*performer.chain, pose.translation, pose.root, pose.joints, placed)
    articulated.twists(PARENTS, RESTS, FIRST, AXES, pose.joints, placed, twists)
    solid_placed, parts = np.empty((len(solids), 3, 4)), np.empty((len(solids), raycast.PARTS))
    raycast.place(placed, solids.bone, solids.center, solids.turn, solid_placed)
    shape = evidence.depth.shape
    raycast.prepare(
        solid_placed, solids.kind, solids.size, solids.taper, evidence.intrinsics, shape[1], shape[0], parts
    )
    depth, solid = np.empty(shape, np.float32), np.empty(shape, np.int16)
    raycast.cast(parts, depth, solid)
    # No larger than needed: large arrays come from the system page by page, each time anew.
    most = -(-shape[0] // every) * -(-shape[1] // every)
    points, pixels = np.empty((*shape, 3), np.float32), np.empty((most, 2), np.int64)
    samples, normals = np.empty((most, 3), np.float32), np.empty((most, 3), np.float32)
    bones = np.empty(most, np.int64)
    count = rendered.describe(
        depth,
        solid,
        solid_placed,
        solids.kind,
        solids.size,
        solids.taper,
        solids.bone,
        evidence.intrinsics,
        every,
        points,
        pixels,
        samples,
        normals,
        bones,
    )
    own = slice(0, count)
    return View(
        pose,
        placed,
        twists,
        depth,
        points,
        solid,
        solid_placed,
        performer,
        pixels[own],
        samples[own],
        normals[own],
        bones[own],
    )
