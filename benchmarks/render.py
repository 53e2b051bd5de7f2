"""Depth images of the performer: the compiled ray-caster against plain NumPy and, if installed, Embree and OpenGL."""

import os
from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np

from motionmend.arrays import Floats, Ints, Singles
from motionmend.bodies import anatomy
from motionmend.bodies.camera import KINECT
from motionmend.bodies.performer import Performer, Pose, bone_frames, standing
from motionmend.bodies.solids import ELLIPSOID
from motionmend.bodies.surface import Rendering, render

from .metric import Metric
from .timing import Plan, race, ratio
from .twins import of_tests

FINENESS = 48  # facets around each solid of the mesh that Embree is given
AIM = 0.0003  # s for a picture of 320 x 240


def run(plan: Plan) -> list[Metric]:
    """All measurements of the suite: one person 3 m away, 320 x 240 and every fourth pixel of it."""
    person, pose = anatomy.average(), standing()
    seen, plain = render(person, pose, KINECT), _plain(person, pose)
    _agree(seen, plain())
    runners: dict[str, Callable[[], object]] = {
        "ours": lambda: render(person, pose, KINECT),
        "fourth": lambda: render(person, pose, KINECT, 4),
        "plain": plain,
    }
    runners |= _embree(seen) | _opengl(seen)
    times = race(runners, plan.rounds)
    found = [
        ratio("render.320x240.plain_over_ours", times["plain"], times["ours"]),
        times["ours"].seconds("render.320x240.seconds"),
        times["ours"].cpu_rate("render.320x240.cpu_rate", 1, "images/s", 1 / AIM),
        times["fourth"].cpu_rate("render.80x60.cpu_rate", 1, "images/s"),
    ]
    peers = [name for name in runners if name.startswith(("embree", "opengl"))]
    return found + [times[name].cpu_rate(f"render.320x240.{name}_cpu_rate", 1, "images/s") for name in peers]


def _plain(person: Performer, pose: Pose) -> Callable[[], Floats]:
    """The tests' twin: every solid for every pixel, all pixels at once."""
    twin = of_tests("naive_body")
    v, u = np.mgrid[: KINECT.height, : KINECT.width]
    pixels = np.stack((u.ravel(), v.ravel()), axis=1)

    def cast() -> Floats:
        placed = twin.place(bone_frames(person, pose), person.solids)
        return np.asarray(twin.cast(placed, person.solids, KINECT, pixels)[0]).reshape(u.shape)

    return cast


def _agree(ours: Rendering, plain: Floats) -> None:
    both = np.isfinite(ours.depth) & np.isfinite(plain)
    apart = np.abs(ours.depth - plain)[both]
    if np.mean(np.isfinite(ours.depth) != np.isfinite(plain)) > 1e-4 or np.mean(apart > 1e-5) > 1e-3:
        raise AssertionError("render: ours and the plain ray-caster disagree, their times cannot be compared")


def _embree(seen: Rendering) -> dict[str, Callable[[], object]]:
    """Embree on a mesh of the same surface, with and without building its scene, which every new pose needs."""
    try:
        scenes = import_module("embreex.rtcore_scene")
        meshes = import_module("embreex.mesh_construction")
    except ImportError:
        return {}
    vertices, faces = _mesh(seen)
    corners = vertices[faces].astype(np.float32)
    v, u = np.mgrid[: KINECT.height, : KINECT.width]
    rays = KINECT.unproject(np.stack((u.ravel(), v.ravel()), axis=1), np.ones(u.size)).astype(np.float32)
    origins = np.zeros_like(rays)

    def build() -> tuple[Any, Any]:
        scene = scenes.EmbreeScene()
        return scene, meshes.TriangleMesh(scene, corners)  # the mesh has to outlive the scene's work

    kept = build()
    return {
        "embree_built": lambda: build()[0].run(origins, rays, query="DISTANCE"),
        "embree": lambda: kept[0].run(origins, rays, query="DISTANCE"),
    }


