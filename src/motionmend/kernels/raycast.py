"""Depth images of elliptic cones and ellipsoids by casting one ray a pixel: exact, each solid within its own box.

Throughout: P solids, each an ellipsoid (`kinds` 0) or an elliptic cone with flat ends (`kinds` 1, a cylinder where its
taper is 0), about its own axes: `placed` (P, 3, 4) m, world from solid; `sizes` (P, 3) m, half extents along them;
`tapers` (P,), the cone's radii at its +y end are 1 + taper, at its -y end 1 - taper times those of `sizes`. The world
is the camera's: x right, y down, z forward; a camera is (fx, fy, cx, cy) in px; a ray is z · ((u - cx)/fx, (v - cy)/fy,
1).
"""

from math import ceil, floor, sqrt

import numpy as np

from ..arrays import Bytes, Floats, Ints, Singles
from .body import Shell
from .compile import compiled

NEAR = 0.05  # m; what comes nearer than this is not seen
STEEP = -1.0  # stands for a ray that needs more thought
PARTS = 18  # numbers kept of a solid while rays are cast: 9 slopes, 3 of the camera's place, taper, kind, box 4


@compiled
def place(frames: Floats, bones: Ints, centers: Floats, turns: Floats, placed: Floats) -> None:
    """Solids on bones: `frames` (B, 4, 4), `bones` (P,), `centers` (P, 3) and `turns` (P, 3, 3) to (P, 3, 4)."""
    for s in range(bones.shape[0]):
        frame = frames[bones[s]]
        for i in range(3):
            placed[s, i, 3] = frame[i, 3]
            for k in range(3):
                placed[s, i, 3] += frame[i, k] * centers[s, k]
                placed[s, i, k] = (
                    frame[i, 0] * turns[s, 0, k] + frame[i, 1] * turns[s, 1, k] + frame[i, 2] * turns[s, 2, k]
                )


@compiled
def prepare(
    placed: Floats, kinds: Bytes, sizes: Floats, tapers: Floats, camera: Floats, width: int, height: int, parts: Floats
) -> None:
    """What casting needs of each solid, `parts` (P, 18); an empty box where it is out of view."""
    fx, fy, cx, cy = camera[0], camera[1], camera[2], camera[3]
    for s in range(kinds.shape[0]):
        frame, part, size = placed[s], parts[s], sizes[s]
        for k in range(3):  # in units of the half extents
            scale = 1.0 / size[k]
            part[k] = scale * (frame[2, k] - frame[0, k] * cx / fx - frame[1, k] * cy / fy)
            part[3 + k] = scale * frame[0, k] / fx
            part[6 + k] = scale * frame[1, k] / fy
            part[9 + k] = scale * (frame[0, k] * frame[0, 3] + frame[1, k] * frame[1, 3] + frame[2, k] * frame[2, 3])
        part[12], part[13] = tapers[s], kinds[s]
        if kinds[s] == 0:
            left, right, top, bottom = _spanned(frame, size, 0.0, 1.0, 1.0)
        else:
            left, right, top, bottom = _spanned(frame, size, -1.0, 1.0 - tapers[s], 0.0)
            other_left, other_right, other_top, other_bottom = _spanned(frame, size, 1.0, 1.0 + tapers[s], 0.0)
            left, right = min(left, other_left), max(right, other_right)
            top, bottom = min(top, other_top), max(bottom, other_bottom)
        part[14] = max(ceil(fx * max(left, -1e6) + cx), 0.0)
        part[15] = min(floor(fx * min(right, 1e6) + cx), width - 1.0)
        part[16] = max(ceil(fy * max(top, -1e6) + cy), 0.0)
        part[17] = min(floor(fy * min(bottom, 1e6) + cy), height - 1.0)


@compiled
def _spanned(
    frame: Floats, size: Floats, along: float, radius: float, depth: float
) -> tuple[float, float, float, float]:
    """Least and greatest x/z and y/z of an ellipse across the y axis (depth 0) or an ellipsoid (depth 1).

    The plane x = u·z touches where (c_x - u·c_z)² is the sum over the half axes p of (p_x - u·p_z)²: a quadratic in u
    (the dual conic). What reaches behind the camera has no bounds; what lies wholly behind it is not seen.
    """
    reach = (
        (radius * size[0] * frame[2, 0]) ** 2
        + (radius * size[2] * frame[2, 2]) ** 2
        + (depth * size[1] * frame[2, 1]) ** 2
    )
    z = frame[2, 3] + along * size[1] * frame[2, 1]
    if z - sqrt(reach) < NEAR:
        return -np.inf, np.inf, -np.inf, np.inf
    left, right = _touched(frame, size, along, radius, depth, z, reach, 0)
    top, bottom = _touched(frame, size, along, radius, depth, z, reach, 1)
    return left, right, top, bottom


