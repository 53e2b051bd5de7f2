"""What workers are given to do in tests of batches, in a file of its own: they need not load what the tests need."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

from motionmend.errors import FileError


def square(item: int) -> int:
    return item * item


def square_or_fail(item: int) -> int:
    if item % 3 == 0:
        raise FileError(f"item {item} is a multiple of three")
    if item == 4:
        raise ZeroDivisionError("four\nis bad")
    return item * item


def leave_a_mark_and_die_once(item: tuple[int, Path]) -> int:
    number, folder = item
    mark = folder / f"{number}-{time.monotonic_ns()}"
    mark.touch()
    if number == 3 and len(list(folder.glob("3-*"))) == 1:
        os._exit(17)
    time.sleep(0.05)
    return number


def die_at_two(item: int) -> int:
    if item == 2:
        os._exit(17)
    time.sleep(0.02)
    return item


def wait_or_die_at_two(item: int) -> int:
    time.sleep(0.3 if item == 2 else 1.0)
    return die_at_two(item)


def first_item_is_slow(item: int) -> int:
    time.sleep(0.4 if item == 0 else 0.0)
    return item


def blas_threads(_: int) -> set[int]:
    import scipy.linalg
    from threadpoolctl import threadpool_info

    scipy.linalg.norm([1.0, 2.0])
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


def ignores_interrupts(_: int) -> bool:
    return signal.getsignal(signal.SIGINT) is signal.SIG_IGN


def never_hears_interrupts(_: int) -> bool:
    return signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, ())


def interrupted_in_compiled_code(_: int) -> int:
    raise SystemError("CPUDispatcher returned a result with an exception set") from KeyboardInterrupt()


def mark_and_wait_for_the_first(item: tuple[int, Path]) -> int:
    number, folder = item
    (folder / str(number)).touch()
    time.sleep(1.0 if number == 0 else 0.0)
    return number


def large_and_cut_off_once(item: tuple[int, Path]) -> bytes:
    """Half of its first answer, which does not fit into the line at once, waits there when its process dies."""
    import psutil

    number, folder = item
    if number == 1 and not (folder / "cut").exists():
        (folder / "cut").touch()
        parent = psutil.Process().parent()
        assert parent is not None
        parent.suspend()  # nobody takes what is answered
        subprocess.Popen(
            [sys.executable, "-c", "import os,signal,sys,time\ntime.sleep(1)\nfor one in sys.argv[1:]:\n"
             " os.kill(int(one), signal.SIGKILL if one == sys.argv[1] else signal.SIGCONT)",
             str(os.getpid()), str(parent.pid)]
        )  # fmt: skip
    return bytes([number]) * (20_000_000 if number == 1 else 1000)


def own_number(_: int) -> int:
    time.sleep(0.2)
    return os.getpid()


def answer_with(item: str) -> object:
    if item == "what cannot travel":
        return lambda: None
    if item == "an error that cannot be rebuilt":
        raise SystemExit(_Unpacked(1, 2))
    return item


class _Unpacked:
    def __init__(self, one: int, two: int) -> None:
        self.both = one, two

    def __reduce__(self) -> tuple[type, tuple[int]]:
        return type(self), (1,)
