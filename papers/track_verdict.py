"""Who is right where the tracker and the sensor's own skeleton disagree, by the depth image alone."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from motionmend.arrays import Bools, Floats
from motionmend.bodies.camera import DepthFrame
from motionmend.bodies.joint_sets import parents
from motionmend.bodies.performer import LANDMARKS
from motionmend.report.style import figure_at

DISPUTED = 20.0  # cm between the two, with and without a constant offset for each joint
BEFORE = 0.03  # m, by which a bone before the visible surface is refuted: it lies within the body
BESIDE = 0.04  # m, by which a bone may be beside what it belongs to
MARGIN = 0.008  # m^2, about two hands: less does not decide
# The thickest part of the body about each bone, m, with clothes; the last of a limb reaches to fingers and toes.
_BONES = (
    ("pelvis", "chest", 0.20, 0.0),
    ("chest", "neck", 0.20, 0.0),
    ("neck", "head", 0.16, 0.12),
    *((f"{side}_{a}", f"{side}_{b}", radius, beyond) for side in "lr" for a, b, radius, beyond in (
        ("shoulder", "elbow", 0.10, 0.0),
        ("elbow", "wrist", 0.09, 0.20),
        ("hip", "knee", 0.14, 0.0),
        ("knee", "ankle", 0.11, 0.10),
    )),
    ("l_shoulder", "r_shoulder", 0.14, 0.0),
    ("l_hip", "r_hip", 0.18, 0.0),
    ("neck", "pelvis", 0.20, 0.0),
)  # fmt: skip
LIMBS = tuple((f"{side}_{a}", f"{side}_{b}", f"{side}_{c}") for side in "lr" for a, b, c in (
    ("shoulder", "elbow", "wrist"),
    ("hip", "knee", "ankle"),
))  # fmt: skip


@dataclass(frozen=True)
class Dispute:
    """A limb in a frame: how far apart (cm), and the area (m^2) held against either, ours and theirs."""

    frame: int
    limb: str
    apart: float
    ours: float
    theirs: float

    @property
    def right(self) -> str:
        """`ours`, `sensor`, `neither` or `open`."""
        if min(self.ours, self.theirs) > 2.0 * MARGIN:
            return "neither"
        if abs(self.ours - self.theirs) < MARGIN:
            return "open"
        return "ours" if self.ours < self.theirs else "sensor"


def disputes(ours: Floats, theirs: Floats, lost: Bools, frames: Sequence[DepthFrame], moving: float) -> list[Dispute]:
    """Every limb in every frame that is apart.

    Parameters
    ----------
    ours, theirs : (T, 16, 3) m, camera axes, NaN where there is no such joint.
    lost : (T,) frames that do not count.
    moving : m, joints that go less far do not count.
    """
    raw = ours - theirs
    settled = raw - np.median(raw[~lost], axis=0)
    # A limb that is wrong most of the time has a wrong offset; where the two agree without one there is no dispute.
    apart = 100.0 * np.minimum(np.linalg.norm(raw, axis=2), np.linalg.norm(settled, axis=2))
    moves = np.ptp(theirs, axis=0).max(axis=1) > moving
    found = []
    for t in np.flatnonzero(~lost):
        for limb in LIMBS:
            joints = [LANDMARKS.index(name) for name in limb[1:]]
            gap = max((float(apart[t, j]) for j in joints if moves[j]), default=0.0)
            if gap > DISPUTED:
                against = [_against(places[t], limb, frames[int(t)]) for places in (ours, theirs)]
                found.append(
                    Dispute(int(t), f"{limb[0][0]} {'arm' if limb[1].endswith('elbow') else 'leg'}", gap, *against)
                )
    return found


def _against(joints: Floats, limb: Sequence[str], frame: DepthFrame) -> float:
    """m^2: parts of a limb that lie beside the body or before its surface, and surface that no bone is behind."""
    from scipy.ndimage import minimum_filter

    camera, depth = frame.camera, frame.depth
    beside = round(BESIDE * camera.fx / float(np.nanmedian(depth)))
    nearest = minimum_filter(np.where(np.isfinite(depth), depth, np.inf), 2 * beside + 1)
    area = 0.0
    for a, b in pairwise(limb):
        begin, end = (joints[LANDMARKS.index(name)] for name in (a, b))
        radius = next(r for one, other, r, _ in _BONES if (one, other) == (a, b)) / 2  # a limb is half as thick at most
        some = begin + np.linspace(0.0, 1.0, 21)[:, None] * (end - begin)
        pixels = np.round(camera.project(some)).astype(int)
        u, v = np.clip(pixels[:, 0], 0, camera.width - 1), np.clip(pixels[:, 1], 0, camera.height - 1)
        refuted = some[:, 2] < nearest[v, u] - BEFORE  # beside the body nearest is infinite
        area += float(refuted.mean()) * float(np.linalg.norm(end - begin)) * 2 * radius
    points = camera.points(depth)[::2, ::2].reshape(-1, 3)
    points = points[np.isfinite(points).all(axis=1)]
    free = np.full(len(points), np.inf)
    for a, b, radius, beyond in _BONES:
        begin, end = joints[LANDMARKS.index(a)], joints[LANDMARKS.index(b)]
        if np.isfinite(begin).all() and np.isfinite(end).all():
            length = max(float(np.linalg.norm(end - begin)), 1e-6)
            along = (end - begin) / length
            share = np.clip((points - begin) @ along, 0.0, length + beyond)
            free = np.minimum(free, np.linalg.norm(points - begin - share[:, None] * along, axis=1) - radius)
    near_feet = points[:, 1] > np.nanmax(joints[:, 1]) - 0.10  # where shoes and floor are no bone is behind
    unit = 4.0 * points[:, 2] ** 2 / (camera.fx * camera.fy)
    return area + float(unit[(free > 0.03) & ~near_feet].sum())


def draw(path: Path, rows: Sequence[tuple[DepthFrame, Floats, Floats, str]]) -> None:
    """Depth with both skeletons from the camera and from the side, ours orange, the sensor's blue.

    Parameters
    ----------
    rows : frame, our joints and the sensor's (16, 3) m, what to write above.
    """
    above = parents(LANDMARKS)
    with figure_at(path, 8.0, 6.4, "") as figure:
        axes = figure.subplots(2, max(len(rows), 1), squeeze=False)
        for column, (frame, ours, theirs, title) in enumerate(rows):
            first, second = axes[:, column]
            box = np.argwhere(np.isfinite(frame.depth))
            (top, left), (bottom, right) = box.min(axis=0) - 8, box.max(axis=0) + 8
            first.imshow(-frame.depth, cmap="gray", interpolation="nearest")
            points = frame.camera.points(frame.depth)[::2, ::2].reshape(-1, 3)
            second.scatter(points[:, 2], points[:, 1], s=0.6, color="0.7", lw=0)
            for joints, color in ((ours, "tab:orange"), (theirs, "tab:blue")):
                pixels = frame.camera.project(joints)
                for joint, parent in enumerate(above):
                    if parent >= 0 and np.isfinite(joints[[joint, parent]]).all():
                        line = {"color": color, "lw": 1.4, "marker": "o", "ms": 2}
                        first.plot(*pixels[[joint, parent]].T, **line)
                        second.plot(*joints[[joint, parent]][:, [2, 1]].T, **line)
            first.set_title(title, fontsize=7)
            first.set_xlim(left, right)
            first.set_ylim(bottom, top)
            second.set_aspect("equal")
            second.invert_yaxis()
            for one in (first, second):
                one.set_axis_off()
