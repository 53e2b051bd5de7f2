"""The tracker's laws: derivatives, where optima lie, what has no influence, what is said when nobody is there."""

from dataclasses import replace

import numpy as np
import pytest

from drawn_people import PERSON, in_room, picture
from motionmend.bodies import anatomy
from motionmend.bodies.camera import KINECT, DepthFrame
from motionmend.bodies.performer import DOFS, LANDMARKS, Pose, advance, bone_frames, landmarks, standing
from motionmend.bodies.surface import render
from motionmend.errors import UsageError
from motionmend.kernels import match
from motionmend.track.database import PoseDatabase
from motionmend.track.frame.evidence import evidence_of
from motionmend.track.frame.observation import Observation
from motionmend.track.limbs.certainty import certainty_of, shown_and_denied, trust_of
from motionmend.track.limbs.other_poses import LIMBS, coarse_of, with_limb
from motionmend.track.measure.girth import AXES_OF
from motionmend.track.model import TrackerModel
from motionmend.track.settings import settings_of
from motionmend.track.terms.edge import EdgeTerm
from motionmend.track.terms.freespace import FreespaceTerm
from motionmend.track.terms.limits import LimitsTerm
from motionmend.track.terms.objective import terms_of
from motionmend.track.terms.prior import PriorTerm, prior_term
from motionmend.track.terms.smooth import SmoothTerm, difference, eased
from motionmend.track.terms.solve import solve_pose
from motionmend.track.terms.surface import SurfaceTerm
from motionmend.track.terms.view import Sums, view_of
from motionmend.track.tracker import start, step

BODY = anatomy.average()


def some_pose(seed=0, much=0.2):
    """Somebody standing not quite upright with arms and legs somewhere, 2.7 m away."""
    rng = np.random.default_rng(seed)
    delta = np.concatenate((np.zeros(3), rng.normal(0, 0.1, 3), rng.normal(0, much, DOFS - 6)))
    arms = standing((0.0, 0.05, 2.7)).joints.copy()
    return advance(BODY, Pose((0.0, 0.05, 2.7), standing().root, 0.5 * arms), delta)


def seen(pose, body=BODY, unknown=None):
    """What a perfect camera observes of a pose; nobody elsewhere, but for pixels nothing is known of."""
    depth = render(body, pose, KINECT).depth.copy()
    free = np.isnan(depth)
    if unknown is not None:
        depth[unknown], free[unknown] = np.nan, False
    return Observation(KINECT, depth, free, 0.0)


def library(seed=1, count=60):
    """Poses about the one of `some_pose`, as one clip."""
    rng = np.random.default_rng(seed)
    joints = some_pose().joints + rng.normal(0, 0.2, (count, DOFS - 6)) * np.linspace(1, 0.1, DOFS - 6)
    return PoseDatabase(joints, np.full(count, count - 1))


def off(pose, other):
    """Distances of the 16 joints, m."""
    return np.linalg.norm(landmarks(BODY, pose) - landmarks(BODY, other), axis=1)


@pytest.mark.parametrize("along", [0.0, 1.0])
def test_the_surface_term_is_linear_in_the_finite_differences_of_its_points(along):
    plain = replace(
        settings_of("default"), along_normal=along, scale=np.inf, gate=np.inf, two_way=False, every=4, window=5
    )
    pose = some_pose()
    evidence = evidence_of(seen(advance(BODY, pose, np.full(DOFS, 0.01))), plain)
    view = view_of(BODY, pose, evidence, plain.every)
    sums = Sums()
    SurfaceTerm(evidence, plain).linearize(view, sums, 99)
    normal, right = sums.assembled(view)
    # The same sums from a Jacobian made of finite differences of points fixed to bones.
    fx, fy, cx, cy = evidence.intrinsics
    near = evidence.depth, 1.0 / fx, 1.0 / fy, cx, cy, 2, np.inf, evidence.apart, np.nan, evidence.depth, 0.0
    each = zip(view.pixels, view.samples.astype(float), strict=True)
    places = np.array([match.nearest(*pixel, *point, *near) for pixel, point in each])
    found = np.where(places[:, 0] < 0, -1, places[:, 0] * evidence.depth.shape[1] + places[:, 1])
    frames = bone_frames(BODY, pose)
    ones = np.concatenate((view.samples.astype(float), np.ones((len(view.samples), 1))), axis=1)
    local = np.einsum("nij,nj->ni", np.linalg.inv(frames)[view.bones], ones)
    jacobian = np.empty((len(local), 3, DOFS))
    for d in range(DOFS):
        ahead, behind = (bone_frames(BODY, advance(BODY, pose, h * np.eye(DOFS)[d])) for h in (1e-6, -1e-6))
        jacobian[:, :, d] = np.einsum("nij,nj->ni", (ahead - behind)[view.bones], local)[:, :3] / 2e-6
    hit = found >= 0
    residual = evidence.camera.points(evidence.depth).reshape(-1, 3)[found] - view.samples
    if along == 1.0:
        jacobian = np.einsum("ni,nid->nd", view.normals.astype(float), jacobian)[:, None]
        residual = np.einsum("ni,ni->n", view.normals, residual)[:, None]
    jacobian, residual = jacobian[hit].reshape(-1, DOFS), residual[hit].reshape(-1).astype(float)
    tolerance = 1e-3 * np.abs(normal).max()
    np.testing.assert_allclose(normal, evidence.weight * jacobian.T @ jacobian, atol=tolerance)
    np.testing.assert_allclose(right, evidence.weight * jacobian.T @ residual, atol=1e-3 * np.abs(right).max())


