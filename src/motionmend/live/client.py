"""One client of the server, from its first message to its last."""

import asyncio
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, TypeAlias

from .listeners import Listener
from .mailbox import Mailbox
from .messages import MOST_BYTES, MessageError, decode, is_end, is_hello
from .session import now

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection

    from .desk import Desk

MOST_RATE: Final = 2_000.0  # messages a second of one client; beyond, they are read more slowly and none is lost
BURST: Final = 1_000.0  # messages that may come at once
AHEAD: Final = 4  # messages read for one answered where there is too much to do: what is old is dropped, not waited for

Item: TypeAlias = "tuple[bytes | str, float]"  # a message, and when it came in s


@dataclass
class Counts:
    """What a server has done so far: clients that came, frames answered and dropped, errors answered."""

    clients: int = 0
    frames: int = 0
    dropped: int = 0
    errors: int = 0


async def read_messages(connection: "ServerConnection", mailbox: Mailbox[Item]) -> None:
    """Put what a client sends into its box until it leaves; frames push out older ones, the rest waits for room."""
    allowed, since, read = BURST, now(), 0
    async for message in connection:
        t_in = now()
        allowed, since = min(BURST, allowed + (t_in - since) * MOST_RATE) - 1.0, t_in
        if _is_frame(message):
            mailbox.put_frame((message, t_in))
        else:  # what is too long is not kept, only refused
            await mailbox.put((message[: MOST_BYTES + 1], t_in))
        read += 1
        if allowed < 0.0:
            await asyncio.sleep(-allowed / MOST_RATE)
        elif read % AHEAD == 0:
            await asyncio.sleep(0)


def _is_frame(message: bytes | str) -> bool:
    try:
        fields, _ = decode(message)
    except MessageError:
        return False
    return not is_hello(fields) and not is_end(fields)


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

    told = 0  # of the frames dropped
    while (item := await mailbox.get()) is not None:
        late = ("dropped",) if mailbox.dropped > told else ()
        told = mailbox.dropped
        reply = await desk.reply(client, *item, late, listener.wants(client))
        for one in (*reply.before, reply):
            if one.hello is not None:
                listener.opened(client, one.hello)
            if one.data is not None:
                try:
                    await connection.send(one.data)
                except ConnectionClosed:
                    return
                counts.errors += one.error
                counts.frames += not one.error
            if one.frame is not None and one.answer is not None:
                listener.frame(client, one.frame, one.answer)
