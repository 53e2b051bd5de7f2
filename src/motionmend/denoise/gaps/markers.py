"""Gaps of markers filled from the markers about them, from what came before and after, and from a library.

Each marker is seen from a frame that moves with the markers whose distances to it change least. There its place is a
sum of smooth functions of the other markers' places (the same in all clips, and the recording's own deviation from
them) and of processes in time. How much each of them says is found from the recording and the library by restricted
likelihood; the prediction is that of universal kriging. So what the other markers miss on both sides of a gap is
carried into it, as far as it lasts: a short gap is bridged like a spline, a long one filled like a regression.
"""

from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from scipy.sparse.csgraph import connected_components
from threadpoolctl import threadpool_limits

from ...arrays import Bools, Floats, Ints, runs
from ...errors import MismatchError
from ..library.markers import MarkerLibrary, examples_like
from ..rivals.filtered import Filtered, check_channels, marker_std
from .hedge import hedged
from .limbs import fill_absent
from .markers_model import GROUPS, UNIT, WOBBLE, Known, Points, Relation, learn, predict, relation
from .moved import beyond_normal
from .segment_frame import ANCHORS, SegmentFrame, segment_frame, unsteadiness, within, without

LEAST_FRAMES = 20  # that show two markers together, before one is a guide to the other
FEWER_FRAMES = 3  # the same, where no other marker was seen with it for longer
TOLD = 10  # frames that show a marker, without which a gap longer than they are stays open
NEAR = 8  # markers about a gap; where one of them goes or comes the gap is taken in parts
SHORTEST_PART = 0.15  # s
ONE_BODY = 0.1  # m; links of markers whose distances change by less make a body: another's are no guides
LEADS = 0.03  # m; guides fewer than a frame's anchors, none of them as steady as this, lead astray
LEAST_UNSTEADY = 1e-5  # m; a marker may be in a file twice, in one place
UNSURE = 0.015  # m; a part less sure than this is looked at from a second frame
STEADY = 12  # anchors of that frame
SHORT = 0.1  # s; a gap shorter than this needs its edges more than it needs teaching
NEEDED = (0.3, 0.55)  # share of a marker's frames that its guides leave to learn from: nearest group, others
LASTS = 0.4  # s; in a shorter gap a marker differs from its neighbours much as it does at the gap's edges
EDGE = 0.2  # s on either side of a gap
RIGID = 0.015  # m; a marker this steady is a guide even if the gap's edges are lost by it
SPREAD, SIMILAR = 220, 100  # frames to learn from: all over the recording, and postures like those in the gap
EXAMPLES = 400  # of the library, those most like the recording
TAUGHT = 150  # of these, for one gap
TUNED, TUNED_EXAMPLES, ROUNDS = 72, 36, 7  # frames, examples and rounds to find the amplitudes
MOVED = 8  # gaps that are moved elsewhere to see how wrong the deviations are
LATER = 1 / 3  # of what is seen of a marker, by which it comes into view later to see the same of ends
LEAST_EXCESS, MOST_EXCESS = 0.5, 10.0  # how much smaller and larger they may become by it
HOPELESS = 0.4  # m; a standard deviation above this is no support: the gap stays open
_EDGE = np.unique(np.round(np.concatenate([np.arange(6), 6 * 1.35 ** np.arange(12)])).astype(np.int64))
_JOINT = np.array([0, 1, 2, 3, 6, 10, 16, 25, 40])


