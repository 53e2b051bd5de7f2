"""`motionmend serve`: correct sensor skeletons live."""

import asyncio
import gc
import os
import signal
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from ..batch import one_blas_thread
from ..errors import FileError, UsageError, counted
from .options import Debug, Whole
from .speech import say

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
    online: Annotated[
        bool, Parameter(show_default=False, help="Go on learning, from each client's frames for that client alone.")
    ] = False,
    look_ahead: Annotated[
        float,
        Parameter(
            help="Answer each frame only when those of so many seconds after it have come, 0 to 1: joints that fail "
            "are then nearer the truth. Each answer says its latency."
        ),
    ] = 0.0,
    jobs: Annotated[
        Whole | None,
        Parameter(help="Processes that correct; 0: the server's own. The default is the number of cores, at most 4."),
    ] = None,
    origin: Annotated[
        tuple[str, ...],
        Parameter(
            help="A web page's origin that may connect beside the server's own page, such as http://localhost:3000."
        ),
    ] = (),
    debug: Debug = False,
) -> int:
    """Correct sensor skeletons as they come, for any number of clients, each with a correction of its own.

    Clients send and receive over a WebSocket, msgpack or JSON. A browser at the same address shows raw and corrected
    skeletons. Try it with `motionmend stream FILE --to ws://127.0.0.1:8765`. Ctrl-C ends it; what has come is answered.
    """
    from ..live.address import udp_address, websocket_address
    from .correct import frames_ahead

    address = websocket_address(listen, "--listen")
    avatar = None if vmc is None else udp_address(vmc, "--vmc")
    if lsl is not None and not lsl.strip():
        raise UsageError("--lsl: the name of a stream was wanted, came none")
    frames_ahead(look_ahead)
    need_live("serve")
    corrector = _corrector(model)
    from ..live.server import Server

    server = Server(
        corrector,
        jobs=_processes(jobs),
        online=online,
        look_ahead=look_ahead,
        listeners=_listeners(avatar, lsl),
        origins=origin,
        say=say,
    )
    gc.collect()
    gc.freeze()  # the model is not looked through again: shorter pauses
    with one_blas_thread():
        asyncio.run(_serve(server, address, look_ahead))
    return 0


def _processes(jobs: int | None) -> int:
    """Processes that correct: those asked for, else as many as cores up to four; on a single core the server's own."""
    if jobs is not None and jobs < 0:
        raise UsageError(f"--jobs: 0 or more processes were wanted, came {jobs}")
    cores = os.cpu_count() or 1
    return jobs if jobs is not None else min(4, cores) if cores > 1 else 0


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
    from ..models import load_model

    model: CorrectorModel = load_model(path, "corrector")
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


async def _serve(server: "Server", address: "Address", look_ahead: float) -> None:
    """Run until Ctrl-C or the system's request to end."""
    stop = asyncio.Event()
    loop = asyncio.get_running_loop()
    hang_up = getattr(signal, "SIGHUP", signal.SIGTERM)  # of a terminal that is closed
    ends = {signal.SIGINT, signal.SIGTERM, *([hang_up] if signal.getsignal(hang_up) != signal.SIG_IGN else [])}
    for number in ends:
        try:
            loop.add_signal_handler(number, stop.set)
        except NotImplementedError:  # Windows: its loop has no handlers of signals
            signal.signal(number, lambda *_: loop.call_soon_threadsafe(stop.set))

    def ready(real: "Address") -> None:
        say(f"listening on ws://{real}")
        say(f"page: http://{real}/")
        if look_ahead:
            say(f"answers wait {1000 * look_ahead:g} ms, to the nearest frame, for what comes after their frames")
        if not real.loopback:
            say("warning: other machines can connect, unencrypted and without a password")

    await server.run(address, stop, ready)
    done = server.counts
    taken = f"{counted(done.clients, 'client')}, {counted(done.frames, 'frame')}"
    say(f"stopped: {taken}, {done.dropped} dropped, {counted(done.errors, 'error')}")
