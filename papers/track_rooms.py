"""Sections 3.8 and 4 in kind: real recordings with colour and all of the room in view"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from motionmend.arrays import Floats
from motionmend.bodies.anatomy import average
from motionmend.bodies.camera import Camera, DepthFrame
from motionmend.bodies.joint_sets import parents
from motionmend.bodies.performer import LANDMARKS
from motionmend.bodies.registration import ColorCamera, registered
from motionmend.errors import FileError, MismatchError
from motionmend.io.png import color_pixels, png_pixels
from motionmend.report.style import figure_at
from motionmend.track.measure.first_seconds import measure_person
from motionmend.track.settings import settings_of

from .common import Findings, Table
from .correct_common import kinect_in
from .track_common import Track, furnished, recorded, tracker

SHOWN = 4  # frames in each picture
EVERY = 2  # pixels of 640 x 480, for the tracker works at half of that anyway
SLOW = 5.0  # Hz; the rate of IST's images is not stated, people walk about 0.2 m from one to the next
SURE = 0.10  # m, of joints whose deviation is less the tracker says where they are


def run(mocap: Path, pictures: Path) -> Findings:
    """Somebody turning before a camera, upper body only; a man walking through a classroom: nothing given."""
    model, wish = tracker(mocap), settings_of("default")
    folder = kinect_in(mocap)
    values: dict[str, float] = {}
    rows, figures = [], []
    for name, title, frames in (
        ("cv2", "CV2: turning on the spot, upper body only", _turning(folder / "cv2_rgbd")),
        ("ist", "IST: walking through a classroom", _walking(folder / "ist_rgbd")),
    ):
        try:
            body = measure_person(model, wish, frames[: 3 * len(frames) // 4 : 2], furnished(frames)).performer
        except MismatchError:
            body = average()
        track = recorded(model, wish, frames, body)
        inside, sure = _inside(track, frames)
        lost = 100.0 * float(track.lost.mean())
        values |= {f"{name}_inside": inside, f"{name}_sure": sure, f"{name}_lost": lost}
        values[f"{name}_frames"] = float(len(frames))
        ms = 1e3 * float(np.median(track.seconds))
        rows.append((title, str(len(frames)), f"{inside:.1f}", f"{sure:.0f}", f"{lost:.0f}", f"{ms:.0f}"))
        _draw(pictures / f"track_{name}.png", frames, track)
        figures.append(
            (f"track_{name}.png", f"{title}; joints over the colour image, faint where the tracker is unsure.")
        )
    return Findings(
        values,
        (
            "CV2: every second of 60 images, 0.9 m away, legs out of view. IST: a camera high on a wall and tilted, colour "
            f"registered from its own camera; the images' rate is not stated and taken as {SLOW:.0f} Hz. Person, lengths and "
            "first pose are found by the tracker among furniture and seated people. On a surface: sure joints (a "
            f"deviation below {100 * SURE:.0f} cm) in view that have one from 0.3 m before to 0.1 m behind them within two "
            "pixels; in view is where the camera has depth in any image (CV2's last eight rows of 240 never have). "
            "That says nothing of whose surface it is: see the picture. Clothes on a chair are told from him beforehand.",
        ),
        (
            Table(
                "Real rooms",
                (
                    "recording",
                    "images",
                    "sure joints on a surface, %",
                    "joints sure, %",
                    "images lost, %",
                    "ms a frame",
                ),
                tuple(rows),
            ),
        ),
        tuple(figures),
    )


def _turning(folder: Path) -> list[DepthFrame]:
    """CV2's images with registered colour, every second of a recording of unstated rate, taken as 30 Hz."""
    names = sorted(folder.glob("*_depth.png"))
    if not names:
        raise FileError(f"{folder} was to hold depth images, there are none: give the folder that has them")
    camera = Camera(640, 480, 525.0, 525.0, 320.0, 240.0)
    frames = []
    for i, name in enumerate(names):
        raw = np.asarray(png_pixels(name))
        color = color_pixels(Path(str(name).replace("_depth.png", ".jpg")))
        frames.append(_halved(camera, raw, np.asarray(color), i / 15.0))
    return frames


