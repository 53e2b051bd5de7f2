"""Bodies that are not the tracker's: skin of many spheres swept along a skeleton's own bones, hands and feet included.

The tracker's performer has cones and ellipsoids on 15 stiff bones. A stranger's skin hangs on all the joints of the
recording's own skeleton: the spine bends in as many places as that has, wrists, fingers and toes move. Sections are
stadiums, not ellipses; belly, calves, buttocks, nose and thumbs stand out; girth and shape are drawn at random.
"""

from dataclasses import dataclass
from typing import final

import numpy as np

from ..arrays import Floats, Ints, Singles, frozen
from ..bodies.camera import Camera
from ..bodies.feet import upwards
from ..bodies.rig import Rig, rig_of, toe_tip
from ..bodies.skeleton import Skeleton, rest_positions
from ..bodies.surface import Solid16, intrinsics

CLOSE = 0.3  # spheres along a sweep lie this share of their radius apart


@final
@dataclass(frozen=True, eq=False)
class Stranger:
    """A skin of N spheres.

    Attributes
    ----------
    skeleton : that carries it.
    joint : (N,) the joint each sphere turns with.
    place : (N, 3) m, its centre from the joint, in the axes of the skeleton at rest.
    radius : (N,) m.
    """

    skeleton: Skeleton
    joint: Ints
    place: Floats
    radius: Floats


class _Skin:
    """Spheres laid one sweep after another on a skeleton at rest."""

    def __init__(self, rest: Floats, scale: float) -> None:
        self.rest = rest
        self.scale = scale
        self.rows: list[tuple[int, Floats, float]] = []

    def ball(self, joint: int, center: Floats, radius: float) -> None:
        self.rows.append((joint, center - self.rest[joint], radius * self.scale))

    def sweep(
        self,
        joint: int,
        begin: Floats,
        end: Floats,
        knots: tuple[tuple[float, float, float, float], ...],
        wide: Floats,
        deep: Floats,
    ) -> None:
        """A limb from one point to another; each knot is (share of the way, radius, half width more, forward shift)."""
        table = np.array(knots)
        length = float(np.linalg.norm(end - begin))
        least = float(table[:, 1].min()) * self.scale
        for share in np.linspace(0.0, 1.0, max(2, int(np.ceil(length / (CLOSE * least))))):
            radius, spread, shift = (self._smooth(share, table[:, 0], table[:, k]) for k in (1, 2, 3))
            center = begin + share * (end - begin) + shift * self.scale * deep
            beside = max(1, 2 * int(np.ceil(spread / (1.2 * CLOSE * radius) / 2)) + 1) if spread > 0 else 1
            for side in np.linspace(-spread, spread, beside) if beside > 1 else (0.0,):
                self.ball(joint, center + side * self.scale * wide, radius)

    @staticmethod
    def _smooth(at: float, knots: Floats, values: Floats) -> float:
        """Between knots by a cosine: bulges are round."""
        index = int(np.clip(np.searchsorted(knots, at) - 1, 0, len(knots) - 2))
        part = (at - knots[index]) / (knots[index + 1] - knots[index])
        ease = 0.5 - 0.5 * np.cos(np.pi * np.clip(part, 0.0, 1.0))
        return float(values[index] + ease * (values[index + 1] - values[index]))


