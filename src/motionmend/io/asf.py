"""Acclaim skeletons (.asf): the body that .amc motions refer to.

Source: Acclaim Skeleton File Definition V1.10 (M. Schafer) and CMU's notes on what Vicon writes.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import pi
from pathlib import Path

import numpy as np

from ..arrays import Floats
from ..bodies.skeleton import ROTATION, TRANSLATION, Skeleton, height, rest_positions
from ..errors import FileError, counted
from .atomic import atomic
from .supposed import length_unit, up_axis
from .text import LARGEST, read_text, shown

INCH = 0.0254
STATED_UNIT = "# metres per length unit:"  # a comment of ours, so that what we write needs no guess
DOFS = ("tx", "ty", "tz", "rx", "ry", "rz")


@dataclass(frozen=True)
class Bone:
    """One bone, or the root, as the file states it; lengths and angles in the file's units.

    Attributes
    ----------
    name : as the file spells it; "root" for the root.
    direction, length : from the bone's start to its end at rest, in the world.
    axis, axis_order : the bone's own axes: turns about the world's x, y and z, made in this order, e.g. "XYZ".
    dof : its degrees of freedom in the order of the .amc columns, of tx ty tz rx ry rz.
    limits : lower and upper, one pair for each DOF, infinite where there is none.
    """

    name: str
    direction: tuple[float, float, float]
    length: float
    axis: tuple[float, float, float]
    axis_order: str
    dof: tuple[str, ...]
    limits: tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class Asf:
    """An Acclaim skeleton file.

    Attributes
    ----------
    name : file name, e.g. "02.asf".
    text : the whole file, so that it can be written again as it was.
    metres : per unit of length.
    degrees : whether angles are in degrees; else radians.
    root : the root's own order, axes and orientation.
    position : of the root at rest, file's unit.
    bones : parents before children, in the order of the hierarchy.
    parents : (bones,) name of each bone's parent, or "root".
    guesses : what the file does not say and was supposed.
    """

    name: str
    text: str
    metres: float
    degrees: bool
    root: Bone
    position: tuple[float, float, float]
    bones: tuple[Bone, ...]
    parents: tuple[str, ...]
    guesses: tuple[str, ...] = ()

    @property
    def radians(self) -> float:
        """Radians per unit of angle."""
        return pi / 180 if self.degrees else 1.0

    def scale(self, token: str) -> float:
        """Metres or radians per unit of the degree of freedom `token`."""
        return self.radians if token.startswith("r") else self.metres


def read_asf(path: str | Path) -> Asf:
    """Read an Acclaim skeleton.

    Raises
    ------
    FileError : one line that names file, line, what was wanted and what came.
    """
    path = Path(path)
    return parse_asf(read_text(path, "an Acclaim skeleton (.asf)"), path)


def write_asf(path: str | Path, asf: Asf) -> None:
    """Write the skeleton as it was read, in UTF-8."""
    with atomic(Path(path)) as temporary:
        temporary.write_bytes(asf.text.encode())


def skeleton_of(asf: Asf) -> Skeleton:
    """The body an .asf describes, in metres and radians.

    A bone turns by R = C M C⁻¹ with C from its `axis`, so each of its turns is one about C·e in the world at rest.
    M applies the listed turns first to last about fixed axes (rx ry rz: M = Rz Ry Rx), so the DOF table, outermost
    first, holds them last to first; so for the root's `order`, its `axis` being that of the orientation at rest.
    Translations come outermost, along C·e for a bone and the world's axes for the root. A bone's joint is its
    start; a bone without children gets a joint `<bone>_end`.
    """
    names, parents, offsets = ["root"], [-1], [np.array(asf.position) * asf.metres]
    joint_of = {"root": 0}
    reach = {"root": np.zeros(3)}
    rows: list[tuple[int, str, str, Floats, tuple[float, float]]] = []
    for bone, parent in zip((asf.root, *asf.bones), ("", *asf.parents), strict=True):
        if parent:
            joint_of[bone.name] = len(names)
            names.append(bone.name)
            parents.append(joint_of[parent])
            offsets.append(reach[parent])
            reach[bone.name] = np.array(bone.direction) * (bone.length * asf.metres)
            if bone.name not in asf.parents:
                names.append(f"{bone.name}_end")
                parents.append(joint_of[bone.name])
                offsets.append(reach[bone.name])
        rows += [(joint_of[bone.name], bone.name, *row) for row in _rows(asf, bone)]
    skeleton = Skeleton(
        names=tuple(names),
        parents=np.array(parents),
        offsets=np.array(offsets),
        dof_names=tuple(f"{name}.{token}" for _, name, token, _, _ in rows),
        dof_joint=np.array([joint for joint, *_ in rows], dtype=np.int64),
        dof_axis=np.array([axis for *_, axis, _ in rows]).reshape(-1, 3),
        dof_kind=np.array([ROTATION if row[2].startswith("r") else TRANSLATION for row in rows]),
        limits=np.array([limits for *_, limits in rows]).reshape(-1, 2),
    )
    return replace(skeleton, up=up_axis(skeleton.names, rest_positions(skeleton))[0])


def _rows(asf: Asf, bone: Bone) -> Iterator[tuple[str, Floats, tuple[float, float]]]:
    """Degrees of freedom of one bone in chain order: token, axis at rest, limits in SI."""
    own = axes(bone, asf.radians)
    limits = dict(zip(bone.dof, bone.limits, strict=True))
    moves = [token for token in bone.dof if token.startswith("t")]
    turns = [token for token in bone.dof if token.startswith("r")]
    for token in (*moves, *reversed(turns)):
        world = bone is asf.root and token.startswith("t")
        low, high = limits[token]
        scale = asf.scale(token)
        letter = "xyz".index(token[1])
        yield token, np.eye(3)[letter] if world else own[:, letter], (low * scale, high * scale)


def axes(bone: Bone, radians: float) -> Floats:
    """C (3, 3): columns are the bone's own x, y and z in the world at rest."""
    matrix = np.eye(3)
    for letter in bone.axis_order:
        i = "XYZ".index(letter)
        j, k = (i + 1) % 3, (i + 2) % 3
        angle = bone.axis[i] * radians
        turn = np.eye(3)
        turn[j, j] = turn[k, k] = np.cos(angle)
        turn[k, j] = np.sin(angle)
        turn[j, k] = -turn[k, j]
        matrix = turn @ matrix
    return matrix


