"""The benchmarks judge rightly: a planted regression fails, an equal run passes, nothing vanishes unseen."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

sys.path.insert(0, str(Path(__file__).parents[1]))  # the suites are no part of the installed package

from benchmarks import __main__ as command
from benchmarks import data, kinematics, memory, record, repair, results, timing, twins
from benchmarks.metric import Metric, regressions
from benchmarks.timing import Plan, Times, ratio

from motionmend.denoise.bases.optimise import PRIOR_WEIGHT, SCALE, window_starts
from motionmend.numerics.robust import ESTIMATORS

TINY = Plan(frames=(20, 60), rounds=2, long_rounds=2)


def metrics() -> st.SearchStrategy[Metric]:
    return st.builds(
        Metric,
        key=st.just("suite.what.ratio"),
        value=st.floats(0.01, 1e6),
        unit=st.just("x"),
        direction=st.sampled_from(["higher", "lower"]),
        tolerance=st.floats(0.0, 0.9),
    )


# ---- the gate ------------------------------------------------------------------------


@given(metrics())
@settings(max_examples=50)
def test_an_equal_run_passes(metric: Metric) -> None:
    assert regressions([metric], [metric]) == []


@given(metrics(), st.floats(1.01, 3.0))
@settings(max_examples=50)
def test_a_worse_value_fails_beyond_the_tolerance_and_only_there(metric: Metric, beyond: float) -> None:
    """Both ways: `beyond` times the tolerance is too much, a `beyond`th of it is let pass, better always passes."""
    sign = -1 if metric.direction == "higher" else 1
    allowed = metric.tolerance * metric.value
    too_bad = replace(metric, value=metric.value + sign * (beyond * allowed + 1e-6 * metric.value))
    tolerable = replace(metric, value=metric.value + sign * allowed / beyond)
    better = replace(metric, value=metric.value - sign * 0.5 * metric.value)
    assert len(regressions([too_bad], [metric])) == 1
    assert metric.key in regressions([too_bad], [metric])[0]
    assert regressions([tolerable], [metric]) == []
    assert regressions([better], [metric]) == []


def test_a_key_on_one_side_only_is_an_error() -> None:
    one, two = Metric("s.one.ratio", 2.0, "x", "higher"), Metric("s.two.ratio", 3.0, "x", "lower")
    assert regressions([one], [one, two]) == ["s.two.ratio: in the baseline, but not measured"]
    assert "not in the baseline" in regressions([one, two], [one])[0]


@pytest.mark.parametrize("value", [float("nan"), float("inf"), float("-inf")])
@pytest.mark.parametrize("direction", ["higher", "lower"])
def test_what_is_no_number_fails(value: float, direction: str) -> None:
    metric = Metric("s.one.ratio", 2.0, "x", direction)
    assert len(regressions([replace(metric, value=value)], [metric])) == 1


def test_another_unit_or_direction_fails() -> None:
    metric = Metric("s.one.ratio", 2.0, "x", "higher")
    assert len(regressions([replace(metric, unit="inputs")], [metric])) == 1
    assert len(regressions([replace(metric, direction="lower")], [metric])) == 1


def test_information_is_not_gated() -> None:
    fast, slow = Metric("s.one.rate", 9e3, "frames/s", "info"), Metric("s.one.rate", 1.0, "frames/s", "info")
    assert regressions([slow], [fast]) == []
    assert regressions([], [fast]) == []


def test_a_metric_needs_a_direction_and_a_tolerance_that_mean_something() -> None:
    with pytest.raises(ValueError, match="higher, lower or info"):
        Metric("s.one.ratio", 1.0, "x", "up")
    with pytest.raises(ValueError, match="share"):
        Metric("s.one.ratio", 1.0, "x", "higher", tolerance=35)


# ---- a suite, for real ---------------------------------------------------------------


@pytest.fixture(scope="module")
def measured() -> record.Record:
    """The suite on kinematics, on a few frames."""
    return record.Record("kinematics", record.machine(), (0.5, 0.5), 0.1, tuple(kinematics.run(TINY)))


def test_a_suite_measures_what_it_says(measured: record.Record) -> None:
    keys = [metric.key for metric in measured.metrics]
    assert len(set(keys)) == len(keys)
    assert {metric.suite for metric in measured.metrics} == {"kinematics"}
    for metric in measured.metrics:
        assert np.isfinite(metric.value), metric
        assert metric.value > 0, metric
        assert metric.low is not None
        assert metric.high is not None
        assert metric.low <= metric.value <= metric.high
        assert metric.unit == "x" or not metric.gated, "times inform, only ratios decide"
    assert sum(metric.gated for metric in measured.metrics) >= 3
    loops = next(m for m in measured.metrics if m.key == "kinematics.forward.20.loops_over_ours")
    assert loops.value > 5, "the compiled kernel is many times as fast as Python loops"


def test_the_gate_over_a_record(measured: record.Record, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What was saved is read back as it was; it passes against itself, and not with one ratio halved or left out."""
    baseline = record.of_one(record.save([measured], tmp_path / "baseline.json"))
    for before, after in zip(measured.metrics, baseline["kinematics"].metrics, strict=True):
        assert (before.key, before.unit, before.direction) == (after.key, after.unit, after.direction)
        assert after.value == pytest.approx(before.value, rel=1e-5)
    assert command.gate([measured], baseline) == 0
    first = next(metric for metric in measured.metrics if metric.gated)
    others = tuple(metric for metric in measured.metrics if metric is not first)
    planted = replace(measured, metrics=(replace(first, value=first.value / 2), *others))
    capsys.readouterr()
    assert command.gate([planted], baseline) == 1
    said = capsys.readouterr().err
    assert first.key in said
    assert "1 worse" in said
    assert command.gate([replace(measured, metrics=others)], baseline) == 1
    assert command.gate([measured], {}) == 1


