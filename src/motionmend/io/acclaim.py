"""Any skeleton as an Acclaim one (.asf), as far as Acclaim can express it."""

import re
import warnings
from dataclasses import dataclass
from itertools import permutations
from math import pi
from pathlib import Path

import numpy as np

from ..arrays import Floats, Ints
from ..bodies.skeleton import ROTATION, TRANSLATION, Skeleton
from ..errors import MismatchError
from .asf import INCH, STATED_UNIT, Asf, parse_asf

CMU_LENGTH = 0.45  # what CMU's files state under :units: one unit is an inch / 0.45
UNIT = INCH / CMU_LENGTH  # m
SMALL = 1e-9


@dataclass(frozen=True)
class Plan:
    """One bone to be: its own joint, or None for a bone that only leads to another's start."""

    name: str
    parent: str
    reach: Floats  # (3,) m
    joint: int | None


def asf_of(skeleton: Skeleton, name: str = "skeleton.asf") -> Asf:
    """Write `skeleton` down as an Acclaim skeleton.

    Acclaim lets children start only where their parent's bone ends. So where children of one joint start at
    different places, bones without degrees of freedom, `<child>_link`, lead to them, as CMU's lhipjoint does.
    The root becomes "root", other joints keep their names, degrees of freedom become rx ry rz tx ty tz.

    Parameters
    ----------
    skeleton : one root; each joint first moves, then turns about at most three perpendicular axes.
    name : file name for the result.

    Raises
    ------
    MismatchError : when Acclaim cannot express the skeleton; says which joint and why.
    """
    plans = _plans(skeleton)
    root, own = dof_tokens(skeleton, 0)
    lines = [
        f"{STATED_UNIT} {UNIT!r}",
        ":version 1.10",
        f":name {Path(name).stem}",
        f":units\n  mass 1.0\n  length {CMU_LENGTH}\n  angle deg",
        ":documentation\n  written by motionmend",
        f":root\n  order {' '.join(root).upper()}\n  axis XYZ",
        f"  position {_numbers(skeleton.offsets[0] / UNIT)}\n  orientation {_numbers(_angles(own))}",
        ":bonedata",
    ]
    for i, plan in enumerate(plans, start=1):
        length = float(np.linalg.norm(plan.reach))
        direction = plan.reach / length if length > 0 else np.array([0.0, 1.0, 0.0])
        tokens, own = ({}, np.eye(3)) if plan.joint is None else dof_tokens(skeleton, plan.joint)
        lines += [
            f"  begin\n    id {i}\n    name {plan.name}",
            f"    direction {_numbers(direction)}\n    length {length / UNIT!r}",
            f"    axis {_numbers(_angles(own))} XYZ",
        ]
        if tokens:
            lines.append(f"    dof {' '.join(tokens)}")
            lines.append("    limits " + "\n           ".join(_limits(skeleton, tokens)))
        lines.append("  end")
    lines.append(":hierarchy\n  begin")
    for parent in ("root", *(plan.name for plan in plans)):
        if children := [plan.name for plan in plans if plan.parent == parent]:
            lines.append(f"    {parent} {' '.join(children)}")
    lines.append("  end\n")
    return parse_asf("\n".join(lines), Path(name))


def dof_tokens(skeleton: Skeleton, joint: int) -> tuple[dict[str, int], Floats]:
    """How Acclaim names a joint's degrees of freedom.

    Returns
    -------
    tokens : row of the DOF table by token, in the order of the .amc columns.
    own : (3, 3) the joint's own axes as columns, in the world at rest.

    Raises
    ------
    MismatchError : when Acclaim cannot express the joint.
    """
    rows = skeleton.dofs_of(joint)
    name = skeleton.names[joint]
    turns = rows[skeleton.dof_kind[rows] == ROTATION]
    moves = rows[skeleton.dof_kind[rows] == TRANSLATION]
    if len(moves) and len(turns) and moves.max() > turns.min():
        raise MismatchError(f"joint {name} moves after it turns, an .asf joint moves first; write .bvh instead")
    main = turns if len(turns) else moves
    letters, own = _own_axes(skeleton, main, name)
    tokens: dict[str, int] = {}
    frame = np.eye(3) if joint == 0 else own  # the root moves along the world's axes
    for row in moves:
        along = frame.T @ skeleton.dof_axis[row]
        letter = int(np.argmax(along))
        if abs(along[letter] - 1) > SMALL or f"t{'xyz'[letter]}" in tokens:
            raise MismatchError(
                f"joint {name} moves along {skeleton.dof_axis[row].round(4).tolist()}, "
                "an .asf joint moves along its own x, y or z, each once; write .bvh instead"
            )
        tokens[f"t{'xyz'[letter]}"] = int(row)
    for row, letter in reversed([*zip(turns, letters, strict=False)]):  # applied first = innermost = listed first
        tokens[f"r{'xyz'[letter]}"] = int(row)
    return tokens, own


