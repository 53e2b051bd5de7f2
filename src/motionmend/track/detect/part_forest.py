"""Trees that tell the part of the body of a depth pixel: trained with scikit-learn, kept as plain arrays."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from ...arrays import Floats, Singles, frozen
from ...errors import MismatchError

FAR, CLIP = 10.0, 0.6  # m: where everything but the person stands; differences of depth are held within ± CLIP


@final
@dataclass(frozen=True, eq=False)
class PartForest:
    """R trees with M nodes and L leaves in all; C parts, one at each joint.

    Attributes
    ----------
    probes : (M, 4) float32 m, across and down of the two places whose depths a node compares.
    thresholds : (M,) m, to the first child when the difference is not greater.
    children : (M, 2) int32 nodes; a leaf has -1 - (its number) in both places.
    roots : (R,) int32.
    parts : (L, C) float32, how likely a pixel that gets to the leaf is of each part.
    votes : (L, C, 3) float32 m, where the part's joint is from such a pixel, in camera axes.
    facing : (L,) float32, how likely its person faces the camera.
    """

    probes: Singles
    thresholds: Floats
    children: NDArray[np.int32]
    roots: NDArray[np.int32]
    parts: Singles
    votes: Singles
    facing: Singles

    def __post_init__(self) -> None:
        types = (np.float32, np.float64, np.int32, np.int32, np.float32, np.float32, np.float32)
        for one, dtype in zip(fields(self), types, strict=True):
            object.__setattr__(self, one.name, frozen(getattr(self, one.name), dtype))
        nodes, (number, count) = len(self.thresholds), self.parts.shape
        wanted = (nodes, 4), (nodes,), (nodes, 2), self.roots.shape, (number, count), (number, count, 3), (number,)
        for one, shape in zip(fields(self), wanted, strict=True):
            if getattr(self, one.name).shape != shape:
                raise MismatchError(f"a forest's {one.name} must be {shape}, came {getattr(self, one.name).shape}")
        inner = self.children[:, 0] >= 0
        sound = np.all((self.children[:, 0] >= 0) == (self.children[:, 1] >= 0))
        # Children come after their parents, so that every walk ends.
        sound &= np.all(self.children[inner] > np.flatnonzero(inner)[:, None])
        sound &= bool(np.all(self.children < nodes) and np.all(-1 - self.children[~inner] < number))
        if not (sound and nodes and np.all((self.roots >= 0) & (self.roots < nodes))):
            raise MismatchError("a forest's nodes must form trees; fit it anew")

    def arrays(self) -> dict[str, NDArray[Any]]:
        """All of it by name, for a model file; what the leaves say with 16 bits, far finer than its error."""
        stored = {one.name: np.asarray(getattr(self, one.name)) for one in fields(self)}
        return stored | {name: stored[name].astype(np.float16) for name in ("parts", "votes", "facing")}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> "PartForest":
        """The forest that `arrays` gave.

        Raises
        ------
        MismatchError : when an array is missing or of another shape.
        """
        missing = [one.name for one in fields(cls) if one.name not in arrays]
        if missing:
            raise MismatchError(f"a forest needs the arrays {', '.join(missing)}; fit the model anew")
        return cls(**{one.name: arrays[one.name] for one in fields(cls)})


def differences(depth: Singles, pixels: NDArray[np.int32], focal: tuple[float, float], probes: Singles) -> Singles:
    """Depth differences (N, F) in m of pixels (N, 2) as (row, column) for probes (F, 4).

    Parameters
    ----------
    depth : (H, W) m with NaN where the person is not.
    focal : (fx, fy) px.
    """
    from ...kernels import forest

    out = np.empty((len(pixels), len(probes)), np.float32)
    rows, columns = np.ascontiguousarray(pixels.T, np.int32)
    forest.differences(_filled(depth), rows, columns, *focal, FAR, CLIP, frozen(probes, np.float32), out)
    return out


def leaves(
    forest: PartForest, depth: Singles, pixels: NDArray[np.int32], focal: tuple[float, float]
) -> NDArray[np.int32]:
    """Leaf numbers (N, R) of pixels (N, 2); arguments as of `differences`."""
    from ...kernels import forest as kernel

    out = np.empty((len(pixels), len(forest.roots)), np.int32)
    rows, columns = np.ascontiguousarray(pixels.T, np.int32)
    kernel.leaves(
        _filled(depth),
        rows,
        columns,
        *focal,
        FAR,
        CLIP,
        forest.probes,
        forest.thresholds,
        forest.children,
        forest.roots,
        out,
    )
    return out


def grown(features: Singles, labels: NDArray[np.int64], depth: int, smallest: int, tried: int, seed: int) -> Any:
    """One scikit-learn decision tree for parts of the body.

    Parameters
    ----------
    features : (N, F) depth differences, m.
    labels : (N,) part of each sample.
    depth : of the tree, at most.
    smallest : samples in a leaf, at least.
    tried : features that each split looks at.
    seed : of their choice.

    Source
    ------
    Shotton et al. 2011, section 3.3.
    """
    from sklearn.tree import DecisionTreeClassifier

    tree = DecisionTreeClassifier(
        criterion="entropy", max_depth=depth, min_samples_leaf=smallest, max_features=tried, random_state=seed
    )
    return tree.fit(features, labels)


def planted(trees: list[Any], probes: list[Singles], parts: int) -> PartForest:
    """scikit-learn's trees as one forest, leaves in node order; votes are 0 and facing a half until they are learned.

    Parameters
    ----------
    trees : R fitted DecisionTreeClassifier.
    probes : R of (F, 4), the features that each was fitted on.
    parts : C, labels are 0 to C - 1; one that a tree never saw has probability 0.
    """
    all_probes, thresholds, children, roots, tables = [], [], [], [], []
    nodes = number = 0
    for tree, tested in zip(trees, probes, strict=True):
        inner = tree.tree_
        leaf = inner.children_left < 0
        names = number + np.cumsum(leaf) - 1
        pair = np.stack([inner.children_left, inner.children_right], axis=1) + nodes
        children.append(np.where(leaf[:, None], -1 - names[:, None], pair))
        all_probes.append(np.where(leaf[:, None], 0.0, tested[np.where(leaf, 0, inner.feature)]))
        thresholds.append(np.where(leaf, 0.0, inner.threshold))
        table = np.zeros((int(leaf.sum()), parts))
        share = inner.value[leaf, 0]
        table[:, tree.classes_] = share / share.sum(axis=1, keepdims=True)
        tables.append(table)
        roots.append(nodes)
        nodes, number = nodes + len(leaf), number + int(leaf.sum())
    table = np.concatenate(tables)
    return PartForest(
        np.concatenate(all_probes).astype(np.float32),
        np.concatenate(thresholds),
        np.concatenate(children).astype(np.int32),
        np.array(roots, np.int32),
        table.astype(np.float32),
        np.zeros((number, parts, 3), np.float32),
        np.full(number, 0.5, np.float32),
    )


def _filled(depth: Singles) -> Singles:
    return np.nan_to_num(np.asarray(depth, np.float32), nan=FAR)
