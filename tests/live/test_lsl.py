"""What a laboratory's recorder finds: a stream of type MoCap whose description names every channel."""

import time
import weakref

import numpy as np
import pytest
from running import ask, client, frame, running

from motionmend.bodies.joint_sets import KINECT20
from motionmend.live.messages import Answer, Frame, Hello
from motionmend.live.warm import standing

pylsl = pytest.importorskip("pylsl", reason="pylsl is not installed")


@pytest.fixture(scope="module", autouse=True)
def near(tmp_path_factory):
    """Streams of this machine alone, found without a network."""
    import os

    settings = tmp_path_factory.mktemp("lsl") / "lsl_api.cfg"
    settings.write_text("[multicast]\nResolveScope = machine\n[lab]\nKnownPeers = {127.0.0.1}\n")
    os.environ["LSLAPICFG"] = str(settings)


@pytest.mark.slow
def test_a_recorder_finds_the_stream_its_channels_and_its_frames(model):
    from motionmend.live.lsl import Laboratory

    joints = standing(KINECT20).astype(np.float32)
    name = "mended in a test"
    with running(model, listeners=[Laboratory(name)]) as live, client(live.url) as connection:
        ask(connection, frame(0, joints))
        found = pylsl.resolve_byprop("name", name, timeout=10)
        assert found, "the stream was not found on this machine"
        inlet = pylsl.StreamInlet(found[0])
        info = inlet.info(timeout=10)
        assert (info.type(), info.channel_count(), info.nominal_srate()) == ("MoCap", 80, 30.0)
        labels, channel = [], info.desc().child("channels").child("channel")
        while not channel.empty():
            labels.append(channel.child_value("label"))
            channel = channel.next_sibling()
        assert labels[:4] == ["HipCenter_x", "HipCenter_y", "HipCenter_z", "Spine_x"]
        assert labels[-1] == "FootRight_reliability"
        assert len(labels) == 80
        inlet.open_stream(timeout=10)
        for k in range(1, 100):
            answer = ask(connection, frame(k, joints))
            sample, stamp = inlet.pull_sample(timeout=0.2)
            if sample is not None:
                break
        assert np.array(sample[:60]) == pytest.approx(np.frombuffer(answer["joints"], "<f4"), abs=0.05)
        assert abs(stamp + inlet.time_correction(timeout=10) - pylsl.local_clock()) < 5.0
        inlet.close_stream()


def test_every_client_has_a_stream_of_its_own():
    from motionmend.live.lsl import Laboratory

    laboratory = Laboratory("another test")
    hello = Hello("kinect20", KINECT20.names, 30.0)
    for client_number in (1, 2):
        laboratory.opened(client_number, hello)
    names = [outlet.get_info().name() for _, outlet in laboratory._outlets.values()]
    assert names == ["another test", "another test-2"]
    joints = standing(KINECT20)
    answer = Answer(0, 0.0, 0.0, joints, np.ones(20), np.ones(20), ())
    laboratory.frame(1, Frame(0, 0.0, joints, None, "msgpack"), answer)
    laboratory.closed(1)
    laboratory.opened(3, hello)
    names = [outlet.get_info().name() for _, outlet in laboratory._outlets.values()]
    assert sorted(names) == ["another test", "another test-2"]


def test_a_crowd_that_leaves_delays_nobody_and_its_streams_end():
    from motionmend.live.lsl import Laboratory

    laboratory = Laboratory("a crowd")
    for client_number in range(20):
        laboratory.opened(client_number, Hello("kinect20", KINECT20.names, 30.0))
    outlets = [weakref.ref(outlet) for _, outlet in laboratory._outlets.values()]
    began = time.perf_counter()
    for client_number in range(20):
        laboratory.closed(client_number)
    assert time.perf_counter() - began < 0.25  # LSL itself takes half a second
    laboratory._ending.shutdown()
    assert not any(outlet() for outlet in outlets)
