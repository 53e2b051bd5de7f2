"""Which channels a model knows: learned from a bounded sample of frames of every clip."""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...arrays import Floats, frozen
from ...bodies.motion import Markers, Motion
from ...bodies.skeleton import ROTATION, Skeleton, turned_in_other_order
from ...errors import MismatchError, few
from .bare_names import bare_name, called_barely
from .cloud import Anchors, distance_change, learn_anchors, main_heading, righting
from .joints import middle, own_middle, unit
from .rotation_order import in_order_of
from .thinning import MOST_VALUES, Sample, first_number, nothing, sample

CLOUD_FRAMES = 400  # of a clip; enough to see what is rigid


@dataclass(frozen=True, eq=False)
class Layout:
    """Which channels a model knows and how a recording becomes them.

    Attributes
    ----------
    kind : "motion" or "markers".
    names : channel names (motions, D) or bare marker names (markers, M).
    centre : (D,) degrees or cm each joint channel is near to; empty for markers.
    anchors : the rigid group of markers, empty where channels stay in the world's frame; None for motions.
    up : (3,) against gravity, of the clips; recordings of markers are turned to it.
    heading : rad about `up`, to which a recording of markers that stays in the world's frame is turned back.
    """

    kind: str
    names: tuple[str, ...]
    centre: Floats
    anchors: Anchors | None
    up: Floats
    heading: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre", frozen(self.centre))
        object.__setattr__(self, "up", frozen(self.up))

    @property
    def columns(self) -> int:
        """C, channels of a frame."""
        return len(self.names) * (3 if self.kind == "markers" else 1)


@dataclass(frozen=True, eq=False)
class Sketch:
    """What a layout is learned from: samples of the frames of clips that add up, in the order of the clips.

    Attributes
    ----------
    kind, names, up : as in `Layout`, of the first clip.
    skeleton : of the first clip; None for markers.
    frames : (D,) degrees and cm each, or (M, 3) m.
    changes : (M, M) m of each clip, `distance_change`; none for motions.
    """

    kind: str
    names: tuple[str, ...]
    up: Floats
    skeleton: Skeleton | None
    frames: Sample[Floats]
    changes: Sample[Floats]

    def __add__(self, other: "Sketch") -> "Sketch":
        if other.kind != self.kind:
            raise MismatchError("a model learns from motions or from markers, came both: fit two models")
        lacking, new = set(self.names) - set(other.names), set(other.names) - set(self.names)
        if lacking or new:
            found = [f"{word} {few(sorted(names))}" for word, names in (("lacks", lacking), ("adds", new)) if names]
            raise MismatchError(
                f"all clips need the same channels, this one {' and '.join(found)}: "
                "fit clips of one skeleton or marker set"
            )
        if other.skeleton is not None:
            other = other.in_order_of(self.names)
        frames, changes = other.frames, other.changes
        if other.names != self.names:
            order = np.array([other.names.index(name) for name in self.names])
            frames = replace(frames, items=tuple(frame[order] for frame in frames.items))
            changes = replace(changes, items=tuple(change[np.ix_(order, order)] for change in changes.items))
        if self.kind == "markers" and not np.array_equal(other.up, self.up):
            upright = righting(other.up, self.up)
            frames = replace(frames, items=tuple(frame @ upright.T for frame in frames.items))
        return replace(self, frames=self.frames + frames, changes=self.changes + changes)

    def in_order_of(self, names: Sequence[str]) -> "Sketch":
        """A sketch of motions with their joints turning in the order of these names."""
        assert self.skeleton is not None
        if not len(turned_in_other_order(self.skeleton, names)):
            return self
        scale = unit(self.skeleton)
        q = np.array(self.frames.items).reshape(-1, len(scale)) / scale
        ordered = in_order_of(Motion(self.skeleton, q, 1.0), names)
        if len(otherwise := turned_in_other_order(ordered.skeleton, names)):
            turned = few([ordered.skeleton.names[joint] for joint in otherwise])
            raise MismatchError(
                "all clips need their joints to turn in the same order, or in another one about three axes at right "
                f"angles, in this one others do so: {turned}; fit clips of one kind"
            )
        frames = replace(self.frames, items=tuple(ordered.q * unit(ordered.skeleton)))
        return replace(self, names=ordered.channels, skeleton=ordered.skeleton, frames=frames)

    @property
    def common(self) -> tuple[str, ...]:
        """What clips that go together have in common: kind, channels in whatever order, rotations in theirs."""
        found = (self.kind, *sorted(self.names))
        if (body := self.skeleton) is None:
            return found
        turns = (
            [self.names[r] for r in body.dofs_of(j) if body.dof_kind[r] == ROTATION] for j in range(len(body.names))
        )
        return (*found, *sorted(" before ".join(names) for names in turns if len(names) > 1))

    def layout(self) -> Layout:
        """The layout the clips have in common."""
        if self.skeleton is not None:
            values = np.array(self.frames.items).reshape(-1, len(self.names))
            centre = middle(values, self.skeleton.dof_kind == ROTATION)
            return Layout(self.kind, self.names, centre, None, self.up)
        frames = np.array(self.frames.items).reshape(-1, len(self.names), 3)
        return Layout(self.kind, self.names, np.empty(0), learn_anchors(self.changes.items, frames, self.up), self.up)


