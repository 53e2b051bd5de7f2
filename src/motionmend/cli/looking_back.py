"""A recording looked back at by a second process, while the first follows the body on."""

import pickle
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future
from contextlib import contextmanager
from typing import TYPE_CHECKING

from ..batch import workers

if TYPE_CHECKING:
    from ..processes import Crew
    from ..track.hindsight.backwards import Moment
    from ..track.model import TrackerModel
    from ..track.outcome import Estimate
    from ..track.settings import TrackSettings

WORTH = 450  # frames, from which on a second process does more than its start and what is sent to it cost
AT_ONCE = 2  # stretches it is given at a time: one it looks back at, and one that waits for it


@contextmanager
def second_process(frames: int, *, idle: bool) -> "Iterator[Crew | Executor | None]":
    """A process that looks back, being started; None where the recording is too short or no processor is idle.

    Parameters
    ----------
    frames : of the recording. idle : whether another processor has nothing to do.
    """
    if not idle or frames < WORTH:
        yield None
        return
    import cv2  # noqa: F401  # while it is loaded its folder is first in the path, which a new process would inherit

    with workers(1) as found:
        found.executor().submit(made_ready)
        yield found.executor()


def made_ready() -> None:
    """Load what looking back needs, while the body is still being measured."""
    from ..track.hindsight import backwards  # noqa: F401


def revised_beside(
    other: "Crew | Executor | None", model: "TrackerModel", settings: "TrackSettings", moments: "Iterable[Moment]"
) -> "Iterator[Estimate]":
    """The same as `track.hindsight.backwards.revised`, to the bit, with another process to look back.

    What it has no time for is looked back at here: nobody waits for a process that is slow to start, is slow, or dies.

    Parameters
    ----------
    other : from `second_process`; with None all is done here.
    model, settings, moments : as for `revised`.
    """
    from ..track.hindsight.backwards import WINDOW, looked_back, revised, stretches

    if other is None or not settings.hindsight:
        yield from revised(model, settings, moments)
        return
    knowing = pickle.dumps((model, settings))
    told: deque[tuple[Future[tuple[Estimate, ...]], list[Moment]]] = deque()

    def first() -> "tuple[Estimate, ...]":
        future, some = told.popleft()
        try:
            return future.result()
        except BrokenExecutor:  # it was killed, or there was no memory for one
            return looked_back(model, settings, some, WINDOW)

    # Packed one by one: a whole stretch at once would hold up the next frame, for it is Python's work
    for both, count in stretches((one, pickle.dumps(one)) for one in moments):
        while told and told[0][0].done():
            yield from first()
        some = [one for one, _ in both]
        if count < len(both) and sum(not future.done() for future, _ in told) < AT_ONCE:
            told.append((other.submit(_there, knowing, [packed for _, packed in both], count), some))
            continue
        here: Future[tuple[Estimate, ...]] = Future()
        here.set_result(looked_back(model, settings, some, count))
        told.append((here, []))
    while told:
        yield from first()


def _there(knowing: bytes, packed: Sequence[bytes], count: int) -> "tuple[Estimate, ...]":
    """`looked_back` in the other process."""
    from ..track.hindsight.backwards import looked_back

    model, settings = pickle.loads(knowing)
    return looked_back(model, settings, [pickle.loads(one) for one in packed], count)
