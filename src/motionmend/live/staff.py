"""Processes that correct for the server, so that many clients share all cores; each client stays with one of them."""

import asyncio
import multiprocessing
import pickle
import socket
import struct
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Final, cast, final

from ..errors import FileError
from ..processes import left_to_parent
from .messages import MessageError, encode_error
from .session import Reply, Session, replied

if TYPE_CHECKING:
    from multiprocessing.process import BaseProcess

    from ..correct import CorrectorModel

_LENGTH: Final = struct.Struct("<I")
_START: Final = 300.0  # s until a process must have said that it is ready
_MOST: Final = 262_144  # bytes read at once
_TOGETHER: Final = 4  # answers to questions that waited, written at once: more would keep the first of them waiting
_PAUSE: Final = 0.5  # s before a process that ended is replaced
ENDED: Final = "the process that corrected this client has ended: its session begins anew with one of the next frames"


@final
class _Line(asyncio.Protocol):
    """The server's end of the line to one process: questions out, answers back in the same order."""

    def __init__(self, lost: Callable[[], None]) -> None:
        self._lost = lost
        self._heard = bytearray()
        self._said: list[bytes] = []
        self._asked: deque[asyncio.Future[Any]] = deque()
        self._transport: asyncio.WriteTransport | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """The line stands."""
        self._transport = cast(asyncio.WriteTransport, transport)

    def data_received(self, data: bytes) -> None:
        """Give answers to those who asked."""
        self._heard += data
        for reply in _unpacked(self._heard):
            asked = self._asked.popleft()
            if not asked.done():
                asked.set_result(reply)

    def connection_lost(self, error: Exception | None) -> None:
        """The process has ended: whoever waits for it is told."""
        self._transport = None
        for asked in self._asked:
            if not asked.done():
                asked.set_result(None)
        self._asked.clear()
        self._lost()

    def expect(self) -> "asyncio.Future[Any]":
        """What the process says next to what was not answered yet."""
        asked: asyncio.Future[Any] = asyncio.get_running_loop().create_future()
        self._asked.append(asked)
        return asked

    def tell(self, what: Any) -> None:
        """Say something that is not answered, together with all else that is said in this turn of the loop."""
        if not self._said:
            asyncio.get_running_loop().call_soon(self._write)
        self._said.append(_packed(what))

    def _write(self) -> None:
        said, self._said = b"".join(self._said), []
        if self._transport is not None:
            self._transport.write(said)

    async def ask(self, what: Any) -> Any:
        """Say something and wait for the answer; None when the process ended meanwhile."""
        if self._transport is None:
            return None
        self.tell(what)
        return await self.expect()

    def hang_up(self) -> None:
        """End the line, and with it the process."""
        if self._transport is not None:
            self._transport.close()


