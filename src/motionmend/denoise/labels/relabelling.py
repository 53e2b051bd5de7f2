"""Swapped labels of a recording: which are given back, and what is said of them."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.ndimage import maximum_filter, median_filter

from ...arrays import Bools, Bytes, Floats, Ints
from ...bodies.motion import Markers, Origin
from ..channels.cloud import in_metres
from ..channels.recording import Channels
from ..library.markers import MarkerLibrary
from .evidence import MarkerDistances, learn_distances
from .swaps import Swap, find_swaps, put_right

LEAST_SWAP = 3  # frames; what looks like a shorter swap is as likely a pair of outliers
SPIKE, SPIKES, LEAST_SPIKE = 5, 6.0, 0.01  # frames of a median, times its usual distance from a sample, and m
AT_FIRST_SIGHT = 25.0  # log odds of a swap in what was measured; true ones have 40 to 130, pairs of outliers up to 11
FEWEST_POSTURES = 50  # from which the distances of a marker set can be told


def swaps_seen(positions: Floats, fps: float, postures: MarkerLibrary | None) -> tuple[Swap, ...]:
    """Swaps in positions (T, M, 3) m at `fps` Hz, told by continuity and by distances of the library's postures."""
    reference: MarkerDistances | None = None
    if postures is not None and tell_distances(postures):
        reference = learn_distances([postures.postures])
    found = find_swaps(positions, fps, reference=reference)
    return tuple(s for s in found if s.put_right or s.last - s.first + 1 >= LEAST_SWAP)


def tell_distances(postures: MarkerLibrary) -> bool:
    """Whether a library has postures enough to tell how far markers are apart."""
    return len(postures.windows) >= FEWEST_POSTURES


def right_at_first_sight(
    recording: Markers,
    channels: Channels,
    those_asked: Callable[[tuple[Swap, ...], Channels], tuple[Swap, ...]] = lambda swaps, _: swaps,
) -> tuple[Markers, tuple[Swap, ...]]:
    """The recording with those labels given back that are swapped beyond doubt as it is, and which these are.

    A repair draws what leaps to where a library has it, and smooths or replaces the very leaps by which a whole limb's
    swapped labels are told.

    Parameters
    ----------
    recording : as measured.
    channels : of it.
    those_asked : which of the swaps are to be put right.
    """
    seen = at_first_sight(recording, channels)
    certain = those_asked(tuple(swap for swap in seen if swap.put_right and swap.log_odds >= AT_FIRST_SIGHT), channels)
    return relabelled(recording, channels, certain), tuple(swap for swap in certain if swap.put_right)


def at_first_sight(recording: Markers, channels: Channels) -> tuple[Swap, ...]:
    """Swaps in a recording as it was measured, of its channels' markers."""
    return swaps_seen(but_for_spikes(in_metres(channels.values)), recording.fps, None)


def but_for_spikes(positions: Floats) -> Floats:
    """Positions (T, M, 3) m without samples that leap away and back within two frames: a swap leaps and stays.

    A recording full of outliers proposes pairs without end, and every one of them would be tried.
    """
    seen: Bools = np.asarray(np.isfinite(positions).all(axis=2))
    middle = median_filter(np.nan_to_num(positions), size=(SPIKE, 1, 1), mode="nearest")
    off = np.where(seen, np.sqrt(np.square(positions - middle).sum(axis=2)), np.nan)
    beside_a_gap = maximum_filter(~seen, size=(SPIKE, 1))
    usual = np.array([np.median(one[np.isfinite(one)]) if np.isfinite(one).any() else 0.0 for one in off.T])
    far = np.maximum(SPIKES * usual, LEAST_SPIKE)
    # a leap that stays bends the medians beside it, but there the samples go on from those of one side
    spike = (np.nan_to_num(off) > far) & (_off_those_before(positions) > far)
    spike &= _off_those_before(positions[::-1])[::-1] > far
    return np.where((spike & ~beside_a_gap)[..., None], np.nan, positions)


def _off_those_before(positions: Floats) -> Floats:
    """(T, M) m from where the two samples before would have each go on; infinite where they were not seen."""
    off = np.full(positions.shape[:2], np.inf)
    off[2:] = np.linalg.norm(np.diff(positions, 2, axis=0), axis=2)
    return np.where(np.isfinite(off), off, np.inf)


def swaps_of(swaps: tuple[Swap, ...], asked: set[int]) -> tuple[Swap, ...]:
    """Those that touch the markers asked for; put right only where no other marker would have to move as well."""
    return tuple(
        replace(swap, put_right=swap.put_right and asked.issuperset(swap.markers))
        for swap in swaps
        if not asked.isdisjoint(swap.markers)
    )


def but_for_throughout(swaps: tuple[Swap, ...], recording: Markers, channels: Channels) -> tuple[Swap, ...]:
    """The same, but what is swapped in every frame that shows one of the markers is only declared."""

    def throughout(swap: Swap) -> bool:
        shown = _shown(swap, recording, channels)
        return bool(len(shown)) and swap.first <= shown[0] and shown[-1] <= swap.last

    return tuple(replace(swap, put_right=swap.put_right and not throughout(swap)) for swap in swaps)


def _shown(swap: Swap, recording: Markers, channels: Channels) -> Ints:
    """Frames that show one of the swap's markers."""
    return np.flatnonzero(recording.present[:, channels.columns[list(swap.markers)]].any(axis=1))


def relabelled(recording: Markers, channels: Channels, swaps: tuple[Swap, ...]) -> Markers:
    """The recording with labels given back."""
    if not any(s.put_right for s in swaps):
        return recording
    own = channels.columns
    here = [
        replace(swap, markers=tuple(int(own[m]) for m in swap.markers))
        for swap in swaps
        if all(own[m] >= 0 for m in swap.markers)
    ]
    return recording.with_positions(put_right(recording.positions, here))


def relabelled_origin(origin: Bytes, channels: Channels, swaps: tuple[Swap, ...]) -> Bytes:
    """A sample under its own label again was repaired."""
    marked = origin.copy()
    for swap in swaps:
        if swap.put_right:
            for marker in swap.markers:
                column = channels.columns[marker]
                if column >= 0:
                    stretch = marked[swap.first : swap.last + 1, column]
                    stretch[stretch == Origin.MEASURED] = Origin.REPAIRED
    return marked


def swaps_told(swaps: tuple[Swap, ...], recording: Markers, channels: Channels, *, taught: bool) -> tuple[str, ...]:
    """A sentence for each swap.

    Parameters
    ----------
    swaps : of the model's markers.
    recording : whose names they go by.
    channels : of it.
    taught : whether a library's distances told which label is whose.
    """
    said = []
    for swap in swaps:
        names = ", ".join(recording.names[column] for m in swap.markers if (column := channels.columns[m]) >= 0)
        where = f"frames {swap.first} to {swap.last}"
        shown = _shown(swap, recording, channels)
        lasts = len(shown) > 0 and (swap.first <= shown[0] or shown[-1] <= swap.last)
        if not swap.put_right:
            said.append(
                f"{names}: labels may be swapped in {where}, or in all others, and were not exchanged; look at them"
            )
        elif lasts and not taught:
            said.append(
                f"{names}: labels were swapped in {where} against the rest and are exchanged there, so that the "
                "recording agrees with itself; nothing tells which of the two is right"
            )
        elif lasts:
            said.append(
                f"{names}: labels were swapped in {where} and are exchanged there, as the library's clips have them; "
                "on somebody who wears these markers otherwise than its people it is the other way round"
            )
        else:
            said.append(f"{names}: labels were swapped in {where} and are put right")
    return tuple(said)
