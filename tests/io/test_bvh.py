"""Biovision files: the kinematics of the format, what is supposed and said, round trips."""

import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from biovision_files import TEXT, VALUES, read_text
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from motionmend.bodies.motion import Motion
from motionmend.bodies.skeleton import height, positions, same
from motionmend.errors import MismatchError
from motionmend.io.amc import read_amc
from motionmend.io.bvh import bvh_of, read_bvh, write_bvh
from skeletons import random_skeleton, skeletons


def numbers_in(path: Path) -> list[float]:
    """Every number after the line that gives the frame time."""
    lines = path.read_text().splitlines()
    start = next(i for i, line in enumerate(lines) if line.lower().startswith("frame time"))
    return [float(word) for line in lines[start + 1 :] for word in line.split()]


# ---- what the format means -------------------------------------------------------------------------------------


@st.composite
def biovision(draw, joints=6):
    """A random .bvh text, and {joint: place} of its frames by the format's own words: offsets, then channels."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    count = int(rng.integers(1, joints + 1))
    parents = [-1, *(int(rng.integers(0, j)) for j in range(1, count))]
    offsets = rng.normal(size=(count, 3)) * 40
    offsets[0] = rng.choice([0.0, 1.0]) * offsets[0]
    turns = [rng.permutation(["Xrotation", "Yrotation", "Zrotation"])[: rng.integers(0, 4)].tolist() for _ in parents]
    moves = ["Xposition", "Yposition", "Zposition"]
    channels = [
        rng.permutation([*turn, *(rng.permutation(moves).tolist() if j == 0 or rng.random() < 0.3 else [])]).tolist()
        for j, turn in enumerate(turns)
    ]
    values = [rng.normal(size=(3, len(c))) * 60 for c in channels]
    absolute = rng.random(count) < 0.5
    for j, own in enumerate(channels):  # clearly absolute or clearly relative places below the root
        if j and "Xposition" in own:
            for axis, letter in enumerate("XYZ"):
                at = own.index(f"{letter}position")
                values[j][:, at] = rng.normal(size=3) * 0.01 + (offsets[j, axis] if absolute[j] else 0.0)
    lines = ["HIERARCHY"]

    def write(j: int, indent: str) -> None:
        lines.append(f"{indent}{'JOINT' if indent else 'ROOT'} joint {j}")
        lines.append(f"{indent}{{\n{indent} OFFSET {' '.join(repr(float(x)) for x in offsets[j])}")
        if channels[j] or rng.random() < 0.5:
            lines.append(f"{indent} CHANNELS {len(channels[j])} {' '.join(channels[j])}")
        children = [c for c in range(count) if parents[c] == j]
        order.append(j)
        for child in children:
            write(child, indent + " ")
        if not children:
            lines.append(f"{indent} End Site\n{indent} {{\n{indent}  OFFSET 0 0 7\n{indent} }}")
        lines.append(f"{indent}}}")

    order: list[int] = []
    write(0, "")
    table = np.hstack([values[j] for j in order])
    lines += ["MOTION", "Frames: 3", "Frame Time: 0.025", *(" ".join(map(repr, row)) for row in table.tolist())]

    places = {}
    for t in range(3):
        frames = {}
        for j in order:
            above, end = frames[parents[j]] if j else (Rotation.identity(), np.zeros(3))
            own = dict(zip(channels[j], values[j][t], strict=True))
            place = offsets[j].copy()
            if "Xposition" in own:
                given_place = np.array([own[m] for m in moves])
                near = absolute[j]
                place = given_place if j and near else offsets[j] + given_place
            turned = Rotation.identity()
            for channel in channels[j]:
                if channel.endswith("rotation"):
                    turned = turned * Rotation.from_euler(channel[0].lower(), own[channel], degrees=True)
            frames[j] = (above * turned, end + above.apply(place))
            places.setdefault(f"joint {j}", []).append(frames[j][1])
            if j not in parents:
                places.setdefault(f"joint {j}_end", []).append(frames[j][1] + frames[j][0].apply([0, 0, 7]))
    return "\n".join(lines) + "\n", places, table


@settings(max_examples=40)
@given(biovision())
def test_the_skeleton_moves_as_the_format_says(tmp_path_factory, case):
    text, places, table = case
    folder = tmp_path_factory.mktemp("random")
    if not table.size:
        return
    motion = read_text(folder, text)
    assert set(motion.skeleton.names) == set(places)
    found = positions(motion.skeleton, motion.q) / motion.source.metres
    wanted = np.stack([places[name] for name in motion.skeleton.names], axis=1)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-8)

    write_bvh(folder / "again.bvh", motion)
    again = (folder / "again.bvh").read_text()
    assert again.startswith(text[: text.index("MOTION")])
    np.testing.assert_allclose(numbers_in(folder / "again.bvh"), table.ravel(), rtol=0, atol=1e-6)
    assert read_bvh(folder / "again.bvh").fps == motion.fps == 40


def test_a_small_motion(tmp_path):
    motion = read_text(tmp_path, TEXT)
    assert motion.skeleton.names == ("Hips", "Head", "Head_end", "LeftFoot", "LeftFoot_end")
    assert motion.channels[:4] == ("Hips.Xposition", "Hips.Yposition", "Hips.Zposition", "Hips.Zrotation")
    assert motion.channels[6:] == ("Head.Yrotation", "Head.Xrotation", "Head.Zrotation", "LeftFoot.Xrotation")
    assert motion.fps == 120
    assert height(motion.skeleton) == pytest.approx(1.70)
    assert motion.q[1, 1] == pytest.approx(0.9025)
    assert motion.q[2, -1] == pytest.approx(np.radians(5))


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace("\n", "\r\n"),
        lambda text: text.replace("\n", "\r"),
        lambda text: text.replace("\t", "     ").replace(" ", "\t "),
        lambda text: text.lower().replace("leftfoot", "LeftFoot").replace("hips", "Hips").replace("head", "Head"),
        lambda text: text.replace("\n{", " {").replace("\n\t{", "{"),
        lambda text: text.replace("\n", "\n\n"),
        lambda text: "\ufeff" + text + "\n \n",
        lambda text: text.replace("Frames: 3", "Frames:3").replace("Frame Time:", "Frame  Time :\t"),
        lambda text: text.rstrip("\n"),
    ],
)
def test_odd_spelling_changes_nothing(tmp_path, change):
    plain = read_text(tmp_path, TEXT)
    odd = read_text(tmp_path, change(TEXT))
    assert same(odd.skeleton, plain.skeleton)
    np.testing.assert_array_equal(odd.q, plain.q)
    assert odd.fps == plain.fps
    write_bvh(tmp_path / "again.bvh", odd)
    np.testing.assert_allclose(read_bvh(tmp_path / "again.bvh").q, odd.q, rtol=0, atol=1e-12)


# ---- what is supposed, and said --------------------------------------------------------------------------------


@pytest.mark.parametrize("metres", [1.0, 0.01, 0.001, 0.0254, 0.0254 / 0.45])
def test_the_unit_is_guessed_from_the_height_and_said(tmp_path, metres):
    lines = []
    for line in TEXT.splitlines():
        if "OFFSET" in line:
            line = "OFFSET " + " ".join(repr(float(word) * 0.01 / metres) for word in line.split()[1:])
        lines.append(line)
    motion = read_text(tmp_path, "\n".join(lines))
    assert motion.source.metres == pytest.approx(metres)
    assert any(f"1 unit of length = {metres:.6g} m" in guess for guess in motion.guesses)


def test_a_height_no_unit_explains_is_said(tmp_path):
    motion = read_text(tmp_path, TEXT.replace("-80", "-80000"))
    assert motion.source.metres == 0.01
    assert any("lengths may be wrong" in guess for guess in motion.guesses)


@pytest.mark.parametrize(
    ("order", "up"),
    [((0, 1, 2), [0, 1, 0]), ((0, 2, 1), [0, 0, 1]), ((1, 0, 2), [1, 0, 0]), ((0, -1, 2), [0, -1, 0])],
)
def test_the_way_up_is_guessed_from_head_and_feet(tmp_path, order, up):
    lines = []
    for line in TEXT.splitlines():
        if "OFFSET" in line:
            x, y, z = line.split()[1:]
            turned = [x, y, z] if -1 not in order else [x, str(-float(y)), z]
            line = "OFFSET " + " ".join(turned if -1 in order else [turned[i] for i in order])
        lines.append(line)
    motion = read_text(tmp_path, "\n".join(lines))
    assert motion.skeleton.up.tolist() == up
    assert any("above the feet" in guess for guess in motion.guesses)
    nameless = read_text(tmp_path, TEXT.replace("Head", "One").replace("Foot", "Two"))
    assert any("no head or feet by name: took +y" in guess for guess in nameless.guesses)


@pytest.mark.parametrize(
    ("spelled", "fps", "said"),
    [
        ("0.00833333", 120, True),
        (".0083333", 120, True),
        ("0.0083", 120, True),
        ("0.033", 30, True),
        ("0.0333333333", 30, True),
        ("0.0166", 60, True),
        ("1.6667e-2", 60, True),
        ("0.0333667", 29.97, False),
        ("0.01", 100, False),
        ("0.04", 25, False),
        ("1", 1, False),
        ("0.03", 100 / 3, False),
    ],
)
def test_the_rate_is_the_one_the_frame_time_is_rounded_from(tmp_path, spelled, fps, said):
    motion = read_text(tmp_path, TEXT.replace("0.00833333", spelled))
    assert motion.fps == pytest.approx(fps, rel=1e-5)
    assert any("Frame Time" in guess for guess in motion.guesses) == said
    write_bvh(tmp_path / "again.bvh", motion)
    assert f"Frame Time: {spelled}\n" in (tmp_path / "again.bvh").read_text()


@pytest.mark.parametrize(("spelled", "said"), [("8.33333", "or milliseconds, 120 Hz"), ("1.5", "nothing is captured")])
def test_a_rate_of_no_capture_is_said(tmp_path, spelled, said):
    motion = read_text(tmp_path, TEXT.replace("0.00833333", spelled))
    assert motion.fps == pytest.approx(1.0 / float(spelled))
    (guess,) = [guess for guess in motion.guesses if "Frame Time" in guess]
    assert said in guess


def test_a_given_rate_wins_and_says_so(tmp_path):
    motion = read_text(tmp_path, TEXT, fps=60.0)
    assert motion.fps == 60
    assert any("states 120 Hz, took 60 Hz" in guess for guess in motion.guesses)
    assert not any("took 120 Hz as given" in g for g in read_text(tmp_path, TEXT, fps=120.0).guesses)
    write_bvh(tmp_path / "again.bvh", motion)
    assert read_bvh(tmp_path / "again.bvh").fps == 60


def test_places_below_the_root_replace_or_add(tmp_path):
    moving = TEXT.replace("CHANNELS 1 Xrotation", "CHANNELS 4 Xrotation Xposition Yposition Zposition")
    replaced = moving.replace(VALUES, "".join(f"{line} 10 -80 {i}\n" for i, line in enumerate(VALUES.splitlines())))
    added = moving.replace(VALUES, "".join(f"{line} 0 0 {i}\n" for i, line in enumerate(VALUES.splitlines())))
    one, other = read_text(tmp_path, replaced), read_text(tmp_path, added)
    np.testing.assert_allclose(one.q, other.q, rtol=0, atol=1e-12)
    assert one.q[2, -2] == pytest.approx(0.02)
    assert any("LeftFoot replace its OFFSET" in guess for guess in one.guesses)
    assert any("LeftFoot add to its OFFSET" in guess for guess in other.guesses)
    for motion, text in ((one, replaced), (other, added)):
        write_bvh(tmp_path / "again.bvh", motion)
        wanted = [float(word) for word in text.split("833333\n")[1].split()]
        np.testing.assert_allclose(numbers_in(tmp_path / "again.bvh"), wanted, rtol=0, atol=1e-9)


def test_what_is_supposed_of_many_joints_is_said_in_one_line(tmp_path):
    channels = "CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation"
    joints, row = "", "0 80 0 0 0 0"
    for joint in range(7):
        joints += f"JOINT J{joint} {{ OFFSET 0 0 10\n{channels}\n"
        row += f" 0 0 10.{joint} 0 0 0"
    text = f"HIERARCHY\nROOT Hips {{ OFFSET 0 0 0\n{channels}\n{joints}End Site {{ OFFSET 0 0 5 }}\n" + "}" * 8
    motion = read_text(tmp_path, f"{text}\nMOTION\nFrames: 2\nFrame Time: 0.0333333\n{row}\n{row}\n")
    said = [guess for guess in motion.guesses if "OFFSET" in guess]
    assert len(said) == 1
    assert "joints J0, J1, J2, J3 and 3 more replace their OFFSET" in said[0]


@pytest.mark.parametrize("spelt", ["-nan(ind)", "nan(snan)", "-1.#IND", "1.#QNAN00"])
def test_what_windows_writes_for_no_number_is_a_gap(tmp_path, spelt):
    motion = read_text(tmp_path, TEXT.replace("1.5 2.5", f"{spelt} {spelt}"))
    assert np.isnan(motion.q).sum() == 2


def test_a_root_with_an_offset_adds_and_says_so(tmp_path):
    motion = read_text(tmp_path, TEXT.replace("OFFSET 0.0 0.0 0.0", "OFFSET 0.0 5.0 0.0"))
    assert positions(motion.skeleton, motion.q)[0, 0].tolist() == pytest.approx([0, 0.95, 0])
    assert any("root Hips add to its OFFSET" in guess for guess in motion.guesses)


def test_names_that_come_twice_are_told_apart(tmp_path):
    motion = read_text(tmp_path, TEXT.replace("JOINT LeftFoot", "JOINT Head"))
    assert motion.skeleton.names == ("Hips", "Head", "Head_end", "Head_2", "Head_2_end")
    assert "joint name Head comes more than once: called one Head_2" in motion.guesses
    assert len(set(motion.channels)) == len(motion.channels)
    write_bvh(tmp_path / "again.bvh", motion)
    assert (tmp_path / "again.bvh").read_text().count("JOINT Head\n") == 2


def test_an_inserted_rest_pose_is_said(tmp_path):
    walk = np.cumsum(np.full((30, 10), 0.4), axis=0) + 40

    def guesses(table):
        rows = "\n".join(" ".join(map(str, row)) for row in table.tolist())
        motion = read_text(tmp_path, TEXT.replace("Frames: 3", f"Frames: {len(table)}").replace(VALUES, rows))
        assert motion.frames == len(table)
        return motion.guesses

    assert "the first frame is a rest pose put before the recording" in guesses(np.vstack([np.zeros((1, 10)), walk]))
    assert not any("first frame" in guess for guess in guesses(walk))
    assert not any("first frame" in guess for guess in guesses(walk - walk[0])), "it starts at rest and goes on"


def test_more_frames_than_stated_are_read_and_said(tmp_path):
    motion = read_text(tmp_path, TEXT.replace("Frames: 3", "Frames: 2"))
    assert motion.frames == 3
    assert "2 frames stated after 'Frames:', 3 in the file: took all" in motion.guesses
    write_bvh(tmp_path / "again.bvh", motion)
    assert read_bvh(tmp_path / "again.bvh").frames == 3


@pytest.mark.parametrize("encoding", ["latin-1", "utf-8-sig"])
def test_the_hierarchy_comes_back_to_the_byte(tmp_path, encoding):
    source, target = tmp_path / "in.bvh", tmp_path / "out.bvh"
    source.write_bytes(TEXT.replace("Hips", "Hüfte").replace("\n", "\r\n").encode(encoding))
    write_bvh(target, read_bvh(source))
    assert target.read_bytes() == source.read_bytes()


def test_missing_samples(tmp_path):
    motion = read_text(tmp_path, TEXT.replace("1.5 2.5", "nan NaN"))
    assert (~motion.present).sum() == 2
    assert not motion.present[1, 6:8].any()
    write_bvh(tmp_path / "again.bvh", motion)
    np.testing.assert_allclose(read_bvh(tmp_path / "again.bvh").q, motion.q, rtol=0, atol=1e-12)


def test_names_of_old_programs(tmp_path):
    """Latin-1 is no UTF-8: the name is read, and written as UTF-8."""
    (tmp_path / "small.bvh").write_bytes(TEXT.replace("Head", "Tête").encode("latin-1"))
    motion = read_bvh(tmp_path / "small.bvh")
    assert motion.skeleton.names[1] == "Tête"
    write_bvh(tmp_path / "again.bvh", motion)
    assert read_bvh(tmp_path / "again.bvh").skeleton.names == motion.skeleton.names


# ---- any motion as a .bvh --------------------------------------------------------------------------------------


def person_sized(skeleton):
    """The same body, 1.7 m tall, so that a reader takes centimetres for what they are."""
    return replace(skeleton, offsets=skeleton.offsets * (1.7 / max(height(skeleton), 1e-6)))


@settings(max_examples=25)
@given(skeletons())
def test_any_skeleton_moves_the_same_as_a_bvh(tmp_path_factory, case):
    skeleton, rng = case
    if height(skeleton) < 0.05:
        return
    skeleton = person_sized(skeleton)
    motion = Motion(skeleton, rng.normal(size=(5, len(skeleton.dof_names))), 50.0)
    path = tmp_path_factory.mktemp("any") / "any.bvh"
    write_bvh(path, motion)
    again = read_bvh(path)
    assert again.fps == 50
    at = [again.skeleton.names.index(name) for name in skeleton.names]
    for converted in (bvh_of(motion), again):
        found = positions(converted.skeleton, converted.q)[:, at]
        np.testing.assert_allclose(found, positions(skeleton, motion.q), rtol=0, atol=1e-6)


def test_a_missing_turn_opens_its_joint_only(rng):
    skeleton = random_skeleton(rng, joints=6, translations=False)
    q = rng.normal(size=(4, len(skeleton.dof_names)))
    lost = int(np.flatnonzero(skeleton.dof_joint > 0)[0])
    q[2, lost] = np.nan
    converted = bvh_of(Motion(skeleton, q, 50.0))
    joint = skeleton.names[skeleton.dof_joint[lost]]
    gaps = np.flatnonzero(~converted.present.all(axis=0))
    assert {converted.channels[d].split(".")[0] for d in gaps} == {joint}
    assert converted.present[[0, 1, 3]].all()


def test_one_missing_coordinate_of_the_root_stays_one(tmp_path):
    motion = read_text(tmp_path, TEXT)
    q = np.array(motion.q)
    q[1, 0] = np.nan
    converted = bvh_of(motion.with_q(q))
    assert [converted.channels[d] for d in np.flatnonzero(~converted.present[1])] == ["Hips.Xposition"]


def test_euler_angles_do_not_jump(rng):
    """A joint that turns round and round: angles go on, they do not wrap."""
    skeleton = random_skeleton(rng, joints=2, translations=False)
    skeleton = replace(
        skeleton,
        dof_names=("j0.d0",),
        dof_joint=np.array([0]),
        dof_axis=np.array([[0.0, 0, 1]]),
        dof_kind=np.array([0]),
        limits=np.array([[-np.inf, np.inf]]),
    )
    turning = np.linspace(0, 20, 200)[:, None]
    converted = bvh_of(Motion(skeleton, turning, 50.0))
    np.testing.assert_allclose(converted.q[:, converted.channels.index("j0.Zrotation")], turning[:, 0], atol=1e-9)


def test_names_a_bvh_cannot_hold_are_one_line(rng):
    skeleton = random_skeleton(rng, joints=2)
    wrong = replace(skeleton, names=("root", "my {joint}"))
    with pytest.raises(MismatchError, match=r"cannot stand in a \.bvh"):
        bvh_of(Motion(wrong, np.zeros((1, len(skeleton.dof_names))), 50.0))


# ---- real recordings -------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_every_recording_keeps_every_value(data, tmp_path):
    files = sorted((data / "mocap" / "bvh").glob("*.bvh"))
    assert len(files) >= 9
    for path in files:
        start = time.process_time()
        motion = read_bvh(path)
        seconds = time.process_time() - start
        assert seconds / motion.frames * 5000 < 1.0, "5,000 frames take under a second"
        assert motion.fps == 120
        assert 1.2 < height(motion.skeleton) < 1.8
        assert motion.skeleton.up.tolist() == [0, 1, 0]
        assert any("put before the recording" in guess for guess in motion.guesses), "all start with one"
        write_bvh(tmp_path / path.name, motion)
        assert numbers_in(tmp_path / path.name) == numbers_in(path)
        text, again = path.read_bytes(), (tmp_path / path.name).read_bytes()
        assert again.startswith(text[: text.index(b"Frame Time:")])


@pytest.mark.slow
def test_a_recording_from_acclaim_moves_the_same_as_a_bvh(data, tmp_path):
    for name in ("02/02_01", "05/05_13", "135/135_04", "86/86_01"):
        motion = read_amc(data / "mocap" / "amc" / f"{name}.amc")
        path = tmp_path / f"{Path(name).name}.bvh"
        write_bvh(path, motion)
        again = read_bvh(path)
        at = [again.skeleton.names.index(joint) for joint in motion.skeleton.names]
        found = positions(again.skeleton, again.q)[:, at]
        np.testing.assert_allclose(found, positions(motion.skeleton, motion.q), rtol=0, atol=1e-6)
        assert again.fps == 120
        assert again.skeleton.names == motion.skeleton.names


@pytest.mark.parametrize("names", [("SpineBase", "Head", "ShoulderLeft"), ("RHip", "RKnee", "RAnkle"), ("A", "B", "C")])
def test_half_a_person_in_centimetres_is_not_a_whole_one_in_inches(tmp_path: Path, names: tuple[str, ...]) -> None:
    text = f"""HIERARCHY
ROOT {names[0]}
{{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT {names[1]}
  {{
    OFFSET 0 40 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    JOINT {names[2]}
    {{
      OFFSET 0 36 0
      CHANNELS 3 Zrotation Xrotation Yrotation
      End Site
      {{
        OFFSET 0 0 3
      }}
    }}
  }}
}}
MOTION
Frames: 2
Frame Time: 0.0333333
0 0 0 0 0 0 0 0 0 0 0 0
1 0 0 0 0 0 0 0 0 0 0 0
"""
    (tmp_path / "half.bvh").write_text(text)
    read = read_bvh(tmp_path / "half.bvh")
    assert read.skeleton.offsets[1, 1] == pytest.approx(40 * (0.0254 if names[0] == "A" else 0.01))
