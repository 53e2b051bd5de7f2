"""Where messages are answered: in the server's own process, or by a staff of others (staff.py)."""

import asyncio
from typing import TYPE_CHECKING, Protocol, final

from .session import Reply, Session, replied

if TYPE_CHECKING:
    from ..correct import CorrectorModel


class Desk(Protocol):
    """Keeps a session for every client; a client has at most one message under way."""

    async def reply(
        self, client: int, message: bytes | str, t_in: float, flags: tuple[str, ...] = (), whole: bool = False
    ) -> Reply:
        """What is to be done about a client's message; parameters as of `session.replied`."""

    def close(self, client: int) -> None:
        """Forget a client, whether it had a session or not."""

    async def leave(self) -> None:
        """End all that was begun."""


@final
class OwnDesk:
    """All sessions in this process.

    Parameters
    ----------
    model : the corrector.
    online : whether it learns from the clients' frames, from each for itself.
    look_ahead : s of frames for which an answer waits.
    """

    def __init__(self, model: "CorrectorModel", online: bool = False, look_ahead: float = 0.0) -> None:
        self._model = model
        self._online = online
        self._look_ahead = look_ahead
        self._sessions: dict[int, Session | None] = {}

    async def reply(
        self, client: int, message: bytes | str, t_in: float, flags: tuple[str, ...] = (), whole: bool = False
    ) -> Reply:
        """What is to be done about a client's message; parameters as of `session.replied`."""
        await asyncio.sleep(0)  # the others' turn
        session = self._sessions.get(client)
        self._sessions[client], reply = replied(
            self._model, session, message, t_in, flags, whole, self._online, self._look_ahead
        )
        return reply

    def close(self, client: int) -> None:
        """Forget a client, whether it had a session or not."""
        self._sessions.pop(client, None)

    async def leave(self) -> None:
        """End all that was begun."""
        self._sessions.clear()
