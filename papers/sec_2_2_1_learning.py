"""Section 2.2.1: learning time"""

import time
from pathlib import Path

import motionmend as mm

from .common import FPS, WALKS, Findings, Table, motions, reduced

SMALL, LARGE = 2000, 60452  # frames at 30 fps
SHIFT = 7  # frames cut from the start of a clip each time it comes again


def run(mocap: Path, pictures: Path) -> Findings:
    """Seconds to learn from 2,000 and from 60,452 frames."""
    whole = motions(mocap, WALKS)
    denoiser = mm.Denoiser(window=20, fps=FPS)
    denoiser.fit(frames_of(whole, 200))  # compiles the loops, which is not learning
    rows, values = [], {}
    for name, frames in (("small", SMALL), ("large", LARGE)):
        clips = frames_of(whole, frames)
        start = time.perf_counter()
        model = denoiser.fit(clips)
        values[f"{name}_seconds"] = time.perf_counter() - start
        rows.append((f"{model.frames:,}", str(len(clips)), str(model.bases.count), f"{values[f'{name}_seconds']:.1f}"))
    distinct = sum(clip.frames for clip in whole)
    return Findings(
        values=values,
        notes=(
            f"The {len(whole)} walking clips of all subjects have {distinct:,} frames at 120 Hz; each of the four "
            f"phases of every fourth frame counts as a clip at 30 fps. For {LARGE:,} frames the same clips come again, "
            f"each time {SHIFT} frames shorter at the start: as many frames as the paper's, not of their variety.",
            "Time covers channels, lag covariance, bases and the dynamics of the data-driven Kalman filter.",
        ),
        tables=(Table("Learning, window 20 at 30 fps", ("frames", "clips", "bases K", "seconds"), tuple(rows)),),
    )


def frames_of(whole: list[mm.Motion], frames: int) -> list[mm.Motion]:
    """Clips at 30 fps with so many frames together, less what is too short for a window."""
    clips: list[mm.Motion] = []
    left, cut = frames, 0
    while left >= 20:
        for clip in whole:
            for phase in range(4):
                piece = reduced(clip, phase=phase)
                piece = piece.with_q(piece.q[cut : cut + left])
                if piece.frames >= 20:
                    clips.append(piece)
                    left -= piece.frames
        cut += SHIFT
        if cut > max(clip.frames for clip in whole) // 4:
            cut = 1
    return clips
