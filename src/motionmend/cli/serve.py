"""`motionmend serve`: correct sensor skeletons live."""

import asyncio
import gc
import signal
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from ..errors import FileError, UsageError
from .output import say

if TYPE_CHECKING:
    from ..correct import CorrectorModel
    from ..live.address import Address
    from ..live.listeners import Listener
    from ..live.server import Server

EXTRA = "motionmend[live]"


def serve(
    *,
    model: Annotated[Path, Parameter(name=["-m", "--model"], help="Model (.mend) from `motionmend fit corrector`.")],
    listen: Annotated[
        str,
        Parameter(help="Where to listen, ws://HOST:PORT. Other machines can connect only if HOST is not loopback."),
    ] = "ws://127.0.0.1:8765",
    vmc: Annotated[
        str | None,
        Parameter(help="HOST:PORT of a receiver of the Virtual Motion Capture protocol; the first client is sent."),
    ] = None,
    lsl: Annotated[
        str | None,
        Parameter(help="Name of a Lab Streaming Layer stream of type MoCap; one for each client."),
    ] = None,
    origin: Annotated[
        tuple[str, ...],
        Parameter(
            help="A web page's origin that may connect beside the server's own page, such as http://localhost:3000."
        ),
    ] = (),
) -> int:
    """Correct sensor skeletons as they come, for any number of clients, each with a correction of its own.

    Clients send and receive over a WebSocket, msgpack or JSON. A browser at the same address shows raw and corrected
    skeletons. Try it with `motionmend stream FILE --to ws://127.0.0.1:8765`. Ctrl-C ends it; what has come is answered.
    """
    from ..live.address import udp_address, websocket_address

    address = websocket_address(listen, "--listen")
    avatar = None if vmc is None else udp_address(vmc, "--vmc")
    if lsl is not None and not lsl.strip():
        raise UsageError("--lsl: the name of a stream was wanted, came none")
    need_live("serve")
    corrector = _corrector(model)
    listeners = _listeners(avatar, lsl)
    _warm(corrector)
    asyncio.run(_serve(_server(corrector, listeners, origin), address))
    return 0


def need_live(command: str) -> None:
    """Refuse where the extra is missing.

    Raises
    ------
    FileError : names the extra.
    """
    try:
        import msgpack  # noqa: F401
        import websockets.asyncio.server  # noqa: F401
    except ImportError as error:
        raise FileError(f"{command} needs {error.name}: pip install '{EXTRA}'") from None


def _corrector(path: Path) -> "CorrectorModel":
    from ..correct import CorrectorModel
    from ..models import load_model

    model = load_model(path)
    if not isinstance(model, CorrectorModel):
        raise FileError(f"{path}: a corrector was wanted, came another model: make one with motionmend fit corrector")
    return model


def _listeners(avatar: "Address | None", lsl: str | None) -> "list[Listener]":
    """The ways out that were asked for."""
    found: list[Listener] = []
    if avatar is not None:
        try:
            import pythonosc  # noqa: F401
        except ImportError:
            raise FileError(f"--vmc needs python-osc: pip install '{EXTRA}'") from None
        from ..live.vmc import Avatar

        found.append(Avatar(avatar))
    if lsl is not None:
        from ..live.lsl import Laboratory

        found.append(Laboratory(lsl.strip()))
    return found


def _server(model: "CorrectorModel", listeners: "list[Listener]", origins: tuple[str, ...]) -> "Server":
    from ..live.server import Server

    return Server(model, listeners=listeners, origins=origins, say=say)


def _warm(model: "CorrectorModel") -> None:
    """Compile and load all that the first frame needs, so that no client waits for it."""
    from ..live.warm import warm

    start = perf_counter()
    warm(model)
    gc.collect()
    gc.freeze()  # the model is not looked through again: a pause less
    say(f"ready after {perf_counter() - start:.1f} s")


async def _serve(server: "Server", address: "Address") -> None:
    """Run until Ctrl-C or the system's request to end."""
    stop = asyncio.Event()
    loop = asyncio.get_running_loop()
    for number in (signal.SIGINT, signal.SIGTERM):
        try:
            loop.add_signal_handler(number, stop.set)
        except NotImplementedError:  # Windows: its loop has no handlers of signals
            signal.signal(number, lambda *_: loop.call_soon_threadsafe(stop.set))

    def ready(real: "Address") -> None:
        say(f"listening on ws://{real}")
        say(f"page: http://{real}/")
        if not real.loopback:
            say("warning: other machines can connect, unencrypted and without a password")

    await server.run(address, stop, ready)
    done = server.counts
    say(f"stopped: {done.clients} clients, {done.frames} frames, {done.dropped} dropped, {done.errors} errors")
