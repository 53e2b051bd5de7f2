"""Depth images: holes and noise, and connected surfaces."""

import numpy as np

from ..arrays import Bools, Bytes, Floats, Ints, Singles
from . import rising
from .compile import compiled

_insert = rising.insert


@compiled
def extent(depth: Singles, box: Ints) -> float:
    """First and last row and column, (4,) inclusive, that hold all that is measured; the least of its depths, m.

    An empty image gives the box (0, -1, 0, -1) and infinity.
    """
    height, width = depth.shape
    top, bottom, left, right = height, -1, width, -1
    nearest = np.float32(np.inf)
    for r in range(height):
        measured = 0
        for c in range(width):
            measured += depth[r, c] == depth[r, c]  # quick, and enough for most rows: not NaN
        if measured == 0:
            continue
        top, bottom = min(top, r), r
        first, last = 0, width - 1
        while np.isnan(depth[r, first]):
            first += 1
        while np.isnan(depth[r, last]):
            last -= 1
        for c in range(first, last + 1):
            nearest = depth[r, c] if depth[r, c] < nearest else nearest
        left, right = min(left, first), max(right, last)
    box[0], box[1], box[2], box[3] = (top, bottom, left, right) if bottom >= 0 else (0, -1, 0, -1)
    return float(nearest)


@compiled
def tally(depth: Singles, rows: Ints, columns: Ints) -> float:
    """How many pixels of each row (H,) and column (W,) are measured; the sum of their depths² in m²."""
    height, width = depth.shape
    rows[:], columns[:], total = 0, 0, 0.0
    for r in range(height):
        measured = 0
        for c in range(width):
            measured += depth[r, c] == depth[r, c]  # as in `extent`
        rows[r] = measured
        if measured == 0:
            continue
        for c in range(width):
            z = np.float64(depth[r, c])
            if not np.isnan(z):
                total += z * z
                columns[c] += 1
    return total


