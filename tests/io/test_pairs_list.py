"""Lists of pairs as people and spreadsheets write them."""

from pathlib import Path

import pytest

from motionmend.errors import FileError
from motionmend.io.pairs_list import Listed, read_pairs_list


@pytest.mark.parametrize(
    "text",
    [
        "sensor,truth,offset_s\na.skl,a.amc,-0.25\nb.skl,b.amc,\n",
        "sensor;truth;offset_s\na.skl;a.amc;-0.25\nb.skl;b.amc;\n",
        "sensor;truth;offset_s\r\na.skl;a.amc;-0,25\r\nb.skl;b.amc;\r\n",
        "offset_s\tsensor\ttruth\n-0,25\ta.skl\ta.amc\n\tb.skl\tb.amc\n",
        "\ufeffSensor, Truth, Offset_s, by\n a.skl , a.amc , -0.25, me\n\nb.skl,b.amc\n",
    ],
)
def test_every_spelling_says_the_same(tmp_path: Path, text: str) -> None:
    (tmp_path / "pairs.csv").write_text(text, "utf-8", newline="")
    first, second = read_pairs_list(tmp_path / "pairs.csv")
    assert first == Listed(tmp_path / "a.skl", tmp_path / "a.amc", -0.25, 2)
    assert (second.sensor.name, second.offset) == ("b.skl", None)


@pytest.mark.parametrize("offset", ["soon", "1,2,3", "0.1s"])
def test_an_offset_that_is_no_number_is_told_with_its_line(tmp_path: Path, offset: str) -> None:
    (tmp_path / "pairs.csv").write_text(f"sensor;truth;offset_s\na.skl;a.amc;{offset}\n")
    with pytest.raises(FileError, match="offset_s in line 2") as told:
        read_pairs_list(tmp_path / "pairs.csv")
    assert offset in str(told.value)
