"""The corrector: settings, learning, and the fitted model that corrects live frames and recordings."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..arrays import Bools, Bytes, Floats, Ints
from ..bodies.postures import Postures
from ..errors import MismatchError, UsageError
from ..numerics.factors import Factors
from .anatomy import anatomy, following, matched
from .follow import Followed
from .hindsight import judged_again, placed_again
from .learning import going_well, learned_factors, lessons, model_anatomy, offset_samples, usual_unsteadiness
from .normalise import Standard, bone_lengths
from .pairing import Pair
from .reliability import Detector
from .settling import Body, bones_outward, settled_frame, settled_recording, unborn
from .spatial import Committee, fit_committee, shape_features
from .watching import Sight, Watcher, acquainted, fresh, look, rows_of

METHODS = ("default",)
GLIMPSE = 300  # frames of a recording that are looked at twice


@dataclass(frozen=True)
class Corrector:
    """How to learn a corrector.

    Attributes
    ----------
    members : Gaussian processes of the committee.
    size : samples of each.
    seed : of the choice of samples.
    """

    members: int = 1
    size: int = 1000
    seed: int = 0

    def __post_init__(self) -> None:
        if self.members < 1 or self.size < 2:
            raise UsageError(f"a committee needs members with samples, came {self.members} with {self.size}")

    def fit(self, pairs: Sequence[Pair]) -> "CorrectorModel":
        """Learn from pairs of a sensor's recordings and the truth.

        Raises
        ------
        MismatchError : no pairs, or none in which the sensor shows a person.
        """
        body = model_anatomy(pairs)
        taught, standard = lessons(pairs, body)
        good = going_well(taught)
        samples, offsets = offset_samples(taught)
        if not len(samples):
            raise MismatchError("wanted frames with all of the sensor's joints and some truth, came none")
        committee = fit_committee(samples, offsets, body, self.members, self.size, self.seed)
        paired = np.isfinite(offsets).all(axis=2).mean(axis=0) > 0.05
        some = samples[:: max(len(samples) // 500, 1)]
        moved = some + following(body.names, paired) @ committee.predict(shape_features(some, body))[0]
        return CorrectorModel(
            self,
            body.names,
            standard,
            learned_factors(taught, good, body),
            usual_unsteadiness(taught, good, body),
            committee,
            np.append(bone_lengths(moved, body).mean(axis=0), np.nan),
            paired,
            len(pairs),
            len(samples),
        )


@dataclass(frozen=True, eq=False)
class Joining:
    """How a recording's joints go with the model's: by meaning, and what has no partner follows its neighbours.

    Attributes
    ----------
    to_model : (J of model,) the recording's joint of each of the model's, -1 = none.
    spread : (J, J of model) how the model's shifts move the recording's joints.
    bones : (B, 2) of the recording's joints, from the root outward.
    model_bones : (B,) the model's bone between the same joints, -1 = none.
    """

    names: tuple[str, ...]
    to_model: Ints
    spread: Floats
    bones: Ints
    model_bones: Ints


@dataclass(frozen=True, eq=False)
class CorrectorState:
    """One client's correction between two frames."""

    joining: Joining
    fps: float
    sight: Sight
    body: Body


