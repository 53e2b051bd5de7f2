"""`python -m papers [ID...] --data DIR -o DIR`."""

import argparse
import sys
from pathlib import Path
from typing import Any

from motionmend.errors import MotionMendError, UsageError

from . import run


def main() -> int:
    """Run the claims; 0 when each came out as expected, 1 when one did not or an input failed, 2 for bad usage."""
    parser = argparse.ArgumentParser(prog="python -m papers", description="Run the papers' claims on real recordings.")
    parser.add_argument("ids", nargs="*", metavar="ID", help="claims to run, e.g. D2 D12 B1; all when none is given")
    parser.add_argument("--data", type=Path, help="folder of real recordings; default: MOTIONMEND_DATA")
    parser.add_argument("-o", "--out", type=Path, default=Path("reproduced"), help="where REPORT.md and figures go")
    options = parser.parse_args()
    try:
        results = run(options.ids, options.data, options.out, on_done=_say)
    except MotionMendError as error:
        print(f"papers: {error}", file=sys.stderr)
        return 2 if isinstance(error, UsageError) else 1
    if (options.out / "REPORT.md").exists():
        print(options.out / "REPORT.md")
    return 0 if all(result["as_expected"] for result in results) else 1


def _say(result: dict[str, Any]) -> None:
    verdict = "met" if result["met"] else "not met"
    surprise = "" if result["as_expected"] else " (expected otherwise)"
    print(f"{result['id']:4} {verdict}{surprise}: {result['ours']}", file=sys.stderr)


if __name__ == "__main__":
    sys.exit(main())
