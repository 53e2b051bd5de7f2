"""The corrector: settings, learning, and the fitted model that corrects live frames and recordings."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from ..arrays import Bools, Bytes, Floats
from ..bodies.postures import Postures
from ..errors import MismatchError, UsageError
from ..kernels import bones
from ..numerics.factors import Factors
from ..numerics.local_gp import Mixture
from .alarm import alarmed
from .anatomy import anatomy, following
from .classic import FILTERS, Samples
from .joining import Joining, inward, joined, outward
from .learning import going_well, learned_factors, lessons, model_anatomy, offset_samples, usual_unsteadiness
from .limits import Hinges, learned_limits
from .look_ahead import Waiting, first_of, going_on
from .normalise import Standard, bone_lengths
from .noted import FOREIGN, noted
from .online import blank, remembered, taken_in
from .pairing import Pair
from .paper import learned_mixture, neighbour_inputs
from .recordings import METHODS, PAPER, Knowledge, by_default, by_filter, by_learner, by_paper
from .reliability import Detector
from .settling import OFFSET_SECONDS, settled_frame, unborn
from .several_people import STRANGER_SECONDS, by_person
from .sight import Sight, Watcher, believable, fresh, kinship, received, rows_of
from .spatial import Processes, fit_processes, shape_features
from .spine import DECIDE, can_tell, elsewhere, heights
from .stamps import taken
from .state import Corrected, CorrectorState
from .still import is_repeated, repeated, unmeasured
from .thrown_about import Believed, followed, unknown
from .watching import look, look_twice

REMEMBERED = 1.0  # s, for which joints that the model lacks stay beside their neighbours
QUICKEST = 1e-4  # s from frame to frame; what is less are no times of a sensor in s
KEPT = 2500  # samples that a model keeps for the methods it is compared with


@dataclass(frozen=True)
class Corrector:
    """How to learn a corrector.

    Attributes
    ----------
    points : postures that offsets are told by, half of them mirrored.
    frames : that those are learned from, at most.
    seed : of the choice of points and frames.
    """

    points: int = 400
    frames: int = 4000
    seed: int = 0

    def __post_init__(self) -> None:
        if self.points < 2 or self.frames < 1:
            raise UsageError(f"two points and a frame are the least, came {self.points} and {self.frames}")

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
        processes = fit_processes(samples, offsets, body, self.points, self.frames, self.seed)
        paired = np.isfinite(offsets).all(axis=2).mean(axis=0) > 0.05
        kept = np.linspace(0, len(samples) - 1, min(len(samples), KEPT)).astype(int)
        some = samples[:: max(len(samples) // 500, 1)]
        moved = some + following(body.names, paired) @ processes.predict(shape_features(some, body))[0]
        factors, detector = learned_factors(taught, good, body), usual_unsteadiness(taught, good, body)
        return CorrectorModel(
            self,
            body.names,
            standard,
            factors,
            alarmed(Watcher(body, standard, factors, detector), taught, good),
            processes,
            np.append(bone_lengths(moved, body).mean(axis=0), np.nan),
            paired,
            Samples(_rounded(samples[kept]), _rounded(offsets[kept])),
            len(pairs),
            len(samples),
            learned_limits(samples, offsets, paired, body),
            all(pair.fitted for pair in pairs),
        )


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
    processes : the offsets.
    bones : (B + 1,) mean lengths of corrected bones in standard metres, the last NaN.
    paired : (J,) joints of which some truth was known.
    samples : some of what it was learned from, for the methods it is compared with.
    pairs, frames : how many it was learned from.
    limits : (J, 2) rad, least and most angle at each joint's parent; NaN = not known.
    fitted : all pairs were brought together by a rigid motion each.
    """

    settings: Corrector
    names: tuple[str, ...]
    standard: Standard
    factors: Factors
    detector: Detector
    processes: Processes
    bones: Floats
    paired: Bools
    samples: Samples
    pairs: int
    frames: int
    limits: Floats
    fitted: bool

    def __post_init__(self) -> None:
        watcher = Watcher(anatomy(self.names), self.standard, self.factors, self.detector)
        follow = following(self.names, self.paired)
        knowledge = Knowledge(watcher, self.processes, follow, self.samples, self.limits, self.fitted)
        object.__setattr__(self, "_knowledge", knowledge)

    @property
    def knowledge(self) -> Knowledge:
        """What recordings are corrected with."""
        found: Knowledge = self.__dict__["_knowledge"]
        return found

    @property
    def watcher(self) -> Watcher:
        """What looks at frames."""
        return self.knowledge.watcher

    def start(self, names: Sequence[str], online: bool = False, look_ahead: int = 0) -> CorrectorState:
        """The state before a client's first frame.

        Parameters
        ----------
        names : of the client's joints.
        online : learn from the client's own frames.
        look_ahead : frames after each that are waited for; the latency of `feed` in frames.

        Raises
        ------
        MismatchError : the joints have too little in common with the model's.
        UsageError : look_ahead is below 0.
        """
        if look_ahead < 0:
            raise UsageError(f"frames to wait for were wanted, came {look_ahead}")
        joining = joined(names, self.watcher.body)
        waiting = Waiting(look_ahead) if look_ahead else None
        return self._begun(joining, self.knowledge.hinges(joining), waiting, online=online)

    def _begun(
        self, joining: Joining, hinges: Hinges | None, waiting: Waiting | None, *, online: bool
    ) -> CorrectorState:
        """Before anything is known of a person."""
        memory = None
        if online:
            inputs = neighbour_inputs(self.factors.mean[None], self.watcher.body)
            memory = blank(inputs.shape[1], inputs.shape[2])
        shown = unborn(len(joining.names), len(joining.bones))
        nothing = np.full((len(self.names), 3), np.nan)
        seen = np.empty((0, len(self.names))) if can_tell(joining, self.watcher.body) else None
        courses = unknown(len(joining.names))
        sight = fresh(self.watcher)
        return CorrectorState(joining, sight, shown, nothing, courses, memory, waiting, hinges, heights=seen)

    def step(
        self, state: CorrectorState, positions: Floats, states: Bytes | None, time: float
    ) -> tuple[CorrectorState, Corrected]:
        """Correct one frame at once; of a client that looks ahead, `feed` does.

        Parameters
        ----------
        state : after the frame before.
        positions : (J, 3) m; what is not finite is missing.
        states : (J,) 2 tracked, 1 inferred, 0 not tracked; None where the sensor does not say.
        time : s.

        Returns
        -------
        The state after this frame, and the corrected frame.

        Raises
        ------
        MismatchError : positions or states of other joints than the state was started for; a time that is no number.
        """
        state, sight, given = self._seen(state, positions, states, time)
        followed = sight.followed
        return self._put_right(state, sight, sight, given, followed.posture, followed.std, followed.failing[None])

    def feed(
        self, state: CorrectorState, positions: Floats, states: Bytes | None, time: float
    ) -> tuple[CorrectorState, Corrected | None]:
        """Take in one frame, and correct the one `look_ahead` frames before it; parameters as of `step`.

        Returns
        -------
        The state after this frame, and that frame corrected; None as long as there is none.

        Raises
        ------
        MismatchError : as of `step`.
        """
        if state.waiting is None:
            return self.step(state, positions, states, time)
        waiting = state.waiting
        state, sight, given = self._seen(state, positions, states, time)
        waiting = waiting.with_frame(sight, given)
        state = replace(state, sight=sight, waiting=waiting)
        return self._first(state) if waiting.full else (state, None)

    def rest(self, state: CorrectorState) -> tuple[CorrectorState, tuple[Corrected, ...]]:
        """The frames that still wait, corrected: no more will come."""
        found = []
        while state.waiting is not None and state.waiting.sights:
            state, one = self._first(state)
            found.append(one)
        return state, tuple(found)

    def _seen(
        self, state: CorrectorState, positions: Floats, states: Bytes | None, time: float
    ) -> tuple[CorrectorState, Sight, Believed]:
        joints = len(state.joining.names)
        if np.shape(positions) != (joints, 3) or (states is not None and np.shape(states) != (joints,)):
            came = f"{np.shape(positions)}" if states is None else f"{np.shape(positions)} and {np.shape(states)}"
            raise MismatchError(f"a frame of {joints} joints is ({joints}, 3), its states ({joints},), came {came}")
        if not isfinite(time):
            raise MismatchError(f"the time of a frame in s was wanted, came {time}")
        state = self._along_the_spine(state, positions)
        sensed, rows, told = received(state.joining.to_model, positions, states)
        courses, given = followed(state.courses, sensed, float(time))
        if given.positions is not sensed:
            rows = rows_of(state.joining.to_model, given.positions)
        away = STRANGER_SECONDS < time - state.sight.seen < np.inf and np.isfinite(rows).any()
        if away or (courses.thrown and not state.courses.thrown and courses.soon):
            state = self._of_a_stranger(state)
        state = replace(state, courses=courses)
        if state.waiting is not None:  # the frames that wait will tell
            return state, look(self.watcher, state.sight, rows, told, float(time)), given
        sight, doubt = look_twice(self.watcher, state.sight, state.doubt, rows, told, float(time))
        return replace(state, doubt=doubt), sight, given

    def _along_the_spine(self, state: CorrectorState, positions: Floats) -> CorrectorState:
        """The state as the joints of the spine are the model's or not, by where the first frames have them."""
        joining, body = state.joining, self.watcher.body
        if state.heights is None:
            return state
        here = heights(rows_of(joining.meant, believable(positions)), body)
        if not np.isfinite(here).any():
            return state
        seen = np.vstack([state.heights, here])
        other = elsewhere(seen, joining, self.standard, body)
        if (other != joining.elsewhere).any():
            joining = joined(joining.names, body, other)
            online = state.memory is not None
            state = self._begun(joining, self.knowledge.hinges(joining), state.waiting, online=online)
        return replace(state, heights=seen if len(seen) < DECIDE else None)

    def _of_a_stranger(self, state: CorrectorState) -> CorrectorState:
        """All that was known of a person forgotten; the sensor stands where it stood, and frames that wait still do."""
        begun = self._begun(state.joining, state.hinges, state.waiting, online=state.memory is not None)
        sight = replace(begun.sight, upright=state.sight.upright, lean=state.sight.lean)
        return replace(begun, sight=sight, heights=state.heights, courses=state.courses)

    def _first(self, state: CorrectorState) -> tuple[CorrectorState, Corrected]:
        """The oldest of the frames that wait, given out."""
        waiting = state.waiting
        assert waiting is not None
        posture, std, failing, belief = first_of(self.factors, waiting, self.watcher.body.mirror)
        left = replace(state, waiting=waiting.without_first(belief))
        return self._put_right(left, state.sight, waiting.sights[0], waiting.given[0], posture, std, failing, waiting)

    def _put_right(
        self,
        state: CorrectorState,
        latest: Sight,
        sight: Sight,
        given: Believed,
        posture: Floats,
        unsure: Floats,
        failing: Floats,
        waiting: Waiting | None = None,
    ) -> tuple[CorrectorState, Corrected]:
        """What is put out of a frame, and the state after it and the `latest` frame that came.

        Known are its posture (J of model, 3), the deviation of that, and which joints fail (1 + N, J of model) in it
        and in the frames that wait behind it.
        """
        state = self._of_a_stranger(state) if sight.other else state
        joining, body, memory, time = state.joining, self.watcher.body, state.memory, float(sight.time or 0.0)
        kin = state.kin_after(kinship(self.watcher, sight, joining.doubt), time)
        offsets, std = self.knowledge.offsets(posture[None], unsure[None], kin)
        since, at = time - state.shown.time, (sight.rows, sight.earlier)
        offset = bones.followed_slowly(state.offset, offsets[0], since, *OFFSET_SECONDS, *at, since)
        moved = (posture + kin * offset)[None]
        learned = moved
        inputs = neighbour_inputs(posture[None], body)[0] if memory is not None else np.zeros((0, 0))
        if memory is not None:
            learned = moved + remembered(memory, inputs)
        last = state.shown.last if since < REMEMBERED else np.full(given.positions.shape, np.nan)
        placed, deviation, trust = outward(joining, given.positions[None], [sight], learned, std, failing[:1], last)
        deviation, trust = np.hypot(deviation, given.deviation), trust * given.share
        prior = self.bones[joining.model_bones] * sight.scale
        later = None if waiting is None else going_on(joining, waiting, failing, placed[0])
        shown, settled = settled_frame(
            state.shown,
            placed[0],
            time,
            trust[0],
            joining.bones,
            prior,
            state.hinges,
            kin,
            later,
            sight.shaking.noise,
        )
        if memory is not None:
            calm = shown.calm  # what following adds to it is behind the person, and nothing to be learned
            shifts = inward(joining, [sight], settled[None])[0] - inward(joining, [sight], calm[None])[0]
            memory = taken_in(memory, time, inputs, shifts, 1.0 - failing[0], unsure < 0.01)
        stale = is_repeated(sight)
        if stale:
            deviation, trust = unmeasured(np.array([True]), np.array([sight.stale]), deviation, trust)
        flags = _words(sight, failing[0, joining.common], kin, stale)
        after = replace(state, sight=latest, shown=shown, memory=memory, offset=offset, kin=kin)
        return after, Corrected(settled, deviation[0], trust[0], flags)

    def correct(
        self, postures: Postures, online: bool = False, method: str = "default", look_ahead: int | None = None
    ) -> Postures:
        """Correct a recording.

        Parameters
        ----------
        postures : any joint set that has joints in common with the model's.
        online : learn from the recording while correcting it.
        method : one of `METHODS`.
        look_ahead : correct as if live, each frame from those before it and so many after it; None = from all.

        Returns
        -------
        The same joints, frames and times, with `std` and `reliability`.

        Raises
        ------
        MismatchError : the joints have too little in common with the model's; times that are no numbers, or no s.
        UsageError : unknown method, or one that is not for looking ahead; look_ahead is below 0.
        """
        if look_ahead is not None and look_ahead < 0:
            raise UsageError(f"frames to wait for were wanted, came {look_ahead}")
        if look_ahead is not None and method != "default":
            raise UsageError(f"only the default method looks ahead, came {method!r}")
        if method not in METHODS:
            raise UsageError(f"unknown method {method!r}: choose one of {', '.join(METHODS)}")
        joined(postures.names, self.watcher.body)
        timeless = np.flatnonzero(~np.isfinite(postures.times))
        if len(timeless):
            raise MismatchError(f"times in s were wanted, frame {timeless[0]} has {postures.times[timeless[0]]}")
        steps = np.diff(postures.times)
        step = float(np.median(steps[steps > 0])) if (steps > 0).any() else QUICKEST
        if step < QUICKEST:
            raise MismatchError(f"times in s were wanted, they rise by {step:.2g} a frame: are they days, or hours?")
        if not postures.frames:
            nothing = np.zeros((0, len(postures.names)))
            return replace(postures, std=nothing, reliability=nothing)
        with threadpool_limits(1, user_api="blas"):  # many small products: threads would wait for each other
            postures = postures.with_positions(believable(postures.positions))
            if method in FILTERS:
                return by_filter(postures, method)
            if method == "default":
                at = replace(postures, times=taken(postures.times))
                if look_ahead is not None:
                    return replace(self._as_live(at, online, look_ahead), times=postures.times)
                found = by_person(lambda one: by_default(self.knowledge, one, online), at, self.watcher.body)
                return replace(found, times=postures.times)
            if method in PAPER:
                return by_paper(self.knowledge, self.mixture, postures, method, online)
            return by_learner(self.knowledge, postures, method)

    def _as_live(self, postures: Postures, online: bool, look_ahead: int) -> Postures:
        state = self.start(postures.names, online, look_ahead)
        found, sights, nothing = [], [], state.sight.followed
        for t in range(postures.frames):
            told = None if postures.state is None else postures.state[t]
            state, one = self.feed(state, postures.positions[t], told, float(postures.times[t]))
            sights.append(replace(state.sight, followed=nothing))  # 20 kB a frame that only the next one asks for
            found += [] if one is None else [one]
        found += self.rest(state)[1]
        again, _ = repeated(postures.positions, postures.times)
        positions = np.stack([one.positions for one in found])
        return replace(
            postures,
            positions=positions,
            std=np.stack([one.std for one in found]),
            reliability=np.stack([one.reliability for one in found]),
            source=noted(state.joining, postures, positions, sights, state.kin, again),
        )

    @property
    def mixture(self) -> Mixture:
        """The paper's local models, learned from the samples when first asked for."""
        if "_learned_mixture" not in self.__dict__:
            mixture = learned_mixture(self.samples, self.watcher.body, self.settings.seed)
            object.__setattr__(self, "_learned_mixture", mixture)
        found: Mixture = self.__dict__["_learned_mixture"]
        return found

    def to_arrays(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """Arrays and a JSON-able header from which `from_arrays` makes the model again."""
        arrays: dict[str, Any] = {
            "standard.lengths": self.standard.lengths,
            "standard.trunk": self.standard.trunk,
            "paired": self.paired,
        }
        arrays["bones"] = self.bones
        arrays["limits"] = self.limits
        arrays["samples.postures"] = self.samples.postures.astype(np.float32)
        arrays["samples.offsets"] = self.samples.offsets.astype(np.float32)
        arrays |= {f"factors.{name}": getattr(self.factors, name) for name in ("mean", "loadings", "rates", "noise")}
        arrays |= {f"detector.{name}": value for name, value in self.detector.to_arrays().items()}
        arrays |= {f"processes.{name}": value for name, value in self.processes.to_arrays().items()}
        header = {
            "names": list(self.names),
            "pairs": self.pairs,
            "frames": self.frames,
            "points": self.settings.points,
            "most_frames": self.settings.frames,
            "seed": self.settings.seed,
            "fitted": self.fitted,
        }
        return arrays, header

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, Any], header: Mapping[str, Any]) -> "CorrectorModel":
        """The model that `to_arrays` took apart."""

        def below(prefix: str) -> dict[str, Any]:
            return {name[len(prefix) :]: value for name, value in arrays.items() if name.startswith(prefix)}

        return cls(
            Corrector(header["points"], header["most_frames"], header["seed"]),
            tuple(header["names"]),
            Standard(arrays["standard.lengths"], arrays["standard.trunk"]),
            Factors(**below("factors.")),
            Detector.from_arrays(below("detector.")),
            Processes.from_arrays(below("processes.")),
            arrays["bones"],
            arrays["paired"],
            Samples(arrays["samples.postures"].astype(np.float64), arrays["samples.offsets"].astype(np.float64)),
            header["pairs"],
            header["frames"],
            arrays["limits"],
            header["fitted"],
        )


def _rounded(values: Floats) -> Floats:
    """As a model file keeps them, so that a model read back is the same."""
    return np.asarray(values.astype(np.float32), dtype=np.float64)


def _words(sight: Sight, failing: Floats, kin: float, stale: bool) -> tuple[str, ...]:
    said = (
        ("swapped", np.count_nonzero(sight.swapped)),
        ("refused", sight.refused),
        ("held", np.count_nonzero(failing > 0.5)),
        ("foreign", kin < FOREIGN),
        ("stale", stale),
    )
    return tuple([word for word, true in said if true])


__all__ = ["METHODS", "Corrected", "Corrector", "CorrectorModel", "CorrectorState", "Pair"]
