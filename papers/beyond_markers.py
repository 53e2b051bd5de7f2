"""B7: gaps in markers, and both arms missing throughout

A third of the markers lose at least a quarter of their samples in gaps of 0.1 to 2 s. Arms: the cases of figure 2.6.
"""

from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

import motionmend as mm
from motionmend.arrays import Bools, Floats
from motionmend.denoise.channels.recording import from_channels, to_channels
from motionmend.denoise.rivals.marker_gaps import fill_kalman_lowdim

from .beyond_common import geometric_mean, in_parallel
from .beyond_ridge import fill_by_ridge
from .common import Findings, Table, distances, markers, only, reduced
from .fig_2_6_arms import CMU, cases

SHARE, GONE = 0.3, 0.25  # of the markers; of each one's samples at least
GAP = (0.1, 2.0)  # s
FPS, ARMS_FPS = 60.0, 30.0  # the takes in gaps and those without arms, reduced from 120
LONGEST = 300  # frames
TAUGHT = 500  # frames of the library that go before the recording for Burke and Lasenby's smoother
ALONE = "adaptive, no library"
WITHOUT = ("linear", "spline", "pca")
Take = tuple[str, int, int | None]  # name, first and last frame
TAKES: dict[str, tuple[Take, tuple[Take, ...]]] = {  # what is tried, and its library
    "CMU 02 walks": (("cmu_02_01", 0, None), (("cmu_02_05", 0, None), ("cmu_135_02", 0, 1600))),
    "CMU 02 punches": (("cmu_02_05", 600, 1200), (("cmu_02_01", 0, None), ("cmu_135_02", 0, 1600))),
    "CMU 135 martial arts": (("cmu_135_02", 3600, 4200), (("cmu_135_02", 1800, 3400), ("cmu_02_05", 0, None))),
    "HDM05 walks": (("hdm05_bd_01-02_01_120", 1600, 2200), (("hdm05_bd_01-02_01_120", 0, 1500),)),
    "SFU side skip": (("sfu_0005_SideSkip001", 0, 600), (("sfu_0018_Moonwalk001", 0, None),)),
    "squats": (("gt_squat", 900, 1500), (("sfu_0005_SideSkip001", 0, None), ("sfu_0018_Moonwalk001", 0, None))),
}


def run(mocap: Path, pictures: Path) -> Findings:
    """Error in gaps by method, with and without a library, and of arms that are never seen."""
    gaps = dict(zip(TAKES, in_parallel(partial(gap_errors, mocap), tuple(TAKES)), strict=True))
    arms = dict(zip(cases(mocap), in_parallel(partial(arm_errors, mocap), tuple(cases(mocap))), strict=True))
    alone = {k: e[ALONE] / min(e[m] for m in (*WITHOUT, "burke-lasenby")) for k, e in gaps.items()}
    taught = {
        k: e["adaptive"] / min(e[m] for m in (*WITHOUT, "burke-lasenby", "burke-lasenby, taught"))
        for k, e in gaps.items()
    }
    to_ridge = {key: errors["adaptive"] / errors["ridge"] for key, errors in arms.items()}
    values = {
        "alone_geomean": geometric_mean(list(alone.values())),
        "alone_worst": max(alone.values()),
        "taught_geomean": geometric_mean(list(taught.values())),
        "taught_worst": max(taught.values()),
        "left_open": float(np.mean([errors["open"] for errors in gaps.values()])),
        "arms_geomean": geometric_mean(list(to_ridge.values())),
        "arms_worst": max(to_ridge.values()),
        "arms_open": float(np.mean([errors["open"] for errors in arms.values()])),
        "arms_known_walker": arms["walker"]["adaptive"],
    }
    methods = ("adaptive", ALONE, *WITHOUT, "burke-lasenby", "burke-lasenby, taught")
    rows = tuple(
        (name, *(f"{errors[m]:.1f}" for m in methods), f"{taught[name]:.2f}", f"{alone[name]:.2f}")
        for name, errors in gaps.items()
    )
    arm_rows = tuple(
        (
            key,
            *(f"{errors[m]:.2f}" for m in ("adaptive", "paper", "ridge")),
            f"{to_ridge[key]:.2f}",
            f"{errors['open']:.0%}",
        )
        for key, errors in arms.items()
    )
    return Findings(
        values=values,
        notes=(
            f"Takes reduced to 60 Hz, at most {LONGEST} frames; RMS over the hidden samples that all methods fill. Without a "
            "library the adaptive method learns from the cut recording itself. Burke-Lasenby, taught: frames of the library, in the travelling "
            f"frame like the recording's, {TAUGHT} at most, stand before the recording.",
            "Arms: at 30 Hz. Ridge: linear regression of the arms on all markers that are there, in the travelling frame, its strength "
            "chosen by cross-validation over pieces of the library.",
        ),
        tables=(
            Table(
                "RMS error in gaps, mm",
                ("take", *methods, "to the best", "without one"),
                rows,
            ),
            Table(
                "Both arms missing throughout: mean distance, cm",
                ("case", "adaptive", "paper", "ridge", "ratio", "adaptive leaves open"),
                arm_rows,
            ),
        ),
    )


