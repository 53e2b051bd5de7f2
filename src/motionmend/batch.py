"""Many items, one contract: something that submits, be it this process, local processes or a Dask cluster.

Delivery is at least once: an item whose worker died is sent again, so a task has to be one that may run twice
(read a file, write a file under a temporary name, rename it).
"""

import importlib
import os
import signal
import threading
import time
import traceback
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

from .errors import MotionMendError, UsageError, interrupt_in, one_line
from .processes import BLAS_VARIABLES, Crew

AHEAD = 4  # items for each worker that `in_turn` lets run on while one is waited for
ASKED = 5.0  # s without an answer, after which a cluster is asked whether it has workers yet
DESERTED = 60.0  # s in which it has none, after which nobody is waited for
ATTEMPTS = 3  # times an item is sent before the death of its worker is held against it
_GIVEN_UP = "KilledWorker"  # what Dask says of an item whose workers died, and of those that ran beside it

Item = TypeVar("Item")
Value = TypeVar("Value")
Item_in = TypeVar("Item_in", contravariant=True)
Value_out = TypeVar("Value_out", covariant=True)


class Task(Protocol[Item_in, Value_out]):
    """What `run` repeats; it must be importable by name in another process (no lambda, no inner function)."""

    def __call__(self, item: Item_in, /) -> Value_out: ...


@dataclass(frozen=True)
class Failure:
    """Why an item failed: the name of the exception's type, its one line, and where it arose."""

    kind: str
    message: str
    traceback: str


@dataclass(frozen=True)
class Outcome(Generic[Item, Value]):
    """What became of one item: `value` where `failure` is None."""

    index: int
    item: Item
    value: Value | None
    failure: Failure | None


def run(
    task: Task[Item, Value],
    items: Sequence[Item],
    *,
    jobs: int,
    cluster: str | None = None,
    on_done: Callable[[Outcome[Item, Value]], None] | None = None,
) -> list[Outcome[Item, Value]]:
    """Run a task on every item; a failed item never takes another with it.

    Every task computes with one BLAS thread wherever it runs: sums split over another number of threads are
    rounded differently, and the result would depend on `jobs`.

    Parameters
    ----------
    task : called once for each item, at least; in another process when `jobs` > 1 or with a cluster.
    items : whatever `task` takes.
    jobs : processes on this machine, >= 1; with 1 everything runs in this process. Not used with a cluster.
    cluster : address of a Dask scheduler ("tcp://127.0.0.1:8786") whose workers have motionmend and the files.
    on_done : called in this process with each outcome as it comes, in no particular order.

    Returns
    -------
    One outcome for each item, in the order of `items`.

    Raises
    ------
    UsageError
        When `jobs` is below 1, the cluster cannot be reached, or the extra `cluster` is not installed.
    """
    outcomes: dict[int, Outcome[Item, Value]] = {}

    def done(outcome: Outcome[Item, Value]) -> None:
        outcomes[outcome.index] = outcome
        if on_done is not None:
            on_done(outcome)

    with workers(jobs, cluster) as found:
        _deliver(task, items, found, done, ahead=len(items))
    return [outcomes[index] for index in range(len(items))]


class Workers:
    """Local processes, started when they are first needed and kept for the next task, or those of a cluster.

    Attributes
    ----------
    width : how many items are worked on at once.
    present : how many could be now; a cluster's workers come and go.
    """

    def __init__(self, width: int, cluster: Executor | None = None, present: Callable[[], int] | None = None) -> None:
        self.width = width
        self.present = present or (lambda: width)
        self._cluster = cluster
        self._local: Crew | None = None

    def spare(self, count: int) -> bool:
        """Whether so few items are better worked on in this process."""
        return self._cluster is None and min(count, self.width) <= 1

    def executor(self) -> Executor | Crew:
        """To submit to."""
        if self._cluster is not None:
            return self._cluster
        if self._local is None:
            self._local = Crew(self.width)
        return self._local

    def dismiss(self) -> None:
        """End local processes; the next that are needed are new ones."""
        if self._local is not None:
            self._local.dismiss()
            self._local = None

    def abandon(self) -> None:
        """End local processes whatever they are at: each clears away what it was writing, none is waited for longer."""
        if self._local is not None:
            with _deaf():
                self._local.abandon()
                self._local = None


@contextmanager
def workers(jobs: int, cluster: str | None = None) -> Iterator[Workers]:
    """Workers for several tasks one after the other.

    Parameters
    ----------
    jobs, cluster : as in `run`.

    Raises
    ------
    UsageError
        As `run` does.
    """
    if jobs < 1:
        raise UsageError(f"jobs must be a whole number above 0, came {jobs}")
    if cluster is not None:
        with _dask(cluster) as found_there:
            yield found_there
        return
    found = Workers(jobs)
    try:
        yield found
    except KeyboardInterrupt:
        found.abandon()
        raise
    finally:
        found.dismiss()


