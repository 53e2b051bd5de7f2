"""Acclaim files: the kinematics of the format, round trips, what is missing, and files that are broken."""

import time
from dataclasses import replace
from pathlib import Path

import ezc3d
import numpy as np
import pytest
from acclaim_files import ASF, FRAMES, HEADER, UNIT, read_frames
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from motionmend.bodies.skeleton import height, positions, same
from motionmend.io.amc import find_asf, read_amc, write_amc
from motionmend.io.asf import INCH, parse_asf, skeleton_of, write_asf

# ---- what the format means -------------------------------------------------------------------------------------


def acclaim_positions(asf, values):
    """The format's own words: bone by bone, R = R_parent C M C⁻¹, the first listed turn made first. {name: (3,)}"""
    frames = {}
    places = {}
    for bone, parent in zip((asf.root, *asf.bones), (None, *asf.parents), strict=True):
        own = dict(zip(bone.dof, values[bone.name], strict=True))
        c = Rotation.from_euler(
            bone.axis_order.lower(), [bone.axis["XYZ".index(a)] for a in bone.axis_order], degrees=True
        )
        turns = [t for t in bone.dof if t.startswith("r")]
        m = Rotation.identity()
        for token in turns:
            m = Rotation.from_euler(token[1], own[token], degrees=True) * m
        moved = np.array([own.get(f"t{a}", 0.0) for a in "xyz"])
        above, end = frames[parent] if parent else (Rotation.identity(), np.array(asf.position) + moved)
        start = end + above.apply(c.apply(moved)) if parent else end
        turned = above * c * m * c.inv()
        reach = turned.apply(np.array(bone.direction) * bone.length)
        frames[bone.name] = (turned, start + reach)
        places[bone.name] = start
        if bone is not asf.root and bone.name not in asf.parents:
            places[f"{bone.name}_end"] = start + reach
    return places


