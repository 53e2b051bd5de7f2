"""A whole recording repaired by the adaptive method: joint angles, or markers with their gaps and labels."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Generic

import numpy as np

from ...arrays import Bools, Floats, Ints
from ...bodies.motion import Markers, Motion, Origin, Recording, Repaired
from ...bodies.skeleton import ROTATION
from ...numerics.ssa import Eigenbases, at_rate, eigenbases, lag_covariance, sum_covariances
from ..channels.cloud import in_metres
from ..channels.joints import JointChannels, root_rows
from ..channels.layout import Layout, along_main_heading, names_of, own_layout
from ..channels.pieces import pieces
from ..channels.recording import Channels, to_channels
from ..channels.root_deviations import root_deviations
from ..faults.contradicted import contradicted
from ..faults.displaced import displaced, lasting
from ..faults.fallen import but_for_fallen
from ..faults.held import SAID, for_long, held, in_noise, recorded_but_lost, told, without
from ..faults.leapt_back import leapt_back
from ..faults.lost_capture import kept_where_open
from ..faults.slid import said_of_sliding
from ..faults.stood_joint import stood_joints
from ..faults.stood_still import stood_still
from ..faults.stuck_again import said_of_stuck_again
from ..faults.takes import repaired_in_takes
from ..faults.thrown_root import thrown
from ..gaps.likeliest import Process
from ..gaps.unseen_frames import as_unsure_as_it_moves, made_up_beyond
from ..labels.relabelling import (
    but_for_throughout,
    relabelled,
    relabelled_origin,
    right_at_first_sight,
    swaps_of,
    swaps_seen,
    swaps_told,
    tell_distances,
)
from ..labels.swaps import Swap
from ..labels.undecided import but_for_undecided
from ..library.exemplars import Library
from ..library.learning import at_rate as series_at_rate
from ..library.local_prior import Prior, neighbourhood
from ..library.markers import MarkerLibrary
from ..noise.barely_moving import most_bends
from ..noise.digits import shaken
from ..noise.own_bends import LONGEST_OF_ANGLES, LONGEST_OF_MARKERS, first_bends, own_bends
from ..outcome import brought_back, repaired_recording
from ..too_short import FEWEST_FRAMES, as_recorded
from .beliefs import Heard
from .blocks import Grounds, Mended, mend_channels
from .given_back import said_of_swings
from .limits import seen_between, within_body_limits, within_seen
from .marker_gaps import filled_from_all, with_gaps_filled
from .replaced import hardly_believed, never_seen
from .second_opinion import calmer, doubtful, of_one_cloud, of_one_mind
from .smoothing import least_bend
from .traits import traits_of
from .unmoving import Unmoving, kept_still, nothing_still, unmoving
from .untaught import with_untaught

OWN_RATE, OWN_WINDOW = 30.0, 20  # Hz and frames of a recording's own patterns, as the dissertation has them
OWN_ENERGY = 0.9  # of the variance: what is left is as likely noise
LONG = 1 << 16  # frames of a recording whose patterns are learned at once
MUCH_LESS = 0.1  # of the variance of second differences that a first repair shows: that less is no chance
OWN_WINDOWS = 3  # whole windows a recording needs to have patterns of its own


@dataclass(frozen=True, eq=False)
class Knowledge:
    """What clean clips taught of a kind of recording; None where they taught nothing.

    Attributes
    ----------
    layout : its channels.
    library : how sharply clean motion bends.
    bases : spatio-temporal patterns at `fps` Hz.
    postures : examples of marker sets; None for motions.
    fps : Hz.
    process : how clean motion goes on, for gaps.
    whole : False where the recording goes on before and after its frames.
    orderly : the recording itself, if it was seen that at first sight no labels are swapped in it.
    """

    layout: Layout
    library: Library | None
    bases: Eigenbases | None
    postures: MarkerLibrary | None
    fps: float
    process: Process | None = None
    whole: bool = True
    orderly: Markers | None = None


def mend_alone(recording: Recording) -> Repaired[Recording]:
    """Repair a recording by what it shows itself: no clip has taught anything.

    How sharply it bends is read off the recording, then again off its first repair; a recording without gaps also lends
    its own patterns (section 2.4), which help to tell outliers but know nothing of what was never seen.
    """
    return mend_recording(recording, _of_itself(recording))


def _of_itself(recording: Motion | Markers, *, whole: bool = True) -> Knowledge:
    return Knowledge(along_main_heading(own_layout(recording), recording), None, None, None, OWN_RATE, whole=whole)


def mend_recording(recording: Recording, known: Knowledge) -> Repaired[Recording]:
    """Repair a recording without being told how noisy it is.

    Parameters
    ----------
    recording : of the layout's channels.
    known : of clean clips.

    Raises
    ------
    MismatchError : the recording is of another kind or channel set.
    """
    return repaired_in_takes(recording, lambda take: _by_its_labels(take, known))


def _by_its_labels(recording: Recording, known: Knowledge) -> Repaired[Recording]:
    """A take's repair; where nothing tells which of two parts bears the right labels, these are left."""
    told_apart = known.postures is not None and tell_distances(known.postures)
    if told_apart or not isinstance(recording, Markers):
        return _mended_take(recording, known)
    repair = partial(_mended_take, known=known)
    if known.library is not None:
        return but_for_undecided(repair, recording)
    orderly = partial(_mended_take, known=replace(known, orderly=recording))
    return but_for_undecided(repair, recording, orderly)


