"""The performer's surface from the lengths of the bones, and the average person."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..arrays import Floats, frozen
from .performer import BONES, LANDMARKS, Performer
from .solids import CONE, ELLIPSOID, Solids

# Breadths and depths of an adult of 1.75 m: medians of both sexes of ANSUR II (Gordon et al. 2014), girths over 2 pi.
_LIMBS = 1.40  # m, upper arm, forearm, thigh and shank of that adult together


class _Sculpture:
    """Solids put together one by one, sizes of the adult of 1.75 m times `scale`."""

    def __init__(self, scale: float) -> None:
        self.scale = scale
        self.rows: list[tuple[int, int, Floats, Floats, Floats, float]] = []

    def ball(self, bone: str, center: Floats, size: float | Sequence[float], lift: Sequence[float] = (0, 0, 0)) -> None:
        """An ellipsoid along the axes of the bone: `center` (3,) m, half axes `size`, moved by `lift`, both scaled."""
        half = np.broadcast_to(np.asarray(size, dtype=np.float64), (3,)) * self.scale
        self._add(bone, ELLIPSOID, np.asarray(center) + self.scale * np.asarray(lift), np.eye(3), half, 0.0)

    def cone(self, bone: str, low: Floats, high: Floats, at_low: float, at_high: float, depth: float = 1.0) -> None:
        """A cone from `low` to `high` (3,) m, with radii across x at both ends (scaled); `depth` is z over x."""
        along = np.asarray(high, dtype=np.float64) - low
        length = float(np.linalg.norm(along))
        y = along / length
        x = np.cross(y, (0.0, 0.0, 1.0)) if abs(y[2]) < 0.7 else np.array([1.0, 0.0, 0.0])
        x = (x - (x @ y) * y) / np.linalg.norm(x - (x @ y) * y)
        radius = self.scale * (at_low + at_high) / 2
        half = np.array([radius, length / 2, radius * depth])
        taper = (at_high - at_low) / (at_high + at_low)
        self._add(bone, CONE, (np.asarray(low) + high) / 2, np.stack((x, y, np.cross(x, y)), axis=1), half, taper)

    def _add(self, bone: str, kind: int, center: Floats, turn: Floats, half: Floats, taper: float) -> None:
        self.rows.append((BONES.index(bone), kind, center, turn, half, taper))

    def solids(self) -> Solids:
        bone, kind, center, turn, size, taper = (np.array(column) for column in zip(*self.rows, strict=True))
        return Solids(bone, kind, center, turn, size, taper)


def performer(offsets: Floats, landmark_place: Floats, tip_place: Floats) -> Performer:
    """A person with these bones, as wide as people of these lengths are on average.

    Parameters
    ----------
    offsets, landmark_place, tip_place : m, as in `Performer`.
    """
    part = {bone: np.asarray(offsets[b]) for b, bone in enumerate(BONES)}
    place = {name: np.asarray(landmark_place[i]) for i, name in enumerate(LANDMARKS)}
    limbs = [part[f"{side}_{bone}"] for side in "lr" for bone in ("forearm", "shank", "foot")]
    limbs += [place[f"{side}_wrist"] for side in "lr"]
    made = _Sculpture(float(np.linalg.norm(limbs, axis=1).sum()) / 2 / _LIMBS)
    s, zero = made.scale, np.zeros(3)
    hips, waist = (part["l_thigh"] + part["r_thigh"]) / 2, part["chest"]
    # Hips lie 3 to 5 cm ahead of the root, but waist markers of CMU's people about the root itself, 0 to 0.3 cm ahead.
    seat = hips * np.array([1.0, 1.0, 0.2])
    made.cone("pelvis", seat, waist, 0.158, 0.140, 0.74)
    made.ball("pelvis", seat, (0.160, 0.105, 0.115))
    for side in "lr":
        made.ball("pelvis", part[f"{side}_thigh"], 0.090, (0.0, 0.0, -0.020))
    top = place["chest"]
    made.cone("chest", -0.25 * top, top * 0.75, 0.138, 0.162, 0.73)
    made.ball("chest", top * 0.68, (0.165, 0.115, 0.118), (0.0, 0.0, 0.005))
    neck, head = place["neck"], place["head"]
    made.cone("head", -0.06 * s * np.array([0.0, 1.0, 0.0]), neck + 0.3 * (head - neck), 0.062, 0.056)
    # The head, as in section 3.2.1: two spheres and a cylinder.
    low, high = head + s * np.array([0.0, -0.035, 0.010]), head + s * np.array([0.0, 0.030, 0.010])
    made.ball("head", low, 0.082)
    made.cone("head", low, high, 0.080, 0.084, 1.10)
    made.ball("head", high, 0.090)
    for side, hand, toe in (("l", 1, 3), ("r", 2, 4)):
        shoulder, elbow, wrist = part[f"{side}_upperarm"], part[f"{side}_forearm"], place[f"{side}_wrist"]
        made.cone(f"{side}_clavicle", 0.2 * shoulder, shoulder, 0.055, 0.050)
        made.ball(f"{side}_clavicle", shoulder, 0.060)
        made.cone(f"{side}_upperarm", elbow, zero, 0.041, 0.053)
        made.ball(f"{side}_upperarm", elbow, 0.043)
        made.cone(f"{side}_forearm", wrist, zero, 0.029, 0.044)
        made.ball(f"{side}_forearm", *_hand(wrist, tip_place[hand], 1.0, s))
        knee, ankle = part[f"{side}_shank"], part[f"{side}_foot"]
        made.cone(f"{side}_thigh", knee, zero, 0.060, 0.093)
        made.ball(f"{side}_thigh", knee, 0.060)
        made.cone(f"{side}_shank", ankle, zero, 0.042, 0.059)
        made.ball(f"{side}_shank", 0.3 * ankle, (0.057, 0.120, 0.058), (0.0, 0.0, -0.012))
        tip = tip_place[toe]
        sole = min(float(tip[1]), -0.03 * s)
        heel = np.array([0.0, sole * 0.7, -0.045 * s])
        made.cone(f"{side}_foot", heel, np.array([0.6 * tip[0], sole * 0.7, 0.6 * tip[2]]), 0.036, 0.042, 0.85)
        made.ball(f"{side}_foot", zero, 0.041, (0.0, -0.010, -0.010))
        made.ball(
            f"{side}_foot", np.array([0.7 * tip[0], sole, 0.62 * tip[2]]), (0.044, 0.022, 0.38 * float(tip[2]) / s)
        )
    return Performer(offsets, landmark_place, tip_place, made.solids())


def handed(body: Performer, reach: float) -> Performer:
    """The same person with other hands.

    Parameters
    ----------
    body : as `performer` makes them, whose hands are flat.
    reach : how far the hands reach beyond the wrists, as a share of flat ones: 1 flat, 0.5 fists.
    """
    solids = body.solids
    center, size = solids.center.copy(), solids.size.copy()
    for side, hand in (("l", 1), ("r", 2)):
        wrist, tip = body.landmark_place[LANDMARKS.index(f"{side}_wrist")], body.tip_place[hand]
        own = (solids.bone == BONES.index(f"{side}_forearm")) & (solids.kind == ELLIPSOID)
        middle, half = _hand(wrist, tip, reach, 1.0)
        center[own], size[own, 1] = middle, half[1]
    return replace(body, solids=replace(solids, center=frozen(center), size=frozen(size)))


def _hand(wrist: Floats, tip: Floats, reach: float, scale: float) -> tuple[Floats, tuple[float, float, float]]:
    """Middle (3,) m and half axes, over `scale`, of a hand from `wrist` that reaches so far to the flat one's `tip`."""
    whole = tip - wrist
    return wrist + 0.5 * reach * whole, (0.020, 0.5 * reach * float(np.linalg.norm(whole)) / scale, 0.042)


