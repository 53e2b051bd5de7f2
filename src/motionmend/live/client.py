"""One client of the server, from its first message to its last."""

import asyncio
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, TypeAlias

from .listeners import Listener
from .mailbox import Mailbox
from .messages import (
    Frame,
    Hello,
    MessageError,
    decode,
    encode_answer,
    encode_error,
    is_hello,
    read_frame,
    read_hello,
)
from .session import leaving, now

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection

    from .desk import Desk

MOST_RATE: Final = 2_000.0  # messages a second of one client; beyond, they are read more slowly and none is lost
BURST: Final = 1_000.0  # messages that may come at once
NO_HELLO: Final = "a hello {v, skeleton, fps, units} was wanted before the first frame"

Item: TypeAlias = "tuple[Hello | Frame | MessageError, bool, float]"  # what came, whether as JSON, and when in s


@dataclass
class Counts:
    """What a server has done so far: clients that came, frames answered and dropped, errors answered."""

    clients: int = 0
    frames: int = 0
    dropped: int = 0
    errors: int = 0


async def read_messages(connection: "ServerConnection", mailbox: Mailbox[Item]) -> None:
    """Put what a client sends into its box until it leaves; frames push out older ones, the rest waits for room."""
    hello: Hello | None = None
    allowed, since = BURST, now()
    async for message in connection:
        t_in = now()
        allowed, since = min(BURST, allowed + (t_in - since) * MOST_RATE) - 1.0, t_in
        text = isinstance(message, str)
        try:
            fields, _ = decode(message)
            if is_hello(fields):
                hello = None
                hello = read_hello(fields)
                await mailbox.put((hello, text, t_in))
            elif hello is None:
                raise MessageError(NO_HELLO, fields["seq"] if type(fields.get("seq")) is int else None)
            else:
                mailbox.put_frame((read_frame(fields, hello, text), text, t_in))
        except MessageError as error:
            await mailbox.put((error, text, t_in))
        if allowed < 0:
            await asyncio.sleep(-allowed / MOST_RATE)


async def answer_messages(
    client: int,
    connection: "ServerConnection",
    mailbox: Mailbox[Item],
    desk: "Desk",
    listener: Listener,
    counts: Counts,
) -> None:
    """Answer what is in a client's box, in its order, until the box is closed and empty or the client gone."""
    from websockets.exceptions import ConnectionClosed

    begun = False
    told = 0  # of the frames dropped
    while (item := await mailbox.get()) is not None:
        what, text, t_in = item
        try:
            if isinstance(what, Hello):
                begun = False
                await desk.open(client, what)
                begun = True
                listener.opened(client, what)
                continue
            if isinstance(what, MessageError):
                raise what
            if not begun:  # its hello came and could not be used
                raise MessageError(NO_HELLO, what.seq)
            answer = await desk.answer(client, what, t_in)
            late = ("dropped",) if mailbox.dropped > told else ()
            told, answer = mailbox.dropped, leaving(answer, *late)
            await connection.send(encode_answer(answer, what.form))
            counts.frames += 1
            listener.frame(client, what, answer)
        except MessageError as error:
            counts.errors += 1
            await connection.send(encode_error(error, text))
        except ConnectionClosed:
            return
        await asyncio.sleep(0)  # the next client's turn
