"""What a run leaves behind: `baseline.json`, all measurements by processor and suite, with the machine of each."""

import json
import os
import platform
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_info

from .metric import Metric

FOLDER = Path(__file__).parent
BASELINE = FOLDER / "baseline.json"


class RecordError(Exception):
    """A baseline that is not there or cannot be read; the message says what to do."""


@dataclass(frozen=True)
class Record:
    """One suite's run.

    Attributes
    ----------
    suite : its name.
    machine : CPU, cores and versions; nothing that names the computer.
    load : average number of running processes in the minute before the start and before the end; None where the
        system does not say.
    minutes : that the run took.
    metrics : all that was measured.
    """

    suite: str
    machine: dict[str, str]
    load: tuple[float, float] | None
    minutes: float
    metrics: tuple[Metric, ...]


def machine() -> dict[str, str]:
    """What the figures depend on."""
    blas = {f"{i['internal_api']} {i['version']}" for i in threadpool_info() if i.get("user_api") == "blas"}
    return {
        "cpu": _cpu(),
        "cores": str(os.cpu_count()),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        **{name: version(name) for name in ("numpy", "scipy", "numba")},
        "blas": ", ".join(sorted(blas)),
    }


def load_average() -> float | None:
    """Running processes on average over the last minute."""
    return round(os.getloadavg()[0], 2) if hasattr(os, "getloadavg") else None


def load(path: Path = BASELINE) -> dict[str, dict[str, Record]]:
    """The baselines, by processor and suite; the one recorded last is the first.

    Raises
    ------
    RecordError : not there, or not a baseline.
    """
    if not path.exists():
        raise RecordError(f"{path.name}: no baseline yet; make one with --update")
    try:
        stored = json.loads(path.read_text("utf-8"))
        found = {cpu: {suite: _record(suite, one) for suite, one in suites.items()} for cpu, suites in stored.items()}
        if not all(found.values()):
            raise ValueError("a processor without suites")
        return found
    except (ValueError, KeyError, TypeError, AttributeError) as failure:
        raise RecordError(f"{path.name}: not a baseline ({failure}); restore it or make one with --update") from None


def save(records: Sequence[Record], path: Path = BASELINE) -> dict[str, dict[str, Record]]:
    """Put these suites into the baseline of their processor; all else stays as it was. Returns all of it."""
    whole = load(path) if path.exists() else {}
    for record in records:
        cpu = record.machine["cpu"]
        whole = {cpu: whole.get(cpu, {}) | {record.suite: record}} | {k: v for k, v in whole.items() if k != cpu}
    stored = {cpu: {suite: _stored(suites[suite]) for suite in sorted(suites)} for cpu, suites in whole.items()}
    path.write_text(json.dumps(stored, indent=1) + "\n", encoding="utf-8")
    return load(path)


def of_one(whole: dict[str, dict[str, Record]], cpu: str | None = None) -> dict[str, Record]:
    """Each suite as `cpu` ran it, else (and for None) as the processor did that was recorded last."""
    chosen: dict[str, Record] = {}
    for suites in [whole.get(cpu or "", {}), *whole.values()]:
        chosen |= {suite: record for suite, record in suites.items() if suite not in chosen}
    return {suite: chosen[suite] for suite in sorted(chosen)}


def _stored(record: Record) -> dict[str, Any]:
    return {
        "machine": record.machine,
        "load": record.load,
        "minutes": round(record.minutes, 1),
        "metrics": {metric.key: metric.to_json() for metric in record.metrics},
    }


def _record(name: str, stored: dict[str, Any]) -> Record:
    return Record(
        name,
        stored["machine"],
        tuple(stored["load"]) if stored["load"] else None,
        stored["minutes"],
        tuple(Metric(key, **values) for key, values in stored["metrics"].items()),
    )


def _cpu() -> str:
    listed = Path("/proc/cpuinfo")
    if listed.exists():
        for line in listed.read_text("utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine() or sys.platform
