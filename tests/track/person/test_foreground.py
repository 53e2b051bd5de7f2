"""The person in depth images: alone, in rooms, walking over a background, and not there at all."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drawn_people import CAMERA, HALF, PERSON, in_room, picture, random_poses
from motionmend.bodies.camera import DepthFrame
from motionmend.bodies.performer import Pose, standing
from motionmend.errors import MismatchError
from motionmend.track.person.foreground import clean, empty_scene, find_person, remember, scene_of, told_again

SEEDS = st.integers(0, 10**6)


def _overlap(found, frame):
    one, other = np.isfinite(found.depth), np.isfinite(frame.depth)
    return (one & other).sum() / (one | other).sum()


@pytest.mark.slow
@given(SEEDS)
@settings(max_examples=8)
def test_a_person_alone_is_kept_whole(seed):
    frame = picture(random_poses(1, seed)[0])
    found = find_person(scene_of(frame), frame)
    assert found.found
    assert _overlap(found, frame) > 0.97
    both = np.isfinite(found.depth) & np.isfinite(frame.depth)
    assert np.mean(np.abs(found.depth - frame.depth)[both] < 0.02) > 0.9
    assert not (found.free & np.isfinite(found.depth)).any()


@pytest.mark.slow
@given(SEEDS, st.floats(3.8, 6.0))
@settings(max_examples=8)
def test_far_background_does_not_change_the_person(seed, wall):
    rng = np.random.default_rng(seed)
    alone = picture(random_poses(1, seed)[0], HALF)
    whole = in_room(alone, floor=np.inf, wall=wall, rng=rng)
    found = find_person(scene_of(whole), whole)
    assert found.found
    assert _overlap(found, find_person(scene_of(alone), alone)) > 0.97


@pytest.mark.slow
@given(SEEDS, st.floats(3.8, 5.0), st.floats(0.95, 1.3))
@settings(max_examples=8)
def test_floor_and_wall_are_taken_away(seed, wall, floor):
    rng = np.random.default_rng(seed)
    alone = picture(random_poses(1, seed)[0], HALF)
    whole = in_room(alone, floor, wall, rng)
    scene = scene_of(whole)
    assert len(scene.planes) == 2
    heights = np.sort(scene.planes[:, 3])
    np.testing.assert_allclose(heights, [floor, wall], rtol=0.03)
    seen = DepthFrame(HALF, np.where(whole.depth < alone.depth, np.float32(np.nan), alone.depth))
    assert _overlap(find_person(scene, whole), seen) > 0.90


@pytest.mark.slow
@given(SEEDS, st.floats(0.25, 0.35))
@settings(max_examples=8)
def test_who_stands_right_before_a_wall_is_told_from_the_strip_of_floor_before_it(seed, gap):
    """Seen from its own height the floor has little area that faces the camera."""
    rng = np.random.default_rng(seed)
    alone = picture(standing((rng.uniform(-0.4, 0.4), -0.05, 2.7)))
    lowest = float(np.nanmax(alone.camera.points(alone.depth)[..., 1])) + 0.01
    whole = in_room(alone, floor=lowest, wall=float(np.nanmax(alone.depth)) + gap, rng=rng)
    scene = scene_of(whole)
    np.testing.assert_allclose(np.sort(scene.planes[:, 3])[:1], [lowest], rtol=0.03)
    assert _overlap(find_person(scene, whole), alone) > 0.90
    nothing = told_again(scene, DepthFrame(whole.camera, whole.depth, None, 0.1))
    np.testing.assert_array_equal(nothing.planes, scene.planes)


def test_the_floor_between_the_feet_is_nobodys(rng):
    pose = standing((0.0, 0.0, 2.8))
    alone = picture(pose)
    lowest = alone.camera.points(alone.depth)[..., 1]
    whole = in_room(alone, floor=float(np.nanmax(lowest)) + 0.02, wall=4.5, rng=rng)
    scene = scene_of(whole)
    for _ in range(3):  # the floor is learned as background, too
        person = find_person(scene, whole)
        scene = remember(scene, whole, person)
    found = np.isfinite(find_person(scene, whole).depth)
    assert (found & np.isnan(alone.depth)).sum() < 0.01 * found.sum()
    assert (found & np.isfinite(alone.depth)).sum() > 0.93 * np.isfinite(alone.depth).sum()


def test_where_a_sensor_loses_an_outline_the_person_ends(rng):
    import cv2

    alone = picture(standing((0.0, 0.0, 2.8)))
    whole = in_room(alone, floor=2.0, wall=4.5, rng=rng)
    on = np.isfinite(alone.depth).astype(np.uint8)
    ring = cv2.dilate(on, np.ones((3, 3), np.uint8)) - cv2.erode(on, np.ones((3, 3), np.uint8)) > 0
    whole = DepthFrame(CAMERA, np.where(ring, np.float32(np.nan), whole.depth))
    found = find_person(scene_of(whole), whole)
    kept = np.isfinite(found.depth)
    assert not kept[ring].any()  # nothing is made up
    for part in (ring & (on > 0), ring & (on == 0)):
        assert found.rim[part].mean() > 0.6
        assert found.free[part].mean() > 0.6
    assert not ((found.rim | found.free) & kept).any()


@pytest.mark.parametrize(("away", "kept"), [(0.43, True), (0.8, False)])
def test_a_forearm_whose_upper_arm_is_hidden_belongs_to_the_body(rng, away, kept):
    nobody = DepthFrame(CAMERA, np.full((240, 320), np.nan, np.float32))
    scene = empty_scene([in_room(nobody, rng=rng) for _ in range(2)])
    alone = picture(standing((0.0, 0.1, 2.8)))
    rows, columns = np.nonzero(np.isfinite(alone.depth[60:90]))
    row, edge = 60 + int(rows.mean()), int(columns.max())
    middle = edge + round(away * CAMERA.fx / 2.8)
    with_arm = alone.depth.copy()
    with_arm[row - 12 : row + 13, middle : middle + 7] = 2.8
    found = find_person(scene, in_room(DepthFrame(CAMERA, with_arm), rng=rng))
    assert np.isfinite(found.depth[row - 8 : row + 9, middle + 2 : middle + 5]).all() == kept
    assert _overlap(found, alone) > 0.85


def test_planes_are_the_same_for_the_same_seed(rng):
    frame = in_room(picture(standing()), rng=rng)
    np.testing.assert_array_equal(scene_of(frame, 3).planes, scene_of(frame, 3).planes)


def _damaged(frame, kind):
    """The frame as a first image may be."""
    depth = np.array(frame.depth)
    if kind == "blank":
        depth[:] = np.nan
    if kind == "lower half":
        depth[len(depth) // 2 :] = np.nan
    if kind == "every second row":
        depth[::2] = np.nan
    if kind == "one pixel in ten":
        depth[np.random.default_rng(0).uniform(size=depth.shape) > 0.1] = np.nan
    if kind == "saturated":
        depth[:] = 65.535
    return DepthFrame(frame.camera, depth, None, frame.time)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["blank", "lower half", "every second row", "one pixel in ten", "saturated"])
def test_a_damaged_first_image_tells_nothing_of_the_room_that_the_next_does_not_put_right(rng, kind):
    alone = [picture(standing((0.05 * k, 0.1, 2.6)), HALF, time=k / 30) for k in range(4)]
    whole = [in_room(frame, rng=rng) for frame in alone]
    first = _damaged(whole[0], kind)
    scene = scene_of(first)
    for k, frame in enumerate([first, *whole[1:]]):
        scene = told_again(scene, frame)
        found = find_person(scene, frame)
        scene = remember(scene, frame, found)
        assert k == 0 or _overlap(found, alone[k]) > 0.9
    np.testing.assert_allclose(np.sort(scene.planes[:, 3]), [1.05, 4.0], rtol=0.03)


def test_a_whole_first_image_tells_of_the_room_for_good(rng):
    whole = [in_room(picture(standing((0.1 * k, 0.1, 2.6)), HALF, time=k / 30), rng=rng) for k in range(3)]
    scene = scene_of(whole[0])
    for frame in [*whole, _damaged(whole[2], "blank"), *whole[1:]]:
        after = told_again(scene, frame)
        np.testing.assert_array_equal(after.planes, scene.planes)
        scene = after


@pytest.mark.parametrize("kind", ["blank", "lower half", "one pixel in ten"])
def test_an_empty_room_is_told_by_its_first_whole_image(rng, kind):
    nobody = DepthFrame(HALF, np.full((120, 160), np.nan, np.float32))
    empty = [in_room(nobody, rng=rng) for _ in range(3)]
    scene = empty_scene([_damaged(empty[0], kind), *empty])
    np.testing.assert_array_equal(scene.planes, scene_of(empty[0]).planes)


def test_an_empty_room_has_nobody_and_whoever_enters_is_found(rng):
    nobody = DepthFrame(HALF, np.full((120, 160), np.nan, np.float32))
    empty = [in_room(nobody, rng=rng) for _ in range(4)]
    scene = empty_scene(empty)
    assert not find_person(scene, in_room(nobody, rng=rng)).found
    alone = picture(standing((0.3, 0.1, 2.8)), HALF)
    found = find_person(scene, in_room(alone, rng=rng))
    assert found.found
    assert _overlap(found, alone) > 0.9
    np.testing.assert_allclose(found.place[[0, 2]], [0.3, 2.75], atol=0.15)


def test_furniture_is_learned_and_the_walker_is_followed_and_leaves(rng):
    """A box before the wall, a person who walks past it and out of the image."""
    scene, last, overlaps, furniture = None, None, [], None
    for k in range(14):
        place = (-1.0 + 0.2 * k, 0.1, 2.6)
        alone = picture(standing(place), HALF, time=k / 30)
        whole = np.array(in_room(alone, rng=rng).depth)
        box = np.full(whole.shape, np.nan, np.float32)
        box[60:100, 120:150] = 3.2
        frame = DepthFrame(HALF, np.fmin(whole, box), None, k / 30)
        scene = scene_of(frame) if scene is None else scene
        found = find_person(scene, frame, last)
        scene = remember(scene, frame, found)
        last = found.place
        overlaps.append(_overlap(found, alone))
        furniture = np.isfinite(found.depth)[70:90, 125:145].mean() if k == 2 else furniture
    assert np.median(overlaps) > 0.9
    assert furniture == 0.0
    nobody = np.fmin(in_room(DepthFrame(HALF, np.full((120, 160), np.nan, np.float32)), rng=rng).depth, box)
    assert not find_person(scene, DepthFrame(HALF, nobody), last).found


def test_what_was_wrongly_learned_from_the_person_heals(rng):
    alone = picture(standing((0.0, 0.1, 2.6)), HALF)
    frame = in_room(alone, rng=rng)
    scene = scene_of(frame)
    spoilt = np.array(scene.background)
    rows, columns = np.nonzero(np.isfinite(alone.depth))
    middle = (np.abs(rows - np.median(rows)) < 8) & (np.abs(columns - np.median(columns)) < 4)
    spoilt[rows[middle], columns[middle]] = alone.depth[rows[middle], columns[middle]]
    scene = type(scene)(scene.planes, spoilt)
    found = find_person(scene, frame)
    assert np.isfinite(found.depth[rows[middle], columns[middle]]).all()
    after = remember(scene, frame, found)
    assert np.isnan(after.background[rows[middle], columns[middle]]).all()


def test_an_arm_that_is_cut_off_by_its_foreshortening_stays():
    """A hand's breadth of pixels half an arm's length before the chest, not connected with it."""
    frame = picture(standing((0.0, 0.1, 2.5)))
    depth = np.array(frame.depth)
    depth[95:107, 154:166] = np.nanmedian(depth) - 0.30
    found = find_person(scene_of(frame), DepthFrame(CAMERA, depth))
    assert np.isfinite(found.depth[97:105, 156:164]).all()


def test_a_body_that_an_arm_cuts_in_two_stays_whole(rng):
    """A band across the waist, an arm's length before the trunk: what is above and below it are alike in size."""
    alone = picture(standing((0.0, 0.1, 2.6)))
    depth = np.array(alone.depth)
    rows, columns = np.nonzero(np.isfinite(depth))
    waist = int(rows.min() + 0.42 * np.ptp(rows))
    depth[waist : waist + 9, columns.min() - 2 : columns.max() + 3] = np.nanmin(depth) - 0.25
    crossed = DepthFrame(CAMERA, depth)
    whole = in_room(crossed, rng=rng)
    found = find_person(scene_of(whole), whole)
    assert _overlap(found, crossed) > 0.9


