"""`motionmend report`."""

import base64
import json
import re
from pathlib import Path

import numpy as np
import pytest
from commands import Command, files_below

from motionmend.bodies.camera import Camera, DepthFrame
from motionmend.bodies.postures import Postures
from motionmend.io.depth_folder import write_depth_folder
from motionmend.io.joint_table import write_joint_table
from motionmend.io.png import color_pixels


@pytest.mark.slow
def test_a_page_with_what_is_known_of_a_repair(cli: Command, library: Path, tmp_path: Path) -> None:
    cli("denoise", library / "take.amc", "-m", library / "amc.mend", "-o", tmp_path / "clean.amc")
    files = [library / "take.amc", tmp_path / "clean.amc"]
    ran = cli("report", *files, "-o", tmp_path / "sub" / "page.html")
    assert (ran.code, ran.out) == (0, "")
    page = (tmp_path / "sub" / "page.html").read_text("utf-8")
    assert page.startswith("<!DOCTYPE html>") or page.startswith("<!doctype html>")
    assert "amc.mend" in page
    assert "clean.amc: repaired from" in page
    # Every sample's origin is drawn, as on the page that --report writes.
    done = json.loads((tmp_path / "clean.mend.json").read_text())["counts"]
    assert sum(done[kind] for kind in ("repaired", "filled")) > 0
    for kind, count in done.items():
        assert re.search(rf'class="{kind}"><b>{count:,}</b>', page)
    shown = json.loads(re.search(r'type="application/json"[^>]*>(.*?)</script>', page, re.S)[1])
    assert [one["repaired"] for one in shown["recordings"]] == [False, True]
    assert [one["before"] for one in shown["recordings"]] == [True, False]
    assert "http://" not in page.replace("http://www.w3.org", "")
    assert cli("report", *files, "-o", tmp_path / "again.html").code == 0
    assert (tmp_path / "again.html").read_text("utf-8") == page


@pytest.mark.slow
def test_a_bad_recording_is_told_and_the_page_shows_the_others(cli: Command, library: Path, tmp_path: Path) -> None:
    (tmp_path / "bad.amc").touch()
    ran = cli("report", tmp_path / "bad.amc", library / "take.c3d", "-o", tmp_path / "page.html")
    assert ran.code == 1
    assert len(ran.failures) == 1
    assert "bad.amc" in ran.failures[0]
    assert (tmp_path / "page.html").is_file()
    ran = cli("report", tmp_path / "bad.amc", library / "take.c3d", "-o", tmp_path / "again.html", "--json")
    failed, done = map(json.loads, ran.out.splitlines())
    assert (failed["input"], "error" in failed) == (str(tmp_path / "bad.amc"), True)
    assert done == {"input": str(library / "take.c3d"), "output": str(tmp_path / "again.html")}


