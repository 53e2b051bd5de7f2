"""Statistics of clips: parts add up to the whole, samples stay within their bounds, pieces say what the whole says."""

from collections.abc import Iterator
from itertools import accumulate, pairwise

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import motionmend.denoise.library.statistics as module
from motionmend.bodies.motion import Motion
from motionmend.denoise import Denoiser
from motionmend.denoise.channels import thinning
from motionmend.denoise.channels.layout import learn_layout, sketch
from motionmend.denoise.channels.thinning import Sample, sample
from motionmend.denoise.library import learning, passages
from motionmend.denoise.library.learning import at_rate, examples
from motionmend.denoise.library.passages import rejoined
from motionmend.denoise.library.statistics import OCTAVES, Statistics, statistics
from motionmend.errors import MismatchError
from motionmend.samples import clip, markers

FPS, WINDOW = 30.0, 12


@pytest.fixture(scope="module")
def clips() -> list[Motion]:
    walks = [clip("walk", seconds=1.5 + 0.3 * k, fps=60.0, seed=k) for k in range(5)]
    q = walks[2].q.copy()
    q[30:33, 8] = np.nan
    q[50:90, 11] = np.nan
    return [*walks[:2], walks[2].with_q(q), *walks[3:]]


def _of(clips) -> Statistics:
    return statistics(clips, learn_layout(clips), WINDOW, FPS)


