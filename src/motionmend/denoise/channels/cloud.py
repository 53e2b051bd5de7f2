"""Markers as channels: centimetres in a frame that travels and turns with the body."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from ...arrays import Bools, Floats, Ints, frozen
from ...errors import MismatchError
from ...numerics.quantiles import quantile_of_known
from ...numerics.robust import ESTIMATORS
from .joints import CENTIMETRES
from .pieces import pieces
from .travel import Travel, travel, turn

RIGID = 0.02  # m; markers on one segment keep their distance this well, skin and all
MOST_ANCHORS = 12
KEPT = 0.95  # share of the clips in which anchors keep their distances
FIT_FLOOR = 0.015  # m; an anchor this near its place counts fully


@dataclass(frozen=True, eq=False)
class Anchors:
    """The most rigid group of markers near the body's middle, by which place and heading are found.

    Attributes
    ----------
    indices : (A,) into the layout's markers.
    template : (A, 3) m, their mean places in the body's own frame, centred.
    """

    indices: Ints
    template: Floats

    def __post_init__(self) -> None:
        object.__setattr__(self, "indices", frozen(self.indices, np.int64))
        object.__setattr__(self, "template", frozen(self.template))


@dataclass(frozen=True, eq=False)
class CloudChannels:
    """Markers as channels: three columns a marker, x y z after another.

    Attributes
    ----------
    values : (T, 3 M) cm in the travelling frame, NaN = missing.
    travel : the travelling frame, in the model's axes.
    righting : (3, 3) turns the recording's axes to the model's.
    """

    values: Floats
    travel: Travel
    righting: Floats


def righting(up: Floats, model_up: Floats) -> Floats:
    """(3, 3) the shortest rotation that brings `up` (3,) to `model_up` (3,), both of length 1."""
    if np.allclose(up, model_up):
        return np.eye(3)  # exactly: most recordings need no turning
    if np.allclose(up, -model_up):
        # any half turn about a level axis will do
        level = np.eye(3)[int(np.argmin(np.abs(up)))]
        level = level - (level @ up) * up
        level = level / np.linalg.norm(level)
        return np.asarray(2.0 * np.multiply.outer(level, level) - np.eye(3))
    return np.asarray(Rotation.align_vectors(model_up[None], up[None])[0].as_matrix())


def orientation_tensor(positions: Floats) -> Floats:
    """(3, 3) m: which way markers (T, M, 3) m go, NaN = missing, and how far; it turns with the recording.

    The outer products of all steps, each over its length, so that a few leaps hardly count.
    """
    found = np.zeros((3, 3))
    for some in pieces(len(positions)):
        steps = np.diff(positions[some.start : some.stop + 1], axis=0).reshape(-1, 3)
        length = np.linalg.norm(steps, axis=1)
        known = np.isfinite(length) & (length > 0.0)
        found += (steps[known] / length[known, None]).T @ steps[known]
    return found


def main_heading(positions: Floats, up: Floats) -> float:
    """Rad about `up` (3,) of the level line along which markers (T, M, 3) m, NaN = missing, go to and fro most."""
    level = np.eye(3)[int(np.argmin(np.abs(up)))]
    along = level - (level @ up) * up
    along = along / np.linalg.norm(along)
    both = np.stack([along, np.cross(up, along)])
    (xx, xy), (_, yy) = both @ orientation_tensor(positions) @ both.T
    return float(0.5 * np.arctan2(2.0 * xy, xx - yy))


def cloud_channels(
    positions: Floats, fps: float, up: Floats, anchors: Anchors, model_up: Floats, facing: float = 0.0
) -> CloudChannels:
    """Channels of markers (T, M, 3) m at `fps` Hz, by the anchors' robustly fitted place and heading.

    The recording's own `up` (3,) is turned to `model_up` (3,) first, and what is `facing` (rad) about that to 0.
    """
    upright = righting(up, model_up)
    if facing:
        upright = turn(np.array([-facing]), model_up)[0] @ upright
    positions, up = positions @ upright.T, model_up
    place, heading = fit_anchors(positions[:, anchors.indices], anchors.template, up)
    frame = travel(place, heading, fps, up)
    local = np.einsum("tji,tmj->tmi", frame.rotations(), positions - frame.place[:, None])
    return CloudChannels(CENTIMETRES * local.reshape(len(positions), 3 * positions.shape[1]), frame, upright)


def positions_of(channels: CloudChannels, repaired: Floats) -> Floats:
    """(T, M, 3) m: repaired channels (T, 3 M) cm back in the world; NaN stays NaN."""
    local, frame = in_metres(repaired), channels.travel
    there = np.einsum("tij,tmj->tmi", frame.rotations(), local) + frame.place[:, None]
    return np.asarray(there @ channels.righting)


def in_metres(values: Floats) -> Floats:
    """(T, M, 3) m, the places that channels of markers (T, 3 M) cm are, in the frame that they are in."""
    return values.reshape(len(values), values.shape[1] // 3, 3) / CENTIMETRES


def learn_anchors(changes: Sequence[Floats], frames: Floats, up: Floats) -> Anchors:
    """Find the largest group of markers that keep their distances, and its mean shape.

    Of more than twenty clips one in twenty may break a distance: a marker that was lost, or that fell off.

    Parameters
    ----------
    changes : each (M, M) m, `distance_change` of a clip.
    frames : (N, M, 3) m of those clips, NaN = missing.
    up : (3,) unit vector.

    Raises
    ------
    MismatchError : fewer than three markers are ever seen together.
    """
    change = np.sort(np.stack(changes), axis=0)[int(np.ceil(KEPT * (len(changes) - 1)))]
    members = _rigid_group(change, _middle_distance(frames))
    if len(members) < 3:
        raise MismatchError(
            f"a body's place and heading need three markers seen together, came {len(members)}: "
            "give clips with more markers"
        )
    return Anchors(members, _mean_shape(frames[:, members], up))


def distance_change(positions: Floats) -> Floats:
    """(M, M) m: robust standard deviation over time of the markers' distances; inf where too rarely seen.

    Parameters
    ----------
    positions : (T, M, 3) m, NaN = missing.
    """
    count = positions.shape[1]
    spread = np.full((count, count), np.inf)
    for i in range(count):
        distance = np.linalg.norm(positions - positions[:, i : i + 1], axis=2)
        seen = np.isfinite(distance).sum(axis=0) >= max(2, len(positions) // 10)
        known = distance[:, seen]
        spread[i, seen] = 1.4826 * quantile_of_known(np.abs(known - quantile_of_known(known, 0.5)), 0.5)
    return spread


def _middle_distance(positions: Floats) -> Floats:
    """(M,) median distance of each marker from the middle of the body in frames (N, M, 3), m."""
    known = np.asarray(np.isfinite(positions).all(axis=2))
    weight = known[..., None] / np.maximum(known.sum(axis=1), 1)[:, None, None]
    centre = np.where(known[..., None], positions, 0.0)
    distances = np.linalg.norm(positions - (centre * weight).sum(axis=1)[:, None], axis=2)
    distances[~np.isfinite(distances)] = np.inf
    return np.asarray(np.median(distances, axis=0))


def _rigid_group(change: Floats, middle: Floats) -> Ints:
    """The largest group found whose markers all keep their distances to each other, at most a dozen.

    Each marker gathers its neighbours, steadiest first, as long as they are steady to all gathered before; the
    largest group wins, of equals the one nearest the body's middle. Where a body shows no rigid trio, the limit
    is doubled until one is found.
    """
    limit = RIGID
    for _ in range(12):
        best: list[int] = []
        for seed in np.argsort(middle, kind="stable"):
            group = [int(seed)]
            for other in np.argsort(change[seed], kind="stable"):
                if len(group) < MOST_ANCHORS and other != seed and (change[other, group] < limit).all():
                    group.append(int(other))
            if len(group) > len(best):
                best = group
        if len(best) >= 3:
            return np.sort(np.array(best, dtype=np.int64))
        limit *= 2.0
    return np.empty(0, dtype=np.int64)


def _mean_shape(together: Floats, up: Floats) -> Floats:
    """(A, 3) m: the anchors' mean places after turning and moving every frame (N, A, 3) onto the mean."""
    whole = together[np.isfinite(together).all(axis=(1, 2))]
    if len(whole) == 0:
        raise MismatchError(
            "the markers that keep their distances are never all seen in one frame: "
            "place and heading cannot be learned from these clips"
        )
    template = whole[0] - whole[0].mean(axis=0)
    for _ in range(5):
        place, heading = fit_anchors(whole, template, up)
        frame = Travel(place, heading, up)
        local = np.einsum("tji,taj->tai", frame.rotations(), whole - place[:, None])
        template = local.mean(axis=0)
        template = template - template.mean(axis=0)
    return np.asarray(template)


