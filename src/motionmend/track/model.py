"""What a tracker learns of clips: poses for the prior, and a detector that finds a person anew."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, final

import numpy as np

from ..arrays import Floats
from ..bodies.motion import Motion
from ..errors import MismatchError
from .database import PoseDatabase, database_of


@final
@dataclass(frozen=True, eq=False)
class TrackerModel:
    """A fitted tracker.

    Attributes
    ----------
    database : poses of the clips at 30 Hz.
    detector : finds the joints in one image; None in a model without one.
    """

    database: PoseDatabase
    detector: Any = None

    @classmethod
    def fit(cls, clips: Sequence[Motion], seed: int = 0, detector: bool = True, images: int = 2000) -> "TrackerModel":
        """Learn from clean clips of any skeleton with the 16 joints.

        Parameters
        ----------
        clips : with limbs, in any axes and units of their own skeletons.
        seed : of the synthetic images the detector learns from; the same clips and seed give the same model.
        detector : whether to learn one; without it tracking has to be given the first pose.
        images : how many of whole people the detector learns from; half as many more are of people who are cut off.

        Raises
        ------
        MismatchError
            When no clip gives a pose.
        """
        database, poses, performers = database_of(clips)
        if not len(database):
            raise MismatchError("clips with whole poses of a body were wanted, came none")
        if not detector:
            return cls(database)
        from .detect.joints import fit_detector

        fitted = cls(database, fit_detector(poses, performers, seed, images))
        return cls.from_arrays(*fitted.to_arrays())  # as a file would give it back

    def to_arrays(self) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
        """Arrays by name and a JSON header, as model files hold them."""
        arrays: dict[str, np.ndarray] = {
            "database.joints": np.asarray(self.database.joints, np.float32),
            "database.last": np.asarray(self.database.last),
        }
        if self.detector is not None:
            arrays |= {f"detector.{name}": values for name, values in self.detector.arrays().items()}
        return arrays, {"fps": 30, "detector": self.detector is not None}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, np.ndarray], header: Mapping[str, Any]) -> "TrackerModel":
        """The model that `to_arrays` took apart."""
        database = PoseDatabase(arrays["database.joints"], arrays["database.last"])
        if not header["detector"]:
            return cls(database)
        from .detect.joints import Detector

        own = {name.removeprefix("detector."): a for name, a in arrays.items() if name.startswith("detector.")}
        return cls(database, Detector.from_arrays(own))

    @property
    def examples(self) -> Floats:
        """(N, 28) about a thousand poses evenly out of the library, to begin a start with."""
        return self.database.joints[:: max(1, len(self.database) // 1000)]

    @cached_property
    def limb_shapes(self) -> tuple[Floats, ...]:
        """Poses of each limb to be tried where it is lost."""
        from ..bodies import anatomy
        from .limbs.other_poses import shapes_of

        return shapes_of(self.database, anatomy.average())
