"""Where frames are corrected: in the server's own process, or by a staff of others (staff.py)."""

from typing import TYPE_CHECKING, Protocol, final

from .messages import Answer, Frame, Hello
from .session import Session, answered, opened

if TYPE_CHECKING:
    from ..correct import CorrectorModel


class Desk(Protocol):
    """Keeps a session for every client; a client has at most one call under way."""

    async def open(self, client: int, hello: Hello) -> None:
        """Begin a session, or begin it anew. MessageError: the model knows none of the client's joints."""

    async def answer(self, client: int, frame: Frame, t_in: float) -> Answer:
        """Correct a frame of a session that has begun. MessageError: it cannot be corrected."""

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
    """

    def __init__(self, model: "CorrectorModel") -> None:
        self._model = model
        self._sessions: dict[int, Session] = {}

    async def open(self, client: int, hello: Hello) -> None:
        """Begin a session, or begin it anew. MessageError: the model knows none of the client's joints."""
        self._sessions[client] = opened(self._model, hello)

    async def answer(self, client: int, frame: Frame, t_in: float) -> Answer:
        """Correct a frame of a session that has begun. MessageError: it cannot be corrected."""
        self._sessions[client], answer = answered(self._model, self._sessions[client], frame, t_in)
        return answer

    def close(self, client: int) -> None:
        """Forget a client, whether it had a session or not."""
        self._sessions.pop(client, None)

    async def leave(self) -> None:
        """End all that was begun."""
        self._sessions.clear()
