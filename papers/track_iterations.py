"""Section 3.6: how many iterations it takes"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from motionmend.arrays import Floats, Singles
from motionmend.bodies.camera import KINECT
from motionmend.bodies.performer import DOFS, Pose, advance, landmarks
from motionmend.report.figures import lines_figure
from motionmend.track.frame.evidence import evidence_of
from motionmend.track.frame.observation import Observation
from motionmend.track.model import TrackerModel
from motionmend.track.settings import TrackSettings, settings_of
from motionmend.track.state import TrackState
from motionmend.track.terms.objective import terms_of
from motionmend.track.terms.solve import solve_pose

from .common import Findings
from .track_common import ABOUT, DANCE, Stage, library, shown, stage

COUNTS = (0, 1, 2, 3, 4, 5, 7, 10, 15, 20, 30)
SOME = range(4, 100, 12)


def run(mocap: Path, pictures: Path) -> Findings:
    """Error after so many iterations, from the pose two frames before; and where small perturbations end."""
    model, scene = library(mocap), stage(mocap, DANCE)
    frames = shown(scene)
    curves: dict[str, Floats] = {}
    ends = []
    for preset in ("paper", "default"):
        whole = settings_of(preset)
        wish = replace(
            whole, terms=tuple(term for term in whole.terms if term != "color"), damping=max(whole.damping, 1e-6)
        )
        rows = [_errors(model, scene, frames[t].depth, wish, t) for t in SOME]
        curves[preset] = np.mean(rows, axis=0)
    rng = np.random.default_rng(0)
    plain = settings_of("default", ("surface", "edge", "limits", "freespace"))
    for t in SOME:
        found = []
        for _ in range(3):
            delta = rng.uniform(-1, 1, DOFS) * np.r_[np.full(3, 0.02), np.full(DOFS - 3, np.radians(5.0))]
            begin = advance(scene.performer, scene.poses[t], delta)
            found.append(_solved(model, scene, frames[t].depth, plain, begin, 30))
        ends.append(max(float(np.linalg.norm(found[0] - one, axis=1).mean()) for one in found[1:]))
    counts = np.array(COUNTS)
    lines_figure(
        pictures / "track_iterations.png",
        counts.astype(float),
        curves,
        xlabel="iterations",
        ylabel="error, cm",
        leading=("default",),
    )
    ten, most = COUNTS.index(10), len(COUNTS) - 1

    def settled(name: str) -> float:
        return float((curves[name][0] - curves[name][ten]) / (curves[name][0] - curves[name][1:].min()))

    return Findings(
        {
            "begin_cm": float(curves["paper"][0]),
            "paper_ten_cm": float(curves["paper"][ten]),
            "paper_thirty_cm": float(curves["paper"][most]),
            "paper_settled": settled("paper"),
            "default_ten_cm": float(curves["default"][ten]),
            "default_thirty_cm": float(curves["default"][most]),
            "default_settled": settled("default"),
            "ends_cm": 100.0 * float(np.median(ends)),
        },
        (
            ABOUT,
            f"{len(SOME)} frames of a clean dance, each begun from the pose two frames before, without colour. Perturbed: "
            "up to 5 degrees in every joint and 2 cm, three times, without prior; how far apart the ends are.",
        ),
        (),
        (("track_iterations.png", "Error by the number of Gauss-Newton iterations."),),
    )


def _errors(model: TrackerModel, scene: Stage, depth: Singles, wish: TrackSettings, t: int) -> list[float]:
    return [
        100.0
        * np.linalg.norm(_solved(model, scene, depth, wish, scene.poses[t - 2], n) - scene.joints[t], axis=1).mean()
        for n in COUNTS
    ]


def _solved(model: TrackerModel, scene: Stage, depth: Singles, wish: TrackSettings, begin: Pose, count: int) -> Floats:
    if count == 0:
        return landmarks(scene.performer, begin)
    evidence = evidence_of(Observation(KINECT, depth, np.isnan(depth), 0.0), wish)
    assert evidence is not None
    state = TrackState(scene.performer, pose=begin)
    found = solve_pose(scene.performer, evidence, terms_of(model, wish, state, evidence, begin), begin, wish, count)
    return landmarks(scene.performer, found.state)
