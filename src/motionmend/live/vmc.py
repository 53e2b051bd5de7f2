"""Corrected skeletons to avatars: the Virtual Motion Capture protocol, OSC messages over UDP.

Bones are sent as `/VMC/Ext/Bone/Pos name px py pz qx qy qz qw` in Unity's axes, relative to the bone above
(protocol.vmc.info). A performer has no number in the protocol: of several clients the first is sent, and when it leaves
the next.
"""

import socket
import time
from collections.abc import Sequence
from typing import Final, final

import numpy as np

from ..arrays import Floats
from ..bodies.joint_sets import meanings
from ..errors import FileError
from .address import Address
from .axes import turned_up, unity_from_sensor
from .humanoid import Bone, humanoid
from .messages import NAMED, Answer, Frame, Hello

MOST_BYTES: Final = 1_400  # of one datagram: below every Ethernet's limit
_HEAD: Final = 16  # bytes before the messages of a bundle: "#bundle" and the time
_UPPER: Final = ("l_shoulder", "r_shoulder")
_LOWER: Final = ("l_hip", "r_hip", "l_ankle", "r_ankle")
_FEET: Final = ("l_foot", "r_foot", "l_ankle", "r_ankle", "l_toe_tip", "r_toe_tip")
_SINK, _RISE = 0.2, 0.002  # shares of the way that the floor goes down to the lowest foot, and up to it, at each frame


@final
class Avatar:
    """A listener of the server that sends one client's corrected frames to a VMC receiver.

    Parameters
    ----------
    address : of the receiver, UDP; VMC's own port is 39539.

    Raises
    ------
    FileError : the receiver's name is not known.
    """

    def __init__(self, address: Address) -> None:
        try:
            found = socket.getaddrinfo(address.host, address.port, type=socket.SOCK_DGRAM)[0]
        except OSError as error:
            raise FileError(f"--vmc: {address} cannot be reached: {error.strerror or error}") from None
        self._socket, self._to = socket.socket(*found[:3]), found[4]
        self._socket.setblocking(False)
        self._clients: dict[int, Hello] = {}
        self._start = time.perf_counter()
        self._stage: Stage | None = None

    def opened(self, client: int, hello: Hello) -> None:
        """A client has begun, or begun anew."""
        if client == self._leader:
            self._stage = None
        self._clients[client] = hello

    def wants(self, client: int) -> bool:
        """Whether this client is the first."""
        return client == self._leader

    def frame(self, client: int, frame: Frame, answer: Answer) -> None:
        """Send the first client's frame."""
        if self._stage is None:
            self._stage = Stage(self._clients[client])
        for datagram in datagrams(self._stage.bones(answer.joints), time.perf_counter() - self._start):
            try:
                self._socket.sendto(datagram, self._to)
            except OSError:  # nobody listens there now, or the network is full: the next frame is newer anyway
                return

    def closed(self, client: int) -> None:
        """A client has left."""
        if client == self._leader:
            self._stage = None
        self._clients.pop(client, None)

    @property
    def _leader(self) -> int | None:
        return min(self._clients, default=None)


@final
class Stage:
    """Where an avatar stands: the floor is under the feet, and the first frame's hips are above the origin.

    Which way is up follows from the sensor whose skeleton it is; where joints only have names nothing is known of it,
    and who comes first is taken to stand or sit.

    Parameters
    ----------
    hello : whose skeleton is sent.
    """

    def __init__(self, hello: Hello) -> None:
        self._meanings = meanings(hello.names)
        self._axes = unity_from_sensor(hello.skeleton)
        self._turned = hello.skeleton != NAMED  # up is where it belongs
        self._origin: Floats | None = None  # x, floor, z

    def bones(self, joints: Floats) -> list[Bone]:
        """The bones of a frame (J, 3) m in the sensor's axes; empty where too little of the trunk is there."""
        placed = joints @ self._axes.T
        named = {m: p for m, p in zip(self._meanings, placed, strict=True) if m and np.isfinite(p).all()}
        if "pelvis" not in named:
            return []
        if not self._turned and named.keys() >= {*_UPPER, *_LOWER[:2]}:
            below = np.mean([named[one] for one in _LOWER if one in named], axis=0)
            turn = turned_up(np.mean([named[one] for one in _UPPER], axis=0) - below)
            self._axes, self._turned = turn @ self._axes, True
            named = {meaning: turn @ place for meaning, place in named.items()}
        feet = [float(named[foot][1]) for foot in _FEET if foot in named]
        if self._origin is None:
            floor = min(feet, default=float(named["pelvis"][1]) - 1.0)
            self._origin = np.array([named["pelvis"][0], floor, named["pelvis"][2]])
        elif feet:
            away = min(feet) - self._origin[1]
            self._origin[1] += away * (_SINK if away < 0 else _RISE)
        return humanoid({meaning: place - self._origin for meaning, place in named.items()})


def datagrams(bones: Sequence[Bone], seconds: float) -> list[bytes]:
    """A frame as OSC bundles of less than 1,400 bytes each.

    Parameters
    ----------
    bones : as `humanoid` gives them; without any, the receiver is told that there is no posture.
    seconds : since the sender began.
    """
    messages = [_message("/VMC/Ext/OK", int(bool(bones))), _message("/VMC/Ext/T", float(seconds))]
    if bones:
        messages.append(_message("/VMC/Ext/Root/Pos", "root", 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0))
    for bone in bones:
        numbers = (*bone.place.tolist(), *bone.rotation.tolist())
        messages.append(_message("/VMC/Ext/Bone/Pos", bone.name, *numbers))
    return _bundles(messages)


def _message(path: str, *values: int | float | str) -> bytes:
    from pythonosc.osc_message_builder import OscMessageBuilder

    builder = OscMessageBuilder(address=path)
    for value in values:
        builder.add_arg(value, {int: "i", float: "f", str: "s"}[type(value)])
    return bytes(builder.build().dgram)


def _bundles(messages: Sequence[bytes]) -> list[bytes]:
    """Messages in their order, as many in a bundle as fit (OSC 1.0: each with its size before it)."""
    head = b"#bundle\0" + (1).to_bytes(8, "big")  # the time 1 means at once
    found, size = [[head]], _HEAD
    for message in messages:
        if size + 4 + len(message) >= MOST_BYTES:
            found.append([head])
            size = _HEAD
        found[-1] += [len(message).to_bytes(4, "big"), message]
        size += 4 + len(message)
    return [b"".join(parts) for parts in found]
