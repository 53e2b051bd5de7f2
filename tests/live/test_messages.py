"""Messages: what is written is read, whatever the form, and whatever else comes is refused in one line."""

import base64
import json

import msgpack
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from motionmend.bodies.joint_sets import JOINT_SETS, KINECT20
from motionmend.live.messages import (
    MOST_BYTES,
    Answer,
    Frame,
    Hello,
    MessageError,
    decode,
    encode_answer,
    encode_error,
    encode_frame,
    encode_hello,
    is_hello,
    read_answer,
    read_frame,
    read_hello,
)

FORMS = ("msgpack", "flat", "rows", "base64")
HELLO = Hello("kinect20", KINECT20.names, 30.0)
GOOD = {"v": 1, "skeleton": "kinect25", "fps": 30, "units": "m"}
places = arrays.arrays(np.float32, (20, 3), elements=st.floats(-90, 90, width=32))
states = arrays.arrays(np.uint8, 20, elements=st.integers(0, 2))


def through(message):
    fields, text = decode(message)
    return read_frame(fields, HELLO, text)


def refusal(message):
    """Why a message, or its fields, cannot be used; None for one that can."""
    try:
        fields, text = (message, False) if isinstance(message, dict) else decode(message)
        read_hello(fields) if is_hello(fields) else read_frame(fields, HELLO, text)
    except MessageError as error:
        return error
    return None


def frame_fields(**changes):
    joints = np.zeros((20, 3), "<f4")
    fields = {"seq": 3, "t": 0.1, "joints": joints.tobytes(), "state": bytes([2] * 20)}
    return {**fields, **changes}


@given(places, states, st.sampled_from(FORMS), st.integers(-(2**40), 2**40), st.floats(-1e9, 1e9))
def test_a_frame_is_read_as_it_was_written(joints, state, form, seq, t):
    back = through(encode_frame(Frame(seq, t, joints.astype(float), state, form)))
    assert (back.seq, back.t, back.form) == (seq, t, form)
    assert np.abs(back.joints - joints).max() <= (0.0 if form in ("msgpack", "base64") else 5.1e-7)
    assert np.array_equal(back.state, state)


@given(places, st.sampled_from(FORMS), st.lists(st.sampled_from(["swapped", "turned"]), unique=True))
def test_an_answer_is_read_as_it_was_written(joints, form, flags):
    reliability, std = np.linspace(0, 1, 20), np.linspace(0.001, 0.2, 20)
    answer = Answer(7, 10.0, 10.5, joints.astype(float), reliability, std, tuple(flags))
    back = read_answer(encode_answer(answer, form), 20)
    assert (back.seq, back.t_in, back.t_out, back.flags) == (7, 10.0, 10.5, tuple(flags))
    for name in ("joints", "reliability", "std"):
        assert getattr(back, name) == pytest.approx(getattr(answer, name), abs=1e-6, rel=1e-6)


def test_bytes_are_little_endian_and_row_by_row():
    joints = np.arange(60, dtype=float).reshape(20, 3)
    fields = msgpack.unpackb(encode_frame(Frame(0, 0.0, joints, None, "msgpack")))
    assert np.frombuffer(fields["joints"], "<f4").tolist() == list(range(60))
    answer = Answer(0, 0.0, 0.0, joints, np.ones(20), np.ones(20), ())
    fields = msgpack.unpackb(encode_answer(answer, "msgpack"))
    assert np.frombuffer(fields["joints"], "<f4").tolist() == list(range(60))
    assert len(fields["reliability"]) == 4 * 20


def test_every_way_to_write_json_means_the_same():
    joints = np.round(np.random.default_rng(0).normal(size=(20, 3)), 3).astype(np.float32)
    ways = [joints.tolist(), joints.reshape(-1).tolist(), base64.b64encode(joints.tobytes()).decode()]
    for way in ways:
        back = through(json.dumps({"seq": 0, "t": 0, "joints": way, "state": [2] * 20}))
        assert back.joints == pytest.approx(joints, abs=1e-6)


def test_bytes_written_as_text_by_an_old_packer_are_read():
    joints = np.linspace(-3, 3, 60).astype("<f4")
    raw = msgpack.packb({b"seq": 1, b"t": 0.0, b"joints": joints.tobytes()}, use_bin_type=False)
    assert np.array_equal(through(raw).joints.reshape(-1), joints)


