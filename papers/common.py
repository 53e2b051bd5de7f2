"""What the scripts share: which clips teach and which are tried, how they are spoiled, how errors are measured."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

import motionmend as mm
from motionmend.arrays import Bools, Floats
from motionmend.errors import FileError
from motionmend.evaluate import body_channels, rms_angle

FPS = 30.0  # the dissertation's rate: captured at 120 Hz, reduced to 30
SEEDS = (0, 1, 2)


@dataclass(frozen=True)
class Split:
    """Clips of one kind of motion.

    Attributes
    ----------
    learn : clips to learn from.
    test : clips held out, tried one by one.
    """

    learn: tuple[str, ...]
    test: tuple[str, ...]


SPLITS = {
    "walking": Split(("16_15", "16_16", "16_21", "16_22", "16_31"), ("16_32", "16_47", "16_58")),
    "running": Split(tuple(f"09_{n:02}" for n in range(1, 9)), ("09_09", "09_10", "09_11")),
    "jumping": Split(("16_01", "16_02", "16_03", "16_05", "16_06"), ("16_04", "16_07")),
    "dance": Split(("05_02", "05_03", "05_06", "05_08", "05_10", "05_14", "05_16"), ("05_13",)),
}

# all walks and runs in the data, whoever walks
WALKS = (
    *("02_01", "02_02", "05_01", "29_01"),
    *(f"07_{n:02}" for n in range(1, 12)),
    *(f"16_{n}" for n in (11, 12, 13, 14, 15, 16, 17, 18, 21, 22, 31, 32, 47, 58)),
)
RUNS = (
    "02_03",
    *(f"09_{n:02}" for n in range(1, 12)),
    *(f"16_{n}" for n in (35, 36, 37, 38, 39, 41, 43, 45, 46, 48, 49, 55, 56)),
)


@dataclass(frozen=True)
class Table:
    """A table of the report: a title, column heads and rows of ready text."""

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class Findings:
    """What a script measured.

    Attributes
    ----------
    values : the numbers that criteria and the claims' texts name.
    notes : sentences on what was done: which clips, what differs from the paper.
    tables : with the numbers in full.
    figures : (file name in the folder of figures, caption).
    machine : what it was measured on, filled in by the run.
    """

    values: dict[str, float]
    notes: tuple[str, ...] = ()
    tables: tuple[Table, ...] = ()
    figures: tuple[tuple[str, str], ...] = ()
    machine: tuple[str, ...] = ()


@cache
def motion(mocap: Path, clip: str) -> mm.Motion:
    """The CMU joint angles called `SUBJECT_TRIAL`, at the rate of the file (120 Hz).

    Frames whose body angles are all exactly zero are a rest pose that a conversion put in (the first four of 09_10):
    they are no motion, and are left out.
    """
    recording = _read(mocap / "amc" / clip.partition("_")[0] / f"{clip}.amc", mm.Motion)
    return recording.with_q(recording.q[(recording.q[:, body(recording)] != 0).any(axis=1)])


@cache
def markers(mocap: Path, name: str) -> mm.Markers:
    """The marker recording `name`.c3d."""
    return _read(mocap / "c3d" / f"{name}.c3d", mm.Markers)


def _read(path: Path, kind: type) -> mm.Motion | mm.Markers:
    recording = mm.read(path)
    if not isinstance(recording, kind):
        raise FileError(f"{path.name} was to hold {kind.__name__}, came {type(recording).__name__}")
    return recording


def only(recording: mm.Markers, names: Sequence[str]) -> mm.Markers:
    """The markers with these names, in this order; subjects' prefixes do not count."""
    bare = [name.rpartition(":")[2].upper() for name in recording.names]
    return mm.Markers(names, recording.positions[:, [bare.index(n) for n in names]], recording.fps, up=recording.up)


def stretch(recording: mm.Markers, start: float, stop: float) -> mm.Markers:
    """The part of the recording between two shares of its length."""
    first, last = (round(share * recording.frames) for share in (start, stop))
    return mm.Markers(recording.names, recording.positions[first:last], recording.fps, up=recording.up)


def motions(mocap: Path, clips: Sequence[str]) -> list[mm.Motion]:
    """Several clips by name."""
    return [motion(mocap, clip) for clip in clips]


def reduced(recording: mm.Motion | mm.Markers, fps: float = FPS, phase: int = 0) -> mm.Motion | mm.Markers:
    """Every n-th frame, so that the recording has `fps` Hz; n must be whole."""
    step = round(recording.fps / fps)
    if abs(step * fps - recording.fps) > 1e-6 * recording.fps:
        raise FileError(f"a recording of {recording.fps:g} Hz does not reduce to {fps:g} Hz by leaving out frames")
    if isinstance(recording, mm.Motion):
        return mm.Motion(recording.skeleton, recording.q[phase::step], fps)
    return mm.Markers(recording.names, recording.positions[phase::step], fps, up=recording.up)


def body(recording: mm.Motion) -> Bools:
    """(D,) True for the joint angles that errors are measured over: no root, hands, fingers, thumbs, toes."""
    return body_channels(recording.channels)


def body_error(truth: mm.Motion, other: mm.Motion, where: Bools | None = None) -> float:
    """RMS difference over the body joint angles, degrees; `where` (T, D) picks samples.

    Raises
    ------
    FileError : a sample of `other` that counts was left open.
    """
    chosen = np.broadcast_to(body(truth), truth.q.shape) if where is None else where & body(truth)
    a, b = truth.q[chosen], other.q[chosen]
    if not np.isfinite(b).all():
        raise FileError(
            f"{int((~np.isfinite(b)).sum())} samples were left open: an error over the others would flatter"
        )
    return float(np.degrees(rms_angle(a, b)))


def all_error(truth: mm.Motion, other: mm.Motion) -> float:
    """RMS difference over all rotations, root and fingers included, degrees."""
    angles = truth.skeleton.dof_kind == 0
    return float(np.degrees(rms_angle(truth.q[:, angles], other.q[:, angles])))


def distances(truth: Floats, other: Floats, where: Bools) -> Floats:
    """(N,) cm: how far the points (T, P, 3) m of `other` are from `truth` where (T, P) says so."""
    return np.asarray(100.0 * np.linalg.norm(other - truth, axis=2)[where])


def spoiled(
    clean: mm.Motion, *, noise: float = 0.0, outliers: float = 0.0, gaps: float = 0.0, seed: int = 0
) -> mm.Motion:
    """The clip with `noise` degrees of Gaussian noise and a share of outliers and gaps, in every channel."""
    return mm.corrupt(clean, noise=np.radians(noise), outliers=outliers, gaps=gaps, seed=seed).recording


@cache
def model_of(mocap: Path, clips: tuple[str, ...], window: int = 20, energy: float = 0.99) -> mm.DenoiserModel:
    """A denoiser learned from these clips at the dissertation's rate, all phases of the 120 Hz frames."""
    return mm.Denoiser(window=window, fps=FPS, energy=energy).fit(motions(mocap, clips))
