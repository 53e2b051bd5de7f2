"""Where the joints are in one depth image, without any memory: body parts by a random forest, joints by mean shift.

After Shotton et al., Real-time human pose recognition in parts from single depth images (2011), and with votes of the
leaves for the joint's place as Girshick et al. (2011). The forest is told left from right only as of somebody who
faces the camera; how likely that is comes with the joints, and who needs both readings takes `mirrored`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from ...arrays import Bools, Floats, Ints, frozen
from ...bodies.camera import KINECT, Camera, DepthFrame
from ...bodies.performer import LANDMARKS, OTHER_SIDE, Performer, Poses
from ...errors import MismatchError
from .part_forest import PartForest, differences, grown, leaves, planted
from .pictures import Picture, pictures

JOINTS = len(LANDMARKS)
WITHIN = 0.10  # m, what counts as found when confidences are learned
BANDWIDTH = 0.08  # m, of mean shift: about a hand's length; the chest's votes scatter as wide
PIXELS = 900  # looked at in one image, about
FOCAL = (KINECT.fx, KINECT.fy)
PLACES = 3  # modes kept of each joint
ROWS, THICK = 4, 0.25  # px above the lower border, and m of the person there: more than both shanks
LIES = 1.5  # times as wide as tall in the image is nobody who stands, whatever the arms do


@final
@dataclass(frozen=True, eq=False)
class Proposer:
    """A forest that proposes joints, and what the mass of a joint's votes tells of its being right.

    Attributes
    ----------
    forest : of body parts.
    mass : (16, K) m^2, masses of votes, not decreasing along K.
    hit : (16, K) share of joints with such a mass that were within 10 cm.
    """

    forest: PartForest
    mass: Floats
    hit: Floats

    def __post_init__(self) -> None:
        for name in ("mass", "hit"):
            object.__setattr__(self, name, frozen(getattr(self, name)))
        for values in (self.mass, self.hit):
            if values.shape != self.mass.shape or len(values) != JOINTS:
                raise MismatchError(f"a detector's mass and hit must be ({JOINTS}, K), came {values.shape}")

    def arrays(self) -> dict[str, NDArray[Any]]:
        """All of it by name, for a model file."""
        own = {f"forest.{name}": values for name, values in self.forest.arrays().items()}
        return own | {"mass": np.asarray(self.mass), "hit": np.asarray(self.hit)}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> "Proposer":
        """The proposer that `arrays` gave.

        Raises
        ------
        MismatchError : when an array is missing or of another shape.
        """
        if not {"mass", "hit"} <= set(arrays):
            raise MismatchError("a detector needs the arrays mass and hit; fit the model anew")
        return cls(PartForest.from_arrays(_below("forest.", arrays)), arrays["mass"], arrays["hit"])


@final
@dataclass(frozen=True, eq=False)
class Detector:
    """What proposes joints of people who are in the image as a whole, and of those whom its border cuts off.

    Attributes
    ----------
    whole : of people in the image as a whole, or all but a foot or a hand.
    cut_off : of people at a desk, say; None in models that were fitted without: they are read as whole ones.
    """

    whole: Proposer
    cut_off: Proposer | None

    def arrays(self) -> dict[str, NDArray[Any]]:
        """All of it by name, for a model file."""
        beside = {} if self.cut_off is None else self.cut_off.arrays()
        return self.whole.arrays() | {f"cut_off.{name}": values for name, values in beside.items()}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> "Detector":
        """The detector that `arrays` gave.

        Raises
        ------
        MismatchError : when an array is missing or of another shape.
        """
        beside = _below("cut_off.", arrays)
        return cls(Proposer.from_arrays(arrays), Proposer.from_arrays(beside) if beside else None)


def _below(prefix: str, arrays: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    return {name.removeprefix(prefix): values for name, values in arrays.items() if name.startswith(prefix)}


@final
@dataclass(frozen=True, eq=False)
class Detection:
    """Joints of one image, read as if the person faced the camera.

    Attributes
    ----------
    joints : (16, 3) m in camera axes, NaN where nothing speaks for the joint.
    confidence : (16,) how likely each is within 10 cm, 0 where there is none.
    places : (16, 3, 3) m, further candidates, the first being `joints`; NaN = none.
    strength : (16, 3) the same likelihood for each.
    facing : how likely the person faces the camera; near a half, both readings have to be tried.
    """

    joints: Floats
    confidence: Floats
    places: Floats
    strength: Floats
    facing: float

    def __post_init__(self) -> None:
        for name in ("joints", "confidence", "places", "strength"):
            object.__setattr__(self, name, frozen(getattr(self, name)))

    @property
    def mirrored(self) -> "Detection":
        """The other reading: left and right changed over, as of a person seen from behind."""
        sides = {name: getattr(self, name)[OTHER_SIDE] for name in ("joints", "confidence", "places", "strength")}
        return replace(self, **sides, facing=1.0 - self.facing)


def fit_detector(
    poses: Poses, performers: Sequence[Performer], seed: int = 0, count: int = 2000, trees: int = 3
) -> Detector:
    """Learn the parts of the body from synthetic pictures.

    Parameters
    ----------
    poses : in camera axes (y down), of any place and heading; both are drawn anew.
    performers : people to vary.
    seed : of all that is drawn; the same arguments give the same detector.
    count : how many pictures of whole people; half as many more are of people who are cut off.
    trees : how many trees, each with pictures, pixels and depth differences of its own.
    """
    whole, cut_off = (
        _fitted(
            list(pictures(poses, performers, number, seed, cut_off=cut)),
            list(pictures(poses, performers, max(number // 8, 40), seed + 1, cut_off=cut)),
            seed,
            trees,
        )
        for number, cut in ((count, False), ((count + 1) // 2, True))
    )
    return Detector(whole, cut_off)


def _fitted(every: Sequence[Picture], others: Sequence[Picture], seed: int, trees: int) -> Proposer:
    """So many trees grown on pictures, and what their votes tell on others."""
    rng = np.random.default_rng(seed)
    fitted, probes = [], []
    for tree in range(trees):
        tested = _drawn_probes(rng, 320)
        samples, labels = [], []
        for picture in every:
            drawn = _balanced(picture.parts, rng, 40)
            samples.append(differences(picture.depth, picture.pixels[drawn], FOCAL, tested))
            labels.append(picture.parts[drawn])
        fitted.append(grown(np.concatenate(samples), np.concatenate(labels), 18, 12, 36, seed + tree))
        probes.append(tested)
    forest = _taught(planted(fitted, probes, JOINTS), every)
    return Proposer(forest, *_calibrated(forest, others))


def detect(detector: Detector, frame: DepthFrame, pixels: int = PIXELS, furniture: Bools | None = None) -> Detection:
    """The joints in one image of a person without background.

    Parameters
    ----------
    detector : fitted.
    frame : its depth is NaN wherever the person is not (see `foreground.find_person`).
    pixels : looked at, about.
    furniture : (H, W) True where some was told, which may cut them off as the image's border does; None = nowhere.

    Returns
    -------
    Detection : all NaN and 0 for an image with nobody in it.
    """
    proposer = detector.whole
    if detector.cut_off is not None and (_cut_off(frame) or _behind(frame, furniture)):
        proposer = detector.cut_off
    places, masses, facing = _modes(proposer.forest, frame, pixels)
    strength = np.array([np.interp(masses[j], proposer.mass[j], proposer.hit[j]) for j in range(JOINTS)])
    strength[~np.isfinite(places[..., 0])] = 0.0
    return Detection(places[:, 0], strength[:, 0], places, strength, facing)


def _cut_off(frame: DepthFrame) -> bool:
    """Whether so much of the person is at the image's lower border as of who is cut off above the knees."""
    lowest = frame.depth[-ROWS:]
    nearest = np.fmin.reduce(lowest, axis=0)  # the last rows lose pixels
    return float(np.nansum(nearest)) / frame.camera.fx > THICK


