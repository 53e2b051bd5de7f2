"""How much evidence it takes to take a joint for failing: more than joints that go well ever show.

What bones, jerk and place say of a joint depends on the sensor: where all is restless, or movements are quick and
frames few, even a limb that is thrown about shows little of what would be evidence elsewhere. There joints that go well
show less still, and how much they show at most tells what evidence is worth.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..arrays import Bools, Floats
from .learning import Lesson, movements
from .level import TOLD_ALREADY
from .reliability import Detector
from .sight import Watcher, fresh
from .watching import look

SELDOM = 0.001  # of the joints that go well show more evidence than
AT_MOST = -0.4  # as a log-likelihood ratio of failing, where the constant serves
WORTH = 1.5  # of what they show less, by so much less is a sign of failing: where little is shown, so it is by failures
FEW = 5.0  # movements that tell half of how joints go well in others
LOOKED = 3000  # frames that are asked, about
PASSAGE = 90  # of one recording, at least


def alarmed(watcher: Watcher, taught: Sequence[Lesson], good: Sequence[Bools]) -> Detector:
    """The watcher's detector, alarmed by as little as joints that go well (T, J) in each recording do not show."""
    some = np.unique(np.linspace(0, len(taught) - 1, min(len(taught), LOOKED // PASSAGE)).astype(int))
    frames = max(LOOKED // len(some), PASSAGE)
    shown = np.concatenate([_evidence(watcher, taught[k], good[k], frames) for k in some])
    weights = np.array(watcher.detector.weights)
    if len(shown):
        sure = movements(taught) / (movements(taught) + FEW)
        weights[-1] += sure * WORTH * max(AT_MOST - float(np.quantile(shown, 1.0 - SELDOM)), 0.0)
    return replace(watcher.detector, weights=weights)


def _evidence(watcher: Watcher, one: Lesson, well: Bools, frames: int) -> Floats:
    """(N,) log-likelihood ratios of failing of joints that go well in the middle of a recording."""
    first = max((len(one.raw) - frames) // 2, 0)
    sight = replace(fresh(watcher), upright=np.eye(3), lean=TOLD_ALREADY)
    found = [np.zeros(0)]
    for t in range(first, min(first + frames, len(one.raw))):
        sight = look(watcher, sight, one.raw[t], None, float(one.times[t]))
        now, before = sight.followed.failing, sight.followed.forecast
        asked = well[t] & np.asarray(np.isfinite(one.raw[t]).all(axis=1)) & (now > 0.0) & (now < 1.0)
        found.append(np.log(now[asked] / (1.0 - now[asked])) - np.log(before[asked] / (1.0 - before[asked])))
    return np.concatenate(found)
