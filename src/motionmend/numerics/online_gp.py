"""Local Gaussian processes that go on learning (algorithm 2), in memory that never grows."""

import numpy as np

from ..arrays import Bools, Floats
from ..kernels import learning as kernel
from .local_gp import Hyper, Mixture


def learned(
    mixed: Mixture, samples: Floats, outputs: Floats, which: Bools, fresh: Hyper, similar: float = 0.5
) -> Mixture:
    """Take one sample of each joint into its most similar model, or open a new one.

    A full model first gives up the sample whose loss changes least (`local_gp.budget`). When no unused model is left
    the most similar one takes the sample all the same.

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
    kernel.learn(
        arrays["centres"],
        arrays["inputs"],
        arrays["outputs"],
        arrays["factors"],
        arrays["weights"],
        arrays["counts"],
        arrays["hyper"],
        np.ascontiguousarray(samples, dtype=np.float64),
        np.ascontiguousarray(outputs, dtype=np.float64),
        which,
        np.array(fresh),
        similar,
    )
    return Mixture(**arrays)
