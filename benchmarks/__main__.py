"""`python -m benchmarks [SUITE...] [--gate] [--update]`."""

import argparse
import sys
import time
from importlib import import_module

from . import record
from .metric import Metric, regressions
from .results import table, write_results
from .timing import Plan

SUITES = ("fit", "repair", "adaptive", "kinematics", "render", "foreground", "files", "peers", "live")
LONG = ("archive", "endurance")  # minutes to half an hour each: only where named


def main(argv: list[str] | None = None) -> int:
    """Run suites; 0 when all went well, 1 when the gate found a regression or has no baseline, 2 for bad usage."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks", description="Measure the package against its plain twins and against peers."
    )
    parser.add_argument(
        "suites",
        nargs="*",
        metavar="SUITE",
        help=f"{', '.join(SUITES)}: all when none is given; {', '.join(LONG)}: long",
    )
    parser.add_argument("--gate", action="store_true", help="fail where a ratio is worse than in baseline.json")
    parser.add_argument(
        "--update", action="store_true", help="record this run in baseline.json and write RESULTS.md anew"
    )
    options = parser.parse_args(argv)
    unknown = [name for name in options.suites if name not in SUITES + LONG]
    if unknown:
        parser.error(f"no suite {', '.join(unknown)}: there are {', '.join(SUITES + LONG)}")
    if options.gate and options.update:
        parser.error("--gate compares with the baseline, --update replaces it: give one of them")
    try:
        baseline = record.of_one(record.load(), record.machine()["cpu"]) if options.gate else {}
        records = [_run(name, Plan()) for name in dict.fromkeys(options.suites or SUITES)]
        if options.update:
            write_results(record.of_one(record.save(records)))
    except record.RecordError as error:
        print(f"benchmarks: {error}", file=sys.stderr)
        return 1
    return gate(records, baseline) if options.gate else 0


def gate(records: list[record.Record], baseline: dict[str, record.Record]) -> int:
    """Compare suite by suite, say what is worse and where another processor stands in; 0 when nothing is worse."""
    for one in records:
        known = baseline[one.suite].machine["cpu"] if one.suite in baseline else one.machine["cpu"]
        if known != one.machine["cpu"]:
            print(
                f"{one.suite}: no baseline of this processor ({one.machine['cpu']}), compared with one of {known}; "
                "where it is worse see whether the commit before is, too",
                file=sys.stderr,
            )
    worse = [line for one in records for line in regressions(one.metrics, _metrics(baseline, one.suite))]
    for line in worse:
        print(f"worse: {line}", file=sys.stderr)
    compared = sum(metric.gated for one in records for metric in one.metrics)
    print(f"gate: {compared} ratios compared, {len(worse)} worse", file=sys.stderr)
    return 1 if worse else 0


def _metrics(baseline: dict[str, record.Record], suite: str) -> tuple[Metric, ...]:
    return baseline[suite].metrics if suite in baseline else ()


def _run(name: str, plan: Plan) -> record.Record:
    print(f"{name} ...", file=sys.stderr)
    before, start = record.load_average(), time.perf_counter()
    metrics = tuple(import_module(f".{name}", __package__).run(plan))
    after, minutes = record.load_average(), (time.perf_counter() - start) / 60
    print(table(metrics))
    loads = None if before is None or after is None else (before, after)
    return record.Record(name, record.machine(), loads, minutes, metrics)


if __name__ == "__main__":
    sys.exit(main())
