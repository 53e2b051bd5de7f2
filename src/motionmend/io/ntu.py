"""NTU RGB+D .skeleton text: the joints of the second Kinect, several bodies, states, no times.

As the data set's own reader has it (shahroudy/NTURGB-D, read_skeleton_file.m): the number of frames; for each frame
the number of bodies; for each body a line of ten values (its identity first), the number of joints, and for each joint
a line of twelve: x y z (m), depth x y, colour x y, quaternion w x y z, tracking state.
"""

import os

import numpy as np

from ..arrays import Floats
from ..bodies.joint_sets import KINECT25
from ..bodies.postures import NOT_TRACKED, Postures
from ..errors import FileError, counted
from .columns import lines_of
from .number_rows import unpacked
from .sensor_source import SensorSource, even_times, spread_states, states_of, with_absent
from .several_bodies import Body, one_person

WANTED = "an NTU .skeleton file"


def read_ntu(path: str | os.PathLike[str], fps: float | None = None) -> Postures:
    """Read the person who is seen longest; frames without them are empty.

    Parameters
    ----------
    path : the .skeleton.
    fps : Hz; 30 when not given, the file has no times.

    Raises
    ------
    FileError : not there, not such a file, cut off, or nobody in it.
    """
    name = str(path)
    words = " ".join(lines_of(unpacked(path, WANTED), name, WANTED)).split()
    place = 0

    def take(count: int, what: str) -> list[str]:
        nonlocal place
        if place + count > len(words):
            raise FileError(f"{name}: the file ends in {what}: it is cut off; get a complete copy")
        place += count
        return words[place - count : place]

    def whole(what: str) -> int:
        word = take(1, what)[0]
        if not word.isdigit():
            raise FileError(f"{name}: wanted {WANTED}, the {what} is {word[:20]!r}; the file is damaged")
        return int(word)

    frames = whole("number of frames")
    bodies: list[list[Body]] = []
    rows: list[list[Floats]] = []
    for frame in range(frames):
        bodies.append([])
        rows.append([])
        for _ in range(whole(f"number of bodies of frame {frame} of {frames}")):
            number = take(10, f"frame {frame} of {frames}")[0]
            joints = whole(f"number of joints in frame {frame} of {frames}")
            if joints != len(KINECT25.names):
                raise FileError(f"{name}: wanted 25 joints in frame {frame}, came {joints}; the file is damaged")
            rows[frame].append(_numbers(take(12 * joints, f"frame {frame} of {frames}"), frame, name))
            bodies[frame].append(Body(number, rows[frame][-1][:, :3]))
    warnings = (f"{len(words) - place} numbers behind the last frame were not read",) if place < len(words) else ()
    if not any(bodies):
        raise FileError(f"{name}: wanted a body in some frame, the file holds none in {counted(frames, 'frame')}")
    times, guesses = even_times(frames, fps)
    chosen, said = one_person(bodies, times)
    values = np.full((frames, len(KINECT25.names), 12), np.nan)
    for frame in np.flatnonzero(chosen >= 0).tolist():
        values[frame] = rows[frame][chosen[frame]]
    state, wrong = states_of(np.where(np.isnan(values[:, :, 11]), NOT_TRACKED, values[:, :, 11]))
    positions, nowhere = with_absent(values[:, :, :3], state)
    return Postures(
        KINECT25.names,
        positions,
        times,
        state=spread_states(np.isfinite(positions[:, :, 0]), state),
        source=SensorSource("Kinect v2 joints (NTU)"),
        guesses=(*guesses, *said),
        warnings=(*warnings, *wrong, *nowhere),
    )


def _numbers(words: list[str], frame: int, name: str) -> Floats:
    """(25, 12) of a body in a frame."""
    try:
        return np.array(words, dtype=np.float64).reshape(-1, 12)
    except ValueError:
        raise FileError(f"{name}: a word among the joints of frame {frame} is no number; repair it") from None
