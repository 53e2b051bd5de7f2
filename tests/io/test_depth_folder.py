"""Folders of depth images: what comes back, and what is said of bad ones."""

import json
import os
import re
import shutil
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.io import loadmat, savemat

from motionmend.bodies.camera import Camera, DepthFrame
from motionmend.bodies.registration import ColorCamera, registered
from motionmend.errors import FileError, MismatchError
from motionmend.io.depth import looks_like_depth_folder, read_depth
from motionmend.io.depth_folder import read_depth_folder, write_depth_folder
from motionmend.io.png import color_pixels, write_depth_png
from motionmend.io.utd_mhad import read_utd_depth

CAMERA = Camera(16, 12, 14.0, 15.0, 7.5, 5.5)
DATA = os.environ.get("MOTIONMEND_DATA")
needs_data = pytest.mark.skipif(not DATA, reason="MOTIONMEND_DATA is not set")


def frames(count: int = 4, color: bool = False, seed: int = 0) -> list[DepthFrame]:
    rng = np.random.default_rng(seed)
    made = []
    for k in range(count):
        depth = rng.uniform(0.5, 6.0, (12, 16)).astype(np.float32)
        depth[rng.random((12, 16)) < 0.3] = np.nan
        pixels = rng.integers(0, 256, (12, 16, 3), dtype=np.uint8) if color else None
        made.append(DepthFrame(CAMERA, depth, pixels, 1.5 + k / 25))
    return made


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_depth_folder(tmp_path / "clip", frames(color=True), 25.0)
    return tmp_path / "clip"


def change(folder: Path, **facts: object) -> None:
    file = folder / "camera.json"
    file.write_text(json.dumps({**json.loads(file.read_text()), **facts}))


@settings(max_examples=15)
@given(st.integers(0, 2**32 - 1), st.integers(1, 5), st.booleans(), st.sampled_from([0.001, 0.0001, 0.00025]))
def test_what_is_written_comes_back(
    tmp_path_factory: pytest.TempPathFactory, seed: int, count: int, color: bool, scale: float
) -> None:
    path = tmp_path_factory.mktemp("depth") / "clip"
    made = frames(count, color, seed)
    assert write_depth_folder(path, made, 25.0, depth_scale=scale) == count
    read = read_depth_folder(path)
    assert read.camera == CAMERA
    assert read.frames == count
    assert read.has_color == color
    assert read.fps == pytest.approx(25.0)
    for was, now in zip(made, read, strict=True):
        assert now.time == pytest.approx(was.time)
        reach = scale * 65535
        kept = np.minimum(was.depth, np.float32(reach))
        np.testing.assert_allclose(now.depth, kept, atol=0.51 * scale)
        assert (now.color is None) == (was.color is None)
        if was.color is not None and now.color is not None:
            np.testing.assert_array_equal(now.color, was.color)


def test_times_come_from_the_rate_without_times_csv(folder: Path) -> None:
    (folder / "times.csv").unlink()
    np.testing.assert_allclose(read_depth_folder(folder).times, np.arange(4) / 25)


def test_numbers_may_start_elsewhere_and_a_title_may_stand_over_the_times(folder: Path) -> None:
    for name in ("depth", "color"):
        for file in sorted((folder / name).iterdir(), reverse=True):
            file.rename(file.with_stem(f"{int(file.stem) + 7:06d}"))
    (folder / "times.csv").write_text("seconds\n0\n1\n2\n3.5\n")
    read = read_depth_folder(folder)
    assert read.times.tolist() == [0, 1, 2, 3.5]
    assert read.frame(3).color is not None
    assert "start at number 7" in read.guesses[0]


@pytest.mark.parametrize("number", [0, 65535])
def test_an_image_without_any_return_or_saturated_throughout_is_blank(folder: Path, number: int) -> None:
    shape = (CAMERA.height, CAMERA.width)
    write_depth_png(folder / "depth/000002.png", np.full(shape, number, np.uint16))
    read = read_depth_folder(folder)
    assert np.isnan(read.frame(2).depth).all()
    assert np.isfinite(read.frame(1).depth).any()


