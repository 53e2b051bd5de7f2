"""The claims as the .toml files hold them, and whether what was measured meets them."""

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from string import Formatter
from typing import Any

from motionmend.errors import UsageError

DIRECTIONS = ("above", "below", "equal")
DENOISING, TRACKING, CORRECTING, BEYOND = "claims", "tracking", "correcting", "beyond"
PARTS = (DENOISING, TRACKING, CORRECTING, BEYOND)  # the files: what was published, and what the package sets itself


@dataclass(frozen=True)
class Criterion:
    """One number that decides whether a claim is met.

    Attributes
    ----------
    value : name of a number that the claim's scripts measure.
    unit : of the number; "1" for counts and ratios.
    direction : `above` or `below` the limit, or `equal` to it.
    limit, tolerance : in that unit.
    about : what the number is, in a few words.
    """

    value: str
    unit: str
    direction: str
    limit: float
    tolerance: float
    about: str

    def __post_init__(self) -> None:
        if self.direction not in DIRECTIONS:
            raise UsageError(f"a criterion's direction is one of {', '.join(DIRECTIONS)}, came {self.direction!r}")

    def holds(self, measured: float) -> bool:
        """Whether `measured` is on the right side; NaN never is."""
        if self.direction == "above":
            return measured >= self.limit - self.tolerance
        if self.direction == "below":
            return measured <= self.limit + self.tolerance
        return abs(measured - self.limit) <= self.tolerance


@dataclass(frozen=True)
class Claim:
    """One claim.

    Attributes
    ----------
    part : one of `PARTS`.
    id, title : `D1` and what it is about.
    place : section, equation or figure of the paper; beyond it, what is tried.
    theirs : the paper's number or statement; beyond it, what is wanted.
    ours : a format string over the measured numbers.
    script : the modules of this package that measure it.
    expected : "met", or "not met: " and why.
    criteria : all must hold.
    also : ids of what the paper claims of parts, which act and are judged in this claim alone.
    """

    part: str
    id: str
    title: str
    place: str
    theirs: str
    ours: str
    script: tuple[str, ...]
    expected: str
    criteria: tuple[Criterion, ...]
    also: tuple[str, ...] = ()

    @property
    def expected_met(self) -> bool:
        """Whether the claim is expected to be met."""
        return self.expected == "met"

    def is_measured(self, values: Mapping[str, float]) -> bool:
        """Whether all numbers that the claim speaks of are there: not those of a script that has since learned more."""
        spoken = {field for _, field, _, _ in Formatter().parse(self.ours) if field}
        return (spoken | {c.value for c in self.criteria}) <= values.keys()

    def judge(self, values: Mapping[str, float]) -> dict[str, Any]:
        """The claim with what was measured, ready for JSON."""
        checks = [
            {
                "value": c.value,
                "about": c.about,
                "measured": float(values[c.value]),
                "unit": c.unit,
                "direction": c.direction,
                "limit": c.limit,
                "tolerance": c.tolerance,
                "holds": bool(c.holds(values[c.value])),
            }
            for c in self.criteria
        ]
        met = all(check["holds"] for check in checks)
        return {
            "part": self.part,
            "id": self.id,
            "title": self.title,
            "place": self.place,
            "theirs": self.theirs,
            "ours": self.ours.format(**values),
            "met": met,
            "expected": self.expected,
            "as_expected": met == self.expected_met,
            "criteria": checks,
            "script": list(self.script),
            "also": list(self.also),
        }


@dataclass(frozen=True)
class OutOfReach:
    """A claim that nothing here can measure, and why."""

    part: str
    id: str
    title: str
    place: str
    theirs: str
    why: str

    def judge(self) -> dict[str, Any]:
        """The same keys as of a claim that was measured: it is not met, as expected, and no number says anything."""
        return {
            **{name: getattr(self, name) for name in ("part", "id", "title", "place", "theirs")},
            "ours": self.why,
            "met": False,
            "expected": f"not met: {self.why}",
            "as_expected": True,
            "criteria": [],
            "script": [],
            "also": [],
        }


def load() -> tuple[Claim, ...]:
    """All claims: the papers', then those beyond them, in the files' order."""
    return tuple(claim for part in PARTS for claim in _claims_of(part))


def out_of_reach() -> tuple[OutOfReach, ...]:
    """The claims of the papers that cannot be measured here."""
    return tuple(OutOfReach(part, **entry) for part in PARTS for entry in _entries(part).get("out_of_reach", ()))


def _claims_of(part: str) -> tuple[Claim, ...]:
    return tuple(
        Claim(
            **{key: value for key, value in entry.items() if key not in ("script", "criterion", "also")},
            part=part,
            script=tuple(entry["script"]),
            criteria=tuple(Criterion(**criterion) for criterion in entry["criterion"]),
            also=tuple(entry.get("also", ())),
        )
        for entry in _entries(part)["claim"]
    )


def _entries(part: str) -> dict[str, Any]:
    with open(Path(__file__).with_name(f"{part}.toml"), "rb") as file:
        return tomllib.load(file)


def choose(claims: Sequence[Claim], ids: Sequence[str]) -> tuple[Claim, ...]:
    """The claims with these ids, or in which these are judged; all when none is given, always in the file's order.

    What is out of reach is known, too, but none of them.

    Raises
    ------
    UsageError : an id that no claim has.
    """
    wanted = {one.upper() for one in ids}
    known = {one: None for claim in claims for one in (claim.id, *claim.also)} | {
        one.id: None for one in out_of_reach()
    }
    unknown = wanted - known.keys()
    if unknown:
        raise UsageError(f"no claim is called {', '.join(sorted(unknown))}: choose from {', '.join(known)}")
    return tuple(claim for claim in claims if not wanted or wanted & {claim.id, *claim.also})
