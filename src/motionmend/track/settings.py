"""What the tracker weighs, and how much: the dissertation's terms and weights, and ours."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import degrees
from typing import final

from ..errors import UsageError

PER_RADIAN = degrees(1.0) ** 2  # a weight of squared degrees, as one of squared radians
TERMS = ("surface", "color", "edge", "prior", "limits", "freespace")


@final
@dataclass(frozen=True)
class TrackSettings:
    """Settings of one tracker; lengths in m, angles in rad, weights per squared metre or squared radian.

    Attributes
    ----------
    preset : where the numbers come from.
    terms : of `TERMS`; smoothness is always on.
    iterations : of Gauss-Newton, at most, each frame.
    median : radius of the median that cleans depth, px.
    raster : every n-th pixel of the frame is worked on, as fine as the Kinect's of 320 x 240.
    every : every n-th pixel of that raster is a sample of the surface.
    edge_every : every n-th row and column is looked at for observed edges.
    window, edge_window : side of the square in which the nearest point is looked for, px of the raster.
    evened : all samples of the surface, or of its edges, weigh the same together, however many a frame has; else each
        weighs one, as in the dissertation.
    steady : poses of a whole recording are made steady at the end.
    two_way : observed points look for the model's too, not only the model's for observed ones.
    along_normal, along_back : share of a surface residual that counts along the model's normal only, of rendered
        points and of observed ones.
    canny : edges by Canny on depth; else by steps in depth.
    scale : of the Geman-McClure estimator; infinite = least squares.
    gate : matches farther than this are none.
    free_scale : as `scale`, of points where nobody is.
    color_weight : m² that a squared difference of 1 in intensity (0 to 255) counts beside squared distances while
        matching.
    edge, prior, limits, freespace, smooth : weights of the terms, the surface's being 1.
    neighbors, following, energy : K, w and the share of energy of the local PCA.
    spread : rad, of a pose about its neighbours' that costs nothing much; 0 = the dissertation's projection.
    velocity : share of the last change of pose that is expected again.
    damping : of Levenberg-Marquardt, relative to the diagonal.
    settled : share of the cost that a step must promise to save, or it is the last one. Matches change at every step,
        so that steps hardly ever become short; but what they save soon becomes noise.
    girth : the person's widths are learned while they are followed.
    search : limbs that do not fit are looked for among other poses of theirs.
    hindsight : a recording's frames are followed back from later ones, too, and what explains them better is taken.
    """

    preset: str
    terms: tuple[str, ...]
    iterations: int = 10
    median: int = 1
    raster: int = 2
    every: int = 2
    edge_every: int = 1
    window: int = 9
    edge_window: int = 11
    evened: bool = True
    steady: bool = True
    two_way: bool = True
    along_normal: float = 1.0
    along_back: float = 0.9
    canny: bool = False
    scale: float = 0.05
    gate: float = 0.25
    free_scale: float = 0.15
    color_weight: float = 1e-5
    edge: float = 0.3
    prior: float = 0.1
    limits: float = 1.0
    freespace: float = 1.0
    smooth: float = 0.1
    neighbors: int = 50
    following: int = 3
    energy: float = 0.95
    spread: float = 0.1
    velocity: float = 0.5
    damping: float = 1e-3
    settled: float = 0.01
    girth: bool = True
    search: bool = True
    hindsight: bool = True


PRESETS = {
    "default": TrackSettings("default", ("surface", "edge", "prior", "limits", "freespace")),
    # Section 3.4.1: 15 x 15, weights 1.0 and 0.0001 (of squares, as in equation 3.4), every 4th pixel. 3.4.2: Canny,
    # 21 x 21. 3.6: lambda 1 to 3, of metres (3.4.1: the background is 100 away) and of degrees (as all angles of
    # section 2): on radians lambda 2 and 3 are nothing beside the surface, and the prior helps nowhere.
    "paper": TrackSettings(
        "paper",
        ("surface", "color", "edge", "prior"),
        raster=1,
        every=4,
        window=15,
        edge_window=21,
        evened=False,
        steady=False,
        two_way=False,
        along_normal=0.0,
        canny=True,
        scale=float("inf"),
        gate=float("inf"),
        color_weight=1e-4,
        edge=10.0,
        prior=1e-3 * PER_RADIAN,
        smooth=1e-5 * PER_RADIAN,
        spread=0.0,
        velocity=0.0,
        damping=0.0,
        settled=0.0,
        girth=False,
        search=False,
        hindsight=False,
    ),
}


def settings_of(preset: str = "default", terms: Sequence[str] | None = None) -> TrackSettings:
    """Settings by name, with other terms if wanted.

    Raises
    ------
    UsageError
        When the preset or a term is not known, or the surface is missing from the terms.
    """
    if preset not in PRESETS:
        raise UsageError(f"a preset of {', '.join(PRESETS)} was wanted, came {preset!r}")
    if terms is None:
        return PRESETS[preset]
    for term in terms:
        if term not in TERMS:
            raise UsageError(f"terms of {', '.join(TERMS)} were wanted, came {term!r}")
    if "surface" not in terms:
        raise UsageError(
            f"the surface must be among the terms, came {', '.join(terms) or 'none'}: colour chooses among its "
            "matches, edges alone leave depth open, and deviations are reckoned from how far it lies off"
        )
    return replace(PRESETS[preset], terms=tuple(dict.fromkeys(terms)))