def average(stature: float = 1.75) -> Performer:
    """The average adult of a stature in m, lengths as in Winter (2009), figure 4.1, and CMU's joint places."""
    s = stature / 1.75
    offsets = np.zeros((len(BONES), 3))
    landmark = np.zeros((len(LANDMARKS), 3))
    tip = np.zeros((5, 3))
    offset = {bone: offsets[b] for b, bone in enumerate(BONES)}
    place = {name: landmark[i] for i, name in enumerate(LANDMARKS)}
    offset["chest"][:] = (0.0, 0.115, -0.008)
    place["chest"][:] = (0.0, 0.235, 0.0)
    offset["head"][:] = (0.0, 0.325, 0.005)
    place["neck"][:] = (0.0, 0.088, -0.005)
    place["head"][:] = (0.0, 0.182, -0.005)
    tip[0] = (0.0, 0.2995, -0.005)
    for side, sign, hand, toe in (("l", 1.0, 1, 3), ("r", -1.0, 2, 4)):
        offset[f"{side}_clavicle"][:] = (0.0, 0.235, 0.0)
        offset[f"{side}_upperarm"][:] = (sign * 0.178, 0.03, -0.012)
        offset[f"{side}_forearm"][:] = (0.0, -0.290, 0.0)
        place[f"{side}_wrist"][:] = (0.0, -0.275, 0.0)
        tip[hand] = (0.0, -0.445, 0.0)
        offset[f"{side}_thigh"][:] = (sign * 0.092, -0.100, 0.030)
        offset[f"{side}_shank"][:] = (0.0, -0.430, 0.0)
        offset[f"{side}_foot"][:] = (0.0, -0.420, 0.0)
        tip[toe] = (0.0, -0.045, 0.205)
    return performer(offsets * s, landmark * s, tip * s)
