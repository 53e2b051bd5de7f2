"""What a body is made of: ellipsoids and elliptic cones fixed to bones."""

from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from ..arrays import Bytes, Floats, Ints, frozen
from ..errors import MismatchError
from ..kernels.body import Shell

ELLIPSOID, CONE = 0, 1


@final
@dataclass(frozen=True, eq=False)
class Solids:
    """P solids on bones; a sphere is an ellipsoid of one size, a cylinder a cone without taper.

    Attributes
    ----------
    bone : (P,) index of the bone that carries it.
    kind : (P,) 0 ellipsoid, 1 elliptic cone with flat ends, along its own y.
    center : (P, 3) m, in the bone's frame.
    turn : (P, 3, 3), bone from solid.
    size : (P, 3) m, half extents along the solid's own axes; of a cone the radii half way along.
    taper : (P,) in (-1, 1): a cone's radii are 1 + taper times its size at the +y end, 1 - taper at the -y end.
    """

    bone: Ints
    kind: Bytes
    center: Floats
    turn: Floats
    size: Floats
    taper: Floats

    def __post_init__(self) -> None:
        count = len(self.bone)
        shapes: dict[str, tuple[tuple[int, ...], type]] = {
            "bone": ((count,), np.int64),
            "kind": ((count,), np.uint8),
            "center": ((count, 3), np.float64),
            "turn": ((count, 3, 3), np.float64),
            "size": ((count, 3), np.float64),
            "taper": ((count,), np.float64),
        }
        for name, (shape, dtype) in shapes.items():
            object.__setattr__(self, name, frozen(getattr(self, name), dtype))
            if getattr(self, name).shape != shape:
                raise MismatchError(f"{name} of {count} solids must be {shape}, came {getattr(self, name).shape}")
        if np.any(self.size <= 0) or np.any(np.abs(self.taper) >= 1):
            raise MismatchError("solids need sizes above 0 and tapers between -1 and 1")

    def __len__(self) -> int:
        return len(self.bone)

    @cached_property
    def arrays(self) -> Shell:
        """Copies of bone, kind, center, turn, size and taper, as kernels take them."""
        return Shell(
            self.bone.copy(),
            self.kind.copy(),
            self.center.copy(),
            self.turn.copy(),
            self.size.copy(),
            self.taper.copy(),
        )

    def stretched(self, stretch: Floats) -> "Solids":
        """The same solids on bones stretched by `stretch` (B, 3) along the bones' own axes.

        Centres move with the bone. Sizes follow the stretch along the solid's own axes, but what is a sphere stays a
        sphere as long as the bone's two cross axes stretch alike.
        """
        factor = stretch[self.bone]
        size = self.size * np.linalg.norm(self.turn * factor[:, :, None], axis=1)
        ball = (self.kind == ELLIPSOID) & (np.ptp(self.size, axis=1) < 1e-9)
        across = factor[:, [0, 2]]
        size[ball] = self.size[ball] * np.sqrt(across.prod(axis=1))[ball, None]
        return Solids(self.bone, self.kind, self.center * factor, self.turn, size, self.taper)
