"""The report: what was claimed, what came out, on which machine."""

import os
import platform
import sys
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

import motionmend

from .claims import BEYOND, PAPER
from .common import Findings, Table

ABOUT_BEYOND = (
    "The method `adaptive`, which is told nothing of the noise, the outliers or how well the library fits. The aims are the "
    "package's own: limits set beforehand, measured on clips and people that are in no library."
)


def write_report(
    path: Path, results: Sequence[Mapping[str, Any]], found: Mapping[str, Findings], only: Sequence[str]
) -> None:
    """Write the report of these results; `only` lists the claims when not all were run."""
    command = " ".join(["motionmend reproduce", *only, "--data DIR -o DIR"])
    surprises = [result["id"] for result in results if not result["as_expected"]]
    parts = [
        "# What the dissertation claims, and what came out here",
        "Hui Lou, *Acquiring 3D full-body motion from noisy and ambiguous input* (dissertation, Texas A&M University, "
        "2012), section 2: filter bases learned from clean clips, and robust statistics. This file is generated; numbers "
        "are measured on real recordings, which are not part of the project. Unless said otherwise an error is the RMS "
        "difference from the truth over body joint angles: no root, hands, fingers, thumbs or toes.",
        f"- Command: `{command}`\n" + "\n".join(f"- {line}" for line in machine()),
    ]
    if surprises:
        parts.append(f"**Not as expected: {', '.join(surprises)}.**")
    published = [result for result in results if result["part"] == PAPER]
    own = [result for result in results if result["part"] == BEYOND]
    if published:
        parts.append(f"{_met(published)} of {len(published)} claims are met.")
        parts += _judged(published, ("claim", "theirs", "ours", "met?"))
    if own:
        parts += ["# Beyond the paper", ABOUT_BEYOND, f"{_met(own)} of {len(own)} aims are met."]
        parts += _judged(own, ("aim", "wanted", "measured", "met?"))
    parts.append("# In full")
    for script, findings in found.items():
        parts.append(_section(script, findings))
    path.write_text("\n\n".join(parts) + "\n", encoding="utf-8")


def _judged(results: Sequence[Mapping[str, Any]], head: Sequence[str]) -> list[str]:
    """The table of some claims, what is not met, and the numbers that decide."""
    parts = [_table(head, [_row(result) for result in results])]
    missed = [result for result in results if not result["met"]]
    if missed:
        parts.append("## What is not met, and why")
        parts.append("\n".join(f"- **{r['id']}** ({r['title']}): {_why(r)}" for r in missed))
    parts.append("## What decides")
    parts.append(_table((head[0], "number", "measured", "wanted", "holds"), _criteria(results)))
    return parts


def _met(results: Sequence[Mapping[str, Any]]) -> int:
    return sum(result["met"] for result in results)


def machine() -> list[str]:
    """CPU model, cores and versions; nothing that names the computer."""
    return [
        f"CPU: {_cpu()}, {os.cpu_count()} cores",
        f"Python {platform.python_version()}, numpy {np.__version__}, motionmend {motionmend.__version__}",
    ]


def _cpu() -> str:
    listed = Path("/proc/cpuinfo")
    if listed.exists():
        for line in listed.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine() or sys.platform


def _row(result: Mapping[str, Any]) -> tuple[str, ...]:
    return (
        f"**{result['id']}** {result['title']} ({result['place']})",
        result["theirs"],
        result["ours"],
        "yes" if result["met"] else "no",
    )


def _why(result: Mapping[str, Any]) -> str:
    if not result["as_expected"]:
        return "expected to be met, see the numbers below"
    return result["expected"].partition(":")[2].strip()


def _criteria(results: Sequence[Mapping[str, Any]]) -> list[tuple[str, ...]]:
    signs = {"above": "≥", "below": "≤", "equal": "="}
    rows = []
    for result in results:
        for check in result["criteria"]:
            unit = "" if check["unit"] == "1" else f" {check['unit']}"
            margin = f" ± {check['tolerance']:g}" if check["tolerance"] else ""
            rows.append(
                (
                    result["id"],
                    check["about"],
                    f"{check['measured']:.3g}{unit}",
                    f"{signs[check['direction']]} {check['limit']:g}{margin}{unit}",
                    "yes" if check["holds"] else "no",
                )
            )
    return rows


def _section(script: str, findings: Findings) -> str:
    title = (import_module(f".{script}", __package__).__doc__ or script).strip().splitlines()[0]
    parts = [f"## {title}", f"Script: `papers/{script}.py`"]
    if findings.notes:
        parts.append("\n".join(f"- {note}" for note in findings.notes))
    parts.extend(f"![{caption}](figures/{name})\n\n*{caption}*" for name, caption in findings.figures)
    parts.extend(_titled(table) for table in findings.tables)
    return "\n\n".join(parts)


def _titled(table: Table) -> str:
    return f"{table.title}\n\n{_table(table.head, table.rows)}"


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)
