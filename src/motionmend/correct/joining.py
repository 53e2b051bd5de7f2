"""How a recording's joints go with a model's, and how what the model says comes back to the recording's axes."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..arrays import Bools, Bytes, Floats, Ints, frozen
from ..bodies.joint_sets import meanings
from ..errors import MismatchError
from ..kernels import sighting as kernel
from ..kernels.proportions import TRUSTED
from .anatomy import Anatomy, following, matched
from .settling import bones_outward
from .sight import Sight, rows_of

FEWEST = 4  # joints in common
FARTHER, SLACK = 2.5, 0.05  # times as far from its neighbours as usual, and m, that a joint the model lacks may be
_SPINE = {"spine", "chest"}
_PICTURED = {"nose", "l_eye", "r_eye", "l_ear", "r_ear", "l_heel", "r_heel"}
OTHER = 6.0 * TRUSTED  # log-odds, more than all bones together say: no posture moves a sensor's joint along the spine
ANYBODY = 0.5  # m, the same of a person of whom nothing is known yet


@dataclass(frozen=True, eq=False)
class Joining:
    """Joints go together by meaning; what has no partner follows its neighbours.

    Attributes
    ----------
    names : (J,) of the recording.
    to_model : (J of model,) the recording's joint of each of the model's, -1 = none.
    spread : (J, J of model) how the model's shifts move the recording's joints.
    bones : (B, 2) of the recording's joints, from the root outward.
    model_bones : (B,) the model's bone between the same joints, -1 = none.
    doubt : log-odds by which the joints themselves speak against the sensor that was learned from: `TRUSTED`, so that
        nothing speaks for it before bones do, where nothing lies between pelvis and neck and the model has a spine, as
        no depth sensor has it but all that estimates poses in pictures; twice that where there also are joints (nose,
        ears, heels) that the model lacks. And `OTHER` where joints of the spine lie elsewhere.
    meant : (J of model,) the recording's joint that means the same as each of the model's, -1 = none.
    elsewhere : (J of model,) those of the spine that lie elsewhere in the recording, and go with none.
    """

    names: tuple[str, ...]
    to_model: Ints
    spread: Floats
    bones: Ints
    model_bones: Ints
    doubt: float
    meant: Ints
    elsewhere: Bools

    @property
    def other_kind(self) -> bool:
        """Whether the joints are those of another kind of sensor."""
        return self.doubt > TRUSTED

    @property
    def displaced(self) -> tuple[str, ...]:
        """The recording's joints of the spine that lie elsewhere than those of the model that mean the same."""
        return tuple(self.names[k] for k in self.meant[self.elsewhere])

    @cached_property
    def common(self) -> Ints:
        """The model's joints that the recording has."""
        return np.flatnonzero(self.to_model >= 0)

    @cached_property
    def loose(self) -> Ints:
        """The recording's joints that the model lacks."""
        return np.setdiff1d(np.arange(len(self.names)), self.to_model)

    @cached_property
    def beside(self) -> Floats:
        """(L, J) of which of the recording's joints each loose one is the neighbour: rows that average over them."""
        shares = np.zeros((len(self.names), len(self.names)))
        shares[:, self.to_model[self.common]] = self.spread[:, self.common]
        return shares[self.loose]

    def states(self, states: Bytes) -> Bytes:
        """(J of model,) tracking states by the model's joints; not tracked where the recording has no such joint."""
        return np.where(self.to_model >= 0, states[self.to_model], 0).astype(np.uint8)


def joined(names: Sequence[str], body: Anatomy, other: Bools | None = None) -> Joining:
    """How joints of these names go with a model's.

    Parameters
    ----------
    names : (J,) of the recording.
    body : the model's.
    other : (J of model,) joints that the recording has elsewhere (spine.py), which go with none; None = none.

    Raises
    ------
    MismatchError : fewer than four in common.
    """
    names = tuple(names)
    meant_by = matched(names, body.names)
    elsewhere = np.zeros(len(meant_by), dtype=np.bool_) if other is None else other & (meant_by >= 0)
    to_model = np.where(elsewhere, -1, meant_by)
    common = int((to_model >= 0).sum())
    if common < FEWEST:
        came = f"came {common} among {', '.join(names[:6])}, ..." if names else "came no joints at all"
        raise MismatchError(
            f"wanted at least {FEWEST} joints that the model knows ({', '.join(body.names[:6])}, ...), {came}"
        )
    back = np.full(len(names), -1, dtype=np.int64)
    have = np.flatnonzero(to_model >= 0)
    back[to_model[have]] = have
    own = np.zeros((len(names), len(body.names)))
    own[back >= 0, back[back >= 0]] = 1.0
    bones = bones_outward(names)
    known = {(int(p), int(c)): b for b, (p, c) in enumerate(body.bones)}
    model_bones = np.array([known.get((int(back[p]), int(back[c])), -1) for p, c in bones], dtype=np.int64)
    meant, known_ones = set(meanings(names)), set(meanings(body.names))
    spineless = bool(_SPINE & known_ones) and not _SPINE & meant
    doubt = TRUSTED * (1 + bool(_PICTURED & meant - known_ones)) if spineless else 0.0
    doubt += OTHER * bool(elsewhere.any())
    spread = following(names, back >= 0) @ own
    return Joining(names, to_model, spread, bones, model_bones, doubt, meant_by, elsewhere)


