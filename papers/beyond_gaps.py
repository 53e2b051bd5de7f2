"""B6: gaps in joint angles

Three kinds: single channels in bursts, whole joints in bursts, and each arm from the shoulder down for a second.
"""

from functools import partial
from pathlib import Path

import numpy as np

import motionmend as mm
from motionmend.arrays import Bools

from .beyond_common import PROBLEMS, angles_off, geometric_mean, in_parallel, truth_of, within
from .common import Findings, Table, body, model_of

TRIED = tuple(name for name in PROBLEMS if name not in ("walk, unseen people", "run, unseen people", "mixed library"))
RIVALS = ("linear", "spline", "paper", "kalman-data")
KINDS = ("channels", "joints", "arm")
ABOUT = {
    "channels": "single channels, 10 % in bursts of 0.1 to 1 s",
    "joints": "whole joints, 10 % in bursts of 0.1 to 2 s",
    "arm": "the left arm for a second, then the right one",
}
SHARE = 0.1
BURST = (3, 30)  # frames at 30 fps
AT_REST = 0.3  # degrees; clavicles turn about one axis in these skeletons, the other two angles are always 0
ARM = ("humerus", "radius", "wrist", "hand", "fingers", "thumb")


def run(mocap: Path, pictures: Path) -> Findings:
    """RMS error on missing samples of each method, one clip of each problem."""
    cases = [(problem, kind) for problem in TRIED for kind in KINDS]
    measured = dict(zip(cases, in_parallel(partial(errors_in, mocap), cases), strict=True))
    best = {case: min(RIVALS, key=lambda name, of=found: of[name]) for case, found in measured.items()}
    ratios = {case: found["adaptive"] / found[best[case]] for case, found in measured.items()}
    values = {
        "gaps_geomean": geometric_mean(list(ratios.values())),
        "gaps_worst": max(ratios.values()),
        "gaps_open": float(np.mean([found["open"] for found in measured.values()])),
    }
    for kind in KINDS:
        values[f"gaps_{kind}"] = geometric_mean([ratio for case, ratio in ratios.items() if case[1] == kind])
    rows = tuple(
        (
            problem,
            ABOUT[kind],
            *(f"{found[name]:.2f}" for name in ("adaptive", *RIVALS)),
            f"{ratios[problem, kind]:.2f}",
        )
        for (problem, kind), found in measured.items()
    )
    return Findings(
        values=values,
        notes=(
            "The first clip of each problem at 30 fps, no noise. RMS over the missing samples of body angles that all "
            "methods fill: interpolation leaves gaps at the ends open.",
        ),
        tables=(
            Table(
                "RMS error on missing samples, degrees", ("problem", "gaps", "adaptive", *RIVALS, "to the best"), rows
            ),
        ),
    )


def errors_in(mocap: Path, case: tuple[str, str]) -> dict[str, float]:
    """RMS degrees of each method where all fill, and the share of the missing samples that adaptive leaves open."""
    model, truth, cut, missing = made(mocap, case)
    filled = {name: model.repair(cut, name).recording for name in ("adaptive", *RIVALS)}
    everywhere = missing & np.all([np.isfinite(one.q) for one in filled.values()], axis=0)
    found = {
        name: float(np.sqrt(np.mean(np.square(angles_off(truth, one)[everywhere])))) for name, one in filled.items()
    }
    return found | {"open": float(np.isnan(filled["adaptive"].q[missing]).mean())}


def coverage_in(mocap: Path, case: tuple[str, str]) -> dict[str, float]:
    """Shares of the errors on missing samples within the stated intervals of the adaptive method, mean over clips.

    By level, and "LEVEL moving" for channels that stray by more than `AT_REST` alone.
    """
    found = []
    for number in range(len(PROBLEMS[case[0]].test)):
        model, truth, cut, missing = made(mocap, case, number)
        repaired = model.repair(cut, "adaptive")
        away, std = angles_off(truth, repaired.recording), np.degrees(repaired.std)
        moving = missing & (np.degrees(truth.q.std(axis=0)) > AT_REST)
        of_moving = {f"{level} moving": share for level, share in within(away[moving], std[moving]).items()}
        found.append(within(away[missing], std[missing]) | of_moving)
    return {name: float(np.mean([one[name] for one in found])) for name in found[0]}


def made(mocap: Path, case: tuple[str, str], number: int = 0) -> tuple[mm.DenoiserModel, mm.Motion, mm.Motion, Bools]:
    """The model, one of the problem's clips, that clip with gaps, and which body angles (T, D) are missing."""
    problem, kind = case
    split = PROBLEMS[problem]
    truth = truth_of(mocap, split.test[number])
    cut = _cut(truth, kind)
    return model_of(mocap, split.learn), truth, cut, ~cut.present & body(truth)


def _cut(truth: mm.Motion, kind: str) -> mm.Motion:
    if kind == "joints":
        return mm.corrupt(truth, gaps=SHARE).recording
    gone = np.zeros(truth.q.shape, dtype=bool)
    if kind == "arm":
        for side, middle in (("l", 0.3), ("r", 0.7)):
            joints = [truth.skeleton.names.index(side + name) for name in ARM]
            first = max(1, round(middle * truth.frames - truth.fps / 2))
            last = min(first + round(truth.fps), truth.frames - 1)
            gone[first:last] |= np.isin(truth.skeleton.dof_joint, joints)
    else:
        rng = np.random.default_rng(0)
        columns = np.flatnonzero(truth.skeleton.dof_joint > 0)
        while gone.mean() < SHARE:
            first = int(rng.integers(truth.frames))
            gone[first : first + int(rng.integers(BURST[0], BURST[1] + 1)), int(rng.choice(columns))] = True
    return truth.with_q(np.where(gone, np.nan, truth.q))
