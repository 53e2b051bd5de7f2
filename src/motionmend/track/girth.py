"""How wide this person is, learned while following: what stays between model and observation, whatever the pose.

Each followed frame gives the normal equations of its pose and of a few widths together; the pose is eliminated
(Schur complement) and what is left tells of the widths alone. Lengths stay as they are: they are known, or were
measured by `calibrate`.
"""

from dataclasses import dataclass, field, replace
from typing import Any, final

import numpy as np

from ..arrays import Floats, frozen
from ..bodies.performer import BONES, DOFS, MOVES, Performer, Pose
from .evidence import Evidence
from .settings import TrackSettings
from .view import View, view_of

# Bones and axes (x breadth, y length, z depth) that a width stretches, and its spread among people.
_WIDTHS: tuple[tuple[tuple[str, ...], tuple[int, ...], float], ...] = (
    (("pelvis", "chest"), (0,), 0.10),
    (("pelvis", "chest"), (2,), 0.14),
    (("head",), (0, 2), 0.08),
    (("upperarm", "forearm", "clavicle"), (0, 2), 0.14),
    (("thigh",), (0, 2), 0.12),
    (("shank",), (0, 2), 0.12),
    (("foot",), (0, 1), 0.12),
)
SPREAD = np.array([spread for *_, spread in _WIDTHS])
FRAMES = 60  # after which the person is known and stays as they are
FIRST_FRAMES = 4  # before which nothing is changed
NOISE = 0.02  # m, of one sample: clothes, and a pose not settled
CLUMP = 8.0  # samples err together: so many tell as much as one
LONGEST = 0.02  # change of a width's logarithm in one frame, so that the pose can follow


def _axes() -> Floats:
    """(G, B, 3) 1 where a width stretches a bone's axis."""
    axes = np.zeros((len(_WIDTHS), len(BONES), 3))
    for g, (names, along, _) in enumerate(_WIDTHS):
        for b, bone in enumerate(BONES):
            if bone.split("_")[-1] in names:
                axes[g, b, list(along)] = 1.0
    return axes


AXES_OF = _axes()


@final
@dataclass(frozen=True, eq=False)
class Girth:
    """What is known of the widths.

    Attributes
    ----------
    base : the performer before anything was learned.
    information, right : (G, G) and (G,) of the logarithms of the widths, summed over frames.
    scale : (G,) the logarithms in use.
    frames : that were learned from.
    """

    base: Performer
    information: Floats = field(default_factory=lambda: frozen(np.zeros((len(_WIDTHS), len(_WIDTHS)))))
    right: Floats = field(default_factory=lambda: frozen(np.zeros(len(_WIDTHS))))
    scale: Floats = field(default_factory=lambda: frozen(np.zeros(len(_WIDTHS))))
    frames: int = 0

    @property
    def performer(self) -> Performer:
        """The base with its surface, not its joints, stretched."""
        factors = np.exp(np.einsum("g,gba->ba", self.scale, AXES_OF))
        return replace(self.base, solids=self.base.solids.stretched(factors))


def learned(girth: Girth, performer: Performer, pose: Pose, evidence: Evidence, settings: TrackSettings) -> Girth:
    """The girth with one followed frame learned.

    Parameters
    ----------
    performer : in use, `girth.performer`. pose : as solved for the frame. evidence, settings : of the frame.
    """
    view = view_of(performer, pose, evidence, settings.every)
    points, normals, bones, residual = _matches(view, evidence, settings)
    weight = 1.0 / (1.0 + (residual / settings.scale) ** 2) ** 2
    # Of every sample: how far a width moves it along its normal, and how a degree of freedom does.
    turn, origin = view.placed[bones, :3, :3], view.placed[bones, :3, 3]
    local = np.einsum("nji,nj->ni", turn, points - origin)
    normal = np.einsum("nji,nj->ni", turn, normals)
    by_width = np.einsum("gna,na->ng", AXES_OF[:, bones], local * normal)
    rows = np.concatenate((np.cross(points, normals), normals), axis=1)
    by_pose = (rows @ view.twists.T) * MOVES[bones]
    trust = weight / (NOISE**2 * CLUMP)
    form = (by_pose * trust[:, None]).T @ by_pose
    form[np.diag_indices(DOFS)] += 1.0  # joints that no pixel tells of stay
    couple = (by_pose * trust[:, None]).T @ by_width
    solved = np.linalg.solve(form, np.column_stack((couple, by_pose.T @ (trust * residual))))
    information = (by_width * trust[:, None]).T @ by_width - couple.T @ solved[:, :-1]
    right = by_width.T @ (trust * residual) - couple.T @ solved[:, -1] + information @ girth.scale
    information, right = girth.information + information, girth.right + right
    frames = girth.frames + 1
    scale = girth.scale
    if frames >= FIRST_FRAMES:
        wanted = np.linalg.solve(information + np.diag(SPREAD**-2.0), right)
        scale = scale + np.clip(wanted - scale, -LONGEST, LONGEST)
    return Girth(girth.base, frozen(information), frozen(right), frozen(scale), frames)