def _behind(frame: DepthFrame, furniture: Bools | None) -> bool:
    """Whether the person ends below at furniture (H, W), in most columns and as broadly as who is cut off."""
    if furniture is None:
        return False
    there = np.isfinite(frame.depth)
    columns = np.flatnonzero(there.any(axis=0))
    lowest = there.shape[0] - 1 - np.argmax(there[::-1, columns], axis=0)
    below = np.minimum(lowest[:, None] + np.arange(1, ROWS + 1), there.shape[0] - 1)
    ends = furniture[below, columns[:, None]].any(axis=1)
    wide = float(frame.depth[lowest, columns][ends].sum()) / frame.camera.fx
    return wide > THICK and 2 * int(np.count_nonzero(ends)) > len(columns)


def detected_lying(detector: Detector, frame: DepthFrame, pixels: int = PIXELS) -> list[Detection]:
    """As `detect`, of somebody with the head at the left or at the right; nothing unless they are much wider than tall.

    The forest knows people who are upright: so the image is turned by a quarter, either way.
    """
    found = []
    for quarters in (1, 3) if _lies(frame) else ():
        turned, back = _turned(frame, quarters)
        one = detect(detector, turned, pixels)
        found.append(replace(one, joints=one.joints @ back.T, places=one.places @ back.T))
    return found


