"""Markers missing from the first frame to the last: what a library's bodies do with them in such postures.

Five predictions from the visible markers are mixed: ridge regressions and Gaussian processes, in a frame that turns
with the body's heading and in one that turns with the markers nearest to the missing ones, some with what came
shortly before and after. The regressions err less on strangers, the processes on people and motions the library knows.
How far the recording's proportions are from those of the library is an error of the regressions' inputs. How much each
prediction counts, and how wrong the mixture is, is found on clips of the library that are predicted from the others;
if the library does not know the person, on people that are predicted from the others, all made as large as the person.
"""

from dataclasses import dataclass, replace

import numpy as np

from ...arrays import Bools, Floats, Ints
from ...errors import MismatchError
from ...numerics.kriging import krige, left_out, likeliest_amplitudes, squared_distances
from ..channels.cloud import distance_change, fit_anchors, learn_anchors
from ..channels.pieces import middle_frames
from ..channels.travel import turn
from ..library.likeness import Likeness, likeness
from ..library.markers import OFFSETS, MarkerLibrary, at_offset
from .segment_frame import SegmentFrame, segment_frame, unsteadiness, within, without

LEAST_EXAMPLES, LEAST_SEEN = 40, 3
ANCHORS = 6
COMPONENTS = {"now": 20, "window": 30}
TUNED, ROUNDS = 300, 40
HERTZ = 30.0  # limbs are predicted at this rate and drawn through
FOLDS = 5
PIECES = 8  # parts of the library that are predicted from the others, if it has fewer clips
RIDGES = 10.0 ** np.arange(-4.0, 2.6, 0.5)
UNKNOWN_MEAN = 100.0  # variances
EVERY, NOW = slice(None), slice(OFFSETS.index(0.0), OFFSETS.index(0.0) + 1)  # of a window
ASKED = 4  # markers that are hidden, in `ASKED_SECONDS` of a recording, where a library shows one person alone
ASKED_SECONDS = 4.0
EQUAL = 0.2  # of the mean squared error: the strength by which shares are drawn to equal ones


def fill_absent(
    positions: Floats, fps: float, library: MarkerLibrary, absent: Ints, *, asked: bool = True
) -> tuple[Floats, Floats]:
    """Predict markers that are missing throughout.

    Parameters
    ----------
    positions : (T, M, 3) m; the library's markers, axes and order, gaps of the others filled.
    fps : Hz.
    library : to learn from.
    absent : (A,) markers.
    asked : a library of one person alone tells nothing of how people differ: markers that are seen are asked then.

    Returns
    -------
    (T, A, 3) m and (T, A) standard deviation of a coordinate; NaN where the library or the recording shows too little.
    """
    nothing = np.full((len(positions), len(absent), 3), np.nan), np.full((len(positions), len(absent)), np.nan)
    seen = np.asarray(np.isfinite(positions).all(axis=2))
    examples = np.asarray(library.windows, dtype=np.float64)
    known: Bools = np.asarray(np.isfinite(examples).all(axis=3))
    visible = np.flatnonzero((seen.mean(axis=0) > 0.5) & (known.mean(axis=(0, 1)) > 0.5))
    now = OFFSETS.index(0.0)
    wanted: Bools = np.asarray(known[:, now][:, absent].all(axis=1))
    visible = _most_known(known[wanted], visible)
    usable: Bools = np.asarray(known[:, :, visible].all(axis=(1, 2)) & wanted)
    if len(absent) == 0 or len(visible) < LEAST_SEEN or usable.sum() < LEAST_EXAMPLES:
        return nothing
    piece = _pieces(library.clip[usable], library.time[usable])
    frames = np.flatnonzero(seen[:, visible].all(axis=1))
    if len(frames) == 0 or len(np.unique(piece)) < 2:
        return nothing
    whole = _drawn_through(positions[:, visible], frames)
    step = max(1, round(fps / HERTZ))
    moments = np.stack([at_offset(whole, fps, offset)[::step] for offset in OFFSETS], axis=1)
    examples, numbers = examples[usable], np.unique(piece)
    who = likeness(positions[frames][:, visible], [examples[piece == one, now][:, visible] for one in numbers])
    if who.stranger:  # the library's people made as large as the recording's
        examples = examples * who.larger[np.searchsorted(numbers, piece)][:, None, None, None]
    try:
        views = _views(examples, visible, absent, piece, library.up)
    except MismatchError:  # no three markers are ever seen together
        return nothing
    taught = _Taught(examples[:, :, visible], examples[:, now][:, absent], piece, piece)
    mixed, doubt = _mixture(views, moments, taught, who)
    at = np.arange(len(positions)) / step
    rows = np.arange(len(mixed))
    flat = mixed.reshape(len(mixed), -1)
    drawn = np.stack([np.interp(at, rows, column) for column in flat.T], axis=1).reshape(len(at), len(absent), 3)
    spread = np.stack([np.interp(at, rows, column) for column in doubt.T], axis=1)
    if asked and (who.persons == 1 or len(np.unique(library.clip[usable])) == 1):
        spread *= _beyond(positions, fps, library, _as_unsteady(examples[:, now], visible, absent))
    return drawn, spread


