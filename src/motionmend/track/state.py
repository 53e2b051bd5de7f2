"""What is carried from one frame to the next: the body, and what is still asked of it."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import final

import numpy as np

from ..arrays import Bools, Floats, Singles, frozen
from ..bodies.performer import BONES, DOFS, Performer, Pose
from ..numerics.least_squares import Solution
from .frame.evidence import Evidence
from .frame.observation import Observation
from .limbs.other_poses import Coarse
from .measure.girth import Girth
from .model import TrackerModel
from .person.foreground import Scene
from .settings import TrackSettings
from .starting.afresh import Afresh
from .terms.contract import Term

EVERY = 4  # frames at least between two looks of the detector for limbs, and for a body that is lost


@final
@dataclass(frozen=True, eq=False)
class Hypothesis:
    """The other pose, as of the last frame.

    Attributes
    ----------
    pose : of the whole body. gained : share of the person's pixels, in sum, by which it is ahead; faded.
    velocity : (34,) m/s and rad/s. trust : (28,) as of `TrackState`. frames : for how many it has been followed.
    """

    pose: Pose
    gained: float
    velocity: Floats = field(default_factory=lambda: frozen(np.zeros(DOFS)))
    trust: Floats = field(default_factory=lambda: frozen(np.ones(DOFS - 6)))
    frames: int = 0


@final
@dataclass(frozen=True, eq=False)
class Sight:
    """One frame, and what it is looked at with.

    Attributes
    ----------
    model : pose library and detector. settings : terms and weights.
    seen : what the frame shows. evidence : what it says, for the terms. coarse : in few pixels, to compare poses by.
    """

    model: TrackerModel
    settings: TrackSettings
    seen: Observation
    evidence: Evidence
    coarse: Coarse


@final
@dataclass(frozen=True, eq=False)
class Fit:
    """How a frame is explained.

    Attributes
    ----------
    state : of this frame, but that pose, velocity, trust and hypothesis are still those of the frame before.
    terms : made for this frame (equation 3.14). expected : the pose that the motion so far leads to.
    solution : the pose. wrong : share of the person's pixels that it explains wrongly.
    """

    state: "TrackState"
    terms: Sequence[Term]
    expected: Pose
    solution: Solution[Pose]
    wrong: float

    @property
    def pose(self) -> Pose:
        """The solution's."""
        return self.solution.state


@final
@dataclass(frozen=True, eq=False)
class Look:
    """The first half of a look.

    Attributes
    ----------
    sight, begun : that frame, and the other reading in it, its limbs not looked for yet.
    pose, trust, wrong : of the reading that was followed in it.
    beside : odds (log) for the other reading by what else was known of it.
    """

    sight: Sight
    begun: Fit
    pose: Pose
    trust: Floats
    wrong: float
    beside: float


@final
@dataclass(frozen=True, eq=False)
class Question:
    """The other reading, while both stand.

    Attributes
    ----------
    pose : of the other reading in the frame it was last looked at. place : (3,) m, where the followed root was then.
    trust : (28,) of the other reading, as a state's. wrong : share of pixels it explained wrongly.
    odds : log, for the other reading. prior : the same before anything was seen; that does not fade.
    looks : taken so far. frames : since the last one began. look : one that is not finished.
    suspected : asked because the body bends strangely, the other reading being no likelier than `pair.RARE` says.
    """

    pose: Pose
    place: Floats
    trust: Floats = field(default_factory=lambda: frozen(np.ones(DOFS - 6)))
    wrong: float = float("nan")
    odds: float = 0.0
    prior: float = 0.0
    looks: int = 0
    frames: int = 0
    look: Look | None = None
    suspected: bool = False

    @property
    def waiting(self) -> "Question":
        """The question after a frame in which the other reading was not looked at."""
        return replace(self, frames=self.frames + 1)

    def moved(self, place: Floats) -> Pose:
        """The other reading where the followed root (3,) m is by now."""
        return Pose(self.pose.translation + place - self.place, self.pose.root, self.pose.joints)