@pytest.mark.parametrize("known", [True, False])
def test_the_legs_of_who_leaps_behind_an_arm_stay_theirs(rng, known):
    """Trunk and legs are where nobody was a moment ago, an arm's loss apart; before a room that is known both move."""
    nobody = DepthFrame(CAMERA, np.full((240, 320), np.nan, np.float32))
    alone = picture(standing((0.0, 0.1, 2.8)), person=PERSON.stretched(np.full((1, 3), 0.85)))
    rows, columns = np.nonzero(np.isfinite(alone.depth))
    waist, band = int(rows.min() + 0.42 * np.ptp(rows)), round(0.17 * CAMERA.fy / 2.8)
    depth = np.array(in_room(alone, rng=rng).depth)
    depth[waist : waist + band, columns.min() : columns.max() + 1] = np.nan
    whole = DepthFrame(CAMERA, depth)
    scene = empty_scene([in_room(nobody, rng=rng) for _ in range(2)]) if known else scene_of(whole)
    found = np.isfinite(find_person(scene, whole).depth)
    legs = slice(waist + band + 5, rows.max() - 12)
    assert found[waist - 20 : waist - 10].any()
    assert (np.count_nonzero(found[legs]) > 0.9 * np.count_nonzero(np.isfinite(alone.depth[legs]))) == known


