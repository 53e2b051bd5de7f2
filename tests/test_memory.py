"""What a long recording needs beyond itself: its results, and no more of anything than a piece or a channel at a time.

Measured as growth from one length to a longer one, in sizes of the recording's own values. The work on a block of
frames is stood in for by something quick: how much it needs does not depend on the recording's length.
"""

import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from motionmend.bodies import put_before
from motionmend.bodies.motion import Motion
from motionmend.bodies.skeleton import ROTATION
from motionmend.cli.provenance import provenance
from motionmend.cli.transform import write_json
from motionmend.denoise import Denoiser, DenoiserModel, repair_without_model
from motionmend.denoise.adaptive import blocks as mending
from motionmend.denoise.adaptive import recording as mend_recording
from motionmend.denoise.adaptive.rounds import Adapted
from motionmend.denoise.bases.support import Support, interpolated
from motionmend.denoise.channels import pieces
from motionmend.denoise.library import exemplars as library
from motionmend.evaluate import corrupt
from motionmend.io import amc, biovision, bvh, read, text, write
from motionmend.samples import clip

SHORT, LONG = 1_200, 3_000  # frames; blocks of both are alike
WRITTEN_SHORT, WRITTEN_LONG = 250, 750


def peak(work: Callable[[], object]) -> int:
    """Bytes that some work holds at most beside what was there before."""
    tracemalloc.start()
    try:
        work()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def growth(short: Motion, long: Motion, work: Callable[[Motion], object]) -> float:
    """By how much the peak grows, in sizes of what the recording grows by."""
    work(short)  # loads and compiles what it needs
    more = peak(lambda: work(long)) - peak(lambda: work(short))
    return more / (long.q.nbytes - short.q.nbytes)


@pytest.fixture(scope="module")
def walk() -> Motion:
    clean = clip("walk", seconds=20.0, fps=30.0, seed=3)
    return corrupt(clean, noise=np.radians(1.0), outliers=0.02, gaps=0.02, seed=1).recording


@pytest.fixture(scope="module")
def model() -> DenoiserModel:
    return Denoiser(window=10, energy=0.9).fit([clip("walk", seconds=8.0, fps=30.0, seed=4)])


def _of(frames: int, walk: Motion) -> Motion:
    return walk.with_q(np.resize(walk.q, (frames, walk.q.shape[1])))


@pytest.mark.slow
@pytest.mark.parametrize("way", ["library", "doubtful library", "alone"])
def test_a_repair_holds_its_results_and_little_else(
    walk: Motion, model: DenoiserModel, monkeypatch: pytest.MonkeyPatch, way: str
) -> None:
    """Values, deviations, weights and origins are 2.1 times the recording, the channels they are made of 1."""
    off = 20.0 if way == "doubtful library" else 0.0

    def quick(measured: np.ndarray, *_: object, **__: object) -> Adapted:
        values = interpolated(measured)
        outlier = np.abs(np.diff(measured, axis=0, prepend=measured[:1])) > 20.0
        ones, one = np.ones(measured.shape), np.ones(measured.shape[1])
        told = Support(values + off, ones, ones)
        return Adapted(values, ones, outlier, one, one, told, one, values, 0.0 * ones, one, one, 1)

    monkeypatch.setattr(mending, "adapt", quick)
    monkeypatch.setattr(mending, "BLOCK", 20.0)
    monkeypatch.setattr(mending, "AT_ONCE", 1)
    monkeypatch.setattr(pieces.pieces, "__defaults__", (1 << 9,))
    monkeypatch.setattr(put_before, "LOOKED_AT", 60)
    monkeypatch.setattr(library, "_TOGETHER", 1 << 9)
    monkeypatch.setattr(library, "_SCALE_SAMPLES", 1 << 7)
    monkeypatch.setattr(mend_recording, "LONG", 1 << 10)
    monkeypatch.setattr(mend_recording, "OWN_WINDOW", 4)  # patterns so small that how much they need does not show

    def repair(recording: Motion) -> object:
        return repair_without_model(recording, "adaptive") if way == "alone" else model.repair(recording)

    said = " ".join(model.repair(_of(600, walk)).warnings)
    assert ("misses this recording" in said) == (way == "doubtful library")
    assert growth(_of(SHORT, walk), _of(LONG, walk), repair) < 8.0


@pytest.mark.slow
@pytest.mark.parametrize("ending", [".amc", ".bvh"])
def test_files_are_text_a_piece_at_a_time(
    walk: Motion, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ending: str
) -> None:
    """The text alone is larger than the values, its words are many times as large."""
    monkeypatch.setattr(text, "PIECE", 1 << 14)
    monkeypatch.setattr(put_before, "LOOKED_AT", 30)
    for module, name in ((amc, "WRITTEN"), (bvh, "WRITTEN"), (biovision, "TOGETHER")):
        monkeypatch.setattr(module, name, 1 << 6)
    recordings = [_of(frames, walk) for frames in (WRITTEN_SHORT, WRITTEN_LONG)]
    files = {one.frames: tmp_path / str(one.frames) / f"x{ending}" for one in recordings}
    for file in files.values():
        file.parent.mkdir()
    assert growth(*recordings, lambda one: write(files[one.frames], one)) < 3.0  # what another skeleton's angles take
    again = [read(file) for file in files.values()]
    assert growth(*again, lambda one: write(files[one.frames], one)) < 0.5
    assert growth(*again, lambda one: read(files[one.frames])) < 5.0


def test_what_was_done_to_each_sample_is_written_a_channel_at_a_time(walk: Motion, tmp_path: Path) -> None:
    """As lists of Python's numbers it is several times as large as the values."""
    recordings = [_of(frames, walk) for frames in (WRITTEN_SHORT, WRITTEN_LONG)]
    repaired = {one.frames: repair_without_model(one, "linear") for one in recordings}

    def tell(one: Motion) -> None:
        write_json(tmp_path / f"{one.frames}.json", provenance(repaired[one.frames]))

    assert (walk.skeleton.dof_kind == ROTATION).sum() > 20
    assert growth(*recordings, tell) < 0.5
