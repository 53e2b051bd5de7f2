"""Folders of depth images: camera.json, depth/000000.png ..., color/ and times.csv where there are any.

Beyond the plain layout, camera.json may say where a colour camera beside the depth camera stands, and its images are
then registered while they are read: `"color": {"width", "height", "fx", "fy", "cx", "cy", "R": 3 x 3, "T": [x, y, z]}`
with a point p of the depth camera at R p + T (m) in the colour camera's axes. `"distortion": [k1, k2, p1, p2, ...]`, of
the depth camera or within `"color"`, is what its lens bends: images are straightened while they are read. `"mirrored":
true` says that the images are as in a mirror; `"up": "left"`, `"right"` or `"bottom"`, where in its images the ceiling
is, that the camera lies on its side or hangs upside down.
"""

import json
import math
import os
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import Bytes, Floats, Singles
from ..bodies.camera import Camera, DepthFrame
from ..bodies.postures import usual_step
from ..bodies.registration import ColorCamera, registered
from ..errors import FileError, MismatchError, counted
from .atomic import atomic
from .columns import read_lines, steady_rate
from .depth_recording import UP, DepthRecording
from .lens import Lens, lens_of
from .png import color_pixels, png_header, png_pixels, write_depth_png

_COLOR_ENDINGS = (".png", ".jpg", ".jpeg")
_IMAGE_ENDINGS = (*_COLOR_ENDINGS, ".tif", ".tiff", ".bmp", ".pgm", ".ppm", ".pnm", ".exr", ".webp", ".jp2", ".gif")
_WIDEST = 20000  # px
_OTHER_RATE = 1.5  # times another; rates that differ by more are no matter of a few dropped frames
_SATURATED = 0xFFFF  # of 16 bits
_ASIDE = 2.0  # m between the two cameras, from which on their distance must be in mm or cm


def read_depth_folder(path: str | os.PathLike[str]) -> DepthRecording:
    """Read a folder of depth images; the images themselves only when their frame is asked for.

    Every image's size, type and end are looked at once, so that a bad folder is known before work on it starts.

    Parameters
    ----------
    path : the folder.

    Returns
    -------
    recording : times from times.csv, else from the rate; warnings of colour that is not there for every image, of
        times at another rate than camera.json's, and of files in depth/ that are no images.

    Raises
    ------
    FileError : camera.json is missing or lacks something; no depth images, numbers missing between them, images of
        the wrong type or size or cut off; times.csv of another length, or times that do not rise.
    """
    folder = Path(path)
    facts = _camera_facts(folder)
    camera = _camera(facts, folder / "camera.json")
    scale = _positive(facts, "depth_scale", folder / "camera.json", "metres per unit, 0.001 for millimetres")
    numbers, images, foreign = _numbered(folder / "depth", (".png",))
    for image in images:
        header = png_header(image)
        if (header.bits, header.kind) != (16, "grey"):
            raise FileError(f"{image}: wanted a 16-bit grey PNG, came {header.bits}-bit {header.kind}")
        if (header.width, header.height) != (camera.width, camera.height):
            raise FileError(
                f"{image}: wanted {camera.width} x {camera.height} pixels as in camera.json, came "
                f"{header.width} x {header.height}"
            )
    times, fps = _times(folder, facts, len(images))
    colors, taker, said_of_color = _colors(folder, numbers, facts)
    lens = _lens(camera, facts, folder / "camera.json")
    beside = None if taker is None else _lens(taker.camera, facts["color"], folder / "camera.json")

    def depth_of(number: int) -> Singles:
        raw = png_pixels(images[number])
        there = (raw > 0) & (raw < _SATURATED)  # what does not fit is no depth, nor what cameras write for none
        depth = np.where(there, raw * np.float32(scale), np.float32(np.nan)).astype(np.float32)
        return depth if lens is None else lens.straight_depth(depth)

    def color_of(number: int, depth: Singles) -> Bytes | None:
        file = colors.get(numbers[number])
        return None if file is None else _color(file, depth, camera, taker, lens if taker is None else beside)

    guesses: tuple[str, ...] = ()
    if numbers[0] > 1:
        guesses += (f"the images start at number {numbers[0]}: took the first for frame 0",)
    if scale * 65535 < 1.0 or scale > 0.1:
        guesses += (f"camera.json says depth_scale {scale:g} m per unit: 0.001 is usual, for millimetres",)
    mirrored = facts.get("mirrored", False)
    if not isinstance(mirrored, bool):
        raise FileError(f"{folder / 'camera.json'}: wanted 'mirrored' as true or false, came {str(mirrored)[:40]!r}")
    up = facts.get("up", UP[0])
    if up not in UP:
        raise FileError(f"{folder / 'camera.json'}: wanted 'up' as one of {', '.join(UP)}, came {str(up)[:40]!r}")
    warnings = (*_of_foreign(foreign), *said_of_color, *_of_rates(fps, facts))
    return DepthRecording(folder, camera, times, fps, depth_of, color_of, bool(colors), mirrored, up, guesses, warnings)


