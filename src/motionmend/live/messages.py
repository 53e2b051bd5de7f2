"""What passes between a client and the server: hello, frames, answers, errors and end, in msgpack or JSON.

    hello   {v: 1, skeleton: "kinect20" | "kinect25" | "azure32" | ..., fps, units: "m"}
    frame   {seq, t, joints: J rows x, y, z, state: J of 2, 1, 0}
    answer  {seq, t_in, t_out, joints, reliability, std, flags}, and latency_ms where the server looks ahead
    end     {end: true}, for the answers that a server that looks ahead still owes
    error   {error, seq where known}

A binary message is msgpack, a text message JSON with the same keys. In msgpack numbers are little-endian bytes
(float32, uint8), joints row by row. JSON has no bytes: there they are lists of numbers, flat or one list a joint, or
the same bytes in base64; an answer takes the form of its frame. What is not a number is null in JSON, and so may be a
whole joint's list.
"""

import base64
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal, TypeAlias, TypeGuard, final

import numpy as np
from numpy.typing import NDArray

from ..arrays import Bytes, Floats
from ..bodies.joint_sets import JOINT_SETS
from ..bodies.postures import NOT_TRACKED, TRACKED
from ..errors import MotionMendError

VERSION: Final = 1
UNITS: Final = "m"
NAMED: Final = "named"  # a skeleton whose hello brings its joints' names
MOST_BYTES: Final = 65_536  # of one message; 32 joints as JSON lists take 3,000
MOST_JOINTS: Final = 128
MOST_NAME: Final = 64  # characters
MOST_FPS: Final = 1_000.0  # Hz
EXACT: Final = 2**53  # up to which a float tells whole numbers apart
LATEST: Final = 2**64  # s; no clock is there, of whatever unit
FARTHEST: Final = 100.0  # m; a body farther from its sensor than this is in other units

_SINGLE: Final = np.dtype("<f4")
_CODE: Final = np.dtype("u1")

Form: TypeAlias = Literal["msgpack", "flat", "rows", "base64"]
Fields: TypeAlias = Mapping[str, Any]


class MessageError(MotionMendError):
    """A message that cannot be used; its sender is told, nobody else notices."""

    def __init__(self, reason: str, seq: int | None = None) -> None:
        super().__init__(reason, seq)
        self.seq = seq

    def __str__(self) -> str:
        return str(self.args[0])


@final
@dataclass(frozen=True)
class Hello:
    """What a client says of itself: joint set, names of its joints (J,) and nominal rate in Hz."""

    skeleton: str
    names: tuple[str, ...]
    fps: float


@final
@dataclass(frozen=True, eq=False)
class Frame:
    """One posture of a client.

    Attributes
    ----------
    seq : the client's number of this frame.
    t : s, the client's clock.
    joints : (J, 3) m, NaN where a joint has no position.
    state : (J,) 2 tracked, 1 inferred, 0 not tracked; None where the client does not say.
    form : how numbers were written, and will be in the answer.
    """

    seq: int
    t: float
    joints: Floats
    state: Bytes | None
    form: Form


@final
@dataclass(frozen=True, eq=False)
class Answer:
    """A corrected posture: `t_in`, `t_out` in s of the server's clock (Unix time); joints (J, 3), std (J,) in m;
    `latency_ms` for which the server let it wait to see what comes after it."""

    seq: int
    t_in: float
    t_out: float
    joints: Floats
    reliability: Floats
    std: Floats
    flags: tuple[str, ...]
    latency_ms: float = 0.0


def decode(message: bytes | str) -> tuple[Fields, bool]:
    """The fields of a message, and whether it was JSON.

    Raises
    ------
    MessageError : too long, neither msgpack nor JSON, or no map with text for keys.
    """
    if len(message) > MOST_BYTES:
        raise MessageError(f"a message of at most {MOST_BYTES:,} bytes was wanted, came more")
    text = isinstance(message, str)
    try:
        fields = json.loads(message) if isinstance(message, str) else _unpacked(message)
    except (ValueError, RecursionError, OverflowError) as error:
        form = "JSON" if text else "msgpack"
        why = str(error)[:120].encode("ascii", "backslashreplace").decode()
        raise MessageError(f"a map in {form} was wanted, this is none: {why}") from None
    if not isinstance(fields, dict) or not {type(key) for key in fields} <= {str}:
        raise MessageError("a map with text for keys was wanted: a hello {v, skeleton, ...} or a frame {seq, t, ...}")
    return fields, text


