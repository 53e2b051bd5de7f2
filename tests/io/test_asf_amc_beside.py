"""Which .asf belongs to an .amc: the one beside it, or the one that is given."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from acclaim_files import ASF, FRAMES, HEADER, UNIT, read_frames
from scipy.spatial.transform import Rotation

from motionmend.bodies.motion import Motion
from motionmend.bodies.skeleton import height, positions, same
from motionmend.errors import FileError, MismatchError
from motionmend.io.acclaim import asf_of
from motionmend.io.amc import find_asf, read_amc, write_amc
from motionmend.io.asf import parse_asf, skeleton_of
from skeletons import random_skeleton


def test_which_skeleton_belongs(tmp_path):
    motion = tmp_path / "02_01.amc"
    with pytest.raises(FileError, match=r"02_01\.asf or 02\.asf .* found none; name one with --skeleton"):
        find_asf(motion)
    (tmp_path / "other.ASF").write_text(ASF)
    assert find_asf(motion).name == "other.ASF"
    (tmp_path / "copy.asf").write_text(ASF)
    assert find_asf(motion).name == "copy.asf"  # the same skeleton twice is one
    (tmp_path / "another.asf").write_text(ASF.replace("length 14", "length 13"))
    with pytest.raises(FileError, match="3 others"):
        find_asf(motion)
    (tmp_path / "02.asf").write_text(ASF)
    assert find_asf(motion).name == "02.asf"
    (tmp_path / "02_01.asf").write_text(ASF)
    assert find_asf(motion).name == "02_01.asf"


def test_a_written_motion_can_always_be_read_again(folder, tmp_path_factory):
    out = tmp_path_factory.mktemp("out")
    motion = read_frames(folder, HEADER + FRAMES)
    write_amc(out / "small_01.amc", motion)
    assert (out / "small.asf").read_text() == ASF
    write_amc(out / "other.amc", motion)  # whatever skeleton comes to lie beside it later
    assert sorted(p.name for p in out.iterdir()) == ["other.amc", "other.asf", "small.asf", "small_01.amc"]
    (folder / "small.asf").write_text(ASF.replace("length 14", "length 13"))
    changed = read_frames(folder, HEADER + FRAMES)
    write_amc(out / "small_02.amc", changed)  # small.asf is taken by another body
    assert (out / "small_02.asf").exists()
    assert height(read_amc(out / "small_02.amc").skeleton) == pytest.approx(28 * UNIT)
    assert height(read_amc(out / "small_01.amc").skeleton) == pytest.approx(29 * UNIT)
    (out / "other.amc").unlink()  # whose other.asf is then, nobody knows
    with pytest.raises(FileError, match=r"other\.asf beside it, which holds another one"):
        write_amc(out / "other.amc", changed)


def test_a_motion_that_is_written_over_takes_its_skeleton_with_it_and_no_other_s(folder, tmp_path_factory):
    out = tmp_path_factory.mktemp("out")
    motion = read_frames(folder, HEADER + FRAMES)
    (folder / "small.asf").write_text(ASF.replace("length 14", "length 13"))
    changed = read_frames(folder, HEADER + FRAMES)
    write_amc(out / "walk.amc", motion)
    write_amc(out / "walk.amc", changed)
    assert sorted(p.name for p in out.iterdir()) == ["walk.amc", "walk.asf"]
    assert height(read_amc(out / "walk.amc").skeleton) == pytest.approx(28 * UNIT)
    write_amc(out / "walk_2.amc", changed)
    assert sorted(p.name for p in out.iterdir()) == ["walk.amc", "walk.asf", "walk_2.amc"]
    with pytest.raises(FileError, match=r"walk\.asf beside it, which holds another one"):
        write_amc(out / "walk.amc", motion)
    assert height(read_amc(out / "walk_2.amc").skeleton) == pytest.approx(28 * UNIT)


def test_any_skeleton_acclaim_can_express(tmp_path):
    """Random perpendicular axes, children at different places: the same movement after a way through files."""
    for seed in range(10):
        rng = np.random.default_rng(seed)
        plain = random_skeleton(rng, joints=6, translations=False)
        owners = np.sort(np.r_[[0] * 6, rng.permutation(np.repeat(np.arange(1, 6), 3))[:8]])
        frames = [Rotation.random(rng=rng).as_matrix() for _ in range(6)]
        counted = [int((owners[:d] == j).sum()) for d, j in enumerate(owners)]
        axes = [np.eye(3)[n % 3] if j == 0 else frames[j][:, n] for j, n in zip(owners, counted, strict=True)]
        skeleton = replace(
            plain,
            dof_names=tuple(f"j{j}.d{n}" for j, n in zip(owners, counted, strict=True)),
            dof_joint=owners,
            dof_axis=np.array(axes),
            dof_kind=np.array([1, 1, 1, *[0] * (len(owners) - 3)]),
            limits=np.sort(rng.normal(size=(len(owners), 2))),
        )
        motion = Motion(skeleton, rng.normal(size=(3, len(owners))), 30.0)
        write_amc(tmp_path / f"r{seed}.amc", motion)
        again = read_amc(tmp_path / f"r{seed}.amc")
        assert again.fps == 30
        found = positions(again.skeleton, again.q)
        wanted = positions(skeleton, motion.q)
        for j, name in enumerate(("root", *skeleton.names[1:])):
            np.testing.assert_allclose(found[:, again.skeleton.names.index(name)], wanted[:, j], atol=1e-8)
        assert sorted(np.ravel(again.skeleton.limits)) == pytest.approx(
            sorted([*np.ravel(skeleton.limits[6:]), *[-np.inf] * 6, *[np.inf] * 6])
        )


def test_an_acclaim_skeleton_stays_itself():
    skeleton = skeleton_of(parse_asf(ASF, Path("small.asf")))
    again = asf_of(skeleton)
    assert same(skeleton_of(again), skeleton)
    assert not any("length" in guess for guess in again.guesses), "our own files state their unit"
    tiny = replace(skeleton, offsets=skeleton.offsets * 0.01)
    assert same(skeleton_of(asf_of(tiny)), tiny)


def test_what_acclaim_cannot_express_is_one_line(rng):
    skeleton = skeleton_of(parse_asf(ASF, Path("small.asf")))
    leg = skeleton.dof_names.index("leg.rz")
    oblique = np.array(skeleton.dof_axis)
    oblique[leg] = np.array([1.0, 1, 1]) / np.sqrt(3)
    kinds = np.array(skeleton.dof_kind)
    kinds[leg + 1] = 1
    spaced = tuple(name.replace("leg", "my leg") for name in skeleton.names)
    for wrong, message in (
        (replace(skeleton, dof_axis=oblique), "joint leg has 2 axes that are not perpendicular"),
        (replace(skeleton, dof_kind=kinds), "joint leg moves after it turns"),
        (replace(skeleton, names=spaced), "joint name 'my leg' cannot stand in an .asf"),
        (replace(skeleton, parents=np.where(skeleton.parents == 1, -1, skeleton.parents)), "has 2"),
    ):
        with pytest.raises(MismatchError, match=message) as failure:
            asf_of(wrong)
        assert "\n" not in str(failure.value)


def test_a_motion_that_cannot_be_written_leaves_no_skeleton(folder, tmp_path_factory, monkeypatch):
    out = tmp_path_factory.mktemp("out")
    motion = read_frames(folder, HEADER + FRAMES)

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("motionmend.io.amc._stating", full)
    with pytest.raises(FileError, match=r"a\.amc: cannot be written: No space left"):
        write_amc(out / "a.amc", motion)
    assert list(out.iterdir()) == []


def test_hidden_files_are_no_skeletons(tmp_path):
    (tmp_path / "02.asf").write_text(ASF)
    (tmp_path / "._other.asf").write_text("notes of another system")
    (tmp_path / ".0123456789ab.asf").write_text("half writ")
    assert find_asf(tmp_path / "walk.amc").name == "02.asf"