def _matches(view: View, evidence: Evidence, settings: TrackSettings) -> tuple[Floats, Floats, np.ndarray, Floats]:
    """Points (N, 3), directions (N, 3), bones (N,) and how far (N,) m each should move, of all that match both ways.

    A rendered point should move along its normal to the observed one; to an observed point beside the model the
    nearest rendered one should move straight; one where nobody is, sideways to the outline.
    """
    from ..kernels import match

    half, none = settings.window // 2 + 2, np.empty(0, np.float32)
    near = half, settings.gate, evidence.apart, none, none[None], 0.0
    found = np.empty(len(view.pixels), np.int64)
    match.nearest_in_window(view.pixels, view.samples, evidence.points, *near, found)
    hit = found >= 0
    hit &= ~evidence.free[view.pixels[:, 0], view.pixels[:, 1]]
    to = evidence.points.reshape(-1, 3)[found[hit]] - view.samples[hit]
    parts: list[tuple[Any, Any, Any, Any]] = [
        (view.samples[hit], view.normals[hit], view.bones[hit], np.einsum("ni,ni->n", to, view.normals[hit]))
    ]
    found = np.empty(len(evidence.pixels), np.int64)
    match.nearest_in_window(
        evidence.pixels,
        evidence.samples,
        view.points,
        half,
        settings.gate,
        evidence.apart,
        none,
        none[None],
        0.0,
        found,
    )
    beside = (found >= 0) & np.isnan(view.depth[evidence.pixels[:, 0], evidence.pixels[:, 1]])
    points, _, bones = view.found(found[beside])
    away = evidence.samples[beside] - points
    size = np.linalg.norm(away, axis=1)
    parts.append((points, away / np.maximum(size, 1e-6)[:, None], bones, size))
    parts += _outside(view, evidence)
    joined = [np.concatenate([part[i] for part in parts]) for i in range(4)]
    return joined[0].astype(np.float64), joined[1].astype(np.float64), joined[2], joined[3].astype(np.float64)


def _outside(view: View, evidence: Evidence) -> list[tuple[Any, Any, Any, Any]]:
    """Rendered samples where nobody is: they should move in the image's plane to the nearest person's pixel."""
    import cv2

    out = evidence.free[view.pixels[:, 0], view.pixels[:, 1]]
    if not out.any():
        return []
    _, label = cv2.distanceTransformWithLabels(
        evidence.free.astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    rows, columns = view.pixels[out].T
    here = np.flatnonzero(~evidence.free.ravel())
    place = np.empty(int(label.max()) + 1, np.int64)
    place[label.ravel()[here]] = here
    nearest = place[label[rows, columns]]
    z = view.samples[out, 2].astype(np.float64)
    fx, fy, _, _ = evidence.intrinsics
    width = evidence.depth.shape[1]
    shift = np.stack(
        ((nearest % width - columns) * z / fx, (nearest // width - rows) * z / fy, np.zeros(len(z))), axis=1
    )
    size = np.linalg.norm(shift, axis=1)
    return [(view.samples[out], shift / np.maximum(size, 1e-6)[:, None], view.bones[out], size)]
