"""Who was taken up wrongly at the start is looked for anew: nobody bends so and explains the images so badly.

What a pose explains wrongly is judged by what is usual with this person, and that is learned of the poses followed. Of
who was taken up wrongly, side-on or bent, the trunk turned against the legs or one arm for the other, this is usual
from the first frame on, and the readings asked for (`facing`, `left_right`) need not be near the truth. Two numbers
tell it, whatever is usual; and half a second later the body is mostly found.
"""

from dataclasses import dataclass, replace
from typing import final

from ...bodies.performer import Pose
from ...numerics.neighbors import Neighbors
from ..misread import odds_misread

DOUBTED = -2.0  # log odds, in the mean of all frames since the start, above which the body is looked for
FIRST, LAST = 0.5, 4.0  # s since the start, of the first look and, each twice as late as the one before, the last one
CLEARLY = 2.0  # log odds by which another pose has to be better; and it has to be right more likely than not


@final
@dataclass(frozen=True)
class Afresh:
    """A body that was just found for the first time.

    Attributes
    ----------
    odds : log, sum over frames that the body is followed wrongly. frames : how many.
    time : s since it was found. look : s since then at which it is looked for, if it is doubted by then.
    """

    odds: float = 0.0
    frames: int = 0
    time: float = 0.0
    look: float = FIRST

    @property
    def due(self) -> bool:
        """Whether it is time for a look, or to leave it at that."""
        return self.time >= self.look - 1e-6

    @property
    def doubted(self) -> bool:
        """Whether the body may well be followed wrongly, ever since it was found."""
        return self.frames > 0 and self.odds > DOUBTED * self.frames

    @property
    def later(self) -> "Afresh | None":
        """After a look that found nothing better; None after the last one."""
        return replace(self, look=2.0 * self.look) if 2.0 * self.look <= LAST else None


def watched(afresh: Afresh, elapsed: float, odds: float) -> Afresh:
    """What is known with one more frame.

    Parameters
    ----------
    afresh : as of the frame before. elapsed : s, since then. odds : of this frame, as `odds_misread` gives them.
    """
    return replace(afresh, odds=afresh.odds + odds, frames=afresh.frames + 1, time=afresh.time + elapsed)


def better(search: Neighbors, pose: Pose, wrong: float, other: Pose, share: float, beside: float = 0.0) -> bool:
    """Whether another pose, which explains a share of the pixels wrongly, is taken for the one that is followed.

    What else is known `beside` that are log odds for the other one.
    """
    now, then = odds_misread(search, pose, wrong), odds_misread(search, other, share)
    return then < min(0.0, now - CLEARLY + beside)