def outward(
    joining: Joining,
    given: Floats,
    sights: Sequence[Sight],
    moved: Floats,
    std: Floats,
    failing: Floats,
    last: Floats | None = None,
) -> tuple[Floats, Floats, Floats]:
    """Corrected postures in the recording's joints and axes.

    Parameters
    ----------
    given : (T, J, 3) m, as the sensor gave them.
    sights : of the T frames.
    moved : (T, J of model, 3) corrected, in standard form.
    std : (T, J of model) of a coordinate, standard metres.
    failing : (T, J of model) probability that the sensor's joint fails.
    last : (J, 3) m, what was put out before the first of them, NaN = nothing; None where all are there at once.

    Returns
    -------
    positions (T, J, 3) m, standard deviations (T, J) m, reliability (T, J) of what the sensor gave. A frame without any
    joint stays empty. Joints that the model lacks are not judged by it: where one is missing, or farther from its
    neighbours than it can be, it stays beside them as before, or as before and after.
    """
    given, moved = frozen(given), np.ascontiguousarray(moved)
    placed = np.empty(given.shape)
    deviation, reliable = np.empty(given.shape[:2]), np.empty(given.shape[:2])
    turn = sights[-1].upright
    turn = np.eye(3) if turn is None else turn
    for t, one in enumerate(sights):
        kernel.given_back(
            given[t],
            one.rows,
            one.swapped,
            one.placement.turn[0],
            one.placement.origin[0],
            one.scale,
            turn,
            moved[t],
            std[t],
            failing[t],
            joining.to_model,
            joining.spread,
            placed[t],
            deviation[t],
            reliable[t],
        )
    if len(joining.loose):
        _kept_beside(joining, placed, deviation, reliable, last)
    return placed, deviation, reliable


def _kept_beside(joining: Joining, placed: Floats, deviation: Floats, reliable: Floats, last: Floats | None) -> None:
    """Loose joints that are missing, or cannot be where they are, put beside their neighbours; in place."""
    loose = joining.loose
    near = _neighbours(joining, placed)
    apart = placed[:, loose] - near
    far = np.sqrt(np.square(apart).sum(axis=2))
    if last is None:
        seen = (column[np.isfinite(column)] for column in far.T)
        usual = np.array([np.median(some) if len(some) else np.nan for some in seen])
    else:
        before = last[loose] - _neighbours(joining, last)
        usual = np.sqrt(np.square(before).sum(axis=1))
    limit = np.where(np.isfinite(usual), FARTHER * usual + SLACK, ANYBODY)
    wrong = ~(far <= limit) & np.isfinite(near).all(axis=2)
    for k, joint in enumerate(loose):
        there, gone = np.flatnonzero(np.isfinite(far[:, k]) & ~wrong[:, k]), np.flatnonzero(wrong[:, k])
        if not len(gone):
            continue
        if last is not None:
            beside = np.broadcast_to(before[k], (len(gone), 3))
        elif len(there):
            beside = np.stack([np.interp(gone, there, apart[there, k, d]) for d in range(3)], axis=1)
        else:
            continue
        some = np.isfinite(beside).all(axis=1)
        placed[gone, joint] = np.where(some[:, None], near[gone, k] + beside, np.nan)
        deviation[gone, joint] = np.hypot(deviation[gone, joint], np.where(some, usual[k], np.nan))
        reliable[gone, joint] = 0.0


def _neighbours(joining: Joining, places: Floats) -> Floats:
    """(..., L, 3) where the neighbours of the loose joints are, of places (..., J, 3); NaN where nobody is."""
    others = places.copy()
    others[..., joining.loose, :] = 0.0
    return np.asarray(joining.beside @ others)


def inward(joining: Joining, sights: Sequence[Sight], placed: Floats) -> Floats:
    """(T, J of model, 3) postures of the recording (T, J, 3), upright and in standard form; NaN without a partner."""
    rows = rows_of(joining.to_model, placed)
    turn = sights[-1].upright
    if turn is not None:
        rows = rows @ turn.T
    return np.concatenate([one.placement.inward(row[None]) for one, row in zip(sights, rows, strict=True)])