@pytest.mark.parametrize("seen_before", [True, False])
def test_a_child_cut_in_two_halves_of_which_none_is_long_enough_for_a_body_stays(rng, seen_before):
    """Only who was there a moment ago: in an empty room what is so short is nobody."""
    child = PERSON.stretched(np.full((1, 3), 0.55))
    alone = picture(standing((0.0, 0.1, 2.6)), person=child)
    whole = in_room(alone, rng=rng)
    scene = scene_of(whole)
    if seen_before:
        scene = remember(scene, whole, find_person(scene, whole))
    depth = np.array(alone.depth)
    rows, columns = np.nonzero(np.isfinite(depth))
    waist = int(rows.min() + 0.45 * np.ptp(rows))
    depth[waist : waist + 5, columns.min() : columns.max() + 1] = np.nan  # lost at the edges of an arm
    found = find_person(scene, in_room(DepthFrame(CAMERA, depth), rng=rng))
    assert found.found == seen_before
    if seen_before:
        assert _overlap(found, DepthFrame(CAMERA, depth)) > 0.85


def test_what_was_the_person_stays_the_persons_while_the_rest_moves(rng):
    """Somebody stands; then head and trunk sway before a wall that was seen, the legs before one that never was."""
    scene, last = None, None
    for k in range(8):
        alone = picture(standing((0.0, 0.1, 2.6)))
        depth = np.array(alone.depth)
        rows = np.nonzero(np.isfinite(depth).any(axis=1))[0]
        waist = int(rows.min() + 0.45 * np.ptp(rows))
        depth[:waist] = np.roll(depth[:waist], 2 * k, axis=1)
        depth[waist : waist + 6] -= 0.3  # an arm across
        frame = DepthFrame(CAMERA, depth, None, k / 30)
        whole = in_room(frame, rng=rng)
        scene = scene_of(whole) if scene is None else scene
        found = find_person(scene, whole, last)
        scene, last = remember(scene, whole, found), found.place
        assert _overlap(found, frame) > 0.85


