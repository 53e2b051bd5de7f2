"""How long and wide this person is, from a few frames whose poses are only roughly known (section 3.8, future work).

Lengths and widths are factors on an average adult's, both sides alike, with the spread of the population as a prior.
They are fitted together with the poses of all frames: every frame has its own pose increments and all share the
factors, so that the normal equations have arrow shape and the poses are eliminated frame by frame.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, TypeAlias, final

import numpy as np

from ...arrays import Floats, frozen
from ...bodies.camera import Camera
from ...bodies.performer import (
    BONES,
    DOFS,
    LANDMARKS,
    MOVES,
    PARENTS,
    Performer,
    Pose,
    advance,
    bone_frames,
    twists,
)
from ...bodies.surface import render
from ...errors import MismatchError
from ..detect.joints import Detection
from ..frame.observation import Observation

# Name, bones, axes that it stretches (x, y, z), and its standard deviation over adults and older children.
_FACTORS: tuple[tuple[str, tuple[str, ...], tuple[int, ...], float], ...] = (
    ("size", tuple({b.split("_")[-1]: None for b in BONES}), (0, 1, 2), 0.10),
    ("torso", ("pelvis", "chest"), (1,), 0.05),
    ("shoulders", ("clavicle",), (0,), 0.06),
    ("hips", ("pelvis",), (0,), 0.06),
    ("head", ("head",), (0, 1, 2), 0.05),
    ("upperarm", ("upperarm",), (1,), 0.06),
    ("forearm", ("forearm",), (1,), 0.06),
    ("thigh", ("thigh",), (1,), 0.06),
    ("shank", ("shank",), (1,), 0.06),
    ("foot", ("foot",), (0, 1, 2), 0.06),
    ("girth", ("pelvis", "chest"), (2,), 0.10),
    ("chest", ("chest",), (0,), 0.08),
    ("arms", ("clavicle", "upperarm", "forearm"), (0, 2), 0.12),
    ("legs", ("thigh", "shank"), (0, 2), 0.12),
)
_SPREAD = np.array([spread for *_, spread in _FACTORS])
GATE = 0.15  # m, what is farther off is not this surface
SCALE = 0.03  # m, of the Geman-McClure weight: clothes are off by as much
# A surface's samples err together: clothes bulge by a centimetre or two over a hand's breadth, and where they do in one
# frame they do in the next.
NOISE = 0.02  # m, of one sample
CLUMP = 24.0  # samples tell as much as one
_SAMPLES = 500  # of each kind in one frame

UNUSUAL = 27.7  # of one in a hundred people proportions are farther off (chi squared, 13 factors)
# shares of the person's pixels explained wrongly, up to which no other beginning is tried, and none of another size
WELL, BADLY = 0.2, 0.3
WORSE = 0.01  # share of the person's pixels that a body may explain worse than the one to begin with


@final
@dataclass(frozen=True, eq=False)
class Trial:
    """The same frames tracked with one performer.

    Attributes
    ----------
    frames, poses : those that tell of the body, with their poses.
    wrong : share of the person's pixels explained wrongly, the median over all frames; 1 in a lost one.
    """

    frames: Sequence[Observation]
    poses: Sequence[Pose]
    wrong: float


Follow: TypeAlias = Callable[[Performer], Trial]
"""Tracks some frames with a performer."""


@final
@dataclass(frozen=True, eq=False)
class Calibration:
    """A person's body.

    Attributes
    ----------
    performer : with its lengths and widths.
    poses : of the frames it was fitted on.
    factors : on an average adult's, by name.
    std : standard deviations of their logarithms.
    residual : m, root mean square of what is left between body and frames.
    measured : whether it was fitted to frames; else the factors are 1 and the deviations those of people.
    """

    performer: Performer
    poses: tuple[Pose, ...]
    factors: Mapping[str, float]
    std: Mapping[str, float]
    residual: float
    measured: bool = True


def size_from(performer: Performer, detections: Sequence[Detection]) -> float:
    """How much larger than `performer` a person is, by the distances between joints detected in several frames.

    The median of the ratios of head to neck to hips to knees to ankles, and shoulders to elbows to wrists, each where
    both ends are confident; 1 where nothing is.
    """
    pairs = ["neck-pelvis", *(f"{s}_{pair}" for s in "lr" for pair in ("hip-knee", "knee-ankle", "shoulder-elbow"))]
    frames = np.array([d.joints for d in detections]).reshape(-1, len(LANDMARKS), 3)
    sure = np.array([d.confidence for d in detections]).reshape(-1, len(LANDMARKS)) > 0.7
    rest = _reach_of(performer)
    ratios = []
    for pair in pairs:
        one, other = pair.split("-")
        a = LANDMARKS.index(one)
        b = LANDMARKS.index(other if other in LANDMARKS else f"{one[:2]}{other}")
        both = sure[:, a] & sure[:, b]
        if both.sum():
            ratios.append(float(np.median(np.linalg.norm(frames[both, a] - frames[both, b], axis=1))) / rest(a, b))
    # Detected joints of a short limb scatter by a tenth of it; people differ less than that allows.
    return float(np.clip(np.median(ratios), 0.6, 1.3)) if ratios else 1.0


def calibrate(
    performer: Performer, frames: Sequence[Observation], poses: Sequence[Pose], rounds: int = 24
) -> Calibration:
    """Fit lengths, widths and poses to frames.

    Parameters
    ----------
    performer : to begin with, of about this person's size; its proportions are the mean of the prior.
    frames : some frames of the person, best in different poses; about 160 x 120 pixels tell enough.
    poses : of each, as the tracker has them.
    rounds : of Gauss-Newton.

    Raises
    ------
    MismatchError : no frames, or not as many poses.
    """
    if not frames or len(frames) != len(poses):
        raise MismatchError(f"a calibration needs frames and as many poses, came {len(frames)} and {len(poses)}")
    shape = np.zeros(len(_FACTORS))
    current = list(poses)
    residual = float("inf")
    information = np.diag(1.0 / _SPREAD**2)
    for _ in range(rounds):
        body = performer.stretched(stretch_of(shape))
        information = np.diag(1.0 / _SPREAD**2)
        right = -shape / _SPREAD**2
        links: list[Floats | None] = []
        squares = count = 0.0
        for seen, pose in zip(frames, current, strict=True):
            value, by_pose, by_shape, weight = _residuals(performer, body, shape, pose, seen)
            if not len(value):
                links.append(None)
                continue
            trust = weight / (NOISE**2 * CLUMP)
            normal = (by_pose * trust[:, None]).T @ by_pose
            normal[np.diag_indices(DOFS)] += 1.0  # joints that no pixel tells of stay
            couple = (by_pose * trust[:, None]).T @ by_shape
            goal = -by_pose.T @ (trust * value)
            solved = np.asarray(np.linalg.solve(normal, np.column_stack([couple, goal])), dtype=np.float64)
            information += (by_shape * trust[:, None]).T @ by_shape - couple.T @ solved[:, :-1]
            right += -by_shape.T @ (trust * value) - couple.T @ solved[:, -1]
            links.append(solved)
            squares += float(weight @ value**2)
            count += float(weight.sum())
        step = np.linalg.solve(information, right)
        step *= min(1.0, 0.1 / max(float(np.abs(step).max()), 1e-12))
        shape = shape + step
        for k, link in enumerate(links):
            if link is not None:
                delta = link[:, -1] - link[:, :-1] @ step
                current[k] = _limited(performer, advance(performer, current[k], np.clip(delta, -0.3, 0.3)))
        residual = float(np.sqrt(squares / count)) if count else float("inf")
        if float(np.abs(step).max()) < 2e-3:
            break
    spread = np.sqrt(np.diag(np.linalg.inv(information)))
    names = [name for name, *_ in _FACTORS]
    return Calibration(
        performer.stretched(stretch_of(shape)),
        tuple(current),
        dict(zip(names, np.exp(shape).tolist(), strict=True)),
        dict(zip(names, spread.tolist(), strict=True)),
        residual,
    )


def calibrated(
    begins: Sequence[Performer],
    follow: Follow,
    passes: int = 2,
    most: int = 12,
    others: Sequence[Performer] = (),
) -> Calibration:
    """Track, fit the body, track again with it, and so on; what is not borne out is not believed.

    Parameters
    ----------
    begins : bodies to begin with: the first that explains the frames `WELL`, else the one that explains them best.
    follow : tracks the first seconds with a performer.
    passes : how often.
    most : frames used of those that `follow` gives, those with the most different poses.
    others : bodies to begin with where those explain the frames `BADLY`.

    Returns
    -------
    The last body whose proportions are somebody's and with which the frames are explained as well as they were to begin
    with. Where there is none, furniture beside the person say, it is the body to begin with, not `measured`.

    Raises
    ------
    MismatchError : when nothing was tracked.
    """
    found: list[Trial] = []
    bodies = (*begins, *others)
    for k, body in enumerate(bodies):
        if k == len(begins) and min(one.wrong for one in found) < BADLY:
            break
        found.append(follow(body))
        if found[-1].wrong < WELL:
            break
    if not any(one.poses for one in found):
        raise MismatchError("a calibration needs frames in which the person was followed; there is none")
    best = min(range(len(found)), key=lambda k: found[k].wrong)
    begin, first = bodies[best], found[best]
    believed = unmeasured(begin)
    here = first
    for _ in range(passes):
        if not here.poses:
            break
        chosen = _different(here.poses, most)
        done = calibrate(begin, [here.frames[i] for i in chosen], [here.poses[i] for i in chosen])
        here = follow(done.performer)
        if unusual(done) < UNUSUAL and here.wrong < first.wrong + WORSE:
            believed = done
    return believed


def unusual(calibration: Calibration) -> float:
    """How far proportions are from the population's, in squared standard deviations; the size does not count.

    What is little seen is drawn to the mean, so that fitted factors scatter less than people do.
    """
    names = [name for name, *_ in _FACTORS][1:]
    logs = np.log([calibration.factors[name] for name in names])
    spread, unsure = _SPREAD[1:], np.array([calibration.std[name] for name in names])
    told = np.maximum(1.0 - (unsure / spread) ** 2, 0.05)
    return float((logs**2 / (told * spread**2)).sum())


def unmeasured(performer: Performer) -> Calibration:
    """What is known of a body that nothing was measured of."""
    names = [name for name, *_ in _FACTORS]
    spread = dict(zip(names, _SPREAD.tolist(), strict=True))
    return Calibration(performer, (), dict.fromkeys(names, 1.0), spread, float("nan"), measured=False)


def stretch_of(shape: Floats) -> Floats:
    """(15, 3) factors for `Performer.stretched` of the logarithms of the named factors."""
    return np.asarray(np.exp(np.einsum("f,fba->ba", shape, _basis())))


@cache
def _basis() -> Floats:
    """(F, 15, 3) what each factor stretches."""
    basis = np.zeros((len(_FACTORS), len(BONES), 3))
    for f, (_, bones, axes, _) in enumerate(_FACTORS):
        for b, bone in enumerate(BONES):
            if bone.split("_")[-1] in bones:
                basis[f, b, list(axes)] = 1.0
    return frozen(basis)


def _residuals(
    performer: Performer, body: Performer, shape: Floats, pose: Pose, seen: Observation
) -> tuple[Floats, Floats, Floats, Floats]:
    """Distances (N,) in m between body and frame, derivatives by pose (N, 34) and by factors (N, F), weights (N,).

    Where both are, the distance of the observed point from the model along its normal. Where only one is, how far
    its pixel is from the other's outline, at the model's depth.
    """
    import cv2

    drawn = render(body, pose, seen.camera)
    person, model = np.isfinite(seen.depth), np.isfinite(drawn.depth)
    if not (person & model).any():
        return np.empty(0), np.empty((0, DOFS)), np.empty((0, len(_FACTORS))), np.empty(0)
    normals, bones = drawn.normals, drawn.bones
    both = _some(person & model)
    point = _at(seen.camera, both, drawn.depth)
    normal = normals[both[:, 0], both[:, 1]].astype(np.float64)
    parts = [(bones[both[:, 0], both[:, 1]], point, normal, _at(seen.camera, both, seen.depth))]
    claimed = _some(model & ~person & seen.free)
    missed = _some(person & ~model)
    for pixels, outline in ((claimed, person), (missed, model)):
        if not len(pixels):
            continue
        labels = cv2.distanceTransformWithLabels(
            (~outline).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
        )[1]
        where = np.zeros((int(labels.max()) + 1, 2), np.int64)
        where[labels[outline]] = np.argwhere(outline)
        nearest = where[labels[pixels[:, 0], pixels[:, 1]]]
        on_model, beside = (pixels, nearest) if outline is person else (nearest, pixels)
        start = _at(seen.camera, on_model, drawn.depth)
        ratio = start[:, 2:] * np.array([1.0 / seen.camera.fx, 1.0 / seen.camera.fy])
        away = np.column_stack([(beside - on_model)[:, ::-1] * ratio, np.zeros(len(start))])
        length = np.linalg.norm(away, axis=1)
        some = (length > 0) & (length < GATE)
        direction = away[some] / length[some, None]
        parts.append((bones[on_model[some, 0], on_model[some, 1]], start[some], direction, start[some] + away[some]))
    bone, point, normal, target = (np.concatenate(column) for column in zip(*parts, strict=True))
    value = np.einsum("ni,ni->n", normal, point - target)
    kept = np.abs(value) < GATE
    bone, point, normal, value = bone[kept].astype(np.int64), point[kept], normal[kept], value[kept]
    turn = twists(body, pose)
    moment = np.cross(point, normal)
    by_pose = np.where(MOVES[bone], moment @ turn[:, :3].T + normal @ turn[:, 3:].T, 0.0)
    placed = bone_frames(body, pose)
    stretch = stretch_of(shape)
    local = np.einsum("nji,nj->ni", placed[bone, :3, :3], point - placed[bone, :3, 3]) / stretch[bone]
    # Rotations do not depend on the factors: points move along their bone's axes, bones begin elsewhere.
    rate = stretch * _basis()
    begin = np.zeros(rate.shape)
    for b in range(1, len(BONES)):
        above = PARENTS[b]
        begin[:, b] = begin[:, above] + (performer.offsets[b] * rate[:, above]) @ placed[above, :3, :3].T
    along = np.einsum("ni,nij->nj", normal, placed[bone, :3, :3]) * local
    by_shape = np.einsum("nj,fnj->nf", along, rate[:, bone]) + np.einsum("ni,fni->nf", normal, begin[:, bone])
    weight = 1.0 / (1.0 + (value / SCALE) ** 2) ** 2
    return value, by_pose, by_shape, weight


def _some(mask: Any) -> Any:
    """(N, 2) rows and columns of a mask, evenly thinned to about `_SAMPLES`."""
    pixels = np.argwhere(mask)
    return pixels[:: max(1, len(pixels) // _SAMPLES)]


def _at(camera: Camera, pixels: Any, depth: Any) -> Floats:
    return camera.unproject(pixels[:, ::-1], depth[pixels[:, 0], pixels[:, 1]])


def _limited(performer: Performer, pose: Pose) -> Pose:
    low, high = performer.limits[6:].T
    return Pose(pose.translation, pose.root, np.clip(pose.joints, low, high))


def _different(poses: Sequence[Pose], most: int) -> list[int]:
    """Indices of up to `most` poses, each the farthest from those before it, in the order of time."""
    joints = np.array([np.concatenate([pose.joints, pose.root.ravel()]) for pose in poses])
    chosen, gap = [0], ((joints - joints[0]) ** 2).sum(axis=1)
    while len(chosen) < min(most, len(poses)):
        chosen.append(int(np.argmax(np.where(np.isin(np.arange(len(poses)), chosen), -1.0, gap))))
        gap = np.minimum(gap, ((joints - joints[chosen[-1]]) ** 2).sum(axis=1))
    return sorted(chosen)


def _reach_of(performer: Performer) -> Callable[[int, int], float]:
    from ...bodies.performer import landmarks, standing

    place = landmarks(performer, standing())
    return lambda a, b: float(np.linalg.norm(place[a] - place[b]))
