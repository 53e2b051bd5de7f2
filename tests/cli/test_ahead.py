"""Pieces read ahead come in order, one at a time, with the errors of their reading."""

import threading

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.cli.ahead import ahead


@given(st.integers(0, 30))
@settings(max_examples=20, deadline=None)
def test_pieces_come_in_order_and_once(count):
    asked = []

    def read(number):
        asked.append(number)
        return number * number

    assert list(ahead(read, count)) == [n * n for n in range(count)]
    assert asked == list(range(count))


def test_one_piece_is_read_while_the_one_before_is_worked_on_and_no_more():
    reached = [threading.Event() for _ in range(5)]

    def read(number):
        reached[number].set()
        return number

    for number in ahead(read, 5):
        if number < 4:
            assert reached[number + 1].wait(5.0)
        assert not any(event.is_set() for event in reached[number + 2 :])


def test_an_error_is_raised_where_its_piece_is_asked_for():
    def read(number):
        if number == 2:
            raise ValueError("damaged")
        return number

    pieces = ahead(read, 4)
    assert [next(pieces), next(pieces)] == [0, 1]
    with pytest.raises(ValueError, match="damaged"):
        next(pieces)
