"""Who performs: stature, style and the small things that tell people apart."""

from dataclasses import dataclass, replace

import numpy as np

from .manner import Manner


@dataclass(frozen=True)
class Person:
    """A performer.

    Attributes
    ----------
    height : stature, m.
    style : from weary (-1: stooped, wide, arms hardly moving) over plain (0) to brisk (1: upright, arms swinging).
    gaze : rad, mean forward bend of the neck.
    stoop : rad, forward bend of the back at rest.
    uneven : share by which the left arm swings more than the right.
    irregularity : coefficient of variation of stride time and length; about 2 % in healthy adults (Hausdorff et al.,
        J. Appl. Physiol. 80 (1996) 1448-1457).
    traits : (8,) standard normal, what else tells this person from another.
    """

    height: float
    style: float
    gaze: float
    stoop: float
    uneven: float
    irregularity: float
    traits: tuple[float, ...]

    def manner(self, norm: Manner) -> Manner:
        """The published manner of a gait as this person has it."""
        z, style = self.traits, self.style
        return replace(
            norm,
            sway=norm.sway * (1 - 0.2 * style) * (1 + 0.1 * z[0]),
            width=norm.width * (1 - 0.25 * style) * (1 + 0.12 * z[0]),
            toe_out=norm.toe_out + 2.0 * z[1],
            turn=norm.turn * (1 + 0.2 * style) * (1 + 0.1 * z[2]),
            drop=norm.drop * (1 + 0.15 * z[3]),
            tilt=norm.tilt + 1.5 * z[3],
            lean=norm.lean + np.degrees(self.stoop) - 1.0,
            counter=norm.counter * (1 + 0.4 * style) * (1 + 0.1 * z[4]),
            swing=norm.swing * (1 + 0.45 * style) * (1 + 0.12 * z[5]),
            hang=norm.hang + 2.0 * z[5],
            elbow=norm.elbow * (1 + 0.15 * style) + 3.0 * z[6],
            abduction=norm.abduction + 1.5 * z[7],
        )


def person(height: float, style: float, rng: np.random.Generator) -> Person:
    """Someone of that stature and style; the rest is drawn."""
    z = rng.standard_normal(10)
    return Person(
        height=height,
        style=style,
        gaze=float(np.radians(5.0 - 7.0 * style + 2.0 * z[8])),
        stoop=float(np.radians(1.0 - 4.0 * style + 1.0 * z[4])),
        uneven=float(0.08 * z[9]),
        irregularity=0.015,
        traits=tuple(float(v) for v in z[:8]),
    )
