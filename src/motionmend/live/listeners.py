"""Who else wants the corrected frames: avatars, laboratories, people at the page."""

from collections.abc import Callable, Iterable
from typing import Protocol, final

from .messages import Answer, Frame, Hello


class Listener(Protocol):
    """Told of every client and every corrected frame, in their order, in the server's own thread: it must not block."""

    def opened(self, client: int, hello: Hello) -> None:
        """A client has begun, or begun anew."""

    def wants(self, client: int) -> bool:
        """Whether it is told of this client's frames now."""

    def frame(self, client: int, frame: Frame, answer: Answer) -> None:
        """A frame of a client that has begun was corrected."""

    def closed(self, client: int) -> None:
        """A client has left, whether it had begun or not."""


@final
class Listeners:
    """Several listeners as one; one that fails is left out from then on, and the server goes on without it."""

    def __init__(self, listeners: Iterable[Listener], say: Callable[[str], None]) -> None:
        self._listeners = list(listeners)
        self._say = say

    def opened(self, client: int, hello: Hello) -> None:
        """A client has begun, or begun anew."""
        self._tell(lambda one: one.opened(client, hello))

    def wants(self, client: int) -> bool:
        """Whether one of them is told of this client's frames now."""
        found: list[bool] = []
        self._tell(lambda one: found.append(one.wants(client)))
        return any(found)

    def frame(self, client: int, frame: Frame, answer: Answer) -> None:
        """A frame of a client that has begun was corrected."""
        self._tell(lambda one: one.frame(client, frame, answer) if one.wants(client) else None)

    def closed(self, client: int) -> None:
        """A client has left, whether it had begun or not."""
        self._tell(lambda one: one.closed(client))

    def _tell(self, call: Callable[[Listener], None]) -> None:
        for one in tuple(self._listeners):
            try:
                call(one)
            except Exception as error:
                self._listeners.remove(one)
                self._say(f"warning: {type(one).__name__} is left out from now on: {type(error).__name__}: {error}")
