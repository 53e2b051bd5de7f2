"""Telling a person from the room in depth images: the compiled passes over all pixels against plain NumPy."""

from collections.abc import Callable

import numpy as np

from motionmend.arrays import Floats
from motionmend.bodies import anatomy
from motionmend.bodies.camera import Camera, DepthFrame
from motionmend.bodies.performer import standing
from motionmend.bodies.surface import intrinsics, render
from motionmend.evaluate.scenes import behind, room, view
from motionmend.evaluate.sensor import sensed
from motionmend.kernels import regions, scene
from motionmend.track.person.fineness import evened
from motionmend.track.person.foreground import empty_scene
from motionmend.track.person.pixels import person_of
from motionmend.track.person.room import NOISE_NEAR, NOISE_STEEP, Scene

from .metric import Metric
from .timing import Plan, race, ratio
from .twins import of_tests

FPS = 30.0
FEET = 0.95  # m below the standing pose's pelvis
CAMERAS = {
    "320x240": Camera(320, 240, 285.6, 285.6, 160.0, 120.0),
    "640x480": Camera(640, 480, 571.3, 571.3, 320.0, 240.0),
    "848x480": Camera(848, 480, 425.0, 425.0, 424.0, 240.0),
    "1280x720": Camera(1280, 720, 640.0, 640.0, 640.0, 360.0),
}


def run(plan: Plan) -> list[Metric]:
    """All measurements of the suite: somebody 3 m away in a room whose background is known, four cameras."""
    found = []
    for name, camera in CAMERAS.items():
        frame, before = _seen(camera)
        times = race({"ours": lambda f=frame, b=before: person_of(b, evened(f), None, 1)}, plan.rounds)
        found += [
            times["ours"].seconds(f"foreground.{name}.seconds"),
            times["ours"].cpu_rate(f"foreground.{name}.cpu_rate", 1, "images/s"),
        ]
    runners = _passes(*_seen(CAMERAS["640x480"]))
    times = race(runners, plan.rounds)
    parts = ("before_scene", "farthest", "blocks")
    return found + [ratio(f"foreground.{p}.plain_over_ours", times[f"{p}_plain"], times[p]) for p in parts]


def _seen(camera: Camera) -> tuple[DepthFrame, Scene]:
    """A noisy image of somebody in a room, and the room as `evened` frames without them showed it."""
    around = room(view(np.zeros(3), np.array([0.0, -1.0, 0.0]), 0.0), -FEET, np.array([0.0, -1.0, 0.0]))
    nobody = np.full((camera.height, camera.width), np.nan, np.float32)
    empty = [evened(_frame(camera, behind(nobody, camera, around), n)) for n in range(5)]
    person = render(anatomy.average(), standing(), camera).depth
    frame = _frame(camera, behind(person, camera, around), 5)
    here = empty_scene(empty)
    if not person_of(here, evened(frame), None, 1)[0].found:
        raise AssertionError("foreground: nobody was found, there is nothing to time")
    return frame, here


def _frame(camera: Camera, depth: np.ndarray, number: int) -> DepthFrame:
    return DepthFrame(camera, sensed(depth, camera, 0, number), None, number / FPS)


def _passes(frame: DepthFrame, before: Scene) -> dict[str, Callable[[], object]]:
    """Each pass over the image, and its plain twin on the same; what both give is compared first."""
    plain, few = of_tests("naive_detector"), evened(frame)
    depth, numbers = few.depth.copy(), intrinsics(few.camera)
    seen = np.isfinite(depth)
    body = person_of(before, few, None, 1)[0].depth
    front, blocks = np.empty(depth.shape, bool), np.empty(depth.shape, np.float32)
    noise = NOISE_NEAR, NOISE_STEEP

    def learned() -> Floats:
        out = before.background.copy()
        scene.farthest(depth, seen, body, *noise, out)
        return out

    runners: dict[str, Callable[[], object]] = {
        "before_scene": lambda: scene.before_scene(depth, numbers, before.planes, before.background, *noise, front),
        "before_scene_plain": lambda: plain.before_scene(depth, numbers, before.planes, before.background, *noise),
        "farthest": learned,
        "farthest_plain": lambda: plain.farthest(depth, seen, body, *noise, before.background),
        "blocks": lambda: regions.blocks(frame.depth, 2, *noise, blocks),
        "blocks_plain": lambda: _blocks(frame.depth, *noise),
    }
    runners["before_scene"](), runners["blocks"]()
    same = (
        np.mean(front != runners["before_scene_plain"]()) < 1e-4
        and np.array_equal(learned(), runners["farthest_plain"](), equal_nan=True)
        and np.allclose(blocks, _blocks(frame.depth, *noise), rtol=1e-5, equal_nan=True)
    )
    if not same:
        raise AssertionError("foreground: ours and the plain passes disagree, their times cannot be compared")
    return runners


def _blocks(depth: np.ndarray, near: float, steep: float) -> np.ndarray:
    """`regions.blocks` of two by two pixels, all at once."""
    four = np.sort(np.stack([depth[r::2, c::2] for r in (0, 1) for c in (0, 1)]), axis=0)  # what is missing comes last
    there = np.isfinite(four)
    count = there.sum(axis=0)
    middle = np.where(count > 2, four[1], four[0])
    with np.errstate(invalid="ignore"):
        on = np.abs(four - middle) <= near + steep * middle**2
        mean = np.where(on, four, 0.0).sum(axis=0) / on.sum(axis=0)
    return np.where(count > 1, mean, np.nan)
