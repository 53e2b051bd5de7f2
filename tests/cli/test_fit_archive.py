"""`motionmend fit denoiser` on many clips: the same model whoever reads them, and whatever dies on the way."""

import shutil
from functools import partial
from pathlib import Path
from threading import Event, Thread

import numpy as np
import psutil
import pytest
from commands import Command
from dying import die_on_one

from motionmend import samples
from motionmend.batch import workers
from motionmend.cli import archive
from motionmend.cli.inputs import Input
from motionmend.cli.options import Working
from motionmend.io import read, write
from motionmend.models import load_model
from skeletons import turned_otherwise

CLIPS = 36  # more than `archive.CHUNKS`: two lie in a chunk
SETTINGS = ["--window", "8", "--fps", "30"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Many tiny clips in a tree, a damaged one, and one of other channels; never write here."""
    top = tmp_path_factory.mktemp("clips")
    walk = samples.clip("walk", seconds=6.0, fps=30.0, seed=1)
    rng = np.random.default_rng(2)
    for k in range(CLIPS):
        day = top / f"day{k % 3}"
        day.mkdir(exist_ok=True)
        start, turned = int(rng.integers(walk.frames - 24)), rng.normal(scale=0.02, size=walk.q.shape[1])
        place = day / f"walk_{k:03d}.amc"
        write(place, walk.with_q(walk.q[start : start + 24] + turned))
        for other in place.parent.glob("*.asf"):  # one skeleton for each folder will do
            if other.name != "body.asf":
                other.replace(other.with_name("body.asf"))
    (top / "day1" / "bad.amc").write_text("1\nroot 1 2\n")
    strange = top / "strange"
    strange.mkdir()
    write(strange / "short.bvh", samples.clip("walk", seconds=1.0, fps=30.0, seed=4))
    return top


@pytest.fixture(scope="module")
def alone(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The model that one process learns."""
    from motionmend.cli import main

    out = tmp_path_factory.mktemp("models") / "alone.mend"
    assert main(["fit", "denoiser", str(folder), "-o", str(out), "--jobs", "1", *SETTINGS]) == 1
    return out


@pytest.mark.slow
def test_what_cannot_be_used_is_told_and_left_out(cli: Command, folder: Path, alone: Path, tmp_path: Path) -> None:
    ran = cli("fit", "denoiser", folder, "-o", tmp_path / "m.mend", "--jobs", "2", *SETTINGS)
    assert ran.code == 1
    assert len(ran.failures) == 2
    assert "bad.amc" in ran.failures[0]
    assert "short.bvh" in ran.failures[1]
    assert (tmp_path / "m.mend").read_bytes() == alone.read_bytes()
    assert load_model(alone).clips == CLIPS


@pytest.mark.slow
def test_without_them_the_model_is_the_same(cli: Command, folder: Path, alone: Path, tmp_path: Path) -> None:
    shutil.copytree(folder, tmp_path / "clips")
    (tmp_path / "clips" / "day1" / "bad.amc").unlink()
    shutil.rmtree(tmp_path / "clips" / "strange")
    ran = cli("fit", "denoiser", tmp_path / "clips", "-o", tmp_path / "m.mend", "--jobs", "1", *SETTINGS)
    assert ran.code == 0
    assert (tmp_path / "m.mend").read_bytes() == alone.read_bytes()


@pytest.mark.slow
def test_it_is_the_model_of_all_clips_at_once(folder: Path, alone: Path) -> None:
    from motionmend.denoise import Denoiser

    model = load_model(alone)
    clips = [read(path, fps=30.0) for path in sorted(folder.rglob("walk_*.amc"))]
    whole = Denoiser(window=8).fit(clips)
    np.testing.assert_allclose(model.bases.values, whole.bases.values, rtol=1e-6)
    np.testing.assert_allclose(model.library.bends, whole.library.bends, rtol=1e-6, atol=1e-9)
    np.testing.assert_array_equal(model.library.exemplars, whole.library.exemplars)
    np.testing.assert_allclose(model.dynamics.mean, whole.dynamics.mean, rtol=1e-6, atol=1e-9)


@pytest.mark.slow
def test_the_clip_that_turns_in_another_order_is_named_and_used(cli: Command, tmp_path: Path) -> None:
    for number in range(3):
        motion = samples.clip("walk", seconds=3.0, fps=30.0, seed=number)
        write(tmp_path / f"{number}.amc", motion)
    write(tmp_path / "same.amc", motion)
    cli("fit", "denoiser", tmp_path, "-o", tmp_path / "m.mend", "--jobs", "1", *SETTINGS)
    joint = motion.skeleton.names.index("lhumerus")
    write(tmp_path / "same.amc", turned_otherwise(motion, [joint]))
    ran = cli("fit", "denoiser", tmp_path, "-o", tmp_path / "o.mend", "--jobs", "1", *SETTINGS)
    assert ran.code == 0
    assert "same.amc: joints turn in another order than in the other clips" in ran.err
    one, other = load_model(tmp_path / "m.mend"), load_model(tmp_path / "o.mend")
    assert one.layout.names == other.layout.names
    np.testing.assert_allclose(one.bases.values, other.bases.values, rtol=1e-4)


@pytest.mark.slow
def test_a_killed_worker_costs_nothing(cli: Command, folder: Path, alone: Path, tmp_path: Path) -> None:
    out = tmp_path / "killed.mend"
    killed: list[int] = []
    finished = Event()

    def kill_two() -> None:
        while len(killed) < 2 and not finished.wait(0.02):
            for child in psutil.Process().children():
                try:
                    at_work = child.cpu_times().user > 0.3 + 0.3 * len(killed)
                    if at_work and len(killed) < 2 and "spawn_main" in " ".join(child.cmdline()):
                        child.kill()
                        killed.append(child.pid)
                except psutil.Error:  # it has gone by itself
                    continue

    killer = Thread(target=kill_two)
    killer.start()
    try:
        ran = cli("fit", "denoiser", folder, "-o", out, "--jobs", "2", *SETTINGS)
    finally:
        finished.set()
        killer.join()
    assert len(killed) > 0
    assert ran.code == 1, ran.err
    assert out.read_bytes() == alone.read_bytes()


@pytest.mark.slow
def test_a_clip_that_kills_every_worker_takes_no_other_with_it(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(archive, "CHUNKS", 4)
    inputs = [Input(path, Path(path.name)) for path in sorted((folder / "day1").glob("walk_*.amc"))[:12]]
    steps: list[int] = []
    task = partial(die_on_one, reading=archive.Reading(30.0, None))
    with workers(2) as staff:
        found = archive.total(task, inputs, Working(jobs=2), staff, lambda: steps.append(1))
    assert len(steps) == 12
    assert [path.name for path, _ in found.failures] == ["walk_007.amc"]
    assert found.failures[0][1].kind == "WorkerDied"
    assert found.value is not None
    (alike,) = found.value.groups.values()
    assert [clip.path for clip in alike.clips] == [item.path for item in inputs if item.path.name != "walk_007.amc"]


@pytest.mark.slow
def test_a_cluster_learns_the_same(cli: Command, folder: Path, alone: Path, tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed", reason="the extra `cluster` is not installed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None
    ) as cluster:
        address = cluster.scheduler_address
        ran = cli("fit", "denoiser", folder, "-o", tmp_path / "m.mend", "--cluster", address, *SETTINGS)
    assert ran.code == 1
    assert (tmp_path / "m.mend").read_bytes() == alone.read_bytes()