def _mended_take(recording: Recording, known: Knowledge) -> Repaired[Recording]:
    outcome: Repaired[Recording] = but_for_fallen(partial(_brought_back, known=known), recording)
    outcome = as_unsure_as_it_moves(outcome)
    if recording.frames < FEWEST_FRAMES:
        return as_recorded(recording, outcome)
    return replace(
        outcome,
        warnings=(
            *outcome.warnings,
            *said_of_sliding(outcome.recording, outcome.origin),
            *said_of_stuck_again(recording, outcome.origin),
            *hardly_believed(outcome),
            *made_up_beyond(outcome),
            *never_seen(outcome),
        ),
    )


def _brought_back(recording: Recording, known: Knowledge) -> Repaired[Recording]:
    """The repair, with what was held still or leapt away for a while taken as missing."""
    # leaps and stands show in what was recorded; markers' places, and whether what is held is noisy, in a repair
    leapt = thrown(recording) if isinstance(recording, Motion) else leapt_back(recording)
    stood = stood_joints(recording) if isinstance(recording, Motion) else stood_still(recording)
    wrong = leapt | stood
    look = _first_look(without(recording, wrong) if wrong.any() else recording, known)
    outcome = look.outcome
    still = in_noise(held(recording), outcome, recording) & ~wrong
    away = leapt
    if isinstance(recording, Markers):
        away = leapt | (_elsewhere(recording, outcome) & ~still & ~wrong)
    beside = contradicted(recording, outcome)
    lost = still | away | stood | beside.beside | beside.drawn
    if (lost == wrong).all():
        outcome = look.filled()
    else:
        again = look.again if (lost == wrong | beside.beside).all() else None
        del look, outcome  # of a long recording only one is held at once
        outcome = _mended_once(without(recording, lost), known) if again is None else again(without(recording, lost))
    if not lost.any():
        return outcome
    outcome = recorded_but_lost(told(outcome, still, away, stood), lost, beside.said(recording))
    if isinstance(recording, Motion) and isinstance(outcome.recording, Motion):
        return kept_where_open(outcome, recording, for_long(still, recording.fps), lost)
    return outcome


