"""How wide this person is and how far the hands reach, learned while following: what stays between model and
observation, whatever the pose.

Each followed frame gives the normal equations of its pose and of a few widths together; the pose is eliminated
(Schur complement) and what is left tells of the widths alone. Lengths stay as they are: they are known, or were
measured by `calibrate`. Fists and flat hands are 9 cm apart, which counts where an arm is thrust at the camera: of a
few reaches that one is used with which the poses so far explain the frames best.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import final

import numpy as np

from ...arrays import Floats, frozen
from ...bodies.anatomy import handed
from ...bodies.performer import BONES, DOFS, MOVES, Performer, Pose
from ...kernels import widths
from ..frame.evidence import Evidence
from ..limbs.other_poses import Coarse, disagreement
from ..settings import TrackSettings
from ..terms.freespace import far_at
from ..terms.view import view_of

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
HANDS = (None, 0.5, 0.65, 0.8, 1.0)  # of flat ones: as the person's are, fists, relaxed ones, bent ones, flat ones
EVIDENT = 0.02  # share of the pixels, summed over frames, that other hands must explain better: out of sight none do
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
    hand : how far the hands reach, of `HANDS`; None = as the base's.
    wrong : (H,) by what share of the person's pixels more each of `HANDS` explains wrongly than the first, summed over
        frames.
    """

    base: Performer
    information: Floats = field(default_factory=lambda: frozen(np.zeros((len(_WIDTHS), len(_WIDTHS)))))
    right: Floats = field(default_factory=lambda: frozen(np.zeros(len(_WIDTHS))))
    scale: Floats = field(default_factory=lambda: frozen(np.zeros(len(_WIDTHS))))
    frames: int = 0
    hand: float | None = None
    wrong: Floats = field(default_factory=lambda: frozen(np.zeros(len(HANDS))))

    @cached_property
    def performer(self) -> Performer:
        """The base with its surface, not its joints, stretched, and its hands."""
        return _with_hands(self.stretched, self.hand)

    @cached_property
    def stretched(self) -> Performer:
        """The same with the base's hands."""
        factors = np.exp(np.einsum("g,gba->ba", self.scale, AXES_OF))
        return replace(self.base, solids=self.base.solids.stretched(factors))


def _with_hands(body: Performer, hand: float | None) -> Performer:
    """A body whose hands reach as far as one of `HANDS` says."""
    return body if hand is None else handed(body, hand)


def learned(
    girth: Girth, performer: Performer, pose: Pose, evidence: Evidence, coarse: Coarse, settings: TrackSettings
) -> Girth:
    """The girth with one followed frame learned.

    Parameters
    ----------
    performer : in use, `girth.performer`. pose : as solved for the frame. evidence, coarse, settings : of the frame.
    """
    view = view_of(performer, pose, evidence, settings.every)
    half, systems = settings.window // 2 + 2, np.zeros((len(BONES), widths.ROW, widths.ROW))
    near = half, settings.gate, evidence.apart, settings.scale, NOISE**-2.0 / CLUMP
    # Points of the model should move along their normals to the observed ones; to an observed point beside the model
    # the nearest one of the model should move straight; one where nobody is, sideways to the outline.
    widths.from_model(
        view.pixels,
        view.samples,
        view.normals,
        view.bones,
        view.placed,
        evidence.depth,
        evidence.free,
        evidence.intrinsics,
        far_at(pose, evidence),
        *near,
        systems,
    )
    widths.from_seen(
        evidence.pixels,
        evidence.samples,
        view.depth,
        view.solid,
        evidence.intrinsics,
        performer.solids.arrays.carriers,
        view.placed,
        *near,
        systems,
    )
    # Rows of a bone's system, [twist, stretch along each axis, residual], to degrees of freedom, widths, residual.
    link = np.zeros((len(BONES), widths.ROW, DOFS + len(_WIDTHS) + 1))
    link[:, :6, :DOFS] = view.twists.T * MOVES[:, None]
    link[:, 6:9, DOFS:-1] = AXES_OF.transpose(1, 2, 0)
    link[:, 9, -1] = 1.0
    whole = (link.transpose(0, 2, 1) @ systems @ link).sum(axis=0)
    form, couple, by_width = whole[:DOFS, :DOFS], whole[:DOFS, DOFS:-1], whole[DOFS:-1, DOFS:-1]
    form[np.diag_indices(DOFS)] += 1.0  # joints that no pixel tells of stay
    solved = np.linalg.solve(form, whole[:DOFS, DOFS:])
    information = by_width - couple.T @ solved[:, :-1]
    right = whole[DOFS:-1, -1] - couple.T @ solved[:, -1] + information @ girth.scale
    information, right = girth.information + information, girth.right + right
    frames = girth.frames + 1
    scale = girth.scale
    if frames >= FIRST_FRAMES:
        wanted = np.linalg.solve(information + np.diag(SPREAD**-2.0), right)
        scale = scale + np.clip(wanted - scale, -LONGEST, LONGEST)
    # One of the other reaches has its turn in each frame, and speaks for as many frames as there are others.
    body, asked, wrong = girth.stretched, 1 + girth.frames % (len(HANDS) - 1), girth.wrong.copy()
    without = disagreement(body, pose, coarse)
    wrong[asked] += (len(HANDS) - 1) * (disagreement(_with_hands(body, HANDS[asked]), pose, coarse) - without)
    evident = wrong[HANDS.index(girth.hand)] - wrong.min() > EVIDENT
    hand = HANDS[int(np.argmin(wrong))] if evident else girth.hand
    return Girth(girth.base, frozen(information), frozen(right), frozen(scale), frames, hand, frozen(wrong))