def _own_axes(skeleton: Skeleton, rows: Ints, name: str) -> tuple[tuple[int, ...], Floats]:
    """Letters (0 = x) of the rows and a right-handed frame in which each row's axis is its letter's."""
    given = skeleton.dof_axis[rows]
    if len(rows) > 3 or np.abs(given @ given.T - np.eye(len(rows))).max(initial=0.0) > SMALL:
        raise MismatchError(
            f"joint {name} has {len(rows)} axes that are not perpendicular to each other, "
            "an .asf joint has at most three perpendicular ones; write .bvh instead"
        )
    named = [re.search(r"([xyz])(?:rotation|position)?$", skeleton.dof_names[row].lower()) for row in rows]
    hint = tuple("xyz".index(found[1]) if found else -1 for found in named)
    principal = tuple(int(np.argmax(np.abs(axis))) for axis in given)
    for letters in (hint, principal, *permutations(range(3), len(rows))):
        if len({*letters, -1}) == len(letters) + 1:  # each letter once, none unknown
            own = _completed(dict(zip(letters, given, strict=True)))
            if np.linalg.det(own) > 0:
                return letters, own
    raise AssertionError("one of two odd and even orders is right-handed")


def _completed(given: dict[int, Floats]) -> Floats:
    """A frame (3, 3) with the given columns, right-handed unless all three are given."""
    columns = dict(given)
    if not columns:
        return np.eye(3)
    if len(columns) == 1:
        ((letter, axis),) = columns.items()
        second = next(e for i in (1, 2) if abs((e := np.eye(3)[(letter + i) % 3]) @ axis) < 0.9)
        second = second - (second @ axis) * axis
        columns[(letter + 1) % 3] = second / np.linalg.norm(second)
    for letter in set(range(3)) - set(columns):
        columns[letter] = np.cross(columns[(letter + 1) % 3], columns[(letter + 2) % 3])
    return np.stack([columns[letter] for letter in range(3)], axis=1)


def _plans(skeleton: Skeleton) -> list[Plan]:
    """The bones that hold the skeleton's joints, parents first."""
    _check_names(skeleton)
    children = [np.flatnonzero(skeleton.parents == j) for j in range(len(skeleton.names))]
    reach = np.zeros_like(skeleton.offsets)  # (J, 3) where the joint's own bone ends; the root has none
    for joint in range(1, len(skeleton.names)):
        ends = skeleton.offsets[children[joint]]
        if len(ends) and np.abs(ends - ends[0]).max() <= SMALL:
            reach[joint] = ends[0]
    plans: list[Plan] = []
    for joint in range(1, len(skeleton.names)):
        name, above = skeleton.names[joint], int(skeleton.parents[joint])
        parent = skeleton.names[above] if above else "root"
        is_end = name == f"{parent}_end" and not len(children[joint]) and not len(skeleton.dofs_of(joint))
        if is_end and above and len(children[above]) == 1:
            continue  # a reader makes this joint of its parent's bone
        gap = skeleton.offsets[joint] - reach[above]
        if np.abs(gap).max() > SMALL:
            plans.append(Plan(f"{name}_link", parent, gap, None))
            parent = f"{name}_link"
        plans.append(Plan(name, parent, reach[joint], joint))
    return plans


def _check_names(skeleton: Skeleton) -> None:
    if (roots := int((skeleton.parents < 0).sum())) != 1:
        raise MismatchError(f"an .asf has one root, this skeleton has {roots}; write .bvh instead")
    if not len(skeleton.dofs_of(0)):
        raise MismatchError(f"the root of an .asf moves, {skeleton.names[0]} has no degree of freedom")
    seen = {"root"}
    for name in skeleton.names[1:]:
        if re.search(r"[\s#(),]", name) or name.lower() in seen or not name:
            raise MismatchError(
                f"joint name {name!r} cannot stand in an .asf: one word without # ( ) or comma, "
                "unlike every other and unlike 'root'; rename it or write .bvh instead"
            )
        seen.add(name.lower())


def _angles(own: Floats) -> Floats:
    """Turns (3,) in degrees about the world's x, then y, then z that make the frame."""
    from scipy.spatial.transform import Rotation

    with warnings.catch_warnings():  # at 90° about y two of the angles are one freedom; any choice will do
        warnings.filterwarnings("ignore", message="Gimbal lock")
        return np.asarray(Rotation.from_matrix(own).as_euler("xyz", degrees=True))


def _limits(skeleton: Skeleton, tokens: dict[str, int]) -> list[str]:
    scale = {token: pi / 180 if token.startswith("r") else UNIT for token in tokens}
    return [f"({_numbers(skeleton.limits[row] / scale[token])})" for token, row in tokens.items()]


def _numbers(values: Floats) -> str:
    return " ".join(repr(float(value)) for value in values)
