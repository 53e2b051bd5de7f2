"""The server: a correction of its own for every client, over WebSockets, and a page at the same port."""

import asyncio
import logging
import socket
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from http import HTTPStatus
from typing import TYPE_CHECKING, Final, final
from urllib.parse import urlsplit

from ..errors import FileError
from .address import Address, host_of, is_loopback
from .client import Counts, Item, answer_messages, read_messages
from .desk import OwnDesk
from .listeners import Listener, Listeners
from .mailbox import Mailbox
from .messages import MOST_BYTES
from .page import page, page_headers
from .staff import Staff
from .warm import warm
from .watch import Watching

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection
    from websockets.http11 import Request, Response

    from ..correct import CorrectorModel
    from .desk import Desk

CORRECT, WATCH = "/", "/watch"  # paths: a client's session, and what the page listens to
MOST_CLIENTS: Final = 256
HARD_BYTES: Final = 256 * MOST_BYTES  # a message longer than this ends its session before it is in memory
UNREAD: Final = 2  # pieces of messages in memory; then a client waits, so that long messages of many do not fill it
SEND_BUFFER: Final = 32_768  # bytes the system keeps for a client that does not read: more would be old frames only
PATIENCE: Final = 3.0  # s for what is left when the server stops


@final
class Server:
    """One model, many clients.

    Parameters
    ----------
    model : the corrector; its states belong to the clients.
    jobs : processes that correct; 0 = this one does.
    online : whether it learns from the clients' frames, from each for itself.
    look_ahead : s of frames for which an answer waits.
    listeners : told of every frame of every client.
    origins : of web pages that may connect ("https://example.org"), beside the server's own.
    say : takes a line for the person who runs the server.

    Attributes
    ----------
    counts : what was done so far.
    """

    def __init__(
        self,
        model: "CorrectorModel",
        *,
        jobs: int = 0,
        online: bool = False,
        look_ahead: float = 0.0,
        listeners: Sequence[Listener] = (),
        origins: Sequence[str] = (),
        say: Callable[[str], None] = lambda line: None,
    ) -> None:
        self.counts = Counts()
        self._model = model
        self._jobs = jobs
        self._say = say
        self._online = online
        self._look_ahead = look_ahead
        self._desk: Desk = OwnDesk(model, online, look_ahead)
        self._origins = frozenset(origin.rstrip("/").lower() for origin in origins)
        self._watching = Watching()
        self._listener = Listeners([self._watching, *listeners], say)
        self._boxes: dict[int, Mailbox[Item]] = {}
        self._workers: set[asyncio.Task[None]] = set()
        self._connections: set[ServerConnection] = set()
        self._loopback = True

    async def run(
        self, address: Address, stop: asyncio.Event, ready: Callable[[Address], None] = lambda address: None
    ) -> None:
        """Listen until `stop` is set; then answer what has come, say goodbye and return.

        Parameters
        ----------
        address : where to listen.
        stop : ends the server.
        ready : called once clients can connect, with the address and the port in use.

        Raises
        ------
        FileError : the address cannot be listened on.
        """
        from websockets.asyncio.server import serve

        listening = _listening(address)
        self._loopback = address.loopback
        if self._jobs:
            self._desk = await Staff.hired(self._model, self._jobs, self._online, self._say, self._look_ahead)
        else:
            warm(self._model, self._look_ahead)
        server = await serve(
            self._handle,
            sock=listening,
            process_request=self._answer_request,
            compression=None,  # a frame is too short to gain, and nothing can unpack to gigabytes
            max_size=HARD_BYTES,
            max_queue=UNREAD,
            write_limit=SEND_BUFFER // 4,
            ping_interval=20,
            ping_timeout=60,
            close_timeout=PATIENCE,
            server_header=None,
            logger=_quiet(),
        )
        ready(Address(address.host, listening.getsockname()[1]))
        try:
            await stop.wait()
        finally:
            for box in self._boxes.values():
                box.close()
            if self._workers:
                await asyncio.wait(self._workers, timeout=PATIENCE)
            server.close()  # with code 1001, going away
            await self._emptied(asyncio.ensure_future(server.wait_closed()))
            await self._desk.leave()

    async def _emptied(self, closed: "asyncio.Future[None]") -> None:
        """Wait until all have left, and no longer for who sends without reading: no goodbye gets through to them."""
        await asyncio.wait({closed}, timeout=PATIENCE)
        for connection in self._connections:
            connection.transport.abort()
        await asyncio.wait({closed}, timeout=PATIENCE)

    async def _handle(self, connection: "ServerConnection") -> None:
        self._connections.add(connection)
        try:
            if connection.request is not None and _path(connection.request) == WATCH:
                await self._watching.show(connection)
            else:
                await self._correct(connection)
        finally:
            self._connections.discard(connection)

    async def _correct(self, connection: "ServerConnection") -> None:
        """One client: a task puts what it sends into a box, another answers what is in the box."""
        from websockets.exceptions import ConnectionClosed

        self.counts.clients += 1
        client, box = self.counts.clients, Mailbox[Item]()
        worker = asyncio.create_task(answer_messages(client, connection, box, self._desk, self._listener, self.counts))
        self._boxes[client] = box
        self._workers.add(worker)
        try:
            with suppress(ConnectionClosed):
                await read_messages(connection, box)
            box.close()
            with suppress(ConnectionClosed):
                await worker
        finally:
            worker.cancel()
            self._workers.discard(worker)
            del self._boxes[client]
            self.counts.dropped += box.dropped
            self._desk.close(client)
            self._listener.closed(client)

    def _answer_request(self, connection: "ServerConnection", request: "Request") -> "Response | None":
        """Before a handshake: who asks, and whether for the page or for a session."""
        path, host = _path(request), _header(request, "Host")
        if self._loopback and not is_loopback(host_of(host)):  # a name that a web page's author points at this machine
            return connection.respond(HTTPStatus.FORBIDDEN, "this server is for this machine alone\n")
        if "websocket" not in _header(request, "Upgrade").lower():
            if path != CORRECT:
                return connection.respond(HTTPStatus.NOT_FOUND, "there is one page, at /\n")
            response = connection.respond(HTTPStatus.OK, page())
            for name, value in page_headers(host).items():
                if name in response.headers:
                    del response.headers[name]
                response.headers[name] = value
            return response
        if path not in (CORRECT, WATCH):
            return connection.respond(HTTPStatus.NOT_FOUND, f"sessions are at {CORRECT}, not at {path[:80]}\n")
        origin = _header(request, "Origin").rstrip("/").lower()
        if origin and urlsplit(origin).netloc != host.lower() and origin not in self._origins:
            return connection.respond(HTTPStatus.FORBIDDEN, f"pages of {origin[:80]} may not connect: see --origin\n")
        if len(self._boxes) >= MOST_CLIENTS:
            return connection.respond(HTTPStatus.SERVICE_UNAVAILABLE, f"{MOST_CLIENTS} clients are here already\n")
        return None


def _path(request: "Request") -> str:
    return request.path.partition("?")[0]


def _header(request: "Request", name: str) -> str:
    """A header's value, "" where there is none; of several all, which then are no host and no origin."""
    return ", ".join(request.headers.get_all(name))


def _listening(address: Address) -> socket.socket:
    """A socket bound to the address, with little room for what a slow client does not read."""
    try:
        family, kind, protocol, _, place = socket.getaddrinfo(
            address.host, address.port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        )[0]
        listening = socket.socket(family, kind, protocol)
        try:
            if sys.platform != "win32":  # there it would let two servers share an address
                listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            listening.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER)  # those accepted inherit it
            listening.bind(place)
            listening.listen(MOST_CLIENTS)
            listening.setblocking(False)
        except BaseException:
            listening.close()
            raise
    except OSError as error:
        raise FileError(
            f"cannot listen on {address}: {error.strerror or error}: choose another with --listen"
        ) from None
    return listening


def _quiet() -> logging.Logger:
    """A log that nobody reads: a stranger's broken handshake is no news."""
    logger = logging.getLogger("motionmend.live")
    if not logger.handlers:
        logger.addHandler(logging.NullHandler())
    logger.propagate = False
    return logger
