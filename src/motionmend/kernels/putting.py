"""Arrays put into others, element by element: as `into[:] = values` numba takes seconds to compile each."""

from ..arrays import Floats
from .compile import compiled


@compiled
def put(into: Floats, values: Floats) -> None:
    """Put values (N,) into an array of as many."""
    for i in range(into.shape[0]):
        into[i] = values[i]


@compiled
def put_matrix(into: Floats, values: Floats) -> None:
    """Put values (N, M) into an array of as many."""
    for i in range(into.shape[0]):
        for j in range(into.shape[1]):
            into[i, j] = values[i, j]