def write_depth_folder(
    path: str | os.PathLike[str], frames: Iterable[DepthFrame], fps: float, *, depth_scale: float = 0.001
) -> int:
    """Write frames of one camera as a folder of depth images.

    Parameters
    ----------
    path : the folder; made when it is not there.
    frames : at least one, all of one camera; read one at a time.
    fps : Hz.
    depth_scale : metres per unit.

    Returns
    -------
    The number of frames.

    Raises
    ------
    FileError : no frames, frames of several cameras, or the folder cannot be written.
    """
    folder = Path(path)
    camera: Camera | None = None
    times: list[float] = []
    try:
        (folder / "depth").mkdir(parents=True, exist_ok=True)
    except OSError as failure:
        raise FileError(f"{folder}: cannot be made: {failure.strerror}") from None
    for number, frame in enumerate(frames):
        if camera is not None and frame.camera != camera:
            raise FileError(f"{folder}: frames of one camera were wanted, frame {number} has another")
        camera = frame.camera
        times.append(frame.time)
        units = np.nan_to_num(np.rint(frame.depth / np.float32(depth_scale)), nan=0.0)
        write_depth_png(folder / "depth" / f"{number:06d}.png", np.clip(units, 0, 65535).astype(np.uint16))
        if frame.color is not None:
            _write_color(folder / "color", number, frame.color)
    if camera is None:
        raise FileError(f"{folder}: a depth folder needs frames, came none")
    facts = {name: getattr(camera, name) for name in ("width", "height", "fx", "fy", "cx", "cy")}
    with atomic(folder / "times.csv") as temporary:
        temporary.write_text("".join(f"{time:.9g}\n" for time in times), "utf-8")
    with atomic(folder / "camera.json") as temporary:  # last: a folder with it is whole
        temporary.write_text(json.dumps({**facts, "fps": fps, "depth_scale": depth_scale}, indent=1) + "\n", "utf-8")
    return len(times)


def _write_color(folder: Path, number: int, color: Bytes) -> None:
    import cv2

    folder.mkdir(exist_ok=True)
    fine, packed = cv2.imencode(".png", np.ascontiguousarray(color[:, :, ::-1]))
    if not fine:
        raise FileError(f"{folder}: the image of frame {number} could not be packed")
    (folder / f"{number:06d}.png").write_bytes(packed.tobytes())


# ---- camera.json ----------------------------------------------------------------------------


def _camera_facts(folder: Path) -> Mapping[str, Any]:
    file = folder / "camera.json"
    if not folder.is_dir():
        raise FileError(f"{folder}: wanted a folder with camera.json and depth/, there is none; check the path")
    if not file.is_file():
        raise FileError(f"{folder}: there is no camera.json; write one with width, height, fx, fy, cx, cy, fps, "
                        "depth_scale")  # fmt: skip
    try:
        facts = json.loads(file.read_text("utf-8-sig"))
    except (OSError, ValueError) as failure:
        raise FileError(f"{file}: wanted JSON ({failure}); repair the file") from None
    if not isinstance(facts, dict):
        raise FileError(f"{file}: wanted an object with width, height, fx, ..., came {type(facts).__name__}")
    return facts


def _camera(facts: Mapping[str, Any], file: Path) -> Camera:
    width, height = (_positive(facts, name, file, "pixels") for name in ("width", "height"))
    if width != int(width) or height != int(height) or max(width, height) > _WIDEST:
        raise FileError(f"{file}: wanted a width and height in whole pixels, came {width:g} x {height:g}")
    fx, fy = (_positive(facts, name, file, "pixels") for name in ("fx", "fy"))
    cx, cy = (_number(facts, name, file, "pixels") for name in ("cx", "cy"))
    return Camera(int(width), int(height), fx, fy, cx, cy)