@final
@dataclass(frozen=True, eq=False)
class Facing:
    """What is known of front and back.

    Attributes
    ----------
    question : which of two readings it is; None when that is closed.
    backwards : m, how far the followed reading has walked backwards lately.
    wait : s until it is asked again of a body that bends strangely.
    odds : log, for the other reading, of all looks at it, those before fading; minus infinity where it never was asked.
    prior : the same before anything was seen; that does not fade.
    """

    question: Question | None = None
    backwards: float = 0.0
    wait: float = 0.0
    odds: float = -float("inf")
    prior: float = 0.0

    @property
    def unread(self) -> bool:
        """Whether front and back of a body that was just found are not told apart yet."""
        return self.question is not None and not self.question.suspected


@final
@dataclass(frozen=True, eq=False)
class Sides:
    """What is known of left and right.

    Attributes
    ----------
    question : which of two readings it is; None when that is closed. asked : of which of `left_right.PAIRS` it is.
    wait : (3,) s until each of them is asked for.
    """

    question: Question | None = None
    asked: int = 0
    wait: tuple[float, ...] = (0.0, 0.0, 0.0)


@final
@dataclass(frozen=True, eq=False)
class TrackState:
    """All that is carried from one frame to the next.

    Attributes
    ----------
    performer : whose lengths and widths are used. scene : the room as known so far; None before the first frame.
    pose : of the last frame; None while nobody was ever found. velocity : (34,) per second.
    trust : (28,) in [0, 1] how well the last frame showed each joint coordinate.
    hidden : (16,) s since each joint was last seen; `tracker.NEVER` and more, if it never was.
    lost : the body was not found in the last frame.
    found : s since the body was found anew after it had been lost.
    wrong : share of pixels explained wrongly, a running mean over tracked frames; NaN before the first.
    misread : log odds that the body is followed wrongly, a running mean since it was found; NaN before.
    bare : (15,) share of each bone that should be seen and is not, a running mean; NaN before.
    searched : frames since limbs were last looked for by the detector.
    looked : frames since the whole body was looked for that was lost, or never found.
    facing : what is known of front and back. sides : of left and right.
    afresh : what is known of a body that was just found for the first time; None when that is closed.
    hypothesis : another pose that is followed beside this one, until one of them is refuted.
    girth : what was learned of the person's widths; None where they are not learned.
    before : bones, intensities, depths and intrinsics of the last frame, where colour counts.
    evidence : what the last frame said, for who looks back at it (`hindsight`); None where nobody was in it.
    observation : what the last frame showed, of every pixel; None where nobody was in it.
    time : s, of the last frame.
    """

    performer: Performer
    scene: Scene | None = None
    pose: Pose | None = None
    velocity: Floats = field(default_factory=lambda: frozen(np.zeros(DOFS)))
    trust: Floats = field(default_factory=lambda: frozen(np.ones(DOFS - 6)))
    hidden: Floats = field(default_factory=lambda: frozen(np.zeros(16)))
    lost: bool = True
    found: float = float("inf")
    wrong: float = float("nan")
    misread: float = float("nan")
    bare: Floats = field(default_factory=lambda: frozen(np.full(len(BONES), np.nan)))
    searched: int = 0
    looked: int = EVERY
    facing: Facing = field(default_factory=Facing)
    sides: Sides = field(default_factory=Sides)
    afresh: Afresh | None = None
    hypothesis: Hypothesis | None = None
    girth: Girth | None = None
    before: tuple[Floats, Singles, Singles, Floats] | None = None
    evidence: Evidence | None = None
    observation: Observation | None = None
    time: float = float("nan")

    @property
    def furniture(self) -> Bools | None:
        """(H, W) True on what was told to be furniture before anybody was followed; None = nothing."""
        return None if self.scene is None else self.scene.furniture