def gap_errors(mocap: Path, name: str) -> dict[str, float]:
    """RMS in mm of each method where all fill, and the share of the hidden samples that adaptive leaves open."""
    tried, library = TAKES[name]
    truth = _take(mocap, tried)
    truth = truth if truth.frames <= LONGEST else _part(truth, 0, LONGEST)
    hidden = _hidden(truth)
    cut = truth.with_positions(np.where(hidden[..., None], np.nan, truth.positions))
    shared = [only(_take(mocap, take), truth.names) for take in library]
    model = mm.Denoiser().fit(shared)
    filled = {"adaptive": model.repair(cut, "adaptive").recording.positions}
    filled[ALONE] = mm.repair_without_model(cut, "adaptive").recording.positions
    filled |= {method: mm.repair_without_model(cut, method).recording.positions for method in WITHOUT}
    filled["burke-lasenby"] = fill_kalman_lowdim(cut.positions).values
    filled["burke-lasenby, taught"] = _taught(cut, shared, model)
    everywhere = hidden & np.all([np.isfinite(one).all(axis=2) for one in filled.values()], axis=0)
    found = {}
    for method, positions in filled.items():
        away = distances(truth.positions, positions, everywhere)
        found[method] = float(10 * np.sqrt(np.square(away).mean()))
    return found | {"open": float((~np.isfinite(filled["adaptive"]).all(axis=2))[hidden].mean())}


def arm_errors(mocap: Path, key: str) -> dict[str, float]:
    """Mean distance in cm of arms missing throughout, by method."""
    case = cases(mocap)[key]
    learn = [_reduced(clip, ARMS_FPS) for clip in case.learn]
    model = mm.Denoiser().fit(learn)
    ways: dict[str, Callable[[mm.Markers], mm.Markers]] = {
        "adaptive": lambda cut: model.repair(cut, "adaptive").recording,
        "paper": lambda cut: model.repair(cut, "paper").recording,
        "ridge": lambda cut: fill_by_ridge(cut, learn, model.layout),
    }
    found: dict[str, list[float]] = {way: [] for way in (*ways, "open")}
    for truth in (_reduced(clip, ARMS_FPS) for clip in case.test):
        cut = mm.corrupt(truth, drop=case.arms).recording
        gone = truth.present & ~cut.present
        filled = {way: fill(cut).positions for way, fill in ways.items()}
        everywhere = gone & np.all([np.isfinite(one).all(axis=2) for one in filled.values()], axis=0)
        for way, positions in filled.items():
            found[way].append(float(distances(truth.positions, positions, everywhere).mean()))
        found["open"].append(float((~np.isfinite(filled["adaptive"]).all(axis=2))[gone].mean()))
    return {way: float(np.mean(errors)) for way, errors in found.items()}


def _taught(cut: mm.Markers, library: list[mm.Markers], model: mm.DenoiserModel) -> Floats:
    """Burke and Lasenby's smoother with the library's frames before the recording's, all in the travelling frame."""
    channels = to_channels(cut, model.layout)
    share = TAUGHT // len(library)
    before = np.concatenate([to_channels(clip, model.layout).values[:share] for clip in library])
    stacked = np.concatenate([before, channels.values])
    filled = fill_kalman_lowdim(stacked.reshape(len(stacked), -1, 3) / 100).values[len(before) :]
    values = 100 * filled.reshape(cut.frames, -1)
    everywhere: Bools = np.ones(values.shape, dtype=bool)
    return from_channels(channels, values, everywhere, cut)


def _hidden(truth: mm.Markers) -> Bools:
    rng = np.random.default_rng(0)
    frames, count = truth.present.shape
    gone = np.zeros((frames, count), dtype=bool)
    shortest, longest = (round(s * truth.fps) for s in GAP)
    for marker in rng.permutation(count)[: round(SHARE * count)]:
        while gone[:, marker].mean() < GONE:
            length = min(int(rng.integers(shortest, longest + 1)), frames // 4)
            first = int(rng.integers(1, frames - length - 1))
            gone[first : first + length, marker] = True
    return np.asarray(gone & truth.present)


def _take(mocap: Path, take: Take) -> mm.Markers:
    name, first, last = take
    whole = markers(mocap, name)
    named = CMU if name.startswith(("cmu", "hdm05")) else [one.rpartition(":")[2].upper() for one in whole.names]
    return _reduced(_part(only(whole, named), first, last), FPS)


def _reduced(recording: mm.Markers, fps: float) -> mm.Markers:
    here = reduced(recording, fps)
    assert isinstance(here, mm.Markers)
    return here


def _part(recording: mm.Markers, first: int, last: int | None) -> mm.Markers:
    return mm.Markers(recording.names, recording.positions[first:last], recording.fps, up=recording.up)