def _as_unsteady(postures: Floats, visible: Ints, absent: Ints) -> Ints:
    """Visible markers that keep their distances from those about them as ill as the absent ones do, the likest few."""
    among = unsteadiness(postures, LEAST_EXAMPLES // 2)[:, visible]
    least = np.log(np.sort(among, axis=1)[:, :ANCHORS].mean(axis=1))
    return visible[np.argsort(np.abs(least[visible] - least[absent].mean()), kind="stable")[:ASKED]]


def _beyond(positions: Floats, fps: float, library: MarkerLibrary, markers: Ints) -> float:
    """How many times as far off as stated some visible markers come out when they are hidden; not below 1."""
    some = middle_frames(len(positions), round(ASKED_SECONDS * fps))
    beyond = [1.0]
    for marker in markers:
        without_it = positions[some].copy()
        without_it[:, marker] = np.nan
        found, told = fill_absent(without_it, fps, library, np.array([marker]), asked=False)
        off = np.square(found[:, 0] - positions[some, marker]).mean(axis=1) / np.square(told[:, 0])
        if np.isfinite(off).any():
            beyond.append(float(np.sqrt(np.nanmean(off))))
    return max(1.0, float(np.mean(beyond)))


def _most_known(known: Bools, visible: Ints) -> Ints:
    """The visible markers that, with the examples (E, W, M) that show them all, make the largest table without gaps.

    A few that were often lost while the library was recorded would take nearly every example with them. Tables of too
    few markers or examples to learn from are passed over.
    """
    whole: Bools = np.asarray(known[:, :, visible].all(axis=1))
    order = np.argsort(-whole.sum(axis=0), kind="stable")
    examples = np.logical_and.accumulate(whole[:, order], axis=1).sum(axis=0)
    markers = np.arange(1, len(order) + 1)
    size = np.where((markers >= LEAST_SEEN) & (examples >= LEAST_EXAMPLES), examples * markers, 0)
    most = len(size) - int(np.argmax(size[::-1])) if len(size) else 0
    return np.sort(visible[order[:most]])


@dataclass(frozen=True, eq=False)
class _Views:
    """Two frames to look at a body from, both found from the visible markers alone."""

    segment: SegmentFrame
    anchors: Ints
    template: Floats
    up: Floats

    def of(self, visible: Floats, name: str) -> tuple[Floats, Floats]:
        """Place (N, 3) and axes (N, 3, 3) for visible markers (N, V, 3)."""
        if name == "segment":
            return self.segment.at(visible)
        place, heading = fit_anchors(visible[:, self.anchors], self.template, self.up)
        return place, turn(heading, self.up)

    def features(self, moments: Floats, name: str) -> Floats:
        """(N, W, F) visible markers (N, W, V, 3) at every moment, seen from the frame of that moment."""
        flat = moments.reshape(-1, *moments.shape[2:])
        return within(flat, *self.of(flat, name)).reshape(*moments.shape[:2], -1)


def _views(examples: Floats, visible: Ints, absent: Ints, piece: Ints, up: Floats) -> _Views:
    postures = examples[:, OFFSETS.index(0.0)]
    unsteady = unsteadiness(postures, LEAST_EXAMPLES // 2)[np.ix_(absent, visible)].mean(axis=0)
    anchors = np.argsort(unsteady, kind="stable")[: min(ANCHORS, len(visible))]
    segment = segment_frame(postures[:, visible], anchors, unsteady[anchors])
    frames = postures[:, visible]
    rigid = learn_anchors([distance_change(frames[piece == one]) for one in np.unique(piece)], frames, up)
    return _Views(segment, rigid.indices, rigid.template, up)


@dataclass(frozen=True, eq=False)
class _Taught:
    """Examples: visible markers (E, W, V, 3), those sought (E, A, 3), and whose they are."""

    visible: Floats
    wanted: Floats
    piece: Ints  # (E,) parts of the library that stand for another recording
    party: Ints  # (E,) parts that stand for another recording as unlike as this one


@dataclass(frozen=True, eq=False)
class _Guess:
    """One way's prediction, in the world's axes.

    Attributes
    ----------
    places : (N, A, 3).
    missed : (C, A, 3) errors on chosen examples left out.
    strange : (N,) how far the variance is above that of those.
    """

    places: Floats
    missed: Floats
    strange: Floats


def _mixture(views: _Views, moments: Floats, taught: _Taught, who: Likeness) -> tuple[Floats, Floats]:
    """Mixed prediction (N, A, 3) and deviation (N, A) at moments (N, W, V, 3)."""
    if who.stranger and who.persons > 1:
        _, number = np.unique(taught.piece, return_inverse=True)
        taught = replace(taught, party=who.person[number])
    chosen = np.unique(np.linspace(0, len(taught.wanted) - 1, min(TUNED, len(taught.wanted))).astype(np.int64))
    guesses = [
        *_guesses(views, "heading", (EVERY, NOW), moments, taught, who.unlike, chosen),
        *_guesses(views, "segment", (NOW,), moments, taught, who.unlike, chosen),
    ]
    # every party counts alike, however many of its examples there are
    party = taught.party[chosen]
    weight = 1.0 / np.sqrt(np.bincount(party)[party])[:, None, None]
    shares = _shares(np.array([(g.missed * weight).ravel() for g in guesses]))
    mixed = np.tensordot(shares, np.array([g.places for g in guesses]), 1)
    missed = np.tensordot(shares, np.array([g.missed for g in guesses]), 1) * weight
    strange = np.median([g.strange for g in guesses], axis=0)
    usual = np.sqrt(np.square(missed).mean(axis=2).sum(axis=0) / np.square(weight).sum())
    return mixed, usual * np.sqrt(strange)[:, None]


def _guesses(
    views: _Views, name: str, looks: tuple[slice, ...], moments: Floats, taught: _Taught, unlike: float, chosen: Ints
) -> list[_Guess]:
    """Ridge regressions that look at these moments of the window, and a process, in one kind of frame."""
    now = OFFSETS.index(0.0)
    place, axes = views.of(taught.visible[:, now], name)
    target = within(taught.wanted, place, axes).reshape(len(taught.wanted), -1)
    known, sought = views.features(taught.visible, name), views.features(moments, name)
    back = views.of(moments[:, now], name)

    def guess(inside: Floats, missed: Floats, strange: Floats) -> _Guess:
        places = without(inside.reshape(len(inside), -1, 3), *back)
        return _Guess(places, missed.reshape(len(missed), -1, 3) @ axes[chosen].transpose(0, 2, 1), strange)

    # a body of other proportions has a marker elsewhere, the more so the farther it is from the frame's place
    away = np.sqrt(np.square(known[:, now].reshape(len(known), -1, 3)).sum(axis=2).mean(axis=0))
    doubt = unlike * np.repeat(away, 3)
    found = []
    for look in looks:
        features, here = known[:, look].reshape(len(known), -1), sought[:, look].reshape(len(sought), -1)
        ridge = _ridge(features, target, taught, np.tile(doubt, features.shape[1] // len(doubt)))
        found.append(guess(ridge.predict(here), (ridge.held_out - target)[chosen], ridge.strange(here)))
    process = _process(known, target, taught, chosen)
    inside, variance = process.predict(sought)
    return [*found, guess(inside, process.held_out - target[chosen], variance / process.usual)]


def _shares(missed: Floats) -> Floats:
    """(G,) shares, not below 0, of predictions with errors (G, N): those of the least error, drawn to equal ones.

    Source
    ------
    Breiman, Stacked regressions, Machine Learning 24, 1996.
    """
    square = missed @ missed.T
    square = square + np.eye(len(square)) * max(EQUAL * float(np.trace(square)) / len(square), 1e-30)
    kept = np.arange(len(square))
    while True:
        found = np.linalg.solve(square[np.ix_(kept, kept)], np.ones(len(kept)))
        found = found / found.sum()
        if (found >= 0).all():
            break
        kept = np.delete(kept, int(np.argmin(found)))
    shares = np.zeros(len(square))
    shares[kept] = found
    return shares


@dataclass(frozen=True, eq=False)
class _Ridge:
    mean: Floats
    scale: Floats
    matrix: Floats
    middle: Floats
    root: Floats  # (F, F) half the inverse covariance of the features
    usual: float  # mean squared distance from the mean, of examples from those of other parties
    held_out: Floats  # (E, D) predictions of examples from other parties

    def predict(self, features: Floats) -> Floats:
        return np.asarray((features - self.mean) / self.scale @ self.matrix + self.middle)

    def strange(self, features: Floats) -> Floats:
        """(N,) how far the squared distance from the examples is above that of other parties."""
        away = np.square((features - self.mean) / self.scale @ self.root).sum(axis=1)
        return np.asarray(np.maximum(away / self.usual, 1.0))


def _ridge(features: Floats, target: Floats, taught: _Taught, doubt: Floats) -> _Ridge:
    """Ridge regression with the penalty that predicts pieces of the library best from the others.

    `doubt` (F,) is the deviation of the recording's features from what they would be on a body of the library: errors
    in the variables, which the covariance of the features gets in addition.

    Source
    ------
    Fuller, Measurement Error Models, 1987, section 1.1.
    """
    mean, scale = features.mean(axis=0), features.std(axis=0) + 1e-4
    normal, noise = (features - mean) / scale, np.square(doubt / scale)
    held_out = np.empty((len(RIDGES), *target.shape))
    by_piece = [(out, _solved(normal[~out], target[~out], noise, RIDGES)) for out in _folds(taught.piece)]
    for out, solved in by_piece:
        for row, (matrix, middle, _) in enumerate(solved):
            held_out[row, out] = normal[out] @ matrix + middle
    best = int(np.argmin(np.square(held_out - target).mean(axis=(1, 2))))
    if np.array_equal(taught.party, taught.piece):
        by_party = [(out, solved[best]) for out, solved in by_piece]
    else:
        parties = _folds(taught.party)
        by_party = [(out, _solved(normal[~out], target[~out], noise, RIDGES[[best]])[0]) for out in parties]
    missed, away = held_out[best], np.ones(len(target))
    for out, (matrix, middle, root) in by_party:
        missed[out] = normal[out] @ matrix + middle
        away[out] = np.square((normal[out] - normal[~out].mean(axis=0)) @ root).sum(axis=1)
    ((matrix, middle, root),) = _solved(normal, target, noise, RIDGES[[best]])
    return _Ridge(mean, scale, matrix, middle, root, float(away.mean()), missed)


def _folds(piece: Ints) -> list[Bools]:
    numbers = np.unique(piece)
    return [np.isin(piece, fold) for fold in np.array_split(numbers, min(FOLDS, len(numbers)))]


def _solved(normal: Floats, target: Floats, noise: Floats, ridges: Floats) -> list[tuple[Floats, Floats, Floats]]:
    """Matrix, constant and root of the inverse covariance for each penalty, a share of the number of examples."""
    centre, middle = normal.mean(axis=0), target.mean(axis=0)
    centred = normal - centre
    values, vectors = np.linalg.eigh(centred.T @ centred + np.diag(len(normal) * noise))
    known = vectors.T @ (centred.T @ (target - middle))
    found = []
    for ridge in ridges:
        stiff = (np.maximum(values, 0.0) + ridge * len(normal))[:, None]
        matrix = vectors @ (known / stiff)
        found.append((matrix, middle - centre @ matrix, vectors * np.sqrt(len(normal) / stiff[:, 0])))
    return found


@dataclass(frozen=True, eq=False)
class _Process:
    """A Gaussian process over principal components of the posture now and of the whole window."""

    bases: tuple[tuple[Floats, Floats], ...]
    reach: tuple[float, ...]
    amplitudes: Floats
    known: tuple[Floats, ...]
    piece: Ints
    values: Floats
    middle: Floats
    base: float
    held_out: Floats  # (chosen, D) predictions from other parties
    usual: float  # their mean variance

    def predict(self, features: Floats) -> tuple[Floats, Floats]:
        """Mean (N, D) and variance (N,)."""
        sought = _scores(features, self.bases)
        strangers = np.full(len(features), -1)
        parts = _parts(sought, self.known, strangers, self.piece, self.reach)
        cross = _summed(self.amplitudes, parts) + self.base
        cov = _summed(self.amplitudes, _parts(self.known, self.known, self.piece, self.piece, self.reach)) + self.base
        cov[np.diag_indices(len(cov))] += self.amplitudes[-1]
        prior = np.full(len(features), self.base + self.amplitudes[-1] + self.amplitudes[-2])
        for k, (score, reach) in enumerate(zip(sought, self.reach, strict=True)):
            linear, near, nearer, own, own_near = self.amplitudes[5 * k : 5 * k + 5]
            prior += (linear + own) * np.square(score).sum(axis=1) / reach**2 + near + nearer + own_near
        found = krige(cov, cross, prior, self.values)
        return found.mean + self.middle, found.variance


def _process(features: Floats, target: Floats, taught: _Taught, chosen: Ints) -> _Process:
    # what clips of one person have in common is no more to be expected of a stranger for being seen often
    piece, party = taught.party, taught.party[chosen]
    now = features[:, OFFSETS.index(0.0)]
    bases = (
        _whitened(now, COMPONENTS["now"]),
        _whitened(features.reshape(len(features), -1), COMPONENTS["window"]),
    )
    known = _scores(features, bases)
    reach = tuple(max(float(np.sqrt(np.median(squared_distances(k[::4], k[::4])))), 1e-6) for k in known)
    middle = target.mean(axis=0)
    values = target - middle
    spread = max(float(np.square(values).mean()), 1e-8)
    some = tuple(k[chosen] for k in known)
    parts = np.array([*_parts(some, some, piece[chosen], piece[chosen], reach), np.eye(len(chosen))])
    share = np.maximum(np.trace(parts, axis1=1, axis2=2) / len(chosen), 1e-6)
    base = UNKNOWN_MEAN * spread
    amplitudes = likeliest_amplitudes(
        parts, np.full(parts.shape[1:], base), values[chosen], 0.2 * spread / share, ROUNDS
    )
    cov = np.tensordot(amplitudes, parts, 1) + base
    groups = [np.flatnonzero(party == number) for number in np.unique(party)]
    out = left_out(cov, values[chosen], groups)
    usual = float(out.variance.mean())
    return _Process(bases, reach, amplitudes, known, piece, values, middle, base, out.mean + middle, usual)


def _whitened(features: Floats, count: int) -> tuple[Floats, Floats]:
    """Mean and (F, K) basis of principal components, the weaker ones raised half-way to the strongest."""
    mean = features.mean(axis=0)
    _, size, vectors = np.linalg.svd(features - mean, full_matrices=False)
    kept = size[:count] > 1e-6 * max(float(size[0]), 1e-30)
    size, vectors = size[:count][kept], vectors[:count][kept]
    return mean, np.asarray(vectors.T / np.sqrt(size / size[:1]))


def _scores(features: Floats, bases: tuple[tuple[Floats, Floats], ...]) -> tuple[Floats, ...]:
    now = features[:, OFFSETS.index(0.0)]
    shapes = (now, features.reshape(len(features), -1))
    return tuple((f - mean) @ basis for f, (mean, basis) in zip(shapes, bases, strict=True))


def _parts(
    one: tuple[Floats, ...], other: tuple[Floats, ...], piece: Ints, other_piece: Ints, reach: tuple[float, ...]
) -> list[Floats]:
    """Components but noise: of each kind of score linear, near, nearer, and two within a piece; a piece's constant."""
    same = (piece[:, None] == other_piece).astype(float)
    found = []
    for x, y, scale in zip(one, other, reach, strict=True):
        linear = x @ y.T / scale**2
        away = squared_distances(x, y) / scale**2
        near = np.exp(-0.5 * away)
        found += [linear, near, np.exp(-0.5 * away / 0.16), linear * same, near * same]
    return [*found, same]


def _summed(amplitudes: Floats, parts: list[Floats]) -> Floats:
    return np.asarray(sum(a * part for a, part in zip(amplitudes, parts, strict=False)))


def _pieces(clip: Ints, time: Floats) -> Ints:
    """Numbers of the parts of a library that stand for another recording: its clips, cut up if they are few."""
    clips = np.unique(clip)
    if len(clips) >= FOLDS:
        return clip
    cuts = -(-PIECES // len(clips))
    piece = np.zeros(len(clip), dtype=np.int64)
    for number, one in enumerate(clips):
        rows = np.flatnonzero(clip == one)
        place = np.argsort(np.argsort(time[rows], kind="stable"), kind="stable")
        piece[rows] = cuts * number + place * cuts // len(rows)
    return piece


def _drawn_through(places: Floats, frames: Ints) -> Floats:
    """Places (T, V, 3) with the frames that lack some drawn straight through from those that do not."""
    if len(frames) == len(places):
        return places
    at = np.arange(len(places))
    flat = places.reshape(len(places), -1)
    return np.stack([np.interp(at, frames, column[frames]) for column in flat.T], axis=1).reshape(places.shape)
