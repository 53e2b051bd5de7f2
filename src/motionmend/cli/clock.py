"""When this process began."""

import os
import time
from pathlib import Path

_LOADED = time.time()


def began() -> float:
    """The time at which this process was started, s since the epoch.

    Linux tells to 10 ms; elsewhere it is when this module was loaded.
    """
    try:
        after_name = Path("/proc/self/stat").read_text("ascii").rpartition(")")[2].split()
        since_boot = int(after_name[19]) / os.sysconf("SC_CLK_TCK")  # field 22, starttime
        return time.time() - (time.clock_gettime(time.CLOCK_BOOTTIME) - since_boot)
    except (OSError, ValueError, AttributeError, IndexError):
        return _LOADED


def since_start() -> float:
    """Seconds since this process was started: what a command takes until its work begins."""
    return max(0.0, time.time() - began())
