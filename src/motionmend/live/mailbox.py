"""What a client has sent and the server has not answered: bounded, and the oldest frames make way."""

import asyncio
from collections import deque
from typing import Final, Generic, TypeVar, final

Item = TypeVar("Item")

MOST_FRAMES: Final = 8  # waiting; the messages promise that 4 unanswered ones are never dropped
MOST_OTHERS: Final = 8  # hellos and errors waiting; then their sender waits too


@final
class Mailbox(Generic[Item]):
    """A queue between one reader and one worker of the same event loop.

    Frames never wait to get in: beyond `MOST_FRAMES` the oldest is dropped. Anything else is never dropped: its sender
    waits until there is room.
    """

    def __init__(self) -> None:
        self._items: deque[tuple[bool, Item]] = deque()
        self._frames = 0
        self._changed = asyncio.Event()
        self._closed = False
        self.dropped = 0

    def put_frame(self, item: Item) -> None:
        """Add a frame at the end; drops the oldest frame where there are too many."""
        if self._frames == MOST_FRAMES:
            oldest = next(k for k, (is_frame, _) in enumerate(self._items) if is_frame)
            del self._items[oldest]
            self._frames -= 1
            self.dropped += 1
        self._items.append((True, item))
        self._frames += 1
        self._changed.set()

    async def put(self, item: Item) -> None:
        """Add what must not be lost at the end; waits while too many of its kind do."""
        while len(self._items) - self._frames >= MOST_OTHERS and not self._closed:
            self._changed.clear()
            await self._changed.wait()
        self._items.append((False, item))
        self._changed.set()

    async def get(self) -> Item | None:
        """The first item; waits for one; None when the box is closed and empty."""
        while not self._items:
            if self._closed:
                return None
            self._changed.clear()
            await self._changed.wait()
        is_frame, item = self._items.popleft()
        self._frames -= is_frame
        self._changed.set()
        return item

    def close(self) -> None:
        """Nothing more comes: what waits is still given out."""
        self._closed = True
        self._changed.set()