@compiled
def mend(depth: Singles, radius: int, enough: int, jump: float, out: Singles) -> None:
    """Fill holes of one pixel and take the median of what is measured around each pixel.

    Parameters
    ----------
    depth : (H, W) m, NaN = no return.
    radius : of the median's square window, pixels; at most 3.
    enough : a hole is filled when so many of its 8 neighbours are measured ...
    jump : ... and lie within this many metres of each other; between two surfaces the nearer is taken.
    out : (H, W) m, written.
    """
    height, width = depth.shape
    window = np.empty(max((2 * radius + 1) ** 2, 8), np.float32)  # also the ring about a hole
    filled, marked = depth.copy(), np.empty(width, np.bool_)  # pixels of a row that need a look of their own
    for r in range(height):
        above, below = depth[max(r - 1, 0)], depth[min(r + 1, height - 1)]
        if _holes(above, depth[r], below, 8 - enough, marked) == 0:  # as in nearly every row
            continue
        for c in range(width):
            if marked[c]:
                filled[r, c] = _filling(depth, r, c, enough, jump, window)
    for r in range(height):
        if radius == 1 and 0 < r < height - 1:
            _medians_of_nine(filled[r - 1], filled[r], filled[r + 1], out[r])
        else:
            out[r, :] = np.nan
        if _missed(filled[r], out[r], marked) == 0:
            continue
        for c in range(width):
            if not marked[c]:
                continue
            count = 0
            for i in range(max(r - radius, 0), min(r + radius + 1, height)):
                for j in range(max(c - radius, 0), min(c + radius + 1, width)):
                    if not np.isnan(filled[i, j]):
                        _insert(window, count, filled[i, j])
                        count += 1
            out[r, c] = window[count // 2] if count % 2 else 0.5 * (window[count // 2 - 1] + window[count // 2])


@compiled
def blocks(depth: Singles, step: int, near: float, steep: float, out: Singles) -> None:
    """One depth for each block of `step` x `step` pixels: the mean of what is measured on its nearer surface.

    Parameters
    ----------
    depth : (H, W) m, NaN = no return.
    step : px; blocks at the right and lower border may be smaller.
    near, steep : what is within near + steep · z² m of a block's median is on the same surface.
    out : (ceil(H / step), ceil(W / step)) m, written; NaN where less than half of a block is measured.
    """
    height, width = depth.shape
    whole = height // step * step, width // step * step
    values = np.empty(step * step, np.float32)
    for r in range(out.shape[0]):
        top, first = r * step, 0
        if step == 2 and top < whole[0]:
            first = whole[1] // 2
            _pairs(depth[top], depth[top + 1], near, steep, out[r, :first])
        for c in range(first, out.shape[1]):
            block = depth[top : min(top + step, height), c * step : min((c + 1) * step, width)]
            out[r, c] = _of_block(block, values, near, steep)


@compiled
def _of_block(block: Singles, values: Singles, near: float, steep: float) -> float:
    """One depth for a block, as of `blocks`; values (N,) is written, N at least the block's pixels."""
    count = 0
    for i in range(block.shape[0]):
        for j in range(block.shape[1]):
            values[count] = block[i, j]
            count += block[i, j] == block[i, j]  # not NaN
    if count == 0 or 2 * count < block.size:
        return np.nan
    for n in range(1, count):
        _insert(values, n, values[n])
    middle = values[(count - 1) // 2]
    slack = near + steep * middle * middle
    total, on = np.float32(0.0), 0
    for n in range(count):
        same = abs(values[n] - middle) <= slack
        total += values[n] * same
        on += same
    return float(total / on)


@compiled
def _pairs(above: Singles, below: Singles, near: float, steep: float, out: Singles) -> None:
    """`_of_block` of each 2 x 2 pixels of two rows; without a branch, for several blocks at once."""
    far, none = np.float32(np.inf), np.float32(0.0)
    least, grows = np.float32(near), np.float32(steep)
    for c in range(len(out)):
        x, y, z, w = above[2 * c], above[2 * c + 1], below[2 * c], below[2 * c + 1]
        count = int(x == x) + int(y == y) + int(z == z) + int(w == w)
        x, y, z, w = x if x == x else far, y if y == y else far, z if z == z else far, w if w == w else far
        low, high = x if x < y else y, y if x < y else x
        other, most = z if z < w else w, w if z < w else z
        first, second = low if low < other else other, other if low < other else low
        third = high if high < most else most
        second = second if second < third else third
        middle = first if count < 3 else second
        slack = least + grows * middle * middle
        a, b = abs(x - middle) <= slack, abs(y - middle) <= slack
        d, e = abs(z - middle) <= slack, abs(w - middle) <= slack
        total = (x if a else none) + (y if b else none) + (z if d else none) + (w if e else none)
        out[c] = total / np.float32(int(a) + int(b) + int(d) + int(e)) if count > 1 else np.float32(np.nan)


@compiled
def _holes(above: Singles, here: Singles, below: Singles, most: int, holes: Bools) -> int:
    """Empty pixels of a row (W,) of which at most so many beside them are empty, too; how many there are.

    Without a branch, for several at once. At the row's ends every empty one counts.
    """
    last, found, few = len(here) - 1, 0, np.int32(most)
    for c in range(1, last):
        across = np.int32(here[c - 1] != here[c - 1]) + np.int32(here[c + 1] != here[c + 1])  # what is empty is NaN
        empty = across + np.int32(above[c] != above[c]) + np.int32(below[c] != below[c])
        holes[c] = (here[c] != here[c]) & (empty <= few)
    holes[0], holes[last] = np.isnan(here[0]), np.isnan(here[last])
    for c in range(last + 1):
        found += holes[c]
    return found


@compiled
def _missed(filled: Singles, out: Singles, missed: Bools) -> int:
    """Pixels of a row (W,) that are measured and have no median yet; how many there are."""
    found = 0
    for c in range(len(out)):
        missed[c] = (filled[c] == filled[c]) & (out[c] != out[c])
    for c in range(len(out)):
        found += missed[c]
    return found


@compiled
def _filling(depth: Singles, r: int, c: int, enough: int, jump: float, ring: Singles) -> float:
    """What fills a hole of one pixel, as `mend` says; NaN where it is no such hole.

    `ring`, (8,) or more, is overwritten.
    """
    height, width = depth.shape
    count = 0
    for i in range(max(r - 1, 0), min(r + 2, height)):
        for j in range(max(c - 1, 0), min(c + 2, width)):
            if not np.isnan(depth[i, j]):
                _insert(ring, count, depth[i, j])
                count += 1
    if count < enough:
        return np.nan
    near = 1
    while near < count and ring[near] - ring[0] < jump:
        near += 1
    return float(ring[near // 2])


@compiled
def _medians_of_nine(above: Singles, here: Singles, below: Singles, out: Singles) -> None:
    """Medians of the 3 x 3 windows of a row (W,), NaN where a pixel of the nine is missing.

    As minima and maxima of sorted columns (Smith 1996), without a branch, for several windows at once.
    """
    nan = np.float32(np.nan)
    out[0] = out[len(out) - 1] = nan
    for c in range(1, len(out) - 1):
        a0, a1, a2 = _sorted3(above[c - 1], here[c - 1], below[c - 1])
        b0, b1, b2 = _sorted3(above[c], here[c], below[c])
        c0, c1, c2 = _sorted3(above[c + 1], here[c + 1], below[c + 1])
        _, low = _ordered(_ordered(a0, b0)[1], c0)
        _, middle, _ = _sorted3(a1, b1, c1)
        high, _ = _ordered(_ordered(a2, b2)[0], c2)
        middle = _sorted3(low, middle, high)[1]
        left = (above[c - 1] + here[c - 1]) + below[c - 1]
        total = left + ((above[c] + here[c]) + below[c]) + ((above[c + 1] + here[c + 1]) + below[c + 1])
        out[c] = middle if total == total else nan


@compiled
def _sorted3(x: float, y: float, z: float) -> tuple[float, float, float]:
    x, y = _ordered(x, y)
    y, z = _ordered(y, z)
    x, y = _ordered(x, y)
    return x, y, z


@compiled
def _ordered(x: float, y: float) -> tuple[float, float]:
    """The smaller and the larger of two, without a jump that the processor has to guess."""
    return (x if x < y else y), (y if x < y else x)


@compiled
def surfaces(depth: Singles, inside: Bools, near: float, steep: float, out: np.ndarray) -> int:
    """Number the connected surfaces: pixels side by side whose depths differ by less than near + steep z^2.

    Parameters
    ----------
    depth : (H, W) m.
    inside : (H, W) pixels that count.
    near : m.
    steep : 1/m, as a depth camera's noise grows.
    out : (H, W) int32, written: number of the surface, in the order of its first pixel, -1 = none.

    Returns
    -------
    How many there are.
    """
    height, width = depth.shape
    parent = np.empty(height * width, np.int32)
    count = 0
    for r in range(height):
        for c in range(width):
            out[r, c] = -1
            if not inside[r, c]:
                continue
            z = depth[r, c]
            most = near + steep * z * z
            label = -1
            if c > 0 and inside[r, c - 1] and abs(z - depth[r, c - 1]) < most:
                label = _root(parent, out[r, c - 1])
            if r > 0 and inside[r - 1, c] and abs(z - depth[r - 1, c]) < most:
                above = _root(parent, out[r - 1, c])
                if label < 0:
                    label = above
                elif above != label:
                    parent[max(above, label)] = min(above, label)
                    label = min(above, label)
            if label < 0:
                label = count
                parent[count] = count
                count += 1
            out[r, c] = label
    names = np.full(count, -1, np.int32)
    known = 0
    for r in range(height):
        for c in range(width):
            if out[r, c] >= 0:
                label = _root(parent, out[r, c])
                if names[label] < 0:
                    names[label] = known
                    known += 1
                out[r, c] = names[label]
    return known


@compiled
def _root(parent: np.ndarray, label: int) -> int:
    while parent[label] != label:
        parent[label] = parent[parent[label]]
        label = parent[label]
    return label


@compiled
def measures(depth: Singles, labels: np.ndarray, moved: Bytes, intrinsics: Floats, out: Floats) -> None:
    """Size and place of each surface.

    Parameters
    ----------
    depth : (H, W) m.
    labels : (H, W) int32 number of the surface, -1 = none.
    moved : (H, W) 1 where something else was seen behind before.
    intrinsics : (4,) fx, fy, cx, cy.
    out : (S, 14) written: pixels, area in m^2 as if facing the camera, least and greatest x, y, z in m, mean x, y, z,
        share of moved pixels, share of pixels on the image's border; mean in m of |z - 2 z' + z''| over three pixels
        in a row, NaN where there are none.
    """
    fx, fy, cx, cy = intrinsics[0], intrinsics[1], intrinsics[2], intrinsics[3]
    height, width = depth.shape
    rows_of_three = np.zeros(len(out), np.int64)
    for s in range(len(out)):
        for k in range(14):
            out[s, k] = 0.0
        for k in range(3):
            out[s, 2 + 2 * k], out[s, 3 + 2 * k] = np.inf, -np.inf
    for r in range(height):
        for c in range(width):
            s = labels[r, c]
            if s < 0:
                continue
            z = np.float64(depth[r, c])
            x, y = (c - cx) * z / fx, (r - cy) * z / fy
            out[s, 0] += 1.0
            out[s, 1] += z * z / (fx * fy)
            out[s, 2], out[s, 3] = min(out[s, 2], x), max(out[s, 3], x)
            out[s, 4], out[s, 5] = min(out[s, 4], y), max(out[s, 5], y)
            out[s, 6], out[s, 7] = min(out[s, 6], z), max(out[s, 7], z)
            out[s, 8] += x
            out[s, 9] += y
            out[s, 10] += z
            out[s, 11] += moved[r, c]
            if r == 0 or c == 0 or r == height - 1 or c == width - 1:
                out[s, 12] += 1.0
            if c >= 2 and labels[r, c - 1] == s and labels[r, c - 2] == s:
                out[s, 13] += abs(z - 2.0 * np.float64(depth[r, c - 1]) + np.float64(depth[r, c - 2]))
                rows_of_three[s] += 1
    for s in range(len(out)):
        out[s, 13] = out[s, 13] / rows_of_three[s] if rows_of_three[s] > 0 else np.nan
        if out[s, 0] > 0.0:
            for k in range(8, 13):
                out[s, k] /= out[s, 0]


@compiled
def sampled(
    depth: Singles,
    labels: np.ndarray,
    slot: np.ndarray,
    step: np.ndarray,
    intrinsics: Floats,
    out: Floats,
    counts: np.ndarray,
) -> None:
    """Some points of some surfaces, in one pass over the image.

    Parameters
    ----------
    depth, labels, intrinsics : as of `measures`.
    slot : (S,) int64 where a surface's points go, -1 = not wanted.
    step : (S,) int64 every n-th pixel of the surface.
    out : (K, P, 3) m, written.
    counts : (K,) int64 how many points, written.
    """
    counts[:] = 0
    passed = np.zeros(len(slot), np.int64)
    for r in range(depth.shape[0]):
        for c in range(depth.shape[1]):
            s = labels[r, c]
            if s < 0 or slot[s] < 0:
                continue
            passed[s] += 1
            k = slot[s]
            if (passed[s] - 1) % step[s] or counts[k] == out.shape[1]:
                continue
            z = np.float64(depth[r, c])
            out[k, counts[k], 0] = (c - intrinsics[2]) * z / intrinsics[0]
            out[k, counts[k], 1] = (r - intrinsics[3]) * z / intrinsics[1]
            out[k, counts[k], 2] = z
            counts[k] += 1


@compiled
def bridges(depth: Singles, near: float, steep: float, longest: int, between: Bools) -> int:
    """Pixels that hold neither of the two surfaces they lie between, along a row or a column.

    From one surface to the next there is one leap. Where depth leaps several times the same way, pixel after pixel,
    those between are a blend of both sides. Only a surface seen along itself leaps so, too, and that goes on: what
    leaps more often is kept, and so is what has nothing measured beyond either end, for nothing tells how far it goes.

    Parameters
    ----------
    depth : (H, W) m, NaN = no return.
    near, steep : a leap is more than near + steep · z² m, z being the nearer depth.
    longest : how many leaps one after the other still are a bridge.
    between : (H, W), written: True where a pixel is part of one.

    Returns
    -------
    How many there are.
    """
    height, width = depth.shape
    least, count = np.float32(near), 0
    leaps = np.empty(width, np.bool_)
    between[:] = False
    for r in range(height):
        # enough for most pixels, several at once: no leap, whatever the depth
        leaps[width - 1] = False
        for c in range(width - 1):
            leaps[c] = abs(depth[r, c + 1] - depth[r, c]) > least
        if r + 1 < height:
            for c in range(width):
                leaps[c] |= abs(depth[r + 1, c] - depth[r, c]) > least
        for c in range(width):
            if not leaps[c]:
                continue
            z = depth[r, c]
            for axis in range(2):
                down, across = axis, 1 - axis
                if r < down or c < across or r + down >= height or c + across >= width:
                    continue
                after = depth[r + down, c + across]
                way = 1 if after > z else -1
                if not _leaps(z, after, way, near, steep) or not _leaps(
                    depth[r - down, c - across], z, way, near, steep
                ):
                    continue
                back = _leaps_on(depth, r, c, -down, -across, -way, near, steep, longest)
                on = _leaps_on(depth, r, c, down, across, way, near, steep, longest)
                between[r, c] |= back > 0 and on > 0 and back + on <= longest
            count += between[r, c]
    return count


@compiled
def _leaps(z: float, after: float, way: int, near: float, steep: float) -> bool:
    """Whether depth in m leaps from one pixel to the next, farther where `way` is 1, nearer where -1; NaN does not."""
    least = z if z < after else after
    return bool(way * (after - z) > near + steep * least * least)


@compiled
def _leaps_on(
    depth: Singles, r: int, c: int, down: int, across: int, way: int, near: float, steep: float, most: int
) -> int:
    """How many leaps follow each other from a pixel on, `most` at most; 0 where nothing is measured beyond the last."""
    count = 0
    while 0 <= r + down < depth.shape[0] and 0 <= c + across < depth.shape[1]:
        z, after = depth[r, c], depth[r + down, c + across]
        if count == most or not _leaps(z, after, way, near, steep):
            return 0 if np.isnan(after) else count
        r, c, count = r + down, c + across, count + 1
    return 0