def test_a_page_is_not_overwritten_and_never_empty(cli: Command, library: Path, tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    page.write_text("mine")
    ran = cli("report", library / "take.c3d", "-o", page)
    assert (ran.code, len(ran.failures), page.read_text()) == (1, 1, "mine")
    (tmp_path / "bad.amc").touch()
    ran = cli("report", tmp_path / "bad.amc", "-o", tmp_path / "none.html", "--json")
    assert (ran.code, len(ran.out.splitlines()), json.loads(ran.out)["input"]) == (1, 1, str(tmp_path / "bad.amc"))
    assert "none.html not written" in ran.err
    assert files_below(tmp_path) == {"page.html", "bad.amc"}


def test_a_foreign_sidecar_is_one_line(cli: Command, library: Path, tmp_path: Path) -> None:
    cli("denoise", library / "take.c3d", "--method", "linear", "-o", tmp_path / "clean.c3d")
    (tmp_path / "clean.mend.json").write_text("{}")
    ran = cli("report", tmp_path / "clean.c3d", "-o", tmp_path / "page.html")
    assert ran.code == 1
    assert "clean.mend.json" in ran.err


@pytest.mark.slow
def test_the_page_of_a_repair_names_its_method_once(cli: Command, library: Path, tmp_path: Path) -> None:
    command = ["denoise", library / "take.amc", "-m", library / "amc.mend", "-o", tmp_path / "clean.amc", "--report"]
    assert cli(*command).code == 0
    assert (tmp_path / "clean.report.html").read_text("utf-8").count('<th scope="row">method</th>') == 1


def test_a_page_says_that_time_was_left_out_and_how_far_joints_were_moved(cli: Command, tmp_path: Path) -> None:
    times = np.concatenate([np.arange(10), np.arange(100, 110)]) / 30
    table = Postures(("head", "pelvis", "l_wrist"), np.zeros((20, 3, 3)) + np.eye(3), times)
    write_joint_table(tmp_path / "seen.csv", table)
    said = {"output": "seen.csv", "input": "seen.skl", "method": "default", "warnings": []}
    (tmp_path / "seen.mend.json").write_text(json.dumps({**said, "counts": {"empty_frames": 0, "moved_cm": 5.72}}))
    ran = cli("report", tmp_path / "seen.csv", "-o", tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text("utf-8")
    for place in (ran.err, page):
        assert "1 step longer than 1.5 frames, up to 3.03 s" in place
    assert "0 empty frames, moved by 5.72 cm" in page


def test_what_the_camera_saw(cli: Command, tmp_path: Path) -> None:
    camera = Camera(80, 60, 70.0, 70.0, 40.0, 30.0)
    depth = np.full((60, 80), np.nan, np.float32)
    depth[3:36, 30:50] = 2.5
    frames = [DepthFrame(camera, depth, None, k / 30) for k in range(10)]
    write_depth_folder(tmp_path / "take", frames, 30.0)
    at = np.array([[0.0, -0.9, 2.6], [0.0, 0.1, 2.6], [0.2, 0.0, 2.6]])
    for name, way in (("camera", (1, 1, 1)), ("sensor", (1, -1, 1))):
        table = Postures(("head", "pelvis", "l_wrist"), np.tile(at * way, (10, 1, 1)), np.arange(10) / 30)
        write_joint_table(tmp_path / f"{name}.csv", table)
    pages = [tmp_path / "both.html", tmp_path / "again.html"]
    for page in pages:
        ran = cli("report", tmp_path / "take", tmp_path / "camera.csv", tmp_path / "sensor.csv", "-o", page)
        assert ran.code == 0
    text = pages[0].read_text()
    assert text == pages[1].read_text()
    pictures = re.findall(r'src="data:image/png;base64,([^"]+)"', text)
    assert len(pictures) == 8
    (tmp_path / "picture.png").write_bytes(base64.b64decode(pictures[0]))
    picture = color_pixels(tmp_path / "picture.png").astype(int)
    # The sensor's y up was turned: its pose lies on the camera's, drawn last, and none of the first is left beside it.
    second = np.abs(picture - [0xD5, 0x5E, 0x00]).sum(axis=2) < 12
    first = np.abs(picture - [0x00, 0x72, 0xB2]).sum(axis=2) < 12
    assert second.sum() > 150
    assert first.sum() < 0.05 * second.sum()
    assert "frame 0" in text


def damage(image: Path) -> None:
    """Zeros where a PNG holds its pixels, its length and header as they were."""
    whole = image.read_bytes()
    at = whole.index(b"IDAT") + 4
    image.write_bytes(whole[:at] + bytes(8) + whole[at + 8 :])


def test_a_damaged_image_costs_a_report_that_image_alone(cli: Command, tmp_path: Path) -> None:
    """One of colour is done without, one of depth is not shown, and both are said; nothing but those is a failure."""
    camera, take = Camera(64, 48, 60.0, 60.0, 32.0, 24.0), tmp_path / "take"
    color = np.full((48, 64, 3), 90, np.uint8)
    frames = [DepthFrame(camera, np.full((48, 64), 2.0, np.float32), color, k / 30) for k in range(4)]
    write_depth_folder(take, frames, 30.0)
    table = Postures(("head", "pelvis", "l_wrist"), np.tile([0.0, 0.0, 2.0], (4, 3, 1)), np.arange(4) / 30)
    write_joint_table(tmp_path / "take.csv", table)
    for image in (take / "color" / "000001.png", take / "depth" / "000003.png"):
        damage(image)
    ran = cli("report", take, tmp_path / "take.csv", "-o", tmp_path / "r.html")
    assert ran.code == 0, ran.err
    assert (tmp_path / "r.html").read_text().count("data:image/png") == 3
    assert "frame 1 is shown without colour" in ran.err
    assert "frame 3 is not shown" in ran.err
    for image in (take / "depth").iterdir():
        damage(image)
    ran = cli("report", take, tmp_path / "take.csv", "-o", tmp_path / "s.html")
    assert (ran.code, len(ran.failures)) == (1, 1)
    assert "no image can be shown" in ran.failures[0]


def test_a_depth_folder_that_cannot_be_read_is_a_line(cli: Command, library: Path, tmp_path: Path) -> None:
    (tmp_path / "take" / "depth").mkdir(parents=True)
    ran = cli("report", tmp_path / "take", library / "clean.amc", "-o", tmp_path / "r.html")
    assert (ran.code, len(ran.failures)) == (1, 1)
    assert "camera.json" in ran.failures[0]


def test_images_alone_are_no_page_and_what_to_give_is_said(cli: Command, tmp_path: Path) -> None:
    camera = Camera(8, 6, 7.0, 7.0, 4.0, 3.0)
    write_depth_folder(tmp_path / "take", [DepthFrame(camera, np.ones((6, 8), np.float32), None, 0.0)], 30.0)
    ran = cli("report", tmp_path / "take", "-o", tmp_path / "r.html")
    assert (ran.code, len(ran.failures)) == (1, 1)
    assert str(tmp_path / "take") in ran.failures[0]
    assert "tracked" in ran.failures[0]
    assert not (tmp_path / "r.html").exists()
