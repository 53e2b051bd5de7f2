"""Learning from many files: workers read them and send back sums, which are added up in the order of the files."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Generic, Protocol, Self, TypeVar

from ..batch import Failure, Outcome, Task, Workers, failure, in_turn, workers
from ..errors import MismatchError
from .inputs import Input
from .options import Working

if TYPE_CHECKING:
    from ..bodies.motion import Markers, Motion
    from ..denoise.channels.layout import Layout, Sketch
    from ..denoise.library.statistics import Statistics
    from ..denoise.spoiled_clips import Spoiled

CHUNKS = 32  # into which files are cut, so that any number of workers has something to do
MOST_CLIPS = 64  # in a chunk; the sums sent back are as large for many clips as for one


class Addable(Protocol):
    """Something of clips that adds up to that of all clips."""

    def __add__(self, other: Self, /) -> Self: ...


Sum = TypeVar("Sum", bound=Addable)


@dataclass(frozen=True, eq=False)
class Part(Generic[Sum]):
    """What comes of some clips: `value` of those that can be used, and why the others cannot."""

    value: Sum | None
    failures: tuple[tuple[Path, Failure], ...] = ()

    def __add__(self, other: "Part[Sum]") -> "Part[Sum]":
        if self.value is None or other.value is None:
            value = other.value if self.value is None else self.value
        else:
            value = self.value + other.value
        return Part(value, self.failures + other.failures)


@dataclass(frozen=True)
class Reading:
    """How files are read: the rate of those that carry none, and the .asf of .amc files."""

    fps: float | None
    skeleton: Path | None

    def __call__(self, item: Input, /) -> "Motion | Markers":
        from ..io import read

        return read(item.path, fps=self.fps, skeleton=self.skeleton)


@dataclass(frozen=True, eq=False)
class Alike:
    """Clips of the same channels, and the sketch of their layout."""

    sketch: "Sketch"
    clips: tuple[Input, ...]


@dataclass(frozen=True, eq=False)
class Survey:
    """Clips by kind and channels, in the order met, and what was guessed or doubted of which."""

    groups: dict[tuple[str, ...], Alike]
    guesses: dict[str, tuple[Path, ...]]

    def __add__(self, other: "Survey") -> "Survey":
        groups, guesses = dict(self.groups), dict(self.guesses)
        for key, alike in other.groups.items():
            here = groups.get(key)
            groups[key] = alike if here is None else Alike(here.sketch + alike.sketch, here.clips + alike.clips)
        for guess, paths in other.guesses.items():
            guesses[guess] = guesses.get(guess, ()) + paths
        return Survey(groups, guesses)

    def alike(self) -> tuple[Alike, tuple[Path, ...], list[tuple[Path, Failure]]]:
        """The clips that more than half of all go together with, which of them turn in another order than the largest
        group, and why each of the others does not.

        Raises
        ------
        MismatchError : no more than half go together.
        """
        by_size = sorted(self.groups.values(), key=lambda alike: -len(alike.clips))
        most, turned, apart = by_size[0], list[Path](), list[tuple[Path, Failure]]()
        for alike in by_size[1:]:
            try:
                most = Alike(most.sketch + alike.sketch, most.clips + alike.clips)
            except MismatchError as error:
                apart += [(clip.path, Failure("MismatchError", str(error), "")) for clip in alike.clips]
            else:
                turned += [clip.path for clip in alike.clips]
        if apart and len(most.clips) <= len(apart):
            path, why = apart[0]
            raise MismatchError(f"{path} does not go with {most.clips[0].path}: {why.message}")
        return most, tuple(turned), apart


@dataclass(frozen=True, eq=False)
class Lesson:
    """What clips teach, those in which no whole window lies, and those that were spoiled themselves."""

    statistics: "Statistics"
    short: tuple[Path, ...]
    spoiled: "tuple[tuple[Path, Spoiled], ...]"

    def __add__(self, other: "Lesson") -> "Lesson":
        return Lesson(self.statistics + other.statistics, self.short + other.short, self.spoiled + other.spoiled)


def survey(chunk: Sequence[Input], /, *, reading: Reading) -> Part[Survey]:
    """Survey clips; a task for `batch.in_turn`."""
    from ..denoise.channels.layout import sketch

    failures: list[tuple[Path, Failure]] = []
    found = Survey({}, {})
    for item, clip in _clips(chunk, reading, failures):
        one = sketch(clip)
        told: dict[str, tuple[Path, ...]] = dict.fromkeys((*clip.warnings, *clip.guesses), (item.path,))
        found = found + Survey({one.common: Alike(one, (item,))}, told)
    return Part(found if found.groups else None, tuple(failures))


def learn(
    chunk: Sequence[Input], /, *, reading: Reading, layout: "Layout", window: int, model_fps: float
) -> Part[Lesson]:
    """Statistics of clips, spoiled ones repaired first; a task for `batch.in_turn`."""
    from ..denoise.library.statistics import statistics
    from ..denoise.spoiled_clips import unspoiled

    failures: list[tuple[Path, Failure]] = []
    taught: list[Path] = []
    repaired: list[tuple[Path, Spoiled]] = []

    def clips() -> Iterator["Motion | Markers"]:
        for item, clip in _clips(chunk, reading, failures):
            cleaned, spoiled = unspoiled(clip)
            taught.append(item.path)
            if spoiled is not None:
                repaired.append((item.path, spoiled))
            yield cleaned

    found = statistics(clips(), layout, window, model_fps)
    lesson = Lesson(found, tuple(taught[number] for number in found.barren), tuple(repaired))
    return Part(lesson if found.clips else None, tuple(failures))


def _clips(
    chunk: Sequence[Input], reading: Reading, failures: list[tuple[Path, Failure]]
) -> Iterator[tuple[Input, "Motion | Markers"]]:
    """The clips of a chunk that can be read, one at a time."""
    for item in chunk:
        try:
            clip = reading(item)
        except Exception as error:
            failures.append((item.path, failure(error)))
        else:
            yield item, clip


def total(
    task: Task[Sequence[Input], Part[Sum]],
    inputs: Sequence[Input],
    working: Working,
    found: Workers,
    advance: Callable[[], None],
) -> Part[Sum]:
    """What a task makes of all clips, in chunks that do not depend on the number of workers.

    Where a chunk as a whole fails, its clips are tried one by one, so that one clip on which a worker dies takes no
    other with it.

    Parameters
    ----------
    task : of a chunk.
    inputs : files.
    working : processes and cluster.
    found : the workers they are.
    advance : called once for each clip.
    """
    whole: Part[Sum] = Part(None)
    size = min(max(1, -(-len(inputs) // CHUNKS)), MOST_CLIPS)
    chunks = [inputs[start : start + size] for start in range(0, len(inputs), size)]

    def take(outcome: Outcome[Sequence[Input], Part[Sum]]) -> None:
        nonlocal whole
        whole = whole + part_of(outcome)
        for _ in outcome.item:
            advance()

    def part_of(outcome: Outcome[Sequence[Input], Part[Sum]]) -> Part[Sum]:
        if outcome.value is not None:
            return outcome.value
        assert outcome.failure is not None
        if len(outcome.item) == 1:
            return Part(None, ((outcome.item[0].path, outcome.failure),))
        alone: Part[Sum] = Part(None)

        def take_one(single: Outcome[Sequence[Input], Part[Sum]]) -> None:
            nonlocal alone
            alone = alone + part_of(single)

        singles: list[Sequence[Input]] = [[item] for item in outcome.item]
        with workers(max(2, working.width), working.cluster) as others:  # never in this process
            in_turn(task, singles, take_one, others)
        return alone

    in_turn(task, chunks, take, found)
    return whole
