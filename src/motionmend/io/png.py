"""PNG images: whether a file is whole, what it says of itself, and its pixels."""

import struct
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..arrays import Bytes
from ..errors import FileError

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_KINDS = {0: "grey", 2: "colour", 3: "palette", 4: "grey with alpha", 6: "colour with alpha"}
_HEADER = 33  # bytes: signature, and the chunk IHDR with its length, name and checksum


@dataclass(frozen=True)
class PngHeader:
    """Width and height in pixels, bits of each sample, and the kind of pixels."""

    width: int
    height: int
    bits: int
    kind: str


def png_header(path: Path) -> PngHeader:
    """What a PNG says of itself; only its ends are read.

    Raises
    ------
    FileError : not there, no PNG, or cut off.
    """
    try:
        with path.open("rb") as file:
            head = file.read(_HEADER)
            file.seek(-min(12, len(head)), 2)
            tail = file.read(12)
    except OSError as failure:
        raise FileError(f"{path}: wanted a PNG image, cannot open it: {failure.strerror}") from None
    if not head:
        raise FileError(f"{path}: wanted a PNG image, this file is empty; get a complete copy")
    if not head.startswith(_SIGNATURE) or head[12:16] != b"IHDR" or len(head) < _HEADER:
        raise FileError(f"{path}: wanted a PNG image, it does not start as one; write the images as 16-bit PNG")
    if tail[4:8] != b"IEND" and not _whole(path.read_bytes()):  # something may stand after an image's end
        raise FileError(f"{path}: this PNG image is cut off; get a complete copy")
    width, height, bits, kind = struct.unpack(">IIBB", head[16:26])
    return PngHeader(width, height, bits, _KINDS.get(kind, f"type {kind}"))


def png_pixels(path: Path) -> np.ndarray[tuple[int, ...], np.dtype[np.uint16]]:
    """(H, W) samples of a 16-bit grey PNG.

    Raises
    ------
    FileError : not there, no 16-bit grey PNG, cut off, or damaged: each chunk's checksum is looked at.
    """
    import cv2

    try:
        raw = path.read_bytes()
    except OSError as failure:
        raise FileError(f"{path}: wanted a PNG image, cannot open it: {failure.strerror}") from None
    if not _whole(raw):
        raise FileError(f"{path}: this PNG image is cut off or damaged; get a complete copy")
    try:
        pixels = cv2.imdecode(np.frombuffer(raw, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error:
        pixels = None
    if pixels is None:
        raise FileError(f"{path}: this PNG image cannot be decoded; get a complete copy")
    if pixels.dtype != np.uint16 or pixels.ndim != 2:
        raise FileError(f"{path}: wanted a 16-bit grey PNG, came {pixels.dtype} {pixels.shape}")
    return np.asarray(pixels)


def color_pixels(path: Path) -> Bytes:
    """(H, W, 3) red, green, blue of a PNG or JPEG image.

    Raises
    ------
    FileError : not there, or it cannot be decoded.
    """
    import cv2

    try:
        raw = path.read_bytes()
    except OSError as failure:
        raise FileError(f"{path}: wanted a colour image, cannot open it: {failure.strerror}") from None
    broken = FileError(f"{path}: this colour image is cut off or damaged; get a complete copy, or remove the folder")
    if not raw or (raw.startswith(_SIGNATURE) and not _whole(raw)):
        raise broken
    if raw.startswith(b"\xff\xd8") and b"\xff\xd9" not in raw[-64:]:  # JPEG, and no end of image
        raise broken
    try:
        pixels = cv2.imdecode(np.frombuffer(raw, np.uint8), cv2.IMREAD_COLOR)
    except cv2.error:
        pixels = None
    if pixels is None:
        raise broken
    return np.ascontiguousarray(pixels[:, :, ::-1])


def write_depth_png(path: Path, samples: np.ndarray[tuple[int, ...], np.dtype[np.uint16]]) -> None:
    """Write (H, W) samples as a 16-bit grey PNG.

    Raises
    ------
    FileError : the file cannot be written.
    """
    import cv2

    fine, packed = cv2.imencode(".png", np.ascontiguousarray(samples, dtype=np.uint16))
    if not fine:
        raise FileError(f"{path}: the image could not be packed")
    try:
        path.write_bytes(packed.tobytes())
    except OSError as failure:
        raise FileError(f"{path}: cannot be written: {failure.strerror}") from None


def _whole(raw: bytes) -> bool:
    """Whether the chunks of a PNG follow each other to the last, each with the right checksum."""
    if not raw.startswith(_SIGNATURE):
        return False
    at = len(_SIGNATURE)
    while at + 12 <= len(raw):
        (length,) = struct.unpack_from(">I", raw, at)
        end = at + 12 + length
        if end > len(raw) or zlib.crc32(raw[at + 4 : end - 4]) != struct.unpack_from(">I", raw, end - 4)[0]:
            return False
        if raw[at + 4 : at + 8] == b"IEND":
            return True
        at = end
    return False
