"""What the package is measured against: the same results by plain NumPy, as one would write them without kernels.

Plain does not mean slow on purpose: everything is vectorised and the matrix products go to the same BLAS. The tests'
own twins, which are written for reading, serve as a third opinion on short recordings.
"""

import importlib.util
from pathlib import Path
from types import ModuleType

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from motionmend.arrays import Floats, Ints
from motionmend.bodies.skeleton import ROTATION, Skeleton
from motionmend.denoise.bases.optimise import PRIOR_WEIGHT, SCALE
from motionmend.numerics.robust import ESTIMATORS
from motionmend.numerics.ssa import Eigenbases


def of_tests(name: str = "naive") -> ModuleType:
    """The tests' plain twins of kernels, `tests/NAME.py`."""
    path = Path(__file__).parents[1] / "tests" / f"{name}.py"
    found = importlib.util.spec_from_file_location(f"motionmend_{name}", path)
    assert found is not None
    assert found.loader is not None
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    return module


# ---- learning ------------------------------------------------------------------------


def trajectory_matrix(series: Floats, window: int) -> Floats:
    """(S, M * C): every lag window a row of its own, all in memory (eq. 2.1-2.2)."""
    windows = sliding_window_view(series, window, axis=0).transpose(0, 2, 1)
    return np.ascontiguousarray(windows).reshape(len(windows), -1)


def lag_products(series: Floats, window: int) -> Floats:
    """D^T D by one product (eq. 2.3); NumPy knows that it is symmetric and does half the work."""
    rows = trajectory_matrix(series, window)
    return np.asarray(rows.T @ rows)


def leading(matrix: Floats, energy: float) -> tuple[Floats, Floats]:
    """Eigenvalues (K,) and vectors (N, K) that hold `energy` of the trace, by the full decomposition."""
    values, vectors = np.linalg.eigh(matrix)
    values, vectors = values[::-1], vectors[:, ::-1]
    count = int(np.argmax(np.cumsum(values) >= energy * values.sum())) + 1
    return values[:count], vectors[:, :count]


# ---- repair --------------------------------------------------------------------------


def alternate(measured: Floats, start: Floats, bases: Eigenbases, iterations: int) -> Floats:
    """The alternation of section 2.2.4 with every window in memory: eq. 2.13, then eq. 2.15, so many times over.

    Parameters
    ----------
    measured : (T, C), NaN = missing.
    start : (T, C) finite.
    bases : patterns at the rate of `measured`.
    iterations : of both updates.

    Returns
    -------
    (T, C) z.
    """
    weight = ESTIMATORS["welsch"].weight
    flat, mean = bases.vectors.reshape(bases.count, -1), bases.mean.ravel()
    seen = np.isfinite(measured)
    known = np.where(seen, measured, 0.0)
    count = _covered(len(measured), bases.window)
    z = start
    for _ in range(iterations):
        coefficients = (trajectory_matrix(z, bases.window) - mean) @ flat.T  # eq. 2.13
        rebuilt = _overlap_add(coefficients @ flat + mean, bases.window, len(z))
        w = seen * weight(z - known, SCALE)
        z = (w * known + 2 * PRIOR_WEIGHT * rebuilt) / (w + 2 * PRIOR_WEIGHT * count)  # eq. 2.15
    return z


def cost(z: Floats, measured: Floats, bases: Eigenbases) -> float:
    """Eq. 2.16 with the coefficients at their best for z."""
    seen = np.isfinite(measured)
    flat = bases.vectors.reshape(bases.count, -1)
    away = trajectory_matrix(z, bases.window) - bases.mean.ravel()
    left = away - (away @ flat.T) @ flat
    rho = ESTIMATORS["welsch"].rho(z[seen] - measured[seen], SCALE)
    return float(rho.sum() + PRIOR_WEIGHT * np.square(left).sum())


def iterations_to(goal: float, measured: Floats, start: Floats, bases: Eigenbases, most: int) -> int:
    """How many plain alternations bring the cost to `goal`; `most` when they do not."""
    z = start
    for done in range(1, most + 1):
        z = alternate(measured, z, bases, 1)
        if cost(z, measured, bases) <= goal:
            return done
    return most


def _covered(frames: int, window: int) -> Floats:
    """(T, 1) how many windows hold each frame."""
    return np.convolve(np.ones(frames - window + 1), np.ones(window))[:, None]


def _overlap_add(rows: Floats, window: int, frames: int) -> Floats:
    """(T, C): rows (S, M * C) laid at their own frames, one place in the window after the other."""
    placed = rows.reshape(len(rows), window, -1)
    total = np.zeros((frames, placed.shape[2]))
    for place in range(window):
        total[place : place + len(rows)] += placed[:, place]
    return total


# ---- kinematics ----------------------------------------------------------------------


def forward(skeleton: Skeleton, q: Floats) -> tuple[Floats, Floats]:
    """Positions (T, J, 3) and rotations (T, J, 3, 3): all frames at once, joint by joint and turn by turn."""
    frames, joints = len(q), len(skeleton.names)
    position, rotation = np.empty((frames, joints, 3)), np.empty((frames, joints, 3, 3))
    for joint, parent in enumerate(skeleton.parents):
        turned = np.tile(np.eye(3), (frames, 1, 1)) if parent < 0 else rotation[:, parent]
        place = np.zeros((frames, 3)) if parent < 0 else position[:, parent]
        place = place + turned @ skeleton.offsets[joint]
        for row in _rows(skeleton, joint):
            axis, value = skeleton.dof_axis[row], q[:, row]
            if skeleton.dof_kind[row] == ROTATION:
                turned = turned @ _about(axis, value)
            else:
                place = place + value[:, None] * (turned @ axis)
        position[:, joint], rotation[:, joint] = place, turned
    return position, rotation


def _rows(skeleton: Skeleton, joint: int) -> Ints:
    return np.flatnonzero(skeleton.dof_joint == joint)


def _about(axis: Floats, angle: Floats) -> Floats:
    """(T, 3, 3) Rodrigues' formula."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    sine, versine = np.sin(angle)[:, None, None], (1.0 - np.cos(angle))[:, None, None]
    return np.asarray(np.eye(3) + sine * cross + versine * (cross @ cross))