@dataclass(frozen=True, eq=False)
class _Look(Generic[Recording]):
    """A first repair of a recording, of which what was measured is looked at.

    Attributes
    ----------
    outcome : in which gaps of markers may be left open, for most of what is filled now would be filled again.
    filled : the same with its gaps filled.
    again : the repair of the recording without a few more samples, by what this one went by; None = these may be many,
        or have misled it.
    """

    outcome: Repaired[Recording]
    filled: Callable[[], Repaired[Recording]]
    again: Callable[[Recording], Repaired[Recording]] | None


def _first_look(recording: Recording, known: Knowledge) -> _Look[Recording]:
    if not isinstance(recording, Markers) or not np.isin(names_of(recording), known.layout.names).all():
        outcome = _mended_once(recording, known)
        return _Look(outcome, lambda: outcome, None)
    found = _marker_channels(recording, known)
    grounds, swaps, fps = found.mended.grounds, found.swaps, recording.fps

    def again(fewer: Markers) -> Repaired[Markers]:
        channels = to_channels(fewer, known.layout)
        mended = with_gaps_filled(_mended(channels.values, fewer, channels, known, grounds), fps, None, False)
        return _of_channels(_MarkerChannels(fewer, channels, mended, swaps, False), known)

    def filled() -> Repaired[Markers]:
        mended = with_gaps_filled(found.mended, fps, known.postures, found.beside)
        return _of_channels(replace(found, mended=mended), known)

    anew = grounds is None or known.library is not None or any(swap.put_right for swap in swaps)
    return _Look(_of_channels(found, known), filled, None if anew else again)


def _elsewhere(recording: Markers, outcome: Repaired[Markers]) -> Bools:
    """(T, M) samples of markers that are not in their place; of rejected ones those that were so for a while."""
    # who only got its label back was believed
    rejected = lasting((outcome.origin == Origin.REPAIRED) & (outcome.weights == 0.0), recording.fps)
    believed = (outcome.origin == Origin.MEASURED) | rejected
    return displaced(np.where(believed[..., None], recording.positions, np.nan), recording.fps)


def _mended_once(recording: Recording, known: Knowledge) -> Repaired[Recording]:
    if isinstance(recording, Motion):
        of_motion, seen = _of_motion(recording, known)

        def motion_alone(beside: Motion, asked: Ints) -> Repaired[Motion]:
            return _of_motion(beside, _of_itself(beside, whole=known.whole), asked)[0]

        return within_body_limits(with_untaught(recording, of_motion, known.layout, motion_alone), seen)
    assert isinstance(recording, Markers)

    def markers_alone(beside: Markers, asked: Ints) -> Repaired[Markers]:
        return _of_markers(beside, _of_itself(beside, whole=known.whole), asked)

    found = with_untaught(recording, _of_markers(recording, known), known.layout, markers_alone)
    return filled_from_all(found, known.layout)


@dataclass(frozen=True, eq=False)
class _MarkerChannels:
    """A marker recording, the labels of these `swaps` given back, its channels and their repair.

    A library that may not know the motion is believed `beside` what the recording alone tells.
    """

    right: Markers
    channels: Channels
    mended: Mended
    swaps: tuple[Swap, ...]
    beside: bool


def _of_markers(recording: Markers, known: Knowledge, asked: Ints | None = None) -> Repaired[Markers]:
    """A marker recording's repair; only of markers that are asked for, if not of all, labels are given back."""
    found = _marker_channels(recording, known, asked)
    mended = with_gaps_filled(found.mended, recording.fps, known.postures, found.beside)
    return _of_channels(replace(found, mended=mended), known)


def _marker_channels(recording: Markers, known: Knowledge, asked: Ints | None = None) -> _MarkerChannels:
    """A marker recording's channels repaired, but for gaps that the markers about them fill."""
    right, channels, mended, swaps = _with_labels(recording, known, asked)
    beside = known.library is not None and doubtful(mended)
    if beside:
        untaught = replace(known, library=None, bases=None, process=None)
        own = _mended(channels.values.copy(), right, channels, untaught)  # which would write over what was measured
        mended = of_one_cloud(mended, own, channels.values, right.fps)
    return _MarkerChannels(right, channels, mended, swaps, beside)


