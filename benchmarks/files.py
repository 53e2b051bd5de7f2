"""Reading and writing: each format against the shortest honest way to get its numbers in or out."""

import warnings
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from motionmend.arrays import Floats
from motionmend.bodies.motion import Markers, Motion
from motionmend.io import read, write

from . import data
from .metric import Metric
from .timing import Plan, race, ratio


def run(plan: Plan) -> list[Metric]:
    """All measurements of the suite, in a temporary folder."""
    frames = plan.frames[len(plan.frames) // 2]
    moved, seen = data.motion(frames), data.markers(frames)
    found: list[Metric] = []
    with TemporaryDirectory() as folder:
        for ending in (".amc", ".bvh"):
            found += _format(Path(folder) / f"moved{ending}", moved, plan.rounds)
        for ending in (".c3d", ".trc", ".csv"):
            found += _format(Path(folder) / f"seen{ending}", seen, plan.rounds)
        found += _second_reader(Path(folder) / "seen.c3d", frames, plan.rounds)
    return found


def _format(file: Path, recording: Motion | Markers, rounds: int) -> list[Metric]:
    """Ours both ways, and the plain way both ways on the same numbers."""
    name, frames = file.suffix[1:], recording.frames
    write(file, recording)
    back = read(file)
    if back.frames != frames:
        raise AssertionError(f"files.{name}: {frames} frames were written, {back.frames} came back")
    plain_read, plain_write = PLAIN[file.suffix]
    values = plain_read(file)
    other = file.with_name("plain" + file.suffix)
    times = race(
        {
            "read": lambda: read(file),
            "plain_read": lambda: plain_read(file),
            "write": lambda: write(file, back),
            "plain_write": lambda: plain_write(other, values),
        },
        rounds,
    )
    size = file.stat().st_size / 1e6
    return [
        ratio(f"files.{name}.read.plain_over_ours", times["plain_read"], times["read"]),
        ratio(f"files.{name}.write.plain_over_ours", times["plain_write"], times["write"]),
        times["read"].rate(f"files.{name}.read.rate", frames, "frames/s"),
        times["write"].rate(f"files.{name}.write.rate", frames, "frames/s"),
        times["read"].rate(f"files.{name}.read.volume", size, "MB/s"),
    ]


def _second_reader(file: Path, frames: int, rounds: int) -> list[Metric]:
    """The pure Python reader of C3D, where it is installed."""
    try:
        import c3d
    except ImportError:
        return []

    def by_c3d() -> list[object]:
        with file.open("rb") as handle:
            return [points for _, points, _ in c3d.Reader(handle).read_frames()]

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # that the file has no analog data
        times = race({"ours": lambda: read(file), "c3d": by_c3d}, rounds)
    return [
        ratio("files.c3d.read.c3d_over_ours", times["c3d"], times["ours"], "info"),
        times["c3d"].rate("files.c3d.read.c3d_rate", frames, "frames/s"),
    ]


# ---- the plain ways ------------------------------------------------------------------


def _read_amc(file: Path) -> Floats:
    """(T, D): split every line and turn its words into numbers."""
    rows: list[list[float]] = []
    for line in file.read_text().splitlines():
        words = line.split()
        if len(words) == 1 and words[0].isdigit():
            rows.append([])
        elif rows:
            rows[-1].extend(map(float, words[1:]))
    return np.array(rows)


def _write_amc(file: Path, values: Floats) -> None:
    """Frame numbers and lines of up to six values, as many digits as it takes."""
    with file.open("w") as out:
        for number, row in enumerate(values.tolist(), start=1):
            out.write(f"{number}\n")
            for start in range(0, len(row), 6):
                out.write("bone " + " ".join(map(repr, row[start : start + 6])) + "\n")


def _read_bvh(file: Path) -> Floats:
    """(T, D): the motion block by NumPy's own reader."""
    lines = file.read_text().splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith("Frame Time"))
    return np.loadtxt(lines[start + 1 :])


def _write_lines(file: Path, values: Floats) -> None:
    np.savetxt(file, values, fmt="%.9g")


def _read_trc(file: Path) -> Floats:
    """(T, 2 + 3 M): by NumPy's reader that knows of empty cells."""
    return np.genfromtxt(file, delimiter="\t", skip_header=5)


def _read_csv(file: Path) -> Floats:
    """(T, 1 + 3 M)."""
    return np.genfromtxt(file, delimiter=",", skip_header=1)


def _write_csv(file: Path, values: Floats) -> None:
    np.savetxt(file, values, fmt="%.9g", delimiter=",")


def _read_c3d(file: Path) -> Floats:
    """(4, M, T): the library that most tools use."""
    import ezc3d

    return np.asarray(ezc3d.c3d(str(file))["data"]["points"])


def _write_c3d(file: Path, points: Floats) -> None:
    import ezc3d

    out = ezc3d.c3d()
    out["parameters"]["POINT"]["RATE"]["value"] = [120.0]
    out["parameters"]["POINT"]["LABELS"]["value"] = [f"m{i}" for i in range(points.shape[1])]
    out["data"]["points"] = points
    out.write(str(file))


PLAIN: dict[str, tuple[Callable[[Path], Floats], Callable[[Path, Floats], None]]] = {
    ".amc": (_read_amc, _write_amc),
    ".bvh": (_read_bvh, _write_lines),
    ".c3d": (_read_c3d, _write_c3d),
    ".trc": (_read_trc, _write_csv),
    ".csv": (_read_csv, _write_csv),
}
