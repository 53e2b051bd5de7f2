"""Sections 3.2 to 3.5: the parts, each with the number that shows it does what the text says"""

from dataclasses import replace
from pathlib import Path
from time import thread_time

import numpy as np
from scipy.ndimage import maximum_filter, minimum_filter

from motionmend.arrays import Bools
from motionmend.bodies.anatomy import average
from motionmend.bodies.camera import KINECT, DepthFrame
from motionmend.bodies.performer import BONES, DOF_BONES, DOFS, Performer, Pose, Poses, advance, bone_frames
from motionmend.bodies.solids import CONE, ELLIPSOID
from motionmend.bodies.surface import Rendering, render
from motionmend.evaluate.scenes import behind, room
from motionmend.evaluate.sensor import sensed
from motionmend.io.depth import read_depth
from motionmend.kernels import match
from motionmend.numerics.local_pca import local_pca
from motionmend.track.frame.evidence import edges_of, evidence_of
from motionmend.track.frame.observation import Observation
from motionmend.track.person.foreground import find_person
from motionmend.track.person.room import scene_of
from motionmend.track.settings import settings_of
from motionmend.track.terms.prior import prior_term
from motionmend.track.terms.surface import SurfaceTerm
from motionmend.track.terms.view import Sums, view_of

from .common import Findings
from .track_common import ABOUT, DANCE, DOZEN, Stage, library, stage

SOME = slice(0, None, 20)  # frames of the dance that are looked at
SLACK = 0.05  # m, the sensor's noise at 4 m


def run(mocap: Path, pictures: Path) -> Findings:
    """Body, camera, scenes, surface, edges and prior."""
    del pictures
    stages = [stage(mocap, take) for take in DOZEN]
    scene = stage(mocap, DANCE)
    performer, poses = scene.performer, scene.poses.some(SOME)
    head = performer.solids.bone == BONES.index("head")
    drawn = [render(performer, poses[t], KINECT) for t in range(len(poses))]
    seconds = []
    for _ in range(40):
        begin = thread_time()
        render(performer, poses[1], KINECT)
        seconds.append(thread_time() - begin)
    slopes = [_jacobian_off(performer, poses[t]) for t in range(len(poses))]
    edges = [_edges_off(picture) for picture in drawn]
    kept, false = _person_found(scene, drawn)
    utd = read_depth(mocap.parent / "kinect" / "utdmhad" / "Depth" / "a1_s1_t1_depth.mat")
    values = {
        "bones": float(len(BONES)),
        "dofs": float(DOFS),
        "head_spheres": float((head & (performer.solids.kind == ELLIPSOID)).sum()),
        "head_cylinders": float((head & (performer.solids.kind == CONE)).sum()),
        "retargeting_cm": float(100.0 * np.mean([one.retargeting.mean() for one in stages])),
        "retargeting_worst_cm": float(100.0 * max(one.retargeting.max() for one in stages)),
        "degrees_wide": float(2 * np.degrees(np.arctan(KINECT.width / 2 / KINECT.fx))),
        "degrees_high": float(2 * np.degrees(np.arctan(KINECT.height / 2 / KINECT.fy))),
        "utd_frames": float(utd.frames),
        "person_kept": kept,
        "person_false": false,
        "off_bone_um": 1e6 * max(_off_surface(picture) for picture in drawn),
        "render_ms": 1e3 * float(np.median(seconds)),
        "jacobian_off": float(max(slopes)),
        "edge_off_px": float(np.mean([one[0] for one in edges])),
        "edge_background": float(np.max([one[1] for one in edges])),
        **_prior(mocap, scene.poses),
    }
    return Findings(
        values,
        (
            ABOUT,
            "Jacobians: the normal matrix of the surface term against one from finite differences of points fixed to bones. "
            "Every 20th frame of the dance. Segmentation: with floor and two walls rendered behind, Kinect's noise.",
        ),
    )


def _off_surface(picture: Rendering) -> float:
    """How far the farthest point of a picture is from the solid it is said to be of, m, along the ray."""
    seen = picture.solid >= 0
    solid = picture.solid[seen].astype(np.int64)
    points, solids = picture.points[seen], picture.performer.solids
    frame = picture.placed[solid]
    local = np.einsum("nij,ni->nj", frame[:, :, :3], points - frame[:, :, 3])
    size = solids.size[solid]
    scaled = local / size
    ball = np.abs(np.linalg.norm(scaled, axis=1) - 1.0) * size.min(axis=1)
    flare = 1.0 + solids.taper[solid] * scaled[:, 1]
    wall = np.abs(np.hypot(scaled[:, 0], scaled[:, 2]) - flare) * size[:, [0, 2]].min(axis=1)
    cap = np.abs(np.abs(scaled[:, 1]) - 1.0) * size[:, 1]
    return float(np.where(solids.kind[solid] == CONE, np.minimum(wall, cap), ball).max())


