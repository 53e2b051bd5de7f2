"""What the columns of a table of joints hold: by their titles as recorders spell them, or by how many there are.

`Head_x`, `HeadX`, `Head.Position.X`, `Head pos z [mm]`, `x_Head`, `Head (x)` are coordinates of one joint; its tracking
state stands right behind them or under its name anywhere. Columns of turns, speeds, pixels and of the floor are passed
over.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Ints
from ..bodies.joint_sets import AZURE32, KINECT20, KINECT25, meanings, parents
from .number_rows import Beside

SDK = {20: KINECT20, 25: KINECT25, 32: AZURE32}
FEWEST = 4  # joints whose names say what they are, in a table of another number
_LAYOUTS = (4, 0, 0), (4, 1, 0), (3, 0, 0), (3, 1, 0), (4, 1, 4), (4, 0, 4), (4, 2, 0), (4, 2, 4)  # the likeliest first
_COORDINATE = re.compile(
    r"^(?P<joint>.+?)[\s._\-:]*(?:pos(?:ition)?)?[\s._\-:\[(]*(?P<axis>[xyz])[\])]?"
    r"(?:\s*[\[(]\s*[cm]?m\s*[\])]|[\s_]+[cm]?m)?$",
    re.IGNORECASE,
)
_AXIS_FIRST = re.compile(r"^(?:pos(?:ition)?)?[\s._\-]*(?P<axis>[xyz])[\s._\-]+(?P<joint>[^\W\d_].*)$", re.IGNORECASE)
_NUMBERED = re.compile(r"(?:joint|j)[\s._\-]*\d+", re.IGNORECASE)  # a bare number may be a marker's
_STATE = re.compile(r"^(?P<joint>.*?)[\s._\-]*(?:tracking)?[\s._\-]*(?:state|status|tracked)$", re.IGNORECASE)
_WHOSE = re.compile(
    r"^(?:(?:body|person|player|user|skeleton)[\s._\-]*(?:id|index|idx|number|no|nr)?"
    r"|track(?:ing)?[\s._\-]*(?:id|index|number))$",
    re.IGNORECASE,
)
_FRAME = re.compile(r"^frame[\s._\-#]*(?:id|index|idx|number|num|no|nr)?$", re.IGNORECASE)
_OTHERS = re.compile(  # what has an x, y and z too, and is no position
    r"(?:(?:^|[\W_])(?i:q|quat\w*|rot\w*|orient\w*|euler\w*|angles?|vel\w*|speed|acc\w*|2d|depth|colou?r|plane|lean)"
    r"|(?<=[a-z0-9])(?:Q|Quat|Rot|Orient|Euler|Angle|Vel|Speed|Acc|2D|Depth|Colou?r|Plane|Lean)[a-z]*)[\W_]*$"
)


@dataclass(frozen=True, eq=False)
class Columns:
    """Where things stand in a row.

    Attributes
    ----------
    time : column, -1 for none.
    xyz : (J, 3) columns of the joints' coordinates.
    state : (J,) columns of their tracking states, -1 where one has none; None where none has.
    titles : (J,) joints as the titles name them; empty without titles.
    frame : column of the frame's number, -1 for none.
    others : what has an x, y and z too and is none of a body's joints, as a gyroscope.
    """

    time: int
    xyz: Ints
    state: Ints | None
    titles: tuple[str, ...] = ()
    others: tuple[str, ...] = ()
    frame: int = -1


def columns_without_titles(columns: int) -> Columns | None:
    """How a row of so many numbers is laid out: perhaps a time stamp and the frame's number, the joints' x, y, z and
    perhaps state in the order of a sensor's SDK, perhaps the floor plane behind; None when it is none of a Kinect's."""
    for width, before, behind in _LAYOUTS:
        joints, rest = divmod(columns - before - behind, width)
        if joints in SDK and not rest:
            places = before + np.arange(joints * width).reshape(joints, width)
            return Columns(0 if before else -1, places[:, :3], places[:, 3] if width == 4 else None)
    return None


def columns_of(titles: Sequence[str]) -> Columns | None:
    """Where joints stand by their titles.

    None when these are no titles of a table of joints: 20, 25 or 32 of them with x, y and z, or others of which
    at least four, and half of them, say what they are on a body. Nor where one of a body's joints lacks a coordinate.
    """
    found: list[tuple[str, dict[str, int]]] = []
    latest: dict[str, dict[str, int]] = {}
    for column, title in enumerate(titles):
        match = _COORDINATE.match(title.strip()) or _AXIS_FIRST.match(title.strip())
        if match is None or _OTHERS.search(match["joint"]):
            continue
        joint, axis = match["joint"], match["axis"].lower()
        if axis in latest.get(joint, {axis: 0}):
            latest[joint] = {}
            found.append((joint, latest[joint]))
        latest[joint][axis] = column
    whole = [(joint, [axes[one] for one in "xyz"]) for joint, axes in found if len(axes) == len("xyz")]
    names = tuple(joint for joint, _ in whole)
    bodily = [bool(meaning) or above >= 0 for meaning, above in zip(meanings(names), parents(names), strict=True)]
    others: tuple[str, ...] = ()
    if sum(bodily) >= FEWEST:
        others = tuple(name for name, one in zip(names, bodily, strict=True) if not one)
        whole = [one for one, of_body in zip(whole, bodily, strict=True) if of_body]
        names = tuple(joint for joint, _ in whole)
    known = set(meanings(names)) - {""}
    torn = any(meanings([joint])[0] for joint in latest.keys() - {*names, *others})
    if torn or (len(whole) not in SDK and (len(known) < FEWEST or 2 * len(known) < len(whole))):
        return None
    xyz = np.array([places for _, places in whole], dtype=np.int64)
    before = [title.strip() for title in titles[: int(xyz.min())]]
    time = next((k for k, title in enumerate(before) if "time" in title.lower()), -1)
    frame = next((k for k, title in enumerate(before) if _FRAME.match(title)), -1)
    return Columns(time, xyz, _states(titles, names, xyz), names, others, frame)


def are_numbered(titles: Sequence[str]) -> bool:
    """Whether a table's joints have numbers for names, as many as a sensor has."""
    columns = columns_of(titles)
    return columns is not None and len(columns.titles) in SDK and all(map(_NUMBERED.fullmatch, columns.titles))