def stranger(skeleton: Skeleton, seed: int = 0, girth: float | None = None) -> Stranger:
    """Somebody with this skeleton.

    Parameters
    ----------
    skeleton : any with the performer's 16 joints.
    seed : whose shape; limbs, trunk and head are 8 % thicker or thinner than average by chance, each for itself.
    girth : 0.8 slim to 1.3 stout, drawn from 0.9 to 1.15 when not given; the belly grows with it.

    Raises
    ------
    MismatchError : a skeleton without those joints.
    """
    rng = np.random.default_rng([seed, 97])
    stout = float(rng.uniform(0.9, 1.15)) if girth is None else float(girth)
    vary = {part: float(np.exp(0.08 * rng.standard_normal())) for part in ("trunk", "head", "arm", "leg", "foot")}
    rig = rig_of(skeleton)
    rest = rest_positions(skeleton)
    limbs = [
        rest[a] - rest[b] for arm in rig.roles.arms for a, b in ((arm.shoulder, arm.elbow), (arm.elbow, arm.wrist))
    ]
    feet = rig.roles.feet
    limbs += [rest[a] - rest[b] for a, b in (*zip(feet.hips, feet.knees, strict=True),)]
    limbs += [rest[a] - rest[b] for a, b in (*zip(feet.knees, feet.ankles, strict=True),)]
    skin = _Skin(rest, float(np.linalg.norm(limbs, axis=1).sum()) / 2 / 1.40)
    left, up, ahead = rig.rests[0].T
    _trunk(skin, skeleton, rig, stout * vary["trunk"], stout, (left, up, ahead))
    _head(skin, rig, vary["head"], (left, up, ahead))
    for side in (0, 1):
        _arm(skin, skeleton, rig, side, stout**0.5 * vary["arm"], ahead, up)
        _leg(skin, rig, side, stout**0.5 * vary["leg"], left, ahead)
        _foot(skin, rig, side, vary["foot"], left, up, ahead)
    joint, place, radius = zip(*skin.rows, strict=True)
    return Stranger(skeleton, frozen(joint, np.int64), frozen(np.array(place)), frozen(radius))


def depth_of(
    body: Stranger, position: Floats, turned: Floats, camera: Camera, turn: Floats, shift: Floats
) -> tuple[Singles, Solid16]:
    """What a camera sees of a stranger.

    Parameters
    ----------
    body : who.
    position, turned : (J, 3) m and (J, 3, 3) of one frame, as `skeleton.forward` gives them.
    camera : that looks.
    turn, shift : (3, 3), (3,) m: camera axes from the motion's.

    Returns
    -------
    depth : (H, W) float32 m, NaN = nothing there; (H, W) int16, the joint of the skeleton seen there, -1 = none.
    """
    from ..kernels import raycast

    centers = position[body.joint] + np.einsum("nij,nj->ni", turned[body.joint], body.place)
    count = len(centers)
    placed = np.zeros((count, 3, 4))
    placed[:, range(3), range(3)] = 1.0
    placed[:, :, 3] = centers @ turn.T + shift
    sizes = frozen(np.repeat(body.radius[:, None], 3, axis=1))
    parts = np.empty((count, raycast.PARTS))
    kinds, tapers = frozen(np.zeros(count), np.uint8), frozen(np.zeros(count))
    raycast.prepare(placed, kinds, sizes, tapers, intrinsics(camera), camera.width, camera.height, parts)
    depth = np.empty((camera.height, camera.width), dtype=np.float32)
    ball = np.empty(depth.shape, dtype=np.int16)
    raycast.cast(parts, depth, ball)
    return depth, np.append(body.joint, -1).astype(np.int16)[ball]