@compiled
def _touched(
    frame: Floats, size: Floats, along: float, radius: float, depth: float, z: float, reach: float, i: int
) -> tuple[float, float]:
    """The same along one axis of the image, i; z and the squared reach along it are known."""
    c = frame[i, 3] + along * size[1] * frame[i, 1]
    square = (
        (radius * size[0] * frame[i, 0]) ** 2
        + (radius * size[2] * frame[i, 2]) ** 2
        + (depth * size[1] * frame[i, 1]) ** 2
    )
    mixed = (
        (radius * size[0]) ** 2 * frame[i, 0] * frame[2, 0]
        + (radius * size[2]) ** 2 * frame[i, 2] * frame[2, 2]
        + (depth * size[1]) ** 2 * frame[i, 1] * frame[2, 1]
    )
    a, b = z * z - reach, c * z - mixed
    root = sqrt(max(b * b - a * (c * c - square), 0.0))
    return (b - root) / a, (b + root) / a


@compiled
def _enters(a: float, b: float, c: float, square: float, y: float, ky: float) -> float:
    """Where a ray first meets a cone between its ends, y·z - ky = -1 and 1; 0 where it misses, STEEP where a <= 0."""
    if a <= 1e-12:
        return STEEP
    if square < 0.0:
        return 0.0
    root = sqrt(square)
    over = 1.0 / a
    enter, leave = (b - root) * over, (b + root) * over
    if y > 1e-12 or y < -1e-12:
        over = 1.0 / y
        middle, half = ky * over, abs(over)
        enter, leave = max(enter, middle - half), min(leave, middle + half)
    elif ky > 1.0 or ky < -1.0:
        return 0.0
    return enter if enter <= leave else 0.0


@compiled
def _enters_steeply(
    a: float, b: float, c: float, x: float, y: float, w: float, kx: float, ky: float, kw: float, taper: float
) -> float:
    """The same for a ray steeper than the cone's own side: the first of what it meets between the ends."""
    best = np.inf
    square = b * b - a * c
    if a < -1e-12 and square >= 0.0:
        root = sqrt(square)
        for z in ((b - root) / a, (b + root) / a):
            if z > 0.0 and z < best and abs(z * y - ky) <= 1.0:
                best = z
    elif a >= -1e-12 and b != 0.0:
        z = 0.5 * c / b
        if z > 0.0 and abs(z * y - ky) <= 1.0:
            best = z
    for end in (-1.0, 1.0):
        z = (ky + end) / y if y != 0.0 else 0.0
        radius = 1.0 + taper * end
        if z > 0.0 and z < best and (z * x - kx) ** 2 + (z * w - kw) ** 2 <= radius * radius:
            best = z
    return best if best < np.inf else 0.0


@compiled
def cast(parts: Floats, depth: Singles, solid: np.ndarray) -> None:
    """The nearest solid along each ray: `depth` (H, W) m along z, NaN = none, and `solid` (H, W) int16, -1 = none.

    A ray z·m - k, m = m0 + u·g along one row, meets a·z² - 2·b·z + c = 0 where a, b and so b² - a·c are polynomials of
    u: the row is cut to the stretch where that is not negative, and all three are cheap within it.
    """
    depth[:] = np.nan
    solid[:] = -1
    cast_onto(parts, depth, solid)