def _jacobian_off(performer: Performer, pose: Pose) -> float:
    """Largest difference of the surface term's normal matrix from finite differences, of its largest entry."""
    plain = replace(settings_of("paper", ("surface",)), gate=np.inf)
    aside = render(performer, advance(performer, pose, np.full(DOFS, 0.01)), KINECT).depth
    evidence = evidence_of(Observation(KINECT, aside, np.isnan(aside), 0.0), plain)
    assert evidence is not None
    view = view_of(performer, pose, evidence, plain.every)
    sums = Sums()
    SurfaceTerm(evidence, plain).linearize(view, sums, 99)
    normal, _ = sums.assembled(view)
    half, seen = plain.window // 2, evidence.depth
    fx, fy, cx, cy = evidence.intrinsics
    near = seen, 1.0 / fx, 1.0 / fy, cx, cy, half, np.inf, evidence.apart, np.nan, seen, 0.0
    each = zip(view.pixels, view.samples.astype(float), strict=True)
    found = np.array([match.nearest(*pixel, *point, *near)[0] for pixel, point in each])
    ones = np.concatenate((view.samples.astype(float), np.ones((len(view.samples), 1))), axis=1)
    local = np.einsum("nij,nj->ni", np.linalg.inv(bone_frames(performer, pose))[view.bones], ones)
    jacobian = np.empty((len(local), 3, DOFS))
    for d in range(DOFS):
        ahead, back = (bone_frames(performer, advance(performer, pose, h * np.eye(DOFS)[d])) for h in (1e-6, -1e-6))
        jacobian[:, :, d] = np.einsum("nij,nj->ni", (ahead - back)[view.bones], local)[:, :3] / 2e-6
    hit = jacobian[found >= 0].reshape(-1, DOFS)
    return float(np.abs(normal - evidence.weight * hit.T @ hit).max() / np.abs(normal).max())


def _edges_off(picture: Rendering) -> tuple[float, float]:
    """Mean distance in px of Canny's edge points from the outline, and the share of them that is not on the body."""
    from scipy.ndimage import binary_erosion, distance_transform_edt

    body = np.isfinite(picture.depth)
    edges = edges_of(picture.depth, True)
    at = np.argwhere(np.isfinite(edges))
    pixels = KINECT.project(picture.points[at[:, 0], at[:, 1]])
    outline = np.asarray(body & ~binary_erosion(body))
    far = distance_transform_edt(~_with_inner(picture, outline))
    rows = np.clip(np.round(pixels[:, 1]).astype(int), 0, KINECT.height - 1)
    columns = np.clip(np.round(pixels[:, 0]).astype(int), 0, KINECT.width - 1)
    off = np.abs(edges[at[:, 0], at[:, 1]] - picture.depth[rows, columns])
    return float(far[rows, columns].mean()), float(np.mean(~(off < 0.02)))


def _with_inner(picture: Rendering, outline: Bools) -> Bools:
    """The outline and the near sides of steps of 6 cm within the body."""
    depth = np.where(np.isfinite(picture.depth), picture.depth, 9.0)
    marked = outline.copy()
    for axis in (0, 1):
        for way in (1, -1):
            marked |= np.roll(depth, way, axis) - depth > 0.06
    return np.asarray(marked & np.isfinite(picture.depth))


def _person_found(scene: Stage, drawn: list[Rendering]) -> tuple[float, float]:
    """Shares of the person's pixels that are kept, and of those kept that are not the person's."""
    up = np.asarray(scene.motion.skeleton.up, dtype=np.float64)
    joints = (scene.joints.reshape(-1, 3) - scene.seen.shift) @ scene.seen.turn
    planes = room(scene.seen, float((joints @ up).min()) - 0.09, up, back=2.5, aside=2.5)
    kept, false = [], []
    for t, picture in enumerate(drawn):
        depth = sensed(behind(picture.depth, KINECT, planes), KINECT, 0, t)
        frame = DepthFrame(KINECT, depth, None, float(t))
        found = np.isfinite(find_person(scene_of(frame), frame).depth)
        body, measured = np.isfinite(picture.depth), np.isfinite(depth)
        # A pixel at the outline samples up to two pixels beside itself: whose it is its depth tells.
        nearest = minimum_filter(np.where(body, picture.depth, np.inf), 5) - SLACK
        farthest = maximum_filter(np.where(body, picture.depth, -np.inf), 5) + SLACK
        with np.errstate(invalid="ignore"):
            theirs = measured & (depth > nearest) & (depth < farthest)
        kept.append((found & theirs & body).sum() / (theirs & body).sum())
        false.append((found & ~theirs & (measured | ~body)).sum() / max(found.sum(), 1))
    return float(np.mean(kept)), float(np.mean(false))


def _prior(mocap: Path, poses: Poses) -> dict[str, float]:
    """The local model in a pose: its samples, its dimensions, its share of energy, and its own derivative."""
    paper, database = settings_of("paper"), library(mocap).database
    pose = poses[len(poses) // 2]
    index, _ = database.search.nearest(pose.joints, paper.neighbors, None)
    samples = database.joints[database.following(index, paper.following).ravel()]
    model = local_pca(samples, paper.energy)
    spread = np.linalg.eigvalsh(np.cov(samples.T.astype(float)))[::-1]
    kept = round(DOFS - 6 - np.trace(model.rest()))
    term = prior_term(database, pose, paper)
    assert term is not None
    slope = np.empty(DOFS)
    for d in range(DOFS):
        moved = [advance(average(), pose, h * np.eye(DOFS)[d]) for h in (1e-5, -1e-5)]
        slope[d] = (term.cost(moved[0]) - term.cost(moved[1])) / 2e-5
    expected = np.zeros(DOFS)
    expected[6:] = 2.0 * term.form @ (pose.joints - term.mean)
    return {
        "prior_samples": float(len(samples)),
        "prior_dimensions": float(kept),
        "prior_energy": float(spread[:kept].sum() / spread.sum()),
        "prior_slope_off": float(np.abs(slope - expected).max() / np.abs(expected).max()),
        "prior_root": float(np.abs(slope[DOF_BONES == 0]).max()),
    }
