"""Spoil a clean recording in a known way: noise, outliers, gaps, whole channels gone."""

from collections.abc import Collection
from dataclasses import dataclass, replace
from difflib import get_close_matches
from typing import Generic

import numpy as np

from ..arrays import Bools, Floats, frozen
from ..bodies.motion import Markers, Motion, Recording
from ..bodies.skeleton import TRANSLATION
from ..errors import UsageError

OUTLIER_ANGLE = (np.radians(15.0), np.radians(55.0))  # rad
OUTLIER_TRANSLATION = (0.15, 0.55)  # m
OUTLIER_MARKER = (0.05, 0.5)  # m
GAP_SECONDS = (0.1, 2.0)
METRES_PER_RADIAN = 0.01 / np.radians(1.0)  # noise of a translation for noise of an angle

_NOISE, _OUTLIERS, _GAPS = range(3)  # one random stream each, so that one kind never shifts another


@dataclass(frozen=True, eq=False)
class Corrupted(Generic[Recording]):
    """A spoilt recording and the truth about what was spoilt. C = D channels or M markers.

    Attributes
    ----------
    recording : same channels, frames and rate as the clean one.
    noise : (T, C) True where Gaussian noise was added (every recorded sample, when there is any noise).
    outlier : (T, C) True where the recording holds an outlier; one that a gap swallowed is not counted.
    missing : (T, C) True where the recording lacks a sample, those missing before included.
    """

    recording: Recording
    noise: Bools
    outlier: Bools
    missing: Bools

    def __post_init__(self) -> None:
        for name in ("noise", "outlier", "missing"):
            object.__setattr__(self, name, frozen(getattr(self, name), np.bool_))


def corrupt(
    recording: Recording,
    *,
    noise: float = 0.0,
    outliers: float = 0.0,
    gaps: float = 0.0,
    drop: Collection[str] = (),
    seed: int = 0,
) -> Corrupted[Recording]:
    """Spoil a recording; the same arguments give the same result, and each kind of damage has its own stream.

    Parameters
    ----------
    recording : T frames of C = D channels or M markers; samples already missing stay missing.
    noise : standard deviation of Gaussian noise, independent in every sample: rad for rotations (translations
        then get 0.01 m per degree), m for each coordinate of a marker.
    outliers : share in [0, 1] of the recorded samples that are moved away: rotations by 15 to 55 degrees and
        translations by 0.15 to 0.55 m with random sign, markers by 0.05 to 0.5 m in a random direction.
    gaps : share in [0, 1] of the recorded samples that go missing, in bursts of 0.1 to 2 s; in a motion all
        DOFs of a joint go together and the root never goes.
    drop : joints, channels or markers that are missing throughout, with or without the subject's prefix
        (`Subject:LFHD` or `LFHD`; without it, in every subject).
    seed : 0 or above.

    Returns
    -------
    Corrupted
        The recording and (T, C) masks of what was done.

    Raises
    ------
    UsageError
        A negative or not finite amount, a share above 1, more gaps than the recording can have, or a name in
        `drop` that the recording does not know.
    """
    _check_amounts(noise, outliers, gaps, seed)
    present = np.asarray(recording.present)
    outlier_rng = np.random.default_rng([seed, _OUTLIERS])
    hit = _outlier_mask(present, outliers, outlier_rng)
    gone = _gap_mask(recording, present, gaps, np.random.default_rng([seed, _GAPS]))
    gone |= _drop_mask(recording, drop)
    missing = gone | ~present
    noise_rng = np.random.default_rng([seed, _NOISE])
    return Corrupted(
        recording=_spoilt(recording, noise, noise_rng, hit, outlier_rng, missing),
        noise=~missing & (noise > 0),
        outlier=hit & ~missing,
        missing=missing,
    )


def _spoilt(
    recording: Recording,
    noise: float,
    noise_rng: np.random.Generator,
    hit: Bools,
    outlier_rng: np.random.Generator,
    missing: Bools,
) -> Recording:
    """The recording with noise everywhere, outliers where `hit` and NaN where `missing`."""
    if isinstance(recording, Motion):
        translation = recording.skeleton.dof_kind == TRANSLATION
        scale = np.where(translation, noise * METRES_PER_RADIAN, noise)
        q = recording.q + scale * noise_rng.standard_normal(recording.q.shape)
        q = np.where(hit, q + _angle_offsets(recording.q.shape, translation, outlier_rng), q)
        return recording.with_q(np.where(missing, np.nan, q))
    shape = recording.positions.shape
    positions = recording.positions + noise * noise_rng.standard_normal(shape)
    positions = np.where(hit[:, :, None], positions + _marker_offsets(shape, outlier_rng), positions)
    positions = np.where(missing[:, :, None], np.nan, positions)
    residuals = None if recording.residuals is None else np.where(missing, -1.0, recording.residuals)
    return replace(recording, positions=positions, residuals=residuals)


