"""Clips that are noisy or full of outliers themselves, repaired before a model learns from them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Bools, Floats
from ..bodies.motion import Markers, Motion, Origin, Recording, Repaired
from ..bodies.skeleton import ROTATION
from .channels.pieces import PIECE, blocks
from .model import repair_without_model
from .noise.level import first_noise
from .too_short import FEWEST_FRAMES

# The noise of one frame in the time of one, degrees and cm a second. Clean motion passes for some by what it turns
# within three frames: up to 19 degrees a second in dances at 30 Hz, 9 at 120; markers 3 cm.
LOUD_ANGLES, LOUD_MARKERS = 24.0, 9.0
FAR = 10.0  # degrees or cm from both neighbours: a lone sample so far off
APART = 1 / 3  # of that the neighbours are apart at most
OFTEN = 0.004  # of the samples; fast dances at 30 Hz have 0.0032
SLOW = 30.0  # Hz; what is recorded at fewer frames turns farther between them, and oftener there and back


@dataclass(frozen=True)
class Spoiled:
    """How a clip was spoiled.

    Attributes
    ----------
    noise : median over channels, degrees or cm; NaN = not told. outliers : share of the samples.
    """

    noise: float
    outliers: float


def unspoiled(clip: Motion | Markers) -> tuple[Motion | Markers, Spoiled | None]:
    """A clip as a model can learn from it: repaired by what it shows itself where it looks spoiled.

    Noise and outliers of clips become patterns of a model, which then takes those of recordings for motion.

    Parameters
    ----------
    clip : at any rate. What is missing in it stays missing: nothing is learned from what was filled.

    Returns
    -------
    The same clip and None where it is clean, as far as its frames tell.

    Source
    ------
    Section 2.4: what a noisy recording shows can be learned from.
    """
    if not looks_spoiled(clip):
        return clip, None
    if isinstance(clip, Markers):
        markers = repair_without_model(clip)
        positions = np.where(_seen(markers)[..., None], markers.recording.positions, np.nan)
        return clip.with_positions(positions), _how(markers, 100.0)
    motion = repair_without_model(clip)
    return clip.with_q(np.where(_seen(motion), motion.recording.q, np.nan)), _how(motion, np.degrees(1.0))


def looks_spoiled(clip: Motion | Markers) -> bool:
    """Whether somewhere most channels are noisier than motion ever looks, or lone samples leap oftener than in any."""
    return any(_spoiled_piece(clip.at_frames(frames)) for frames, _ in blocks(clip.frames, PIECE, 0))


def _spoiled_piece(clip: Motion | Markers) -> bool:
    turns = isinstance(clip, Motion)
    values = _angles(clip) if isinstance(clip, Motion) else 100.0 * clip.positions.reshape(clip.frames, -1)
    values = values[:, _moving(values)]
    if not values.shape[1] or clip.frames < FEWEST_FRAMES:
        return False
    noise, alone = float(np.median(first_noise(values))), float(_alone(values, turns=turns).mean())
    slower = max(1.0, SLOW / clip.fps)
    return noise * clip.fps > (LOUD_ANGLES if turns else LOUD_MARKERS) * slower or alone > OFTEN * slower**2


def told(found: Sequence[Spoiled], unit: str) -> str:
    """How badly clips were spoiled, in one sentence.

    Parameters
    ----------
    found : of each clip, one at least. unit : of their noise, in full.
    """
    known = [one.noise for one in found if np.isfinite(one.noise)]
    noise = f"noise of {max(known):.2g} {unit} and " if known else ""
    most, who, whom = (" at most", "they show themselves", "them") if len(found) > 1 else ("", "it shows itself", "it")
    outliers = 100.0 * max(one.outliers for one in found)
    return f"{noise}{outliers:.2g} % outliers{most}: repaired by what {who} before anything was learned from {whom}"


def _seen(outcome: Repaired[Recording]) -> Bools:
    """Which samples were recorded at all."""
    return np.asarray((outcome.origin == Origin.MEASURED) | (outcome.origin == Origin.REPAIRED))


def _how(outcome: Repaired[Recording], unit: float) -> Spoiled:
    """What a repair says of a clip, its noise times `unit`."""
    known = np.empty(0) if outcome.noise is None else outcome.noise[np.isfinite(outcome.noise)]
    noise = unit * float(np.median(known)) if known.size else float("nan")
    return Spoiled(noise, float((outcome.origin == Origin.REPAIRED).sum() / max(1, _seen(outcome).sum())))


def _angles(motion: Motion) -> Floats:
    """(T, R) degrees."""
    return np.asarray(np.degrees(motion.q[:, motion.skeleton.dof_kind == ROTATION]))


def _moving(values: Floats) -> Bools:
    """(C,) channels of more than one value."""
    low, high = np.fmin.reduce(values, axis=0, initial=np.inf), np.fmax.reduce(values, axis=0, initial=-np.inf)
    return np.asarray(high > low)


def _alone(values: Floats, *, turns: bool) -> Bools:
    """(T - 2, C) samples far from both neighbours, which are much nearer to each other; full turns are none."""
    steps = np.diff(values, axis=0)
    if turns:
        steps -= 360.0 * np.round(steps / 360.0)
    there, back = steps[:-1], -steps[1:]
    least = np.minimum(np.abs(there), np.abs(back))
    return np.asarray((there * back > 0.0) & (least > FAR) & (np.abs(there - back) < APART * least))
