"""`serve` in a process of its own, `stream` into it, and what both say when something is missing."""

import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from motionmend import samples
from motionmend.bodies.joint_sets import KINECT20, correspondence
from motionmend.bodies.postures import Postures
from motionmend.bodies.skeleton import positions
from motionmend.correct import Corrector, Pair
from motionmend.io.joint_table import read_joint_table, write_joint_table
from motionmend.models import save_model

SLOWLY = ("--speed", "0.5")  # a machine that is busy with other things answers all frames even so


@pytest.fixture(scope="module")
def seen() -> Postures:
    """A second of a walk as a sensor might see it, one joint missing for a while."""
    clip = samples.clip("walk", seconds=1.0, seed=3)
    truth = positions(clip.skeleton, clip.q)[::4, correspondence(clip.skeleton.names, KINECT20.names)]
    state = np.full(truth.shape[:2], 2, np.uint8)
    sensor = truth + np.random.default_rng(0).normal(0, 0.01, truth.shape)
    sensor[10:20, 7], state[10:20, 7] = np.nan, 0
    return Postures(KINECT20.names, sensor, np.arange(len(truth)) / 30.0, state=state)


@pytest.fixture(scope="module")
def model(seen: Postures, tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("live") / "sensor.mend"
    clean = Postures(seen.names, np.nan_to_num(seen.positions), seen.times)
    save_model(file, Corrector(points=30).fit([Pair(clean, clean.with_positions(clean.positions + 0.02))]))
    return file


@pytest.fixture
def server(model: Path):
    """`motionmend serve` on a free port: the process and its address."""
    command = [sys.executable, "-m", "motionmend", "serve", "-m", str(model), "--listen", "ws://127.0.0.1:0"]
    with subprocess.Popen([*command, "--jobs", "0"], stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        found = None
        while not found:
            line = process.stderr.readline()
            assert line, "the server ended"
            found = re.search(r"ws://\S+", line)
        yield process, found[0]
        process.kill()


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="signals of Unix")
def test_a_recording_is_streamed_corrected_and_the_server_ends_well(server, seen, cli, tmp_path):
    process, url = server
    recording, out = tmp_path / "take.csv", tmp_path / "answers.csv"
    write_joint_table(recording, seen)
    ran = cli("stream", recording, "--to", url, "-o", out, "--json", *SLOWLY)
    assert (ran.code, ran.failures) == (0, [])
    facts = json.loads(ran.out)
    assert (facts["frames"], facts["answered"], facts["lost"], facts["refused"]) == (30, 30, 0, 0)
    assert 0 < facts["round_trip_ms"]["p50"] <= facts["round_trip_ms"]["p95"] <= facts["round_trip_ms"]["p99"]
    answers = read_joint_table(out)
    assert answers.names == seen.names
    assert answers.times == pytest.approx(seen.times)
    assert answers.reliability is not None
    assert np.isfinite(answers.positions).all()
    text = cli("stream", recording, "--to", url, "-o", tmp_path / "text.csv", "--text", *SLOWLY)
    assert text.code == 0
    assert read_joint_table(tmp_path / "text.csv").positions == pytest.approx(answers.positions, abs=1e-4)
    again = cli("stream", recording, "--to", url, "-o", out)
    assert again.code == 1
    assert "--force" in again.failures[0]
    process.send_signal(signal.SIGTERM)
    said = process.communicate(timeout=30)[1]
    assert process.returncode == 0
    assert "stopped: 2 clients, 60 frames, 0 dropped, 0 errors" in said
    assert "Traceback" not in said
    gone = cli("stream", recording, "--to", url)
    assert gone.code == 1
    assert "no server answers there" in gone.failures[0]


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="signals of Unix")
def test_ctrl_c_ends_the_server_well(server):
    process, _ = server
    os.kill(process.pid, signal.SIGINT)
    process.wait(timeout=30)
    assert process.returncode == 0