@st.composite
def acclaim(draw):
    """A random .asf text, and values for one frame by bone."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    orders = ["XYZ", "XZY", "YXZ", "YZX", "ZXY", "zyx"]
    numbers = lambda n, s=1.0: " ".join(repr(float(x)) for x in rng.normal(size=n) * s)  # noqa: E731
    root = [*rng.permutation(["TX", "TY", "TZ"]), *rng.permutation(["RX", "RY", "RZ"])]
    lines = [":units", "angle deg", "length 0.45", ":root", f"order {' '.join(root)}", f"axis {rng.choice(orders)}"]
    lines += [f"position {numbers(3)}", f"orientation {numbers(3, 90)}", ":bonedata"]
    values = {"root": rng.normal(size=6) * 50}
    names = [f"bone{i}" for i in range(int(rng.integers(1, 7)))]
    for name in names:
        tokens = rng.permutation(["rx", "ry", "rz"])[: rng.integers(0, 4)].tolist()
        tokens += rng.permutation(["tx", "ty", "tz"])[: rng.integers(0, 2)].tolist()
        direction = rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        fields = [
            f"direction {' '.join(repr(float(x)) for x in direction)}",
            f"length {rng.uniform(0, 10)!r}".replace("np.float64", ""),
            f"axis {numbers(3, 90)} {rng.choice(orders)}",
        ]
        fields = [fields[i] for i in rng.permutation(3)]
        lines += ["begin", f"name {name}", *fields]
        if tokens:
            lines.append(f"dof {' '.join(tokens)}")
        lines.append("end")
        values[name] = rng.normal(size=len(tokens)) * 50
    lines += [":hierarchy", "begin", f"root {names[0]}"]
    lines += [f"bone{rng.integers(0, i)} {name}" for i, name in enumerate(names) if i]
    return "\n".join([*lines, "end"]), values


@settings(max_examples=40)
@given(acclaim())
def test_the_skeleton_moves_as_the_format_says(case):
    text, values = case
    asf = parse_asf(text, Path("random.asf"))
    skeleton = skeleton_of(asf)
    q = np.zeros((1, len(skeleton.dof_names)))
    for bone in (asf.root, *asf.bones):
        for token, value in zip(bone.dof, values[bone.name], strict=True):
            q[0, skeleton.dof_names.index(f"{bone.name}.{token}")] = value * asf.scale(token)
    places = acclaim_positions(asf, values)
    assert set(places) == set(skeleton.names)
    found = positions(skeleton, q)[0] / asf.metres
    np.testing.assert_allclose(found, [places[name] for name in skeleton.names], rtol=0, atol=1e-9)


@settings(max_examples=15)
@given(acclaim())
def test_writing_a_random_motion_gives_it_back(tmp_path_factory, case):
    text, _ = case
    folder = tmp_path_factory.mktemp("random")
    asf = parse_asf(text, Path("random.asf"))
    skeleton = skeleton_of(asf)
    rng = np.random.default_rng(5)
    q = rng.normal(size=(4, len(skeleton.dof_names)))
    q[rng.random(q.shape) < 0.2] = np.nan
    write_asf(folder / "random.asf", asf)
    (folder / "random.amc").write_text(":DEGREES\n7\nroot 0 0 0 0 0 0\n")
    template = read_amc(folder / "random.amc")
    written = replace(template, q=q)
    write_amc(folder / "out.amc", written)
    again = read_amc(folder / "out.amc")
    assert again.source.numbers.tolist() == [7, 8, 9, 10]
    assert same(again.skeleton, skeleton)
    np.testing.assert_allclose(again.q, q, rtol=0, atol=1e-6 * min(asf.metres, np.pi / 180))


def test_rest_pose_units_and_limits():
    asf = parse_asf(ASF, Path("small.asf"))
    skeleton = skeleton_of(asf)
    assert skeleton.names == ("root", "hip", "leg", "foot", "foot_end", "head", "head_end")
    assert skeleton.dof_names[:6] == ("root.tx", "root.ty", "root.tz", "root.rz", "root.ry", "root.rx")
    assert skeleton.dof_names[6:] == ("leg.rz", "leg.rx", "foot.rx", "head.rz", "head.ry", "head.rx")
    assert height(skeleton) == pytest.approx(29 * UNIT)
    np.testing.assert_allclose(skeleton.offsets[3], [0, -15 * UNIT, 0], atol=1e-15)
    limits = dict(zip(skeleton.dof_names, skeleton.limits.tolist(), strict=True))
    assert limits["leg.rx"] == pytest.approx([np.radians(-160), np.radians(20)])
    assert limits["leg.rz"] == limits["root.tx"] == [-np.inf, np.inf]
    assert any("inch / 0.45" in guess for guess in asf.guesses)


@pytest.mark.parametrize(
    ("length", "scale", "metres"),
    [("0.45", 1, UNIT), ("1.0", 1 / 0.45, INCH), ("1.0", UNIT / 0.01, 0.01), ("2.54", 1 / 0.45, INCH)],
)
def test_the_length_unit_is_guessed_from_the_height_and_said(length, scale, metres):
    text = ASF.replace("length 0.45", f"length {length}")
    for bone in ("15", "2", "1.5", "14"):
        text = text.replace(f"length {bone}\n", f"length {float(bone) * scale}\n")
    asf = parse_asf(text, Path("other.asf"))
    assert asf.metres == pytest.approx(metres)
    assert height(skeleton_of(asf)) == pytest.approx(29 * UNIT)
    assert f"1 unit of length = {metres:.6g} m" in asf.guesses[0]


def test_a_height_no_unit_explains_is_said():
    text = ASF.replace("length 15\n", "length 1500000\n")
    assert "lengths may be wrong" in parse_asf(text, Path("giant.asf")).guesses[0]


def test_radians():
    text = ASF.replace("angle deg", "angle rad").replace("axis 0 0 20 XYZ", f"axis 0 0 {np.radians(20)} XYZ")
    text = text.replace("axis -90 0 20 ZYX", f"axis {-np.pi / 2} 0 {np.radians(20)} ZYX")
    in_degrees, in_radians = (skeleton_of(parse_asf(t, Path("x.asf"))) for t in (ASF, text))
    np.testing.assert_allclose(in_radians.dof_axis, in_degrees.dof_axis, atol=1e-12)


# ---- motions ---------------------------------------------------------------------------------------------------


def test_a_small_motion(folder):
    motion = read_frames(folder, HEADER + FRAMES)
    column = {name: d for d, name in enumerate(motion.channels)}
    assert motion.q.shape == (3, 12)
    assert motion.q[1, column["root.tx"]] == pytest.approx(1.1 * UNIT)
    assert motion.q[1, column["root.rz"]] == pytest.approx(np.radians(31))
    assert motion.q[0, column["head.rz"]] == pytest.approx(np.radians(0.3))
    assert motion.q[2, column["foot.rx"]] == pytest.approx(np.radians(8))
    assert motion.fps == 120
    assert "no rate in .amc: took 120 Hz; give --fps" in motion.guesses
    assert read_frames(folder, HEADER + FRAMES, fps=60.0).fps == 60


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace("\n", "\r\n"),
        lambda text: text.replace("\n", "\r"),
        lambda text: text.replace(" ", "  \t "),
        lambda text: text.replace("\n", "\n\n"),
        lambda text: "\ufeff" + text,
        lambda text: text.replace("leg", "LEG").replace("root", "Root"),
        lambda text: text.replace("\n2\n", "\n# a comment\n2\n"),
        lambda text: text.rstrip("\n") + "\n\n\n",
    ],
)
def test_odd_spelling_changes_nothing(folder, change):
    plain = read_frames(folder, HEADER + FRAMES)
    np.testing.assert_array_equal(read_frames(folder, change(HEADER + FRAMES)).q, plain.q)


def test_radians_and_a_stated_rate(folder):
    motion = read_frames(folder, ":SAMPLES-PER-SECOND 60\n:FULLY-SPECIFIED\n:RADIANS\n" + FRAMES)
    assert motion.q[0, motion.channels.index("leg.rx")] == pytest.approx(-20)
    assert motion.fps == 60
    assert not any("rate" in guess for guess in motion.guesses)
    other = read_frames(folder, ":SAMPLES-PER-SECOND 60\n" + FRAMES, fps=30.0)
    assert other.fps == 60  # a recording keeps its own rate
    assert read_frames(folder, ":SAMPLES-PER-SECOND 0\n" + FRAMES, fps=30.0).fps == 30
    assert any("took degrees" in guess for guess in other.guesses)


def test_missing_samples(folder):
    text = FRAMES.replace("foot 7.5\n", "").replace("leg -22 5.75", "leg nan 5.75")
    motion = read_frames(folder, HEADER + text)
    lost = ~motion.present
    assert lost.sum() == 2
    assert lost[1, motion.channels.index("foot.rx")]
    assert lost[2, motion.channels.index("leg.rx")]
    write_amc(folder / "small_02.amc", motion)
    assert "foot nan\n" in (folder / "small_02.amc").read_text()
    np.testing.assert_array_equal(read_amc(folder / "small_02.amc").q, motion.q)


def test_a_bone_in_no_frame_is_missing_and_stays_out(folder):
    motion = read_frames(folder, HEADER + "".join(line for line in FRAMES.splitlines(True) if "foot" not in line))
    assert not motion.present[:, motion.channels.index("foot.rx")].any()
    write_amc(folder / "small_02.amc", motion)
    assert "foot" not in (folder / "small_02.amc").read_text()
    filled = motion.with_q(np.nan_to_num(motion.q))
    write_amc(folder / "small_03.amc", filled)
    assert "foot 0\n" in (folder / "small_03.amc").read_text()


def test_numbers_comments_and_header_are_kept(folder):
    text = HEADER + FRAMES.replace("1\nroot", "17\nroot").replace("\n2\n", "\n# in between\n18\n")
    text = text.replace("\n3\n", "\n19\n")
    motion = read_frames(folder, text)
    write_amc(folder / "small_02.amc", motion)
    kept = (folder / "small_02.amc").read_text()
    assert kept.startswith(HEADER + "17\n")
    assert "\n# in between\n18\n" in kept
    longer = motion.with_q(np.vstack([motion.q, motion.q]))
    write_amc(folder / "small_03.amc", longer)
    assert read_amc(folder / "small_03.amc").source.numbers.tolist() == list(range(17, 23))
    jumps = read_frames(folder, HEADER + FRAMES.replace("\n3\n", "\n9\n"))
    assert any("not consecutive" in guess for guess in jumps.guesses)
    assert jumps.frames == 3


@pytest.mark.parametrize("fps", [30.0, 120.0, 59.94])
def test_the_rate_survives(folder, fps):
    for header in (HEADER, ":SAMPLES-PER-SECOND 50\n" + HEADER, ":FULLY-SPECIFIED\r\n:DEGREES\r\n"):
        motion = replace(read_frames(folder, header + FRAMES), fps=fps)
        write_amc(folder / "small_02.amc", motion)
        assert read_amc(folder / "small_02.amc").fps == fps


def test_many_frames_are_read_fast(folder):
    rng = np.random.default_rng(0)
    motion = read_frames(folder, HEADER + FRAMES)
    frames = 5000 * 62 // 12  # as many values as 5,000 frames of CMU's 62
    write_amc(folder / "small_02.amc", motion.with_q(rng.normal(size=(frames, 12))))
    start = time.process_time()
    read_amc(folder / "small_02.amc")
    assert time.process_time() - start < 1.0


# ---- real recordings -------------------------------------------------------------------------------------------


def numbers_in(path: Path) -> list[float]:
    lines = (line for line in path.read_text().splitlines() if not line.startswith(("#", ":")))
    return [float(word) for line in lines for word in line.split() if word[0] in "-0123456789"]


@pytest.mark.slow
def test_every_recording_keeps_every_value(data, tmp_path):
    """All CMU files: 62 degrees of freedom, and the same numbers in the same order after a way through us."""
    files = sorted((data / "mocap" / "amc").glob("*/*.amc"))
    assert len(files) > 50
    frames, seconds = 0, 0.0
    for path in files:
        start = time.process_time()
        motion = read_amc(path)
        seconds += time.process_time() - start
        frames += motion.frames
        assert motion.q.shape[1] == 62
        assert motion.present.all()
        assert 1.3 < height(motion.skeleton) < 1.8
        out = tmp_path / path.parent.name / path.name
        out.parent.mkdir(exist_ok=True)
        write_amc(out, motion)
        assert numbers_in(out) == numbers_in(path)
        assert (out.parent / f"{path.parent.name}.asf").read_bytes() == find_asf(path).read_bytes()
    assert seconds / frames * 5000 < 1.0, "5,000 frames take under a second"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("markers", "motion"),
    [("cmu_02_01", "02/02_01"), ("cmu_02_05", "02/02_05"), ("cmu_05_13", "05/05_13")],
)
def test_the_body_follows_the_markers_it_was_made_from(data, markers, motion):
    """CMU's .c3d and .amc of one take: metres, axes and every rotation convention at once."""
    c3d = ezc3d.c3d(str(data / "mocap" / "c3d" / f"{markers}.c3d"))
    labels = [label.split(":")[-1] for label in c3d["parameters"]["POINT"]["LABELS"]["value"]]
    points = c3d["data"]["points"][:3].transpose(2, 1, 0) / 1000  # mm, z up
    recording = read_amc(data / "mocap" / "amc" / f"{motion}.amc")
    joints = positions(recording.skeleton, recording.q)
    pelvis = points[:, [labels.index(n) for n in ("LFWT", "RFWT", "LBWT", "RBWT")]].mean(axis=1)
    root = joints[:, 0]

    correlation = np.corrcoef(root.T, pelvis.T)[:3, 3:]
    distance = np.abs(root.mean(axis=0)[:, None] - pelvis.mean(axis=0)[None]) + np.abs(
        np.ptp(root, axis=0)[:, None] - np.ptp(pelvis, axis=0)[None]
    )
    match = [int(np.argmin(distance[axis])) for axis in range(3)]
    assert sorted(match) == [0, 1, 2]
    for axis in (0, 2):
        assert np.ptp(root[:, axis]) > 0.05
        assert correlation[axis, match[axis]] > 0.98
    points = points[:, :, match]
    for marker, joint in (("LANK", "lfoot"), ("RANK", "rfoot"), ("LELB", "lradius"), ("RELB", "rradius")):
        gap = np.linalg.norm(points[:, labels.index(marker)] - joints[:, recording.skeleton.names.index(joint)], axis=1)
        assert gap.mean() < 0.08, f"{marker} sits on the skin over {joint}"
        assert gap.std() < 0.02, f"{marker} moves with {joint}"