def fill_gaps(
    positions: Floats, fps: float, *, library: MarkerLibrary | None = None, asked: Bools | None = None
) -> Filtered:
    """Fill missing markers; measured samples stay as they are.

    Parameters
    ----------
    positions : (T, M, 3) m, NaN = missing; of the library's markers, in its order and with its `up`.
    fps : Hz.
    library : of clean clips of the same marker set, this or other people; without it the recording teaches itself.
        Markers that are missing throughout need it.
    asked : (T, M) missing samples; gaps without one of them are left open. All are filled if it is None.

    Returns
    -------
    Filtered over markers. std : m per coordinate; of measured samples the noise level, of filled ones that of the
    prediction, scaled by the errors on hidden stretches. A sample stays open where the std is above `HOPELESS`.

    Raises
    ------
    MismatchError : positions or library of another shape, or a rate that is not above 0.

    Source
    ------
    Universal kriging: Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006, section 2.7.
    """
    if positions.ndim != 3 or positions.shape[2] != 3:
        raise MismatchError(f"markers must be (frames, markers, 3), came {positions.shape}")
    check_channels(positions.reshape(len(positions), 3 * positions.shape[1]), fps)
    if library is not None and library.markers != positions.shape[1]:
        raise MismatchError(f"the library knows {library.markers} markers, the recording has {positions.shape[1]}")
    seen: Bools = np.asarray(np.isfinite(positions).all(axis=2))
    std = marker_std(positions, seen)
    if seen.all() or not seen.any():
        return Filtered(positions, std, np.zeros(seen.shape, dtype=bool))
    with threadpool_limits(1, user_api="blas"):  # many small products: threads would wait for each other
        work = _work(positions, seen, fps, library)
        wanted = ~seen if asked is None else ~seen & asked
        for marker in np.flatnonzero(wanted.any(axis=0) & seen.any(axis=0)):
            longest = _longest(work, int(marker))
            for start, stop in runs(~seen[:, marker]):
                if stop - start <= longest and wanted[start:stop, marker].any():
                    _fill_gap(work, int(marker), start, stop)
        _calibrate(work)
        work.places, work.std = hedged(work.places, work.std, positions)
        if library is not None:
            absent = np.flatnonzero(~seen.any(axis=0))
            work.places[:, absent], work.std[:, absent] = fill_absent(work.places, fps, library, absent)
    found = ~seen & (work.std <= HOPELESS) & np.isfinite(work.places).all(axis=2)
    values = np.where(np.isfinite(positions), positions, np.where(found[..., None], work.places, np.nan))
    return Filtered(values, np.where(seen, std, np.where(found, work.std, np.nan)), found)


@dataclass(eq=False)
class _Work:
    """A recording while it is filled."""

    places: Floats  # (T, M, 3), what is known so far
    seen: Bools  # (T, M), measured; those of a marker lie together in memory, for each part of a gap looks through them
    std: Floats  # (T, M), of what was filled
    fps: float
    unsteady: Floats  # (M, M)
    body: Ints  # (M,), alike for markers of one body
    examples: Floats  # (E, M, 3)
    clip: Ints  # (E,)
    tuned: dict[tuple[int, ...], Floats] = field(default_factory=dict)
    last: dict[tuple[int, bool, bool], Floats] = field(default_factory=dict)


def _work(positions: Floats, seen: Bools, fps: float, library: MarkerLibrary | None) -> _Work:
    unsteady = unsteadiness(positions, LEAST_FRAMES)
    examples, clip = np.empty((0, *positions.shape[1:])), np.empty(0, dtype=np.int64)
    if library is not None:
        examples, clip = examples_like(library, positions, EXAMPLES)
        if len(examples):
            taught = unsteadiness(examples, LEAST_FRAMES)
            unsteady = np.where(np.isfinite(unsteady), unsteady, taught)
    lone: Bools = np.asarray(~np.isfinite(unsteady).any(axis=1))
    if lone.any():
        fewer = unsteadiness(positions, FEWER_FRAMES)
        unsteady = np.where(lone[:, None] | lone, fewer, unsteady)
    std = np.full(seen.shape, np.nan)
    body = connected_components(unsteady < ONE_BODY, directed=False)[1].astype(np.int64)
    return _Work(positions.copy(), np.asfortranarray(seen), std, fps, unsteady, body, examples, clip)


def _longest(work: _Work, marker: int) -> int:
    """Frames of the longest gap of a marker that what is known of it can fill: how it goes with the others is not told
    by a few frames, and how sure that is still less."""
    count = int(work.seen[:, marker].sum())
    taught = int(np.isfinite(work.examples[:, marker]).all(axis=1).sum())
    return len(work.seen) if max(count, taught) >= TOLD else count


