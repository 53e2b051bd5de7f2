"""Which of two labels bears which of two tracks, over a whole recording: the likeliest path and its rivals."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...arrays import Bools, Floats, Ints, runs
from .evidence import STEP_LAW, Continuity, line_weights

_SWITCH = -12.0  # log prior of a change of labels at one instant between two given markers
_MORE = -3.0  # and, where several pairs seem to change hands together, of each of them: they share the first price
_LABELLED = -4.0  # and of labels that are wrong from the start, or to the end, when a reference can tell
_LASTING = -4.0  # and of the whole recording spent swapped
_POSTURE = 0.1  # s, within which distances say the same thing over and over
_LIMIT = 10.0  # beyond it the odds of one stretch grow as a logarithm: a strange posture is one fact, however long
_KEPT = 24  # paths followed at a time, and
_HOPELESS = 60.0  # log odds behind the best at which one is given up: five changes of labels


@dataclass(frozen=True)
class Stretch:
    """Frames first ... last in which two labels are swapped, and the log odds of that against any path that is not."""

    first: int
    last: int
    log_odds: float


def swapped_stretches(
    positions: Floats,
    cuts: Mapping[int, int],
    evidence: Floats,
    continuity: Continuity,
    fps: float,
    *,
    sided: bool = False,
) -> list[Stretch]:
    """The stretches of the likeliest path in which the two tracks bear each other's labels.

    Parameters
    ----------
    positions : (T, 2, 3) m of two labels, NaN = missing.
    cuts : frames at which the labels may change hands, and how many pairs do so there together.
    evidence : (T,) log odds of swapped to right by distances.
    continuity : of the recording.
    fps : Hz.
    sided : whether the evidence is by a reference and so tells right from wrong at the recording's ends too.

    The path is a hidden Markov chain whose state remembers where each track was last seen, so that a track is followed
    from stretch to stretch across its gaps under every hypothesis (Viterbi, with the odds from constrained reruns).
    """
    from ...kernels.labelling import likeliest_path

    seen: Bools = np.asarray(np.isfinite(positions).all(axis=2))
    starts = sorted({0, *cuts} - {len(positions)})
    stops = [*starts[1:], len(positions)]
    # A limb whose labels change hands is one event, however many markers it has.
    price = np.array([_SWITCH if cuts.get(k, 1) < 2 else _SWITCH / cuts[k] + _MORE for k in starts])
    ends = _LABELLED if sided else float(price.max())
    price[0] = ends
    chain = (
        *_lines(positions, seen, starts, stops, continuity.window),
        np.array([_odds(evidence, seen, *stretch, fps) for stretch in zip(starts, stops, strict=True)]),
        price,
        ends,
    )
    steps = continuity.horizons, continuity.rest, continuity.share, continuity.fastest, STEP_LAW, _KEPT, _HOPELESS
    free = np.zeros(len(starts), dtype=bool)
    best, swapped = likeliest_path(*chain, free, *steps)
    found = []
    for start, stop in runs(swapped):
        frames = np.flatnonzero(seen[starts[start] : stops[stop - 1]].any(axis=1))
        if len(frames):
            forbidden = free.copy()
            forbidden[start:stop] = True
            first, last = starts[start] + frames[[0, -1]]
            found.append(Stretch(int(first), int(last), float(best - likeliest_path(*chain, forbidden, *steps)[0])))
    return found


def _odds(evidence: Floats, seen: Bools, start: int, stop: int, fps: float) -> float:
    """Log odds of a stretch being swapped, by distances and by how much of the recording it is."""
    said = evidence[start:stop].sum() / (_POSTURE * fps)
    lasting = _LASTING * seen[start:stop].any(axis=1).mean() * (stop - start) / len(evidence)
    return float(_LIMIT * np.sign(said) * np.log1p(abs(said) / _LIMIT) + lasting)


def _lines(
    positions: Floats, seen: Bools, starts: list[int], stops: list[int], window: int
) -> tuple[Ints, Floats, Floats, Bools]:
    """Frame (2, K, 2), -1 = never, place and velocity (2, K, 2, 3), and whether that is known, of the lines through
    the first samples in a row and through the last ones of each stretch, by label."""
    frame = np.full((2, len(starts), 2), -1)
    place, velocity = np.zeros((2, *frame.shape, 3))
    moving = np.zeros(frame.shape, dtype=bool)
    for k, (start, stop) in enumerate(zip(starts, stops, strict=True)):
        for label in range(2):
            frames = start + np.flatnonzero(seen[start:stop, label])
            if len(frames):
                for end, forward in enumerate((1, -1)):
                    at = end, k, label
                    frame[at], place[at], velocity[at], moving[at] = _line(
                        positions[:, label], frames[::forward], forward, window
                    )
    return frame, place, velocity, moving


def _line(track: Floats, frames: Ints, forward: int, window: int) -> tuple[int, Floats, Floats, bool]:
    """Frame, place, velocity and whether that is known, of the line through the first samples in a row."""
    count = 1
    while count < min(window, len(frames)) and frames[count] == frames[count - 1] + forward:
        count += 1
    at = int(frames[0])
    if count < 2:
        return at, track[at], np.zeros(3), False
    slope, level = line_weights(count)
    samples = track[frames[:count][::-1]]
    return at, level @ samples, -forward * (slope @ samples), True
