"""Several people in one recording of markers, each repaired on their own by a library that knows one: `Ann:LFHD`,
`Bob:LFHD`."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..bodies.motion import Markers, Recording, Repaired
from ..errors import few
from .channels.bare_names import SEPARATORS, by_bare_names, without_subject
from .channels.layout import own_layout
from .channels.recording import LEAST_SHARED, Channels, to_channels
from .faults.takes import first_frames
from .labels.relabelling import relabelled_origin, right_at_first_sight, swaps_told
from .labels.swaps import Swap
from .outcome import left_open

NOBODY = "the unnamed"  # whose markers have no subject before their names


def by_people(
    repair: Callable[[Recording], Repaired[Recording]],
    recording: Recording,
    taught: Sequence[str],
    *,
    labels: bool = False,
) -> Repaired[Recording]:
    """Repair a recording by a library of one person, everybody in it on their own.

    Parameters
    ----------
    repair : by that library.
    recording : markers of several people begin with a subject each, before a colon or any of `SEPARATORS`.
    taught : the library's names.
    labels : whether those that two people's markers bear of each other are given back first; alone nobody can tell.

    Returns
    -------
    One outcome for all markers of the recording, in its order; sentences begin with whom they are about.

    Raises
    ------
    MismatchError : nobody in the recording wears enough of the library's markers.
    """
    if not isinstance(recording, Markers) or len(people := people_in(recording.names, taught)) < 2:
        return by_bare_names(repair, recording, taught)
    channels = to_channels(recording, own_layout(recording))
    right, swaps = _labels_among(recording, channels, people) if labels else (recording, ())
    outcomes: dict[str, Repaired[Markers]] = {who: repair(_alone(right, of)) for who, of in people.items()}
    everybody: Repaired[Recording] = _together(right, people, outcomes)
    told: tuple[str, ...] = swaps_told(swaps, right, channels, taught=False)
    origin = relabelled_origin(everybody.origin, channels, swaps)
    return replace(everybody, origin=origin, warnings=(*everybody.warnings, *told))


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


def _labels_among(
    recording: Markers, channels: Channels, people: Mapping[str, Mapping[int, str]]
) -> tuple[Markers, tuple[Swap, ...]]:
    """The recording with labels given back, and the swaps: none unless people's markers bear one another's.

    What is swapped within a person is told when they are repaired, unless it is swapped with another's besides.
    """
    if len(first_frames(recording)):  # labels are compared within a take
        return recording, ()
    right, swaps = right_at_first_sight(recording, channels)
    whose = {m: who for who, of in people.items() for m in of}
    among = any(len({whose[int(channels.columns[m])] for m in swap.markers}) > 1 for swap in swaps)
    return (right, swaps) if among else (recording, ())


def _alone(recording: Markers, called: Mapping[int, str]) -> Markers:
    """The recording of these markers only, called so."""
    names, markers = tuple(called.values()), list(called)
    residuals = None if recording.residuals is None else recording.residuals[:, markers]
    return replace(recording, names=names, positions=recording.positions[:, markers], residuals=residuals)


def _together(
    recording: Markers, people: Mapping[str, Mapping[int, str]], outcomes: Mapping[str, Repaired[Markers]]
) -> Repaired[Markers]:
    """One outcome for all of the recording's markers; sentences begin with whom they are about."""
    shape = recording.positions.shape[:2]
    positions = recording.positions.copy()
    origin, std, weights = np.zeros(shape, np.uint8), np.zeros(shape, np.float32), np.zeros(shape, np.float32)
    noise = np.full(shape[1], np.nan)
    subjects = {who: who.rstrip(f":{SEPARATORS}") or NOBODY for who in people}
    said = [f"{len(people)} people in one recording, each repaired on their own: {few(list(subjects.values()))}"]
    for who, one in outcomes.items():
        markers = list(people[who])
        positions[:, markers] = one.recording.positions
        origin[:, markers], std[:, markers], weights[:, markers] = one.origin, one.std, one.weights
        noise[markers] = np.nan if one.noise is None else one.noise
        said += [f"{subjects[who]}: {warning}" for warning in one.warnings if warning not in left_open(one.origin)]
    each = list(outcomes.values())
    longest = max(len(one.cost) for one in each)  # who has settled costs what they did last
    costs = [np.pad(one.cost, (0, longest - len(one.cost)), mode="edge") for one in each if len(one.cost)]
    return Repaired(
        recording=recording.with_positions(positions),
        origin=origin,
        std=std,
        weights=weights,
        method=each[0].method,
        iterations=max(one.iterations for one in each),
        cost=np.sum(costs, axis=0) if costs else np.empty(0),
        converged=all(one.converged for one in each),
        warnings=(*said, *left_open(origin)),
        noise=None if all(one.noise is None for one in each) else noise,
    )
