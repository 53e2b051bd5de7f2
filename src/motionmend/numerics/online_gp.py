"""Local Gaussian processes that go on learning (algorithm 2), in memory that never grows."""

import numpy as np
from scipy.linalg import cho_solve

from ..arrays import Bools, Floats
from .local_gp import Hyper, Mixture, budget, covariance, extended, factor


def learned(
    mixed: Mixture, samples: Floats, outputs: Floats, which: Bools, fresh: Hyper, similar: float = 0.5
) -> Mixture:
    """Take one sample of each joint into its most similar model, or open a new one.

    A full model first gives up the sample whose loss changes least (`budget`). When no unused model is left the most
    similar one takes the sample all the same.

    Parameters
    ----------
    mixed : the models so far; they stay as they are.
    samples : (J, D).
    outputs : (J, P).
    which : (J,) the joints that learn.
    fresh : parameters of new models.
    similar : w_similar; below this similarity (eq. 10) to all models a new one is opened.

    Source
    ------
    Section 4.2.3, eq. 14-17.
    """
    arrays = {name: np.array(getattr(mixed, name)) for name in Mixture.__dataclass_fields__}
    for j in np.flatnonzero(which):
        q = _place_for(mixed, int(j), samples[j], similar)
        if not mixed.counts[j, q]:
            arrays["hyper"][j, q] = fresh
        _extend(arrays, int(j), q, samples[j], outputs[j])
    return Mixture(**arrays)


def _place_for(mixed: Mixture, joint: int, sample: Floats, similar: float) -> int:
    used = mixed.counts[joint] > 0
    free = np.flatnonzero(~used)
    if not used.any():
        return int(free[0])
    apart = ((sample - mixed.centres[joint]) ** 2).sum(axis=1)
    likeness = np.where(used, -0.5 * mixed.hyper[joint, :, 2] * apart, -np.inf)  # logarithm of eq. 10
    best = int(np.argmax(likeness))
    return int(free[0]) if np.exp(likeness[best]) < similar and len(free) else best


def _extend(arrays: dict[str, Floats], j: int, q: int, sample: Floats, output: Floats) -> None:
    count = int(arrays["counts"][j, q])
    inputs, outputs, lower = arrays["inputs"][j, q], arrays["outputs"][j, q], arrays["factors"][j, q]
    hyper = Hyper(*(float(v) for v in arrays["hyper"][j, q]))
    if count == len(inputs):
        kept = budget(inputs, outputs, hyper, count - 1)
        count -= 1
        inputs[:count], outputs[:count] = inputs[kept], outputs[kept]
        lower[:] = 0.0
        lower[:count, :count] = factor(inputs[:count], hyper)
    cross = covariance(inputs[:count], sample[None], hyper)[:, 0]
    lower[: count + 1, : count + 1] = extended(lower[:count, :count], cross, hyper.signal + hyper.bias + hyper.noise)
    inputs[count], outputs[count] = sample, output
    count += 1
    arrays["weights"][j, q] = 0.0
    arrays["weights"][j, q, :count] = cho_solve((lower[:count, :count], True), outputs[:count])
    arrays["centres"][j, q] = inputs[:count].mean(axis=0)
    arrays["counts"][j, q] = count
