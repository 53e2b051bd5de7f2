"""Real recordings with tracking states: what is kept, what is steadied

Nobody knows the truth of these. What can be seen without: bones must not change, motion must not become rougher, quick
moves of what the sensor tracks must go through, and what it tracks well must stay where it is but for a constant.
"""

from pathlib import Path

import numpy as np

from motionmend.arrays import Bools, Floats
from motionmend.bodies.postures import TRACKED, Postures
from motionmend.correct.anatomy import anatomy
from motionmend.correct.normalise import bone_lengths, facing, turns, upright
from motionmend.errors import MotionMendError
from motionmend.io.sensor import read_postures

from .common import Findings, Table
from .correct_common import kinect_in, learned

FOLDERS = "gaitkinect", "keraal", "kimore", "laban"
LONGEST = 450  # frames of each recording
QUICK = 1.5  # m/s, of hands and feet
MOVE = 0.1  # s; what is back where it was after so long was no move
ENDS = "Wrist", "Ankle"


def run(mocap: Path, pictures: Path) -> Findings:
    """Bones, jerk, peaks and shifts of every recording, corrected as a whole and live."""
    del pictures
    kinect = kinect_in(mocap)
    model = learned(kinect, ())
    rows, peaks, same = [], {"whole": [], "live": []}, True
    judged: dict[str, list[tuple[float, float, float]]] = {"whole": [], "live": []}
    for name, given in recordings(kinect):
        for way, found in (("whole", model.correct(given)), ("live", model.correct(given, look_ahead=0))):
            same &= found.positions.shape == given.positions.shape and bool(np.array_equal(found.times, given.times))
            quick = quick_moves(given, found.positions)
            peaks[way] += quick
            judged[way].append((bones(found, given), rough(found) / rough(given), shifted(given, found)))
            if way == "whole":
                middle = f"{np.median(quick):.2f}" if quick else "none quick"
                rows.append((name, str(given.frames), *(f"{one:.2f}" for one in judged[way][-1]), middle))
    whole, live = (np.array(judged[way]) for way in ("whole", "live"))
    return Findings(
        {
            "recordings": float(len(whole)),
            "frames_kept": float(same),
            "bones": float(np.median(whole[:, 0])),
            "bones_worst": float(whole[:, 0].max()),
            "bones_live": float(np.median(live[:, 0])),
            "jerk": float(np.median(whole[:, 1])),
            "jerk_worst": float(whole[:, 1].max()),
            "jerk_live_worst": float(live[:, 1].max()),
            "moved": float(np.median(whole[:, 2])),
            "moved_worst": float(whole[:, 2].max()),
            "moved_far": float((whole[:, 2] > 2.0).sum()),
            "peaks": float(np.median(peaks["whole"])),
            "peaks_live": float(np.median(peaks["live"])),
            "quick": float(len(peaks["whole"])),
        },
        (
            f"Kinect v1 and v2 recordings of walks, exercises and gestures by people the corrector (all of UI-PRMD) has not "
            f"seen, at most {LONGEST} frames each. Bones: spread of their lengths by their mean, after against before, median "
            "over bones. Jerk: median over joints and moments, after against before. Moved: how far tracked joints are from "
            "where the sensor has them but for a constant offset each along the person's axes, median in cm. Quick: the 98th percentile of the speed of "
            f"tracked hands and feet over {MOVE} s, where that is above {QUICK} m/s, after against before.",
        ),
        (Table("Corrected as a whole", ("recording", "frames", "bones", "jerk", "moved, cm", "quick"), tuple(rows)),),
    )


def recordings(kinect: Path) -> list[tuple[str, Postures]]:
    """All that say how well they track, cut to `LONGEST`."""
    found = []
    for file in sorted(one for folder in FOLDERS for one in (kinect / folder).rglob("*") if one.is_file()):
        try:
            postures = read_postures(file)
        except MotionMendError:  # a list of joints, the truth of a pair
            continue
        if postures.state is not None and postures.frames > 2:
            found.append((f"{file.parent.name}/{file.stem}", _begun(postures)))
    return found


def _begun(postures: Postures) -> Postures:
    some = slice(0, LONGEST)
    state = None if postures.state is None else postures.state[some]
    return Postures(postures.names, postures.positions[some], postures.times[some], state=state)


def tracked(given: Postures) -> Bools:
    """(T, J) joints that the sensor says it tracks."""
    assert given.state is not None
    return np.asarray((given.state == TRACKED) & np.isfinite(given.positions).all(axis=2))


def bones(found: Postures, given: Postures) -> float:
    """Spread of the bones' lengths, after against before."""
    body = anatomy(given.names)
    spread = []
    for one in (found, given):
        lengths = bone_lengths(one.positions, body)
        spread.append(np.nanstd(lengths, axis=0) / np.nanmean(lengths, axis=0))
    known = np.isfinite(spread[0]) & (spread[1] > 1e-6)
    return float(np.median(spread[0][known]) / np.median(spread[1][known]))


def rough(one: Postures) -> float:
    """m/s3: the jerk, median over joints and moments between frames that follow each other as usual."""
    step = np.diff(one.times)
    usual = float(np.median(step))
    regular = np.abs(np.lib.stride_tricks.sliding_window_view(step, 3) - usual).max(axis=1) < 0.3 * usual
    jerk = np.linalg.norm(np.diff(one.positions, 3, axis=0), axis=2)[regular] / usual**3
    return float(np.nanmedian(np.nanmean(jerk, axis=0)))


def quick_moves(given: Postures, positions: Floats) -> list[float]:
    """For each hand and foot that is quick while tracked: the 98th percentile of its speed, after against before."""
    seen = tracked(given)
    step = float(np.median(np.diff(given.times)))
    apart = max(1, round(MOVE / step))
    both = np.lib.stride_tricks.sliding_window_view(seen, apart + 1, axis=0).all(axis=2)
    before, after = (
        np.linalg.norm(one[apart:] - one[:-apart], axis=2) / (apart * step) for one in (given.positions, positions)
    )
    found = []
    for j in (j for j, name in enumerate(given.names) if any(end in name for end in ENDS)):
        speeds = before[both[:, j], j], after[both[:, j], j]
        if len(speeds[0]) > 20 and np.percentile(speeds[0], 98) > QUICK:
            found.append(float(np.percentile(speeds[1], 98) / np.percentile(speeds[0], 98)))
    return found


def shifted(given: Postures, found: Postures) -> float:
    """cm: how far tracked joints went, but for each joint's median shift; the median over joints and frames.

    Shifts are taken along the person's own axes: who turns round takes a constant offset along.
    """
    seen, body = tracked(given), anatomy(given.names)
    up = upright(given.positions, body)
    turn = turns(facing(given.positions @ up.T, seen.astype(np.float64), body))
    shift = np.einsum("tij,tkj->tki", turn, (found.positions - given.positions) @ up.T)
    shift = np.where(seen[..., None], shift, np.nan)
    known = seen.any(axis=0)
    less = shift[:, known] - np.nanmedian(shift[:, known], axis=0)
    return float(100.0 * np.nanmedian(np.linalg.norm(less, axis=2)))
