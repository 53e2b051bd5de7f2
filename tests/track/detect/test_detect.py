"""The part forest is scikit-learn's, the detector finds the joints of people it has not seen, and says how surely."""

import numpy as np
import pytest

from drawn_people import CAMERA, PERSON, picture, random_poses, turned
from motionmend.bodies.camera import KINECT, Camera, DepthFrame
from motionmend.bodies.performer import LANDMARKS, OTHER_SIDE, Pose, landmarks, rotation
from motionmend.errors import MismatchError
from motionmend.io.model import load_model, save_model
from motionmend.track.detect import part_forest
from motionmend.track.detect.joints import Detector, detect, detected_lying, fit_detector
from motionmend.track.detect.pictures import pictures

LEGS = [j for j, name in enumerate(LANDMARKS) if name.endswith(("hip", "knee", "ankle"))]
TRUNK = [LANDMARKS.index(name) for name in ("pelvis", "chest", "neck", "head", "l_shoulder", "r_shoulder")]


@pytest.fixture(scope="module")
def detector():
    return fit_detector(random_poses(300, 1), [PERSON], seed=0, count=240, trees=2)


def test_probabilities_are_those_of_scikit_learn():
    rng = np.random.default_rng(4)
    probes = rng.uniform(-0.5, 0.5, (30, 4)).astype(np.float32)
    every = list(pictures(random_poses(30, 2), [PERSON], 20, 3))
    focal = (KINECT.fx, KINECT.fy)
    features = [part_forest.differences(p.depth, p.pixels, focal, probes) for p in every]
    parts = np.concatenate([p.parts for p in every])
    trees = [part_forest.grown(np.concatenate(features), parts, 8, 5, 10, seed) for seed in (0, 1)]
    forest = part_forest.planted(trees, [probes, probes], 16)
    for one, own in zip(every[:5], features[:5], strict=True):
        reached = part_forest.leaves(forest, one.depth, one.pixels, focal)
        for r, tree in enumerate(trees):
            wanted = np.zeros((len(own), 16))
            wanted[:, tree.classes_] = tree.predict_proba(own)
            np.testing.assert_allclose(forest.parts[reached[:, r]], wanted, atol=1e-6)


def test_pictures_are_the_same_for_the_same_seed_and_show_their_joints():
    poses = random_poses(10, 5)
    for one, other in zip(pictures(poses, [PERSON], 6, 7), pictures(poses, [PERSON], 6, 7), strict=True):
        np.testing.assert_array_equal(one.depth, other.depth)
        np.testing.assert_array_equal(one.parts, other.parts)
        z = one.depth[one.pixels[:, 0], one.pixels[:, 1]].astype(float)
        gap = np.linalg.norm(KINECT.unproject(one.pixels[:, ::-1], z) - one.joints[one.parts], axis=1)
        assert np.median(gap) < 0.2
        assert gap.max() < 0.6


def test_the_trunk_of_an_unseen_pose_is_found_and_confidences_mean_something(detector):
    errors, sure = [], []
    for pose in random_poses(30, 99):
        found = detect(detector, picture(pose, rng=np.random.default_rng(0)))
        errors.append(np.linalg.norm(found.joints - landmarks(PERSON, pose), axis=1))
        sure.append(found.confidence)
    errors, sure = np.array(errors), np.array(sure)
    assert np.median(errors[:, TRUNK]) < 0.06
    assert np.all((sure >= 0) & (sure <= 1))
    close = errors < 0.10
    assert close[sure > 0.8].mean() > 0.75
    assert close[sure > 0.8].mean() > close[sure < 0.5].mean() + 0.15


def test_who_is_cut_off_is_read_by_a_forest_of_their_own(detector):
    arrays = {name: values for name, values in detector.arrays().items() if not name.startswith("cut_off.")}
    before = Detector.from_arrays(arrays)  # as a model that was fitted without one
    errors: dict[str, list] = {"own": [], "whole": []}
    below: dict[str, list] = {"own": [], "whole": []}
    for pose in random_poses(20, 77):
        near = Pose(pose.translation + np.array([0.0, 0.45, -1.8]), pose.root, pose.joints)  # the pelvis 5 cm too low
        for name, one in (("own", detector), ("whole", before)):
            found = detect(one, picture(near, rng=np.random.default_rng(0)))
            errors[name].append(np.linalg.norm(found.joints - landmarks(PERSON, near), axis=1)[TRUNK[1:]])
            below[name].append(found.confidence[LEGS])
        for one in (pose, turned(pose, 0.7)):  # whole ones are read as they were, but for what a file rounds
            frames = picture(one, rng=np.random.default_rng(0))
            found, known = detect(detector, frames), detect(before, frames)
            np.testing.assert_allclose(found.joints, known.joints, atol=0.02)
    assert np.nanmedian(errors["own"]) < 0.7 * np.nanmedian(errors["whole"])
    assert np.mean(below["own"]) < 0.5 * np.mean(below["whole"])  # hips and feet are not in the image


