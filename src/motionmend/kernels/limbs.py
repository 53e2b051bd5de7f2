"""How well other poses of a limb would explain what is seen: only the limb is cast anew, onto the rest of the body."""

import numpy as np

from ..arrays import Bools, Floats, Ints, Singles
from . import articulated, raycast, rendered
from .body import Chain, Posed, Shell
from .compile import compiled
from .putting import put

_frames, _frame = articulated.frames, articulated.frame
_picture = rendered.picture
_place, _prepare, _cast, _cast_onto = raycast.place, raycast.prepare, raycast.cast, raycast.cast_onto

BESIDE = 0.7  # of a pixel that only one of the two bodies has, next to the other's outline


@compiled
def unlikeness(seen: Singles, free: Bools, rendered: Singles, most: float, each: Floats) -> float:
    """How wrong pixels of images (H, W) are, 0 to 1: the difference in depth over `most`, 1 where only one has a body.

    A pixel that is neither the person nor free counts 0 whatever is rendered. Beside the body that it lacks one counts
    `BESIDE`: a shirt is wider than the trunk in it, and not an arm.

    Parameters
    ----------
    seen, free : (H, W) m, NaN = not the person, and where surely nobody is.
    rendered : (H, W) m, NaN = nothing there.
    most : m.
    each : (H, W) is written.

    Returns
    -------
    The sum over all pixels.
    """
    total = 0.0
    for row in range(seen.shape[0]):
        each[row] = 0.0
        some = 0
        for column in range(seen.shape[1]):  # quick: most rows of an image have neither body
            some += (seen[row, column] == seen[row, column]) | (rendered[row, column] == rendered[row, column])
        if some == 0:
            continue
        for column in range(seen.shape[1]):
            there, z = seen[row, column], rendered[row, column]
            if np.isnan(z) and np.isnan(there):  # as nearly everywhere
                continue
            one = 0.0
            if np.isnan(z):
                one = BESIDE if beside(rendered, row, column) else 1.0
            elif not np.isnan(there):
                one = min(1.0, abs(there - z) / most)
            elif free[row, column]:
                one = BESIDE if beside(seen, row, column) else 1.0
            each[row, column] = one
            total += one
    return total


@compiled
def beside(depth: Singles, row: int, column: int) -> bool:
    """Whether one of a pixel's four neighbours in an image (H, W) has a depth."""
    return bool(
        (row > 0 and not np.isnan(depth[row - 1, column]))
        or (row + 1 < depth.shape[0] and not np.isnan(depth[row + 1, column]))
        or (column > 0 and not np.isnan(depth[row, column - 1]))
        or (column + 1 < depth.shape[1] and not np.isnan(depth[row, column + 1]))
    )


@compiled
def disagreements(
    chain: Chain,
    translations: Floats,
    roots: Floats,
    joints: Floats,
    shell: Shell,
    camera: Floats,
    seen: Singles,
    free: Bools,
    most: float,
    costs: Floats,
) -> None:
    """The disagreement of a body in each of C poses with what is seen.

    Parameters
    ----------
    translations, roots, joints : (C, 3) m, (C, 3, 3) and (C, J) rad.
    camera : (4,) of the images. seen, free : (H, W) what is observed, and where nobody is.
    most : m, see `unlikeness`. costs : (C,) is written.
    """
    frames, count = np.empty((len(chain.parents), 4, 4)), len(shell.carriers)
    placed, parts = np.empty((count, 3, 4)), np.empty((count, raycast.PARTS))
    depth, solid = np.empty(seen.shape, np.float32), np.empty(seen.shape, np.int16)
    each = np.empty(seen.shape)
    for c in range(len(costs)):
        pose = Posed(translations[c], roots[c], joints[c])
        _picture(chain, pose, shell, camera, frames, placed, parts, depth, solid)
        costs[c] = unlikeness(seen, free, depth, most, each)