@contextmanager
def _deaf() -> Iterator[None]:
    """Another Ctrl-C changes nothing about an end that has begun."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def in_turn(
    task: Task[Item, Value],
    items: Sequence[Item],
    take: Callable[[Outcome[Item, Value]], None],
    found: Workers,
) -> None:
    """Run a task on every item and hand on what comes of each in the order of the items; none is kept.

    For sums over many items: the order of the terms is the same for any number of workers, and while the first is
    waited for, no more than `AHEAD` for each worker run on, so that few wait.

    Parameters
    ----------
    task, items : as in `run`.
    take : called in this process with each outcome in its turn.
    found : from `workers`.
    """
    waiting: dict[int, Outcome[Item, Value]] = {}
    turn = 0

    def done(outcome: Outcome[Item, Value]) -> None:
        nonlocal turn
        waiting[outcome.index] = outcome
        while turn in waiting:
            take(waiting.pop(turn))
            turn += 1

    _deliver(task, items, found, done, ahead=AHEAD * found.width)


def _deliver(
    task: Task[Item, Value],
    items: Sequence[Item],
    found: Workers,
    tell: Callable[[Outcome[Item, Value]], None],
    *,
    ahead: int,
) -> None:
    """Tell of each outcome as it comes; no item is sent that lies `ahead` or more beyond the first not yet done."""

    def done(index: int, result: Value | Failure) -> None:
        if isinstance(result, Failure):
            tell(Outcome(index, items[index], None, result))
        else:
            tell(Outcome(index, items[index], result, None))

    if found.spare(len(items)):
        for index, item in enumerate(items):
            done(index, _attempt(task, item))
    else:
        _spread(found, task, items, done, ahead)


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Hold matrix products to one thread, so that their rounding is the same on every machine of a kind.

    A BLAS library loaded within keeps one thread afterwards.
    """
    from threadpoolctl import threadpool_limits

    unset = [name for name in BLAS_VARIABLES if name not in os.environ]
    os.environ.update(dict.fromkeys(unset, "1"))  # for a library that is loaded later
    try:
        with threadpool_limits(limits=1):  # for those loaded already
            yield
    finally:
        for name in unset:
            os.environ.pop(name, None)


def _attempt(task: Task[Item, Value], item: Item) -> Value | Failure:
    """The task's value, or its exception as something that survives the way back from another process."""
    try:
        with one_blas_thread():
            return task(item)
    except Exception as error:
        return failure(error)


def failure(error: Exception) -> Failure:
    """What an exception says, in one line; call it where the exception was caught.

    Parameters
    ----------
    error : of the package's own kinds, or one that nobody expected.

    Raises
    ------
    KeyboardInterrupt
        Where that is what the error came of: it fails no item, it ends all.
    """
    interrupt = interrupt_in(error)
    if interrupt is not None:
        raise interrupt
    kind = type(error).__name__
    line = one_line(str(error))
    if isinstance(error, OSError) and error.filename is not None and error.strerror:
        line = one_line(f"{error.filename}: {error.strerror}")
    elif not isinstance(error, MotionMendError):
        line = f"unexpected {kind}: {line}" if line else f"unexpected {kind}"
    return Failure(kind, line, traceback.format_exc())


def _spread(
    found: Workers,
    task: Task[Item, Value],
    items: Sequence[Item],
    done: Callable[[int, Value | Failure], None],
    ahead: int,
) -> None:
    """Keep as many items in flight as there are workers; when workers die, run the suspects again one at a time.

    No item is sent that lies `ahead` or more beyond the first one not yet done.

    Alone, none dies of the memory that others need; and where one that died took others with it, only it dies again.
    Where no workers are left, and none come, what is not done has failed.
    """
    todo = deque(range(len(items)))
    suspects: deque[int] = deque()
    attempts = [0] * len(items)
    finished_early: set[int] = set()
    first = 0  # not yet done
    flying: dict[Future[Value | Failure], int] = {}

    def send(index: int) -> None:
        flying[found.executor().submit(_attempt, task, items[index])] = index

    def finish(index: int, result: Value | Failure) -> None:
        nonlocal first
        finished_early.add(index)
        while first in finished_early:
            finished_early.remove(first)
            first += 1
        done(index, result)

    heard = time.monotonic()
    try:
        while todo or suspects or flying:
            if suspects and not flying:
                send(suspects.popleft())
            while todo and not suspects and len(flying) < found.width and todo[0] < first + ahead:
                send(todo.popleft())
            finished, _ = wait(flying, timeout=ASKED, return_when=FIRST_COMPLETED)
            if finished or found.present():
                heard = time.monotonic()
            elif time.monotonic() - heard > DESERTED:
                line = "the cluster has no workers any more: start some and run it again"
                for index in sorted({*flying.values(), *suspects, *todo}):
                    finish(index, Failure("WorkerDied", line, ""))
                break
            lost = []
            for future in finished:
                index = flying.pop(future)
                try:
                    result = future.result()
                except BrokenExecutor:
                    lost.append(index)
                    continue
                except Exception as error:  # the cluster gave up on it, or the item cannot be sent
                    if type(error).__name__ == _GIVEN_UP and not attempts[index]:
                        attempts[index] = 1  # it may have died with another's worker: alone it shows
                        suspects.append(index)
                        continue
                    line = one_line(str(error))
                    result = Failure(type(error).__name__, f"{type(error).__name__}: {line}", "")
                finish(index, result)
            for index in sorted(lost):
                attempts[index] += 1
                if attempts[index] < ATTEMPTS:
                    suspects.append(index)
                else:
                    line = f"its process died {ATTEMPTS} times (out of memory?): try it alone"
                    finish(index, Failure("WorkerDied", line, ""))
    finally:
        for future in flying:
            future.cancel()


@contextmanager
def _dask(address: str) -> Iterator[Workers]:
    """The workers of a Dask cluster."""
    try:
        distributed = importlib.import_module("distributed")
    except ImportError:
        raise UsageError('a cluster needs Dask, which is not installed: pip install "motionmend[cluster]"') from None
    try:
        client = distributed.Client(address, timeout=5)
    except (OSError, ValueError) as error:
        line = one_line(str(error))
        raise UsageError(f"no Dask scheduler answers at {address} ({line}): start `dask scheduler`") from None

    def slots() -> int:
        return sum(client.nthreads().values())

    with client:
        width = slots()
        if width == 0:
            raise UsageError(f"the Dask scheduler at {address} has no workers: start `dask worker {address}`")
        # a file of the same name may hold something else by now
        yield Workers(width, client.get_executor(pure=False), slots)
