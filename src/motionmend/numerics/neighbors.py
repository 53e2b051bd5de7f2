"""The k nearest samples: exact up to 100,000, by faiss beyond when it is installed."""

from dataclasses import dataclass, field
from functools import cached_property
from importlib.util import find_spec
from typing import Any, final

import numpy as np

from ..arrays import Floats, Ints, Singles, frozen
from ..errors import MismatchError

EXACT = 100_000  # samples; a scan of so many takes about a millisecond


@final
@dataclass(frozen=True, eq=False)
class Neighbors:
    """Samples to be searched.

    Attributes
    ----------
    samples : (N, n) float32.
    """

    samples: Singles
    columns: Singles = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "samples", frozen(self.samples, np.float32))
        if self.samples.ndim != 2:
            raise MismatchError(f"samples must be (N, n), came {self.samples.shape}")
        object.__setattr__(self, "columns", frozen(self.samples.T.copy(), np.float32))

    def nearest(self, query: Floats, k: int, weights: Floats | None = None) -> tuple[Ints, Floats]:
        """Indices of the k samples nearest to `query` (n,), nearest first, and their distances (k,).

        Distances are Euclidean after scaling each coordinate by the root of its weight (n,). Fewer than k samples:
        all of them. Ties go to the earlier sample. Above 100,000 samples faiss, when installed, answers queries
        without weights approximately (HNSW); everything else is exact.
        """
        count = min(k, len(self.samples))
        if count <= 0:
            return np.empty(0, np.int64), np.empty(0)
        wanted: Singles = np.asarray(query, np.float32)
        if weights is None and len(self.samples) > EXACT and find_spec("faiss") is not None:
            squared, index = self._graph.search(wanted[None], count)
            found = index[0] >= 0
            return index[0][found].astype(np.int64), np.sqrt(squared[0][found].astype(np.float64))
        from ..kernels.nearest import smallest, squared_distances

        scale: Singles = np.ones(len(wanted), np.float32) if weights is None else np.asarray(weights, np.float32)
        squares = np.empty(len(self.samples), np.float32)
        squared_distances(self.columns, wanted, scale, squares)
        chosen, least = np.empty(count, np.int64), np.empty(count, np.float32)
        smallest(squares, chosen, least)
        return chosen, np.sqrt(least.astype(np.float64))

    @cached_property
    def _graph(self) -> Any:
        import faiss  # type: ignore[import-not-found, import-untyped, unused-ignore]

        graph = faiss.IndexHNSWFlat(self.samples.shape[1], 32)
        graph.hnsw.efSearch = 128
        graph.add(np.ascontiguousarray(self.samples))
        return graph
