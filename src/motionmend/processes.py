"""Processes on this machine, each on a line of its own: whatever becomes of one, no other hears of it.

The pool of `concurrent.futures` has one queue for all answers. Of a process that is killed in the middle of an answer
(a large one, when memory runs short) half of it stays there, and the rest is waited for for ever.
"""

import multiprocessing
import os
import pickle
import signal
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Future, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import connection, resource_tracker
from multiprocessing.reduction import ForkingPickler
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar, final

if TYPE_CHECKING:
    from multiprocessing.process import BaseProcess

PATIENCE = 2.0  # s that processes have to clear away what they were writing
BLAS_VARIABLES = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")

_Given = ParamSpec("_Given")
_Value = TypeVar("_Value")


@dataclass(frozen=True, eq=False)
class _Hand:
    """One process and this process's end of the line to it."""

    process: "BaseProcess"
    line: "connection.Connection[Any, Any]"


@final
class Crew:
    """Runs calls in processes that are started when they are first needed.

    A call during which its process dies raises `BrokenExecutor`; the next one is given another process.

    Parameters
    ----------
    width : calls that run at once, >= 1.
    """

    def __init__(self, width: int) -> None:
        self._threads = ThreadPoolExecutor(width)  # one waits at each line
        self._lock = threading.Lock()
        self._hands: set[_Hand] = set()
        self._idle: list[_Hand] = []
        self._leaving = False

    def submit(self, fn: Callable[_Given, _Value], /, *args: _Given.args, **kwargs: _Given.kwargs) -> Future[_Value]:
        """Run a call, importable by name in another process, as soon as one is free."""
        return self._threads.submit(self._ask, fn, args, kwargs)

    def dismiss(self) -> None:
        """End the processes, each when it has finished what it is at; what has not begun is cancelled."""
        self._threads.shutdown(cancel_futures=True)
        for hand in list(self._hands):
            hand.line.close()
        for hand in list(self._hands):
            hand.process.join()

    def abandon(self) -> None:
        """End the processes whatever they are at: each clears away what it was writing, none is waited for longer."""
        with self._lock:
            self._leaving = True
            hands = list(self._hands)
        for hand in hands:
            hand.process.terminate()
        waiting = {hand.process.sentinel for hand in hands}
        deadline = time.monotonic() + PATIENCE
        while waiting and time.monotonic() < deadline:
            waiting.difference_update(connection.wait(list(waiting), max(0.0, deadline - time.monotonic())))
        for hand in hands:
            hand.process.kill()
        self.dismiss()

    def _ask(self, call: Callable[..., _Value], args: tuple[Any, ...], kwargs: dict[str, Any]) -> _Value:
        question = ForkingPickler.dumps((call, args, kwargs))
        hand = self._hand()
        try:
            hand.line.send_bytes(question)
            answer = hand.line.recv_bytes()
        except BaseException as error:  # it may have died, and half a question or answer lies on the line
            self._bury(hand)
            if isinstance(error, (EOFError, OSError)):
                raise BrokenExecutor("the process died") from None
            raise
        with self._lock:
            self._idle.append(hand)
        value, raised = pickle.loads(answer)
        if raised is not None:
            raise raised
        return value  # type: ignore[no-any-return]

    def _hand(self) -> _Hand:
        with self._lock:
            if self._leaving:
                raise BrokenExecutor("the processes are being ended")
            if self._idle:
                return self._idle.pop()
            try:
                hand = _hired()
            except OSError as error:  # neither memory nor processes are without end
                raise BrokenExecutor(str(error)) from None
            self._hands.add(hand)
            return hand

    def _bury(self, hand: _Hand) -> None:
        hand.process.kill()
        hand.process.join()
        hand.line.close()
        with self._lock:
            self._hands.discard(hand)


def _hired() -> _Hand:
    """A process started afresh: a forked copy of a process with threads may hang."""
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_serve, args=(theirs,))
    try:
        with _interrupts_waiting():
            process.start()
    except BaseException:
        ours.close()
        raise
    finally:
        theirs.close()  # the line ends with the process only if nobody else holds its end
    return _Hand(process, ours)


@contextmanager
def _interrupts_waiting() -> Iterator[None]:
    """Processes started meanwhile never hear Ctrl-C, not even before their first line."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    # what multiprocessing starts beside the first process lets interrupts through once it runs
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


class _Dismissed(SystemExit):
    """In a process that was told to end: what it was writing is cleared away on the way out."""


def _dismissed(_signal: int, _frame: object) -> None:
    signal.signal(signal.SIGTERM, signal.SIG_IGN)  # once is enough, and clearing away must not be interrupted
    # What is being imported or compiled just now would complain, each in its own way.
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    raise _Dismissed


def left_to_parent() -> None:
    """Let Ctrl-C and a terminal that closes be the parent's affair, which ends its processes."""
    for number in (signal.SIGINT, getattr(signal, "SIGHUP", signal.SIGINT)):
        signal.signal(number, signal.SIG_IGN)


def _serve(line: "connection.Connection[Any, Any]") -> None:
    """Answer every call that comes down the line until it ends."""
    os.environ.update(dict.fromkeys(BLAS_VARIABLES, "1"))  # before numpy is loaded
    left_to_parent()
    signal.signal(signal.SIGTERM, _dismissed)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    try:
        with suppress(EOFError, OSError):  # nobody is there any more
            while True:
                line.send_bytes(_answer(line.recv_bytes()))
    except _Dismissed:
        os._exit(0)


def _answer(question: bytes) -> memoryview:
    """What a call returned or raised, as it travels; what cannot travel is raised as an error that can."""
    try:
        call, args, kwargs = pickle.loads(question)
        return ForkingPickler.dumps((call(*args, **kwargs), None))
    except _Dismissed:
        raise
    except BaseException as error:
        try:
            answer = ForkingPickler.dumps((None, error))
            pickle.loads(answer)
        except Exception:
            line = f"{type(error).__name__}: {error}"
            return ForkingPickler.dumps((None, RuntimeError(line)))
        return answer


def _end_with_parent() -> None:
    """End this process when the one that started it is gone, be it killed: nobody would ever send it anything again."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
