"""All steps of Gauss-Newton for one frame's pose, from the picture of the body to its next place, without a return.

The steps are those that `least_squares.gauss_newton` takes with the tracker's terms, one after the other from Python;
here nothing is handed back and forth between them. What the terms ask is added up by the same kernels.
"""

from typing import Any

import numpy as np

from ..arrays import Bools, Floats, Ints, Singles
from . import articulated, bone_systems, dense, inside, match, raycast, rendered
from .body import Chain, Posed, Shell
from .compile import compiled

_advance = articulated.advance

WISHES = np.dtype(
    [
        (name, np.int64)
        for name in ("every", "half", "wide", "two_way", "edge_half", "reach", "iterations")
    ]
    + [
        (name, np.float64)
        for name in (
            "gate", "apart", "along", "back", "scale", "surface", "jump", "edge", "free_scale", "free", "limits",
            "solid_scale", "solid", "prior", "damping", "tolerance", "longest", "settled",
        )
    ]
)  # fmt: skip
"""What is asked of a frame: `every` of rows and columns that become samples; `half` of the surface's window, px, and
by how much `wide`r it is at first; whether observed points draw `two_way`; `edge_half` of the edges' window; `reach`
to a pixel that is not free, px, at the depth of the pose begun from, however far it then moves; most `iterations`;
`gate`, `apart`, m, see `match`; shares `along` the normal, forth and `back`; `scale`, m; weights of `surface`, `edge`,
`free` space, `limits` and `solid` trunk, and whether there is a `prior`, 0 = none; `jump` of an edge, `free_scale` and
`solid_scale`, m; `damping` relative to the diagonal; `tolerance` and `longest` of a step's components, m and rad;
`settled`, see `least_squares.gauss_newton`."""

SURFACE, EDGE, FREE, SMOOTH, LIMITS, PRIOR = range(6)