@compiled
def cast_onto(parts: Floats, depth: Singles, solid: np.ndarray) -> None:
    """The same onto a picture that is empty, or has other solids already: what is nearer stays."""
    for s in range(parts.shape[0]):
        part = parts[s]
        kx, ky, kw, taper, cone = part[9], part[10], part[11], part[12], part[13] > 0.5
        gx, gy, gw = part[3], part[4], part[5]
        # The quadric x² + metric·y² + w² = 1 or, of a cone, = (1 + taper·y)² with the linear part in by.
        metric = -taper * taper if cone else 1.0
        level = 1.0 - taper * ky
        by = taper * level if cone else ky
        c = kx * kx + kw * kw - level * level if cone else kx * kx + ky * ky + kw * kw - 1.0
        a2, b1 = gx * gx + metric * gy * gy + gw * gw, gx * kx + gw * kw + gy * by
        d2 = b1 * b1 - a2 * c
        for v in range(int(part[16]), int(part[17]) + 1):
            x0, y0, w0 = part[0] + v * part[6], part[1] + v * part[7], part[2] + v * part[8]
            a0, a1 = x0 * x0 + metric * y0 * y0 + w0 * w0, x0 * gx + metric * y0 * gy + w0 * gw
            b0 = x0 * kx + w0 * kw + y0 * by
            d0, d1 = b0 * b0 - a0 * c, b0 * b1 - a1 * c
            left, right = int(part[14]), int(part[15])
            if d2 < 0.0:
                square = d1 * d1 - d2 * d0
                if square <= 0.0:
                    continue
                root = sqrt(square)
                left = max(left, int(max(ceil((d1 - root) / -d2), -1.0)))
                right = min(right, int(min(floor((d1 + root) / -d2), 1e6)))
            for u in range(left, right + 1):
                square = d0 + u * (2.0 * d1 + u * d2)
                a, b = a0 + u * (2.0 * a1 + u * a2), b0 + u * b1
                if cone:
                    z = _enters(a, b, c, square, y0 + u * gy, ky)
                    if z == STEEP:
                        z = _enters_steeply(a, b, c, x0 + u * gx, y0 + u * gy, w0 + u * gw, kx, ky, kw, taper)
                else:
                    z = (b - sqrt(square)) / a if square >= 0.0 else 0.0
                if z >= NEAR and not z >= depth[v, u]:
                    depth[v, u] = z
                    solid[v, u] = s


@compiled
def normals(placed: Floats, shell: Shell, camera: Floats, depth: Singles, solid: np.ndarray, normal: Singles) -> None:
    """Outward unit normals (H, W, 3) of what `cast` found, NaN where it found nothing."""
    _, kinds, _, _, sizes, tapers = shell
    for v in range(depth.shape[0]):
        for u in range(depth.shape[1]):
            s = solid[v, u]
            if s < 0:
                normal[v, u, :] = np.nan
                continue
            z = np.float64(depth[v, u])
            x, y = (u - camera[2]) / camera[0] * z, (v - camera[3]) / camera[1] * z
            nx, ny, nz = outward(placed[s], kinds[s], sizes[s], tapers[s], x, y, z)
            normal[v, u, 0], normal[v, u, 1], normal[v, u, 2] = nx, ny, nz


@compiled
def outward(
    frame: Floats, kind: int, size: Floats, taper: float, x: float, y: float, z: float
) -> tuple[float, float, float]:
    """The unit normal at a point (x, y, z) of a solid's surface: `frame` (3, 4), `kind`, `size` (3,) and `taper`."""
    dx, dy, dz = x - frame[0, 3], y - frame[1, 3], z - frame[2, 3]
    # In the solid's own axes, in half extents.
    gx = (frame[0, 0] * dx + frame[1, 0] * dy + frame[2, 0] * dz) / size[0]
    gy = (frame[0, 1] * dx + frame[1, 1] * dy + frame[2, 1] * dz) / size[1]
    gw = (frame[0, 2] * dx + frame[1, 2] * dy + frame[2, 2] * dz) / size[2]
    if kind == 1:
        side = sqrt(gx * gx + gw * gw)
        radius = 1.0 + taper * gy
        # Which of the two surfaces the point lies on: the side, or an end.
        if abs(side - radius) * min(size[0], size[2]) <= (1.0 - abs(gy)) * size[1]:
            gy = -taper * radius
        else:
            gx, gw = 0.0, 0.0
            gy = 1.0 if gy > 0.0 else -1.0
    gx, gy, gw = gx / size[0], gy / size[1], gw / size[2]
    nx = frame[0, 0] * gx + frame[0, 1] * gy + frame[0, 2] * gw
    ny = frame[1, 0] * gx + frame[1, 1] * gy + frame[1, 2] * gw
    nz = frame[2, 0] * gx + frame[2, 1] * gy + frame[2, 2] * gw
    over = 1.0 / sqrt(max(nx * nx + ny * ny + nz * nz, 1e-30))
    return nx * over, ny * over, nz * over