def test_smoothness_limits_and_prior_are_the_derivatives_of_their_costs(rng):
    pose = advance(BODY, some_pose(), np.full(DOFS, 0.3))
    root = rng.normal(size=(DOFS - 6, DOFS - 6))
    terms = (
        SmoothTerm(some_pose(), rng.uniform(0.1, 1.0, DOFS)),
        LimitsTerm(np.zeros(2), 3.0),
        PriorTerm(rng.normal(size=DOFS - 6), root @ root.T),
    )
    evidence = evidence_of(seen(pose), settings_of("default"))
    stiff = replace(BODY, limits=np.tile((-0.2, 0.2), (DOFS, 1)))
    for term in terms:
        sums = Sums()
        share = term.linearize(view_of(stiff, pose, evidence, 4), sums, 0)
        assert share.cost == pytest.approx(term.residual(view_of(stiff, pose, evidence, 4)))
        slope = np.empty(DOFS)
        for d in range(DOFS):
            moved = [advance(BODY, pose, h * np.eye(DOFS)[d]) for h in (1e-5, -1e-5)]
            ahead, behind = (term.residual(view_of(stiff, one, evidence, 4)) for one in moved)
            slope[d] = (ahead - behind) / 2e-5
        # A large turn of the root adds as vectors only to first order.
        rows = np.r_[0:3, 6:DOFS]
        np.testing.assert_allclose(-2.0 * sums.right[rows], slope[rows], rtol=1e-4, atol=1e-6)


def test_an_arm_behind_the_back_does_not_stay_inside_it():
    """In there it contradicts no image, and the trunk's pixels draw at it."""
    model, arm, elbow = TrackerModel(PoseDatabase(np.empty((0, DOFS - 6)), np.empty(0))), LIMBS[0], 5
    upright = standing((0.0, 0.05, 2.7))
    behind = with_limb(upright, arm, upright.joints[arm.columns] + (0.0, 0.0, 0.86, 0.43, -0.35, 0.29))
    inside = with_limb(behind, arm, behind.joints[arm.columns] + (0.0, 0.0, -0.22, 0.24, -0.08, 0.05))
    assert not np.isin(render(BODY, behind, KINECT).bones, arm.shown[-1]).any()
    unseen = np.where(np.isin(np.arange(DOFS - 6), arm.columns), 0.0, 1.0)
    misses = []
    for names in (("surface", "edge", "freespace", "limits"), ("surface", "edge", "freespace")):
        settings = settings_of("default", names)
        evidence = evidence_of(seen(behind), settings)
        state = start(model, settings, DepthFrame(KINECT, seen(behind).depth, None, 0.0), BODY, inside)
        pose = inside
        for _ in range(3):
            terms = terms_of(model, settings, replace(state, pose=pose, trust=unseen), evidence, pose)
            pose = solve_pose(BODY, evidence, terms, pose, settings).state
        misses.append(off(pose, behind)[elbow : elbow + 2].max())
    begun = off(inside, behind)[elbow : elbow + 2].max()
    assert misses[0] < 0.4 * begun
    assert misses[1] > 0.8 * begun


