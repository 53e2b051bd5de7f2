"""What a recording's channels are, whatever is measured of them."""

from collections.abc import Callable
from dataclasses import dataclass

from ...arrays import Bools, Floats, Ints
from ..noise.band_limited import BandLimited
from ..noise.lasting import Lasting


@dataclass(frozen=True, eq=False)
class Traits:
    """What the adaptive repair asks of C channels besides their samples; by default nothing is known.

    Attributes
    ----------
    together : G, neighbouring columns that are outliers together: 1 for angles, 3 for markers.
    joints : (C,) a number for each joint, alike where columns are angles of one; None = each has one of its own.
    limb : (C, C) which columns are angles of joints of which one carries the other; None = none are.
    leaping : of some frames (T, C) where no sample is an outlier and what bends may bend as it will:
        `poles.pole_crossings` and `other_pose.other_poses`; None = nowhere.
    as_pose : of measured, rejected and values (T, C) what is no outlier for the pose: `as_pose.smoother_as_pose`;
        None = nothing.
    own_leaps : of the same, what leaps like the recording itself: `own_jumps.own_jumps`; None = nothing.
    rounded : of some frames the variance (N, C) of what rounding took from the samples; None = nothing.
    lasting : noise that lasts, or was smoothed; None = it is new in every frame.
    """

    together: int = 1
    joints: Ints | None = None
    limb: Bools | None = None
    leaping: Callable[[Floats], Bools] | None = None
    as_pose: Callable[[Floats, Bools, Floats], Bools] | None = None
    own_leaps: Callable[[Floats, Bools, Floats], Bools] | None = None
    rounded: Callable[[slice], Floats] | None = None
    lasting: Lasting | BandLimited | None = None


UNKNOWN = Traits()