def _of_channels(found: _MarkerChannels, known: Knowledge) -> Repaired[Markers]:
    """The repaired recording, and what is said of its labels."""
    right, channels, mended = found.right, found.channels, found.mended
    outcome: Repaired[Markers] = repaired_recording(
        right, known.layout, channels, mended.found, "adaptive", mended.noise
    )
    origin = relabelled_origin(outcome.origin, channels, found.swaps)
    taught = known.postures is not None and tell_distances(known.postures)
    said = swaps_told(found.swaps, right, channels, taught=taught)
    return replace(outcome, origin=origin, warnings=(*outcome.warnings, *said))


def _with_labels(
    recording: Markers, known: Knowledge, asked: Ints | None
) -> tuple[Markers, Channels, Mended, tuple[Swap, ...]]:
    """The recording with labels given back, its channels, their repair, and what was done.

    What is swapped throughout only distances tell, and people's differ: unless the library then misses less of the
    recording, it is not put right.
    """

    def repaired(labelled: Markers) -> tuple[Channels, Mended]:
        channels = to_channels(labelled, known.layout)
        return channels, _mended(channels.values, labelled, channels, known)

    def those_asked(swaps: tuple[Swap, ...], channels: Channels) -> tuple[Swap, ...]:
        if asked is None:
            return swaps
        return swaps_of(swaps, set(np.flatnonzero(np.isin(channels.columns, asked)).tolist()))

    at_first: tuple[Swap, ...] = ()
    if recording is not known.orderly:
        recording, at_first = right_at_first_sight(recording, to_channels(recording, known.layout), those_asked)
    channels, mended = repaired(recording)
    swaps = swaps_seen(_cleaned(mended, recording, known.layout), recording.fps, known.postures)
    swaps = those_asked(swaps, channels)
    right = relabelled(recording, channels, swaps)
    if right is recording:
        return right, channels, mended, (*at_first, *swaps)
    missed = mended.missed
    channels, mended = repaired(right)
    certain = but_for_throughout(swaps, recording, channels)
    if mended.missed > missed and certain != swaps:
        swaps, right = certain, relabelled(recording, channels, certain)
        channels, mended = repaired(right)
    return right, channels, mended, (*at_first, *swaps)


def _of_motion(motion: Motion, known: Knowledge, asked: Ints | None = None) -> tuple[Repaired[Motion], Floats]:
    """A motion's repair, and (D, 2) degrees between which the clips lie, NaN = not known.

    What leaps is said of the channels that are asked for, or of all.
    """
    way_back, mended = _channels_of_motion(motion, known)
    here, done = way_back.columns >= 0, np.full((motion.q.shape[1], 2), np.nan)
    done[way_back.columns[here]] = _seen(motion, way_back, known)[here]
    values = brought_back(motion, way_back, mended.found)
    said = (*mended.found.warnings, *_leaping(mended, way_back, known.layout, asked))
    if known.library is not None:
        said = (*said, *said_of_swings(mended.swings, mended.pace, known.layout.names))
    found = replace(mended.found.but_for_values(), warnings=said)
    outcome: Repaired[Motion] = repaired_recording(
        motion, known.layout, way_back, found, "adaptive", mended.noise, values
    )
    frame = way_back.inner.travel if isinstance(way_back.inner, JointChannels) else None
    if frame is not None and outcome.noise is not None:
        at_home = np.full(len(outcome.noise), known.library is not None)
        at_home[way_back.columns[way_back.columns >= 0]] |= mended.still[way_back.columns >= 0]
        std = root_deviations(
            outcome.std.astype(np.float64), outcome.noise, frame, motion, outcome.recording.q, at_home
        )
        outcome = replace(outcome, std=std.astype(np.float32))
    return outcome, done


