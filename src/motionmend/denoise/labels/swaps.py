"""Find markers that bear each other's labels, and give the labels back, or say so."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ...arrays import Bools, Floats, Ints
from ...errors import MismatchError
from ..channels.pieces import pieces
from .evidence import (
    Continuity,
    Ends,
    MarkerDistances,
    learn_distances,
    line_ends,
    measure_continuity,
    measure_distances,
    mismatch,
    pair_evidence,
    suspicious_pairs,
)
from .path import Stretch, swapped_stretches

__all__ = ["MarkerDistances", "Swap", "find_swaps", "learn_distances", "put_right"]

SURE = float(np.log(1000.0))  # log odds from which a swap is put right
MOST = 1 / 2  # share of the recording above which nothing but a reference says which part bears the wrong labels,
MOST_AT_END = 1 / 3  # and of a swap that lasts to the recording's first or last frame (none that lasts to both)
_BREAK = -6.0  # log of what an error takes from a step's density: beyond it the step may be a change of labels
_ROUGH = -9.0  # log of the same beyond which another marker does not go on there at all: a spike, not a swap
_BETTER = 3.0  # log of how much better another marker must go on to be tried,
_BETTER_ACROSS_GAP = 6.0  # and where the step, though not smooth, is no worse than its gap allows
_WORSE = -5.0  # and at least, for the labels to change hands there
_RIVALS = 3  # markers tried for each break
_NEARBY = 0.5  # s, within which the other marker must have been seen
_LOOK = 0.1  # s between the frames whose distances are looked at
_SUSPICION = 6.0  # log odds of one frame, and
_LASTS = 3  # frames looked at in a row that make two markers suspicious
_HINT = 0.1  # of the distances' odds when others may be wrong too: tells inside from outside where nothing else does
_SHORTEST = 3  # frames below which two spikes look like a swap, which is then only declared
_TRIED = 4  # pairs tried in a round, times the number of markers: spikes without end propose any
_ROUNDS = 5  # a cycle of three takes two, a recording full of swaps some more
_BLOCK = 256  # frames or breaks compared at a time, to bound the memory
_AT_ONCE = 1 << 18  # steps looked at, likewise


@dataclass(frozen=True)
class Swap:
    """Markers that bear each other's labels for a while.

    Attributes
    ----------
    markers : indices; what belongs to markers[k] stands under markers[k + 1], the last one's under the first.
    first, last : frames, both included.
    log_odds : natural logarithm of the posterior odds of the swap.
    put_right : whether `put_right` gives the labels back; else the swap is only declared.
    """

    markers: tuple[int, ...]
    first: int
    last: int
    log_odds: float
    put_right: bool


def put_right(positions: Floats, swaps: Iterable[Swap]) -> Floats:
    """Positions (T, M, 3) with the labels given back, swap after swap in the order given; declared ones stay."""
    corrected = positions.copy()
    for swap in swaps:
        if swap.put_right:
            _exchange(corrected, swap)
    return corrected


def find_swaps(positions: Floats, fps: float, *, reference: MarkerDistances | None = None) -> tuple[Swap, ...]:
    """Find markers that bear each other's labels.

    Two things speak for a swap. Continuity: both tracks break at one frame, or across gaps, and each goes on under the
    other's label. Distances: the markers keep the distances to their neighbours that belong to the other label. Steps
    that break and frames whose distances are odd propose pairs of markers; for each pair the likeliest path of labels
    over the whole recording is found, and swaps with odds above 1000 : 1 are put right, those below are declared.
    Limbs are swaps of many pairs: each pair is judged with the others put right as continuity alone would have it.

    Parameters
    ----------
    positions : (T, M, 3) m, NaN = missing.
    fps : Hz.
    reference : distances of the marker set from clean clips (`learn_distances`). Without it the recording's own medians
        serve; a marker swapped for more than half of the recording (a third, if to its first or last frame) is then
        only declared, and one swapped throughout cannot be found.

    Returns
    -------
    Swaps in the order in which `put_right` applies them, declared ones last.

    Raises
    ------
    MismatchError : positions or the reference are of another shape, or the rate is not above 0.
    """
    if positions.ndim != 3 or positions.shape[2] != 3:
        raise MismatchError(f"markers must be (frames, markers, 3), came {positions.shape}")
    if not (np.isfinite(fps) and fps > 0):
        raise MismatchError(f"a recording needs a frame rate above 0 Hz, came {fps}")
    if len(positions) < 4 or positions.shape[1] < 2:
        return ()
    seen: Bools = np.asarray(np.isfinite(positions).all(axis=2))
    current = np.where(seen[:, :, None], positions, np.nan)
    continuity = measure_continuity(current, fps)
    put, declared = list[Swap](), list[Swap]()
    for turn in range(_ROUNDS):
        judge = reference.fitted(current) if reference is not None and turn == 0 else None
        found, current = _one_round(current, fps, continuity, judge, reference is not None)
        put += [s for s in found if s.put_right]
        declared = [s for s in found if not s.put_right]
        if len(declared) == len(found) and not (reference is not None and turn == 0 and declared):
            break
    return (*_cycles(put), *declared)


def _one_round(
    current: Floats, fps: float, continuity: Continuity, reference: MarkerDistances | None, sided: bool
) -> tuple[list[Swap], Floats]:
    """Propose, try and judge pairs once: what was found, and the positions with what is put right."""
    seen = np.isfinite(current[:, :, 0])
    steps = _steps(current, seen, continuity)
    gains, together = _proposals(steps, fps)
    known = reference or measure_distances([current])
    for pair in _odd_pairs(current, known, fps):
        gains.setdefault(pair, 0.0)
    if not gains:
        return [], current
    pairs = sorted(gains, key=lambda p: (-gains[p], p))[: _TRIED * seen.shape[1]]
    cuts = {pair: dict.fromkeys(_cuts(steps, seen, pair, fps), 1) for pair in pairs}
    for frames in cuts.values():
        frames.update({f: together[f] for f in frames if f in together})
    tentative = current.copy()
    for pair in pairs:
        if gains[pair] > 0.0:  # what only distances propose may be due to the others and waits for them
            hint = _HINT * pair_evidence(tentative, known, pair)
            for stretch in swapped_stretches(tentative[:, pair], cuts[pair], hint, continuity, fps):
                _exchange(tentative, Swap(pair, stretch.first, stretch.last, stretch.log_odds, True))
    known = reference or measure_distances([tentative])
    current, found = current.copy(), list[Swap]()
    waiting = {pair: _verdict(pair, current, tentative, known, cuts[pair], continuity, fps, sided) for pair in pairs}
    while True:
        # The surest first: what is put right speaks for or against the others.
        waiting = {pair: swaps for pair, swaps in waiting.items() if swaps}
        surest = max(waiting, key=lambda p: sum(s.log_odds for s in waiting[p] if s.put_right), default=None)
        if surest is None or not any(s.put_right for s in waiting[surest]):
            break
        for swap in waiting.pop(surest):
            found.append(swap)
            if swap.put_right:
                _exchange(current, swap)
        tentative[:, surest] = current[:, surest]
        waiting = {
            pair: _verdict(pair, current, tentative, known, cuts[pair], continuity, fps, sided) for pair in waiting
        }
    return [*found, *(swap for swaps in waiting.values() for swap in swaps)], current


def _verdict(
    pair: tuple[int, int],
    current: Floats,
    tentative: Floats,
    known: MarkerDistances,
    cuts: dict[int, int],
    continuity: Continuity,
    fps: float,
    sided: bool,
) -> list[Swap]:
    """The swaps of one pair as recorded, by all evidence, the others being as they were tried."""
    judged = tentative.copy()
    judged[:, pair] = current[:, pair]
    evidence = pair_evidence(judged, known, pair)
    stretches = swapped_stretches(judged[:, pair], cuts, evidence, continuity, fps, sided=sided)
    seen: Bools = np.asarray(np.isfinite(current[:, :, 0]))
    return [_swap(pair, stretch, stretches, seen, evidence, sided) for stretch in stretches]


def _swap(
    pair: tuple[int, int], stretch: Stretch, all_of_pair: list[Stretch], seen: Bools, evidence: Floats, sided: bool
) -> Swap:
    shown: Bools = np.asarray(seen[:, pair].any(axis=1))
    swapped = sum(int(shown[s.first : s.last + 1].sum()) for s in all_of_pair)
    frames = np.flatnonzero(shown)
    ends = int(all_of_pair[0].first <= frames[0]) + int(all_of_pair[-1].last >= frames[-1])
    known = sided or swapped <= (MOST, MOST_AT_END, 0.0)[ends] * len(frames)
    known = known and stretch.last - stretch.first + 1 >= _SHORTEST
    log_odds = stretch.log_odds
    if swapped == len(frames):
        # Where markers were put is the same in every frame: however many there are, they are one observation.
        log_odds = min(log_odds, float(np.median(evidence[frames])))
    return Swap(pair, stretch.first, stretch.last, log_odds, bool(known and log_odds >= SURE))


def _exchange(positions: Floats, swap: Swap) -> None:
    """Give the labels of one swap back, in place."""
    frames = slice(swap.first, swap.last + 1)
    owners = list(swap.markers)
    positions[frames, owners] = positions[frames, owners[1:] + owners[:1]]


@dataclass(frozen=True, eq=False)
class _Steps:
    """Steps that do not go on smoothly or lead across a gap, and what is needed to try other markers there."""

    marker: Ints  # (B,)
    before: Ints  # (B,) frame last seen
    after: Ints  # (B,) frame seen again
    density: Floats  # (B,) log density of the step
    reach: Floats  # (B,) m, how wrong it may be
    broken: Bools  # (B,) whether it is not smooth
    last: Ints  # (T, M) frame at or before, in which the marker was seen, -1 = never
    following: Ints  # (T, M) frame at or after, T = never
    left: Ends  # (T * M)
    right: Ends
    continuity: Continuity


def _steps(positions: Floats, seen: Bools, continuity: Continuity) -> _Steps:
    frames, markers = seen.shape
    number = np.arange(frames)[:, None]
    last = np.maximum.accumulate(np.where(seen, number, -1), axis=0)
    following = np.minimum.accumulate(np.where(seen, number, frames)[::-1], axis=0)[::-1]
    left, right = line_ends(positions, continuity.window)
    after, marker = np.nonzero(seen[1:] & (last[:-1] >= 0))
    before = last[after, marker]
    after = after + 1
    parts = []
    for some in pieces(len(marker), _AT_ONCE):  # of a long recording hardly a step is kept
        a, b = left.at(before[some] * markers + marker[some]), right.at(after[some] * markers + marker[some])
        length = after[some] - before[some]
        density, lost = continuity.log_density(a, b, length)
        kept = np.flatnonzero((lost < _BREAK) | (length > 1))
        error, way = mismatch(a.at(kept), b.at(kept), length[kept])
        parts.append((some.start + kept, density[kept], error + way, lost[kept] < _BREAK))
    rows, density, reach, broken = (np.concatenate(column) for column in zip(*parts, strict=True))
    return _Steps(
        marker[rows], before[rows], after[rows], density, reach, broken, last, following, left, right, continuity
    )


def _gains(steps: _Steps, rows: Ints, fps: float) -> Floats:
    """(R, M) by how much another marker goes on better where these steps lead, or from where they come; -inf = none."""
    frames, markers = steps.last.shape
    marker, before, after = steps.marker[rows, None], steps.before[rows, None], steps.after[rows, None]
    others = np.arange(markers)[None]
    gain = np.full((len(rows), markers), -np.inf)
    longest = max(1, round(_NEARBY * fps)) + after - before
    into = steps.last[after[:, 0] - 1], others, after, marker
    out = before, marker, steps.following[before[:, 0] + 1], others
    for from_frame, from_marker, to_frame, to_marker in (into, out):
        took = to_frame - from_frame
        usable = (from_frame >= 0) & (to_frame < frames) & (took <= longest) & (others != marker)
        left = np.broadcast_to(from_frame * markers + from_marker, gain.shape)
        right = np.broadcast_to(to_frame * markers + to_marker, gain.shape)
        # Only a marker about as far away as the step is wrong can be what is sought.
        row, column = np.nonzero(usable)
        way = np.square(steps.right.place[right[row, column]] - steps.left.place[left[row, column]]).sum(axis=1)
        near = way < np.square(
            2.0 * steps.reach[rows[row]] * np.maximum(took[row, column] / (after - before)[row, 0], 1.0)
        )
        row, column = row[near], column[near]
        a, b = steps.left.at(left[row, column]), steps.right.at(right[row, column])
        length = took[row, column]
        # A swap of few frames bends the lines fitted across its other end: places alone may tell more.
        fits = np.full(len(length), -np.inf)
        for ends in ((a, b), (a.still(), b.still())):
            density, lost = steps.continuity.log_density(*ends, length)
            fits = np.maximum(fits, np.where(lost > _ROUGH, density, -np.inf))
        gain[row, column] = np.maximum(gain[row, column], fits)
    return gain - steps.density[rows, None]


def _proposals(steps: _Steps, fps: float) -> tuple[dict[tuple[int, int], float], Counter[int]]:
    """Pairs of markers of which one goes on where the other breaks, and how much better; and at each frame how many
    pairs each go on best under the other's label."""
    gains: dict[tuple[int, int], float] = {}
    favourites: dict[tuple[int, int], int] = {}
    for start in range(0, len(steps.marker), _BLOCK):
        rows = np.arange(start, min(start + _BLOCK, len(steps.marker)))
        gain = _gains(steps, rows, fps)
        best = np.argsort(-gain, axis=1)[:, :_RIVALS]
        for row, column in zip(*np.nonzero(np.take_along_axis(gain, best, axis=1) > _BETTER), strict=True):
            if gain[row, best[row, column]] < _BETTER_ACROSS_GAP and not steps.broken[rows[row]]:
                continue
            marker, rival = int(steps.marker[rows[row]]), int(best[row, column])
            pair = (min(marker, rival), max(marker, rival))
            gains[pair] = gains.get(pair, 0.0) + float(gain[row, rival])
            if column == 0:
                favourites[int(steps.after[rows[row]]), marker] = rival
    mutual = [frame for (frame, one), other in favourites.items() if favourites.get((frame, other)) == one]
    return gains, Counter({frame: count // 2 for frame, count in Counter(mutual).items()})


def _cuts(steps: _Steps, seen: Bools, pair: tuple[int, int], fps: float) -> set[int]:
    """Frames at which the labels of a pair may change hands: at breaks and gaps where the other could take over."""
    cuts = set[int]()
    for marker, other in (pair, pair[::-1]):
        rows = np.flatnonzero(steps.marker == marker)
        before, after = steps.before[rows], steps.after[rows]
        hidden = ~seen[before, other] | ~seen[after, other]
        plausible = hidden | (_gains(steps, rows, fps)[:, other] > _WORSE)
        cuts |= {int(f) for f in (before[plausible] + 1)} | {int(f) for f in after[plausible]}
        # What comes before the first sample and after the last one has no step.
        frames = np.flatnonzero(seen[:, marker])
        cuts |= {int(frames[0]), int(frames[-1]) + 1} if len(frames) else set()
    return cuts


def _odd_pairs(positions: Floats, known: MarkerDistances, fps: float) -> set[tuple[int, int]]:
    """Pairs of markers whose distances are each other's for some frames on end."""
    looked = positions[:: max(1, round(_LOOK * fps))]
    odd = set[tuple[int, int]]()
    for start in range(0, len(looked) - _LASTS + 1, _BLOCK):
        suspicious = suspicious_pairs(looked[start : start + _BLOCK + _LASTS - 1], known, _SUSPICION)
        held = np.logical_and.reduce([suspicious[k : len(suspicious) - _LASTS + 1 + k] for k in range(_LASTS)])
        odd |= {(int(a), int(b)) for a, b in zip(*np.nonzero(np.triu(held.any(axis=0), 1)), strict=True)}
    return odd


def _cycles(swaps: list[Swap]) -> list[Swap]:
    """Swaps of two pairs of three markers over the same frames, one after the other, as one cycle."""
    merged: list[Swap] = []
    for swap in swaps:
        previous = merged[-1] if merged else None
        if (
            previous is None
            or len(previous.markers) != 2
            or (previous.first, previous.last) != (swap.first, swap.last)
            or len({*previous.markers, *swap.markers}) != 3
        ):
            merged.append(swap)
            continue
        labels = np.arange(max(*previous.markers, *swap.markers) + 1)
        for one in (previous, swap):
            labels[list(one.markers)] = labels[list(one.markers[::-1])]
        start = previous.markers[0]
        cycle = (start, int(labels[start]), int(labels[labels[start]]))
        merged[-1] = Swap(cycle, swap.first, swap.last, min(previous.log_odds, swap.log_odds), True)
    return merged