def test_a_saturated_pixel_holds_no_depth(folder: Path) -> None:
    samples = cv2.imread(str(folder / "depth/000002.png"), cv2.IMREAD_UNCHANGED)
    samples[:, :4] = 65535
    write_depth_png(folder / "depth/000002.png", samples)
    read = read_depth_folder(folder).frame(2).depth
    assert np.isnan(read[:, :4]).all()
    assert (np.isfinite(read) == ((samples > 0) & (samples < 65535))).all()
    assert np.isfinite(read).any()


def test_bytes_after_an_images_end_do_no_harm(folder: Path) -> None:
    file = folder / "depth/000002.png"
    depth = read_depth_folder(folder).frame(2).depth
    file.write_bytes(file.read_bytes() + b"\0" * 40)
    np.testing.assert_array_equal(read_depth_folder(folder).frame(2).depth, depth)


def test_frames_are_read_when_asked_for(folder: Path) -> None:
    read = read_depth_folder(folder)
    shutil.rmtree(folder / "depth")
    with pytest.raises(FileError, match=r"000002\.png"):
        read.frame(2)


def spoil_png(folder: Path) -> None:
    raw = bytearray((folder / "depth/000002.png").read_bytes())
    raw[len(raw) // 2] ^= 0x40
    (folder / "depth/000002.png").write_bytes(bytes(raw))


def cut_png(folder: Path) -> None:
    raw = (folder / "depth/000002.png").read_bytes()
    (folder / "depth/000002.png").write_bytes(raw[: len(raw) // 2])


def image(kind: str, size: tuple[int, ...]) -> Callable[[Path], None]:
    def put(folder: Path) -> None:
        cv2.imwrite(str(folder / "depth/000001.png"), np.ones(size, kind))

    return put


def empty(folder: Path) -> None:
    shutil.rmtree(folder / "depth")
    (folder / "depth").mkdir()


BAD: dict[str, tuple[Callable[[Path], object], str]] = {
    "no camera": (lambda f: (f / "camera.json").unlink(), "no camera.json"),
    "camera is no json": (lambda f: (f / "camera.json").write_text("width: 3"), "wanted JSON"),
    "camera is a list": (lambda f: (f / "camera.json").write_text("[1]"), "an object"),
    "no focal length": (lambda f: (f / "camera.json").write_text('{"width": 16, "height": 12}'), "'depth_scale'|'fx'"),
    "negative focal length": (lambda f: change(f, fx=-3), "'fx' above 0"),
    "scale as text": (lambda f: change(f, depth_scale="mm"), "'depth_scale' as a number"),
    "half a pixel": (lambda f: change(f, width=16.5), "whole pixels"),
    "another size than said": (lambda f: change(f, width=32), "wanted 32 x 12"),
    "no images": (lambda f: shutil.rmtree(f / "depth"), "none"),
    "empty folder": (empty, "empty"),
    "a number missing": (lambda f: (f / "depth/000001.png").unlink(), r"000001\.png is missing"),
    "a number twice": (lambda f: shutil.copy(f / "depth/000001.png", f / "depth/1.png"), "again"),
    "another name": (lambda f: (f / "depth/000001.png").rename(f / "depth/b.png"), "named 000000"),
    "a frame of another kind": (lambda f: (f / "depth/000004.npy").touch(), "named 000000"),
    "8 bits": (image("uint8", (12, 16)), "8-bit grey"),
    "colour": (image("uint16", (12, 16, 3)), "16-bit colour"),
    "mixed sizes": (image("uint16", (6, 8)), "8 x 6"),
    "cut off": (cut_png, "cut off"),
    "empty image": (lambda f: (f / "depth/000003.png").write_bytes(b""), "empty"),
    "text as image": (lambda f: (f / "depth/000003.png").write_text("hello " * 20), "does not start"),
    "damaged": (spoil_png, "damaged"),
    "too few times": (lambda f: (f / "times.csv").write_text("0\n1\n"), "wanted 4 times"),
    "times that fall": (lambda f: (f / "times.csv").write_text("0\n2\n1\n3\n"), "times that rise"),
    "times as words": (lambda f: (f / "times.csv").write_text("t\na\nb\nc\nd\n"), "seconds"),
    "colour of another size": (
        lambda f: cv2.imwrite(str(f / "color/000001.png"), np.ones((3, 3, 3), np.uint8)),
        "register",
    ),
    "colour cut off": (lambda f: (f / "color/000001.png").write_bytes(b"\xff\xd8\xff"), "colour image"),
    "no rotation": (lambda f: change(f, color={**json.loads((f / "camera.json").read_text())}), "R, 3 rows"),
}


@pytest.mark.parametrize("kind", BAD)
def test_a_bad_folder_is_one_line_that_names_it(folder: Path, kind: str) -> None:
    spoil, said = BAD[kind]
    spoil(folder)
    with pytest.raises(FileError, match=said) as failure:
        list(read_depth(folder))
    assert "clip" in str(failure.value)
    assert "\n" not in str(failure.value)


def renumber(folder: Path, by: int) -> None:
    for file in sorted((folder / "color").iterdir(), reverse=by > 0):
        file.rename(file.with_stem(f"{int(file.stem) + by:06d}"))


def no_colour(folder: Path) -> None:
    shutil.rmtree(folder / "color")
    (folder / "color").mkdir()


def vars_of(camera: Camera) -> dict[str, float]:
    return {name: getattr(camera, name) for name in ("width", "height", "fx", "fy", "cx", "cy")}


def in_milliseconds(folder: Path) -> None:
    (folder / "times.csv").write_text("0\n40\n80\n120\n")


@pytest.mark.parametrize("dropped", [(), (7, 20, 21)])
def test_times_in_whole_milliseconds_are_at_the_clock_s_rate(tmp_path: Path, dropped: tuple[int, ...]) -> None:
    kept = [k for k in range(40) if k not in dropped]
    write_depth_folder(tmp_path / "clip", frames(len(kept)), 30.0)
    (tmp_path / "clip/times.csv").write_text("".join(f"{k / 30:.3f}\n" for k in kept))
    assert read_depth(tmp_path / "clip").fps == pytest.approx(30.0, rel=1e-3)  # one over the median step: 30.3


PROMISES: dict[str, tuple[Callable[[Path], object], str]] = {
    "fewer colour images": (lambda f: (f / "color/000002.png").unlink(), "for 1 of 4 depth images, 000002 first"),
    "colour begins later": (lambda f: renumber(f, 1), "for 1 of 4 .* 000000 first: .* 000001 to 000004"),
    "colour of other numbers": (lambda f: renumber(f, 100), "for 4 of 4 .* 000100 to 000103"),
    "no colour in its folder": (no_colour, "color/ holds no images"),
    "milliseconds": (in_milliseconds, r"0\.025 Hz, camera.json says 25 Hz; .* milliseconds"),
    "a colour camera far away": (
        lambda f: change(f, color={**vars_of(CAMERA), "R": np.eye(3).tolist(), "T": [-25.0, 0.0, 0.0]}),
        "stands 25 m from the depth camera: is 'T' in mm",
    ),
    "another rate": (lambda f: change(f, fps=50.0), "25 Hz, camera.json says 50 Hz; the times count"),
    "a file of the system": (lambda f: (f / "depth/Thumbs.db").touch(), r"Thumbs\.db in depth/ is no image"),
}


@pytest.mark.parametrize("kind", PROMISES)
def test_what_a_folder_promises_and_lacks_is_one_warning(folder: Path, kind: str) -> None:
    assert read_depth(folder).warnings == ()
    spoil, said = PROMISES[kind]
    spoil(folder)
    read = read_depth(folder)
    (warning,) = read.warnings
    assert re.search(said, warning)
    assert len(list(read)) == 4


def test_files_of_the_system_are_told_together_and_alone_are_no_recording(folder: Path) -> None:
    for name in ("Thumbs.db", "desktop.ini", ".DS_Store"):
        (folder / "depth" / name).touch()
    assert read_depth(folder).warnings == ("2 files in depth/ are no images and are left out, Thumbs.db first",)
    for file in (folder / "depth").glob("*.png"):
        file.unlink()
    with pytest.raises(FileError, match=r"came 'Thumbs\.db'"):
        read_depth(folder)


def test_a_mirrored_recording_is_turned_round(folder: Path) -> None:
    """A point of the image is seen at the mirrored place: x changes its sign, y and z stay."""
    plain = read_depth(folder)
    assert plain.true_frame(1).camera == plain.camera
    change(folder, mirrored=True)
    read = read_depth(folder)
    assert read.mirrored
    seen, true = read.frame(1), read.true_frame(1)
    np.testing.assert_array_equal(seen.depth, plain.frame(1).depth)
    there, turned = seen.camera.points(seen.depth), true.camera.points(true.depth)
    np.testing.assert_allclose(turned, there[:, ::-1] * [-1, 1, 1], atol=1e-9)
    assert seen.color is not None
    assert true.color is not None
    np.testing.assert_array_equal(true.color, seen.color[:, ::-1])
    change(folder, mirrored="yes")
    with pytest.raises(FileError, match="mirrored"):
        read_depth(folder)


CEILING = {"top": (0, -1, 0), "left": (-1, 0, 0), "bottom": (0, 1, 0), "right": (1, 0, 0)}


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("up", CEILING)
def test_a_camera_on_its_side_is_turned_upright(folder: Path, up: str, mirrored: bool) -> None:
    """The same points, turned by `axes`; what lies towards the ceiling is up then, and colour goes along."""
    change(folder, mirrored=mirrored, up=up)
    read = read_depth(folder)
    seen, true = read.frame(1), read.true_frame(1)
    one, other = (np.asarray(frame.camera.points(frame.depth)).reshape(-1, 3) for frame in (seen, true))
    one, other = (points[np.isfinite(points).all(axis=1)] for points in (one, other))
    back = other @ read.axes.T
    np.testing.assert_allclose(back[np.lexsort(back.round(6).T)], one[np.lexsort(one.round(6).T)], atol=1e-6)
    np.testing.assert_allclose(read.axes @ np.array([0.0, -1.0, 0.0]), CEILING[up], atol=1e-12)
    np.testing.assert_allclose(read.axes.T @ read.axes, np.eye(3), atol=1e-12)
    assert np.linalg.det(read.axes) == pytest.approx(-1.0 if mirrored else 1.0)
    assert seen.color is not None
    assert true.color is not None
    tints = [
        {(float(z), *tint) for z, tint in zip(depth.ravel(), color.reshape(-1, 3).tolist(), strict=True) if z > 0}
        for depth, color in ((seen.depth, seen.color), (true.depth, true.color))
    ]
    assert len(tints[0]) > 50
    assert tints[0] == tints[1]


def test_a_side_that_no_image_has_is_refused(folder: Path) -> None:
    change(folder, up="north")
    with pytest.raises(FileError, match="top, left, bottom, right"):
        read_depth(folder)


def test_what_looks_like_a_depth_folder(folder: Path) -> None:
    assert looks_like_depth_folder(folder)
    assert not looks_like_depth_folder(folder.parent)
    (folder / "camera.json").unlink()
    assert looks_like_depth_folder(folder)  # so that reading it says what is missing


def test_colour_of_a_camera_beside_is_registered_to_points_it_sees(tmp_path: Path) -> None:
    """A plane of coloured pixels, seen by a camera that stands 5 cm to the right and is turned."""
    angle = np.radians(3.0)
    turn = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
    beside = ColorCamera(Camera(80, 60, 90.0, 90.0, 39.5, 29.5), turn, np.array([-0.05, 0.01, 0.0]))
    depth = np.full((12, 16), 2.0, np.float32)
    depth[:, :3] = np.nan
    column, row = np.meshgrid(np.arange(80), np.arange(60))
    color = np.stack([column, row, np.full_like(row, 200)], axis=-1).astype(np.uint8)  # a pixel says where it is
    seen = registered(color, depth, CAMERA, beside)
    there = CAMERA.points(depth) @ turn.T + beside.translation
    expected = np.rint(beside.camera.project(there))
    inside = (expected >= 0).all(axis=-1) & (expected <= [79, 59]).all(axis=-1)
    assert inside.sum() > 60
    np.testing.assert_array_equal(seen[inside][:, :2], expected[inside])
    assert (seen[~inside] == 0).all()


def test_colour_does_not_pass_through_what_stands_before() -> None:
    beside = ColorCamera(Camera(16, 12, 14.0, 15.0, 7.5, 5.5), np.eye(3), np.array([-0.3, 0.0, 0.0]))
    depth = np.full((12, 16), 4.0, np.float32)
    depth[:, 6:9] = 1.0
    color = np.full((12, 16, 3), 9, np.uint8)
    seen = registered(color, depth, CAMERA, beside)[:, :, 0]
    moved = 14.0 * 0.3 / 1.0  # px, of the near bar in the colour image
    shadow = [c for c in range(16) if depth[0, c] == 4 and 5.6 - moved < c - 14.0 * 0.3 / 4.0 < 8.4 - moved]
    assert shadow
    assert (seen[:, shadow] == 0).all()
    assert (seen[:, 6:9] == 9).all()


def test_extrinsics_that_are_none() -> None:
    with pytest.raises(MismatchError, match="rotation"):
        ColorCamera(CAMERA, np.diag([1.0, 1.0, -1.0]), np.zeros(3))
    with pytest.raises(MismatchError, match=r"\(3,\)"):
        ColorCamera(CAMERA, np.eye(3), np.zeros(2))


def test_utd_mhad_in_metres(tmp_path: Path) -> None:
    volume = np.zeros((240, 320, 3), np.uint16)
    volume[100:120, 150:160] = np.array([2500, 2600, 2700])
    savemat(tmp_path / "a1_depth.mat", {"d_depth": volume})
    read = read_depth(tmp_path / "a1_depth.mat")
    assert (read.frames, read.camera.fx, read.fps, read.mirrored) == (3, 285.63, 30.0, True)
    assert read.frame(2).depth[110, 155] == pytest.approx(2.7)
    assert np.isnan(read.frame(0).depth[0, 0])
    assert "nominal" in read.guesses[0]


@pytest.mark.parametrize(
    ("held", "said"),
    [
        ({"d_skel": np.zeros((20, 3, 4))}, "no d_depth"),
        ({"d_depth": np.zeros((20, 30, 4), np.uint16)}, "320 x 240"),
        ({"d_depth": np.full((240, 320, 2), 0.5)}, "whole millimetres"),
        ({"d_depth": "text"}, "as numbers"),
    ],
)
def test_bad_utd_mhad_is_one_line(tmp_path: Path, held: dict[str, object], said: str) -> None:
    savemat(tmp_path / "a_depth.mat", held)
    with pytest.raises(FileError, match=said):
        read_utd_depth(tmp_path / "a_depth.mat")


@pytest.mark.parametrize("keep", [0, 3, 60, 400])
def test_utd_mhad_cut_off(tmp_path: Path, keep: int) -> None:
    path = tmp_path / "a_depth.mat"
    rng = np.random.default_rng(0)
    savemat(path, {"d_depth": rng.integers(0, 4000, (240, 320, 2), dtype=np.uint16)}, do_compression=True)
    path.write_bytes(path.read_bytes()[:keep])
    with pytest.raises(FileError, match=r"a_depth.*cut off.*get a complete copy"):
        read_utd_depth(path)


@needs_data
def test_utd_mhad_as_recorded() -> None:
    file = next((Path(DATA or "") / "kinect/utdmhad/Depth").glob("*_depth.mat"))
    read = read_utd_depth(file)
    first = read.frame(0)
    person = first.depth[np.isfinite(first.depth)]
    assert 0.02 < len(person) / first.depth.size < 0.2  # the background is removed
    assert 1.5 < np.median(person) < 4.5


@needs_data
def test_ist_colour_follows_the_person(tmp_path: Path) -> None:
    """Registered colour jumps where depth jumps: more often than colour that is only scaled does."""
    place = Path(DATA or "") / "kinect/ist_rgbd"
    cameras = loadmat(place / "cameraparametersAsus.mat", squeeze_me=True)["cam_params"]
    held = {name: cameras[name].item() for name in ("Kdepth", "Krgb", "R", "T")}
    at = {"Kdepth": (640, 480), "Krgb": (640, 480)}
    depth_camera, color_camera = (
        Camera(*at[name], held[name][0, 0], held[name][1, 1], held[name][0, 2], held[name][1, 2])
        for name in ("Kdepth", "Krgb")
    )
    file = sorted((place / "imgseq1").glob("*.mat"))[10]
    raw = loadmat(file)["depth_array"]
    depth = np.where(raw > 0, raw / 1000, np.nan).astype(np.float32)
    color = color_pixels(file.with_suffix(".jpg"))
    seen = registered(color, depth, depth_camera, ColorCamera(color_camera, held["R"], held["T"]))
    step = np.abs(np.diff(depth, axis=1)) > 0.3

    def jump(image: np.ndarray) -> float:
        grey = image.astype(float).mean(axis=2)
        both = (image[:, 1:] > 0).any(axis=2) & (image[:, :-1] > 0).any(axis=2)
        return float(np.abs(np.diff(grey, axis=1))[step & both].mean())

    assert step.sum() > 300
    assert jump(seen) > 1.15 * jump(color)


BENT = Camera(160, 120, 110.0, 112.0, 81.0, 58.0)
LENS = [0.12, -0.05, 0.002, -0.003, 0.01]


def _bent(rays: np.ndarray) -> np.ndarray:
    """Where the lens shows rays (..., 2), by Brown's formula."""
    k1, k2, p1, p2, k3 = LENS
    x, y = rays[..., 0], rays[..., 1]
    r2 = x * x + y * y
    radial = 1.0 + k1 * r2 + k2 * r2**2 + k3 * r2**3
    across = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x)
    down = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y
    return np.stack((across, down), axis=-1)


def _plane(rays: np.ndarray) -> np.ndarray:
    """Depth (..., ) m of a tilted wall along rays (..., 2) = x / z, y / z."""
    return 3.0 / (1.0 + 0.3 * rays[..., 0] - 0.2 * rays[..., 1])


def test_a_bent_image_is_straightened(tmp_path: Path) -> None:
    """Each pixel of the bent image shows the wall along its own ray; read, it is a plane, and colours lie on it."""
    at = np.stack(np.meshgrid(np.arange(160.0), np.arange(120.0)), axis=-1)
    asked = (at - [BENT.cx, BENT.cy]) / [BENT.fx, BENT.fy]
    rays = asked.copy()
    for _ in range(100):
        rays += asked - _bent(rays)
    bent = _plane(rays).astype(np.float32)
    color = np.repeat(np.clip(60 * bent, 0, 255).astype(np.uint8)[..., None], 3, axis=2)
    path = tmp_path / "clip"
    write_depth_folder(path, [DepthFrame(BENT, bent, color, 0.0)], 30.0)
    change(path, distortion=LENS)
    seen = read_depth(path).frame(0)
    straight = (at - [BENT.cx, BENT.cy]) / [BENT.fx, BENT.fy]
    there = np.isfinite(seen.depth)
    assert there.mean() > 0.9  # what the bent image has beyond its border is in no pixel
    # Within what the wall's slope makes of half a pixel, and a millimetre of rounding.
    assert np.abs(seen.depth - _plane(straight))[there].max() < 0.5 * 3.0 * 0.5 / 110 * 2 + 0.001
    assert np.abs(seen.depth - _plane(straight))[there].mean() < 0.3 * np.abs(bent - _plane(straight)).mean()
    lit = np.pad((seen.color[2:-2, 2:-2, 0] > 0).astype(np.uint8), 2)
    inside = cv2.erode(lit, np.ones((5, 5), np.uint8)) > 0  # beside the border black is mixed in
    assert np.abs(seen.color[..., 0][inside] / 60.0 - _plane(straight)[inside]).max() < 0.06


def test_a_lens_that_bends_nothing_changes_nothing(folder: Path) -> None:
    before = [frame.depth for frame in read_depth(folder)]
    change(folder, distortion=[0, 0, 0, 0])
    np.testing.assert_array_equal([frame.depth for frame in read_depth(folder)], before)


@pytest.mark.parametrize("bend", [[0.1, 0.2], "k1", [0.1, 0.0, 0.0, None], [float("nan")] * 5, {"k1": 0.1}])
def test_a_lens_of_other_numbers_is_refused(folder: Path, bend: object) -> None:
    change(folder, distortion=bend)
    with pytest.raises(FileError, match="distortion"):
        read_depth(folder)
