"""A server in a thread of its own, and clients that talk to it over real sockets."""

import asyncio
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import msgpack
import numpy as np
from websockets.sync.client import ClientConnection, connect

from motionmend.live.address import Address
from motionmend.live.server import Server
from motionmend.live.warm import standing

PATIENT = 120.0  # s, in which a server and its processes have to have begun, on a machine that does much else
HELLO = {"v": 1, "skeleton": "kinect20", "fps": 30, "units": "m"}


@dataclass
class Running:
    """A server that listens."""

    server: Server
    address: Address
    stop: asyncio.Event
    loop: asyncio.AbstractEventLoop

    @property
    def url(self) -> str:
        return f"ws://{self.address}"

    def halt(self) -> None:
        self.loop.call_soon_threadsafe(self.stop.set)


@contextmanager
def running(model: Any, **options: Any) -> Iterator[Running]:
    """A server on a free port; afterwards its thread must have ended well."""
    listening = threading.Event()
    found: list[Running] = []
    failed: list[BaseException] = []

    async def serve() -> None:
        stop, server = asyncio.Event(), Server(model, **options)

        def ready(address: Address) -> None:
            found.append(Running(server, address, stop, asyncio.get_running_loop()))
            listening.set()

        await server.run(Address("127.0.0.1", 0), stop, ready)

    def run() -> None:
        try:
            asyncio.run(serve())
        except BaseException as error:
            failed.append(error)
        finally:
            listening.set()

    thread = threading.Thread(target=run)
    thread.start()
    assert listening.wait(PATIENT)
    try:
        assert not failed, failed
        yield found[0]
    finally:
        if found and thread.is_alive():
            found[0].halt()
        thread.join(20)
        assert not thread.is_alive()
        assert not failed, failed


def pack(fields: dict[str, Any]) -> bytes:
    return msgpack.packb(fields)


def unpack(message: bytes | str) -> dict[str, Any]:
    assert isinstance(message, bytes)
    return msgpack.unpackb(message)


def frame(seq: int, joints: np.ndarray, t: float | None = None, state: np.ndarray | None = None) -> dict[str, Any]:
    """A frame's fields as an independent client would write them."""
    codes = np.full(len(joints), 2) if state is None else state
    return {
        "seq": seq,
        "t": seq / 30.0 if t is None else t,
        "joints": np.asarray(joints, "<f4").tobytes(),
        "state": np.asarray(codes, np.uint8).tobytes(),
    }


def singles(raw: bytes) -> np.ndarray:
    return np.frombuffer(raw, "<f4")


@contextmanager
def client(url: str, hello: dict[str, Any] | None = None) -> Iterator[ClientConnection]:
    """A connection that has said hello, unless `hello` is empty."""
    with connect(url, compression=None) as connection:
        if hello is None or hello:
            connection.send(pack(HELLO if hello is None else hello))
        yield connection


def ask(connection: ClientConnection, fields: dict[str, Any]) -> dict[str, Any]:
    connection.send(pack(fields))
    return unpack(connection.recv(timeout=10))


def moving(joint_set, frames, seed=0):
    """(T, J, 3) somebody who sways, with noise."""
    noise = np.random.default_rng(seed).normal(0, 0.01, (frames, len(joint_set.names), 3))
    sway = 0.1 * np.sin(np.arange(frames) / 5 + seed)[:, None, None]
    return (standing(joint_set) + sway * np.linspace(0, 1, 3) + noise).astype(np.float32)


def alone(model, joint_set, positions, online=False):
    """The answers of the model itself, without any server."""
    state = model.start(joint_set.names, online)
    codes, found = np.full(len(joint_set.names), 2, np.uint8), []
    for k, joints in enumerate(positions):
        state, corrected = model.step(state, joints.astype(float), codes, k / 30.0)
        found.append(corrected.positions)
    return np.array(found)
