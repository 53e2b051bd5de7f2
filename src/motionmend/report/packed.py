"""Arrays small enough for a page: 16-bit steps, differences in time, deflate, base64."""

import base64
import zlib
from typing import Any

import numpy as np

from ..arrays import Bytes, Floats, Singles

MISSING = -32768  # the code of a sample that is not there
FINEST = 1e-4  # m and rad: 0.1 mm and 0.006 degrees, finer than a pixel shows
_CODES = 65000  # steps a column may span; a little under 2^16 leaves room for rounding


def pack(values: Floats | Singles) -> dict[str, Any]:
    """Quantise columns to 16 bits and pack them as text.

    Each column n is stored as whole steps from its own offset, value = offset[n] + step[n] * code, so that
    the error is at most step / 2; the code -32768 is a missing sample. The codes are stored column by
    column as differences in time, all low bytes before all high bytes, deflated: motion is smooth, so this
    takes about half the room of the codes themselves.

    Parameters
    ----------
    values : (T, N) in m or rad; anything not finite counts as missing.

    Returns
    -------
    JSON object with `shape` [T, N], `step` (N,), `offset` (N,) and `data` (base64). A step is 1e-4 unless the
    column spans more than 6.5, then its span / 65000.
    """
    there = np.isfinite(values)
    low = np.where(there, values, np.inf).min(axis=0, initial=np.inf)
    high = np.where(there, values, -np.inf).max(axis=0, initial=-np.inf)
    empty = low > high
    low, high = np.where(empty, 0.0, low), np.where(empty, 0.0, high)
    step = _short(np.maximum(FINEST, (high - low) / _CODES))
    offset = _short(np.round((low + high) / 2 / FINEST) * FINEST)
    codes = np.round((np.where(there, values, offset) - offset) / step).astype(np.int16)
    codes[~there] = MISSING
    columns = np.ascontiguousarray(codes.T).view(np.uint16)
    columns[:, 1:] -= columns[:, :-1].copy()  # wraps around modulo 2^16, and so does the sum in the page
    planes = columns.astype("<u2").view(np.uint8).reshape(-1, 2).T
    return {
        "shape": [int(n) for n in values.shape],
        "step": step.tolist(),
        "offset": offset.tolist(),
        "data": _text(planes.tobytes()),
    }


def pack_bytes(values: Bytes) -> dict[str, Any]:
    """Pack small whole numbers (T, N), column by column: JSON object with `shape` and `data`."""
    return {"shape": [int(n) for n in values.shape], "data": _text(np.ascontiguousarray(values.T).tobytes())}


def unpack(block: dict[str, Any]) -> Floats:
    """The values (T, N) that `pack` stored, NaN = missing: what the page's own script computes."""
    frames, columns = block["shape"]
    planes = np.frombuffer(_bytes(block["data"]), np.uint8).reshape(2, -1)
    codes = np.ascontiguousarray(planes.T).view("<u2").reshape(columns, frames)
    codes = np.cumsum(codes, axis=1, dtype=np.uint16).view(np.int16).T
    values = np.asarray(block["offset"]) + np.asarray(block["step"]) * codes
    return np.where(codes == MISSING, np.nan, values)


def unpack_bytes(block: dict[str, Any]) -> Bytes:
    """The whole numbers (T, N) that `pack_bytes` stored."""
    frames, columns = block["shape"]
    return np.frombuffer(_bytes(block["data"]), np.uint8).reshape(columns, frames).T


def _short(values: Floats) -> Floats:
    """Round to 9 digits, so that the page holds 0.0001 and not sixteen digits of it."""
    return np.array([float(f"{v:.9g}") for v in values])


def _text(raw: bytes) -> str:
    packed = zlib.compress(raw, 6)  # level 9 takes six times as long for 1.5 % less
    return base64.b64encode(packed).decode("ascii")


def _bytes(text: str) -> bytes:
    return zlib.decompress(base64.b64decode(text, validate=True))
