"""What is known of the one person a sensor sees, from frame to frame, and what is needed to look at the next."""

from dataclasses import dataclass, replace
from math import exp

import numpy as np

from ..arrays import Bools, Bytes, Floats, Ints, frozen
from ..kernels import proportions
from ..kernels import sighting as kernel
from ..numerics.factors import Factors
from .anatomy import Anatomy
from .follow import Followed, begin
from .level import TOLD_ALREADY, UNASKED, Lean, level
from .normalise import Placement, Standard, bone_lengths
from .reliability import Detector
from .shaking import Shaking, calm

FAR = 100.0  # m; what is farther is no person
POINT = 1e-3  # m; joints that are all within this are no person either
RANGE = 2.0  # times what is usual; bones vary by so much in some recordings of the sensor that was learned from
NO_STATES = np.zeros(0, dtype=np.uint8)


@dataclass(frozen=True, eq=False)
class Watcher:
    """What is needed to look at frames: the model's joint set and standard body, and what was learned of failures."""

    body: Anatomy
    standard: Standard
    factors: Factors
    detector: Detector


@dataclass(frozen=True, eq=False)
class Sight:
    """What is known after a frame, in the model's joints.

    Attributes
    ----------
    upright : (3, 3) rotation of the sensor's axes that brings its up to y; None before a person was seen.
    time : s, of the frame; None before the first.
    seen : s, of the last frame in which somebody was; -inf before that.
    rows : (J, 3) m, the frame's positions upright, NaN = missing.
    earlier : (J, 3) m, those of the frame before.
    latest : (J, 3) m, those of the last frame in which somebody was.
    placement : of this frame alone.
    direction : (2,) where the trunk points from right to left.
    lengths : (2, B) trusted lengths summed in m, and how many.
    spread : (B,) by how much the logarithm of each bone's length varies.
    followed : in standard form.
    swapped : (J,) joints whose sides were changed back.
    righted : (J,) joints whose sides, as this frame shows, were confused until now.
    moved : (J,) joints that the sensor ever had elsewhere than a frame before, or will in this recording: what never
        moves has not stopped.
    stale : s, for which the sensor has said this posture, all joints alike: a slow one says each several times.
    refused : the frame says so little that it was not judged.
    shaking : how much all joints shake.
    other : somebody else is where a moment ago somebody was; or who was there was seen aslant until now.
    lean : what was seen of how far the sensor is tilted.
    speaks : it ever said of a joint that it is tracked or inferred.
    """

    upright: Floats | None
    time: float | None
    seen: float
    rows: Floats
    earlier: Floats
    latest: Floats
    placement: Placement
    direction: Floats
    lengths: Floats
    spread: Floats
    followed: Followed
    swapped: Bools
    righted: Bools
    moved: Bools
    stale: float
    refused: bool
    shaking: Shaking
    other: bool = False
    lean: Lean = UNASKED
    speaks: bool = False

    @property
    def scale(self) -> float:
        """Size of the person by that of the standard body."""
        return float(self.placement.scale[0])


def fresh(watcher: Watcher) -> Sight:
    """Before the first frame."""
    joints, bones = len(watcher.body.names), len(watcher.body.bones)
    return Sight(
        None,
        None,
        -np.inf,
        np.full((joints, 3), np.nan),
        np.full((joints, 3), np.nan),
        np.full((joints, 3), np.nan),
        Placement(np.eye(3)[None], np.zeros((1, 3)), np.ones(1)),
        np.zeros(2),
        np.zeros((2, bones)),
        watcher.detector.bone_spread,
        begin(watcher.factors),
        np.zeros(joints, dtype=np.bool_),
        np.zeros(joints, dtype=np.bool_),
        np.zeros(joints, dtype=np.bool_),
        0.0,
        False,
        calm(joints),
    )


def acquainted(watcher: Watcher, rows: Floats, sight: Sight) -> Sight:
    """The sight before a recording's first frame when all of the recording is at hand: its size is known at once.

    Parameters
    ----------
    rows : (T, J, 3) m in the sensor's axes.
    """
    turn = level(rows, watcher.body)
    lengths = bone_lengths(rows, watcher.body)
    known = np.zeros((2, lengths.shape[1]))
    for b in range(lengths.shape[1]):
        some = lengths[np.isfinite(lengths[:, b]), b]
        if len(some):
            known[:, b] = 100.0 * np.median(some), 100.0
    return replace(sight, upright=turn, lengths=known, lean=TOLD_ALREADY)


def unsteadiness(watcher: Watcher, spread: Floats) -> Floats:
    """(B,) deviation of the logarithm of each bone's length that is usual here, by what it is in this recording (B,).

    Most joints do not fail, so the median bone shows the sensor's own restlessness; that of one limb that is drawn in
    does not count. Recordings of one sensor differ as well, and that is no reason to overlook failures. The joints'
    second differences are not asked: who moves briskly would teach that failures are usual.
    """
    wider: Floats = proportions.unsteadiness(frozen(spread), watcher.detector.bone_spread, RANGE)
    return wider


def size_of(watcher: Watcher, lengths: Floats) -> float:
    """The person's size by that of the standard body; 1 when no bone is known.

    Parameters
    ----------
    lengths : (2, B) sums and counts.
    """
    usual = np.array(watcher.standard.lengths)
    return float(proportions.usual_lengths(lengths, watcher.standard.lengths, usual)) or 1.0


def kinship(watcher: Watcher, sight: Sight, doubt: float = 0.0) -> float:
    """The probability that what is seen comes from the sensor that was learned from: bones tell.

    Parameters
    ----------
    doubt : log-odds by which its joints themselves speak against that (`Joining.doubt`).
    """
    body = watcher.body
    kin = float(proportions.kinship(sight.lengths, watcher.standard.lengths, body.twins, body.parts))
    return kin / (kin + (1.0 - kin) * exp(doubt))


def believable(positions: Floats) -> Floats:
    """Positions (..., J, 3) in m, all NaN where no person can be.

    That is what is not finite, far away, or at the sensor itself, where some recordings put what they miss; and
    whole postures in one point.
    """
    frames = np.array(positions, dtype=np.float64).reshape(-1, *positions.shape[-2:])
    return np.asarray(kernel.believable(frames, FAR, POINT)).reshape(positions.shape)


def received(to_model: Ints, positions: Floats, states: Bytes | None) -> tuple[Floats, Floats, Bytes | None]:
    """A frame as it came in: what of it is `believable`, and that and the states by the model's joints.

    Parameters
    ----------
    to_model : (J of model,) the recording's joint of each of the model's, -1 = none.
    positions : (J, 3) m.
    states : (J,) or None.
    """
    codes = NO_STATES if states is None else np.array(states, dtype=np.uint8)
    given, rows, told = kernel.received(np.array(positions, dtype=np.float64), codes, to_model, FAR, POINT)
    return given, rows, None if states is None else told


def rows_of(to_model: Ints, values: Floats) -> Floats:
    """(..., J, 3) values by the model's joints, NaN for joints that the recording lacks."""
    return np.where((to_model >= 0)[:, None], values[..., to_model, :], np.nan)