def _unpacked(message: bytes) -> Any:
    import msgpack

    # bytes that an old packer wrote as text come back as they were
    try:
        return msgpack.unpackb(message, raw=False, unicode_errors="surrogateescape")
    except (msgpack.UnpackException, TypeError) as error:
        raise ValueError(str(error) or type(error).__name__) from None


def is_hello(fields: Fields) -> bool:
    """Whether this is meant as a hello; all else is a frame."""
    return "joints" not in fields and ("v" in fields or "skeleton" in fields)


def is_end(fields: Fields) -> bool:
    """Whether no more frames are to come before the answers that are owed."""
    return "joints" not in fields and fields.get("end") is True


def read_hello(fields: Fields) -> Hello:
    """The hello in the fields of a message.

    Raises
    ------
    MessageError : another version or units, a joint set not known, or a rate that is none.
    """
    if whole_number(fields.get("v")) != VERSION:
        raise MessageError(f"v: version {VERSION} was wanted, came {_shown(fields.get('v'))}")
    if fields.get("units") != UNITS:
        raise MessageError(f"units: {UNITS!r} was wanted, came {_shown(fields.get('units'))}: convert to metres")
    fps = fields.get("fps")
    if not _is_number(fps) or not 0 < float(fps) <= MOST_FPS:
        raise MessageError(f"fps: a rate above 0 and at most {MOST_FPS:g} Hz was wanted, came {_shown(fps)}")
    skeleton = fields.get("skeleton")
    if skeleton == NAMED:
        return Hello(NAMED, _names(fields.get("names")), float(fps))
    if not isinstance(skeleton, str) or skeleton not in JOINT_SETS:
        known = ", ".join([*JOINT_SETS, NAMED])
        raise MessageError(f"skeleton: one of {known} was wanted, came {_shown(skeleton)}")
    return Hello(skeleton, JOINT_SETS[skeleton].names, float(fps))


def _names(given: Any) -> tuple[str, ...]:
    """Names of joints that a hello brings."""
    if not isinstance(given, list) or not 2 <= len(given) <= MOST_JOINTS:
        raise MessageError(f"names: 2 to {MOST_JOINTS} joints were wanted for skeleton {NAMED!r}, came {_shown(given)}")
    for name in given:
        if not isinstance(name, str) or not 0 < len(name) <= MOST_NAME or not name.isprintable():
            raise MessageError(f"names: text of 1 to {MOST_NAME} characters was wanted, came {_shown(name)}")
    if len(set(given)) < len(given):
        raise MessageError("names: each joint's name once was wanted, one came twice")
    return tuple(given)


def read_frame(fields: Fields, hello: Hello, text: bool) -> Frame:
    """The frame in the fields of a message; `text` says that it was JSON.

    A joint without a position is NaN (null in JSON) with state 0. Any other number that is not finite is an error.

    Raises
    ------
    MessageError : a field missing, of another length or kind, or out of its range; with `seq` where that could be read.
    """
    seq = whole_number(fields.get("seq"))
    if seq is None or not -(2**63) <= seq < 2**64:
        raise MessageError(f"seq: a whole number was wanted, came {_shown(fields.get('seq'))}")
    try:
        return _frame(fields, hello, text, seq)
    except MessageError as error:
        raise MessageError(str(error), seq) from None