def _opengl(seen: Rendering) -> dict[str, Callable[[], object]]:
    """OpenGL on the processor (Mesa's llvmpipe, one thread) on the same mesh, with and without sending a new pose's."""
    os.environ.setdefault("LP_NUM_THREADS", "1")
    try:
        gl: Any = import_module("moderngl")
        context = gl.create_standalone_context(backend="egl")
    except Exception:  # no package, no library, no driver: whatever it is, there is no rival
        return {}
    if "llvmpipe" not in context.info["GL_RENDERER"]:
        return {}  # a graphics card is no rival of a processor
    vertices, faces = _mesh(seen)
    points = vertices.astype(np.float32)
    program = context.program(
        vertex_shader=_VERTEX,
        fragment_shader="#version 330\nin float z; out float depth; void main() { depth = z; }",
    )
    program["camera"].value = (KINECT.fx, KINECT.fy, KINECT.cx + 0.5, KINECT.cy + 0.5)
    program["size"].value = (float(KINECT.width), float(KINECT.height))
    buffer = context.buffer(points.tobytes())
    mesh = context.vertex_array(program, [(buffer, "3f", "place")], context.buffer(faces.astype(np.int32).tobytes()))
    size = KINECT.width, KINECT.height
    target = context.framebuffer([context.texture(size, 1, dtype="f4")], context.depth_renderbuffer(size))
    target.use()
    context.enable(gl.DEPTH_TEST)

    def draw() -> Singles:
        target.clear(np.nan)
        mesh.render(gl.TRIANGLES)
        return np.frombuffer(target.read(components=1, dtype="f4"), np.float32).reshape(KINECT.height, KINECT.width)

    def posed() -> Singles:
        buffer.write(points.tobytes())
        return draw()

    both = np.isfinite(seen.depth) & np.isfinite(draw())
    apart = np.abs(seen.depth - draw())[both]
    if both.sum() < 0.97 * np.isfinite(seen.depth).sum() or np.median(apart) > 0.002:
        raise AssertionError("render: ours and OpenGL's picture disagree, their times cannot be compared")
    return {"opengl_posed": posed, "opengl": draw}


_VERTEX = """
#version 330
uniform vec4 camera; uniform vec2 size; in vec3 place; out float z;
void main() {
    vec2 pixel = camera.xy * place.xy / place.z + camera.zw;
    z = place.z;
    gl_Position = vec4((2.0 * pixel / size - 1.0) * place.z, place.z - 0.2, place.z);
}
"""


def _mesh(seen: Rendering) -> tuple[Floats, Ints]:
    """Vertices (N, 3) m and triangles (M, 3) of the performer's solids."""
    solids = seen.performer.solids
    around = np.linspace(0, 2 * np.pi, FINENESS, endpoint=False)
    vertices, faces, count = [], [], 0
    for s in range(len(solids)):
        if solids.kind[s] == ELLIPSOID:
            lift = np.linspace(-np.pi / 2, np.pi / 2, FINENESS // 2)
            level, radius = np.sin(lift), np.cos(lift)
        else:
            level = np.array([-1.0, -1.0, 1.0, 1.0])
            radius = np.array([0.0, 1 - solids.taper[s], 1 + solids.taper[s], 0.0])
        ring = np.stack((np.cos(around), np.ones(FINENESS), np.sin(around)), axis=1)
        grid = ring[None] * np.stack((radius, level, radius), axis=1)[:, None]
        vertices.append((grid.reshape(-1, 3) * solids.size[s]) @ seen.placed[s, :, :3].T + seen.placed[s, :, 3])
        row, column = np.mgrid[: len(level) - 1, :FINENESS]
        a, b = row * FINENESS + column, row * FINENESS + (column + 1) % FINENESS
        square = np.stack((a, b, a + FINENESS, b, b + FINENESS, a + FINENESS), axis=-1)
        faces.append(square.reshape(-1, 3) + count)
        count += grid.shape[0] * FINENESS
    return np.concatenate(vertices), np.concatenate(faces)
