"""A body, a pose of it and its surface, as kernels take them: tuples of arrays that may be written to.

Read-only arrays cost every call a microsecond each, and kernels are compiled for one kind of arrays only.
"""

from typing import NamedTuple

from ..arrays import Bytes, Floats, Ints


class Chain(NamedTuple):
    """A tree of B bones with J joint coordinates.

    Attributes
    ----------
    parents : (B,) of each bone, before its children; bone 0 is the root, free in space.
    offsets : (B, 3) m, where a bone begins in its parent's frame.
    rests : (B, 3, 3) its frame in its parent's while its coordinates are 0.
    first : (B + 1,) bone b owns the coordinates first[b] to first[b + 1].
    axes : (J, 3) of the coordinates, orthonormal within a bone, in its own frame: they turn it by
        exp(sum of axes · coordinates).
    """

    parents: Ints
    offsets: Floats
    rests: Floats
    first: Ints
    axes: Floats


class Posed(NamedTuple):
    """A pose: the root's place (3,) m and rotation (3, 3), and joint coordinates (J,) rad."""

    translation: Floats
    root: Floats
    joints: Floats


class Shell(NamedTuple):
    """P solids on a chain's bones.

    Attributes
    ----------
    carriers : (P,) the bone of each.
    kinds : (P,) as in `raycast`.
    centers, turns : (P, 3) m and (P, 3, 3), bone from solid.
    sizes, tapers : (P, 3) m and (P,), as in `raycast`.
    """

    carriers: Ints
    kinds: Bytes
    centers: Floats
    turns: Floats
    sizes: Floats
    tapers: Floats