def parse_asf(text: str, path: Path) -> Asf:
    """The skeleton a text describes; `path` names it in messages. Raises FileError as `read_asf` does."""
    sections = _sections(text.removeprefix("\ufeff"), path)
    for keyword in ("root", "bonedata", "hierarchy"):
        if keyword not in sections:
            raise FileError(
                f"{path}: wanted an Acclaim skeleton with :root, :bonedata and :hierarchy, "
                f"found no :{keyword}; get a complete copy"
            )
    units = {words[0].lower(): words[1:] for _, words in sections.get("units", [])}
    degrees = "".join(units.get("angle", ["deg"])).lower() != "rad"
    root, position = _root(sections["root"], path)
    bones = _bones(sections["bonedata"], path)
    parents = _hierarchy(sections["hierarchy"], bones, path)
    asf = Asf(
        name=path.name,
        text=text,
        metres=1.0,
        degrees=degrees,
        root=root,
        position=position,
        bones=tuple(bones[name.lower()] for name in parents),
        parents=tuple(parents.values()),
    )
    length = _floats(units.get("length", ["1"]), 1, path, 0, "length")[0]
    if length < 1.0 / LARGEST:
        raise FileError(f"{path}: wanted a unit of length above 0 under :units, came {length:g}; correct it")
    return _with_unit(asf, length)