def test_somebody_far_away_who_moves_is_found(rng):
    """At 5.6 m noise hides the relief of a body; that it moves before a known wall does not hide."""
    nobody = DepthFrame(CAMERA, np.full((240, 320), np.nan, np.float32))

    def seen(frame):
        whole = in_room(frame, 1.05, 7.0)
        depth = whole.depth + rng.normal(0, 0.0017, whole.depth.shape).astype(np.float32) * whole.depth**2
        return DepthFrame(CAMERA, depth, None, frame.time)

    scene = empty_scene([seen(nobody) for _ in range(6)])
    for k in range(4):
        alone = picture(standing((0.1 * k, 0.1, 5.6)))
        found = find_person(scene, seen(alone))
        assert found.found
        assert _overlap(found, alone) > 0.7


def test_what_stands_before_the_person_may_hide_them(rng):
    """Legs behind a table: known as the room's, it says nothing of where they are; floor and wall do."""
    alone = picture(standing((0.0, 0.1, 2.8)))
    whole = np.array(in_room(alone, 1.05, 4.5).depth)
    whole[150:200, 110:210] = 2.0
    scene, last = None, None
    for k in range(3):
        seen = DepthFrame(CAMERA, whole + rng.normal(0, 0.003, whole.shape).astype(np.float32), None, k / 30)
        scene = scene_of(seen) if scene is None else scene
        found = find_person(scene, seen, last)
        scene, last = remember(scene, seen, found), found.place
    assert found.found
    assert not found.free[152:198, 112:208].any()
    assert found.free[60:140, 5:80].mean() > 0.95  # the wall
    assert found.free[225:, :].mean() > 0.95  # the floor


@pytest.mark.parametrize("who", ["person", "board"])
def test_far_away_a_person_who_stands_still_is_told_from_a_board(rng, who):
    """At 5.4 m the first Kinect's noise would hide the relief of a body; a camera with less shows it."""
    alone = picture(standing((0.0, 0.1, 5.4)))
    if who == "board":
        depth = np.full(alone.depth.shape, np.nan, np.float32)
        rows, columns = np.nonzero(np.isfinite(alone.depth))
        depth[rows.min() : rows.max() + 1, columns.min() : columns.max() + 1] = 5.4
        depth += 0.001 * np.arange(depth.shape[1], dtype=np.float32)  # not square to the camera
        alone = DepthFrame(CAMERA, depth)
    whole = in_room(alone, 1.05, 6.8)
    noise = rng.normal(0, 0.008, whole.depth.shape).astype(np.float32)
    seen = DepthFrame(CAMERA, whole.depth + noise)
    assert find_person(scene_of(seen), seen).found == (who == "person")