@compiled
def descend(
    chain: Chain,
    pose: Posed,
    shell: Shell,
    moved_first: Ints,
    moved: Ints,
    camera: Floats,
    seen: Singles,
    free: Bools,
    pixels: Ints,
    samples: Singles,
    edge_pixels: Ints,
    edge_samples: Singles,
    expected: Posed,
    smooth: Floats,
    limits: Floats,
    trunk: Ints,
    forearms: Ints,
    clear: Floats,
    mean: Floats,
    form: Floats,
    wishes: Any,
    normal: Floats,
    right: Floats,
    costs: Floats,
    counts: Ints,
) -> tuple[int, bool]:
    """Steps from a pose towards the minimum of the terms; the pose is changed in place.

    Parameters
    ----------
    moved_first, moved : which degrees of freedom move which bone, see `bone_systems.assemble`.
    camera, seen, free : (4,) px, (H, W) m and True where nobody is.
    pixels, samples, edge_pixels, edge_samples : (N, 2), (N, 3) and (E, 2), (E, 3) m, observed.
    expected, smooth : see `bone_systems.drawn_to`. limits : (D, 2). trunk .. clear : see `inside.kept_out`.
    mean, form : of the prior.
    wishes : (1,) of `WISHES`.
    normal, right : (D, D) and (D,), written: the system about the pose before the last step.
    costs, counts : (6,) and (6, 2), written: of each term its cost, inliers and samples there.

    Returns
    -------
    Steps taken, and whether the last one was as short, or promised as little, as asked. No steps, when a system is
    singular.
    """
    wish = wishes[0]
    bones, solids, dofs = len(chain.parents), len(shell.carriers), len(right)
    frames, moving = np.empty((bones, 4, 4)), np.empty((dofs, 6))
    placed, parts = np.empty((solids, 3, 4)), np.empty((solids, raycast.PARTS))
    depth, solid = np.empty(seen.shape, np.float32), np.empty(seen.shape, np.int16)
    edge = np.empty(seen.shape, np.float32)
    most = (seen.shape[0] // wish.every + 1) * (seen.shape[1] // wish.every + 1)
    own_pixels, own_bones = np.empty((most, 2), np.int64), np.empty(most, np.int64)
    own_samples, own_normals = np.empty((most, 3), np.float32), np.empty((most, 3), np.float32)
    hessian, gradient = np.empty((bones, 6, 6)), np.empty((bones, 6))
    lifted, step, away = np.empty((dofs, dofs)), np.empty(dofs), np.empty(dofs)
    known, no_tones = np.empty((0, 0), np.bool_), np.empty(0, np.float32)
    for taken in range(1, wish.iterations + 1):
        hessian[:] = 0.0
        gradient[:] = 0.0
        normal[:] = 0.0
        right[:] = 0.0
        count = rendered.sampled(
            chain, pose, shell, camera, wish.every, frames, moving, placed, parts, depth, solid, own_pixels,
            own_samples, own_normals, own_bones,
        )  # fmt: skip
        half = wish.half + max(0, wish.wide - 2 * (taken - 1))  # wide at first
        costs[SURFACE], counts[SURFACE, 0] = match.draw_to_seen(
            own_pixels[:count], own_samples, own_normals, own_bones, seen, camera, half, wish.gate, wish.apart,
            no_tones, seen, 0.0, wish.along, wish.scale, wish.surface, hessian, gradient,
        )  # fmt: skip
        counts[SURFACE, 1] = count
        if wish.two_way:
            cost, inliers = match.draw_from_seen(
                pixels, samples, depth, solid, camera, placed, shell, half, wish.gate, wish.apart, wish.back,
                wish.scale, wish.surface, hessian, gradient,
            )  # fmt: skip
            costs[SURFACE] += cost
            counts[SURFACE, 0] += inliers
            counts[SURFACE, 1] += len(pixels)
        costs[SMOOTH] = bone_systems.drawn_to(pose, expected, smooth, away, normal, right)
        if wish.edge > 0.0 and len(edge_pixels) > 0:
            rendered.steps(depth, known, wish.jump, edge)
            costs[EDGE], counts[EDGE, 0] = match.draw_from_seen(
                edge_pixels, edge_samples, edge, solid, camera, placed, shell, wish.edge_half, wish.gate, wish.apart,
                0.0, wish.scale, wish.edge, hessian, gradient,
            )  # fmt: skip
            counts[EDGE, 1] = len(edge_pixels)
        if wish.free > 0.0:
            costs[FREE], counts[FREE, 1] = match.push_out(
                own_pixels[:count], own_bones, own_samples, free, wish.reach, camera[0], camera[1], wish.free_scale,
                wish.free, hessian, gradient,
            )  # fmt: skip
        if wish.limits > 0.0:
            costs[LIMITS] = bone_systems.within(pose.joints, limits, wish.limits, normal, right)
            costs[LIMITS] += inside.kept_out(
                placed, moving, moved_first, moved, shell, trunk, forearms, clear,
                wish.solid_scale * wish.solid_scale, wish.solid, normal, right,
            )  # fmt: skip
        if wish.prior > 0.0:
            costs[PRIOR] = bone_systems.about_mean(pose.joints, mean, form, normal, right)
        bone_systems.assemble(hessian, gradient, moving, moved_first, moved, normal, right)
        largest = 1e-300
        for d in range(dofs):
            largest = max(largest, normal[d, d])
        for d in range(dofs):
            step[d] = right[d]
            for e in range(dofs):
                lifted[d, e] = normal[d, e]
            lifted[d, d] += wish.damping * normal[d, d] + 1e-12 * largest
        if not dense.factor_and_solve(lifted, step):
            return 0, False
        size, promised, total = 0.0, 0.0, 0.0
        for d in range(dofs):
            size = max(size, abs(step[d]))
            promised += step[d] * right[d]
        for k in range(len(costs)):
            total += costs[k]
        if size > wish.longest:
            for d in range(dofs):
                step[d] *= wish.longest / size
        _advance(pose, step)
        if size < wish.tolerance or promised < wish.settled * total:
            return taken, True
    return wish.iterations, False