def _equal(one: Statistics, other: Statistics) -> None:
    """To rounding the sums, exactly the samples."""
    np.testing.assert_allclose(one.lag.products, other.lag.products, rtol=1e-9, atol=1e-6)
    np.testing.assert_allclose(one.lag.total, other.lag.total, rtol=1e-9, atol=1e-7)
    np.testing.assert_allclose(one.bends, other.bends, rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(one.bend_counts, other.bend_counts)
    for name in ("clips", "frames", "lost", "bridged"):
        assert getattr(one, name) == getattr(other, name)
    assert one.lag.count == other.lag.count
    for mine, theirs in ((one.windows, other.windows), (one.passages, other.passages)):
        assert mine.level == theirs.level
        np.testing.assert_array_equal(mine.numbers, theirs.numbers)
    np.testing.assert_array_equal(np.array(one.windows.items), np.array(other.windows.items))
    for mine, theirs in zip(rejoined(one.passages), rejoined(other.passages), strict=True):
        np.testing.assert_array_equal(mine, theirs)


@pytest.mark.slow
@given(st.lists(st.integers(0, 5), max_size=4), st.sampled_from([40, 150, 4000]))
@settings(max_examples=6, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_parts_add_up_to_the_whole(clips, cuts, exemplars):
    layout = learn_layout(clips)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "MOST_EXEMPLARS", exemplars)
        whole = statistics(clips, layout, WINDOW, FPS)
        edges = [0, *sorted(cuts), len(clips)]
        parts = [statistics(clips[a:b], layout, WINDOW, FPS) for a, b in pairwise(edges)]
    *_, added = accumulate(parts, lambda one, other: one + other)
    _equal(added, whole)
    assert len(whole.windows.items) <= exemplars


@given(
    st.lists(st.tuples(st.integers(0, 10**9), st.integers(1, 40)), min_size=1, max_size=8),
    st.integers(1, 60),
    st.randoms(use_true_random=False),
)
def test_a_sample_is_the_same_however_its_clips_are_dealt_out(starts, most, random):
    def one(start: int, count: int) -> Sample[int]:
        return sample(start + np.arange(count), np.ones(count, dtype=np.int64), most, lambda i: start + i)

    parts = [one(*clip) for clip in starts]
    *_, in_order = accumulate(parts, lambda a, b: a + b)
    while len(parts) > 1:
        k = random.randrange(len(parts) - 1)
        parts[k : k + 2] = [parts[k] + parts[k + 1]]
    assert parts[0].items == in_order.items
    assert parts[0].level == in_order.level
    assert len(in_order.items) <= most
    assert all(number % 2**in_order.level == 0 for number in in_order.items)


def test_long_and_short_clips_are_sampled_alike():
    parts = [
        sample(np.random.default_rng(k).integers(1 << 40) + np.arange(n), np.ones(n, dtype=int), 500, lambda _, k=k: k)
        for k, n in enumerate([20_000, *[10] * 2_000])
    ]
    *_, whole = accumulate(parts, lambda a, b: a + b)
    share = np.mean(np.array(whole.items) == 0)
    assert 250 < len(whole.items) <= 500
    assert share == pytest.approx(0.5, abs=0.1)


def test_bends_are_second_differences_at_every_rate_the_clips_reach(clips):
    found = _of(clips[:1])
    values = next(examples(clips[0], learn_layout(clips[:1]), tail=0.0)).values
    for k, octave in enumerate(OCTAVES):
        rate = FPS * 2.0**octave
        if rate > 60.0:
            assert found.bend_counts[k] == 0
            continue
        expected, count = np.zeros((values.shape[1],) * 2), 0
        for series in at_rate(values, 60.0, rate):
            for t in range(len(series) - 2):
                bend = series[t] - 2 * series[t + 1] + series[t + 2]
                expected += np.outer(bend, bend)
                count += 1
        assert found.bend_counts[k] == count
        np.testing.assert_allclose(found.bends[k], expected, rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(found.library().rates, [15.0, 30.0, 60.0])


def test_windows_are_those_of_the_clips_and_none_has_a_gap(clips):
    layout = learn_layout(clips)
    found = statistics(clips, layout, WINDOW, FPS)
    assert len(found.windows.items) == found.lag.count  # few enough to keep all
    every = [
        series[start : start + WINDOW].astype(np.float32).tobytes()
        for one in clips
        for example in examples(one, layout, 0.0)
        for series in at_rate(example.values, example.fps, FPS)
        for start in range(len(series) - WINDOW + 1)
        if np.isfinite(series[start : start + WINDOW]).all()
    ]
    assert sorted(window.tobytes() for window in found.windows.items) == sorted(every)


def test_passages_below_the_bound_are_the_clips_themselves(clips):
    layout = learn_layout(clips)
    series = [one for c in clips for example in examples(c, layout, 0.0) for one in at_rate(example.values, c.fps, FPS)]
    kept = rejoined(statistics(clips, layout, WINDOW, FPS).passages)
    for mine, theirs in zip(kept, series, strict=True):
        np.testing.assert_array_equal(mine, theirs)


def test_what_is_left_out_between_passages_cuts_the_series():
    series = [np.arange(6.0 * passages.FRAMES).reshape(-1, 1)]
    kept = passages.passages(series, 0)
    thin = sample(kept.numbers, kept.sizes, 4 * passages.FRAMES, lambda i: kept.items[i])  # places 0, 2 and 4
    found = rejoined(thin)[0][:, 0]
    assert np.isnan(found).sum() == 2
    whole = found[np.isfinite(found)]
    assert len(whole) == 3 * passages.FRAMES
    assert whole[passages.FRAMES] == 2 * passages.FRAMES


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["motion", "markers"])
def test_pieces_of_a_long_clip_say_what_the_whole_says(monkeypatch, kind):
    long = clip("walk", seconds=40.0, fps=60.0, seed=3)
    recording = long if kind == "motion" else markers(long)
    layout = learn_layout([recording])
    whole = statistics([recording], layout, WINDOW, FPS)
    monkeypatch.setattr(learning, "LEAST_PIECE", 500)
    monkeypatch.setattr(learning, "MOST_VALUES", 800 * layout.columns)
    parts = statistics([recording], layout, WINDOW, FPS)
    assert len(list(examples(recording, layout, 0.0))) == 3
    assert (parts.clips, parts.frames, parts.lag.count) == (whole.clips, whole.frames, whole.lag.count)
    # the travelling frame of a piece is that of the whole but for the weights of its own outliers
    scale = np.abs(whole.lag.matrix()).max()
    np.testing.assert_allclose(parts.lag.matrix(), whole.lag.matrix(), atol=1e-2 * scale)


@pytest.mark.slow
def test_a_library_is_learned_as_it_is_read_and_one_that_runs_out_is_kept(clips):
    class Reread:
        """Reads its clips anew each time; notes how many are alive."""

        rounds = 0

        def __iter__(self) -> Iterator[Motion]:
            self.rounds += 1
            return iter(clips)

    library = Reread()
    settings_ = Denoiser(window=WINDOW, fps=FPS)
    models = [settings_.fit(clips), settings_.fit(library), settings_.fit(iter(clips))]
    assert library.rounds == 2
    first = models[0].to_arrays()[0]
    for model in models[1:]:
        for name, array in model.to_arrays()[0].items():
            assert np.asarray(array).tobytes() == np.asarray(first[name]).tobytes(), name


@pytest.mark.slow
def test_a_model_of_a_thinned_library_is_near_that_of_the_whole(monkeypatch):
    walks = [clip("walk", seconds=4.0, fps=60.0, seed=k) for k in range(6)]
    settings_ = Denoiser(window=WINDOW, fps=FPS)
    whole = settings_.fit(walks)
    bound = 60 * walks[0].q.shape[1]
    for part in (thinning, passages, module):
        monkeypatch.setattr(part, "MOST_VALUES", bound)
    monkeypatch.setattr("motionmend.denoise.channels.layout.MOST_VALUES", bound)
    monkeypatch.setattr(passages, "FRAMES", 20)
    monkeypatch.setattr(module, "MOST_EXEMPLARS", 32)
    few = settings_.fit(walks)
    assert 0 < len(few.library.exemplars) <= 32
    assert few.bases.count == pytest.approx(whole.bases.count, abs=1)
    np.testing.assert_allclose(few.layout.centre, whole.layout.centre, atol=5.0)
    np.testing.assert_allclose(few.library.bends, whole.library.bends, rtol=0.05, atol=0.05 * whole.library.bends.max())


@pytest.mark.slow
def test_sketches_add_up_to_the_layout_of_all(clips):
    clouds = [markers(c) for c in clips]
    for of in (clips, clouds):
        left, right = [sketch(c) for c in of[:2]], [sketch(c) for c in of[2:]]
        *_, a = accumulate(left, lambda one, other: one + other)
        *_, b = accumulate(right, lambda one, other: one + other)
        one, other = (a + b).layout(), learn_layout(of)
        assert one.names == other.names
        np.testing.assert_array_equal(one.centre, other.centre)
        if one.anchors is not None and other.anchors is not None:
            np.testing.assert_array_equal(one.anchors.indices, other.anchors.indices)
            np.testing.assert_array_equal(one.anchors.template, other.anchors.template)
    with pytest.raises(MismatchError, match="two models"):
        sketch(clips[0]) + sketch(clouds[0])


@pytest.mark.slow
def test_one_clip_in_twenty_may_lose_a_marker_for_good():
    three = [markers(clip("walk", seconds=1.0, fps=30.0, seed=k)) for k in range(3)]
    clouds = [three[k % 3] for k in range(40)]
    anchors = learn_layout(clouds).anchors
    assert anchors is not None
    positions = clouds[7].positions.copy()
    positions[:, anchors.indices[0]] = np.nan
    spoiled = [*clouds[:7], clouds[7].with_positions(positions), *clouds[8:]]
    again = learn_layout(spoiled).anchors
    assert again is not None
    np.testing.assert_array_equal(again.indices, anchors.indices)


@pytest.mark.slow
def test_clips_without_a_whole_window_are_told_by_their_numbers():
    whole = markers(clip("walk", seconds=2.0, seed=1))
    rate = whole.fps

    def with_gaps(*gaps):
        positions = whole.positions.copy()
        for marker, start, seconds in gaps:
            positions[round(start * rate) : round((start + seconds) * rate), marker] = np.nan
        return whole.with_positions(positions)

    bridged = with_gaps(*((3, start, 0.15) for start in (0.5, 1.0, 1.5)))
    side_by_side = with_gaps(*((m, start + 0.14 * m, 0.14) for m in range(3) for start in (0.5, 1.1)))
    cut = with_gaps(*((3, start, 0.3) for start in (0.3, 0.9, 1.5)))
    short = whole.with_positions(whole.positions[: round(0.5 * rate)])
    clips, layout = [cut, bridged, short, whole, side_by_side], learn_layout([whole])
    found = statistics(clips, layout, 20, 30.0)
    assert found.barren == (0, 2)
    assert (statistics(clips[:1], layout, 20, 30.0) + statistics(clips[1:], layout, 20, 30.0)).barren == found.barren
