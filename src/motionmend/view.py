"""Recordings in rerun's viewer, for this machine alone: needs the extra `view`.

What is shown is written to a file of rerun's own, which rerun serves to a browser. Rerun listens to other machines and
tells its makers of its use unless told not to; it is told not to, in a home of its own, and its page, which would ask
for fonts, news and examples elsewhere, is passed on with a policy that forbids it.
"""

import os
import socket
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Thread
from time import monotonic, sleep
from urllib.parse import quote, urlsplit
from urllib.request import urlopen

import numpy as np

from .arrays import Floats
from .bodies.motion import Markers, Motion
from .errors import FileError

HERE = "127.0.0.1"
PATIENCE = 20.0  # s until the viewer has to answer


def need_viewer() -> None:
    """Refuse where the extra is missing.

    Raises
    ------
    FileError : names the extra, and what there is without it.
    """
    if find_spec("rerun") is None:
        raise FileError("view needs rerun: pip install 'motionmend[view]'; `motionmend report` needs nothing more")


def write_scene(path: Path, named: Sequence[tuple[str, Motion | Markers]]) -> None:
    """Recordings side by side in time as rerun's file (.rrd), heights along z, each from its own first frame.

    Parameters
    ----------
    path : written.
    named : recordings with their names; positions in m. What is missing is not drawn.
    """
    import rerun

    from .report.payload import lines_of, points_of
    from .report.style import COLOURS

    stream = rerun.RecordingStream("motionmend")
    stream.save(path)
    stream.log("/", rerun.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    for k, (name, recording) in enumerate(named):
        points = points_of(recording)
        if isinstance(recording, Markers):
            names, up, lines = recording.names, recording.up, lines_of(recording.names, points)
        else:
            skeleton = recording.skeleton
            names, up = skeleton.names, skeleton.up
            lines = [[int(parent), joint] for joint, parent in enumerate(skeleton.parents) if parent >= 0]
        if not recording.frames:
            continue
        shown, there = points @ upward(up).T, np.asarray(np.isfinite(points).all(axis=2))
        times = [
            rerun.TimeColumn("time", duration=np.arange(recording.frames) / recording.fps),
            rerun.TimeColumn("frame", sequence=np.arange(recording.frames)),
        ]
        colour = list(bytes.fromhex(COLOURS[k % len(COLOURS)][1:]))
        labels = np.broadcast_to(np.array(names), there.shape)[there].tolist()
        counts = there.sum(axis=1)
        stream.log(
            f"{name}/points", rerun.Points3D.from_fields(radii=0.012, colors=colour, show_labels=False), static=True
        )
        stream.log(f"{name}/lines", rerun.LineStrips3D.from_fields(radii=0.006, colors=colour), static=True)
        columns = rerun.Points3D.columns(positions=shown[there], labels=labels).partition(counts)
        stream.send_columns(f"{name}/points", times, columns)
        pairs = np.array(lines, dtype=np.int64).reshape(-1, 2)
        whole = there[:, pairs[:, 0]] & there[:, pairs[:, 1]]
        strips = np.stack([shown[:, pairs[:, 0]], shown[:, pairs[:, 1]]], axis=2)[whole]
        columns = rerun.LineStrips3D.columns(strips=list(strips)).partition(whole.sum(axis=1))
        stream.send_columns(f"{name}/lines", times, columns)
    stream.disconnect()


def upward(up: Floats) -> Floats:
    """(3, 3) rotation that brings a unit vector to z."""
    up = up / np.linalg.norm(up)
    side = np.eye(3)[int(np.argmin(np.abs(up)))]
    side = side - (side @ up) * up
    side = side / np.linalg.norm(side)
    return np.array([side, np.cross(up, side), up])


@contextmanager
def served(named: Sequence[tuple[str, Motion | Markers]], port: int) -> Iterator[tuple[str, subprocess.Popen[bytes]]]:
    """The viewer's address, and its process, while it is served to browsers on this machine.

    Parameters
    ----------
    named : recordings with their names.
    port : of the page; 0 = any that is free.

    Raises
    ------
    FileError : the port is taken, or the viewer does not start.
    """
    with TemporaryDirectory(prefix="motionmend-view-") as folder:
        scene, home = Path(folder) / "recordings.rrd", Path(folder) / "home"
        home.mkdir()
        write_scene(scene, named)
        behind, data = _free(), _free()
        private = {**os.environ, "HOME": str(home), "APPDATA": str(home), "LOCALAPPDATA": str(home)}
        private |= {f"XDG_{kind}_HOME": str(home) for kind in ("CONFIG", "DATA", "CACHE")}
        program = _program()
        subprocess.run([program, "analytics", "disable"], env=private, capture_output=True, check=False)
        ports = ["--port", str(data), "--web-viewer-port", str(behind)]
        command = [program, "--serve-web", "--bind", HERE, *ports, str(scene)]
        said = Path(folder) / "said.txt"
        with (
            said.open("w") as out,
            _page(port, behind, data) as page,
            subprocess.Popen(command, env=private, stdout=out, stderr=out) as process,
        ):
            try:
                _wait(process, behind, said)
                source = quote(f"rerun+http://{HERE}:{data}/proxy", safe="")
                yield f"http://{HERE}:{page}/?url={source}", process
            finally:
                process.terminate()


def _program() -> str:
    """The viewer itself: the script of that name would leave it running."""
    spec = find_spec("rerun_cli")
    found = sorted(Path(spec.origin).parent.glob("rerun*")) if spec is not None and spec.origin else []
    programs = [one for one in found if one.name in ("rerun", "rerun.exe")]
    if not programs:
        raise FileError("rerun is there without its viewer: pip install --force-reinstall 'motionmend[view]'")
    return str(programs[0])


@contextmanager
def _page(port: int, behind: int, data: int) -> Iterator[int]:
    """The viewer's page, passed on from the port `behind` so that it may ask nobody but this machine for anything."""
    inside = "'self' 'unsafe-inline' 'unsafe-eval' 'wasm-unsafe-eval' blob: data:"
    policy = f"default-src {inside}; connect-src 'self' blob: data: http://{HERE}:{data}"

    class PassOn(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            try:
                with urlopen(f"http://{HERE}:{behind}{urlsplit(self.path).path}", timeout=PATIENCE) as answer:
                    content, kind = answer.read(), answer.headers.get("Content-Type", "application/octet-stream")
            except OSError:
                self.send_error(404)
                return
            self.send_response(200)
            for name, value in (("Content-Type", kind), ("Content-Security-Policy", policy)):
                self.send_header(name, value)
            self.send_header("Content-Length", str(len(content)))
            self.end_headers()
            with suppress(OSError):  # who asked has left
                self.wfile.write(content)

        def log_message(self, format: str, *args: object) -> None:
            """Nothing: stderr is for what the user has to know."""

    try:
        server = ThreadingHTTPServer((HERE, port), PassOn)
    except OSError as error:
        raise FileError(f"--port: nothing can listen at {HERE}:{port} ({error.strerror}): give another") from None
    server.daemon_threads = True
    with server:
        Thread(target=server.serve_forever, daemon=True).start()
        try:
            yield int(server.server_address[1])
        finally:
            server.shutdown()


def _free() -> int:
    """A port that nobody listens at."""
    with socket.socket() as trial:
        trial.bind((HERE, 0))
        found: int = trial.getsockname()[1]
        return found


def _wait(process: subprocess.Popen[bytes], port: int, said: Path) -> None:
    """Until the page answers."""
    until = monotonic() + PATIENCE
    while monotonic() < until and process.poll() is None:
        try:
            socket.create_connection((HERE, port), 1.0).close()
            return
        except OSError:
            sleep(0.1)
    process.kill()
    lines = said.read_text("utf-8", errors="replace").split("\n")
    last = next((line for line in reversed(lines) if line.strip()), "it says nothing")
    raise FileError(f"rerun's viewer did not start: {last}")