@pytest.mark.parametrize(("vouched", "found"), [(True, True), (False, False)])
@pytest.mark.parametrize("reaches", [False, True])
def test_who_was_followed_a_moment_ago_has_not_become_a_board_or_too_long(rng, reaches, vouched, found):
    """Noise that hides all relief, or arms raised by somebody tall; what may be furniture is asked as ever."""
    alone = np.array(picture(standing((0.0, 0.1, 5.2))).depth)
    noise = 0.04
    if reaches:
        rows, columns = np.nonzero(np.isfinite(alone))
        noise, top = 0.005, int(rows.max() - 2.65 * CAMERA.fy / 5.2)
        alone[top : rows.min() + 10, int(np.median(columns)) - 4 : int(np.median(columns)) + 4] = 5.2
    whole = in_room(DepthFrame(CAMERA, alone), 1.05, 6.8).depth
    whole = whole + rng.normal(0, noise, whole.shape).astype(np.float32) * np.isfinite(alone)
    seen = DepthFrame(CAMERA, whole)
    scene = replace(scene_of(seen), person=alone, vouched=vouched)
    assert find_person(scene, seen, np.array([0.0, 0.1, 5.2])).found == found


def test_specks_are_nobody(rng):
    depth = np.full((240, 320), np.nan, np.float32)
    depth[rng.uniform(size=depth.shape) < 0.01] = 2.0
    depth[100:110, 100:110] = 2.5
    frame = DepthFrame(CAMERA, depth)
    assert not find_person(scene_of(frame), frame).found


def test_clean_up_fills_single_holes_and_leaves_outlines(rng):
    frame = picture(Pose(*[getattr(standing(), n) for n in ("translation", "root", "joints")]))
    holes = np.array(frame.depth)
    rows, columns = np.nonzero(np.isfinite(holes))
    inner = np.array(
        [np.isfinite(holes[r - 1 : r + 2, c - 1 : c + 2]).all() for r, c in zip(rows, columns, strict=True)]
    )
    rows, columns = rows[inner], columns[inner]
    some = rng.permutation(len(rows))[:40]
    holes[rows[some], columns[some]] = np.nan
    out = clean(holes)
    background = np.isnan(frame.depth)
    assert np.isfinite(out[rows[some], columns[some]]).mean() > 0.9
    assert np.isnan(out[background]).mean() > 0.999
    assert np.nanmedian(np.abs(out - frame.depth)) < 0.004


def test_sizes_that_differ_are_refused():
    scene = scene_of(picture(standing()))
    with pytest.raises(MismatchError, match="240"):
        find_person(scene, picture(standing(), HALF))
    with pytest.raises(MismatchError, match="at least one"):
        empty_scene([])


def test_real_recordings_without_background_keep_their_person(data):
    from scipy.io import loadmat

    volume = loadmat(data / "kinect" / "utdmhad" / "Depth" / "a10_s1_t1_depth.mat")["d_depth"]
    for k in range(0, volume.shape[2], 15):
        depth = np.where(volume[:, :, k] == 0, np.nan, volume[:, :, k] / 1000.0).astype(np.float32)
        frame = DepthFrame(CAMERA, depth)
        found = find_person(scene_of(frame), frame)
        assert np.isfinite(found.depth)[np.isfinite(depth)].mean() > 0.98


def test_a_real_person_before_a_wall_is_told_from_it(data):
    import cv2

    from motionmend.bodies.camera import Camera

    camera = Camera(320, 240, 262.5, 262.5, 160.0, 120.0)
    folder = data / "kinect" / "cv2_rgbd"
    scene, last = None, None
    for name in sorted(folder.glob("*_depth.png"))[::3]:
        raw = cv2.imread(str(name), cv2.IMREAD_UNCHANGED)[::2, ::2]
        mask = cv2.imread(str(name).replace("_depth.png", "_mask.jpg"), 0)[::2, ::2] > 128
        frame = DepthFrame(camera, np.where(raw == 0, np.nan, raw / 1000.0).astype(np.float32))
        scene = scene_of(frame) if scene is None else scene
        found = find_person(scene, frame, last)
        scene, last = remember(scene, frame, found), found.place
        seen = DepthFrame(camera, np.where(mask, frame.depth, np.float32(np.nan)))
        assert _overlap(found, seen) > 0.93
