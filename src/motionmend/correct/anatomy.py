"""What correction needs to know of a joint set: its tree, its two sides, its trunk."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..arrays import Bools, Floats, Ints
from ..bodies.joint_sets import correspondence, meanings, mirrored, parents

ACROSS = ("clavicle", "shoulder", "hip")
TRUNK = ("pelvis", "spine", "chest", "neck_base", *(f"{side}_{one}" for side in "lr" for one in ACROSS))


@dataclass(frozen=True, eq=False)
class Anatomy:
    """A joint set as correction sees it.

    Attributes
    ----------
    names : (J,).
    parents : (J,) -1 for a root.
    mirror : (J,) the joint on the other side, its own number in the middle.
    bones : (B, 2) parent and child.
    across : (P, 2) left and right joints of the trunk, which show where the person faces.
    trunk : (J,) joints of the trunk.
    upper, lower : joints that lie above and below one another in a person who stands or sits.
    legs : (L, 3) hip, knee and ankle.
    feet : (F, 2) ankle and foot.
    """

    names: tuple[str, ...]
    parents: Ints
    mirror: Ints
    bones: Ints
    across: Ints
    trunk: Bools
    upper: Ints
    lower: Ints
    legs: Ints
    feet: Ints

    @cached_property
    def near(self) -> Ints:
        """(J, N) each joint itself and those that share a bone with it (section 4.1), ascending; the rest J."""
        rows = [{j} for j in range(len(self.names))]
        for parent, child in self.bones:
            rows[parent].add(int(child))
            rows[child].add(int(parent))
        table = np.full((len(rows), max((len(row) for row in rows), default=0)), len(rows))
        for j, row in enumerate(rows):
            table[j, : len(row)] = sorted(row)
        return table

    @cached_property
    def limbs(self) -> tuple[tuple[Ints, ...], ...]:
        """For each pair of limbs, what may be confused of it: left and right joints (N, 2) from each joint outward, and
        each alone."""
        beyond = np.eye(len(self.names), dtype=np.bool_)  # (J, J) the joint and what hangs on it
        for _ in self.names:
            for parent, child in self.bones:
                beyond[parent] |= beyond[child]
        loose = [k for k, m in enumerate(self.mirror) if m != k and not self.trunk[k]]
        tops = [k for k in loose if k < self.mirror[k] and self.parents[k] not in loose]
        parts = np.concatenate([beyond, np.eye(len(self.names), dtype=np.bool_)])
        return tuple(
            tuple(
                np.array([(j, self.mirror[j]) for j in np.flatnonzero(part)], dtype=np.int64)
                for part in np.unique(parts[np.r_[limb, len(beyond) + limb]], axis=0)
            )
            for limb in (np.array([k for k in loose if beyond[top, k]], dtype=np.int64) for top in tops)
        )

    @cached_property
    def twins(self) -> Ints:
        """(B,) the bone on the other side, its own number in the middle or where there is none."""
        of_child = {int(child): b for b, (_, child) in enumerate(self.bones)}
        return np.array([of_child.get(int(self.mirror[c]), b) for b, (_, c) in enumerate(self.bones)], dtype=np.int64)

    @cached_property
    def parts(self) -> Ints:
        """(B,) 0 for bones of the trunk, else the limbs they are of, 1 and up, the same on both sides."""
        found = np.zeros(len(self.bones), dtype=np.int64)
        for b, (parent, child) in enumerate(self.bones):
            top, above = int(child), int(parent)
            while above >= 0 and not self.trunk[above] and not self.trunk[top]:
                top, above = above, int(self.parents[above])
            found[b] = 0 if self.trunk[top] else 1 + min(top, int(self.mirror[top]))
        return np.asarray(np.unique(np.append(found, 0), return_inverse=True)[1][:-1])

    @cached_property
    def pairs(self) -> Ints:
        """(M, 2) left and right joints, each pair once."""
        return np.array([(k, m) for k, m in enumerate(self.mirror) if k < m], dtype=np.int64).reshape(-1, 2)


def anatomy(names: Sequence[str]) -> Anatomy:
    """The anatomy of a joint set, by what its names mean."""
    above, meant, other = parents(names), meanings(names), mirrored(names)
    place = {meaning: k for k, meaning in enumerate(meant) if meaning}
    bones = [(int(p), k) for k, p in enumerate(above) if p >= 0]
    across = [(place[f"l_{one}"], place[f"r_{one}"]) for one in ACROSS if {f"l_{one}", f"r_{one}"} <= place.keys()]
    legs = [_places(place, *(f"{side}_{one}" for one in ("hip", "knee", "ankle"))) for side in "lr"]
    feet = [_places(place, *(f"{side}_{one}" for one in ("ankle", "foot"))) for side in "lr"]
    trunk = np.array([meaning in TRUNK for meaning in meant], dtype=np.bool_)
    return Anatomy(
        tuple(names),
        above,
        other,
        np.array(bones, dtype=np.int64).reshape(-1, 2),
        np.array(across, dtype=np.int64).reshape(-1, 2),
        trunk if trunk.any() else np.ones(len(trunk), dtype=np.bool_),
        _places(place, "head", "neck", "neck_base", "l_shoulder", "r_shoulder"),
        _places(place, "pelvis", "l_hip", "r_hip", "l_knee", "r_knee", "l_ankle", "r_ankle"),
        np.array([leg for leg in legs if len(leg) == 3], dtype=np.int64).reshape(-1, 3),
        np.array([foot for foot in feet if len(foot) == 2], dtype=np.int64).reshape(-1, 2),
    )


def following(names: Sequence[str], known: Bools) -> Floats:
    """How joints without a value of their own take it from their neighbours in the tree.

    Parameters
    ----------
    names : (J,).
    known : (J,) joints that have a value.

    Returns
    -------
    (J, J) rows that average over known joints: each unknown joint is the mean of its neighbours, solved together; a
    part of the tree without any known joint takes the mean of all.
    """
    count = len(names)
    laplacian = np.zeros((count, count))
    for child, parent in enumerate(parents(names)):
        if parent >= 0:
            laplacian[[child, parent], [child, parent]] += 1.0
            laplacian[[child, parent], [parent, child]] -= 1.0
    rows = np.zeros((count, count))
    have, lack = np.flatnonzero(known), np.flatnonzero(~known)
    if not len(have):
        return rows
    rows[have, have] = 1.0
    if len(lack):
        inner = laplacian[np.ix_(lack, lack)] + 1e-9 * np.eye(len(lack))
        outer = 1e-9 / len(have) - laplacian[np.ix_(lack, have)]
        rows[np.ix_(lack, have)] = np.linalg.solve(inner, outer)
    return rows


def matched(source: Sequence[str], target: Sequence[str]) -> Ints:
    """(J of target,) the joint of `source` that means the same; -1 where none does."""
    return correspondence(source, target)


def _places(place: dict[str, int], *wanted: str) -> Ints:
    return np.array([place[one] for one in wanted if one in place], dtype=np.int64)