def _trunk(
    skin: _Skin, skeleton: Skeleton, rig: Rig, wide: float, stout: float, axes: tuple[Floats, Floats, Floats]
) -> None:
    """Hips, waist, chest and shoulders, each height carried by the spine joint below it."""
    left, up, ahead = axes
    part, rest = rig.roles, skin.rest
    hips = (rest[part.feet.hips[0]] + rest[part.feet.hips[1]]) / 2
    # Hips may lie ahead of the pelvis, 3.5 and 4.8 cm in CMU's skeletons; waist markers lie 0.1 and 0.3 cm ahead of it.
    low, high = hips - 0.8 * ((hips - rest[part.pelvis]) @ ahead) * ahead, rest[part.chest]
    carriers = [part.pelvis, *part.spine]
    starts = [-np.inf] + [float((rest[j] - low) @ up) for j in part.spine]
    starts[1:2] = [max(starts[1], 0.45 * float((rest[part.pelvis] - low) @ up))] if len(starts) > 1 else []
    belly = 0.10 * max(stout - 0.95, 0.0)
    # Share of the height from hips to the chest's upper end, radius (half depth), half width beyond it, forward shift.
    sections = np.array(
        (
            (-0.22, 0.080, 0.060, 0.000),
            (0.00, 0.108, 0.062, -0.012),
            (0.28, 0.100, 0.048, 0.004 + belly / 2),
            (0.45, 0.095, 0.042, 0.008 + belly),
            (0.75, 0.108, 0.056, 0.010),
            (0.92, 0.085, 0.080, 0.002),
            (1.02, 0.050, 0.075, -0.008),
        )
    )
    sections[:, 1:3] *= wide
    for share in np.linspace(-0.22, 1.02, 42):
        center = low + share * (high - low)
        carrier = carriers[int(np.searchsorted(starts, float((center - low) @ up), side="right")) - 1]
        radius, spread, shift = (_Skin._smooth(share, sections[:, 0], sections[:, k]) for k in (1, 2, 3))
        for side in np.linspace(-spread, spread, 7):
            skin.ball(carrier, center + skin.scale * (side * left + shift * ahead), radius)
    for hip in part.feet.hips:  # buttocks
        skin.ball(part.pelvis, rest[hip] - skin.scale * (0.035 * ahead + 0.01 * up), 0.085 * wide)
    for arm in part.arms:  # shoulders, from the neck outwards
        joint = arm.clavicle if arm.clavicle >= 0 else carriers[-1]
        begin = high + 0.15 * (rest[arm.shoulder] - high)
        knots = ((0.0, 0.052, 0.0, 0.0), (0.6, 0.050, 0.0, 0.0), (1.0, 0.058, 0.0, 0.0))
        skin.sweep(joint, begin, rest[arm.shoulder], knots, left, ahead)


def _head(skin: _Skin, rig: Rig, thick: float, axes: tuple[Floats, Floats, Floats]) -> None:
    """Neck, skull, face, jaw, nose and ears."""
    left, up, ahead = axes
    part, rest = rig.roles, skin.rest
    middle = rest[list(part.head_end)].mean(axis=0)
    if len(part.head_end) > 1:
        middle = middle - ((middle - rest[part.head]) @ ahead) * ahead
    neck = part.neck[0] if part.neck else part.head
    knots = ((0.0, 0.058, 0.0, 0.0), (0.6, 0.054, 0.0, 0.0), (1.0, 0.056, 0.0, 0.0))
    skin.sweep(neck, rest[part.chest], middle - skin.scale * 0.06 * up, knots, left, ahead)
    s = skin.scale * thick
    for x, y, z, radius in (
        (0.0, 0.035, -0.012, 0.084),
        (0.0, 0.030, 0.020, 0.078),
        (0.0, -0.020, 0.028, 0.068),
        (0.0, -0.060, 0.040, 0.050),
        (0.0, -0.010, 0.098, 0.014),
        (0.075, 0.0, 0.0, 0.018),
        (-0.075, 0.0, 0.0, 0.018),
    ):
        skin.ball(part.head, middle + s * (x * left + y * up + z * ahead), radius * thick)