def _walking(folder: Path) -> list[DepthFrame]:
    """IST's images, colour registered to depth."""
    from scipy.io import loadmat

    names = sorted((folder / "imgseq1").glob("*.mat"))
    if not names:
        raise FileError(f"{folder} was to hold depth images, there are none: give the folder that has them")
    known = loadmat(folder / "cameraparametersAsus.mat")["cam_params"][0, 0]
    depth, color = (
        Camera(640, 480, k[0, 0], k[1, 1], k[0, 2], k[1, 2])
        for k in (np.asarray(known[name], np.float64) for name in ("Kdepth", "Krgb"))
    )
    beside = ColorCamera(color, np.asarray(known["R"], np.float64), np.asarray(known["T"], np.float64).ravel())
    frames = []
    for i, name in enumerate(names):
        raw = loadmat(name)["depth_array"]
        seen = np.where(raw == 0, np.nan, raw / 1000.0).astype(np.float32)
        picture = registered(np.asarray(color_pixels(name.with_suffix(".jpg"))), seen, depth, beside)
        frames.append(_halved(depth, raw, picture, i / SLOW))
    return frames


def _halved(camera: Camera, raw: np.ndarray, color: np.ndarray, time: float) -> DepthFrame:
    small = raw[::EVERY, ::EVERY]
    depth = np.where(small == 0, np.nan, small / 1000.0).astype(np.float32)
    return DepthFrame(camera.every(EVERY), depth, np.ascontiguousarray(color[::EVERY, ::EVERY]), time)


def _inside(track: Track, frames: Sequence[DepthFrame]) -> tuple[float, float]:
    """Share of sure joints in view with a surface from 0.3 m before to 0.1 m behind them, and of joints sure, %."""
    measured = np.argwhere(np.isfinite([frame.depth for frame in frames]).any(axis=0))[:, ::-1]
    low, high = measured.min(axis=0) + 3, measured.max(axis=0) - 3  # CV2's images have no depth in their last rows
    hits, sure = [], []
    for places, std, lost, frame in zip(track.joints, track.std, track.lost, frames, strict=True):
        if lost:
            continue
        good = np.isfinite(places).all(axis=1) & (std < SURE)
        pixels = np.round(frame.camera.project(places[good])).astype(int)
        view = ((pixels >= low) & (pixels <= high)).all(axis=1)
        sure.append(good.mean())
        for (u, v), z in zip(pixels[view], places[good][view, 2], strict=True):
            behind = z - frame.depth[v - 2 : v + 3, u - 2 : u + 3]
            hits.append(bool(((behind > -0.1) & (behind < 0.3)).any()))
    return 100.0 * float(np.mean(hits)) if hits else 0.0, 100.0 * float(np.mean(sure)) if sure else 0.0


def _draw(path: Path, frames: Sequence[DepthFrame], track: Track) -> None:
    above = parents(LANDMARKS)
    there = np.flatnonzero(~track.lost)
    chosen = there[np.linspace(0, len(there) - 1, SHOWN).astype(int)] if len(there) else np.arange(SHOWN)
    with figure_at(path, 5.6, 2.4, "") as figure:
        for row, what in enumerate(("color", "depth")):
            for column, t in enumerate(chosen):
                axes = figure.add_subplot(2, SHOWN, row * SHOWN + column + 1)
                frame = frames[t]
                assert frame.color is not None
                axes.imshow(frame.color if what == "color" else -frame.depth, cmap="gray", interpolation="nearest")
                _bones(axes, frame.camera.project(track.joints[t]), track.std[t], above)
                axes.set_xlim(0, frame.camera.width)
                axes.set_ylim(frame.camera.height, 0)
                axes.set_axis_off()


def _bones(axes: Any, pixels: Floats, std: Floats, above: np.ndarray) -> None:
    for joint, parent in enumerate(above):
        if parent >= 0:
            faint = 0.35 if max(std[joint], std[parent]) >= SURE else 1.0
            axes.plot(*pixels[[joint, parent]].T, color="tab:orange", lw=1.6, marker="o", ms=2, alpha=faint)