def fit_anchors(observed: Floats, template: Floats, up: Floats) -> tuple[Floats, Floats]:
    """Place and heading of the template in each frame: weighted least squares, re-weighted against outliers.

    Parameters
    ----------
    observed : (T, A, 3) m, NaN = missing.
    template : (A, 3) m.
    up : (3,) unit vector; only turns about it are sought.

    Returns
    -------
    place (T, 3) m and heading (T,) rad, NaN where fewer than two anchors are seen.
    """
    seen: Bools = np.asarray(np.isfinite(observed).all(axis=2))
    known = np.where(seen[..., None], observed, 0.0)
    weights = seen.astype(float)
    if len(template) == 0:
        return np.full((len(observed), 3), np.nan), np.full(len(observed), np.nan)
    scale = np.full(len(observed), np.inf)
    welsch = ESTIMATORS["welsch"].weight
    for _ in range(10):
        share = weights / np.maximum(weights.sum(axis=1, keepdims=True), 1e-12)
        centre = np.einsum("ta,taj->tj", share, known)
        middle = share @ template
        body = template[None] - middle[:, None]
        cloud = known - centre[:, None]
        sine = np.einsum("ta,taj->tj", share, np.cross(body, cloud)) @ up
        cosine = np.einsum("ta,taj,taj->t", share, body, cloud)
        cosine -= np.einsum("ta,ta,ta->t", share, body @ up, cloud @ up)
        heading = np.arctan2(sine, cosine)
        turned = np.einsum("tij,taj->tai", turn(heading, up), body)
        residual = np.where(seen, np.linalg.norm(cloud - turned, axis=2), np.nan)
        # the scale only shrinks, so that the fit settles on the majority of the anchors
        some = np.asarray(seen.any(axis=1))[:, None]
        spread = np.nan_to_num(quantile_of_known(np.where(some, residual, 0.0).T, 0.5))
        scale = np.minimum(scale, 3.0 * np.maximum(1.4826 * spread, FIT_FLOOR))
        weights = seen * welsch(np.nan_to_num(residual) / scale[:, None], 1.0)
    place = centre - np.einsum("tij,tj->ti", turn(heading, up), middle)
    lost = seen.sum(axis=1) < 2
    return np.where(lost[:, None], np.nan, place), np.where(lost, np.nan, heading)