def test_smoothness_gives_way_with_the_time_between_frames():
    assert eased(0.1, 0.0) == eased(0.1, 1.0 / 60.0) == eased(0.1, 1.0 / 30.0 + 1e-3) == 0.1
    assert eased(0.1, 0.09) == pytest.approx(0.25 * eased(0.1, 0.045))
    assert eased(0.1, 0.3) == eased(0.1, 0.1)


def test_after_a_gap_of_time_stamps_a_limb_may_have_gone_farther():
    settings = replace(settings_of("default", ("surface", "freespace")), search=False, smooth=10.0)
    pose, arm = some_pose(much=0.05), LIMBS[0]
    moved = with_limb(pose, arm, pose.joints[arm.columns] + 0.15)
    model = TrackerModel(library())
    missed = []
    for elapsed in (1.0 / 30.0, 0.2):
        state = start(model, settings, DepthFrame(KINECT, seen(pose).depth, None, 0.0), BODY, pose)
        for time, one in ((0.0, pose), (elapsed, moved)):
            state, estimate = step(model, settings, state, DepthFrame(KINECT, seen(one).depth, None, time))
        missed.append(np.linalg.norm(estimate.landmarks - landmarks(BODY, moved), axis=1).max())
    assert missed[1] < 0.5 * missed[0]


def test_differences_of_poses_undo_increments(rng):
    delta = rng.normal(0, 0.4, DOFS)
    pose = some_pose()
    np.testing.assert_allclose(difference(advance(BODY, pose, delta), pose), delta, atol=1e-9)


@pytest.mark.parametrize("names", [None, ("surface",), ("surface", "prior", "edge")])
def test_all_steps_at_once_are_the_steps_one_by_one(monkeypatch, names):
    settings = settings_of("default", names)
    pose = some_pose()
    begun = advance(BODY, pose, 0.05 * np.random.default_rng(3).normal(size=DOFS))
    evidence = evidence_of(seen(pose), settings)
    model = TrackerModel(library())
    state = start(model, settings, DepthFrame(KINECT, seen(pose).depth, None, 0.0), BODY, pose)
    terms = terms_of(model, settings, state, evidence, begun)
    at_once = solve_pose(BODY, evidence, terms, begun, settings, 3)
    monkeypatch.setattr("motionmend.track.terms.solve._at_once", lambda *_: None)
    singly = solve_pose(BODY, evidence, terms, begun, settings, 3)
    assert (at_once.iterations, at_once.converged) == (singly.iterations, singly.converged)
    assert off(at_once.state, singly.state).max() < 1e-6
    np.testing.assert_allclose(at_once.system.normal, singly.system.normal, rtol=1e-6, atol=1e-6)
    assert at_once.system.costs == pytest.approx(singly.system.costs, rel=1e-6)
    assert at_once.system.inliers == singly.system.inliers
    assert at_once.system.samples == singly.system.samples


def test_evidence_of_the_whole_width_can_be_written_to_as_any_other():
    """Kernels are compiled anew for read-only images, in the frame in which somebody comes near."""
    settings = settings_of("default", ("surface", "edge", "color"))
    shapes = []
    for distance in (0.9, 3.5):
        pose = standing((0.0, 0.2, distance))
        tones = np.full((KINECT.height, KINECT.width), 90.0, np.float32)
        evidence = evidence_of(replace(seen(pose), intensity=tones), settings)
        shapes.append(evidence.depth.shape)
        for image in (evidence.depth, evidence.free, evidence.tones):
            assert image.shape == shapes[-1]
            assert image.flags.writeable
            assert image.flags.c_contiguous
    whole = KINECT.every(settings.raster).width
    assert shapes[0][1] == whole
    assert shapes[1][1] < 0.8 * whole


def test_weights_are_evened_but_in_the_dissertation():
    for preset in ("default", "paper"):
        own = replace(settings_of(preset, ("surface", "edge")), raster=2)
        for settings in (own, replace(own, preset="a name of its own")):
            near, far = (evidence_of(seen(standing((0.0, 0.05, z))), settings) for z in (2.0, 4.0))
            assert len(near.pixels) > 2 * len(far.pixels)
            ratios = far.weight / near.weight, EdgeTerm(far, settings).weight / EdgeTerm(near, settings).weight
            if preset == "paper":
                assert ratios == (1.0, 1.0)
            else:
                assert min(ratios) > 1.3


