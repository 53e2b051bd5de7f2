"""Plain NumPy twin of `kernels.one_side`."""

import numpy as np


def facing(rows, trust, trunk, across, standard_trunk, before):
    """Where the trunk points by the joints of one side, as complex numbers turn."""
    now = before / max(np.linalg.norm(before), 1e-300)
    if not trust[across].any():
        return now
    some = np.flatnonzero(trunk & (trust > 0))
    weights = trust[some] / trust[some].sum()
    here, there = rows[some][:, ::2], standard_trunk[some][:, ::2]
    here, there = ([1.0, 1j] @ (one - weights @ one).T for one in (here, there))
    turned = (weights * np.conj(there) * here).sum()
    return now + 0.03 * np.array([turned.real, turned.imag]) / abs(turned) if turned else now
