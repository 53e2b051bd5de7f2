"""A second process looks back: the same estimates, whatever becomes of it."""

import multiprocessing
import sys
from dataclasses import replace
from importlib.machinery import ModuleSpec
from types import ModuleType

import numpy as np
import pytest

from motionmend.bodies import anatomy
from motionmend.bodies.camera import Camera, DepthFrame
from motionmend.bodies.performer import standing
from motionmend.bodies.surface import render
from motionmend.cli.looking_back import WORTH, revised_beside, second_process
from motionmend.cli.options import Working
from motionmend.evaluate.sensor import sensed
from motionmend.track.database import PoseDatabase
from motionmend.track.hindsight.backwards import AHEAD, WINDOW, moment, revised
from motionmend.track.model import TrackerModel
from motionmend.track.settings import settings_of
from motionmend.track.tracker import start, step

BODY, CAMERA, DEFAULT = anatomy.average(), Camera(80, 60, 71.4, 71.4, 40.0, 30.0), settings_of("default")


@pytest.fixture(scope="module")
def followed():
    """A model, and what the tracker said of somebody who sways for three stretches and a half."""
    poses = [standing((x, 0.1, 2.6)) for x in 0.15 * np.sin(np.arange(40) * 2 * np.pi / 40)]
    joints = np.array([pose.joints for pose in poses])
    model = TrackerModel(PoseDatabase(joints, np.full(len(joints), len(joints) - 1)))
    frames = [
        DepthFrame(CAMERA, sensed(render(BODY, poses[t % 40], CAMERA).depth, CAMERA, 1, t), None, t / 30.0)
        for t in range(2 * WINDOW + AHEAD + WINDOW // 2)
    ]
    state, moments = start(model, DEFAULT, frames[0], BODY, poses[0]), []
    for frame in frames:
        state, estimate = step(model, DEFAULT, state, frame)
        moments.append(moment(state, estimate))
    return model, moments


@pytest.fixture(scope="module")
def alone(followed):
    """What one process says of it in hindsight."""
    model, moments = followed
    return list(revised(model, DEFAULT, moments))


def same(ones, others):
    assert len(ones) == len(others)
    for one, other in zip(ones, others, strict=True):
        assert one.flags == other.flags
        np.testing.assert_array_equal(one.landmarks, other.landmarks)
        np.testing.assert_array_equal(one.std, other.std)
        np.testing.assert_array_equal(one.pose.joints, other.pose.joints)


@pytest.mark.slow
def test_a_second_process_says_the_same_in_the_same_order(followed, alone):
    model, moments = followed
    with second_process(WORTH, idle=True) as other:
        assert other is not None
        asked = []

        class Heard:
            def submit(self, call, *args):
                asked.append(other.submit(call, *args))
                return asked[-1]

        said = list(revised_beside(Heard(), model, DEFAULT, iter(moments)))
    same(said, alone)
    assert len(asked) == 2  # the last stretch is looked back at here, the others there
    assert all(future.exception() is None for future in asked)


@pytest.mark.slow
def test_a_process_that_is_killed_costs_no_frame(followed, alone):
    model, moments = followed
    with second_process(WORTH, idle=True) as other:

        def killing():
            for t, one in enumerate(moments):
                if t == WINDOW + AHEAD + 1:
                    (child,) = multiprocessing.active_children()
                    child.kill()
                yield one

        said = list(revised_beside(other, model, DEFAULT, killing()))
    same(said, alone)


@pytest.mark.slow
def test_nobody_looks_back_where_no_processor_is_idle_or_little_is_to_be_done(followed):
    model, moments = followed
    alone = list(revised(model, DEFAULT, moments[:10]))
    for frames, idle in ((WORTH, False), (WORTH - 1, True)):
        with second_process(frames, idle=idle) as other:
            assert other is None
            said = list(revised_beside(other, model, DEFAULT, iter(moments[:10])))
        same(said, alone)
        assert not multiprocessing.active_children()


@pytest.mark.parametrize("started", ["python -m motionmend", "motionmend"])
def test_two_processors_for_each_recording_are_needed(monkeypatch, started):
    command = ModuleType("__main__")
    if started == "motionmend":
        command.__file__ = "/usr/local/bin/motionmend"
    else:
        command.__spec__ = ModuleSpec("motionmend.__main__", None)
    monkeypatch.setitem(sys.modules, "__main__", command)
    assert Working(jobs=2).idle(1)
    assert Working(jobs=4).idle(2)
    assert not Working(jobs=1).idle(1)
    assert not Working(jobs=4).idle(3)
    assert not Working(jobs=4, cluster="tcp://127.0.0.1:8786").idle(1)


def test_a_script_that_calls_the_command_is_not_run_again_by_another_process(monkeypatch):
    script = ModuleType("__main__")
    monkeypatch.setitem(sys.modules, "__main__", script)
    for file in ("/home/anna/all_takes.py", None):
        script.__file__ = file
        assert not Working(jobs=2).idle(1)
    script.__spec__ = ModuleSpec("takes.motionmend", None)
    assert not Working(jobs=2).idle(1)


@pytest.mark.slow
def test_without_looking_back_estimates_come_as_they_are(followed):
    model, moments = followed
    plain = replace(DEFAULT, hindsight=False)
    with second_process(WORTH, idle=True) as other:
        said = list(revised_beside(other, model, plain, iter(moments[:10])))
    assert [id(one) for one in said] == [id(one.estimate) for one in moments[:10]]