def test_a_body_rendered_from_its_own_pose_stays_put():
    model, settings = TrackerModel(PoseDatabase(np.empty((0, DOFS - 6)), np.empty(0))), settings_of("default")
    pose = some_pose()
    depth = render(BODY, pose, KINECT).depth
    state = start(model, settings, DepthFrame(KINECT, depth, None, 0.0), BODY, pose)
    for t in range(6):
        state, estimate = step(model, settings, state, DepthFrame(KINECT, depth, None, t / 30))
    assert off(estimate.pose, pose).max() < 0.01
    assert estimate.flags[0] == "tracked"
    assert estimate.wrong < 0.1
    np.testing.assert_allclose(np.exp(state.girth.scale), 1.0, atol=0.04)


def test_the_optimum_does_not_move_with_a_start_less_than_five_degrees_away(rng):
    pose = some_pose(2)
    settings = settings_of("default", ("surface", "edge", "limits", "freespace"))
    evidence = evidence_of(seen(pose), settings)
    ends = []
    for _ in range(4):
        delta = rng.normal(size=DOFS)
        delta[:3] = rng.uniform(-0.02, 0.02, 3)
        delta[3:] *= np.radians(5.0) / np.abs(delta[3:]).max()
        begin = advance(BODY, pose, delta)
        terms = [SurfaceTerm(evidence, settings), FreespaceTerm(evidence, settings)]
        terms.append(SmoothTerm(begin, np.full(DOFS, 1e-4)))
        ends.append(solve_pose(BODY, evidence, terms, begin, settings, 30).state)
    for end in ends:
        assert off(end, pose).mean() < 0.006
        assert off(end, ends[0]).mean() < 0.008


def test_pixels_marked_missing_have_no_influence():
    settings = settings_of("default")
    pose = some_pose()
    aside = np.zeros((240, 320), bool)
    aside[:, 200:] = True  # nothing of the person; but the model will reach there
    model = advance(BODY, pose, np.concatenate(((0.45, 0.0, 0.0), np.zeros(DOFS - 3))))
    costs = []
    for unknown in (aside & np.isnan(render(BODY, pose, KINECT).depth), None):
        evidence = evidence_of(seen(pose, unknown=unknown), settings)
        view, sums = view_of(BODY, model, evidence, 2), Sums()
        costs.append(FreespaceTerm(evidence, settings).linearize(view, sums, 0).samples)
        if unknown is not None:
            out = view.pixels[:, 1] * 2 + (KINECT.cx - evidence.camera.cx * 2) > 206
            assert out.sum() > 10
            assert not evidence.free[tuple(view.pixels[out].T)].any()
    assert costs[0] < costs[1]


def test_an_arm_put_elsewhere_is_found_again():
    database = library()
    pose = some_pose()
    raised = with_limb(pose, LIMBS[0], pose.joints[LIMBS[0].columns] + np.array([0, 0, 0.2, 0.9, 0.9, 0.8]))
    joints = np.concatenate((database.joints, [raised.joints] * 3))
    model = TrackerModel(PoseDatabase(joints, np.full(len(joints), len(joints) - 1)))
    settings = settings_of("default")
    depth = render(BODY, raised, KINECT).depth
    wrist = LANDMARKS.index("l_wrist")
    assert off(raised, pose)[wrist] > 0.2
    state = start(model, settings, DepthFrame(KINECT, depth, None, 0.0), BODY, pose)
    for t in range(5):
        state, estimate = step(model, settings, state, DepthFrame(KINECT, depth, None, t / 30))
    assert off(estimate.pose, raised)[wrist] < 0.04


def test_an_empty_frame_is_said_to_be_empty_and_the_person_is_taken_up_again():
    settings, pose = settings_of("default"), some_pose()
    model = TrackerModel(library())
    depth = render(BODY, pose, KINECT).depth
    nothing = np.full(depth.shape, np.nan, np.float32)
    state = start(model, settings, DepthFrame(KINECT, depth, None, 0.0), BODY, pose)
    state, _ = step(model, settings, state, DepthFrame(KINECT, depth, None, 0.0))
    spreads = []
    for t in (1, 2, 3):
        state, estimate = step(model, settings, state, DepthFrame(KINECT, nothing, None, t / 30))
        assert estimate.flags == ("empty",)
        spreads.append(estimate.std.min())
    assert spreads[0] >= 0.10
    assert spreads == sorted(spreads)
    assert spreads[2] > spreads[0]
    state, estimate = step(model, settings, state, DepthFrame(KINECT, depth, None, 0.2))
    assert "recovered" in estimate.flags
    assert off(estimate.pose, pose).mean() < 0.02