def whose_of(titles: Sequence[str]) -> int:
    """The column that says of which of several bodies a row is, -1 for none."""
    return next((k for k, title in enumerate(titles) if _WHOSE.match(title.strip())), -1)


def beside(titles: Sequence[str]) -> Beside:
    """The columns of a table of joints in which words may stand: what holds nothing of a joint, nor when or of whom a
    row is, is free: a label, an exercise, whether a hand is open."""
    whose, columns = whose_of(titles), columns_of(titles)
    if columns is None:
        return Beside(whose)
    states = [] if columns.state is None else columns.state.tolist()
    asked = {*columns.xyz.ravel().tolist(), *states, columns.time, columns.frame, whose}
    return Beside(whose, columns.time, frozenset(range(len(titles))) - asked)


def _states(titles: Sequence[str], names: Sequence[str], xyz: Ints) -> Ints | None:
    """(J,) columns of tracking states, right behind a joint's coordinates or under its name; None without any.

    Where few joints have one it is something else: whether a hand is open, or somebody is there.
    """
    stated = {k: match["joint"].lower() for k, title in enumerate(titles) if (match := _STATE.match(title.strip()))}
    by_name, plain = {joint: k for k, joint in stated.items()}, [name.lower() for name in names]
    behind = [int(one.max()) + 1 for one in xyz]
    found = [
        k if k in stated and (stated[k] == name or stated[k] not in plain) else by_name.get(name, -1)
        for k, name in zip(behind, plain, strict=True)
    ]
    return np.array(found, dtype=np.int64) if 2 * sum(k >= 0 for k in found) >= len(found) else None
