"""What a recording's channels are, whatever is measured of them."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from ...arrays import Bools, Floats, Ints
from ...bodies.motion import Markers, Motion
from ..channels.joints import joints_of
from ..channels.recording import Channels
from ..noise.band_limited import BandLimited, band_limited_by_distances, band_limited_noise
from ..noise.digits import rounding
from ..noise.lasting import USUAL_OF_ANGLES, USUAL_OF_MARKERS, Lasting, lasting_by_distances, lasting_noise
from ..outliers.as_pose import of_one_limb, smoother_as_pose
from ..outliers.other_pose import other_poses
from ..outliers.poles import pole_crossings
from .own_jumps import channels_beside, channels_that_meet, own_jumps


@dataclass(frozen=True, eq=False)
class Traits:
    """What the adaptive repair asks of C channels besides their samples; by default nothing is known.

    Attributes
    ----------
    together : G, neighbouring columns that are outliers together: 1 for angles, 3 for markers.
    joints : (C,) a number for each joint, alike where columns are angles of one; None = each has one of its own.
    limb : (C, C) which columns are angles of joints of which one carries the other; None = none are.
    beside : (C, C) which columns are angles of joints that hang on one: `own_jumps.channels_beside`; None = none are.
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
    beside: Bools | None = None
    leaping: Callable[[Floats], Bools] | None = None
    as_pose: Callable[[Floats, Bools, Floats], Bools] | None = None
    own_leaps: Callable[[Floats, Bools, Floats], Bools] | None = None
    rounded: Callable[[slice], Floats] | None = None
    lasting: Lasting | BandLimited | None = None


UNKNOWN = Traits()


def traits_of(values: Floats, recording: Motion | Markers, channels: Channels) -> Traits:
    """What the channels are whose samples are `values` (T, C), degrees or cm, of a recording."""
    rounded = rounding(recording, channels.columns)
    usual = USUAL_OF_MARKERS if isinstance(recording, Markers) else USUAL_OF_ANGLES
    lasting = lasting_noise(values, recording.fps, usual) if rounded is None else None
    if isinstance(recording, Markers):
        if rounded is None:
            told = lasting_by_distances(values, recording.fps) or band_limited_by_distances(values, recording.fps)
            return Traits(together=3, rounded=rounded, lasting=told or lasting)
        return Traits(together=3, rounded=rounded)
    skeleton, columns = recording.skeleton, channels.columns
    beside = channels_beside(skeleton, columns)
    return Traits(
        joints=joints_of(skeleton, columns),
        limb=of_one_limb(skeleton, columns),
        leaping=lambda angles: (
            pole_crossings(angles, skeleton, columns) | other_poses(angles, skeleton, columns, recording.fps)
        ),
        as_pose=partial(smoother_as_pose, skeleton=skeleton, columns=columns),
        own_leaps=partial(own_jumps, linked=channels_that_meet(skeleton, columns), fps=recording.fps, beside=beside),
        beside=beside,
        rounded=rounded,
        lasting=lasting or (band_limited_noise(values, recording.fps) if rounded is None else None),
    )
