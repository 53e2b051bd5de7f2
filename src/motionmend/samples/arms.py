"""Arms: swinging from the shoulder, or stretched out to where the hand should be."""

from dataclasses import dataclass

import numpy as np

from ..arrays import Floats
from .body import SIDES, Build, arm_axes, rotation

_FOLD_REST = np.array([0.0, 0.5, np.sqrt(0.75)])  # where the forearm goes at rest when the elbow bends
_SOFT_ELBOW, _LEAST_ELBOW = np.radians(40.0), np.radians(8.0)


@dataclass(frozen=True, eq=False)
class Arms:
    """Both arms in the thorax' axes; second axis 0 left, 1 right.

    Attributes
    ----------
    upper : (T, 2, 3) unit vectors from shoulder to elbow.
    fold : (T, 2, 3) where the forearm goes when the elbow bends; only its part across the upper arm counts.
    elbow : (T, 2) rad, flexion.
    clavicle : (T, 2, 2) rad, forward and up.
    wrist : (T, 2) rad, palm turned forward of facing the thigh.
    hand : (T, 2) rad, flexion.
    """

    upper: Floats
    fold: Floats
    elbow: Floats
    clavicle: Floats
    wrist: Floats
    hand: Floats


def swung(
    swing: Floats, away: Floats, inward: Floats, elbow: Floats, clavicle: Floats, wrist: Floats, hand: Floats
) -> Arms:
    """Arms by angles (T, 2) in rad: upper arm forward of hanging and away from the side, forearm turned inward."""
    mirror = np.array([1.0, -1.0])
    upper = np.stack([mirror * np.sin(away), -np.cos(away) * np.cos(swing), np.cos(away) * np.sin(swing)], axis=2)
    fold = np.stack([-mirror * np.sin(inward), np.sin(swing) * np.cos(inward), np.cos(swing) * np.cos(inward)], axis=2)
    return Arms(upper, fold, elbow, clavicle, wrist, hand)


def shoulder(b: Build, side: int, clavicle: Floats) -> Floats:
    """(T, 3) m: the shoulder from the thorax' far end, in the thorax' axes, for clavicle angles (T, 2) rad."""
    out, up = b.clavicle
    return np.asarray(_clavicle(side, clavicle) @ np.array([(1 - 2 * side) * out, up, 0.0]))


def stretched(b: Build, side: int, to: Floats) -> tuple[Floats, Floats, Floats]:
    """Upper arm (T, 3), fold (T, 3) and elbow (T,) rad that bring the wrist by `to` (T, 3) m from the shoulder.

    The elbow points back when the arm hangs, down when it is held forward, to the side when it is held up, and is
    never quite straight: a place further away is not reached.
    """
    mirror = 1 - 2 * side
    l1, l2 = b.upper_arm, b.forearm
    near, far = (l1**2 + l2**2 + 2 * l1 * l2 * np.cos(elbow) for elbow in (_SOFT_ELBOW, _LEAST_ELBOW))
    squared = np.sum(to * to, axis=1)
    squared = np.minimum(squared, near) + (far - near) * np.tanh(np.maximum(squared - near, 0.0) / (far - near))
    elbow = np.arccos(np.clip((squared - l1**2 - l2**2) / (2 * l1 * l2), -1.0, 1.0))
    along = to / np.linalg.norm(to, axis=1, keepdims=True)
    pole = np.cross([1.0, 0.0, 0.0], along) + np.array([0.35 * mirror, -0.25, -0.15])
    pole -= np.sum(pole * along, axis=1, keepdims=True) * along
    pole /= np.linalg.norm(pole, axis=1, keepdims=True)
    angle = np.arctan2(l2 * np.sin(elbow), l1 + l2 * np.cos(elbow))[:, None]  # between upper arm and `to`
    upper = np.cos(angle) * along + np.sin(angle) * pole
    return upper, np.cos(angle) * -pole + np.sin(angle) * along, elbow


def arm_angles(arms: Arms) -> dict[str, Floats]:
    """(T,) rad by DOF name: humerus by Euler angles in its own axes, the rest one by one."""
    angles: dict[str, Floats] = {}
    for side, s in enumerate(SIDES):
        mirror = 1 - 2 * side
        clavicle = _clavicle(side, arms.clavicle[:, side])
        rest = _frame(np.array([[float(mirror), 0.0, 0.0]]), _FOLD_REST[None])
        aimed = np.swapaxes(clavicle, 1, 2) @ _frame(arms.upper[:, side], arms.fold[:, side])
        local = arm_axes(side).T @ aimed @ np.swapaxes(rest, 1, 2) @ arm_axes(side)
        hand = arms.hand[:, side]
        angles |= {
            f"{s}clavicle.ry": -mirror * arms.clavicle[:, side, 0],
            f"{s}clavicle.rz": mirror * arms.clavicle[:, side, 1],
            f"{s}humerus.rx": np.unwrap(np.arctan2(local[:, 2, 1], local[:, 2, 2])),
            f"{s}humerus.ry": np.arcsin(np.clip(-local[:, 2, 0], -1.0, 1.0)),
            f"{s}humerus.rz": np.unwrap(np.arctan2(local[:, 1, 0], local[:, 0, 0])),
            f"{s}radius.rx": arms.elbow[:, side],
            f"{s}wrist.ry": mirror * arms.wrist[:, side],
            f"{s}hand.rx": hand,
            f"{s}hand.rz": mirror * (np.radians(6.0) + 0.1 * hand),
            f"{s}fingers.rx": np.radians(16.0) + 0.4 * hand,
            f"{s}thumb.rx": np.radians(6.0) + 0.2 * hand,
            f"{s}thumb.rz": mirror * (np.radians(25.0) + 0.2 * hand),
        }
    return angles


def _clavicle(side: int, angles: Floats) -> Floats:
    """(T, 3, 3) the clavicle's rotation for (T, 2) rad forward and up."""
    mirror = 1 - 2 * side
    return np.asarray(rotation(2, mirror * angles[:, 1]) @ rotation(1, -mirror * angles[:, 0]))


def _frame(along: Floats, fold: Floats) -> Floats:
    """(T, 3, 3) columns: along a bone, across it towards `fold`, and across both."""
    across = fold - np.sum(fold * along, axis=1, keepdims=True) * along
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    return np.stack([along, across, np.cross(along, across)], axis=2)
