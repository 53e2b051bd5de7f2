"""Array types spelt once, the one way an array becomes read-only, and where a mask holds."""

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int64]
Singles: TypeAlias = NDArray[np.float32]
Bytes: TypeAlias = NDArray[np.uint8]
Bools: TypeAlias = NDArray[np.bool_]


def frozen(values: ArrayLike, dtype: Any = np.float64) -> NDArray[Any]:
    """A read-only, C-contiguous view or copy of `values` as `dtype`; the caller's own array stays writeable."""
    array = np.ascontiguousarray(values, dtype=dtype)
    if not array.flags.writeable:
        return array
    if array is values or array.base is not None:
        array = array.view()
    array.flags.writeable = False
    return array


def away_from(mask: ArrayLike) -> Floats:
    """(T,) how far each index is from the nearest at which a mask (T,) holds; inf where it holds at none."""
    holds = np.asarray(mask, np.bool_)
    here = np.arange(len(holds))
    before = np.maximum.accumulate(np.where(holds, here, -np.inf))
    after = np.minimum.accumulate(np.where(holds, here, np.inf)[::-1])[::-1]
    return np.asarray(np.minimum(here - before, after - here))


def runs(mask: ArrayLike) -> list[tuple[int, int]]:
    """Start and stop, the first index after it, of each longest stretch in which a mask (T,) holds, in order."""
    inside = np.asarray(mask, np.bool_)
    holds = np.zeros(len(inside) + 2, np.bool_)
    holds[1:-1] = inside
    edges = np.flatnonzero(holds[1:] != holds[:-1])
    return [(start, stop) for start, stop in edges.reshape(-1, 2).tolist()]