def _arm(skin: _Skin, skeleton: Skeleton, rig: Rig, side: int, thick: float, ahead: Floats, up: Floats) -> None:
    """Upper arm, forearm, palm, fingers and thumb; what lies between elbow and wrist turns with the joint above it."""
    arm, rest = rig.roles.arms[side], skin.rest
    upper = ((0.0, 0.056, 0.0, 0.0), (0.4, 0.050, 0.0, 0.004), (0.75, 0.043, 0.0, 0.0), (1.0, 0.040, 0.0, 0.0))
    lower = ((0.0, 0.040, 0.0, 0.0), (0.25, 0.043, 0.004, 0.0), (0.7, 0.032, 0.006, 0.0), (1.0, 0.024, 0.010, 0.0))
    along = (rest[arm.wrist] - rest[arm.elbow]) / np.linalg.norm(rest[arm.wrist] - rest[arm.elbow])
    across = ahead - (ahead @ along) * along
    across = across / np.linalg.norm(across) if np.linalg.norm(across) > 0.1 else up
    flat = np.cross(along, across)
    skin.sweep(arm.shoulder, rest[arm.shoulder], rest[arm.elbow], _thick(upper, thick), across, flat)
    skin.sweep(arm.elbow, rest[arm.elbow], rest[arm.wrist], _thick(lower, thick), across, flat)
    s = skin.scale
    begin = rest[arm.wrist]
    knuckles = begin + 0.085 * s * along
    fingers = next((j for j in upwards(skeleton, arm.tip) if skeleton.parents[j] == arm.wrist), arm.wrist)
    palm = ((0.0, 0.020, 0.012, 0.0), (0.6, 0.017, 0.026, 0.0), (1.0, 0.014, 0.028, 0.0))
    skin.sweep(arm.wrist, begin, knuckles, palm, across, flat)
    tips = ((0.0, 0.013, 0.028, 0.0), (0.7, 0.011, 0.024, 0.004), (1.0, 0.009, 0.014, 0.008))
    skin.sweep(fingers, knuckles, knuckles + 0.085 * s * along, tips, across, flat)
    thumb = ((0.0, 0.014, 0.0, 0.0), (1.0, 0.010, 0.0, 0.0))
    skin.sweep(
        arm.wrist, begin + 0.02 * s * (along + across), begin + s * (0.07 * along + 0.055 * across), thumb, across, flat
    )


def _leg(skin: _Skin, rig: Rig, side: int, thick: float, left: Floats, ahead: Floats) -> None:
    """Thigh and shank with the calf behind."""
    feet, rest = rig.roles.feet, skin.rest
    hip, knee, ankle = feet.hips[side], feet.knees[side], feet.ankles[side]
    thigh = ((0.0, 0.082, 0.0, 0.0), (0.3, 0.080, 0.0, 0.004), (0.7, 0.062, 0.0, 0.004), (1.0, 0.052, 0.004, 0.004))
    shank = ((0.0, 0.050, 0.004, 0.002), (0.28, 0.054, 0.0, -0.016), (0.65, 0.040, 0.0, -0.008), (1.0, 0.034, 0.0, 0.0))
    skin.sweep(hip, rest[hip], rest[knee], _thick(thigh, thick), left, ahead)
    skin.sweep(knee, rest[knee], rest[ankle], _thick(shank, thick), left, ahead)


def _foot(skin: _Skin, rig: Rig, side: int, thick: float, left: Floats, up: Floats, ahead: Floats) -> None:
    """Heel, instep, ball and toes."""
    feet, rest, s = rig.roles.feet, skin.rest, skin.scale
    ankle, ball = feet.ankles[side], feet.toes[side]
    tip = toe_tip(rig.roles, side)
    reach = rest[tip] - rest[ankle] if tip >= 0 else 0.19 * s * ahead
    flat = reach - (reach @ up) * up
    along = flat / np.linalg.norm(flat) if np.linalg.norm(flat) > 0.05 else ahead
    across = np.cross(up, along)
    heel = rest[ankle] - s * (0.045 * along + 0.045 * up)
    toes = rest[ankle] + s * (0.135 * along - 0.052 * up)
    body = ((0.0, 0.033, 0.004, 0.0), (0.3, 0.034, 0.010, 0.012), (0.7, 0.028, 0.020, 0.004), (1.0, 0.024, 0.026, 0.0))
    skin.sweep(ankle, heel, toes, _thick(body, thick), across, up)
    skin.sweep(ankle, rest[ankle], toes, ((0.0, 0.036, 0.0, 0.0), (1.0, 0.024, 0.015, 0.0)), across, up)
    end = ((0.0, 0.024, 0.026, 0.0), (1.0, 0.013, 0.022, -0.006))
    skin.sweep(ball if ball >= 0 else ankle, toes, toes + s * 0.065 * along, _thick(end, thick), across, up)


def _thick(
    knots: tuple[tuple[float, float, float, float], ...], factor: float
) -> tuple[tuple[float, float, float, float], ...]:
    return tuple((share, radius * factor, spread * factor, shift) for share, radius, spread, shift in knots)
