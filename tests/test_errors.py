"""How messages count."""

import pytest

from motionmend.errors import counted


@pytest.mark.parametrize(("number", "said"), [(0, "0 frames"), (1, "1 frame"), (2, "2 frames"), (100, "100 frames")])
def test_one_is_singular(number: int, said: str) -> None:
    assert counted(number, "frame") == said
