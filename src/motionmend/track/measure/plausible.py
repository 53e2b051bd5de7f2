"""Whether a body can be this person's: by its lengths, and by what it leaves unexplained throughout a recording."""

import numpy as np

from ...arrays import Floats
from ...bodies import anatomy
from ...bodies.performer import BONES, Performer

LONG = tuple(b for b, bone in enumerate(BONES) if bone.endswith(("thigh", "shank", "upperarm", "forearm")))
SHORTEST, LONGEST = 0.35, 1.45  # times an average adult's; an infant's are 0.4, and of the tallest people ever 1.4
UNLIKE = 0.3  # share of pixels explained wrongly in the median frame: the right bodies' come to 0.25
STILL_UNLIKE = 0.25  # of what never sways; six bodies unlike the own come to 0.14 to 0.19 there, a coat rack to 0.29
FRAMES = 5  # that say so at least


def unlike(wrong: Floats, most: float = UNLIKE) -> bool:
    """Whether a body that explains shares (N,) of the pixels wrongly, more than `most` in the median frame, is not this
    person's, or nobody's."""
    shares = wrong[np.isfinite(wrong)]
    return bool(len(shares) >= FRAMES and np.median(shares) > most)


def doubts(performer: Performer, wrong: Floats, *, still: bool = False) -> tuple[str, ...]:
    """What speaks against a body, in sentences.

    Parameters
    ----------
    performer : as given, or as measured.
    wrong : (N,) shares of the person's pixels that it explains wrongly, in frames with somebody in them.
    still : whether what is followed never moves.
    """
    said: tuple[str, ...] = ()
    times = performer.lengths / anatomy.average().lengths
    far = max(LONG, key=lambda b: abs(float(np.log(times[b]))))
    if not SHORTEST <= times[far] <= LONGEST:
        said += (
            f"the body's {BONES[far]} is {performer.lengths[far]:.2f} m long, {times[far]:.2g} times an adult's "
            "and nobody's: check depth_scale, fx and fy in camera.json, or the body that was given",
        )
    if still:
        said += (
            "what is followed never moves, not by the millimetres by which people who stand still sway: it may be a "
            "dummy or furniture, and nobody there",
        )
    if unlike(wrong):
        said += (
            f"the body explains {100 * np.nanmedian(wrong):.0f} % of the person's pixels wrongly in the middle one of "
            "the frames, where 10 to 20 are usual: it is not this person's, the camera's numbers are wrong, or the "
            "motion is like none of the model's; joints may be farther off than their deviations say",
        )
    return said
