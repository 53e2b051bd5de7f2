"""`motionmend reproduce`: run the published claims again."""

import sys
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from ..errors import FileError
from .options import AsJson, Debug
from .speech import json_line, say

CLAIMS = Path("papers") / "claims.toml"


def reproduce(
    *ids: Annotated[str, Parameter(help="Claims to run, such as D12; all of them when none is named.")],
    data: Annotated[
        Path | None,
        Parameter(help="Folder of the recordings; otherwise the environment variable MOTIONMEND_DATA names it."),
    ] = None,
    out: Annotated[Path, Parameter(name=["-o", "--out"], help="Folder for REPORT.md and the figures.")] = Path(
        "reproduced"
    ),
    as_json: AsJson = False,
    debug: Debug = False,
) -> int:
    """Run the claims of the papers and write what came out beside what was claimed: REPORT.md and figures.

    A claim that is judged within others runs these; one that nothing here can measure says why.

    Exit code 1 says that a claim came out otherwise than the project states.
    """
    root = _checkout()
    sys.path.insert(0, str(root))
    try:
        papers = import_module("papers")  # of the checkout; no part of the installed package
        results = papers.run(ids, data, out, on_done=_tell_json if as_json else _tell)
    finally:
        sys.path.remove(str(root))
    if (out / "REPORT.md").exists():
        say(str(out / "REPORT.md"))
    return 0 if all(result["as_expected"] for result in results) else 1


def _tell(result: dict[str, Any]) -> None:
    """One line for a claim, as soon as it was run."""
    verdict = "met" if result["met"] else "not met"
    surprise = "" if result["as_expected"] else ", which the project does not expect"
    judged = f"{result['id']} ({', '.join(result['also'])})" if result.get("also") else result["id"]
    print(f"{judged}: {verdict}{surprise}: {result['ours']}", flush=True)


def _tell_json(result: dict[str, Any]) -> None:
    """The same for programs: the claim's id, what was claimed and found, and whether that meets it."""
    print(json_line(result), flush=True)


def _checkout() -> Path:
    """The folder that holds `papers/`: the current one or one above it, else the checkout the package runs from."""
    here = Path.cwd().resolve()
    for folder in (here, *here.parents, Path(__file__).resolve().parents[3]):
        if (folder / CLAIMS).is_file():
            return folder
    raise FileError(f"{CLAIMS} was wanted here or above, found none: clone the project and run this inside of it")
