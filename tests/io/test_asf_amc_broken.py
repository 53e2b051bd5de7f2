"""Damaged .asf and .amc files: one line that says where, never a wrong motion."""

import pytest
from acclaim_files import ASF, FRAMES, HEADER, read_frames
from hypothesis import given, settings
from hypothesis import strategies as st

from motionmend.errors import FileError
from motionmend.io import text as pieces
from motionmend.io.amc import read_amc
from motionmend.io.asf import read_asf

BROKEN_AMC = {
    "empty": ("", "came an empty file"),
    "blank": ("\n \n\t\n", "came an empty file"),
    "binary": ("\0\1\2\3" * 9, "binary data"),
    "no frames": (HEADER, "found no frame"),
    "not an amc": ("hello world\n1\nroot 0 0 0 0 0 0\n", "line 1: wanted a :KEYWORD"),
    "unknown bone": (HEADER + FRAMES.replace("leg -21", "lag -21"), "line 12: wanted a bone of small.asf"),
    "too few values": (HEADER + FRAMES.replace("leg -21 5.5", "leg -21"), "line 12: wanted 2 values for leg"),
    "too many values": (HEADER + FRAMES.replace("leg -21 5.5", "leg -21 5.5 9"), "line 12: wanted 2 values"),
    "no number": (HEADER + FRAMES.replace("-21", "abc"), "line 12: wanted a number or nan for leg, came 'abc'"),
    "python number": (HEADER + FRAMES.replace("-21", "-2_1"), "line 12: wanted a number"),
    "beyond all measure": (HEADER + FRAMES.replace("-21", "1e308"), "line 12: wanted a number"),
    "infinite": (HEADER + FRAMES.replace("-21", "inf"), "line 12: wanted a number"),
    "garbage": (HEADER + FRAMES.replace("-21", "\x01\x7fé"), "line 12: wanted a number"),
    "twice": (HEADER + FRAMES.replace("foot 7.5", "leg 7.5 1"), "line 13: leg comes twice in frame 2"),
    "bone without values": (HEADER + FRAMES.replace("leg -21 5.5", "hip 3"), "line 12: wanted 0 values for hip"),
    "cut in the last row": (HEADER + FRAMES.replace("foot 8\n", "foo"), "line 18: wanted a bone"),
    "cut before the last row": (HEADER + FRAMES.replace("foot 8\n", ""), "line 17: frame 3 wants bones up to foot"),
    "cut after the number": (HEADER + FRAMES[: FRAMES.index("3\n") + 2], "wants bones up to foot"),
    "bad rate": (":SAMPLES-PER-SECOND fast\n" + FRAMES, "line 1: wanted the rate in Hz"),
    "keyword between": (HEADER + FRAMES.replace("\n2\n", "\n:KEY\n2\n"), "line 9: wanted a bone"),
}


@pytest.mark.parametrize("piece", [pieces.PIECE, 30])
@pytest.mark.parametrize("name", BROKEN_AMC)
def test_broken_motions_say_where_and_why(folder, monkeypatch, name, piece):
    monkeypatch.setattr(pieces, "PIECE", piece)
    text, message = BROKEN_AMC[name]
    with pytest.raises(FileError) as failure:
        read_frames(folder, text)
    said = str(failure.value)
    assert message in said
    assert "small_01.amc" in said
    assert "\n" not in said
    assert len(said) < 400


BROKEN_ASF = {
    "empty": (lambda t: "", "empty file"),
    "no text": (lambda t: "\0" + t, "binary data"),
    "no keyword": (lambda t: "hello\n" + t, "line 1: wanted an Acclaim skeleton's :keyword"),
    "cut in a bone": (lambda t: t[: t.index("name foot")], "no :hierarchy"),
    "no end": (lambda t: t.replace("  end\n:hier", ":hier"), "no 'end'"),
    "no begin": (lambda t: t.replace("  begin\n     id 3", "     id 3"), "wanted 'begin' of a bone, came 'id'"),
    "no length": (lambda t: t.replace("     length 2\n", ""), "line 27: wanted the bone's length"),
    "no direction": (lambda t: t.replace("     direction 0 0 1\n", ""), "line 27: wanted the bone's direction"),
    "two numbers": (lambda t: t.replace("direction 0 0 1", "direction 0 1"), "wanted 3 numbers for direction"),
    "no number": (lambda t: t.replace("length 2\n", "length two\n"), "wanted 1 number for length, came 'two'"),
    "limits": (lambda t: t.replace("(-45 90)", "(-45)"), "wanted 2 numbers for limits of foot"),
    "order": (lambda t: t.replace("20 ZYX", "20 ZZX"), "axis order"),
    "stretch": (lambda t: t.replace("dof rx\n", "dof l\n"), "stretches along itself"),
    "dof": (lambda t: t.replace("dof rx\n", "dof qx\n"), "came 'qx'"),
    "dof twice": (lambda t: t.replace("dof rx rz", "dof rx rx"), "twice"),
    "bone twice": (lambda t: t.replace("name foot", "name Leg"), "bone 'Leg' comes twice"),
    "unknown child": (lambda t: t.replace("leg foot\n", "leg fool\n"), "names 'fool'"),
    "two parents": (lambda t: t.replace("leg foot\n", "leg foot\n head foot\n"), "two parents"),
    "not connected": (lambda t: t.replace("    leg foot\n", ""), "does not connect bone 'foot'"),
    "circle": (lambda t: t.replace("    hip leg\n", "").replace("leg foot", "leg foot\nfoot leg"), "connect"),
    "no order": (lambda t: t.replace("order TX TY TZ RX RY RZ", ""), "root's order"),
    "unit": (lambda t: t.replace("length 0.45", "length 0"), "unit of length above 0"),
    "hardly a unit": (lambda t: t.replace("length 0.45", "length 1e-320"), "unit of length above 0"),
}


@pytest.mark.parametrize("name", BROKEN_ASF)
def test_broken_skeletons_say_where_and_why(tmp_path, name):
    change, message = BROKEN_ASF[name]
    path = tmp_path / "small.asf"
    path.write_text(change(ASF))
    with pytest.raises(FileError) as failure:
        read_asf(path)
    assert message in str(failure.value)
    assert "small.asf" in str(failure.value)
    assert "\n" not in str(failure.value)


@settings(max_examples=150)
@given(st.data())
def test_no_damage_ends_in_a_traceback(tmp_path_factory, data):
    """Whatever is cut off or overwritten: a motion or one clear line."""
    folder = tmp_path_factory.mktemp("damaged")
    files = {"small.asf": ASF, "small_01.amc": HEADER + FRAMES}
    name = data.draw(st.sampled_from(list(files)))
    raw = bytearray(files[name].encode())
    for _ in range(data.draw(st.integers(0, 3))):
        raw[data.draw(st.integers(0, len(raw) - 1))] = data.draw(st.integers(0, 255))
    raw = raw[: data.draw(st.integers(0, len(raw)))] if data.draw(st.booleans()) else raw
    for key, text in files.items():
        (folder / key).write_bytes(bytes(raw) if key == name else text.encode())
    said = ""
    try:
        motion = read_amc(folder / "small_01.amc")
    except FileError as failure:
        said = str(failure)
    if said:
        assert "\n" not in said
        assert name in said
    else:
        assert motion.q.shape == (motion.frames, len(motion.channels))


def test_a_missing_file_and_a_folder_are_one_line(folder):
    with pytest.raises(FileError, match=r"none\.amc: wanted an Acclaim motion .*cannot open"):
        read_amc(folder / "none.amc")
    with pytest.raises(FileError, match="cannot open"):
        read_amc(folder)
