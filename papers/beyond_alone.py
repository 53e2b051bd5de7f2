"""B10, B11: recordings that come alone, as they are: no library, their own rate, joint angles and markers"""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import motionmend as mm

from .beyond_common import LEVELS, angles_off, geometric_mean, in_parallel, within
from .common import Findings, Table, body, body_error, distances, markers, motion, reduced

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
    shares = {
        (level, title, cell): float(np.mean([measured[job][cell][level] for job in members]))
        for title, members in (
            ("joint angles at 120 Hz", [job for job in jobs if job[2] == 120.0]),
            ("joint angles at 30 Hz", [job for job in jobs if job[2] == 30.0]),
            (".bvh as recorded", [job for job in jobs if job[0] == "bvh"]),
            ("markers as recorded", [job for job in jobs if job[0] == "markers"]),
        )
        for cell in cells["markers" if members[0][0] == "markers" else "angles"]
        for level in LEVELS
    }
    for level in LEVELS:
        of_level = [100.0 * share for (one, _, _), share in shares.items() if one == level]
        values |= {f"alone_{level}_low": min(of_level), f"alone_{level}_high": max(of_level)}
        values[f"alone_{level}"] = float(np.mean(of_level))
    tables.append(
        Table(
            "Errors within the 68 and 95 % intervals, mean over recordings",
            ("recordings", "noise, degrees or mm", "outliers", *(f"{level} %" for level in LEVELS)),
            tuple(
                (title, f"{n:g}", f"{s:.0%}", *(f"{100 * shares[level, title, (n, s)]:.1f} %" for level in LEVELS))
                for title, (n, s) in dict.fromkeys((title, cell) for _, title, cell in shares)
            ),
        )
    )
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
    """RMS error over body angles, degrees, or of marker places, mm, by cell and method; and what `held` gives."""
    kind, name, rate = job
    whole = recorded(mocap, kind, name, rate)
    length = round(LONGEST * whole.fps)
    clean = part(whole, 0 if kind == "bvh" else max(0, (whole.frames - length) // 2), length)
    found: dict[tuple[float, float], dict[str, float]] = {}
    for noise in NOISE["markers" if kind == "markers" else "angles"]:
        size = noise / 1000.0 if kind == "markers" else np.radians(noise)
        for share in SHARES:
            bad = mm.corrupt(clean, noise=size, outliers=share, seed=len(found)).recording
            ours = mm.repair_without_model(bad, "adaptive")
            found[noise, share] = held(clean, ours) | {"adaptive": off(clean, ours.recording)}
            for method in RIVALS:
                found[noise, share][method] = off(clean, mm.repair_without_model(bad, method).recording)
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


def held(clean: mm.Motion | mm.Markers, repaired: mm.Repaired[Any]) -> dict[str, float]:
    """Share of the errors within the intervals of `LEVELS`, of body angles or markers that were seen."""
    if isinstance(clean, mm.Motion):
        counted = body(clean)
        return within(angles_off(clean, repaired.recording)[:, counted], np.degrees(repaired.std)[:, counted])
    away = np.abs(repaired.recording.positions - clean.positions)[clean.present]
    return within(away, repaired.std[clean.present][:, None].repeat(3, axis=1))
