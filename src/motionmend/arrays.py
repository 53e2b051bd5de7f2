"""Array types spelt once, and the one way an array becomes read-only."""

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
    if array is values or (array.base is not None and array.flags.writeable):
        array = array.view()
    array.flags.writeable = False
    return array