def _frame(fields: Fields, hello: Hello, text: bool, seq: int) -> Frame:
    count = len(hello.names)
    t = fields.get("t")
    if not _is_number(t) or not abs(t) <= LATEST:
        raise MessageError(f"t: seconds were wanted, came {_shown(t)}")
    flat, form = _numbers("joints", fields.get("joints"), _SINGLE, 3 * count, text)
    joints = flat.astype(np.float64).reshape(count, 3)
    state = None
    if fields.get("state") is not None:
        codes, _ = _numbers("state", fields["state"], _CODE, count, text)
        with np.errstate(invalid="ignore"):  # null is none of the three, and said below
            state = codes.astype(np.uint8)
        if np.count_nonzero(codes > 2) or np.count_nonzero(state != codes):
            raise MessageError(f"state: 2 tracked, 1 inferred or 0 not tracked was wanted, came {codes.max():g}")
    if np.vdot(joints, joints) <= FARTHEST**2:  # then none is farther, and all are finite
        return Frame(seq, float(t), joints, state, form)
    finite = np.isfinite(joints).all(axis=1)
    joints[~finite] = np.nan
    if not finite.all():  # whatever the sensor says of it
        state = np.full(count, TRACKED, np.uint8) if state is None else state
        state = np.where(finite, state, np.uint8(NOT_TRACKED))
    if np.abs(joints[finite]).max(initial=0.0) > FARTHEST:
        most = np.abs(joints[finite]).max()
        raise MessageError(f"joints: metres, at most {FARTHEST:g}, were wanted, came {most:.4g}: is it millimetres?")
    return Frame(seq, float(t), joints, state, form)


def _numbers(key: str, given: Any, kind: np.dtype[Any], count: int, text: bool) -> tuple[NDArray[Any], Form]:
    """A field's numbers, (count,), and the form they were written in."""
    form: Form = "base64" if text else "msgpack"
    if isinstance(given, list):
        return _listed(key, given, count, text)
    if isinstance(given, str) and text:
        try:
            given = base64.b64decode(given, validate=True)
        except ValueError:
            raise MessageError(f"{key}: numbers or bytes in base64 were wanted, this is neither") from None
    elif isinstance(given, str):
        given = given.encode("utf-8", "surrogateescape")
    if not isinstance(given, bytes):
        raise MessageError(f"{key}: {count * kind.itemsize} bytes were wanted, came {_shown(given)}")
    if len(given) != count * kind.itemsize:
        raise MessageError(f"{key}: {count * kind.itemsize} bytes were wanted, came {len(given)}")
    return np.frombuffer(given, kind), form


def _listed(key: str, given: list[Any], count: int, text: bool) -> tuple[NDArray[Any], Form]:
    empty = 3 * len(given) == count and all(row is None for row in given)  # one for each joint, and nobody is there
    nested = empty or any(isinstance(row, list) for row in given)
    given = [[None] * 3 if nested and row is None else row for row in given]
    flat: list[Any] = [one for row in given for one in (row if isinstance(row, list) else [row])]
    if len(flat) != count or (nested and not all(isinstance(row, list) and len(row) == 3 for row in given)):
        raise MessageError(f"{key}: {count} numbers were wanted, came {len(flat)} or rows that are not x, y, z")
    if not all(one is None or _is_number(one) for one in flat):
        raise MessageError(f"{key}: numbers were wanted, came something else among them")
    values = np.array([math.nan if one is None else float(one) for one in flat])
    form: Form = "msgpack" if not text else "rows" if nested else "flat"
    return values, form


def encode_answer(answer: Answer, form: Form) -> bytes | str:
    """An answer as its frame was written."""
    fields = {
        "seq": answer.seq,
        "t_in": answer.t_in,
        "t_out": answer.t_out,
        "joints": _written(answer.joints, form),
        "reliability": _written(answer.reliability, form),
        "std": _written(answer.std, form),
        "flags": list(answer.flags),
    }
    if answer.latency_ms > 0:
        fields["latency_ms"] = answer.latency_ms
    return packed(fields, text=form != "msgpack")


def encode_error(error: MessageError, text: bool) -> bytes | str:
    """What the sender of a message that cannot be used is told."""
    fields: dict[str, Any] = {"error": str(error)}
    if error.seq is not None:
        fields["seq"] = error.seq
    return packed(fields, text)


