"""`motionmend stream`: play a recorded sensor skeleton into a server."""

import asyncio
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from cyclopts import Parameter

from ..batch import failure
from ..errors import FileError, UsageError, counted
from .options import AsJson, Debug, Force, Rate
from .output import tell_failure, tell_guesses
from .serve import need_live
from .speech import json_line, progress, say

if TYPE_CHECKING:
    from ..bodies.postures import Postures
    from ..live.replay import Replayed


def stream(
    file: Annotated[Path, Parameter(help="A recorded sensor skeleton, in any form that `motionmend correct` reads.")],
    /,
    *,
    to: Annotated[str, Parameter(help="The server, ws://HOST:PORT.")],
    out: Annotated[
        Path | None, Parameter(name=["-o", "--out"], help="Write the answers as a table of joints (.csv).")
    ] = None,
    speed: Annotated[float, Parameter(help="Times the recording's own rate.")] = 1.0,
    text: Annotated[bool, Parameter(name="--text", show_default=False, help="Send JSON instead of msgpack.")] = False,
    fps: Rate = None,
    as_json: AsJson = False,
    force: Force = False,
    debug: Debug = False,
) -> int:
    """Play a recorded sensor skeleton into a server at its own rate, and say how long the answers took.

    The times between the recording's frames are kept. Exit code 1 when a frame got no reply, or none was corrected.
    """
    from ..live.address import websocket_address

    url = f"ws://{websocket_address(to, '--to')}"
    if not 0 < speed < np.inf:
        raise UsageError(f"--speed: a number above 0 was wanted, came {speed}")
    if out is not None and out.suffix.lower() != ".csv":
        raise UsageError(f"-o: a table's name ends in .csv, came {out}")
    need_live("stream")
    try:
        if out is not None and out.exists() and not force:
            raise FileError(f"{out} is there already: --force overwrites it")
        postures = _read(file, fps)
        tell_guesses({guess: [file] for guess in postures.guesses})
        replayed = _replay(url, postures, speed, text)
        if out is not None:
            from ..io.joint_table import write_joint_table

            out.parent.mkdir(parents=True, exist_ok=True)
            write_joint_table(out, replayed.postures)
    except (FileError, OSError) as error:
        tell_failure(file, failure(error), as_json=as_json, debug=debug)
        return 1
    return _tell(file, out, postures, replayed, as_json)


def _read(file: Path, fps: float | None) -> "Postures":
    from ..io.sensor import read_postures

    postures = read_postures(file, fps=fps)
    for warning in postures.warnings:
        say(f"warning ({file}): {warning}")
    if not postures.frames:
        raise FileError(f"{file}: a recording with frames was wanted, this one has none")
    return postures


def _replay(url: str, postures: "Postures", speed: float, text: bool) -> "Replayed":
    from ..live.replay import replay

    with progress(postures.frames) as advance:
        return asyncio.run(replay(url, postures, speed=speed, text=text, sent=advance))


def _tell(file: Path, out: Path | None, postures: "Postures", replayed: "Replayed", as_json: bool) -> int:
    frames, took = postures.frames, replayed.round_trip[np.isfinite(replayed.round_trip)]
    percentiles = np.percentile(1000.0 * took, (50, 95, 99)).tolist() if took.size else [None] * 3
    round_trip = dict(zip(("p50", "p95", "p99"), percentiles, strict=True))
    facts: dict[str, Any] = {
        "input": file,
        "output": out,
        "frames": frames,
        "answered": int(took.size),
        "refused": len(replayed.refused),
        "lost": replayed.lost,
        "round_trip_ms": round_trip,
        "latency_ms": replayed.latency_ms,
        "flags": replayed.flags,
        "guesses": postures.guesses,
    }
    if as_json:
        print(json_line(facts))
    times = ", ".join(f"{name} {value:.2f}" for name, value in round_trip.items()) if took.size else "none"
    late = f"; {replayed.latency_ms:g} of it to look ahead" if replayed.latency_ms else ""
    say(f"{file}: {took.size} of {counted(frames, 'frame')} answered; round trip in ms: {times}{late}")
    if replayed.refused:
        first = min(replayed.refused)
        refused = counted(len(replayed.refused), "frame")
        whose = f"motionmend: {file}" if not took.size and not replayed.lost else f"warning ({file})"
        say(f"{whose}: {refused} refused, {first} first: {replayed.refused[first]}")
    if replayed.lost:
        say(
            f"motionmend: {file}: {counted(replayed.lost, 'frame')} got no answer: "
            "the server or this machine is too slow for them"
        )
    return 1 if replayed.lost or not took.size else 0