def _number(facts: Mapping[str, Any], name: str, file: Path, unit: str) -> float:
    if name not in facts:
        raise FileError(f"{file}: '{name}' is missing; add it ({unit})")
    value = facts[name]
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise FileError(f"{file}: wanted '{name}' as a number ({unit}), came {str(value)[:40]!r}")
    return float(value)


def _positive(facts: Mapping[str, Any], name: str, file: Path, unit: str) -> float:
    value = _number(facts, name, file, unit)
    if value <= 0:
        raise FileError(f"{file}: wanted '{name}' above 0 ({unit}), came {value:g}")
    return value


# ---- images and times -----------------------------------------------------------------------


def _numbered(folder: Path, endings: Sequence[str]) -> tuple[list[int], list[Path], list[str]]:
    """Numbers and files of images named by numbers, in their order, none missing in between; names of what is no image.

    A system leaves files of its own in folders of images, as Thumbs.db. What has a number or the ending of an image may
    be meant as a frame and is not passed over.
    """
    if not folder.is_dir():
        raise FileError(f"{folder}: wanted a folder with depth images 000000.png, 000001.png, ...; there is none")
    found: dict[int, Path] = {}
    foreign: list[str] = []
    for file in sorted(folder.iterdir()):
        if file.name.startswith(".") or file.is_dir():
            continue
        numbered = file.stem.isascii() and file.stem.isdigit()
        if not numbered and file.suffix.lower() not in _IMAGE_ENDINGS:
            foreign.append(file.name)
            continue
        if file.suffix.lower() not in endings or not numbered:
            raise FileError(f"{file}: wanted depth images named 000000.png, 000001.png, ..., came '{file.name}'")
        if int(file.stem) in found:
            raise FileError(f"{file}: the number of {found[int(file.stem)].name} again; remove one")
        found[int(file.stem)] = file
    if not found:
        came = f"came '{foreign[0]}'" if foreign else "the folder is empty"
        raise FileError(f"{folder}: wanted depth images 000000.png, 000001.png, ..., {came}")
    numbers = sorted(found)
    missing = next((one + 1 for one, after in pairwise(numbers) if after != one + 1), None)
    if missing is not None:
        lacking = numbers[-1] - numbers[0] + 1 - len(numbers)
        raise FileError(
            f"{folder}: {missing:06d}.png is missing ({lacking} in all between the first and the last); number the "
            "images without gaps and give their times in times.csv"
        )
    return numbers, [found[number] for number in numbers], foreign


def _of_foreign(names: Sequence[str]) -> tuple[str, ...]:
    """What is said of files in depth/ that are no images."""
    if not names:
        return ()
    if len(names) == 1:
        return (f"{names[0]} in depth/ is no image and is left out",)
    return (f"{len(names)} files in depth/ are no images and are left out, {names[0]} first",)


def _times(folder: Path, facts: Mapping[str, Any], frames: int) -> tuple[Floats, float]:
    """(T,) s from times.csv or the rate, and the rate in Hz."""
    file = folder / "times.csv"
    if not file.exists():
        fps = _positive(facts, "fps", folder / "camera.json", "frames per second")
        return np.arange(frames) / fps, fps
    lines = [line.strip() for line in read_lines(file, "seconds, one a line") if line.strip()]
    if lines and not _is_number(lines[0]):  # a title
        lines = lines[1:]
    wrong = next((line for line in lines if not _is_number(line)), None)
    if wrong is not None:
        raise FileError(f"{file}: wanted seconds, one a line, came '{wrong[:40]}'")
    if len(lines) != frames:
        raise FileError(f"{file}: wanted {frames} times, one for each depth image, came {len(lines)}")
    times = np.array([float(line) for line in lines])
    falls = np.flatnonzero(np.diff(times) <= 0)
    if falls.size:
        at = int(falls[0])
        raise FileError(f"{file}: wanted times that rise, {times[at + 1]:g} s follows {times[at]:g} s")
    if frames > 1:
        return times, _rate(times, lines, str(file))
    return times, _positive(facts, "fps", folder / "camera.json", "frames per second")


