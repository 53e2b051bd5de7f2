"""Run the scripts behind the chosen claims and write what came out."""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from motionmend.errors import FileError, UsageError

from . import measured
from .claims import Claim, choose, load, out_of_reach
from .common import Findings
from .pictures import shrink
from .report import machine, write_report


def run(
    ids: Sequence[str],
    data: Path | str | None,
    out: Path | str,
    *,
    on_done: Callable[[dict[str, Any]], None] | None = None,
) -> list[dict[str, Any]]:
    """Measure claims on real recordings; writes `REPORT.md`, `measured.json` and `figures/*.png` into `out`.

    What an earlier run into the same folder measured of other claims stays in the report.

    Parameters
    ----------
    ids : of claims, e.g. `D2` or `B1`; all when empty. One that is judged in others runs these, and one that is out of
        reach says so and runs nothing.
    data : folder that holds `mocap/`; None takes the environment variable MOTIONMEND_DATA.
    out : folder, made when it is not there.
    on_done : called with each claim's result as soon as it is known.

    Returns
    -------
    One dictionary for each claim: part, id, title, place, theirs, ours, met, expected, as_expected, criteria, script,
    also.

    Raises
    ------
    UsageError : unknown id, or no data folder named.
    FileError : the folder holds no recordings.
    """
    claims = choose(load(), ids)
    results = [one.judge() for one in out_of_reach() if one.id in {name.upper() for name in ids}]
    for result in results if on_done is not None else ():
        on_done(result)
    if not claims:
        return results
    mocap = recordings_in(data)
    pictures = Path(out) / "figures"
    pictures.mkdir(parents=True, exist_ok=True)
    found = measured.load(Path(out))
    fresh: set[str] = set()
    for claim in claims:
        for script in claim.script:
            if script not in fresh:
                # many small products: threads of the linear algebra would only wait for each other
                with threadpool_limits(1, user_api="blas"):
                    findings = import_module(f".{script}", __package__).run(mocap, pictures)
                found[script] = replace(findings, machine=tuple(machine()))
                fresh.add(script)
                for name, _ in found[script].figures:
                    shrink(pictures / name)
                measured.save(Path(out), found)
        results.append(claim.judge(_values(claim, found)))
        if on_done is not None:
            on_done(results[-1])
    known = [claim for claim in load() if claim.is_measured(_values(claim, found))]
    write_report(Path(out) / "REPORT.md", [claim.judge(_values(claim, found)) for claim in known], found)
    return results


def _values(claim: Claim, found: Mapping[str, Findings]) -> dict[str, float]:
    measured = [found[script].values for script in claim.script if script in found]
    return {name: value for values in measured for name, value in values.items()}


def recordings_in(data: Path | str | None) -> Path:
    """The folder of motion capture recordings below `data` or MOTIONMEND_DATA."""
    named = data or os.environ.get("MOTIONMEND_DATA")
    if not named:
        raise UsageError("the claims are measured on real recordings: give --data DIR or set MOTIONMEND_DATA")
    folder = Path(named) / "mocap"
    if not folder.is_dir():
        raise FileError(
            f"{named} was to hold the folder mocap with real recordings, there is none: give another folder"
        )
    return folder