def sketch(recording: Motion | Markers) -> Sketch:
    """The sketch of one clip."""
    recording = called_barely(recording) if isinstance(recording, Motion) else recording
    names = names_of(recording)
    if isinstance(recording, Motion):
        skeleton, q = recording.skeleton, recording.q
        scale = unit(skeleton)
        frames = _frames(q, first_number(q), len(names), lambda i: q[i] * scale)
        return Sketch("motion", names, skeleton.up, skeleton, frames, nothing(MOST_VALUES))
    number = first_number(recording.positions)
    some = recording.positions[:: max(1, recording.frames // CLOUD_FRAMES)]
    size = len(names) ** 2
    changes = sample(np.array([number]), np.array([size]), max(size, MOST_VALUES), lambda _: distance_change(some))
    frames = _frames(some, number, 3 * len(names), lambda i: some[i].copy())
    return Sketch("markers", names, recording.up, None, frames, changes)


def learn_layout(clips: Iterable[Motion | Markers]) -> Layout:
    """The layout that clips have in common; one clip at a time is held.

    Parameters
    ----------
    clips : of one kind, with the same channels (in any order, by name).

    Raises
    ------
    MismatchError : no clip, or kinds or channels differ.
    """
    whole: Sketch | None = None
    for clip in clips:
        whole = sketch(clip) if whole is None else whole + sketch(clip)
    if whole is None:
        raise MismatchError("a denoiser learns from clean clips, came none")
    return whole.layout()


def own_layout(recording: Motion | Markers) -> Layout:
    """A recording's own layout for methods that know no body: markers stay in the world's frame."""
    names = names_of(recording)
    if isinstance(recording, Motion):
        return Layout("motion", names, own_middle(recording), None, recording.skeleton.up)
    nowhere = Anchors(np.empty(0, dtype=np.int64), np.empty((0, 3)))
    return Layout("markers", names, np.empty(0), nowhere, recording.up)


def along_main_heading(layout: Layout, recording: Motion | Markers) -> Layout:
    """A recording's own layout with its axes along and across the line that its markers go to and fro on most.

    Coordinates are repaired each for itself: by these the same recording facing elsewhere is repaired the same, and who
    walks along a line is calm across it.
    """
    if isinstance(recording, Motion):
        return layout
    return replace(layout, heading=main_heading(recording.positions, recording.up))


def kind_of(recording: Motion | Markers) -> str:
    """ "motion" or "markers"."""
    return "motion" if isinstance(recording, Motion) else "markers"


def names_of(recording: Motion | Markers) -> tuple[str, ...]:
    """Channel names as a layout spells them."""
    if isinstance(recording, Motion):
        return recording.channels
    bare = [bare_name(n) for n in recording.names]
    often = Counter(bare)
    # a name that two subjects of one file share is told apart by the subject, and a repeated one by its number
    told = [b if often[b] == 1 else n.strip().upper() for b, n in zip(bare, recording.names, strict=True)]
    return tuple(n if told[:i].count(n) == 0 else f"{n} {told[:i].count(n) + 1}" for i, n in enumerate(told))


def _frames(values: Floats, number: int, size: int, frame: Callable[[int], Floats]) -> Sample[Floats]:
    count = len(values)
    return sample(number + np.arange(count), np.full(count, size), MOST_VALUES, frame)