def test_a_clock_that_is_put_back_counts_as_no_time():
    settings, pose, model = settings_of("default"), some_pose(), TrackerModel(library())
    frame = DepthFrame(KINECT, render(BODY, pose, KINECT).depth, None, 100.0)
    state, _ = step(model, settings, start(model, settings, frame, BODY, pose), frame)
    for depth in (frame.depth, np.full_like(frame.depth, np.nan)):
        then, now = (step(model, settings, state, DepthFrame(KINECT, depth, None, time))[1] for time in (0.0, 100.0))
        np.testing.assert_array_equal(then.std, now.std)


@pytest.mark.slow
def test_what_no_pose_explains_does_not_become_usual():
    """A ball instead of the person, for three seconds: what is told of it is `lost`, and what is usual stays."""
    settings, pose = settings_of("default"), some_pose()
    model = TrackerModel(library())
    depth = render(BODY, pose, KINECT).depth
    state = start(model, settings, DepthFrame(KINECT, depth, None, 0.0), BODY, pose)
    state, _ = step(model, settings, state, DepthFrame(KINECT, depth, None, 0.0))
    usual = state.wrong
    rows, columns = np.mgrid[: KINECT.height, : KINECT.width]
    wide = 1.0 - ((columns - KINECT.cx) ** 2 + (rows - KINECT.cy) ** 2) / 80.0**2
    ball = np.where(wide > 0.0, 2.7 - 0.7 * np.sqrt(np.maximum(wide, 0.0)), np.nan).astype(np.float32)
    for t in range(1, 31):
        state, estimate = step(model, settings, state, DepthFrame(KINECT, ball, None, t / 10))
    assert "lost" in estimate.flags
    assert state.wrong == usual


def test_a_limb_out_of_sight_is_held_and_less_and_less_sure():
    settings, model = settings_of("default"), TrackerModel(library())
    pose = some_pose()
    wrist = LANDMARKS.index("r_wrist")
    depth = render(BODY, pose, KINECT)
    unknown = np.isin(depth.bones, [7, 8])  # something before the arm: neither the person nor free
    state = start(model, settings, DepthFrame(KINECT, depth.depth, None, 0.0), BODY, pose)
    observation = seen(pose, unknown=unknown)
    evidence = evidence_of(observation, settings)
    terms = terms_of(model, settings, state, evidence, pose)
    solution = solve_pose(BODY, evidence, terms, pose, settings)
    share, *_ = shown_and_denied(BODY, solution.state, coarse_of(evidence), evidence.weight)
    _, visible = trust_of(share)
    assert not visible[wrist]
    assert visible[LANDMARKS.index("l_wrist")]
    hidden = [np.where(visible, 0.0, since) for since in (0.0, 0.2, 1.0)]
    std = [certainty_of(BODY, solution, h, np.zeros(16), 0.1)[1] for h in hidden]
    assert std[0][wrist] < std[1][wrist] < std[2][wrist]
    assert std[0][wrist] > 1.5 * std[0][LANDMARKS.index("l_wrist")]


@pytest.mark.slow
@pytest.mark.parametrize("known", [1.0, 0.5])
@pytest.mark.parametrize("reach", [0.5, 1.0])
def test_fists_and_flat_hands_are_told_apart_whatever_is_known_before(reach, known):
    settings, model, pose = settings_of("default"), TrackerModel(library()), some_pose()
    who, body, state = anatomy.handed(BODY, reach), anatomy.handed(BODY, known), None
    for t in range(30):
        here = advance(BODY, pose, np.concatenate((np.zeros(6), 0.1 * np.sin(0.4 * t) * np.ones(28))))
        frame = DepthFrame(KINECT, render(who, here, KINECT).depth, None, t / 30)
        state = start(model, settings, frame, body, here) if state is None else state
        state, estimate = step(model, settings, state, frame)
    assert state.girth.hand == (None if reach == known else reach)  # as before until something else is seen
    other = anatomy.handed(state.performer, reach).solids
    np.testing.assert_allclose(state.performer.solids.center, other.center, atol=1e-12)
    wrists = [LANDMARKS.index(name) for name in ("l_wrist", "r_wrist")]
    assert off(estimate.pose, here)[wrists].max() < 0.03