def _leaping(mended: Mended, channels: Channels, layout: Layout, asked: Ints | None) -> tuple[str, ...]:
    """The sentence that says which samples look like outliers and were left; none where there are none."""
    leaps = mended.leaps if asked is None else np.where(np.isin(channels.columns, asked), mended.leaps, 0)
    far = np.argsort(-mended.farthest, kind="stable")
    far = far[leaps[far] > 0]
    if not len(far):
        return ()
    named = ", ".join(f"{layout.names[c]} ({leaps[c]})" for c in far[:SAID])
    return (
        f"samples that leap like outliers ({int(leaps.sum())}, by up to {mended.farthest[far[0]]:.0f} degrees or cm) "
        "were left as measured, for outliers are rare here and the recording may leap so itself: "
        f"{named}{', ...' if len(far) > SAID else ''}",
    )


def _channels_of_motion(motion: Motion, known: Knowledge) -> tuple[Channels, Mended]:
    """A motion's channels mended, and the way back; what they were before is let go."""
    channels = to_channels(motion, known.layout)
    mended = _mended(channels.values, motion, channels, known)
    if known.library is not None and not doubtful(mended):
        mended = replace(mended, found=within_seen(mended.found, _seen(motion, channels, known)))
    return channels.way_back(), mended


def _seen(motion: Motion, channels: Channels, known: Knowledge) -> Floats:
    """(C, 2) degrees between which the clips' joint angles lie; NaN for the root's, and where nothing is known."""
    if known.library is None:
        return np.full((len(channels.columns), 2), np.nan)
    return seen_between(known.library.exemplars, _held(motion, channels))


def _mended(
    values: Floats,
    recording: Motion | Markers,
    channels: Channels,
    known: Knowledge,
    grounds: Grounds | None = None,
) -> Mended:
    """Channels repaired; `values`, those of `channels`, may be lost by it.

    What a repair of the recording by itself went by serves for the same recording without a few samples.
    """
    traits = traits_of(values, recording, channels) if grounds is None else grounds.traits
    rounded, lasting = traits.rounded, traits.lasting
    mended = partial(mend_channels, values, fps=recording.fps, traits=traits, whole=known.whole)

    def unmoved(found: Mended) -> Unmoving:
        if isinstance(recording, Markers):
            return nothing_still(values.shape[1])  # bodies travel, and their markers with them
        asked = np.ones(values.shape[1], dtype=np.bool_)
        if known.library is not None:  # what moves in its clips it knows better, however slowly it moves here
            asked = np.diag(known.library.usual_bends(recording.fps)) <= least_bend(recording.fps)
        root = np.isin(channels.columns, np.concatenate(root_rows(recording.skeleton)))
        return unmoving(values, found, asked, root, recording.fps)

    def seen_alone() -> tuple[Prior, Unmoving, tuple[Heard, ...]]:
        seen = values if rounded is None else shaken(values, rounded)
        longest = LONGEST_OF_MARKERS if isinstance(recording, Markers) else LONGEST_OF_ANGLES
        gappy = not np.isfinite(values).all()
        plain = Prior(first_bends(seen, recording.fps, longest, lasting), None)
        first = mended(plain, deviations=False, trying=gappy, hearing=True)
        rest = unmoved(first)
        prior = _calmed(_own_prior(kept_still(first, rest), recording, known.fps), seen, first, recording)
        return prior, rest, first.heard

    if known.library is not None and known.bases is not None:
        near = neighbourhood(known.library, known.bases, known.fps)
        patterns, stride = at_rate(known.bases, known.fps, recording.fps)
        first = mended(
            Prior(known.library.usual_bends(recording.fps), patterns, stride), near=near, process=known.process
        )
        rest = unmoved(first)
        first = kept_still(first, rest)
        calm = calmer(first, known.library.usual_bends(recording.fps), recording.fps)
        if isinstance(recording, Markers) or not (calm or doubtful(first)):
            return first  # markers get their labels back first
        own, _, heard = seen_alone()
        if own.bases is None:  # what is missing was left open: only the library fills it
            own = _own_prior(first, recording, known.fps)
        return (
            first if own.bases is None else kept_still(of_one_mind(first, mended(own, into=values, heard=heard)), rest)
        )
    if grounds is None:
        own, rest, heard = seen_alone()
    else:
        own, rest, heard = grounds.prior, nothing_still(values.shape[1]), grounds.heard
    alike = isinstance(recording, Markers) and grounds is None  # may be asked for again
    again = kept_still(mended(own, into=values, heard=heard, hearing=alike, resumed=alike), rest)
    found = replace(again.found, warnings=())  # there is no library that could miss anything
    return replace(again, found=found, grounds=Grounds(traits, own, again.heard) if alike else None)


