"""What a corrector is taught with: what a sensor said and what was true, at the same moments."""

from dataclasses import dataclass

from ..bodies.postures import Postures
from ..errors import MismatchError


@dataclass(frozen=True, eq=False)
class Pair:
    """A recording of a sensor and the truth about it.

    Attributes
    ----------
    sensor : as the sensor gave it.
    truth : in the sensor's axes, at its times and with its joint names; NaN where the truth is not known.
    fitted : a rigid motion brought the truth to the sensor (`Matched.pair`): that of the two systems to each other is
        not known, and nothing is to be learned of it.
    """

    sensor: Postures
    truth: Postures
    fitted: bool = False

    def __post_init__(self) -> None:
        if self.sensor.names != self.truth.names or self.sensor.frames != self.truth.frames:
            raise MismatchError(
                f"a pair has the same joints and frames on both sides, came {len(self.sensor.names)} and "
                f"{len(self.truth.names)} joints, {self.sensor.frames} and {self.truth.frames} frames"
            )