@dataclass(frozen=True, eq=False)
class Corrected:
    """One corrected frame of J joints.

    Attributes
    ----------
    positions : (J, 3) m, finite where anything is known.
    std : (J,) m, of a coordinate.
    reliability : (J,) in [0, 1], of what the sensor said.
    flags : words about the frame: "swapped", "refused", "held".
    """

    positions: Floats
    std: Floats
    reliability: Floats
    flags: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class CorrectorModel:
    """A fitted corrector.

    Attributes
    ----------
    settings : it was learned with.
    names : (J,) joints of the sensor it was learned on.
    standard : the body that others are brought to.
    factors : how the sensor sees people stand and move.
    detector : how its failures look.
    committee : the offsets.
    bones : (B + 1,) mean lengths of corrected bones in standard metres, the last NaN.
    paired : (J,) joints of which some truth was known.
    pairs, frames : how many it was learned from.
    """

    settings: Corrector
    names: tuple[str, ...]
    standard: Standard
    factors: Factors
    detector: Detector
    committee: Committee
    bones: Floats
    paired: Bools
    pairs: int
    frames: int

    def __post_init__(self) -> None:
        body = anatomy(self.names)
        object.__setattr__(self, "_watcher", Watcher(body, self.standard, self.factors, self.detector))
        object.__setattr__(self, "_following", following(self.names, self.paired))

    @property
    def watcher(self) -> Watcher:
        """What looks at frames."""
        found: Watcher = self.__dict__["_watcher"]
        return found

    def start(self, names: Sequence[str], fps: float = 30.0) -> CorrectorState:
        """The state before a client's first frame.

        Parameters
        ----------
        names : of the client's joints.
        fps : Hz, nominal.

        Raises
        ------
        MismatchError : the joints have too little in common with the model's.
        UsageError : fps is not above 0.
        """
        if not fps > 0:
            raise UsageError(f"a rate above 0 Hz was wanted, came {fps}")
        joining = self._joining(tuple(names))
        return CorrectorState(joining, float(fps), fresh(self.watcher), unborn(len(names), len(joining.bones)))

    def _joining(self, names: tuple[str, ...]) -> Joining:
        to_model = matched(names, self.names)
        if (to_model >= 0).sum() < 4:
            raise MismatchError(
                f"wanted at least 4 joints that the model knows ({', '.join(self.names[:6])}, ...), came "
                f"{int((to_model >= 0).sum())} among {', '.join(names[:6])}, ..."
            )
        back = np.full(len(names), -1, dtype=np.int64)
        for k, joint in enumerate(to_model):
            if joint >= 0:
                back[joint] = k
        own = np.zeros((len(names), len(self.names)))
        have = np.flatnonzero(back >= 0)
        own[have, back[have]] = 1.0
        bones = bones_outward(names)
        known = {(int(p), int(c)): b for b, (p, c) in enumerate(self.watcher.body.bones)}
        model_bones = np.array([known.get((int(back[p]), int(back[c])), -1) for p, c in bones], dtype=np.int64)
        return Joining(names, to_model, following(names, back >= 0) @ own, bones, model_bones)

    def step(
        self, state: CorrectorState, positions: Floats, states: Bytes | None, time: float
    ) -> tuple[CorrectorState, Corrected]:
        """Correct one frame.

        Parameters
        ----------
        state : after the frame before.
        positions : (J, 3) m; what is not finite is missing.
        states : (J,) 2 tracked, 1 inferred, 0 not tracked; None where the sensor does not say.
        time : s.

        Returns
        -------
        The state after this frame, and the corrected frame.
        """
        joining = state.joining
        given = np.asarray(positions, dtype=np.float64)
        rows = rows_of(joining.to_model, given)
        told = None if states is None else _states_of(joining, np.asarray(states))
        sight = look(self.watcher, state.sight, rows, told, float(time))
        followed = sight.followed
        moved, std = self._moved(followed.posture[None], followed.std[None])
        placed, deviation, trust = self._outward(joining, given[None], [sight], moved, std, followed.failing[None])
        body, settled = settled_frame(
            state.body, placed[0], float(time), trust[0], joining.bones, self.bones[joining.model_bones] * sight.scale
        )
        flags = _words(sight, joining.to_model >= 0)
        return replace(state, sight=sight, body=body), Corrected(settled, deviation[0], trust[0], flags)

    def correct(self, postures: Postures, online: bool = False, method: str = "default") -> Postures:
        """Correct a recording.

        Parameters
        ----------
        postures : any joint set that has joints in common with the model's.
        online : learn from the recording while correcting it.
        method : one of `METHODS`.

        Returns
        -------
        The same joints, frames and times, with `std` and `reliability`.

        Raises
        ------
        UsageError : unknown method.
        """
        if method not in METHODS:
            raise UsageError(f"unknown method {method!r}: choose one of {', '.join(METHODS)}")
        fps = postures.fps if np.isfinite(postures.fps) and postures.fps > 0 else 30.0
        state = self.start(postures.names, fps)
        rows = rows_of(state.joining.to_model, postures.positions)
        state = replace(state, sight=acquainted(self.watcher, rows, state.sight))
        known = self._watched(state, rows[:GLIMPSE], postures)
        if known:  # a first look tells what is this person's and this sensor's own
            met = known[-1].followed
            state = replace(
                state, sight=replace(state.sight, followed=replace(state.sight.followed, own=met.own, met=met.met))
            )
        sights = self._watched(state, rows, postures)
        if not sights:
            return replace(postures, std=np.zeros(rows.shape[:2]), reliability=np.zeros(rows.shape[:2]))
        failing = judged_again(sights)
        posture, unsure = placed_again(self.factors, sights, failing)
        moved, std = self._moved(posture, unsure)
        positions, std, reliability = self._outward(state.joining, postures.positions, sights, moved, std, failing)
        positions = settled_recording(positions, postures.times, reliability, state.joining.bones)
        return replace(postures, positions=positions, std=std, reliability=reliability)

    def _watched(self, state: CorrectorState, rows: Floats, postures: Postures) -> list[Sight]:
        sights: list[Sight] = []
        for t, row in enumerate(rows):
            told = None if postures.state is None else _states_of(state.joining, postures.state[t])
            sights.append(
                look(self.watcher, sights[-1] if sights else state.sight, row, told, float(postures.times[t]))
            )
        return sights

    def _moved(self, posture: Floats, unsure: Floats) -> tuple[Floats, Floats]:
        """(T, J, 3) the corrected postures in standard form and (T, J) their standard deviation."""
        offsets, variance = self.committee.predict(shape_features(posture, self.watcher.body))
        return posture + self.__dict__["_following"] @ offsets, np.sqrt(variance + unsure**2)

    def _outward(
        self, joining: Joining, given: Floats, sights: Sequence[Sight], moved: Floats, std: Floats, failing: Floats
    ) -> tuple[Floats, Floats, Floats]:
        here = np.concatenate(
            [one.placement.outward(posture[None]) for one, posture in zip(sights, moved, strict=True)]
        )
        if sights[-1].upright is not None:
            here = here @ sights[-1].upright
        old = rows_of(joining.to_model, given)
        seen = np.isfinite(old).all(axis=2)
        placed = np.where(
            np.isfinite(given), given + joining.spread @ np.where(seen[..., None], here - old, 0.0), np.nan
        )
        have = joining.to_model >= 0
        anyone = seen.any(axis=1)
        placed[:, joining.to_model[have]] = np.where(anyone[:, None, None], here[:, have], np.nan)
        trust = np.where(seen & ~np.stack([one.swapped for one in sights]), 1.0 - failing, 0.0)
        share = np.abs(joining.spread).T
        scale = np.array([one.scale for one in sights])[:, None]
        reliable = np.where(np.isfinite(given).all(axis=2), np.clip(trust @ share, 0.0, 1.0), 0.0)
        return placed, (std * scale) @ share, reliable

    def to_arrays(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """Arrays and a JSON-able header from which `from_arrays` makes the model again."""
        arrays: dict[str, Any] = {
            "standard.lengths": self.standard.lengths,
            "standard.trunk": self.standard.trunk,
            "paired": self.paired,
        }
        arrays["bones"] = self.bones
        arrays |= {f"factors.{name}": getattr(self.factors, name) for name in ("mean", "loadings", "rates", "noise")}
        arrays |= {f"detector.{name}": value for name, value in self.detector.to_arrays().items()}
        arrays |= {f"committee.{name}": value for name, value in self.committee.to_arrays().items()}
        header = {
            "names": list(self.names),
            "pairs": self.pairs,
            "frames": self.frames,
            "members": self.settings.members,
            "size": self.settings.size,
            "seed": self.settings.seed,
        }
        return arrays, header

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, Any], header: Mapping[str, Any]) -> "CorrectorModel":
        """The model that `to_arrays` took apart."""

        def below(prefix: str) -> dict[str, Any]:
            return {name[len(prefix) :]: value for name, value in arrays.items() if name.startswith(prefix)}

        return cls(
            Corrector(header["members"], header["size"], header["seed"]),
            tuple(header["names"]),
            Standard(arrays["standard.lengths"], arrays["standard.trunk"]),
            Factors(**below("factors.")),
            Detector.from_arrays(below("detector.")),
            Committee.from_arrays(below("committee.")),
            arrays["bones"],
            arrays["paired"],
            header["pairs"],
            header["frames"],
        )


def _states_of(joining: Joining, states: Bytes) -> Bytes:
    return np.where(joining.to_model >= 0, states[joining.to_model], 0).astype(np.uint8)


def _words(sight: Sight, given: Bools) -> tuple[str, ...]:
    held = bool((sight.followed.failing[given] > 0.5).any())
    said = {"swapped": bool(sight.swapped.any()), "refused": sight.refused, "held": held}
    return tuple(word for word, true in said.items() if true)


__all__ = ["METHODS", "Corrected", "Corrector", "CorrectorModel", "CorrectorState", "Followed", "Pair"]
