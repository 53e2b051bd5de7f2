"""Which of two labels bears which of two tracks, over a whole recording: the likeliest path and its rivals."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from ...arrays import Bools, Floats, Ints, runs
from .evidence import Continuity, Ends, line_weights

_SWITCH = -12.0  # log prior of a change of labels at one instant between two given markers
_MORE = -3.0  # and, where several pairs seem to change hands together, of each of them: they share the first price
_LABELLED = -4.0  # and of labels that are wrong from the start, or to the end, when a reference can tell
_LASTING = -4.0  # and of the whole recording spent swapped
_POSTURE = 0.1  # s, within which distances say the same thing over and over
_LIMIT = 10.0  # beyond it the odds of one stretch grow as a logarithm: a strange posture is one fact, however long
_KEPT = 24  # paths followed at a time, and
_HOPELESS = 60.0  # log odds behind the best at which one is given up: five changes of labels

_Node = tuple[int, int]  # stretch, slot
_State = tuple[bool, _Node | None, _Node | None]  # swapped, and where each of the two tracks was last seen


@dataclass(frozen=True)
class Stretch:
    """Frames first ... last in which two labels are swapped, and the log odds of that against any path that is not."""

    first: int
    last: int
    log_odds: float


def swapped_stretches(
    positions: Floats,
    cuts: Mapping[int, int],
    evidence: Floats,
    continuity: Continuity,
    fps: float,
    *,
    sided: bool = False,
) -> list[Stretch]:
    """The stretches of the likeliest path in which the two tracks bear each other's labels.

    Parameters
    ----------
    positions : (T, 2, 3) m of two labels, NaN = missing.
    cuts : frames at which the labels may change hands, and how many pairs do so there together.
    evidence : (T,) log odds of swapped to right by distances.
    continuity : of the recording.
    fps : Hz.
    sided : whether the evidence is by a reference and so tells right from wrong at the recording's ends too.

    The path is a hidden Markov chain whose state remembers where each track was last seen, so that a track is followed
    from stretch to stretch across its gaps under every hypothesis (Viterbi, with the odds from constrained reruns).
    """
    chain = _Chain(positions, cuts, evidence, continuity, fps, sided)
    free = np.zeros(len(chain.starts), dtype=bool)
    best, swapped = chain.best(free)
    found = []
    for start, stop in runs(swapped):
        forbidden = free.copy()
        forbidden[start:stop] = True
        frames = np.flatnonzero(chain.seen[chain.starts[start] : chain.stops[stop - 1]].any(axis=1))
        if len(frames):
            first, last = chain.starts[start] + frames[[0, -1]]
            found.append(Stretch(int(first), int(last), float(best - chain.best(forbidden)[0])))
    return found


class _Chain:
    """The stretches between cuts, their ends, and what it costs to go from one to another."""

    def __init__(
        self,
        positions: Floats,
        cuts: Mapping[int, int],
        evidence: Floats,
        continuity: Continuity,
        fps: float,
        sided: bool,
    ) -> None:
        self.seen: Bools = np.asarray(np.isfinite(positions).all(axis=2))
        self.starts = sorted({0, *cuts} - {len(positions)})
        self.stops = [*self.starts[1:], len(positions)]
        # A limb whose labels change hands is one event, however many markers it has.
        self.switch = [_SWITCH if cuts.get(k, 1) < 2 else _SWITCH / cuts[k] + _MORE for k in self.starts]
        self.ends = _LABELLED if sided else max(self.switch)
        self.continuity = continuity
        self.steps: dict[tuple[_Node, _Node], float] = {}
        self.heads: dict[_Node, tuple[int, Floats, Floats, bool]] = {}
        self.tails: dict[_Node, tuple[int, Floats, Floats, bool]] = {}
        self.odds = np.zeros(len(self.starts))
        for k, (start, stop) in enumerate(zip(self.starts, self.stops, strict=True)):
            said = evidence[start:stop].sum() / (_POSTURE * fps)
            lasting = _LASTING * self.seen[start:stop].any(axis=1).mean() * (stop - start) / len(positions)
            self.odds[k] = _LIMIT * np.sign(said) * np.log1p(abs(said) / _LIMIT) + lasting
            for slot in range(2):
                frames = start + np.flatnonzero(self.seen[start:stop, slot])
                if len(frames):
                    self.heads[k, slot] = self._line(positions[:, slot], frames, 1)
                    self.tails[k, slot] = self._line(positions[:, slot], frames[::-1], -1)
        self._go(list(self._usual_steps()))

    def _line(self, track: Floats, frames: Ints, forward: int) -> tuple[int, Floats, Floats, bool]:
        """Frame, place, velocity and whether that is known, of the line through the first samples in a row."""
        count = 1
        while count < min(self.continuity.window, len(frames)) and frames[count] == frames[count - 1] + forward:
            count += 1
        at = int(frames[0])
        if count < 2:
            return at, track[at], np.zeros(3), False
        slope, level = line_weights(count)
        samples = track[frames[:count][::-1]]
        return at, level @ samples, -forward * (slope @ samples), True

    def _usual_steps(self) -> Iterator[tuple[_Node, _Node]]:
        """From where each slot was last seen to the heads of each stretch: nearly all that paths go through."""
        lasts: dict[int, _Node] = {}
        for k in range(len(self.starts)):
            here = [(k, slot) for slot in range(2) if (k, slot) in self.heads]
            yield from ((last, node) for last in lasts.values() for node in here)
            lasts.update({node[1]: node for node in here})

    def _go(self, steps: list[tuple[_Node, _Node]]) -> None:
        """Work out the log densities of steps not met before."""
        new = [s for s in dict.fromkeys(steps) if s not in self.steps]
        if not new:
            return
        tails, heads = [self.tails[a] for a, _ in new], [self.heads[b] for _, b in new]
        left, right = (
            Ends(np.stack([e[1] for e in es]), np.stack([e[2] for e in es]), np.array([e[3] for e in es]))
            for es in (tails, heads)
        )
        frames = np.array([h[0] - t[0] for t, h in zip(tails, heads, strict=True)])
        self.steps.update(zip(new, self.continuity.log_density(left, right, frames)[0].tolist(), strict=True))

    @staticmethod
    def _last(state: _State, track: int) -> _Node | None:
        return state[2] if track else state[1]

    def best(self, forbidden: Bools) -> tuple[float, Bools]:
        """Log posterior of the likeliest path that is not swapped where forbidden, and where it is swapped."""
        front: dict[_State, float] = {(False, None, None): 0.0}
        trail: list[dict[_State, _State]] = []
        for k, odds in enumerate(self.odds):
            moves: list[tuple[_State, _State, list[tuple[_Node, _Node]], float]] = []
            for state, score in front.items():
                for swapped in (False,) if forbidden[k] else (False, True):
                    lasts = list[_Node | None]()
                    steps = list[tuple[_Node, _Node]]()
                    for track in range(2):
                        node, last = (k, 1 - track if swapped else track), self._last(state, track)
                        if node in self.heads:
                            if last is not None:
                                steps.append((last, node))
                            last = node
                        lasts.append(last)
                    price = self.switch[k] if k else self.ends
                    gain = (odds if swapped else 0.0) + (price if swapped != state[0] else 0.0)
                    moves.append((state, (swapped, lasts[0], lasts[1]), steps, score + gain))
            self._go([s for move in moves for s in move[2]])
            reached: dict[_State, float] = {}
            came: dict[_State, _State] = {}
            for state, then, steps, score in moves:
                total = score + sum(self.steps[s] for s in steps)
                if total > reached.get(then, -np.inf):
                    reached[then], came[then] = total, state
            hopeful = max(reached.values()) - _HOPELESS
            ahead = sorted((item for item in reached.items() if item[1] >= hopeful), key=lambda item: -item[1])
            front = dict(ahead[:_KEPT])
            trail.append(came)
        # A swap has two ends: one that lasts to the last frame is as rare as one from the first.
        front = {state: score + (self.ends if state[0] else 0.0) for state, score in front.items()}
        end = max(front, key=lambda s: front[s])
        score, path = front[end], np.zeros(len(self.odds), dtype=bool)
        for k in range(len(trail) - 1, -1, -1):
            path[k] = end[0]
            end = trail[k][end]
        return score, path