@pytest.mark.parametrize("module", ["websockets", "msgpack"])
def test_without_the_extra_one_line_names_it(module, model, cli, monkeypatch, tmp_path, seen):
    for name in [name for name in sys.modules if name.partition(".")[0] == module]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, module, None)
    write_joint_table(tmp_path / "take.csv", seen)
    for command in (["serve", "-m", model], ["stream", tmp_path / "take.csv", "--to", "ws://127.0.0.1:9"]):
        ran = cli(*command)
        assert ran.code == 1
        assert len(ran.failures) == 1
        assert "motionmend[live]" in ran.failures[0]


@pytest.mark.parametrize(("option", "module"), [(["--lsl", "x"], "pylsl"), (["--vmc", "127.0.0.1:39539"], "pythonosc")])
def test_a_way_out_without_its_library_names_the_extra(option, module, model, cli, monkeypatch):
    monkeypatch.setitem(sys.modules, module, None)
    ran = cli("serve", "-m", model, *option)
    assert ran.code == 1
    assert "motionmend[live]" in ran.failures[0]


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["--listen", "http://127.0.0.1:80"], "--listen"),
        (["--listen", "ws://127.0.0.1:99999"], "--listen"),
        (["--listen", "127.0.0.1"], "--listen"),
        (["--vmc", "nowhere"], "--vmc"),
        (["--vmc", "127.0.0.1:0"], "--vmc"),
        (["--lsl", " "], "--lsl"),
        (["--jobs", "-1"], "--jobs"),
    ],
)
def test_options_that_make_no_sense_are_bad_usage(arguments, word, model, cli):
    ran = cli("serve", "-m", model, *arguments)
    assert ran.code == 2
    assert word in ran.failures[0]


def test_another_model_and_a_file_that_is_none_are_refused(library, cli, tmp_path):
    ran = cli("serve", "-m", library / "amc.mend")
    assert ran.code == 1
    assert "corrector" in ran.failures[0]
    ran = cli("serve", "-m", tmp_path / "none.mend")
    assert ran.code == 1
    assert "none.mend" in ran.failures[0]


def test_a_recording_that_was_cut_off_is_said_to_be(seen, cli, tmp_path):
    recording = tmp_path / "take.skl"
    rows = [np.column_stack([row, np.full(20, 2)]).ravel() for row in np.nan_to_num(seen.positions)]
    lines = ["\t".join([str(33 * t), *(f"{value:.4f}" for value in row)]) for t, row in enumerate(rows)]
    titles = ["Timestamp", *(f"{name}_{what}" for name in seen.names for what in ("X", "Y", "Z", "State"))]
    recording.write_text("\n".join(["\t".join(titles), *lines])[:-100])
    ran = cli("stream", recording, "--to", "ws://127.0.0.1:9")
    assert ran.code == 1
    assert "cut off" in ran.err


def test_a_recording_that_is_none_is_refused_by_its_name(cli, tmp_path):
    (tmp_path / "empty.csv").write_text("")
    ran = cli("stream", tmp_path / "empty.csv", "--to", "ws://127.0.0.1:9")
    assert ran.code == 1
    assert "empty.csv" in ran.failures[0]
    assert cli("stream", tmp_path / "empty.csv", "--to", "tcp://x").code == 2


def test_a_failure_is_an_object_in_json_too(cli, seen, tmp_path):
    write_joint_table(tmp_path / "take.csv", seen)
    for name, word in (("none.csv", "no such file"), ("take.csv", "no server answers")):
        ran = cli("stream", tmp_path / name, "--to", "ws://127.0.0.1:9", "--json")
        assert ran.code == 1
        assert len(ran.failures) == 1
        told = json.loads(ran.out)
        assert told["input"] == str(tmp_path / name)
        assert word in told["error"]


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="signals of Unix")
def test_a_recording_of_which_every_frame_is_refused_is_said_to_have_failed(server, seen, cli, tmp_path):
    """In millimetres."""
    write_joint_table(tmp_path / "take.csv", Postures(seen.names, 1000.0 * seen.positions[:4], seen.times[:4]))
    ran = cli("stream", tmp_path / "take.csv", "--to", server[1], "--json", *SLOWLY)
    assert ran.code == 1
    assert len(ran.failures) == 1
    assert "take.csv" in ran.failures[0]
    assert "millimetres" in ran.failures[0]
