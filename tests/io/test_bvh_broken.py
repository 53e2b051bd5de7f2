"""Broken Biovision files: a motion, or one clear line that says where and why."""

import pytest
from biovision_files import TEXT, VALUES, read_text
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.errors import FileError
from motionmend.io import text as pieces
from motionmend.io.bvh import read_bvh

BROKEN = {
    "empty": (lambda t: "", "came an empty file"),
    "binary": (lambda t: t + "\0\0", "binary data"),
    "no bvh": (lambda t: "hello " + t, "line 1: wanted HIERARCHY, came 'hello'"),
    "cut in the hierarchy": (lambda t: t[: t.index("LeftFoot")], "joint's name"),
    "cut in a joint": (lambda t: t[: t.index("OFFSET 10")], "wanted a brace to close joint LeftFoot"),
    "cut before MOTION": (lambda t: t[: t.index("MOTION")], "wanted MOTION"),
    "no frame time": (lambda t: t.replace("Frame Time: 0.00833333\n", ""), "wanted MOTION"),
    "frame time zero": (lambda t: t.replace("0.00833333", "0"), "line 27: wanted the frame time"),
    "frame time word": (lambda t: t.replace("0.00833333", "fast"), "line 27: wanted the frame time in seconds"),
    "frames word": (lambda t: t.replace("Frames: 3", "Frames: some"), "line 26: wanted the number of frames"),
    "no frames": (lambda t: t.replace("Frames: 3", "Frames: 0"), "wanted the number of frames, came '0'"),
    "too few frames": (lambda t: t.replace("Frames: 3", "Frames: 4"), "wanted 4 frames as stated"),
    "no values": (lambda t: t.replace(VALUES, ""), "wanted 3 frames as stated after 'Frames:', came 0"),
    "cut in a row": (lambda t: t[: t.rindex(" 4 5")] + "\n", "line 30: wanted 10 values, one for each channel, came 8"),
    "cut a row": (lambda t: t[: t.rindex("1 90.5")], "came 2; the file is cut off"),
    "no number": (lambda t: t.replace("2.5", "2,5"), "line 29: wanted a number or nan, came '2,5'"),
    "python number": (lambda t: t.replace("2.5", "2_5"), "line 29: wanted a number"),
    "beyond all measure": (lambda t: t.replace("2.5", "1e308"), "line 29: wanted a number"),
    "infinite": (lambda t: t.replace("2.5", "-inf"), "line 29: wanted a number"),
    "garbage": (lambda t: t.replace("2.5", "\x07é\x7f"), "line 29: wanted a number"),
    "words after": (lambda t: t + "the end\n", "line 31: wanted a number or nan, came 'the'"),
    "unknown channel": (lambda t: t.replace("1 Xrotation", "1 Wrotation"), "line 18: wanted 1 different channels"),
    "missing channel": (lambda t: t.replace("1 Xrotation", "2 Xrotation"), "for LeftFoot, came 'End'"),
    "channel twice": (lambda t: t.replace("1 Xrotation", "2 Xrotation Xrotation"), "came 'Xrotation'"),
    "channel count": (lambda t: t.replace("CHANNELS 1", "CHANNELS 1.5"), "wanted 0 to 6 CHANNELS"),
    "no count": (lambda t: t.replace("CHANNELS 1 ", "CHANNELS "), "wanted a number for CHANNELS, came 'Xrotation'"),
    "no channels": (
        lambda t: "\n".join(line for line in t.splitlines() if "CHANNELS" not in line),
        "wanted at least one joint with CHANNELS",
    ),
    "offset": (lambda t: t.replace("OFFSET 10 -80 0", "OFFSET 10 -80"), "number for OFFSET, came 'CHANNELS'"),
    "no offset": (lambda t: t.replace("OFFSET 10 -80 0", ""), "joint 'LeftFoot' has no OFFSET"),
    "brace": (lambda t: t.replace("\t}\n\tJOINT Left", "\tJOINT Left"), "wanted a brace to close joint Hips"),
    "brace too many": (lambda t: t.replace("}\nMOTION", "}\n}\nMOTION"), "wanted ROOT, came '}'"),
    "root in root": (lambda t: t.replace("JOINT Left", "ROOT Left"), "'ROOT' stands in the wrong place"),
    "no root": (lambda t: t.replace("ROOT Hips", "JOINT Hips"), "line 2: 'JOINT' stands in the wrong place"),
    "unknown word": (lambda t: t.replace("\tOFFSET 10", "\tSCALE 10"), "came 'SCALE'"),
}


@pytest.mark.parametrize("piece", [pieces.PIECE, 30])
@pytest.mark.parametrize("name", BROKEN)
def test_broken_files_say_where_and_why(tmp_path, monkeypatch, name, piece):
    monkeypatch.setattr(pieces, "PIECE", piece)
    change, message = BROKEN[name]
    with pytest.raises(FileError) as failure:
        read_text(tmp_path, change(TEXT))
    said = str(failure.value)
    assert message in said
    assert "small.bvh" in said
    assert "\n" not in said
    assert len(said) < 400


@settings(max_examples=150)
@given(st.data())
def test_no_damage_ends_in_a_traceback(tmp_path_factory, data):
    """Whatever is cut off or overwritten: a motion or one clear line."""
    raw = bytearray(TEXT.encode())
    for _ in range(data.draw(st.integers(0, 3))):
        raw[data.draw(st.integers(0, len(raw) - 1))] = data.draw(st.integers(0, 255))
    raw = raw[: data.draw(st.integers(0, len(raw)))] if data.draw(st.booleans()) else raw
    path = tmp_path_factory.mktemp("damaged") / "small.bvh"
    path.write_bytes(bytes(raw))
    said = ""
    try:
        motion = read_bvh(path)
    except FileError as failure:
        said = str(failure)
    if said:
        assert "\n" not in said
        assert "small.bvh" in said
    else:
        assert motion.q.shape == (motion.frames, len(motion.channels))
