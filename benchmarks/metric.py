"""A number with all that is needed to judge it."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from math import isfinite
from typing import Any, Literal

Direction = Literal["higher", "lower", "info"]
TOLERANCE = 0.35  # a gated ratio may be this much worse than its baseline; shared machines move it by half of that


@dataclass(frozen=True)
class Metric:
    """One measurement.

    Attributes
    ----------
    key : `suite.what.size.figure`, unique.
    value : the median over the rounds, in `unit`.
    unit : "x" for a ratio.
    direction : which way is better; "info" is never gated, as all absolute times are.
    tolerance : relative worsening against the baseline that is let pass.
    low, high : the range over the rounds; None for a single measurement.
    target : what was aimed at, in `unit` and `direction`; None where nothing was.
    """

    key: str
    value: float
    unit: str
    direction: Direction
    tolerance: float = TOLERANCE
    low: float | None = None
    high: float | None = None
    target: float | None = None

    def __post_init__(self) -> None:
        if self.direction not in ("higher", "lower", "info"):
            raise ValueError(f"{self.key}: a direction is higher, lower or info, came {self.direction!r}")
        if not 0 <= self.tolerance < 1:
            raise ValueError(f"{self.key}: a tolerance is a share in [0, 1), came {self.tolerance}")

    @property
    def suite(self) -> str:
        """The part of the key before the first dot."""
        return self.key.partition(".")[0]

    @property
    def gated(self) -> bool:
        """Whether a worse value fails the gate."""
        return self.direction != "info"

    def meets(self, target: float) -> bool:
        """Whether the value is on the good side of `target`; of information, less is better in s and MB, else more."""
        less = self.direction == "lower" or (self.direction == "info" and self.unit in ("s", "MB"))
        return self.value <= target if less else self.value >= target

    def to_json(self) -> dict[str, Any]:
        """Everything but the key; six significant digits."""
        found = {name: value for name, value in asdict(self).items() if name != "key" and value is not None}
        return {name: float(f"{v:.6g}") if isinstance(v, float) else v for name, v in found.items()}


def regressions(measured: Sequence[Metric], baseline: Sequence[Metric]) -> list[str]:
    """One line for each gated metric that is worse than its baseline, not a number, missing or unknown.

    Parameters
    ----------
    measured : of this run.
    baseline : of the same suites; a key on one side only is an error on either side.

    Returns
    -------
    Empty when the gate is passed.
    """
    now = {m.key: m for m in measured if m.gated}
    before = {m.key: m for m in baseline if m.gated}
    found = [f"{key}: in the baseline, but not measured" for key in before if key not in now]
    found += [f"{key}: measured, but not in the baseline; record it with --update" for key in now if key not in before]
    for key in (key for key in before if key in now):
        one, reference = now[key], before[key]
        if (one.unit, one.direction) != (reference.unit, reference.direction):
            found.append(
                f"{key}: {one.unit}, {one.direction} is better; the baseline has {reference.unit}, "
                f"{reference.direction}: record it anew with --update"
            )
        elif not isfinite(one.value):
            found.append(f"{key}: came out as {one.value}")
        elif _worse(one.value, reference):
            found.append(
                f"{key}: {one.value:.3g} {one.unit}, baseline {reference.value:.3g}, "
                f"{reference.direction} is better and {reference.tolerance:.0%} let pass"
            )
    return found


def _worse(value: float, reference: Metric) -> bool:
    if reference.direction == "higher":
        return value < reference.value * (1.0 - reference.tolerance)
    return value > reference.value * (1.0 + reference.tolerance)
