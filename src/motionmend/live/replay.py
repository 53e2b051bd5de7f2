"""The client: plays a recorded sensor skeleton into a server at its own rate and times the answers."""

import asyncio
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from time import perf_counter
from typing import TYPE_CHECKING, Final, final

import numpy as np

from ..arrays import Bytes, Floats
from ..bodies.joint_sets import known_set
from ..bodies.postures import NOT_TRACKED, TRACKED, Postures
from ..errors import FileError
from .messages import NAMED, Answer, Frame, Hello, MessageError, encode_end, encode_frame, encode_hello, read_answer

if TYPE_CHECKING:
    from websockets.asyncio.client import ClientConnection

PATIENCE: Final = 2.0  # s for the last answers
FPS: Final = 30.0  # Hz said in the hello where a recording has one frame


@final
@dataclass(frozen=True, eq=False)
class Replayed:
    """What came back.

    Attributes
    ----------
    postures : the answers, one frame for each sent; NaN where none came.
    round_trip : (T,) s from sending a frame to having its answer; NaN where none came.
    refused : what the server said about frames it could not use, by frame.
    flags : how many answers carried each flag.
    latency_ms : for which the server let answers wait to see what comes after them.
    """

    postures: Postures
    round_trip: Floats
    refused: dict[int, str]
    flags: dict[str, int]
    latency_ms: float = 0.0

    @property
    def lost(self) -> int:
        """Frames that got neither an answer nor a refusal."""
        return int(np.isnan(self.round_trip).sum()) - len(self.refused)


def hello_of(postures: Postures) -> Hello:
    """What a client with this recording says of itself."""
    known = known_set(postures.names)
    fps = postures.fps if postures.frames > 1 and postures.fps > 0 else FPS
    return Hello(NAMED if known is None else known.key, postures.names, float(fps))


async def replay(
    url: str,
    postures: Postures,
    *,
    speed: float = 1.0,
    text: bool = False,
    sent: Callable[[], None] = lambda: None,
) -> Replayed:
    """Play a recording into a server.

    Parameters
    ----------
    url : ws://host:port of the server.
    postures : T frames, T > 0. Joints without a position are sent as not tracked.
    speed : times the recording's own rate.
    text : JSON instead of msgpack.
    sent : called after each frame.

    Raises
    ------
    FileError : no server there, or it ended the session.
    """
    from websockets.asyncio.client import connect
    from websockets.exceptions import ConnectionClosed, WebSocketException

    try:
        async with connect(url, compression=None, max_queue=None, open_timeout=10) as connection:
            return await _played(connection, postures, speed, text, sent)
    except ConnectionClosed as error:
        raise FileError(f"{url}: the server ended the session: {error}") from None
    except (OSError, WebSocketException, TimeoutError) as error:
        why = str(error) or type(error).__name__
        raise FileError(f"{url}: no server answers there: {why}: start one with motionmend serve -m MODEL") from None


async def _played(
    connection: "ClientConnection", postures: Postures, speed: float, text: bool, sent: Callable[[], None]
) -> Replayed:
    frames, joints = postures.positions.shape[:2]
    at = np.full(frames, np.nan)  # s, when each was sent
    record = _Record(frames, joints)
    hearing = asyncio.create_task(_hear(connection, record, at))
    try:
        await connection.send(encode_hello(hello_of(postures), text))
        due = np.maximum.accumulate(postures.times - postures.times[0]) / speed
        start = perf_counter()
        for k in range(frames):
            await asyncio.sleep(max(0.0, start + due[k] - perf_counter()))
            if hearing.done():
                break
            at[k] = perf_counter()
            await connection.send(encode_frame(_frame(postures, k, text)))
            sent()
        if not hearing.done() and (record.latency_ms > 0 or record.left == frames):  # the server may owe the last ones
            await connection.send(encode_end(text))
        with suppress(TimeoutError):
            await asyncio.wait_for(asyncio.shield(hearing), PATIENCE)
        if hearing.done():
            hearing.result()  # raises what ended it
    finally:
        hearing.cancel()
    return record.replayed(postures)


def _frame(postures: Postures, k: int, text: bool) -> Frame:
    state: Bytes | None = None if postures.state is None else postures.state[k]
    missing = ~postures.present[k]
    if missing.any():
        told = np.full(len(missing), TRACKED, dtype=np.uint8) if state is None else state
        state = np.where(missing, NOT_TRACKED, told).astype(np.uint8)
    joints = np.where(missing[:, None], np.nan, postures.positions[k])
    return Frame(k, float(postures.times[k]), joints, state, "rows" if text else "msgpack")


@final
class _Record:
    """Answers as they come."""

    def __init__(self, frames: int, joints: int) -> None:
        self.joints = joints
        self.positions = np.full((frames, joints, 3), np.nan)
        self.reliability = np.full((frames, joints), np.nan)
        self.std = np.full((frames, joints), np.nan)
        self.round_trip = np.full(frames, np.nan)
        self.refused: dict[int, str] = {}
        self.flags: dict[str, int] = {}
        self.latency_ms = 0.0
        self.left = frames

    def add(self, answer: Answer, seconds: float) -> None:
        """An answer, and how long it took."""
        k = answer.seq
        self.positions[k], self.reliability[k], self.std[k] = answer.joints, answer.reliability, answer.std
        self.round_trip[k] = seconds
        self.latency_ms = answer.latency_ms
        for flag in answer.flags:
            self.flags[flag] = self.flags.get(flag, 0) + 1
        self.left -= 1

    def replayed(self, postures: Postures) -> Replayed:
        """All that came, in the order of the recording."""
        answers = Postures(
            postures.names,
            self.positions,
            postures.times,
            state=postures.state,
            std=self.std,
            reliability=np.nan_to_num(self.reliability, nan=0.0),
        )
        return Replayed(answers, self.round_trip, self.refused, self.flags, self.latency_ms)


async def _hear(connection: "ClientConnection", record: _Record, at: Floats) -> None:
    """Read answers until all frames have one."""
    while record.left:
        message = await connection.recv()
        came = perf_counter()
        try:
            answer = read_answer(message, record.joints)
        except MessageError as error:
            if error.seq is None or not 0 <= error.seq < len(at):
                raise FileError(f"the server says: {error}") from None
            record.refused[error.seq] = str(error)
            record.left -= 1
            continue
        record.add(answer, came - at[answer.seq])
