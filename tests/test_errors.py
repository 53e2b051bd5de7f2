"""How messages count."""

import pytest

from motionmend.errors import counted, interrupt_in


@pytest.mark.parametrize(("number", "said"), [(0, "0 frames"), (1, "1 frame"), (2, "2 frames"), (100, "100 frames")])
def test_one_is_singular(number: int, said: str) -> None:
    assert counted(number, "frame") == said


def test_an_interrupt_is_found_behind_what_it_caused():
    interrupt = KeyboardInterrupt()
    first, second = SystemError("first"), RuntimeError("second")
    first.__cause__ = interrupt
    second.__cause__ = first
    assert interrupt_in(second) is interrupt
    assert interrupt_in(interrupt) is interrupt
    assert interrupt_in(ValueError("none")) is None
