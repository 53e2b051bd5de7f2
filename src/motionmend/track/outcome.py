"""What a frame comes to: the state that is carried on, and the estimate that is given out."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import final

import numpy as np

from ..arrays import Bools, Floats, Singles, frozen
from ..bodies.performer import DOFS, Performer, Pose, bone_frames, landmarks
from ..bodies.surface import intrinsics
from .limbs.certainty import astray, bare_of, certainty_of, shown_and_denied, trust_of
from .lost import UNPROVEN, is_lost, is_unproven
from .measure.girth import FRAMES, Girth, learned
from .misread import held, misread, odds_misread
from .readings.facing import changed_about, changed_over, lies
from .readings.pair import either
from .stages import Stages
from .starting.afresh import watched
from .state import Fit, Sight, TrackState
from .terms.objective import PAUSE
from .terms.smooth import difference

BODY = 0.25  # share of pixels usually explained wrongly, up to which they are surely a body's: furniture's are 0.3
PROBATION = 1.0  # s, in which it has to prove itself; what is usual gives way meanwhile
DOUBTFUL = 1.15  # times the usual share of pixels explained wrongly, above which a pose may be wrong
UNSURE = 0.10  # m, the least deviation of a joint of a body that is lost


@final
@dataclass(frozen=True, eq=False)
class Estimate:
    """What one frame gave.

    Attributes
    ----------
    pose : None while nobody was ever found. landmarks : (16, 3) m in camera axes, NaN then.
    std : (16,) m, standard deviation of each joint (one coordinate); half of how far apart two readings of front and
        back have it at least, until one of them is refuted, and wider by what doubt is left then.
    settled : (16,) m, the deviation if this reading is the right one; None where nobody is.
    changed : how likely front and back are changed over, 0 to 0.5.
    flags : of tracked, held, lost, recovered, revised and empty; `held` joints are in `held`, and only `hindsight` says
        `revised`.
    held : (16,) True where nothing of the limb is seen and the prior holds it.
    costs, inliers : of each term. wrong : share of the person's pixels explained wrongly.
    converged, iterations : of Gauss-Newton. covariance : (34, 34) m² and rad².
    restarts : how many limbs or bodies were found anew.
    seconds : of each stage.
    """

    pose: Pose | None
    landmarks: Floats
    std: Floats
    flags: tuple[str, ...]
    held: Bools
    costs: Mapping[str, float] = field(default_factory=dict)
    inliers: Mapping[str, int] = field(default_factory=dict)
    wrong: float = float("nan")
    converged: bool = False
    iterations: int = 0
    covariance: Floats | None = None
    restarts: int = 0
    settled: Floats | None = None
    changed: float = 0.0
    seconds: Mapping[str, float] = field(default_factory=dict)


@final
@dataclass(frozen=True, eq=False)
class Searched:
    """What looking for limbs, and for the whole body from where it is, came to.

    Attributes
    ----------
    fit : the best one. restarts : how many limbs were found anew.
    busy : this frame was searched for something. unclaimed : a piece of the person has nothing of the body near it.
    doubt : (16,) m, about each joint.
    """

    fit: Fit
    restarts: int = 0
    busy: bool = False
    unclaimed: bool = False
    doubt: Floats = field(default_factory=lambda: frozen(np.zeros(16)))


@final
@dataclass(frozen=True, eq=False)
class _Belief:
    """How far the pose of a frame is believed.

    Attributes
    ----------
    trust : (28,) of each angle, as of `TrackState`. visible : (16,) joints that are seen.
    odds : log, that the body is followed wrongly, by this frame. misread : the same, held over frames.
    bare : (16,) as of `TrackState`. hidden : (16,) s, since each joint was last seen.
    covariance : (34, 34) m² and rad². std : (16,) m.
    """

    trust: Floats
    visible: Bools
    odds: float
    misread: float
    bare: Floats
    hidden: Floats
    covariance: Floats
    std: Floats


def followed(
    sight: Sight, fit: Fit, searched: Searched, elapsed: float, recovered: bool, clock: Stages
) -> tuple[TrackState, Estimate]:
    """The next state and the estimate, after a frame in which the body was followed, or lost while it was.

    Parameters
    ----------
    sight, fit : the frame, and how it is explained in the end.
    searched : what looking for limbs came to.
    elapsed : s since the frame before; 0 of a body that was just found.
    recovered : whether it was found anew.
    clock : of the frame's stages.
    """
    state, pose, wrong = fit.state, fit.pose, fit.wrong
    belief = _believed(sight, fit, searched, elapsed, recovered)
    # Not who is seen for the first time, unless they lie.
    anew = recovered or (state.lost and (bool(np.isfinite(state.wrong)) or lies(pose)))
    found = 0.0 if anew else state.found + elapsed
    refuted = sight.settings.search and is_lost(state.wrong, wrong)
    lost = refuted or (sight.settings.search and found < PROBATION and is_unproven(state.wrong, pose, wrong))
    # A pose that was just found, or fits worse than usual, says little of widths.
    doubtful = wrong > DOUBTFUL * state.wrong + 0.01
    sure = elapsed > 0.0 and not (lost or recovered or searched.restarts or doubtful)
    performer, girth = _measured(sight, fit, clock) if sure else (state.performer, state.girth)
    running = _usual(fit, searched.unclaimed)
    assert state.scene is not None
    vouched = not lost and (state.scene.vouched or running < BODY)
    after = replace(
        state,
        scene=replace(state.scene, vouched=vouched, stirred=0.0 if lost else state.scene.stirred),
        performer=performer,
        girth=girth,
        afresh=None if lost or state.afresh is None else watched(state.afresh, elapsed, belief.odds),
        pose=pose,
        velocity=frozen(_velocity(state, pose, belief.trust, elapsed)),
        trust=frozen(belief.trust),
        hidden=frozen(belief.hidden),
        lost=lost,
        found=found,
        wrong=state.wrong if refuted else running,
        misread=belief.misread,
        bare=frozen(belief.bare),
        hypothesis=None if lost or recovered else state.hypothesis,
        before=_images(sight, performer, pose),
    )
    std = np.maximum(belief.std, UNSURE) if lost else belief.std
    place, changed = landmarks(performer, pose), changed_about(state.facing)
    unsure = std if state.facing.unread else changed_over(std, place, changed)
    unsure = np.maximum(unsure, either(state.facing.question, performer, pose))
    flags = ("lost",) if lost else ("tracked", *(("recovered",) if recovered or searched.restarts else ()))
    flags += ("held",) if not belief.visible.all() else ()
    clock.lap("certainty")
    solution = fit.solution
    return after, Estimate(
        pose=pose,
        landmarks=place,
        std=unsure,
        flags=flags,
        held=~belief.visible,
        costs=solution.system.costs,
        inliers=solution.system.inliers,
        wrong=wrong,
        converged=solution.converged,
        iterations=solution.iterations,
        covariance=belief.covariance,
        restarts=searched.restarts + recovered,
        settled=std,
        changed=changed,
        seconds=clock.seconds,
    )


def _believed(sight: Sight, fit: Fit, searched: Searched, elapsed: float, recovered: bool) -> _Belief:
    """What the image shows and denies of each joint, and how sure each is for that."""
    state, pose, wrong, coarse = fit.state, fit.pose, fit.wrong, sight.coarse
    performer = state.performer
    shown, denied, unknown = shown_and_denied(performer, pose, coarse, sight.evidence.weight)
    trust, visible = trust_of(shown)
    odds = odds_misread(sight.model.database.search, pose, wrong, trust)
    past, bare = (float("nan"), np.full(len(shown), np.nan)) if recovered else (state.misread, state.bare)
    mean = held(past, odds, elapsed)
    bare = bare_of(bare, shown, denied, unknown, elapsed)
    doubt = np.hypot(searched.doubt, astray(shown, denied, bare, wrong, state.wrong))
    doubt = np.sqrt(doubt**2 + either(state.sides.question, performer, pose) ** 2 + misread(mean) ** 2)
    hidden = np.where(visible, 0.0, state.hidden + elapsed)
    covariance, std = certainty_of(performer, fit.solution, hidden, doubt, wrong)
    return _Belief(trust, visible, odds, mean, bare, hidden, covariance, std)


def _velocity(state: TrackState, pose: Pose, trust: Floats, elapsed: float) -> Floats:
    """(34,) m/s and rad/s by which it came here from the frame before; zero after a pause."""
    if not 0.0 < elapsed < PAUSE:
        return np.zeros(DOFS)
    assert state.pose is not None
    velocity = difference(pose, state.pose) / elapsed
    velocity[6:] *= np.minimum(1.0, 0.2 + trust)  # what is not seen is not known to go on moving
    return velocity


def _measured(sight: Sight, fit: Fit, clock: Stages) -> tuple[Performer, Girth | None]:
    """The person's widths with one more frame, until they are known."""
    performer, girth = fit.state.performer, fit.state.girth
    if girth is None or girth.frames >= FRAMES:
        return performer, girth
    girth = learned(girth, performer, fit.pose, sight.evidence, sight.coarse, sight.settings)
    clock.lap("girth")
    return girth.performer, girth


