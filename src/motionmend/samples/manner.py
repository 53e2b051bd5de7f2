"""How the trunk and arms go with a gait.

Walking: Murray, Drought and Kory, J. Bone Joint Surg. 46A (1964) 335-360 (pelvis, width, toe-out); Murray, Sepic and
Barnard, Phys. Ther. 47 (1967) 272-284 (arms). Running: Novacheck, Gait Posture 7 (1998) 77-95 (pelvis, trunk);
Hinrichs, Int. J. Sport Biomech. 3 (1987) 222-241 (arms). Rounded; what they do not give is chosen by eye.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Manner:
    """Amplitudes and means; degrees but for `sway` and `width`, m."""

    sway: float  # of the root from side to side
    width: float  # between the feet's lines
    toe_out: float
    turn: float  # of the pelvis about the vertical
    drop: float  # of the pelvis on the swinging side
    tilt: float  # of the pelvis, forward
    lean: float  # of the trunk, forward
    counter: float  # turn of the thorax against the pelvis
    swing: float  # of the upper arm
    hang: float  # its mean, forward positive
    elbow: float
    elbow_swing: float
    abduction: float
    inward: float  # turn of the forearms towards the middle


WALK = Manner(
    sway=0.021,
    width=0.09,
    toe_out=6.5,
    turn=4.5,
    drop=3.5,
    tilt=5.0,
    lean=3.0,
    counter=4.5,
    swing=17.0,
    hang=-4.0,
    elbow=27.0,
    elbow_swing=11.0,
    abduction=8.0,
    inward=18.0,
)
RUN = Manner(
    sway=0.008,
    width=0.04,
    toe_out=4.0,
    turn=6.0,
    drop=4.0,
    tilt=11.0,
    lean=9.0,
    counter=11.0,
    swing=30.0,
    hang=-14.0,
    elbow=84.0,
    elbow_swing=14.0,
    abduction=17.0,
    inward=38.0,
)
