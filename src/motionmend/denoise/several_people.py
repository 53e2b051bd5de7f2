"""Several people in one recording of markers, each repaired on their own by a library that knows one: `Ann:LFHD`,
`Bob:LFHD`."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..arrays import Ints, frozen
from ..bodies.motion import Markers, Recording, Repaired
from ..errors import few
from .channels.bare_names import SEPARATORS, by_bare_names, without_subject
from .channels.recording import LEAST_SHARED
from .outcome import left_open

NOBODY = "the unnamed"  # whose markers have no subject before their names


def by_people(
    repair: Callable[[Recording], Repaired[Recording]], recording: Recording, taught: Sequence[str]
) -> Repaired[Recording]:
    """Repair a recording by a library of one person, everybody in it on their own.

    Parameters
    ----------
    repair : by that library.
    recording : markers of several people begin with a subject each, before a colon or any of `SEPARATORS`.
    taught : the library's names.
    """
    if not isinstance(recording, Markers) or len(people := people_in(recording.names, taught)) < 2:
        return by_bare_names(repair, recording, taught)
    outcomes: list[Repaired[Markers]] = []
    for called in people.values():
        markers = frozen(list(called), np.int64)
        outcomes.append(repair(_alone(recording, markers, tuple(called.values()))))
    return _together(recording, [(who, frozen(list(of), np.int64)) for who, of in people.items()], outcomes)


def people_in(names: Sequence[str], taught: Sequence[str]) -> Mapping[str, Mapping[int, str]]:
    """Whose markers are in a recording: for each person's subject the markers, and how a library calls them.

    Somebody is there who wears as many of the library's markers as it needs. Any other marker is with the person of its
    subject, or with the first one.

    Parameters
    ----------
    names : of the recording's markers. taught : the library's.
    """
    known = {without_subject(name, taught).upper(): name for name in taught}
    split = [_subject(name.strip(), known) for name in names]
    found: dict[str, dict[int, str]] = {}
    for m, (who, called) in enumerate(split):
        if called is not None and called not in found.setdefault(who, {}).values():
            found[who][m] = called
    people = {who: of for who, of in found.items() if len(of) >= LEAST_SHARED * len(taught)}
    if not people:
        return people
    theirs = {m for of in people.values() for m in of}
    for m, name in enumerate(names):
        if m not in theirs:
            named = [who for who in people if who and name.strip().startswith(who)]
            people[max(named, key=len) if named else next(iter(people))][m] = name
    return {who: dict(sorted(of.items())) for who, of in people.items()}


def _subject(name: str, known: Mapping[str, str]) -> tuple[str, str | None]:
    """A marker's subject, the separator included, and what a library calls the rest; None where it does not know it."""
    begins = [0, *(k + 1 for k, letter in enumerate(name) if letter in f":{SEPARATORS}")]
    for begin in begins:
        called = known.get(name[begin:].strip().upper())
        if called is not None:
            return name[:begin], called
    return "", None


def _alone(recording: Markers, markers: Ints, names: tuple[str, ...]) -> Markers:
    residuals = None if recording.residuals is None else recording.residuals[:, markers]
    return replace(recording, names=names, positions=recording.positions[:, markers], residuals=residuals)


def _together(
    recording: Markers, people: Sequence[tuple[str, Ints]], outcomes: Sequence[Repaired[Markers]]
) -> Repaired[Markers]:
    """One outcome for all of the recording's markers; sentences begin with whom they are about."""
    shape = recording.positions.shape[:2]
    positions = recording.positions.copy()
    origin, std, weights = np.zeros(shape, np.uint8), np.zeros(shape, np.float32), np.zeros(shape, np.float32)
    noise = np.full(shape[1], np.nan)
    called = [who.rstrip(f":{SEPARATORS}") or NOBODY for who, _ in people]
    said = [f"{len(people)} people in one recording, each repaired on their own: {few(called)}"]
    for name, (_, markers), one in zip(called, people, outcomes, strict=True):
        positions[:, markers] = one.recording.positions
        origin[:, markers], std[:, markers], weights[:, markers] = one.origin, one.std, one.weights
        noise[markers] = np.nan if one.noise is None else one.noise
        said += [f"{name}: {warning}" for warning in one.warnings if warning not in left_open(one.origin)]
    longest = max(len(one.cost) for one in outcomes)  # who has settled costs what they did last
    costs = [np.pad(one.cost, (0, longest - len(one.cost)), mode="edge") for one in outcomes if len(one.cost)]
    return Repaired(
        recording=recording.with_positions(positions),
        origin=origin,
        std=std,
        weights=weights,
        method=outcomes[0].method,
        iterations=max(one.iterations for one in outcomes),
        cost=np.sum(costs, axis=0) if costs else np.empty(0),
        converged=all(one.converged for one in outcomes),
        warnings=(*said, *left_open(origin)),
        noise=None if all(one.noise is None for one in outcomes) else noise,
    )
