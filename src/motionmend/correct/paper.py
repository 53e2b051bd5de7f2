"""The paper's own method: local Gaussian processes per joint, and the energy of eq. 22 frame by frame.

Its three terms have the paper's weights, reliability is Shum et al.'s, and the minimum is found frame by frame by the
paper's sampling descent or, being quadratic, exactly and for all frames of a recording together.
"""

import numpy as np

from ..arrays import Bools, Floats, Ints
from ..bodies.postures import Postures
from ..numerics.local_gp import Hyper, Mixture, fit_mixture, predict, with_places
from ..numerics.online_gp import learned
from .anatomy import Anatomy
from .classic import Samples
from .energy import Terms, Weights, adapted, sampled, solved, solved_together
from .normalise import Placement, bone_lengths
from .reliability import behaviour, kinematics, paper_reliability, tracking
from .watching import PATIENCE

MODELS, SIZE, NEAREST = 30, 50, 9  # Q, S and L of section 4.2
WEIGHTS = Weights(0.6, 0.2, 0.2)
TRUSTED, SIMILAR = 0.9, 0.5  # reliability of a sample worth learning; w_similar
NEW_MODELS, NEW_SAMPLES, EVERY = 4, 10, 6  # room for what is learned online; frames between samples
NEW = Hyper(0.02**2, 0.03**2, 1.0 / 0.3**2, 0.02**2)  # parameters of models opened online, standard metres


def neighbour_inputs(postures: Floats, body: Anatomy) -> Floats:
    """(T, J, D) each joint's place and those of the joints that share a bone with it, unused inputs zero."""
    padded = np.concatenate([postures, np.zeros((len(postures), 1, 3))], axis=1)
    return padded[:, body.near].reshape(*postures.shape[:2], -1)


def learned_mixture(samples: Samples, body: Anatomy, seed: int = 0, room: int = 0) -> Mixture:
    """The local models of every joint (algorithm 1, offline).

    Parameters
    ----------
    samples : postures (N, J, 3) and offsets, standard metres.
    body : J joints.
    seed : of the k-means start.
    room : places in each model for samples learned later.
    """
    inputs = neighbour_inputs(samples.postures, body)
    known = np.asarray(np.isfinite(samples.offsets).all(axis=2))
    return fit_mixture(
        [inputs[known[:, j], j] for j in range(inputs.shape[1])],
        [samples.offsets[known[:, j], j] for j in range(inputs.shape[1])],
        MODELS,
        SIZE,
        seed,
        room,
    )


def corrected_as_published(
    mixture: Mixture,
    body: Anatomy,
    placement: Placement,
    rows: Floats,
    standard: Floats,
    recording: Postures,
    to_model: Ints,
    method: str,
    online: bool = False,
    seed: int = 0,
    weights: Weights = WEIGHTS,
) -> tuple[Floats, Floats, Floats]:
    """Section 4 on a recording.

    Parameters
    ----------
    mixture : of `learned_mixture`.
    placement : of each frame.
    rows : (T, J, 3) m upright, NaN = missing.
    standard : (T, J, 3) the postures in standard form, complete.
    recording : for its states and times.
    to_model : (J,) the recording's joint of each of the model's, -1 = none.
    method : "paper" descends eq. 22 in each frame, "exact" solves it for all frames together, "adaptive" does so with
        weights that follow each joint's doubt (`energy.adapted`).
    online : learn from frames with high reliability and low variance (algorithm 2).
    seed : of the descent.
    weights : of the terms.

    Returns
    -------
    postures (T, J, 3) in standard form of each frame's placement, standard deviations (T, J), reliability (T, J).

    Notes
    -----
    Learning on the way needs offsets on the way: those are of each frame, its past taken for true.
    """
    rng = np.random.default_rng(seed)
    inputs = neighbour_inputs(standard, body)
    mean, variance = predict(mixture, inputs, NEAREST)
    certain = np.median(variance, axis=0)
    stated = np.isfinite(variance)
    usual = float(np.median(variance[stated])) if stated.any() else 1.0
    if online:
        mixture = with_places(mixture, NEW_MODELS, NEW_SAMPLES)
    reliable = _reliable(rows, recording, to_model, body)
    follows = _follows(rows, recording.times)
    tied = follows & np.append(False, follows[:-1])
    result = np.empty(mean.shape)
    placed: list[Floats] = []  # results upright, in metres: placements differ from frame to frame
    # In turn where each frame begins from those before it, or learns from them.
    for t in range(len(standard) if online or method == "paper" else 0):
        if online:
            mean[t : t + 1], variance[t : t + 1] = predict(mixture, inputs[t : t + 1], NEAREST)
        here = Placement(placement.turn[t : t + 1], placement.origin[t : t + 1], placement.scale[t : t + 1])
        steady = here.inward((2.0 * placed[-1] - placed[-2])[None])[0] if tied[t] else None
        terms = Terms(standard[t], mean[t], steady, reliable[t], _doubt(variance[t], usual))
        if method == "paper":
            start = here.inward(placed[-1][None])[0] - standard[t] if follows[t] else mean[t]
            offset = sampled(terms, weights, start, rng)
        else:
            offset = solved(terms, _weighed(method, terms, weights))
        result[t] = standard[t] + offset
        placed.append(here.outward(result[t][None])[0])
        worth = (reliable[t] > TRUSTED) & (variance[t] <= certain)
        if online and t % EVERY == 0 and worth.any():
            mixture = learned(mixture, inputs[t], offset, worth, NEW, SIMILAR)
    if method != "paper":
        whole = Terms(standard, mean, None, reliable, _doubt(variance, usual))
        result = standard + solved_together(whole, _weighed(method, whole, weights), tied, placement)
    return result, np.sqrt(np.where(np.isfinite(variance), variance, 0.0)), reliable


def _doubt(variance: Floats, usual: float) -> Floats:
    """Variances by the usual one; joints whose truth nobody knew are weighed plainly."""
    return np.where(np.isfinite(variance), np.maximum(variance / usual, 1e-6), 1.0)


def _weighed(method: str, terms: Terms, weights: Weights) -> Weights | tuple[Floats, Floats, Floats]:
    return adapted(terms.doubt, weights) if method == "adaptive" else weights


def _reliable(rows: Floats, recording: Postures, to_model: Ints, body: Anatomy) -> Floats:
    """(T, J) the paper's reliability of joints at (T, J, 3), by what the sensor says of them."""
    lengths = bone_lengths(rows, body)
    with np.errstate(all="ignore"):
        usual = np.array([np.median(b[np.isfinite(b)]) if np.isfinite(b).any() else np.nan for b in lengths.T])
    reliable = np.empty(rows.shape[:2])
    for t, row in enumerate(rows):
        present = np.asarray(np.isfinite(row).all(axis=1))
        told = None
        if recording.state is not None:
            told = np.where(to_model >= 0, recording.state[t][to_model], 0).astype(np.uint8)
        moving = behaviour(row, rows[t - 1], rows[t - 2]) if t > 1 else np.ones(len(present))
        reliable[t] = paper_reliability((moving, kinematics(lengths[t], usual, body), tracking(told, present)))
    return reliable


def _follows(rows: Floats, times: Floats) -> Bools:
    """(T,) frames before which the person was seen in another, without a break."""
    seen = np.asarray(np.asarray(np.isfinite(rows).all(axis=2)).any(axis=1))
    follows = np.zeros(len(rows), dtype=np.bool_)
    follows[1:] = seen[1:] & seen[:-1] & (np.diff(times) <= PATIENCE)
    return follows