def _with_unit(asf: Asf, length: float) -> Asf:
    rest = skeleton_of(asf)
    stated = re.search(rf"^\s*{re.escape(STATED_UNIT)}\s*(\S+)", asf.text, flags=re.MULTILINE)
    up = up_axis(rest.names, rest_positions(rest))[1]
    if stated:
        metres = _floats([stated[1]], 1, Path(asf.name), 0, "metres per length unit")[0]
        return replace(asf, metres=metres, guesses=(f"{asf.name}: {up}",))
    candidates = (
        (INCH / length, f"inch / {length:g}, as CMU's files have it"),
        (0.01 * length, f"{length:g} cm"),
        (INCH * length, f"{length:g} inch"),
        (length, f"{length:g} m"),
        (0.001 * length, f"{length:g} mm"),
        (0.01, "cm"),
        (INCH, "inch"),
    )
    metres, guess = length_unit(height(rest), candidates, otherwise=INCH / length)
    named = f"{asf.name}: length {length:g} under :units names no unit: {guess}"
    return replace(asf, metres=metres, guesses=(named, f"{asf.name}: {up}"))


Lines = list[tuple[int, list[str]]]  # line number and words


def _sections(text: str, path: Path) -> dict[str, Lines]:
    """Words of each line under its :keyword; comments, parentheses and commas are white space."""
    sections: dict[str, Lines] = {}
    current: Lines | None = None
    for number, line in enumerate(text.splitlines(), start=1):
        line = line.split("#")[0].strip()
        if not line:
            continue
        if line.startswith(":"):
            keyword, _, rest = line[1:].partition(" ")
            current = sections.setdefault(keyword.strip().lower(), [])
            line = rest
        elif current is None:
            raise FileError(
                f"{path}, line {number}: wanted an Acclaim skeleton's :keyword, came {shown(line)}; "
                "check that this is an .asf"
            )
        if words := re.sub(r"[(),]", " ", line).split():
            current.append((number, words))
    return sections


def _root(lines: Lines, path: Path) -> tuple[Bone, tuple[float, float, float]]:
    fields = {words[0].lower(): (number, words[1:]) for number, words in lines}
    number, order = fields.get("order", (lines[0][0] if lines else 0, []))
    dof = _dof(order, path, number, "root")
    if not dof:
        raise FileError(f"{path}: wanted the root's order (such as TX TY TZ RX RY RZ), found none; add it")
    triples = {}
    for field in ("position", "orientation"):
        number, words = fields.get(field, (0, ["0", "0", "0"]))
        x, y, z = _floats(words, 3, path, number, field)
        triples[field] = (x, y, z)
    number, words = fields.get("axis", (0, ["XYZ"]))
    free = ((-np.inf, np.inf),) * len(dof)
    root = Bone("root", (0.0, 0.0, 0.0), 0.0, triples["orientation"], _order(words, path, number, "root"), dof, free)
    return root, triples["position"]


def _bones(lines: Lines, path: Path) -> dict[str, Bone]:
    """Bones by lower-case name, as Acclaim compares them."""
    bones: dict[str, Bone] = {}
    block: dict[str, tuple[int, list[str]]] | None = None
    start, field = 0, ""
    for number, words in lines:
        key = words[0].lower()
        if key == "begin":
            block, start, field = {}, number, ""
        elif block is None:
            raise FileError(f"{path}, line {number}: wanted 'begin' of a bone, came {shown(words[0])}; correct it")
        elif key == "end":
            bone = _bone(block, path, start)
            if bone.name.lower() in (*bones, "root"):
                raise FileError(f"{path}, line {start}: bone {shown(bone.name)} comes twice; rename one")
            bones[bone.name.lower()] = bone
            block = None
        elif field == "limits" and re.match(r"[-+.\d]|inf", key):
            block[field][1].extend(words)
        else:
            field = key
            block[field] = (number, words[1:])
    if block is not None:
        raise FileError(f"{path}, line {start}: this bone has no 'end': the file is cut off; get a complete copy")
    return bones