@pytest.mark.parametrize("quarter", [-np.pi / 2, np.pi / 2])
def test_who_lies_is_found_as_who_stands(detector, quarter):
    errors, upright = [], []
    for pose in random_poses(12, 98):
        laid = Pose(pose.translation, rotation(np.array([0.0, 0.0, quarter])) @ pose.root, pose.joints)
        left, right = detected_lying(detector, picture(laid, rng=np.random.default_rng(0)))
        found = left if left.confidence.sum() > right.confidence.sum() else right
        errors.append(np.linalg.norm(found.joints - landmarks(PERSON, laid), axis=1)[TRUNK])
        stood = picture(pose, rng=np.random.default_rng(0))
        upright.append(np.linalg.norm(detect(detector, stood).joints - landmarks(PERSON, pose), axis=1)[TRUNK])
        assert not detected_lying(detector, stood)
    assert np.median(errors) < 1.2 * np.median(upright)
    assert np.quantile(errors, 0.9) < 1.2 * np.quantile(upright, 0.9)


def test_from_behind_the_other_reading_is_the_right_one(detector):
    better = []
    for pose in random_poses(16, 98):
        back = turned(pose, np.pi)
        found = detect(detector, picture(back, rng=np.random.default_rng(0)))
        truth = landmarks(PERSON, back)
        errors = [np.nanmedian(np.linalg.norm(d.joints - truth, axis=1)) for d in (found, found.mirrored)]
        better.append(errors[1] < errors[0])
        np.testing.assert_array_equal(found.mirrored.mirrored.joints, found.joints)
    assert np.mean(better) > 0.8
    np.testing.assert_array_equal(OTHER_SIDE[OTHER_SIDE], np.arange(16))


def test_another_camera_sees_the_same_joints(detector):
    wide = Camera(512, 424, 365.0, 365.0, 256.0, 212.0)
    for pose in random_poses(4, 12):
        one, other = detect(detector, picture(pose)), detect(detector, picture(pose, wide))
        gap = np.linalg.norm(one.joints - other.joints, axis=1)[TRUNK]
        assert np.median(gap) < 0.05


def test_nobody_has_no_joints(detector):
    found = detect(detector, DepthFrame(CAMERA, np.full((240, 320), np.nan, np.float32)))
    assert np.isnan(found.joints).all()
    assert not found.confidence.any()


@pytest.mark.slow
def test_a_detector_fits_again_and_is_stored_in_little(detector, tmp_path):
    again = fit_detector(random_poses(300, 1), [PERSON], seed=0, count=240, trees=2)
    for name, values in detector.arrays().items():
        np.testing.assert_array_equal(values, again.arrays()[name])
    path = tmp_path / "d.mend"
    save_model(path, "tracker", detector.arrays(), {})
    assert path.stat().st_size < 10e6
    stored = Detector.from_arrays(load_model(path).arrays)
    frame = picture(random_poses(1, 50)[0])
    one, other = detect(detector, frame), detect(stored, frame)
    np.testing.assert_allclose(one.joints, other.joints, atol=0.02)


def test_arrays_that_form_no_trees_are_refused(detector):
    arrays = detector.arrays()
    with pytest.raises(MismatchError, match="fit"):
        Detector.from_arrays({k: v for k, v in arrays.items() if k != "mass"})
    circular = np.array(arrays["forest.children"])
    circular[5] = (0, 1)  # a walk that never ends
    with pytest.raises(MismatchError, match="trees"):
        Detector.from_arrays(arrays | {"forest.children": circular})
    with pytest.raises(MismatchError, match="must be"):
        Detector.from_arrays(arrays | {"forest.parts": arrays["forest.parts"][:, :3]})