def encode_hello(hello: Hello, text: bool = False) -> bytes | str:
    """A hello; the names of the joints go with it where the joint set is none known."""
    fields: dict[str, Any] = {"v": VERSION, "skeleton": hello.skeleton, "fps": hello.fps, "units": UNITS}
    if hello.skeleton == NAMED:
        fields["names"] = list(hello.names)
    return packed(fields, text)


def encode_end(text: bool = False) -> bytes | str:
    """The message after the last frame."""
    return packed({"end": True}, text)


def encode_frame(frame: Frame) -> bytes | str:
    """A frame in its own form."""
    fields: dict[str, Any] = {"seq": frame.seq, "t": frame.t, "joints": _written(frame.joints, frame.form)}
    if frame.state is not None:
        codes = frame.state
        fields["state"] = codes.tolist() if frame.form in ("flat", "rows") else _written_bytes(codes, frame.form)
    return packed(fields, text=frame.form != "msgpack")


def read_answer(message: bytes | str, joints: int) -> Answer:
    """An answer as a client reads it; `joints` is J.

    Raises
    ------
    MessageError : the server said it could not use a frame, or this is no answer.
    """
    fields, text = decode(message)
    if "error" in fields:
        raise MessageError(str(fields["error"]), fields.get("seq"))
    try:
        place, _ = _numbers("joints", fields["joints"], _SINGLE, 3 * joints, text)
        reliability, _ = _numbers("reliability", fields["reliability"], _SINGLE, joints, text)
        if "std" in fields:
            std, _ = _numbers("std", fields["std"], _SINGLE, joints, text)
        else:  # another server's answer need not have it
            std = np.full(joints, np.nan)
        return Answer(
            int(fields["seq"]),
            float(fields["t_in"]),
            float(fields["t_out"]),
            place.astype(np.float64).reshape(joints, 3),
            reliability.astype(np.float64),
            std.astype(np.float64),
            _flags(fields["flags"]),
            float(fields.get("latency_ms", 0.0)),
        )
    except (KeyError, TypeError, ValueError) as error:
        raise MessageError(f"an answer {{seq, t_in, t_out, joints, reliability, flags}} was wanted: {error}") from None


def _flags(given: Any) -> tuple[str, ...]:
    return tuple(str(flag) for flag in given) if isinstance(given, list) else (str(given),)


def _written(values: Floats, form: Form) -> Any:
    """Numbers (J,) or (J, 3) as the form has them; lists to six places, which is a micrometre."""
    if form in ("msgpack", "base64"):
        return _written_bytes(values.astype(_SINGLE), form)
    listed = values if form == "rows" else values.reshape(-1)
    return _rounded(listed.tolist())


def _rounded(values: Sequence[Any]) -> list[Any]:
    return [_rounded(one) if isinstance(one, list) else round(one, 6) if math.isfinite(one) else None for one in values]


def _written_bytes(values: NDArray[Any], form: Form) -> bytes | str:
    raw = values.tobytes()
    return base64.b64encode(raw).decode("ascii") if form == "base64" else raw


def packed(fields: Fields, text: bool) -> bytes | str:
    """A map as JSON text or as msgpack bytes."""
    if text:
        return json.dumps(fields, allow_nan=False, separators=(",", ":"))
    import msgpack

    return bytes(msgpack.packb(fields, use_bin_type=True))


def _is_number(value: Any) -> TypeGuard[int | float]:
    if isinstance(value, bool):
        return False
    return isinstance(value, float) or (isinstance(value, int) and abs(value) <= 2**64)  # no more fits a float safely


def whole_number(value: Any) -> int | None:
    """A whole number, also one that is written as 1.0: languages with one kind of numbers pack them all so."""
    if type(value) is float and value.is_integer() and abs(value) <= EXACT:
        return int(value)
    return value if type(value) is int else None


def _shown(value: Any) -> str:
    """What came, short enough for one line."""
    if isinstance(value, list | tuple | dict | bytes):
        return f"{type(value).__name__} of {len(value)}"
    text = ascii(value)
    return text if len(text) <= 40 else f"{text[:37]}..."