def test_saving_one_suite_keeps_the_others(measured: record.Record, tmp_path: Path) -> None:
    path = tmp_path / "baseline.json"
    record.save([measured], path)
    record.save([replace(measured, suite="other")], path)
    assert set(record.of_one(record.load(path))) == {"kinematics", "other"}


def test_each_processor_has_a_baseline_of_its_own(
    measured: record.Record, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "baseline.json"
    other = replace(measured, machine=measured.machine | {"cpu": "another"}, minutes=9.0)
    whole = record.save([replace(other, suite="alone"), other], path) and record.save([measured], path)
    here = record.of_one(whole, measured.machine["cpu"])
    assert here["kinematics"].minutes == 0.1
    assert record.of_one(whole)["kinematics"].minutes == 0.1, "the last one recorded"
    assert record.of_one(whole, "another")["kinematics"].minutes == 9.0
    assert here["alone"].minutes == 9.0, "where there is no other"
    command.gate([measured], here)
    assert "no baseline of this processor" not in capsys.readouterr().err
    command.gate([replace(measured, suite="alone")], here)
    assert "no baseline of this processor" in capsys.readouterr().err


@pytest.mark.parametrize(
    "content", [None, "", "{", "[]", '{"fit": {}}', '{"fit": {"machine": 1, "metrics": {"a": {}}}}']
)
def test_a_baseline_that_is_none_is_one_clear_line(tmp_path: Path, content: str | None) -> None:
    path = tmp_path / "baseline.json"
    if content is not None:
        path.write_text(content, "utf-8")
    with pytest.raises(record.RecordError, match="--update"):
        record.load(path)


def test_bad_usage_is_refused() -> None:
    for argv in (["nonsense"], ["--gate", "--update"]):
        with pytest.raises(SystemExit) as end:
            command.main(argv)
        assert end.value.code == 2


# ---- the instruments -----------------------------------------------------------------


def test_runners_take_turns(monkeypatch: pytest.MonkeyPatch) -> None:
    """A B A B after one call of each that is thrown away; what is slow enough is called once a round."""
    calls: list[str] = []

    def runner(name: str) -> None:
        calls.append(name)
        np.linalg.eigvalsh(np.eye(700) + 1.0)

    monkeypatch.setattr(timing, "LEAST_SECONDS", 1e-6)
    times = timing.race({"a": lambda: runner("a"), "b": lambda: runner("b")}, 3)
    assert "".join(calls) == "ab" * 4
    assert len(times["a"].wall) == len(times["a"].cpu) == 3


def test_a_ratio_is_the_median_of_the_rounds() -> None:
    """Round by round, so that a machine that slows down in the middle changes nothing."""
    slow, fast = Times((1.0,) * 3, (4.0, 40.0, 8.0)), Times((1.0,) * 3, (2.0, 20.0, 2.0))
    found = ratio("s.one.ratio", slow, fast)
    assert (found.low, found.value, found.high) == (2.0, 2.0, 4.0)


@pytest.mark.slow
def test_peak_memory_sees_a_matrix_that_is_built() -> None:
    """The plain product holds every window; the kernel, a small part of that."""
    series = data.channels(data.motion(2_500))
    windows = (len(series) - data.WINDOW + 1) * data.WINDOW * series.shape[1] * 8
    plain, ours = memory.measure("lag-plain", series), memory.measure("lag", series)
    assert plain.data == series.nbytes
    assert plain.after - plain.before > 0.9 * windows
    assert ours.after - ours.before < 0.9 * (plain.after - plain.before)


def test_the_twins_do_the_same_as_the_reading_ones() -> None:
    loops, spoiled = twins.of_tests(), repair.case(45)
    bases, starts = spoiled.bases, window_starts(45, spoiled.bases.window, 1)
    rows = twins.trajectory_matrix(spoiled.start, bases.window)
    np.testing.assert_array_equal(rows, loops.trajectory_matrix(spoiled.start, bases.window))
    estimator = ESTIMATORS["welsch"]
    z = loops.alternate(
        spoiled.measured, spoiled.start, bases.mean, bases.vectors, starts, estimator.weight, SCALE, PRIOR_WEIGHT, 2
    )
    np.testing.assert_allclose(twins.alternate(spoiled.measured, spoiled.start, bases, 2), z, rtol=0, atol=1e-9)
    cost = loops.window_cost(z, spoiled.measured, bases.mean, bases.vectors, starts, estimator.rho, SCALE, PRIOR_WEIGHT)
    assert twins.cost(z, spoiled.measured, bases) == pytest.approx(cost, rel=1e-9)
    moved = data.motion(3)
    for plain, read in zip(
        twins.forward(moved.skeleton, moved.q), loops.chain_forward(moved.skeleton, moved.q), strict=True
    ):
        np.testing.assert_allclose(plain, read, rtol=0, atol=1e-12)


def test_the_performer_is_worth_measuring() -> None:
    """62 degrees of freedom, about the dissertation's 50 bases, and the same at every call."""
    moved = data.motion(300)
    assert moved.q.shape == (300, 62)
    assert 40 <= data.learned()[1].count <= 60
    np.testing.assert_array_equal(moved.q, data.motion(300).q)
    assert np.isnan(data.spoiled(moved).q).mean() == pytest.approx(data.GAPS, abs=0.01)


def test_an_exponent_is_the_slope() -> None:
    assert repair.exponent((1_000, 10_000, 60_000), [0.5, 5.0, 30.0]) == pytest.approx(1.0)
    assert repair.exponent((1_000, 10_000), [1.0, 100.0]) == pytest.approx(2.0)


# ---- what is committed ---------------------------------------------------------------


@pytest.mark.slow
def test_the_results_are_the_baseline(tmp_path: Path) -> None:
    """RESULTS.md is generated: it says what baseline.json says."""
    results.write_results(record.of_one(record.load()), tmp_path)
    committed = (record.FOLDER / "RESULTS.md").read_text("utf-8")
    assert (tmp_path / "RESULTS.md").read_text("utf-8") == committed
    assert (tmp_path / "cost.png").read_bytes().startswith(b"\x89PNG")


def test_the_baseline_holds_every_suite() -> None:
    assert set(record.of_one(record.load())) == {*command.SUITES, *command.LONG}
