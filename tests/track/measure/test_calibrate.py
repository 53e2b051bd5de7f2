"""A body's lengths and widths from pictures of it whose poses are only roughly known."""

import numpy as np
import pytest

from drawn_people import HALF, PERSON, picture, random_poses
from motionmend.bodies.performer import BONES, Pose, advance, landmarks
from motionmend.errors import MismatchError
from motionmend.track.detect.joints import Detection
from motionmend.track.frame.observation import Observation
from motionmend.track.measure import calibrate as own
from motionmend.track.measure.calibrate import UNUSUAL, Trial, calibrate, calibrated, size_from, stretch_of, unusual

SHAPE = np.array([0.10, 0.04, -0.05, 0.03, 0.0, 0.06, -0.05, 0.05, -0.04, 0.0, 0.06, -0.05, 0.08, -0.08])
OTHER = PERSON.stretched(stretch_of(SHAPE))
MEASURED = [b for b, bone in enumerate(BONES) if not bone.endswith(("foot", "clavicle"))]


def _frames(person, poses, rng):
    frames = [picture(poses[k], HALF, person, rng) for k in range(len(poses))]
    return [Observation(HALF, f.depth, np.isnan(f.depth), 0.0) for f in frames]


def _spoilt(person, pose, rng, spread=0.04):
    return advance(person, pose, np.concatenate([rng.normal(0, 0.02, 3), rng.normal(0, spread, 31)]))


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_lengths_of_a_rendered_person_are_recovered(seed):
    rng = np.random.default_rng(seed)
    poses = random_poses(8, 40 + seed)
    frames = _frames(OTHER, poses, rng)
    done = calibrate(PERSON, frames, [_spoilt(PERSON, poses[k], rng) for k in range(8)])
    before = np.abs(PERSON.lengths / OTHER.lengths - 1)[MEASURED]
    after = np.abs(done.performer.lengths / OTHER.lengths - 1)[MEASURED]
    assert before.mean() > 0.07
    assert after.mean() < 0.045
    for bones in (("l_thigh", "l_shank"), ("l_upperarm", "l_forearm")):  # straight limbs hide where they bend
        own, true = (sum(p.lengths[BONES.index(b)] for b in bones) for p in (done.performer, OTHER))
        assert abs(own / true - 1) < 0.035
    for trunk in ("pelvis", "chest", "head"):
        assert abs(done.performer.lengths[BONES.index(trunk)] / OTHER.lengths[BONES.index(trunk)] - 1) < 0.035
    gaps = [landmarks(done.performer, done.poses[k]) - landmarks(OTHER, poses[k]) for k in range(8)]
    assert np.linalg.norm(gaps, axis=2).mean() < 0.025
    assert done.residual < 0.012


def test_a_body_that_fits_stays_as_it_is(rng):
    poses = random_poses(5, 9)
    done = calibrate(PERSON, _frames(PERSON, poses, None), [poses[k] for k in range(5)])
    np.testing.assert_allclose(done.performer.lengths, PERSON.lengths, rtol=0.03)
    assert done.residual < 0.006


def test_what_is_not_seen_stays_unsure(rng):
    """Of a person whose legs are out of the image, legs are told no better than for anybody of this size."""
    poses = random_poses(5, 11)
    near = [Pose(np.array([0.0, 0.75, 1.6]), poses[k].root, poses[k].joints) for k in range(5)]
    frames = [picture(pose, HALF, PERSON, rng) for pose in near]
    seen = [Observation(HALF, f.depth, np.isnan(f.depth), 0.0) for f in frames]
    done = calibrate(PERSON, seen, near)
    assert done.std["shank"] > 0.055
    assert min(done.std.values()) < 0.04


@pytest.mark.slow
def test_tracking_and_fitting_take_turns(rng):
    poses = random_poses(6, 15)
    frames = _frames(OTHER, poses, rng)
    bodies = []

    def follow(body):
        bodies.append(body)
        return Trial(frames, [_spoilt(body, poses[k], rng, 0.03) for k in range(6)], 0.1)

    done = calibrated([PERSON], follow, passes=2)
    assert done.measured
    assert len(bodies) == 3
    assert bodies[0] is PERSON
    assert bodies[-1] is done.performer
    assert np.abs(done.performer.lengths / OTHER.lengths - 1)[MEASURED].mean() < 0.045
    with pytest.raises(MismatchError, match="none"):
        calibrated([PERSON], lambda body: Trial([], [], 1.0))


