"""B10: recordings that come alone, as they are: no library, their own rate, joint angles and markers"""

from functools import partial
from pathlib import Path

import numpy as np

import motionmend as mm

from .beyond_common import geometric_mean, in_parallel
from .common import Findings, Table, body_error, distances, markers, motion, reduced

RIVALS = ("butterworth", "savgol", "gaussian", "kalman")  # the filters people use, none of which is told anything
CLIPS = ("16_32", "07_01", "02_05", "135_04", "14_33", "09_05", "86_01")
BVH = ("10_04", "27_01", "60_10_salsa")
TAKES = ("cmu_02_01", "cmu_05_13", "emory_SoccerHeader", "hdm05_bd_01-02_01_120", "sfu_0018_Moonwalk001", "gt_squat")
LONGEST = 8.0  # s: of longer recordings the middle is tried
NOISE = {"angles": (0.3, 1.0, 3.0), "markers": (1.0, 5.0, 20.0)}  # degrees; mm
SHARES = (0.0, 0.05)


def run(mocap: Path, pictures: Path) -> Findings:
    """Errors of the adaptive method that was taught nothing, against filters, by recording, noise and outliers."""
    jobs = [("angles", name, rate) for name in CLIPS for rate in (120.0, 30.0)]
    jobs += [("bvh", name, 0.0) for name in BVH]
    jobs += [("markers", name, 0.0) for name in TAKES]
    measured = dict(zip(jobs, in_parallel(partial(errors, mocap), jobs), strict=True))
    ratios = {
        (job, cell): found["adaptive"] / min(found[m] for m in RIVALS)
        for job, cells in measured.items()
        for cell, found in cells.items()
    }
    without = [r for (_, (_, share)), r in ratios.items() if not share]
    kinds = {"angles": ("angles", "bvh"), "markers": ("markers",)}
    values = {
        "alone_geomean": geometric_mean(list(ratios.values())),
        "alone_geomean_calm": geometric_mean(without),
        "alone_worst": max(ratios.values()),
        "alone_above": float(np.mean([r > 1.02 for r in ratios.values()])),
    }
    for kind, members in kinds.items():
        values[f"alone_{kind}"] = geometric_mean([r for (job, _), r in ratios.items() if job[0] in members])
    cells = {kind: [(n, s) for n in NOISE[kind] for s in SHARES] for kind in NOISE}
    tables = []
    for kind, members in kinds.items():
        head = ("recording", *(f"{n:g} {'degrees' if kind == 'angles' else 'mm'}, {s:.0%}" for n, s in cells[kind]))
        rows = tuple(
            (
                f"{job[1]}, {job[2]:g} Hz" if job[2] else job[1],
                *(f"{c['adaptive']:.2f} ({ratios[job, at]:.2f} of {best(c)})" for at, c in measured[job].items()),
            )
            for job in jobs
            if job[0] in members
        )
        tables.append(Table(f"Without a library, {'degrees' if kind == 'angles' else 'mm'} left", head, rows))
    return Findings(
        values=values,
        notes=(
            f"Noise and share of outliers in every channel or marker; of longer recordings the middle {LONGEST:g} s, "
            "of .bvh the first, with the rest pose that stands before them. In brackets the error against that of the best of "
            f"{', '.join(RIVALS)}.",
        ),
        tables=tuple(tables),
    )


def best(found: dict[str, float]) -> str:
    """The rival that errs least."""
    return min(RIVALS, key=lambda name: found[name])


def errors(mocap: Path, job: tuple[str, str, float]) -> dict[tuple[float, float], dict[str, float]]:
    """RMS error over body angles, degrees, or of marker places, mm, by cell and method."""
    kind, name, rate = job
    whole = recorded(mocap, kind, name, rate)
    length = round(LONGEST * whole.fps)
    clean = part(whole, 0 if kind == "bvh" else max(0, (whole.frames - length) // 2), length)
    found: dict[tuple[float, float], dict[str, float]] = {}
    for noise in NOISE["markers" if kind == "markers" else "angles"]:
        size = noise / 1000.0 if kind == "markers" else np.radians(noise)
        for share in SHARES:
            bad = mm.corrupt(clean, noise=size, outliers=share, seed=len(found)).recording
            found[noise, share] = {
                method: off(clean, mm.repair_without_model(bad, method).recording) for method in ("adaptive", *RIVALS)
            }
    return found


def recorded(mocap: Path, kind: str, name: str, rate: float) -> mm.Motion | mm.Markers:
    """A recording as it is, but for CMU's joint angles, which are reduced to `rate` Hz."""
    if kind == "markers":
        return markers(mocap, name)
    if kind == "angles":
        return reduced(motion(mocap, name), rate)
    found = mm.read(mocap / "bvh" / f"{name}.bvh")
    assert isinstance(found, mm.Motion)
    return found


def part(whole: mm.Motion | mm.Markers, first: int, length: int) -> mm.Motion | mm.Markers:
    """So many frames of a recording."""
    if isinstance(whole, mm.Motion):
        return whole.with_q(whole.q[first : first + length])
    return mm.Markers(whole.names, whole.positions[first : first + length], whole.fps, up=whole.up)


def off(clean: mm.Motion | mm.Markers, other: mm.Motion | mm.Markers) -> float:
    """RMS error: degrees over body angles, mm over the markers that were seen."""
    if isinstance(clean, mm.Motion):
        assert isinstance(other, mm.Motion)
        return body_error(clean, other)
    assert isinstance(other, mm.Markers)
    away = distances(clean.positions, other.positions, clean.present)
    return float(10.0 * np.sqrt(np.mean(np.square(away)) / 3.0))