def _bone(block: dict[str, tuple[int, list[str]]], path: Path, start: int) -> Bone:
    for field in ("name", "direction", "length"):
        if not block.get(field, (0, []))[1]:
            raise FileError(f"{path}, line {start}: wanted the bone's {field}, found none; add it")
    name = " ".join(block["name"][1])
    if len(block["name"][1]) > 1:
        raise FileError(f"{path}, line {block['name'][0]}: bone name {shown(name)} has spaces; use one word")
    x, y, z = _floats(block["direction"][1], 3, path, block["direction"][0], "direction")
    length = _floats(block["length"][1], 1, path, block["length"][0], "length")[0]
    number, words = block.get("axis", (0, ["0", "0", "0", "XYZ"]))
    a, b, c = _floats(words[:3], 3, path, number, "axis")
    number, tokens = block.get("dof", (start, []))
    dof = _dof(tokens, path, number, name)
    number, words = block.get("limits", (0, ["-inf", "inf"] * len(dof)))
    bounds = _floats(words, 2 * len(dof), path, number, f"limits of {name}'s {len(dof)} degrees of freedom", np.inf)
    return Bone(
        name=name,
        direction=(x, y, z),
        length=length,
        axis=(a, b, c),
        axis_order=_order(block.get("axis", (0, []))[1][3:], path, start, name),
        dof=dof,
        limits=tuple(zip(bounds[::2], bounds[1::2], strict=True)),
    )


def _hierarchy(lines: Lines, bones: dict[str, Bone], path: Path) -> dict[str, str]:
    """Parent's name by bone's name, parents before children, each bone's children after it in file order."""
    children: dict[str, list[str]] = {}
    placed: set[str] = set()
    for number, words in lines:
        if words[0].lower() in ("begin", "end"):
            continue
        for word in words:
            if word.lower() != "root" and word.lower() not in bones:
                raise FileError(
                    f"{path}, line {number}: :hierarchy names {shown(word)}, which :bonedata lacks; correct the name"
                )
        for word in words[1:]:
            if word.lower() in placed or word.lower() == "root":
                raise FileError(f"{path}, line {number}: bone {shown(word)} has two parents; keep one")
            placed.add(word.lower())
        children.setdefault(words[0].lower(), []).extend(word.lower() for word in words[1:])
    parents: dict[str, str] = {}
    waiting = [(child, "root") for child in reversed(children.get("root", []))]
    while waiting:
        child, parent = waiting.pop()
        parents[bones[child].name] = parent
        waiting += [(c, bones[child].name) for c in reversed(children.get(child, []))]
    if lost := [bone.name for bone in bones.values() if bone.name not in parents]:
        raise FileError(f"{path}: :hierarchy does not connect bone {shown(lost[0])} to the root; add its line")
    return parents


def _dof(tokens: list[str], path: Path, number: int, name: str) -> tuple[str, ...]:
    dof = tuple(token.lower() for token in tokens)
    if "l" in dof:
        raise FileError(
            f"{path}, line {number}: {name} stretches along itself (dof l), which motionmend does not know; "
            "take l out of the .asf and its column out of the .amc"
        )
    if unknown := [token for token in tokens if token.lower() not in DOFS]:
        raise FileError(f"{path}, line {number}: wanted dof of {' '.join(DOFS)}, came {shown(unknown[0])}; correct it")
    if len(set(dof)) < len(dof):
        raise FileError(f"{path}, line {number}: {name} lists a degree of freedom twice: {' '.join(dof)}; correct it")
    return dof


def _order(words: list[str], path: Path, number: int, name: str) -> str:
    order = "".join(words).upper() or "XYZ"
    if sorted(order) != ["X", "Y", "Z"]:
        raise FileError(
            f"{path}, line {number}: wanted {name}'s axis order as XYZ in some order, came {shown(order)}; correct it"
        )
    return order


def _floats(words: list[str], count: int, path: Path, number: int, what: str, most: float = LARGEST) -> list[float]:
    place = f"{path}, line {number}" if number else str(path)
    try:
        values = [float(word) for word in words]
    except ValueError:
        values = []
    if len(values) != count or not all(abs(value) <= most for value in values):
        came = shown(" ".join(words))
        raise FileError(f"{place}: wanted {counted(count, 'number')} for {what}, came {came}; correct the line")
    return values