def test_hands_out_of_view_stay_as_they_are():
    camera = replace(KINECT, height=120, cy=60.0)
    settings, model, pose, state = settings_of("default"), TrackerModel(library()), standing((0.0, 0.3, 2.0)), None
    for t in range(14):
        frame = DepthFrame(camera, render(anatomy.handed(BODY, 0.5), pose, camera).depth, None, t / 30)
        state = start(model, settings, frame, BODY, pose) if state is None else state
        state, _ = step(model, settings, state, frame)
    assert state.girth.frames >= 10
    assert state.girth.hand is None


def test_widths_are_learned_and_lengths_are_not():
    settings, model, pose = settings_of("default"), TrackerModel(library()), some_pose()
    factors = np.ones((15, 3))
    factors[[0, 1]] = (1.2, 1.0, 1.2)
    stout = replace(BODY, solids=BODY.solids.stretched(factors))
    rng = np.random.default_rng(0)
    state, here = None, pose
    for t in range(14):
        here = advance(BODY, pose, np.concatenate((np.zeros(6), 0.1 * np.sin(0.4 * t) * np.sign(rng.normal(size=28)))))
        frame = DepthFrame(KINECT, render(stout, here, KINECT).depth, None, t / 30)
        state = start(model, settings, frame, BODY, here) if state is None else state
        state, estimate = step(model, settings, state, frame)
    assert np.exp(state.girth.scale[0]) > 1.08
    assert len(AXES_OF) == len(state.girth.scale)
    np.testing.assert_array_equal(state.performer.offsets, BODY.offsets)
    assert off(estimate.pose, here).mean() < 0.03


def test_the_prior_of_the_dissertation_leaves_what_the_basis_explains():
    database = library()
    pose = some_pose()
    term = prior_term(database, pose, settings_of("paper"))
    rest = term.form / settings_of("paper").prior
    np.testing.assert_allclose(rest @ rest, rest, atol=1e-9)
    assert prior_term(PoseDatabase(np.empty((0, 28)), np.empty(0)), pose, settings_of("paper")) is None


def test_followers_end_with_their_clip():
    database = PoseDatabase(np.zeros((7, 28)), np.array([3, 3, 3, 3, 6, 6, 6]))
    np.testing.assert_array_equal(database.following(np.array([0, 3, 5]), 3), [[1, 2, 3], [3, 3, 3], [6, 6, 6]])


def test_models_come_back_from_arrays():
    model = TrackerModel(library())
    again = TrackerModel.from_arrays(*model.to_arrays())
    np.testing.assert_array_equal(again.database.joints, model.database.joints)
    np.testing.assert_array_equal(again.database.last, model.database.last)
    assert again.detector is None


def test_the_same_frames_give_the_same_numbers():
    settings, model, pose = settings_of("default"), TrackerModel(library()), some_pose()
    results = []
    for _ in range(2):
        frame = DepthFrame(KINECT, render(BODY, advance(BODY, pose, np.full(DOFS, 0.02)), KINECT).depth, None, 0.0)
        state = start(model, settings, frame, BODY, pose)
        results.append(step(model, settings, state, frame)[1].landmarks)
    np.testing.assert_array_equal(*results)


def test_bad_settings_are_refused():
    with pytest.raises(UsageError, match="terms of surface"):
        settings_of("default", ("surface", "smell"))
    with pytest.raises(UsageError, match="surface must be among the terms, came edge: "):
        settings_of("paper", ("edge",))
    with pytest.raises(UsageError, match="preset"):
        settings_of("best")
    frame = DepthFrame(KINECT, np.full((240, 320), np.nan, np.float32))
    with pytest.raises(UsageError, match="start pose"):
        start(TrackerModel(library()), settings_of(), frame, BODY)


def test_what_a_first_pose_explains_wrongly_is_not_usual(rng):
    pose = standing((0.0, 0.1, 3.0))
    model = TrackerModel(library())
    frame = in_room(picture(pose, rng=rng), rng=rng)
    for body, fits in ((PERSON, True), (anatomy.average(1.45), False)):
        state, estimate = step(model, settings_of(), start(model, settings_of(), frame, body, pose), frame)
        assert (estimate.wrong < 0.2) == fits
        assert state.wrong == (estimate.wrong if fits else 0.2)
