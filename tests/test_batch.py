"""Every item comes back, in order, whatever dies on the way."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

from batch_tasks import (
    answer_with,
    blas_threads,
    die_at_two,
    first_item_is_slow,
    ignores_interrupts,
    interrupted_in_compiled_code,
    leave_a_mark_and_die_once,
    mark_and_wait_for_the_first,
    never_hears_interrupts,
    own_number,
    square,
    square_or_fail,
    wait_or_die_at_two,
)
from motionmend import batch
from motionmend.errors import UsageError

PATIENT = "5 minutes"  # Dask's own cluster gives a worker up that is not there 15 s after it died: dead again, say


@pytest.mark.slow
@pytest.mark.parametrize("jobs", [1, 2])
def test_failures_stay_with_their_items(jobs: int) -> None:
    outcomes = batch.run(square_or_fail, range(6), jobs=jobs)
    assert [o.item for o in outcomes] == list(range(6))
    assert [o.value for o in outcomes] == [None, 1, 4, None, None, 25]
    failures = [o.failure for o in outcomes if o.failure is not None]
    assert [f.kind for f in failures] == ["FileError", "FileError", "ZeroDivisionError"]
    assert failures[0].message == "item 0 is a multiple of three"
    assert failures[2].message == "unexpected ZeroDivisionError: four is bad"
    assert "square_or_fail" in failures[2].traceback


@pytest.mark.slow
def test_one_death_loses_nothing_and_repeats_nothing_else(tmp_path: Path) -> None:
    outcomes = batch.run(leave_a_mark_and_die_once, [(n, tmp_path) for n in range(12)], jobs=2)
    assert [o.value for o in outcomes] == list(range(12))
    calls = len(list(tmp_path.iterdir()))
    assert calls == 13  # the one that died


@pytest.mark.slow
def test_an_item_that_always_kills_its_worker_fails_alone() -> None:
    outcomes = batch.run(die_at_two, range(6), jobs=2)
    assert [o.value for o in outcomes] == [0, 1, None, 3, 4, 5]
    failure = outcomes[2].failure
    assert failure is not None
    assert failure.kind == "WorkerDied"
    assert str(batch.ATTEMPTS) in failure.message


@pytest.mark.slow
def test_outcomes_are_told_as_they_come_and_returned_in_order() -> None:
    told: list[int] = []
    outcomes = batch.run(first_item_is_slow, range(4), jobs=2, on_done=lambda o: told.append(o.index))
    assert sorted(told) == [0, 1, 2, 3]
    assert told[0] != 0
    assert [o.value for o in outcomes] == [0, 1, 2, 3]


@pytest.mark.slow
@pytest.mark.parametrize("jobs", [1, 2])
def test_every_task_computes_with_one_blas_thread(jobs: int) -> None:
    for outcome in batch.run(blas_threads, range(2), jobs=jobs):
        assert outcome.value == {1}


@pytest.mark.slow
def test_an_interrupt_reaches_the_parent_alone() -> None:
    assert [outcome.value for outcome in batch.run(ignores_interrupts, range(2), jobs=2)] == [True, True]
    assert [outcome.value for outcome in batch.run(ignores_interrupts, range(2), jobs=1)] == [False, False]


@pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="there are no signal masks here")
def test_a_worker_that_is_being_started_hears_no_interrupt_and_the_parent_does() -> None:
    """It would end with a traceback of its own while it still imports what it needs."""
    assert [outcome.value for outcome in batch.run(never_hears_interrupts, range(2), jobs=2)] == [True, True]
    assert not never_hears_interrupts(0)


def test_an_item_that_cannot_travel_fails_alone() -> None:
    outcomes = batch.run(str, [1, lambda: None, 3], jobs=2)
    assert outcomes[0].value == "1"
    assert outcomes[2].value == "3"
    assert outcomes[1].failure is not None


def test_an_interrupt_that_compiled_code_hands_on_ends_all() -> None:
    told: list[int] = []
    with pytest.raises(KeyboardInterrupt):
        batch.run(interrupted_in_compiled_code, range(3), jobs=1, on_done=lambda o: told.append(o.index))
    assert told == []


def test_nothing_to_do() -> None:
    assert batch.run(square, [], jobs=4) == []


def test_jobs_below_one_are_refused() -> None:
    with pytest.raises(UsageError, match="above 0"):
        batch.run(square, [1], jobs=0)


def test_a_cluster_without_its_extra_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(UsageError, match=r'pip install "motionmend\[cluster\]"'):
        batch.run(square, [1], jobs=1, cluster="tcp://127.0.0.1:1")


def test_a_dask_cluster_gives_what_one_process_gives(monkeypatch: pytest.MonkeyPatch) -> None:
    distributed = pytest.importorskip("distributed", reason="the extra `cluster` is not installed")
    import dask

    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))
    with (
        dask.config.set({"distributed.deploy.lost-worker-timeout": PATIENT}),
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None
        ) as cluster,
    ):
        outcomes = batch.run(square_or_fail, range(6), jobs=1, cluster=cluster.scheduler_address)
        assert [o.value for o in outcomes] == [None, 1, 4, None, None, 25]
        died = batch.run(die_at_two, range(6), jobs=1, cluster=cluster.scheduler_address)
        assert [o.value for o in died] == [0, 1, None, 3, 4, 5]
    with pytest.raises(UsageError, match="no Dask scheduler answers"):
        batch.run(square, [1], jobs=1, cluster="tcp://127.0.0.1:1")


def test_who_ran_beside_an_item_that_killed_their_worker_is_asked_again_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    distributed = pytest.importorskip("distributed", reason="the extra `cluster` is not installed")
    import dask

    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))
    with (
        dask.config.set(
            {"distributed.scheduler.allowed-failures": 0, "distributed.deploy.lost-worker-timeout": PATIENT}
        ),
        distributed.LocalCluster(
            n_workers=1, threads_per_worker=2, host="127.0.0.1", dashboard_address=None
        ) as cluster,
    ):
        died = batch.run(wait_or_die_at_two, [2, 3], jobs=1, cluster=cluster.scheduler_address)
    assert [o.value for o in died] == [None, 3]
    assert died[0].failure is not None
    assert "KilledWorker" in died[0].failure.message


def test_a_cluster_that_loses_its_last_worker_is_not_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    distributed = pytest.importorskip("distributed", reason="the extra `cluster` is not installed")
    import dask

    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))
    monkeypatch.setattr(batch, "ASKED", 0.2)
    monkeypatch.setattr(batch, "DESERTED", 1.0)
    with (
        dask.config.set({"distributed.deploy.lost-worker-timeout": "0.1s"}),  # no new one can be there by then
        distributed.LocalCluster(
            n_workers=1, threads_per_worker=1, host="127.0.0.1", dashboard_address=None
        ) as cluster,
    ):
        outcomes = batch.run(die_at_two, range(5), jobs=1, cluster=cluster.scheduler_address)
    assert [o.value for o in outcomes] == [0, 1, None, None, None]
    for outcome in outcomes[2:]:
        assert outcome.failure is not None
        assert outcome.failure.kind == "WorkerDied"
        assert "no workers any more" in outcome.failure.message


@pytest.mark.slow
@pytest.mark.parametrize("jobs", [1, 2])
def test_outcomes_come_in_turn_and_few_wait_for_the_first(jobs: int, tmp_path: Path) -> None:
    taken: list[int | None] = []
    begun: list[int] = []

    def take(outcome: batch.Outcome[tuple[int, Path], int]) -> None:
        taken.append(outcome.value)
        begun.append(len(list(tmp_path.iterdir())))

    items = [(n, tmp_path) for n in range(40)]
    with batch.workers(jobs) as staff:
        batch.in_turn(mark_and_wait_for_the_first, items, take, staff)
        assert taken == list(range(40))
        assert begun[0] <= batch.AHEAD * jobs
        batch.in_turn(square, range(3), lambda outcome: taken.append(outcome.value), staff)
    assert taken[-3:] == [0, 1, 4]


@pytest.mark.slow
def test_deaths_during_a_sum_in_turn_leave_its_order(tmp_path: Path) -> None:
    taken: list[int | None] = []
    with batch.workers(2) as staff:
        batch.in_turn(die_at_two, range(8), lambda outcome: taken.append(outcome.value), staff)
    assert taken == [0, 1, None, 3, 4, 5, 6, 7]


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="processes are stopped and killed by signals")
def test_a_worker_killed_in_the_middle_of_its_answer_costs_nothing(tmp_path: Path) -> None:
    script = tmp_path / "cut.py"
    script.write_text(
        "import sys\n"
        "from pathlib import Path\n"
        "from motionmend.batch import run\n"
        "from batch_tasks import large_and_cut_off_once\n"
        "if __name__ == '__main__':\n"
        "    for outcome in run(large_and_cut_off_once, [(n, Path(sys.argv[1])) for n in range(4)], jobs=2):\n"
        "        print(len(outcome.value), set(outcome.value))\n"
    )
    paths = os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")])
    ran = subprocess.run(
        [sys.executable, str(script), str(tmp_path)],
        env={**os.environ, "PYTHONPATH": paths},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert ran.stdout == "1000 {0}\n20000000 {1}\n1000 {2}\n1000 {3}\n", ran.stderr
    assert (tmp_path / "cut").exists()


@pytest.mark.slow
def test_workers_killed_while_they_wait_are_replaced() -> None:
    taken: list[int] = []

    def take(outcome: batch.Outcome[int, int]) -> None:
        assert outcome.value is not None
        taken.append(outcome.value)

    with batch.workers(2) as staff:
        batch.in_turn(own_number, range(2), take, staff)
        for number in set(taken):
            os.kill(number, signal.SIGKILL if os.name == "posix" else signal.SIGTERM)
        batch.in_turn(own_number, range(4), take, staff)
    assert len(taken) == 6
    assert not set(taken[:2]) & set(taken[2:])


@pytest.mark.slow
def test_an_answer_that_cannot_travel_fails_alone() -> None:
    outcomes = batch.run(answer_with, ["a", "what cannot travel", "an error that cannot be rebuilt", "b"], jobs=2)
    assert [outcome.value for outcome in outcomes] == ["a", None, None, "b"]
    assert all(outcome.failure is not None and outcome.failure.message for outcome in outcomes[1:3])


@pytest.mark.slow
def test_workers_end_with_the_process_that_started_them(tmp_path: Path) -> None:
    """As after `kill -9`: workers that nobody sends anything any more would wait for ever."""
    script = tmp_path / "long.py"
    script.write_text(
        "import time\n"
        "from motionmend.batch import run\n"
        "if __name__ == '__main__':\n"
        "    run(time.sleep, [0.01] * 4 + [600.0] * 2, jobs=2)\n"
    )
    running = subprocess.Popen([sys.executable, str(script)])
    parent = psutil.Process(running.pid)
    deadline = time.monotonic() + 60
    staff: list[psutil.Process] = []
    while len(staff) < 2 and time.monotonic() < deadline:
        staff = [one for one in parent.children() if "spawn_main" in " ".join(one.cmdline())]
        time.sleep(0.05)
    time.sleep(1.0)  # until they have begun
    running.kill()
    running.wait()
    gone, alive = psutil.wait_procs(staff, timeout=20)
    for one in alive:
        one.kill()
    assert (len(gone), alive) == (2, [])


@pytest.mark.slow
@pytest.mark.parametrize("times", [1, 2])
def test_an_interrupt_ends_at_once_and_leaves_nothing_half_written(tmp_path: Path, times: int) -> None:
    """However long the items would take, and however impatient who interrupts."""
    out = tmp_path / "out"
    out.mkdir()
    script = tmp_path / "long.py"
    script.write_text(
        "import sys, time\n"
        "from pathlib import Path\n"
        "from motionmend.batch import run\n"
        "from motionmend.io.atomic import atomic\n"
        "def write_slowly(path):\n"
        "    with atomic(path) as temporary:\n"
        "        temporary.write_text('half')\n"
        "        try:\n"
        "            time.sleep(600)\n"
        "        finally:\n"
        "            print('complains', file=sys.stderr, flush=True)\n"
        "if __name__ == '__main__':\n"
        "    run(write_slowly, [Path(sys.argv[1]) / name for name in ('a.csv', 'b.csv')], jobs=2)\n"
    )
    running = subprocess.Popen([sys.executable, str(script), str(out)], stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 60
    while len(list(out.iterdir())) < 2 and time.monotonic() < deadline:
        time.sleep(0.05)
    assert len(list(out.iterdir())) == 2
    staff = psutil.Process(running.pid).children()
    began = time.monotonic()
    for _ in range(times):
        running.send_signal(signal.SIGINT)
        time.sleep(0.1)
    _, said = running.communicate(timeout=60)
    assert time.monotonic() - began < 10.0
    assert running.returncode != 0
    assert said.rstrip().endswith("KeyboardInterrupt")
    assert "complains" not in said
    assert list(out.iterdir()) == []
    assert psutil.wait_procs(staff, timeout=5)[1] == []