@compiled
def limb_search(
    chain: Chain,
    pose: Posed,
    columns: Ints,
    candidates: Floats,
    limb: Ints,
    shell: Shell,
    camera: Floats,
    seen: Singles,
    free: Bools,
    most: float,
    costs: Floats,
    limits: Floats,
    mean: Floats,
    form: Floats,
    picks: Ints,
    noise: Floats,
    kept: int,
    best: Floats,
) -> float:
    """The disagreement of a body with each of many poses of one limb; then, if wanted, closer about the best of them.

    Parameters
    ----------
    columns, candidates : (n,) joint coordinates of the limb and (C, n) their values to be tried.
    limb : bones of the limb, parents first.
    camera : (4,) of the images.
    seen, free : (H, W) what is observed, and where nobody is.
    most : m, see `unlikeness`.
    costs : (2, C) is written: a sum over pixels, and the same with by how much more is said against it than against the
        pose as it is.
    limits : (D, 2) least and most of every degree of freedom.
    mean, form : (J,), (J, J) what is said against joint coordinates, in pixels: (joints - mean)' form (joints - mean);
        or of length 0: nothing.
    picks, noise : (R, K) and (R, K, n): in each of R rounds the `kept` cheapest so far stay, and K are drawn, each by
        the noise, rad, about the one of them that it picks.
    kept : how many stay.
    best : (n,) is written: the cheapest of all, what is said against it included.

    Returns
    -------
    What the best costs, beyond what is said against the pose as it is.
    """
    height, width = seen.shape
    joints = pose.joints
    carriers, kinds, centers, turns, sizes, tapers = shell
    frames = np.empty((len(chain.parents), 4, 4))
    _frames(chain, pose, frames)
    own = _of_limb(limb, carriers, len(frames))  # apart from all other solids, which are cast only once
    placed, parts = np.empty((len(carriers), 3, 4)), np.empty((len(carriers), raycast.PARTS))
    _place(frames, carriers, centers, turns, placed)
    _prepare(placed, kinds, sizes, tapers, camera, width, height, parts)
    for i in range(len(own)):
        parts[own[i], 15] = -1.0  # nothing is seen in an empty box
    base, solid = np.empty(seen.shape, np.float32), np.empty(seen.shape, np.int16)
    depth, below = np.empty(seen.shape, np.float32), np.empty(seen.shape)
    _cast(parts, base, solid)
    rest = unlikeness(seen, free, base, most, below)
    depth[:] = np.nan
    part = Shell(carriers[own], kinds[own], centers[own], turns[own], sizes[own], tapers[own])
    placed, parts, tried = np.empty((len(own), 3, 4)), np.empty((len(own), raycast.PARTS)), joints.copy()
    turn, rested = np.empty((3, 3)), np.empty((3, 3))
    rounds, drawn, size = picks.shape[0], picks.shape[1], len(columns)
    uphill = np.zeros(size)  # the slope of what is said against the pose as it is
    for k in range(size):
        for j in range(len(mean)):
            uphill[k] += 2.0 * form[columns[k], j] * (joints[j] - mean[j])
    total = max(len(candidates), kept + drawn)
    pool, prices = np.empty((total, size)), np.empty(total)
    for c in range(len(candidates)):
        for k in range(size):
            pool[c, k] = candidates[c, k]
    begin, count = 0, len(candidates)
    for r in range(rounds + 1):
        if r > 0:
            begin = min(kept, count)
            _cheapest_first(prices[:count], pool, begin)
            for i in range(drawn):
                about = picks[r - 1, i] % begin
                for k in range(size):
                    value = pool[about, k] + noise[r - 1, i, k]
                    pool[begin + i, k] = min(max(value, limits[6 + columns[k], 0]), limits[6 + columns[k], 1])
            count = begin + drawn
        for c in range(begin, count):
            prices[c] = rest + _changed(
                pool[c], chain, columns, tried, limb, part, camera, seen, free, most, base, below, frames, placed,
                parts, depth, solid, turn, rested,
            )  # fmt: skip
            against = _against(pool[c], columns, joints, uphill, form)
            if r == 0:
                costs[0, c], costs[1, c] = prices[c], prices[c] + against
            prices[c] += against
    _cheapest_first(prices[:count], pool, 1)
    put(best, pool[0])
    return float(prices[0])


@compiled
def _of_limb(limb: Ints, carriers: Ints, bones: int) -> Ints:
    """Which solids are on some of the bones: `limb` (n,) of so many, `carriers` (P,) the bone of each solid."""
    moves = np.zeros(bones, np.bool_)
    for b in limb:
        moves[b] = True
    own, count = np.empty(len(carriers), np.int64), 0
    for s in range(len(carriers)):
        if moves[carriers[s]]:
            own[count] = s
            count += 1
    return own[:count]


@compiled
def _cheapest_first(prices: Floats, pool: Floats, kept: int) -> None:
    """The cheapest of poses (C, n) to the front, in the order of their prices (C,), the earlier of equal ones first."""
    for i in range(kept):
        least = i
        for c in range(i + 1, len(prices)):
            if prices[c] < prices[least]:
                least = c
        for c in range(least, i, -1):
            prices[c], prices[c - 1] = prices[c - 1], prices[c]
            for k in range(pool.shape[1]):
                pool[c, k], pool[c - 1, k] = pool[c - 1, k], pool[c, k]