@pytest.mark.parametrize("key", sorted(JOINT_SETS))
def test_every_known_joint_set_may_say_hello(key):
    for text in (False, True):
        fields, _ = decode(encode_hello(Hello(key, JOINT_SETS[key].names, 29.97), text))
        assert is_hello(fields)
        assert read_hello(fields) == Hello(key, JOINT_SETS[key].names, 29.97)


def test_a_skeleton_with_names_of_its_own_may_say_hello():
    named = Hello("named", ("Hips", "Head", "LeftHand"), 60.0)
    assert read_hello(decode(encode_hello(named))[0]) == named


def test_whole_numbers_may_be_written_as_floats():
    """As MATLAB packs every number."""
    hello = {"v": 1.0, "skeleton": "kinect20", "fps": 30.0, "units": "m"}
    assert read_hello(decode(msgpack.packb(hello))[0]).fps == 30.0
    assert read_hello(decode(json.dumps(hello))[0]).fps == 30.0
    fields = {"seq": 7.0, "t": 1.0, "joints": bytes(4 * 60)}
    frame = read_frame(fields, Hello("kinect20", JOINT_SETS["kinect20"].names, 30.0), text=False)
    assert frame.seq == 7
    assert type(frame.seq) is int


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"v": 1.5}, "v: version 1"),
        ({"v": float("inf")}, "v: version 1"),
        ({"v": 2}, "v: version 1"),
        ({"v": "1"}, "v: version 1"),
        ({"v": True}, "v: version 1"),
        ({"v": None}, "v: version 1"),
        ({"skeleton": "kinect99"}, "skeleton: one of"),
        ({"skeleton": 20}, "skeleton: one of"),
        ({"skeleton": ["kinect20"]}, "skeleton: one of"),
        ({"skeleton": "named"}, "names: 2 to"),
        ({"skeleton": "named", "names": ["a", "a"]}, "came twice"),
        ({"skeleton": "named", "names": ["a", "\ud800"]}, "names: text"),
        ({"skeleton": "named", "names": ["a"] * 1000}, "names: 2 to"),
        ({"units": "mm"}, "units: 'm'"),
        ({"units": None}, "units: 'm'"),
        ({"fps": 0}, "fps: a rate above 0"),
        ({"fps": -30}, "fps: a rate above 0"),
        ({"fps": float("nan")}, "fps: a rate above 0"),
        ({"fps": float("inf")}, "fps: a rate above 0"),
        ({"fps": "30"}, "fps: a rate above 0"),
        ({"fps": 10**300}, "fps: a rate above 0"),
    ],
)
def test_a_hello_that_cannot_be_is_refused_by_the_field(changes, word):
    with pytest.raises(MessageError, match=word):
        read_hello({**GOOD, **changes})


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"seq": "x"}, "seq"),
        ({"seq": 1.5}, "seq"),
        ({"seq": 1e300}, "seq"),
        ({"seq": float("nan")}, "seq"),
        ({"seq": None}, "seq"),
        ({"t": None}, "t: seconds"),
        ({"t": float("nan")}, "t: seconds"),
        ({"t": 10**400}, "t: seconds"),
        ({"t": 1e300}, "t: seconds"),
        ({"t": -1e20}, "t: seconds"),
        ({"joints": b""}, "joints: 240 bytes"),
        ({"joints": bytes(239)}, "joints: 240 bytes were wanted, came 239"),
        ({"joints": bytes(300)}, "joints: 240 bytes were wanted, came 300"),
        ({"joints": None}, "joints"),
        ({"joints": {}}, "joints"),
        ({"joints": [0.0] * 59}, "joints: 60 numbers were wanted, came 59"),
        ({"joints": [[0.0, 0.0]] * 30}, "joints"),
        ({"joints": ["a"] * 60}, "joints: numbers"),
        ({"state": bytes(19)}, "state: 20 bytes"),
        ({"state": bytes([3] * 20)}, "state: 2 tracked"),
        ({"joints": np.full(60, 1800.0, "<f4").tobytes()}, "millimetres"),
        (
            {"joints": [0.5] * 60, "state": [None] * 20},
            "state: 2 tracked, 1 inferred or 0 not tracked was wanted, came nan",
        ),
    ],
)
def test_a_frame_that_cannot_be_is_refused_by_the_field(changes, word):
    fields = frame_fields(**changes)
    text = "bytes" not in word and not isinstance(fields["joints"], bytes)
    if text and "state" not in changes:
        fields["state"] = [2] * 20
    with pytest.raises(MessageError, match=word) as caught:
        read_frame(fields, HELLO, text)
    assert caught.value.seq == (3 if fields["seq"] == 3 else None)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("code", [None, 0, 1, 2])
