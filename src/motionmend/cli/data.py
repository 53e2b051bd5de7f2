"""`motionmend data`: public recordings by name."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..batch import Failure
from ..errors import FileError, MotionMendError, UsageError, counted
from .options import AsJson, Debug
from .output import exit_code, tell_failure
from .speech import json_line, progress, say


def listed(*, as_json: AsJson = False, debug: Debug = False) -> int:
    """List the public recordings that can be fetched by name: what they are, whose, on which terms."""
    from ..datasets import DATASETS

    for one in DATASETS:
        if as_json:
            facts = {"name": one.name, "what": one.what, "source": one.source, "terms": one.terms}
            print(json_line({**facts, "files": len(one.items), "bytes": one.size}))
        else:
            print(f"{one.name}  {counted(len(one.items), 'file')}, {one.size / 1e6:.1f} MB, {one.terms}")
            print(f"  {one.what}\n  {one.source}")
    return 0


def get(
    *names: Annotated[str, Parameter(help="Names from `motionmend data list`.", negative="")],
    dir: Annotated[Path, Parameter(help="Folder in which DIR/NAME is made.")] = Path(),
    as_json: AsJson = False,
    debug: Debug = False,
) -> int:
    """Fetch public recordings; a file is kept only when its SHA-256 is the one known here.

    Files that are there already are not fetched again. Their terms are those of their sources.
    """
    from ..datasets import fetch, named

    if not names:
        raise UsageError("the name of a data set was wanted, came none: `motionmend data list` shows them")
    chosen = [named(name) for name in dict.fromkeys(names)]
    if dir.exists() and not dir.is_dir():
        raise FileError(f"--dir {dir}: a folder was wanted, this is a file")
    failures = []
    for one in chosen:
        try:
            with progress(len(one.items)) as advance:
                files = fetch(one, dir, lambda _: advance())
        except MotionMendError as error:
            failures.append(Failure(type(error).__name__, str(error), ""))
            tell_failure(dir / one.name, failures[-1], as_json=as_json, debug=debug)
            continue
        if as_json:
            print(json_line({"name": one.name, "folder": dir / one.name, "files": files, "bytes": one.size}))
        say(f"{one.name}: {counted(len(files), 'file')} in {dir / one.name} ({one.terms}; {one.source})")
    return exit_code(failures)
