"""Correcting in processes of their own: the same answers, and a process that ends takes nobody with it."""

import gc
import os
import signal
import socket
import sys
import time

import numpy as np
import pytest
from running import HELLO, ask, client, frame, pack, running, singles

from motionmend.bodies.joint_sets import KINECT20, KINECT25
from motionmend.live import staff
from motionmend.live.staff import _packed, _unpacked
from motionmend.live.warm import standing


def test_what_is_said_on_a_line_comes_whole_and_in_order_however_it_is_cut():
    said = [(k, b"x" * size) for k, size in enumerate((0, 1, 300, 70_000, 3))]
    data = b"".join(map(_packed, said))
    for piece in (1, 3, 7, 1_000, len(data)):
        heard, found = bytearray(), []
        for at in range(0, len(data), piece):
            heard += data[at : at + piece]
            found += _unpacked(heard)
        assert found == said
        assert not heard


@pytest.mark.slow
def test_who_is_ready_when_the_server_has_gone_goes_without_a_word(model, monkeypatch):
    monkeypatch.setattr(signal, "signal", lambda *_: None)
    ours, theirs = socket.socketpair()
    ours.close()
    staff._work(model, False, 0.0, theirs)
    gc.unfreeze()
    assert theirs.fileno() == -1


@pytest.mark.slow
def test_processes_answer_as_the_server_itself_and_are_replaced_when_they_end(model):
    said: list[str] = []
    joints = [(standing(KINECT20) + 0.01 * k).astype(np.float32) for k in range(12)]
    with running(model) as own, client(own.url) as connection:
        wanted = [singles(ask(connection, frame(k, p))["joints"]) for k, p in enumerate(joints)]
    with running(model, jobs=1, say=said.append) as live, client(live.url) as one, client(live.url) as other:
        for k, p in enumerate(joints):
            assert singles(ask(one, frame(k, p))["joints"]) == pytest.approx(wanted[k], abs=1e-6)
            assert singles(ask(other, frame(k, p))["joints"]) == pytest.approx(wanted[k], abs=1e-6)
        assert "at least 4 joints" in ask(other, {**HELLO, "skeleton": "named", "names": ["a", "b"]})["error"]
        other.send(pack({**HELLO, "skeleton": "kinect25"}))
        assert ask(other, frame(0, standing(KINECT25)))["seq"] == 0
        if sys.platform == "win32":
            return
        os.kill(live.server._desk._processes[0].pid, signal.SIGKILL)
        answer = ask(one, frame(20, joints[0]))
        assert "ended" in answer["error"]
        deadline = time.monotonic() + 60
        while "error" in (answer := ask(one, frame(21, joints[0]))):
            assert time.monotonic() < deadline, answer
            time.sleep(0.2)
        assert singles(answer["joints"]) == pytest.approx(wanted[0], abs=1e-6)
    assert len(said) == 1
    assert "another takes its place" in said[0]