def test_a_joint_without_a_position_is_not_tracked(code):
    joints = np.ones((20, 3), "<f4")
    joints[4, 1] = np.inf
    fields = frame_fields(joints=joints.tobytes(), state=None if code is None else bytes([code] * 20))
    found = read_frame(fields, HELLO, False)
    assert np.isnan(found.joints[4]).all()
    assert found.state is not None
    assert found.state.tolist() == [0 if k == 4 else 2 if code is None else code for k in range(20)]


def test_a_joint_that_is_not_tracked_needs_no_position():
    joints = np.ones((20, 3), "<f4")
    joints[4, 1] = np.nan
    state = np.full(20, 2, np.uint8)
    state[4] = 0
    found = read_frame(frame_fields(joints=joints.tobytes(), state=state.tobytes()), HELLO, False)
    assert np.isnan(found.joints[4]).all()
    assert np.isfinite(np.delete(found.joints, 4, axis=0)).all()
    assert np.isnan(through(encode_frame(Frame(0, 0.0, found.joints, state, "rows"))).joints[4]).all()


@given(st.sets(st.integers(0, 19)), st.booleans(), st.booleans())
def test_null_for_a_whole_joint_is_a_joint_without_a_position(missing, stated, text):
    rows = [None if k in missing else [0.1 * k, 1.0, 2.0] for k in range(20)]
    fields = {"seq": 1, "t": 0.5, "joints": rows, **({"state": [2] * 20} if stated else {})}
    found = read_frame(fields, HELLO, text)
    apart = read_frame({**fields, "joints": [[None] * 3 if row is None else row for row in rows]}, HELLO, text)
    np.testing.assert_array_equal(found.joints, apart.joints)
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(found.joints).all(axis=1)), sorted(missing))
    assert found.form == apart.form == ("rows" if text else "msgpack")
    states = [None] if found.state is None else found.state.tolist()
    assert states == ([None] if apart.state is None else apart.state.tolist())
    answer = {"seq": 1, "t_in": 0.0, "t_out": 0.0, "reliability": [1] * 20, "std": [0.1] * 20, "flags": []}
    read = read_answer(json.dumps({**answer, "joints": rows}), 20)
    np.testing.assert_array_equal(read.joints, found.joints)


@pytest.mark.slow
@given(st.one_of(st.binary(max_size=300), st.text(max_size=300)))
def test_whatever_comes_is_read_or_refused(message):
    said = refusal(message)
    for text in (True, False):
        assert said is None or decode(encode_error(said, text))[0]["error"] == str(said)


values = st.recursive(
    st.one_of(
        st.none(), st.booleans(), st.integers(-(2**63), 2**63), st.floats(), st.text(max_size=8), st.binary(max_size=8)
    ),
    lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(st.text(max_size=4), inner, max_size=3)),
    max_leaves=12,
)


@pytest.mark.slow
@given(
    st.dictionaries(st.sampled_from(["v", "skeleton", "fps", "units", "seq", "t", "joints", "state", "names"]), values)
)
def test_fields_of_any_kind_are_read_or_refused(fields):
    for given_fields in ({**GOOD, **fields}, {**frame_fields(), **fields}):
        assert len(str(refusal(given_fields))) < 300


@pytest.mark.parametrize("message", ["[" * 50_000, b"\x91" * 50_000, "1" * 5_000, b"\xc1", "null", b"\xc0", "{} {}"])
def test_what_breaks_parsers_is_refused(message):
    with pytest.raises(MessageError, match="map"):
        decode(message)


def test_what_is_too_long_is_refused_unread():
    with pytest.raises(MessageError, match="65,536 bytes"):
        decode(b"\xc1" * (MOST_BYTES + 1))


def test_an_error_comes_back_to_the_client_with_its_frame():
    with pytest.raises(MessageError, match="too far") as caught:
        read_answer(encode_error(MessageError("too far", 9), False), 20)
    assert caught.value.seq == 9