@final
class Staff:
    """A desk (desk.py) of several processes. One that ends is replaced, and its clients' sessions begin anew.

    `hired` makes one.
    """

    def __init__(self, model: "CorrectorModel", online: bool, say: Callable[[str], None], look_ahead: float) -> None:
        self._model = model
        self._online = online
        self._look_ahead = look_ahead
        self._say = say
        self._lines: list[_Line] = []
        self._processes: list[BaseProcess] = []
        self._clients: dict[int, tuple[int, _Line]] = {}  # place of the process, and the line to it
        self._hellos: dict[int, bytes | str] = {}
        self._hiring: set[asyncio.Task[None]] = set()
        self._leaving = False

    @classmethod
    async def hired(
        cls,
        model: "CorrectorModel",
        count: int,
        online: bool,
        say: Callable[[str], None],
        look_ahead: float = 0.0,
    ) -> "Staff":
        """A staff that is ready to correct.

        Parameters
        ----------
        model : the corrector.
        count : processes.
        online : whether the corrector learns from the clients' frames, from each for itself.
        say : takes a line for the person who runs the server.
        look_ahead : s of frames for which an answer waits.

        Raises
        ------
        FileError : a process ended as it began.
        """
        staff = cls(model, online, say, look_ahead)
        try:
            for places in (range(1), range(1, count)):  # what the first has compiled the others only load
                for ready in [await staff._begin(place) for place in places]:
                    if await asyncio.wait_for(ready, _START) is None:
                        raise FileError("a process that should correct ended as it began: --jobs 0 does without")
        except BaseException:
            await staff.leave()
            raise
        return staff

    async def _begin(self, place: int) -> "asyncio.Future[Any]":
        """Start the process at a place of the staff; what is returned comes when it is ready."""
        ours, theirs = socket.socketpair()
        process = _context().Process(
            target=_work, args=(self._model, self._online, self._look_ahead, theirs), daemon=True
        )
        process.start()
        theirs.close()
        loop = asyncio.get_running_loop()
        _, line = await loop.create_connection(lambda: _Line(lambda: self._lost(place)), sock=ours)
        self._lines[place : place + 1] = [line]
        self._processes[place : place + 1] = [process]
        return line.expect()

    def _lost(self, place: int) -> None:
        """A process has ended: another takes its place, unless all are leaving."""
        if not self._leaving:
            self._say("warning: a process that corrected has ended, another takes its place; its clients begin anew")
            hiring = asyncio.get_running_loop().create_task(self._replace(place))
            self._hiring.add(hiring)
            hiring.add_done_callback(self._hiring.discard)

    async def _replace(self, place: int) -> None:
        await asyncio.sleep(_PAUSE)  # should it end at once again and again
        await self._begin(place)

    async def reply(
        self, client: int, message: bytes | str, t_in: float, flags: tuple[str, ...] = (), whole: bool = False
    ) -> Reply:
        """What is to be done about a client's message; parameters as of `session.replied`.

        A client stays with the process that had the fewest clients when it came. Where that was replaced, its session
        begins anew with the hello it had said.
        """
        if client not in self._clients:
            taken = [place for place, _ in self._clients.values()]
            place = min(range(len(self._lines)), key=taken.count)
            self._clients[client] = (place, self._lines[place])
        place, line = self._clients[client]
        if self._lines[place] is not line:
            line = self._lines[place]
            self._clients[client] = (place, line)
            if client in self._hellos:
                await line.ask((client, self._hellos[client], t_in, (), False))
                flags = (*flags, "restarted")
        reply: Reply | bytes | str | None = await line.ask((client, message, t_in, flags, whole))
        if isinstance(reply, bytes | str):
            return Reply(reply)
        if reply is None:
            return Reply(encode_error(MessageError(ENDED), isinstance(message, str)), error=True)
        if reply.hello is not None:
            self._hellos[client] = message
        return reply

    def close(self, client: int) -> None:
        """Forget a client, whether it had a session or not."""
        self._hellos.pop(client, None)
        if client in self._clients:
            self._clients.pop(client)[1].tell((client, None, 0.0, (), False))

    async def leave(self) -> None:
        """End all processes."""
        self._leaving = True
        for hiring in self._hiring:
            hiring.cancel()
        for line in self._lines:
            line.hang_up()
        await asyncio.sleep(0)  # the lines are closed now, and who hears nothing more goes
        for process in self._processes:
            await asyncio.to_thread(process.join, 2.0)
            if process.is_alive():
                process.terminate()


def _context() -> Any:
    """How processes are started: from a small one that has loaded what all need, where the system has such."""
    if "forkserver" not in multiprocessing.get_all_start_methods():
        return multiprocessing.get_context("spawn")
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["motionmend.live.staff", "motionmend.live.warm", "motionmend.correct.corrector"])
    return context


def _work(model: "CorrectorModel", online: bool, look_ahead: float, line: socket.socket) -> None:
    """A process of the staff: correct what comes over the line until it ends."""
    left_to_parent()  # the server, which then ends the line
    with suppress(BrokenPipeError, ConnectionResetError):  # it may while somebody is spoken of whom it will not hear of
        _serve(model, online, look_ahead, line)


def _serve(model: "CorrectorModel", online: bool, look_ahead: float, line: socket.socket) -> None:
    import gc

    from ..batch import one_blas_thread
    from .warm import warm

    sessions: dict[int, Session | None] = {}
    heard, said = bytearray(), list[bytes]()
    # What was pickled is writeable: kernels would be compiled anew for it.
    model = type(model).from_arrays(*model.to_arrays())
    with one_blas_thread(), line:
        warm(model, look_ahead)
        gc.collect()
        gc.freeze()  # the model is not looked through again: shorter pauses
        line.sendall(_packed("ready"))
        while data := line.recv(_MOST):
            heard += data
            for client, message, t_in, flags, whole in _unpacked(heard):
                if message is None:
                    sessions.pop(client, None)
                    continue
                session = sessions.get(client)
                sessions[client], reply = replied(model, session, message, t_in, flags, whole, online, look_ahead)
                said.append(_packed(reply.data if reply.plain else reply))
                if len(said) == _TOGETHER:
                    line.sendall(b"".join(said))
                    said.clear()
            line.sendall(b"".join(said))
            said.clear()


def _packed(what: Any) -> bytes:
    data = pickle.dumps(what, pickle.HIGHEST_PROTOCOL)
    return _LENGTH.pack(len(data)) + data


def _unpacked(heard: bytearray) -> list[Any]:
    """What has come whole, taken out of the buffer."""
    found, start = [], 0
    while len(heard) - start >= _LENGTH.size:
        end = start + _LENGTH.size + _LENGTH.unpack_from(heard, start)[0]
        if len(heard) < end:
            break
        found.append(pickle.loads(heard[start + _LENGTH.size : end]))
        start = end
    del heard[:start]
    return found