def _angle_offsets(shape: tuple[int, ...], translation: Bools, rng: np.random.Generator) -> Floats:
    """(T, D) rad and m: what an outlier in each sample is off by."""
    size, sign = rng.random(shape), rng.choice([-1.0, 1.0], shape)
    low = np.where(translation, OUTLIER_TRANSLATION[0], OUTLIER_ANGLE[0])
    high = np.where(translation, OUTLIER_TRANSLATION[1], OUTLIER_ANGLE[1])
    return np.asarray(sign * (low + (high - low) * size))


def _marker_offsets(shape: tuple[int, ...], rng: np.random.Generator) -> Floats:
    """(T, M, 3) m: what an outlier in each sample is off by, all directions alike."""
    direction = rng.standard_normal(shape)
    direction /= np.linalg.norm(direction, axis=2, keepdims=True)
    return np.asarray(direction * rng.uniform(*OUTLIER_MARKER, (*shape[:2], 1)))


def _outlier_mask(present: Bools, share: float, rng: np.random.Generator) -> Bools:
    """(T, C) True for the rounded share of the samples that are present."""
    candidates = np.flatnonzero(present)
    mask = np.zeros(present.size, dtype=bool)
    mask[rng.permutation(candidates)[: round(share * candidates.size)]] = True
    return mask.reshape(present.shape)


def _gap_mask(recording: Motion | Markers, present: Bools, share: float, rng: np.random.Generator) -> Bools:
    """(T, C) True in bursts until the share of the present samples is reached.

    A burst starts at a sample that is still there, so each makes progress; bursts may meet and so make a longer
    gap. The last one is cut to the samples still wanted, but never below the shortest burst.
    """
    gone = np.zeros_like(present)
    if share == 0:
        return gone
    groups = _gap_groups(recording)
    eligible = np.zeros_like(present)
    for columns in groups:
        eligible[:, columns] = present[:, columns]
    wanted = round(share * int(present.sum()))
    if wanted > eligible.sum():
        most = eligible.sum() / max(1, present.sum())
        raise UsageError(f"gaps must be at most {most:.3f} here because the root never goes missing, came {share}")
    shortest, longest = (max(1, round(s * recording.fps)) for s in GAP_SECONDS)
    left = np.array([eligible[:, columns].any(axis=1).sum() for columns in groups], dtype=float)
    done = 0
    while done < wanted:
        group = int(rng.choice(len(groups), p=left / left.sum()))
        columns = groups[group]
        start = int(rng.choice(np.flatnonzero(eligible[:, columns].any(axis=1))))
        length = int(rng.integers(shortest, longest + 1))
        length = min(length, max(shortest, -(-(wanted - done) // len(columns))))
        burst = eligible[start : start + length, columns]
        done += int(burst.sum())
        gone[start : start + length, columns] |= burst
        eligible[start : start + length, columns] = False
        left[group] = eligible[:, columns].any(axis=1).sum()
    return gone


def _gap_groups(recording: Motion | Markers) -> list[list[int]]:
    """Columns that go missing together: each marker alone, each joint's DOFs together, without the root."""
    if isinstance(recording, Markers):
        return [[m] for m in range(len(recording.names))]
    skeleton = recording.skeleton
    moving = [j for j in np.unique(skeleton.dof_joint) if skeleton.parents[j] >= 0]
    return [skeleton.dofs_of(int(j)).tolist() for j in moving]


def _drop_mask(recording: Motion | Markers, drop: Collection[str]) -> Bools:
    """(T, C) True in the columns that `drop` names."""
    mask = np.zeros((recording.frames, len(recording.channels)), dtype=bool)
    columns = _columns_by_name(recording)
    for name in drop:
        if name not in columns:
            known = sorted(columns)
            spelt = {one.casefold(): one for one in known}
            found = get_close_matches(name.casefold(), spelt, n=3, cutoff=0.5)
            close = [spelt[one] for one in found] or known[:3]
            raise UsageError(
                f"drop wants a joint, channel or marker of the recording, came {name!r}; "
                f"names like it: {', '.join(close)}"
            )
        mask[:, columns[name]] = True
    return mask


def _columns_by_name(recording: Motion | Markers) -> dict[str, list[int]]:
    """Every name that means something, prefix or not, and the columns it means."""
    columns: dict[str, list[int]] = {}
    for c, channel in enumerate(recording.channels):
        names = {channel, channel.rpartition(":")[2]}
        if isinstance(recording, Motion):
            joint = recording.skeleton.names[recording.skeleton.dof_joint[c]]
            names |= {joint, joint.rpartition(":")[2]}
        for name in names:
            columns.setdefault(name, []).append(c)
    return columns


def _check_amounts(noise: float, outliers: float, gaps: float, seed: int) -> None:
    if not (np.isfinite(noise) and noise >= 0):
        raise UsageError(f"noise must be a standard deviation of 0 or above, came {noise}")
    for name, share in (("outliers", outliers), ("gaps", gaps)):
        if not 0 <= share <= 1:
            raise UsageError(f"{name} must be a share between 0 and 1, came {share}")
    if seed < 0:
        raise UsageError(f"seed must be 0 or above, came {seed}")