def _lies(frame: DepthFrame) -> bool:
    """Whether who is in the image is so much wider than tall as only people who lie are."""
    rows, columns = np.nonzero(np.isfinite(frame.depth))
    if not len(rows):
        return False
    tall, wide = (float(np.ptp(np.quantile(part, (0.02, 0.98)))) for part in (rows, columns))
    return wide / frame.camera.fx > LIES * tall / frame.camera.fy


def _turned(frame: DepthFrame, quarters: int) -> tuple[DepthFrame, Floats]:
    """The frame turned counterclockwise by quarters of a turn, and (3, 3) what turns its points back."""
    camera, depth, back = frame.camera, frame.depth, np.eye(3)
    for _ in range(quarters):
        camera = Camera(camera.height, camera.width, camera.fy, camera.fx, camera.cy, camera.width - 1 - camera.cx)
        back = back @ np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    return DepthFrame(camera, np.ascontiguousarray(np.rot90(depth, quarters)), None, frame.time), back


def _modes(forest: PartForest, frame: DepthFrame, wanted: int = PIXELS) -> tuple[Floats, Floats, float]:
    """Heaviest places (16, 3, 3) of each joint's votes, their masses (16, 3) m^2, and the share of facing."""
    from ...kernels import forest as kernel

    camera = frame.camera
    places, masses = np.full((JOINTS, PLACES, 3), np.nan), np.zeros((JOINTS, PLACES))
    shown = np.isfinite(frame.depth)
    # Every n-th pixel of every n-th row, so that what one stands for is the same everywhere.
    step = max(1, round(np.sqrt(np.count_nonzero(shown) / wanted)))
    pixels = (step * np.argwhere(shown[::step, ::step])).astype(np.int32)
    if not len(pixels):
        return places, masses, 0.5
    reached = leaves(forest, frame.depth, pixels, (camera.fx, camera.fy))
    z = frame.depth[pixels[:, 0], pixels[:, 1]].astype(np.float64)
    points, area = camera.unproject(pixels[:, ::-1], z), z**2 / (camera.fx * camera.fy) * step**2
    place, weight = np.empty((len(pixels), 3)), np.empty(len(pixels))
    for joint in range(JOINTS):
        votes = kernel.votes(reached, forest.parts, forest.votes, points, area, joint, 0.1, place, weight)
        found, mass = np.full((PLACES, 3), np.nan), np.zeros(PLACES)
        number = kernel.densest(place[:votes], weight[:votes], BANDWIDTH, 1.5 * BANDWIDTH, 20, found, mass)
        places[joint, :number], masses[joint, :number] = found[:number], mass[:number]
    return places, masses, float(forest.facing[reached].mean())