def _held(motion: Motion, channels: Channels) -> Bools:
    """(C,) True for the channels that are angles of joints, not of the root."""
    skeleton = motion.skeleton
    joint = skeleton.dof_kind == ROTATION
    joint[np.concatenate(root_rows(skeleton))] = False
    return np.where(channels.columns >= 0, joint[channels.columns], False)


def _own_prior(first: Mended, recording: Motion | Markers, rate: float) -> Prior:
    """What a first repair shows of a recording; its patterns only where it is a motion without a sample left open."""
    smooth = first.found.values
    whole = isinstance(recording, Motion) and bool(np.isfinite(smooth).all())
    own, pace = _own_bases(smooth, recording.fps, rate) if whole else (None, 1)
    tried = own is not None and len(first.tried) > 0
    elsewhere = _own_bases(first.tried, recording.fps, rate)[0] if tried else None
    return Prior(own_bends(smooth, first.unseen_bends), own, pace, own=True, elsewhere=elsewhere)


def _calmed(prior: Prior, seen: Floats, first: Mended, recording: Motion | Markers) -> Prior:
    """What is known of a recording where some markers hardly move: they bend no more than their slow changes allow."""
    if not isinstance(recording, Markers):
        return prior
    most, found = np.empty(len(prior.bends)), first.found
    for own in (slice(at, at + 3) for at in range(0, len(most), 3)):
        believed = (found.origin[:, own] == Origin.MEASURED) & np.isfinite(seen[:, own])
        most[own] = most_bends(np.where(believed, seen[:, own], found.values[:, own]))
    still = most < MUCH_LESS * np.diag(prior.bends)
    scale = np.ones(len(most))
    scale[still] = np.sqrt(most[still] / np.diag(prior.bends)[still])
    return replace(prior, bends=prior.bends * np.outer(scale, scale), still=still)


def _own_bases(smooth: Floats, fps: float, rate: float) -> tuple[Eigenbases | None, int]:
    """Patterns of a recording's own first repair, learned at about `rate` Hz, and their stride; none of a short one."""
    if len(smooth) < OWN_WINDOWS * OWN_WINDOW * fps / rate:
        return None, 1
    steps = max(1, round(fps / rate))
    own, after = steps * (LONG // steps), steps * (OWN_WINDOW - 1)  # frames after a part complete its windows
    parts = (smooth[part.start : part.stop + after] for part in pieces(len(smooth), own))
    lag = sum_covariances(lag_covariance(series_at_rate(part, fps, rate), OWN_WINDOW) for part in parts)
    return at_rate(eigenbases(lag, OWN_ENERGY), rate, fps)


def _cleaned(mended: Mended, recording: Markers, layout: Layout) -> Floats:
    """(T, M, 3) m: the measured samples smoothed, NaN where missing or rejected, in the travelling frame.

    What was rejected for a while may be at another marker: it is left as measured.
    """
    values = np.where(mended.found.origin == Origin.MEASURED, mended.found.values, np.nan)
    elsewhere = lasting(mended.found.origin == Origin.REPAIRED, recording.fps)
    if elsewhere.any():
        values = np.where(elsewhere, to_channels(recording, layout).values, values)
    return in_metres(values)