def _fill_gap(work: _Work, marker: int, start: int, stop: int) -> None:
    unsteady = work.unsteady[marker]
    order = np.argsort(unsteady, kind="stable")
    order = order[np.isfinite(unsteady[order])]
    order = order[np.equal(work.body[order], work.body[marker])]
    near = order[:NEAR]
    parts = _parts_of_gap(work.seen[start:stop, near], max(2, round(SHORTEST_PART * work.fps)))
    worth = np.maximum(unsteady[near], LEAST_UNSTEADY) ** -2.0
    guided = [float(worth[work.seen[start + a : start + b, near].all(axis=0)].sum()) for a, b in parts]
    done = np.zeros(len(work.seen), dtype=bool)
    # the part with the best guides first: it leads the others on
    for part in np.argsort(-np.array(guided), kind="stable"):
        a, b = start + parts[part][0], start + parts[part][1]
        _fill_part(work, marker, order, (start, stop), np.arange(a, b), done)
        done[a:b] = np.isfinite(work.std[a:b, marker])


def _fill_part(work: _Work, marker: int, order: Ints, gap: tuple[int, int], frames: Ints, done: Bools) -> None:
    guides, usable = _guides(work, marker, order, gap, frames, done)
    if 0 < len(guides) < ANCHORS and work.unsteady[marker, guides].min() > LEADS:
        guides, usable = _guides(work, marker, order[:0], gap, frames, done)
    own = np.flatnonzero(usable & work.seen[:, marker])
    if len(own) == 0 and len(work.examples) == 0:
        return
    short = gap[1] - gap[0] < SHORT * work.fps
    guides_known = np.isfinite(work.examples[:, [*guides, marker]]).all(axis=(1, 2))
    examples = (
        np.flatnonzero(guides_known)
        if len(guides) >= 3 and not (short and len(own) >= 3 * LEAST_FRAMES)
        else np.empty(0, dtype=np.int64)
    )
    if len(own) == 0 and len(examples) < LEAST_FRAMES:
        return
    shown = work.places[own[:: max(1, len(own) // 60)]] if len(own) else work.examples[examples]
    anchors = guides[:ANCHORS]
    near = segment_frame(shown, anchors, work.unsteady[marker, anchors])
    task = _Task(gap, frames, own, np.flatnonzero(usable & done), examples, short)
    places, variance = _seen_from(work, _Sight(near, guides, marker), task)
    if np.sqrt(variance.mean()) > UNSURE and len(guides) > ANCHORS:
        # Few of the segment's markers are there: its frame wobbles. That of more of the body does not, but what is
        # sought moves more in it; each counts as far as it is sure.
        body = segment_frame(shown, guides[:STEADY], np.zeros(len(guides[:STEADY])))
        others, doubt = _seen_from(work, _Sight(body, guides, marker), task)
        share = (variance / (variance + doubt))[:, None]
        places, variance = places + share * (others - places), 2.0 * variance * doubt / (variance + doubt)
    work.places[frames, marker] = places
    work.std[frames, marker] = np.sqrt(variance)


@dataclass(frozen=True, eq=False)
class _Task:
    """Part of a gap, and what there is to fill it from."""

    gap: tuple[int, int]
    frames: Ints  # of the part
    own: Ints  # frames that show the marker and its guides
    done: Ints  # frames of the gap filled before, with the guides
    examples: Ints
    short: bool


@dataclass(frozen=True, eq=False)
class _Sight:
    """How a marker is looked at."""

    frame: SegmentFrame
    guides: Ints
    marker: int

    def features(self, positions: Floats) -> tuple[Floats, Floats, Floats]:
        """Features (T, F) of the guides, and place and axes of the frame."""
        place, axes = self.frame.at(positions)
        inside = within(positions[:, self.guides], place, axes) / UNIT
        return inside.reshape(len(positions), 3 * len(self.guides)), place, axes


def _seen_from(work: _Work, sight: _Sight, task: _Task) -> tuple[Floats, Floats]:
    """Places (L, 3) of the marker in the part's frames and the variance (L,) of a coordinate."""
    frames = task.frames
    sought_features, place, axes = sight.features(work.places[frames])
    joint = _those_in(task.done, frames[[0, -1]][:, None] + np.outer([-1, 1], 1 + _JOINT))
    chosen = np.union1d(_teaching(work, sight, task.own, task.gap, sought_features, task.short), joint)
    features, here, here_axes = sight.features(work.places[chosen])
    middle = features.mean(axis=0) if len(chosen) else sought_features.mean(axis=0)
    mine = within(work.places[chosen][:, [sight.marker]], here, here_axes)[:, 0]
    doubt = np.where(work.seen[chosen, sight.marker], 0.0, np.square(np.nan_to_num(work.std[chosen, sight.marker])))
    taught_features, taught_places, clips = _examples(work, sight, task.examples, sought_features)
    wobble = WOBBLE * min(1.0, (task.gap[1] - task.gap[0]) / (LASTS * work.fps))
    known = Known(
        Points(
            np.concatenate([features, taught_features]) - middle,
            np.concatenate([chosen, np.zeros(len(clips), dtype=np.int64)]),
            np.concatenate([np.zeros(len(chosen), dtype=np.int64), clips]),
        ),
        np.concatenate([mine, taught_places]),
        np.concatenate([doubt, np.zeros(len(clips))]),
        wobble,
    )
    how = relation(known.points, len(sight.guides), len(clips) > 0, work.fps)
    amplitudes = _tuned(work, sight, known, how)
    sought = Points(sought_features - middle, frames, np.zeros(len(frames), dtype=np.int64))
    found = predict(amplitudes, known, how, sought)
    places = without(found.mean[:, None], place, axes)[:, 0]
    measured = chosen[work.seen[chosen, sight.marker]]
    return places, found.variance + np.square(_impossible(work, sight, places, frames, measured))


def _impossible(work: _Work, sight: _Sight, places: Floats, frames: Ints, measured: Ints) -> Floats:
    """(L,) m by which distances to the nearest guides are beyond all that were measured: an error no smaller than this.

    A linear relation carried on to postures unlike all learned from does not know of it.
    """
    if len(measured) < LEAST_FRAMES:
        return np.zeros(len(places))
    guides = sight.guides[: GROUPS[0]]
    usual = np.linalg.norm(work.places[measured][:, guides] - work.places[measured, sight.marker][:, None], axis=2)
    here = np.linalg.norm(work.places[frames][:, guides] - places[:, None], axis=2)
    beyond = np.maximum(here - usual.max(axis=0), usual.min(axis=0) - here)
    return np.asarray(np.maximum(beyond, 0.0).max(axis=1, initial=0.0))


def _guides(
    work: _Work, marker: int, order: Ints, gap: tuple[int, int], frames: Ints, done: Bools
) -> tuple[Ints, Bools]:
    """Markers seen in all the frames, steadiest first, and the frames (T,) that show them and the marker.

    A marker that is missing itself where the others show what to learn is a guide only if enough is left: of all
    frames and, unless it is nearly rigid with the marker sought, of those at the gap's edges.
    """
    mine = work.seen[:, marker]
    usable, guides = mine | done, list[int]()
    reach = max(1, round(EDGE * work.fps))
    edges = [slice(max(gap[0] - reach, 0), gap[0]), slice(gap[1], gap[1] + reach)]
    total = before = int(np.count_nonzero(mine))
    for other in order[work.seen[np.ix_(frames, order)].all(axis=0)]:
        rest = usable & work.seen[:, other]
        left = int(np.count_nonzero(rest & mine))
        enough: bool = left >= NEEDED[0 if len(guides) < GROUPS[0] else 1] * total or left >= 0.98 * before
        if work.unsteady[marker, other] > RIGID or len(guides) >= GROUPS[0]:
            enough = enough and all(2 * int((rest & mine)[e].sum()) >= int((usable & mine)[e].sum()) for e in edges)
        if enough and left > 0:
            guides.append(int(other))
            usable, before = rest, left
        if len(guides) == sum(GROUPS):
            break
    return np.array(guides, dtype=np.int64), usable


def _teaching(work: _Work, sight: _Sight, own: Ints, gap: tuple[int, int], sought: Floats, short: bool) -> Ints:
    """Frames of the recording to learn from: all over it, like those sought, and at the gap's edges."""
    if len(own) == 0:
        return own
    many, spread = _thinned(own, 2 * SPREAD), _thinned(own, SPREAD // 3 if short else SPREAD)
    edges = _those_in(own, np.concatenate([gap[0] - 1 - _EDGE, gap[1] + _EDGE]))
    if short or len(many) <= SPREAD:
        return np.union1d(spread, edges)
    similar = many[_similar(sight.features(work.places[many])[0], sought, SIMILAR)]
    return np.union1d(np.union1d(spread, similar), edges)


def _examples(work: _Work, sight: _Sight, examples: Ints, sought: Floats) -> tuple[Floats, Floats, Ints]:
    """Features, places of the marker and clips of the examples most like the frames sought, and of some more."""
    if len(examples) < LEAST_FRAMES:
        return np.empty((0, sought.shape[1])), np.empty((0, 3)), np.empty(0, dtype=np.int64)
    features, place, axes = sight.features(work.examples[examples])
    others = _thinned(np.arange(len(examples)), TAUGHT // 3)
    rows = np.union1d(_similar(features, sought, TAUGHT - len(others)), others)
    places = within(work.examples[examples[rows]][:, [sight.marker]], place[rows], axes[rows])[:, 0]
    return features[rows], places, work.clip[examples[rows]]


def _similar(features: Floats, sought: Floats, count: int) -> Ints:
    """Rows of `features` that are nearest to any of some moments sought, by the first two groups."""
    width = 3 * sum(GROUPS[:2])
    some = sought[np.unique(np.linspace(0, len(sought) - 1, min(len(sought), 12)).astype(np.int64)), :width]
    known = features[:, :width]
    square = np.square(some).sum(axis=1)[:, None] + np.square(known).sum(axis=1) - 2.0 * some @ known.T
    return np.argsort(square.min(axis=0), kind="stable")[:count]


def _tuned(work: _Work, sight: _Sight, known: Known, how: Relation) -> Floats:
    """Amplitudes for these guides: found once for the nearest of them, starting from the marker's last."""
    kind = sight.marker, how.taught, len(sight.frame.anchors) > ANCHORS
    key = (*kind, len(how.groups), *sight.guides[: GROUPS[0]].tolist())
    if key not in work.tuned:
        clip = known.points.clip
        own, taught = np.flatnonzero((clip == 0) & (known.doubt == 0)), np.flatnonzero(clip > 0)
        rows = np.concatenate([_thinned(own, TUNED), _thinned(taught, TUNED_EXAMPLES)])
        amplitudes = learn(known, how, rows, work.last.get(kind), ROUNDS)
        work.tuned[key] = amplitudes
        work.last[kind] = amplitudes / known.spread()
    return work.tuned[key]


def _those_in(rows: Ints, asked: Ints) -> Ints:
    """Those asked for that are among the rows, which rise, each once; a few in many frames are not worth a sort."""
    few = np.unique(asked)
    if not len(rows):
        return rows
    return np.asarray(few[rows[np.minimum(np.searchsorted(rows, few), len(rows) - 1)] == few])


def _thinned(rows: Ints, count: int) -> Ints:
    return rows[np.unique(np.linspace(0, len(rows) - 1, count).astype(np.int64))] if len(rows) else rows


def _calibrate(work: _Work) -> None:
    """Scale what was filled so that on hidden stretches the deviations say what they promise.

    A gap of each marker is moved elsewhere, with the gaps that other markers have at the time, and filled by what the
    rest teaches: amplitudes and all. Where markers come into view or leave it, they do so later or earlier.
    """
    inside = _errors(work, *_moved_gaps(work.seen))
    beyond = [(end, _errors(work, *_moved_ends(work.seen, end))) for end in (0, 1)]
    if inside:
        work.std *= _excess(inside)
    for end, errors in beyond:
        if errors:
            worse = _excess(errors) / (_excess(inside) if inside else 1.0)
            work.std[_beyond(work.seen, end)] *= max(1.0, worse)


def _errors(work: _Work, seen: Bools, moved: list[tuple[int, int, int]]) -> list[Floats]:
    """Errors of what is filled in moved gaps, for each gap, in deviations as they are stated."""
    places = np.where(seen[..., None], work.places, np.nan)
    std, shown = np.full(seen.shape, np.nan), np.asfortranarray(seen)
    trial = replace(work, places=places, seen=shown, std=std, tuned={}, last={})
    errors = []
    for marker, start, stop in moved:
        _fill_gap(trial, marker, start, stop)
        hidden = start + np.flatnonzero(work.seen[start:stop, marker])
        found = (trial.places - work.places)[hidden, marker] / trial.std[hidden, marker, None]
        if len(found := found[np.isfinite(found).all(axis=1)]):  # of what is left nothing may be told
            errors.append(found)
    return errors


def _beyond(seen: Bools, end: int) -> Bools:
    """(T, M) True before each marker's first sample, or at the other `end`, 1, after its last."""
    way = slice(None, None, -1 if end else 1)
    return np.asarray(~np.logical_or.accumulate(seen[way], axis=0)[way])


def _moved_ends(seen: Bools, end: int) -> tuple[Bools, list[tuple[int, int, int]]]:
    """(T, M) what is seen if everybody came into view later, or left earlier, and the gaps at that end.

    What a marker does before it comes into view nothing after it encloses, as gaps inside are enclosed, and there few
    others are in view.
    """
    gaps = _beyond(seen, end)
    lost = gaps.sum(axis=0)
    enters = np.flatnonzero((lost > 0) & (lost < len(seen)))
    if not len(enters):
        return seen, []
    shown = seen[:, enters].sum(axis=0)
    later = int(min(np.median(lost[enters]), np.median(shown) * LATER))
    if later < 1:
        return seen, []
    way = slice(None, None, -1 if end else 1)
    left = seen.copy()
    left[way][later:] &= seen[way][:-later]
    left[way][:later] = False
    moved = []
    for marker in _thinned(_by_what_is_seen(seen, enters), MOVED):
        length = int(min(lost[marker] + later, len(seen)))
        if left[:, marker].any():
            moved.append((int(marker), len(seen) - length if end else 0, len(seen) if end else length))
    return left, moved


def _moved_gaps(seen: Bools) -> tuple[Bools, list[tuple[int, int, int]]]:
    """(T, M) what is seen when gaps are moved elsewhere, and the moved gaps: marker, start, stop."""
    left, moved = seen.copy(), []
    gappy = np.flatnonzero(~seen.all(axis=0) & seen.any(axis=0))
    for turn, marker in enumerate(_thinned(_by_what_is_seen(seen, gappy), MOVED)):
        gaps = sorted(runs(~seen[:, marker]), key=lambda gap: gap[0] - gap[1])
        start, stop = gaps[turn % max(1, min(3, len(gaps)))]
        length = stop - start
        shown = np.concatenate([[0], np.cumsum(seen[:, marker])])
        whole = np.flatnonzero(shown[length:] - shown[:-length] == length)
        if len(whole) == 0:
            continue
        there = int(whole[(len(whole) - 1) * (2 * turn + 1) // (2 * MOVED) % len(whole)])
        left[there : there + length] &= seen[start:stop]
        left[there : there + length, marker] = False
        moved.append((int(marker), there, there + length))
    return left, moved


def _by_what_is_seen(seen: Bools, markers: Ints) -> Ints:
    """Markers (N,) in an order that is not the file's: which gaps are moved where says how sure all are taken to be."""
    return np.array(sorted(markers.tolist(), key=lambda marker: seen[:, marker].tobytes()), dtype=np.int64)


def _excess(errors: list[Floats]) -> float:
    """How far standardised errors of gaps go beyond a standard normal's, by the quantiles 68 and 95 %."""
    size = np.abs(np.concatenate(errors))
    # every gap counts alike, as if it were that many samples of an error that hardly changes along it
    share = np.concatenate([np.full(e.size, 1.0 / e.size) for e in errors if e.size]) / len(errors)
    size = size.ravel()
    order = np.argsort(size)
    variance = beyond_normal(size[order], np.cumsum(share[order]))
    return float(np.clip(np.sqrt(variance), LEAST_EXCESS, MOST_EXCESS))


def _parts_of_gap(visible: Bools, least: int) -> list[tuple[int, int]]:
    """(start, stop) of the parts of a gap (L, K) in which the same markers are seen; short ones join a neighbour."""
    changes = np.flatnonzero((visible[1:] != visible[:-1]).any(axis=1)) + 1
    edges = [0, *changes.tolist(), len(visible)]

    def lost(edge: int) -> int:
        """Marker frames given up when the parts on both sides of an inner edge become one."""
        a, b, c = edges[edge - 1 : edge + 2]
        together = int(visible[a:c].all(axis=0).sum()) * (c - a)
        return int(visible[a:b].all(axis=0).sum()) * (b - a) + int(visible[b:c].all(axis=0).sum()) * (c - b) - together

    while len(edges) > 2:
        shortest = int(np.argmin(np.diff(edges)))
        if edges[shortest + 1] - edges[shortest] >= least:
            break
        del edges[min((e for e in (shortest, shortest + 1) if 0 < e < len(edges) - 1), key=lost)]
    return list(pairwise(edges))
