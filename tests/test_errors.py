"""How messages count."""

import pytest

from motionmend.errors import counted, interrupt_in, one_line


@pytest.mark.parametrize(("number", "said"), [(0, "0 frames"), (1, "1 frame"), (2, "2 frames"), (100, "100 frames")])
def test_one_is_singular(number: int, said: str) -> None:
    assert counted(number, "frame") == said


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("a  b.bvh: no", "a  b.bvh: no"),
        ("a\nb.bvh: no", "a b.bvh: no"),
        ("first\r\n\n   second\n", "first second"),
        ("", ""),
    ],
)
def test_a_message_is_one_line_and_names_keep_their_blanks(text: str, line: str) -> None:
    assert one_line(text) == line


def test_an_interrupt_is_found_behind_what_it_caused():
    interrupt = KeyboardInterrupt()
    first, second = SystemError("first"), RuntimeError("second")
    first.__cause__ = interrupt
    second.__cause__ = first
    assert interrupt_in(second) is interrupt
    assert interrupt_in(interrupt) is interrupt
    assert interrupt_in(ValueError("none")) is None
