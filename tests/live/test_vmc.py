"""What an avatar's receiver hears: OSC bundles over UDP, read by another library's parser."""

import socket

import numpy as np
import pytest
from pythonosc.osc_bundle import OscBundle
from running import HELLO, ask, client, frame, pack, running

from motionmend.bodies.joint_sets import AZURE32, KINECT20, KINECT25
from motionmend.live.address import Address
from motionmend.live.messages import Hello
from motionmend.live.vmc import Avatar, Stage, datagrams
from motionmend.live.warm import standing

# UnityEngine.HumanBodyBones
BONES = {"Hips", "Spine", "Chest", "Neck", "Head"} | {
    f"{side}{bone}"
    for side in ("Left", "Right")
    for bone in ("Shoulder", "UpperArm", "LowerArm", "Hand", "UpperLeg", "LowerLeg", "Foot")
}


@pytest.fixture
def receiver():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as found:
        found.bind(("127.0.0.1", 0))
        found.settimeout(10)
        yield found


def heard(datagram):
    assert OscBundle.dgram_is_bundle(datagram)
    return [(message.address, message.params) for message in OscBundle(datagram)]


def one_frame(receiver):
    """All messages up to the last bone of a frame."""
    found = []
    while not any(params[:1] == ["RightFoot"] for _, params in found):
        datagram = receiver.recv(65_536)
        assert len(datagram) < 1400
        found += heard(datagram)
    return found


@pytest.mark.parametrize("joint_set", [KINECT20, KINECT25, AZURE32], ids=lambda one: one.key)
def test_every_bone_of_the_humanoid_is_sent_with_a_unit_quaternion(joint_set):
    stage = Stage(Hello(joint_set.key, joint_set.names, 30.0))
    found = datagrams(stage.bones(standing(joint_set)), 1.5)
    assert len(found) > 1
    assert all(len(datagram) < 1400 for datagram in found)
    messages = [message for datagram in found for message in heard(datagram)]
    assert messages[:2] == [("/VMC/Ext/OK", [1]), ("/VMC/Ext/T", [1.5])]
    assert messages[2] == ("/VMC/Ext/Root/Pos", ["root", 0, 0, 0, 0, 0, 0, 1])
    bones = [params for path, params in messages if path == "/VMC/Ext/Bone/Pos"]
    assert {params[0] for params in bones} == BONES
    for _, *numbers in bones:
        assert len(numbers) == 7
        assert np.linalg.norm(numbers[3:]) == pytest.approx(1, abs=1e-5)
    hips = next(params for params in bones if params[0] == "Hips")
    assert hips[1] == pytest.approx(0, abs=1e-6)
    assert 0.7 < hips[2] < 1.2  # above the floor under the feet
    assert hips[3] == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("turn", ["xyz", "zxy", "yzx", "xZy", "xyZ", "XYz", "zyX", "Xzy"])
def test_joints_that_only_have_names_stand_whatever_axis_is_up(turn):
    """Capitals are axes that point the other way; those of a mirror are none of a sensor's."""
    signed = np.array([[(axis == one.lower()) * (1 if one.islower() else -1) for axis in "xyz"] for one in turn])
    signed[2] *= round(np.linalg.det(signed))
    joints = standing(KINECT25) @ signed.T
    bones = {one.name: one for one in Stage(Hello("named", KINECT25.names, 30.0)).bones(joints)}
    x, _, z, _ = bones["Hips"].rotation
    assert 1 - 2 * (x * x + z * z) > 0.95  # the hips' y axis points up
    assert 0.7 < bones["Hips"].place[1] < 1.2
    assert bones["Head"].place[1] > 0


def test_who_lies_before_a_known_sensor_lies():
    joints = standing(KINECT25)[:, [1, 0, 2]] * [1, -1, 1]
    hips = Stage(Hello("kinect25", KINECT25.names, 30.0)).bones(joints)[0].rotation
    assert abs(1 - 2 * (hips[0] ** 2 + hips[2] ** 2)) < 0.1


def test_nobody_there_is_said():
    stage = Stage(Hello("kinect20", KINECT20.names, 30.0))
    [datagram] = datagrams(stage.bones(np.full((20, 3), np.nan)), 0.0)
    assert heard(datagram)[0] == ("/VMC/Ext/OK", [0])


def test_the_floor_follows_the_lowest_foot():
    stage = Stage(Hello("kinect20", KINECT20.names, 30.0))
    joints = standing(KINECT20)
    stage.bones(joints + np.array([0, 0.2, 0]))  # the first frame is a jump
    for _ in range(60):
        bones = stage.bones(joints)
    assert bones[0].place[1] == pytest.approx(joints[0, 1] - joints[:, 1].min(), abs=0.01)


def test_the_first_client_is_sent_and_when_it_leaves_the_next(model, receiver):
    joints = standing(KINECT20).astype(np.float32)
    avatar = Avatar(Address(*receiver.getsockname()))
    with running(model, listeners=[avatar]) as live, client(live.url) as second:
        with client(live.url) as first:
            ask(second, frame(0, joints))  # the second to connect to the server below is the first here
            one_frame(receiver)
            ask(first, frame(0, joints))
            ask(second, frame(1, joints))
            one_frame(receiver)
            receiver.setblocking(False)
            with pytest.raises(BlockingIOError):
                receiver.recv(65_536)
            receiver.settimeout(10)
        second.close()
        with client(live.url) as third:
            third.send(pack({**HELLO, "skeleton": "kinect20"}))
            while True:
                ask(third, frame(0, joints))
                receiver.settimeout(0.2)
                try:
                    receiver.recv(65_536)
                    break
                except TimeoutError:  # the server has not noticed yet that the first has left
                    continue