def _usual(fit: Fit, unclaimed: bool) -> float:
    """Share of pixels usually explained wrongly, with one more frame."""
    usual, wrong = fit.state.wrong, fit.wrong
    if not np.isfinite(usual):
        return min(wrong, UNPROVEN)
    # A pose that fits worse than usual says little of what is usual, nor does the first one if it fits badly.
    share = 0.1 if wrong < 1.2 * usual and not unclaimed else 0.02
    return (1.0 - share) * usual + share * wrong


def _images(sight: Sight, performer: Performer, pose: Pose) -> tuple[Floats, Singles, Singles, Floats] | None:
    """What the color term compares the next frame with."""
    seen = sight.seen
    if "color" not in sight.settings.terms or seen.intensity is None:
        return None
    return bone_frames(performer, pose), seen.intensity, seen.depth, intrinsics(seen.camera)


def nobody(state: TrackState, elapsed: float, flags: tuple[str, ...], clock: Stages) -> tuple[TrackState, Estimate]:
    """The last pose is kept; its joints may be anywhere within reach by now."""
    hidden = state.hidden + elapsed
    after = replace(state, hidden=frozen(hidden), lost=True, velocity=frozen(np.zeros(DOFS)), before=None)
    place = np.full((16, 3), np.nan) if state.pose is None else landmarks(state.performer, state.pose)
    std = np.full(16, np.nan) if state.pose is None else 0.15 + 0.5 * hidden
    return after, Estimate(state.pose, place, std, flags, np.ones(16, bool), seconds=clock.seconds)
