"""`motionmend view`: what is shown is the recording, on this machine only, and Ctrl-C ends all of it."""

import os
import re
import signal
import socket
import subprocess
import sys
from pathlib import Path
from urllib.request import urlopen

import numpy as np
import pytest

from motionmend import samples, view
from motionmend.bodies.motion import Markers
from motionmend.io import write


@pytest.fixture(scope="module")
def walk(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("view") / "walk.bvh"
    write(file, samples.clip("walk", seconds=1.0, seed=2))
    return file


def test_without_the_extra_it_says_how_to_get_it(cli, walk: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(view, "find_spec", lambda _: None)
    ran = cli("view", walk)
    assert ran.code == 1
    assert "pip install 'motionmend[view]'" in ran.failures[0]


def test_a_port_that_is_none_is_bad_usage(cli, walk: Path) -> None:
    assert cli("view", walk, "--port", "70000").code == 2


def test_up_is_turned_to_z() -> None:
    rng = np.random.default_rng(0)
    for up in (*np.eye(3), *-np.eye(3), *rng.normal(size=(5, 3))):
        turn = view.upward(up)
        np.testing.assert_allclose(turn @ up, [0.0, 0.0, np.linalg.norm(up)], atol=1e-12)
        assert np.linalg.det(turn) == pytest.approx(1.0)


def test_a_scene_holds_every_point_that_is_there(tmp_path: Path) -> None:
    pytest.importorskip("rerun", reason="the extra `view` is not installed")
    rng = np.random.default_rng(1)
    markers = Markers(("LASI", "RASI", "C7"), rng.normal(size=(7, 3, 3)), 100.0, up=np.array([0.0, 1.0, 0.0]))
    gone = markers.positions.copy()
    gone[2:4, 1] = np.nan
    gone[5] = np.nan
    motion = samples.clip("walk", seconds=0.1, seed=2)
    file = tmp_path / "scene.rrd"
    view.write_scene(file, [("gaps", Markers(markers.names, gone, 100.0, up=markers.up)), ("walk", motion)])
    shown = subprocess.run(
        [view._program(), "rrd", "print", "-vvv", str(file)], capture_output=True, text=True, check=True
    )
    rows: dict[str, int] = {}  # colours and sizes stand in a row of their own
    for count, entity in re.findall(r"with (\d+) rows .*? - (/\w+/\w+) -", shown.stdout):
        rows[entity] = max(rows.get(entity, 0), int(count))
    assert rows == {f"/gaps/{one}": 7 for one in ("points", "lines")} | {
        f"/walk/{one}": motion.frames for one in ("points", "lines")
    }
    drawn = [line for line in shown.stdout.splitlines() if "LASI" in line and "row_" in line]
    assert len(drawn) == 6  # of seven frames one has no marker
    assert sum("RASI" in line for line in drawn) == 4


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="signals of Unix")
def test_it_serves_this_machine_and_ctrl_c_ends_it(walk: Path, tmp_path: Path) -> None:
    pytest.importorskip("rerun", reason="the extra `view` is not installed")
    command = [sys.executable, "-m", "motionmend", "view", str(walk), "--port", "0"]
    environment = {**os.environ, "TMPDIR": str(tmp_path)}
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=environment) as process:
        assert process.stderr is not None
        found = None
        while not found:
            line = process.stderr.readline()
            assert line, "the viewer ended"
            found = re.search(r"(http://127\.0\.0\.1:\d+/)\?url=\S+A(\d+)%2F", line)
        with urlopen(found[1], timeout=20) as page:
            assert b"rerun" in page.read().lower()
            policy = page.headers["Content-Security-Policy"]
        assert "https:" not in policy
        socket.create_connection(("127.0.0.1", int(found[2])), 5).close()
        process.send_signal(signal.SIGINT)
        assert process.wait(20) == 0
    with pytest.raises(OSError, match="refused"):
        socket.create_connection(("127.0.0.1", int(found[2])), 5)
    assert not list(tmp_path.iterdir())