def _drawn_probes(rng: np.random.Generator, count: int) -> NDArray[np.float32]:
    """(F, 4) m: pairs of places up to 1.2 m away, near ones more often; half of them the pixel itself and one other."""
    radius = 1.2 * rng.uniform(0.02, 1.0, (count, 2)) ** 2
    angle = rng.uniform(0.0, 2.0 * np.pi, (count, 2))
    radius[: count // 2, 1] = 0.0
    return np.stack(
        [radius[:, 0] * np.cos(angle[:, 0]), radius[:, 0] * np.sin(angle[:, 0]),
         radius[:, 1] * np.cos(angle[:, 1]), radius[:, 1] * np.sin(angle[:, 1])], axis=1
    ).astype(np.float32)  # fmt: skip


def _balanced(parts: Ints, rng: np.random.Generator, count: int) -> Ints:
    """Indices of random pixels, small parts as often as large ones every second time."""
    size = np.bincount(parts, minlength=JOINTS)[parts]
    chance = 0.5 / len(parts) + 0.5 / (size * len(np.unique(parts)))
    return rng.choice(len(parts), count, p=chance / chance.sum())


def _taught(forest: PartForest, every: Sequence[Picture]) -> PartForest:
    """The leaves' probabilities, votes and facing from many more pixels than the trees were grown on."""
    number = len(forest.facing)
    seen, facing = np.zeros((number, JOINTS)), np.zeros(number)
    votes = np.zeros((number, JOINTS, 3))
    for picture in every:
        reached = leaves(forest, picture.depth, picture.pixels, FOCAL)
        part = picture.parts
        z = picture.depth[picture.pixels[:, 0], picture.pixels[:, 1]].astype(np.float64)
        to_joint = picture.joints[part] - KINECT.unproject(picture.pixels[:, ::-1], z)
        for tree in range(reached.shape[1]):
            np.add.at(seen, (reached[:, tree], part), 1.0)
            np.add.at(votes, (reached[:, tree], part), to_joint)
            np.add.at(facing, reached[:, tree], float(picture.facing))
    total = seen.sum(axis=1)
    # What the trees were grown on stands for a few pixels in leaves that hardly any of these reached.
    parts = (seen + 4.0 * forest.parts) / (total + 4.0)[:, None]
    mean = votes.sum(axis=0) / np.maximum(seen.sum(axis=0), 1.0)[:, None]
    offsets = (votes + 2.0 * mean) / (seen + 2.0)[..., None]
    return replace(forest, parts=parts, votes=offsets, facing=(facing + 1.0) / (total + 2.0))


def _calibrated(forest: PartForest, every: Sequence[Picture], bins: int = 8) -> tuple[Floats, Floats]:
    """How often joints were within 10 cm, by the mass of their votes, on pictures the forest has not seen."""
    from sklearn.isotonic import IsotonicRegression

    masses, hits = [], []
    for picture in every:
        places, mass, _ = _modes(forest, DepthFrame(KINECT, picture.depth))
        masses.append(mass[:, 0])
        with np.errstate(invalid="ignore"):
            hits.append(np.linalg.norm(places[:, 0] - picture.joints, axis=1) < WITHIN)
    mass, hit = np.array(masses), np.array(hits, float)
    table, share = np.empty((JOINTS, bins)), np.empty((JOINTS, bins))
    for joint in range(JOINTS):
        smooth = IsotonicRegression(out_of_bounds="clip").fit(mass[:, joint], hit[:, joint])
        table[joint] = np.quantile(mass[:, joint], np.linspace(0.02, 0.98, bins))
        share[joint] = smooth.predict(table[joint])
    return table, share
