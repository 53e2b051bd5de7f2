"""What the page shows: who is there, and raw and corrected frames of the client that is looked at."""

import asyncio
import json
import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final, final

from ..arrays import Floats
from ..bodies.joint_sets import parents
from .axes import page_from_sensor
from .messages import Answer, Frame, Hello

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection

EVERY: Final = 1.0 / 60.0  # s between two frames for a page
MOST_VIEWERS: Final = 16


@dataclass
class _Viewer:
    """One open page: the client it looks at (0 = none), and what it has not been sent yet."""

    client: int = 0
    clients_changed: bool = True
    latest: tuple[Frame, Answer] | None = None
    awake: asyncio.Event = field(default_factory=asyncio.Event)


@final
class Watching:
    """All open pages; a listener of the server. A page that is slow misses frames, and delays nobody."""

    def __init__(self) -> None:
        self._clients: dict[int, Hello] = {}
        self._viewers: list[_Viewer] = []

    def opened(self, client: int, hello: Hello) -> None:
        """A client has begun, or begun anew."""
        self._clients[client] = hello
        self._tell_clients()

    def wants(self, client: int) -> bool:
        """Whether somebody looks at this client."""
        return any(viewer.client == client for viewer in self._viewers)

    def frame(self, client: int, frame: Frame, answer: Answer) -> None:
        """A frame was corrected."""
        for viewer in self._viewers:
            if viewer.client == client:
                viewer.latest = (frame, answer)
                viewer.awake.set()

    def closed(self, client: int) -> None:
        """A client has left."""
        if self._clients.pop(client, None) is not None:
            self._tell_clients()

    def _tell_clients(self) -> None:
        first = min(self._clients, default=0)
        for viewer in self._viewers:
            if viewer.client not in self._clients:
                viewer.client = first
            viewer.latest = None
            viewer.clients_changed = True
            viewer.awake.set()

    async def show(self, connection: "ServerConnection") -> None:
        """Send a page what it is to show until it is closed; it says which client it wants with {watch: number}."""
        from websockets.exceptions import ConnectionClosed

        if len(self._viewers) >= MOST_VIEWERS:
            await connection.close(1013, "too many pages are open")
            return
        viewer = _Viewer(min(self._clients, default=0))
        self._viewers.append(viewer)
        sender = asyncio.create_task(self._send(connection, viewer))
        try:
            async for message in connection:
                self._choose(viewer, message)
        except ConnectionClosed:
            pass
        finally:
            self._viewers.remove(viewer)
            sender.cancel()

    def _choose(self, viewer: _Viewer, message: str | bytes) -> None:
        try:
            wanted = json.loads(message)["watch"]
        except (ValueError, KeyError, TypeError, RecursionError):
            return
        if type(wanted) is int and wanted in self._clients:
            viewer.client, viewer.latest, viewer.clients_changed = wanted, None, True
            viewer.awake.set()

    async def _send(self, connection: "ServerConnection", viewer: _Viewer) -> None:
        from websockets.exceptions import ConnectionClosed

        try:
            while True:
                viewer.awake.clear()
                if viewer.clients_changed:
                    viewer.clients_changed = False
                    await connection.send(json.dumps(self._who(viewer)))
                if viewer.latest is not None:
                    (frame, answer), viewer.latest = viewer.latest, None
                    await connection.send(json.dumps(shown(frame, answer), separators=(",", ":")))
                    await asyncio.sleep(EVERY)
                if viewer.latest is None and not viewer.clients_changed:
                    await viewer.awake.wait()
        except ConnectionClosed:
            return

    def _who(self, viewer: _Viewer) -> dict[str, Any]:
        """The clients there are, and the body of the one looked at."""
        who: dict[str, Any] = {
            "clients": [
                {"id": client, "skeleton": hello.skeleton, "fps": hello.fps} for client, hello in self._clients.items()
            ],
            "client": viewer.client,
        }
        hello = self._clients.get(viewer.client)
        if hello is not None:
            hangs_from = parents(hello.names).tolist()
            who["names"] = list(hello.names)
            who["lines"] = [[parent, joint] for joint, parent in enumerate(hangs_from) if parent >= 0]
            who["view"] = page_from_sensor(hello.skeleton).tolist()
        return who


def shown(frame: Frame, answer: Answer) -> dict[str, Any]:
    """A frame and its answer for the page; lengths in m to 0.1 mm, null where there is none."""
    return {
        "seq": frame.seq,
        "t": frame.t,
        "raw": _plain(frame.joints.reshape(-1), 4),
        "corrected": _plain(answer.joints.reshape(-1), 4),
        "reliability": _plain(answer.reliability, 2),
        "std": _plain(answer.std, 4),
        "ms": round(1000.0 * (answer.t_out - answer.t_in), 2),
        "flags": list(answer.flags),
    }


def _plain(values: Floats, digits: int) -> list[float | None]:
    return [round(value, digits) if math.isfinite(value) else None for value in values.tolist()]