@compiled
def _changed(
    values: Floats,
    chain: Chain,
    columns: Ints,
    joints: Floats,
    limb: Ints,
    shell: Shell,
    camera: Floats,
    seen: Singles,
    free: Bools,
    most: float,
    base: Singles,
    below: Floats,
    frames: Floats,
    placed: Floats,
    parts: Floats,
    depth: Singles,
    solid: np.ndarray,
    turn: Floats,
    rested: Floats,
) -> float:
    """By how much the disagreement changes when the limb is added with these values (n,) to the rest of the body.

    The limb's own outline has no margin here: what it leaves beside itself counts in full.

    `shell` is of the limb's solids alone; `base`, `below` (H, W) the rest as rendered and its unlikeness;
    `depth` is empty before and after; `joints`, `frames`, `placed`, `parts`, `solid`, `turn` and `rested` are
    overwritten.
    """
    bones, kinds, centers, turns, sizes, tapers = shell
    for k in range(len(columns)):
        joints[columns[k]] = values[k]
    for b in limb:
        _frame(b, chain, joints, turn, rested, frames)
    _place(frames, bones, centers, turns, placed)
    _prepare(placed, kinds, sizes, tapers, camera, seen.shape[1], seen.shape[0], parts)
    _cast_onto(parts, depth, solid)
    top, bottom, left, right = float(seen.shape[0]), -1.0, float(seen.shape[1]), -1.0
    for s in range(len(bones)):
        if parts[s, 15] >= parts[s, 14] and parts[s, 17] >= parts[s, 16]:
            left, right = min(left, parts[s, 14]), max(right, parts[s, 15])
            top, bottom = min(top, parts[s, 16]), max(bottom, parts[s, 17])
    total = 0.0
    for row in range(int(top), int(bottom) + 1):
        for column in range(int(left), int(right) + 1):
            z = depth[row, column]
            if np.isnan(z):
                continue
            depth[row, column] = np.nan  # empty for the next
            if z >= base[row, column]:
                continue
            there = seen[row, column]
            if not np.isnan(there):
                total += min(1.0, abs(there - z) / most)
            elif free[row, column]:
                total += BESIDE if beside(seen, row, column) else 1.0
            total -= below[row, column]
    return total


@compiled
def _against(values: Floats, columns: Ints, joints: Floats, uphill: Floats, form: Floats) -> float:
    """By how much more a quadratic form is against joints (J,) with these values (n,) for n of them; `uphill` (n,)."""
    total = 0.0
    if len(form) == 0:
        return total
    for k in range(len(columns)):
        slope = uphill[k]
        for m in range(len(columns)):
            slope += form[columns[k], columns[m]] * (values[m] - joints[columns[m]])
        total += (values[k] - joints[columns[k]]) * slope
    return total


@compiled
def limb_places(
    chain: Chain,
    pose: Posed,
    columns: Ints,
    candidates: Floats,
    limb: Ints,
    bones: Ints,
    local: Floats,
    places: Floats,
) -> None:
    """Where points of a limb are, with other coordinates of its joints.

    Parameters
    ----------
    columns, candidates, limb : as above.
    bones, local : (K,) and (K, 3) m, the points. places : (C, K, 3) m, written.
    """
    tried, frames = pose.joints.copy(), np.empty((len(chain.parents), 4, 4))
    turn, rested = np.empty((3, 3)), np.empty((3, 3))
    _frames(chain, pose, frames)
    for c in range(candidates.shape[0]):
        for k in range(len(columns)):
            tried[columns[k]] = candidates[c, k]
        for b in limb:
            _frame(b, chain, tried, turn, rested, frames)
        articulated.points(frames, bones, local, places[c])


@compiled
def shown_and_denied(
    seen: Singles,
    free: Bools,
    rendered: Singles,
    solid: np.ndarray,
    carriers: Ints,
    fit: float,
    shown: Floats,
    denied: Floats,
    unknown: Floats,
) -> None:
    """Pixels of each bone that are seen where they are rendered, that are not there, and of which nothing is known.

    Parameters
    ----------
    seen, free, rendered, solid : (H, W) as above; solid -1 = nothing rendered.
    carriers : (P,) the bone of each solid.
    fit : m, closer than this is seen there; where nobody is, or what is seen is farther away, it is not there.
    shown, denied, unknown : (B,), added to.
    """
    for row in range(seen.shape[0]):
        for column in range(seen.shape[1]):
            s = solid[row, column]
            if s < 0:
                continue
            apart = seen[row, column] - rendered[row, column]
            if abs(apart) < fit:
                shown[carriers[s]] += 1.0
            if apart > fit or free[row, column]:
                denied[carriers[s]] += 1.0
            elif np.isnan(apart):
                unknown[carriers[s]] += 1.0