def _rate(times: Floats, spelt: Sequence[str], name: str) -> float:
    """Hz of times that rise: an even clock's, or of uneven ones one over the usual step."""
    try:
        return steady_rate(times, spelt, name)[0]
    except FileError:
        return 1.0 / usual_step(times)


def _of_rates(fps: float, facts: Mapping[str, Any]) -> tuple[str, ...]:
    """What is said of times at another rate than camera.json's, which counts only where there are no times."""
    stated = facts.get("fps")
    if isinstance(stated, bool) or not isinstance(stated, int | float) or not 0.0 < stated < math.inf:
        return ()
    if 1.0 / _OTHER_RATE <= fps / stated <= _OTHER_RATE:
        return ()
    unit = "; they count as seconds: are they milliseconds?" if 500.0 < stated / fps < 2000.0 else "; the times count"
    return (f"the times of times.csv come at {fps:.3g} Hz, camera.json says {stated:g} Hz{unit}",)


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def _colors(
    folder: Path, numbers: Sequence[int], facts: Mapping[str, Any]
) -> tuple[dict[int, Path], ColorCamera | None, tuple[str, ...]]:
    """Colour images by the number of their frame, the camera that took them where it is not the depth camera, and what
    is said of frames without colour."""
    place = folder / "color"
    if not place.is_dir():
        return {}, None, ()
    found: dict[int, Path] = {}
    for file in sorted(place.iterdir()):
        if file.suffix.lower() in _COLOR_ENDINGS and file.stem.isascii() and file.stem.isdigit():
            found.setdefault(int(file.stem), file)
    lacking = [number for number in numbers if number not in found]
    said: tuple[str, ...] = ()
    if not found:
        said = ("color/ holds no images named 000000.png or 000000.jpg, ...: there is no colour",)
    elif lacking:
        said = (
            f"no colour for {len(lacking)} of {counted(len(numbers), 'depth image')}, {lacking[0]:06d} first: of "
            f"color/ the image of the same number is taken, and it holds {min(found):06d} to {max(found):06d}",
        )
    wanted, taker = set(numbers), _color_camera(facts, folder)
    aside = 0.0 if taker is None else float(np.linalg.norm(taker.translation))
    if aside > _ASIDE:
        said += (f"the colour camera of camera.json stands {aside:.3g} m from the depth camera: is 'T' in mm or cm?",)
    return {number: file for number, file in found.items() if number in wanted}, taker, said


def _color_camera(facts: Mapping[str, Any], folder: Path) -> ColorCamera | None:
    said = facts.get("color")
    file = folder / "camera.json"
    if said is None:
        return None
    if not isinstance(said, dict):
        raise FileError(f"{file}: wanted 'color' as an object with width, height, fx, fy, cx, cy, R, T")
    try:
        rotation, translation = (np.array(said[name], dtype=np.float64) for name in ("R", "T"))
    except (KeyError, ValueError, TypeError):
        raise FileError(f"{file}: wanted 'color' with R, 3 rows of 3 numbers, and T, 3 numbers in m") from None
    try:
        return ColorCamera(_camera(said, file), rotation, translation)
    except MismatchError as failure:
        raise FileError(f"{file}: {failure}") from None


def _lens(camera: Camera, facts: Mapping[str, Any], file: Path) -> Lens | None:
    bend = facts.get("distortion")
    if bend is None:
        return None
    numbers = isinstance(bend, list) and all(isinstance(k, int | float) and not isinstance(k, bool) for k in bend)
    try:
        lens = lens_of(camera, bend if numbers else [])
    except MismatchError as failure:
        raise FileError(f"{file}: 'distortion': {failure}; came {str(bend)[:60]}") from None
    return lens if any(bend) else None


def _color(file: Path, depth: Singles, camera: Camera, taker: ColorCamera | None, lens: Lens | None) -> Bytes:
    pixels = color_pixels(file)
    wanted = camera if taker is None else taker.camera
    if pixels.shape[:2] != (wanted.height, wanted.width):
        raise FileError(
            f"{file}: wanted {wanted.width} x {wanted.height} pixels, came {pixels.shape[1]} x {pixels.shape[0]}; "
            "register colour to depth, or say in camera.json under 'color' where the colour camera stands"
        )
    pixels = pixels if lens is None else lens.straight_color(pixels)
    return pixels if taker is None else registered(pixels, depth, camera, taker)
