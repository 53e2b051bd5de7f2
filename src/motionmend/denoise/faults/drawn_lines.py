"""Gaps that another program filled by straight lines: nothing that is measured goes straight on to the last digit.

Taken for samples, they are surer than any other. Where the markers about them have the marker elsewhere, they are gaps.
"""

import numpy as np

from ...arrays import Bools, Floats, runs
from ...bodies.motion import Markers
from ..channels.joints import CENTIMETRES
from ..channels.pieces import PIECE, blocks
from ..gaps.markers import LEAST_FRAMES
from ..noise.digits import coarseness
from .strayed import BESIDE, LEAST, away_and_doubt

SHORTEST, FEWEST = 0.05, 4  # s and frames; less are on a line by chance
ROUNDED, SINGLE = 2.0, 4.0 * 2.0**-23  # steps of the digits, and of a marker's place, by which they may miss the line
MOVES = 4.0  # times as far as that from frame to frame; who stands is on a line as well
KINK = 10.0  # times as far, by which a line ends in a kink; what goes straight by chance bends on little by little
RARELY = 0.3  # of what is seen of a marker; one that is more often on lines is drawn so, or too slow for its digits
SURE = 3.0  # deviations of where the markers about it have it


def drawn_lines(recording: Markers, repaired: Floats, std: Floats) -> Bools:
    """Samples on straight lines that the markers about them contradict.

    Parameters
    ----------
    recording : T frames of M markers.
    repaired : (T, M, 3) m, NaN = missing or not believed.
    std : (T, M) m per coordinate.

    Returns
    -------
    (T, M) True between the ends of such a line.
    """
    found = np.zeros(recording.present.shape, dtype=np.bool_)
    on_lines = _on_lines(recording)
    if not on_lines.any() or recording.frames < 2 * LEAST_FRAMES:
        return found
    for own, seen in blocks(recording.frames, PIECE, round(BESIDE * recording.fps)):
        asked = on_lines[seen]
        if asked.any():
            part = _contradicted(repaired[seen], std[seen], asked, recording.fps)
            found[own] = part[own.start - seen.start : own.stop - seen.start]
    return found


def _contradicted(positions: Floats, std: Floats, asked: Bools, fps: float) -> Bools:
    away, doubt = away_and_doubt(positions, std, asked, fps)
    found = np.zeros(asked.shape, dtype=np.bool_)
    for marker in np.flatnonzero(asked.any(axis=0)).tolist():
        for start, stop in runs(asked[:, marker]):
            told = start + np.flatnonzero(np.isfinite(away[start:stop, marker]))
            if len(told):
                far, unsure = (np.square(one[told, marker]).mean() for one in (away, doubt))
                found[start:stop, marker] = far > max(SURE**2 * unsure, LEAST**2)
    return found


def _on_lines(recording: Markers) -> Bools:
    """(T, M) True between the ends of straight lines along which a marker moves."""
    found = np.zeros(recording.present.shape, dtype=np.bool_)
    least = max(FEWEST, round(SHORTEST * recording.fps))
    steps = coarseness(recording).max(axis=1) / CENTIMETRES
    for marker in range(len(recording.names)):  # one at a time: a recording may be long
        path = recording.positions[:, marker]
        seen = np.isfinite(path).all(axis=1)
        size = np.fmax.reduce(np.abs(path), axis=None, initial=0.0)
        slack = max(ROUNDED * float(steps[marker]), SINGLE * float(size))
        step = np.diff(path, axis=0)
        far = np.linalg.norm(step, axis=1)
        bends = np.diff(step, axis=0)
        straight = (np.abs(bends) <= slack).all(axis=1) & (far[1:] > MOVES * slack)
        ends = np.pad(~(np.linalg.norm(bends, axis=1) <= KINK * slack), 1, constant_values=True)
        lines = [
            (start, stop) for start, stop in runs(straight) if stop - start >= least and ends[[start, stop + 1]].all()
        ]
        if sum(stop - start for start, stop in lines) <= RARELY * seen.sum():
            for start, stop in lines:
                found[start + 1 : stop + 1, marker] = True
    return found