@pytest.mark.slow
def test_a_body_that_explains_the_frames_worse_is_not_believed(rng):
    """Whatever was fitted; what the frames were explained by best to begin with is kept."""
    poses = random_poses(4, 15)
    frames = _frames(OTHER, poses, rng)
    small = PERSON.stretched(np.full((1, 3), 0.8))
    wrong = {id(small): 0.3, id(PERSON): 0.1}

    def follow(body):
        return Trial(frames, [poses[k] for k in range(4)], wrong.get(id(body), 0.15))

    done = calibrated([small, PERSON], follow)
    assert not done.measured
    assert done.performer is PERSON
    assert set(done.factors.values()) == {1.0}


@pytest.mark.parametrize(("badly", "tried"), [(0.25, 1), (0.45, 3)])
def test_other_sizes_are_tried_where_the_likeliest_explain_the_frames_badly(badly, tried, rng):
    poses = random_poses(4, 15)
    frames = _frames(PERSON, poses, rng)
    others = [PERSON.stretched(np.full((1, 3), size)) for size in (0.8, 0.63)]
    wrong = {id(PERSON): badly, id(others[0]): 0.35, id(others[1]): 0.22}
    bodies = []

    def follow(body):
        bodies.append(body)
        return Trial(frames, [poses[k] for k in range(4)], wrong.get(id(body), 0.5))

    done = calibrated([PERSON], follow, passes=0, others=others)
    assert bodies == [PERSON, *others][:tried]
    assert done.performer is min(bodies, key=lambda body: wrong[id(body)])


@pytest.mark.slow
def test_proportions_nobody_has_are_not_believed(rng):
    """Legs in a tub: what stands about them is fitted well, and is nobody's."""
    poses = random_poses(4, 15)
    wide = np.zeros(14)
    wide[-1] = np.log(2.2)
    frames = _frames(PERSON.stretched(stretch_of(wide)), poses, None)
    fitted = calibrate(PERSON, frames, [poses[k] for k in range(4)])
    assert unusual(fitted) > UNUSUAL
    done = calibrated([PERSON], lambda body: Trial(frames, [poses[k] for k in range(4)], 0.1))
    assert not done.measured
    child = PERSON.stretched(np.full((1, 3), 0.6))
    assert unusual(calibrate(PERSON, _frames(child, poses, None), [poses[k] for k in range(4)])) < UNUSUAL


@pytest.mark.parametrize("factor", [0.75, 1.0, 1.15])
def test_size_comes_from_detected_joints(factor, rng):
    person = PERSON.stretched(np.full((1, 3), factor))
    found = []
    for k in range(6):
        joints = landmarks(person, random_poses(6, 21)[k]) + rng.normal(0, 0.02, (16, 3))
        none = np.full((16, 3, 3), np.nan)
        found.append(Detection(joints, np.full(16, 0.9), none, np.zeros((16, 3)), 0.5))
    assert abs(size_from(PERSON, found) / factor - 1) < 0.06
    assert size_from(PERSON, []) == 1.0


def test_both_sides_are_alike_and_derivatives_are_those_of_finite_differences(rng):
    stretch = stretch_of(SHAPE)
    for b, bone in enumerate(BONES):
        if bone.startswith("l_"):
            np.testing.assert_array_equal(stretch[b], stretch[BONES.index("r_" + bone[2:])])
    pose = random_poses(1, 5)[0]
    seen = _frames(OTHER, random_poses(1, 5), rng)[0]
    value, by_pose, _, _ = own._residuals(PERSON, PERSON, np.zeros(len(SHAPE)), pose, seen)
    assert len(value) > 300
    assert by_pose.shape == (len(value), 34)
    # Along z every point moves as the body does: the derivative is the normal's z, at most 1.
    assert np.abs(by_pose[:, :3]).max() <= 1.0 + 1e-9
    np.testing.assert_allclose(np.linalg.norm(by_pose[:, :3], axis=1), 1.0, atol=1e-5)


def test_as_many_poses_as_frames_are_wanted():
    with pytest.raises(MismatchError, match="as many"):
        calibrate(PERSON, [], [])
