"""Time stamps that are written as a clock shows them, with a date or without."""

import re
from collections.abc import Sequence
from datetime import date

DAY = 86_400.0  # s
_CLOCK = re.compile(
    r"^(?:(?P<date>\d{4}-\d\d-\d\d)[T ]\s*)?"
    r"(?P<hour>\d{1,2}):(?P<minute>[0-5]\d):(?P<second>[0-5]\d)(?:[.,:](?P<parts>\d+))?(?:Z|[-+]\d\d:?\d\d)?$"
)
SAID = "times are those of a clock: taken as seconds since midnight"


def clock_seconds(stamps: Sequence[str]) -> list[float] | None:
    """Seconds since the midnight before the first of `12:00:59.033`, `2024-05-01T12:00:59.033`; None where one is none.

    Without a date a clock that goes back by more than half a day has passed midnight.
    """
    found: list[float] = []
    first, days = None, 0
    for stamp in stamps:
        match = _CLOCK.match(stamp.strip())
        if match is None:
            return None
        seconds = (
            3600.0 * int(match["hour"])
            + 60.0 * int(match["minute"])
            + float(f"{match['second']}.{match['parts'] or 0}")
        )
        if match["date"]:
            try:
                day = date.fromisoformat(match["date"]).toordinal()
            except ValueError:
                return None
            first = day if first is None else first
            days = day - first
        elif found and days * DAY + seconds < found[-1] - DAY / 2:
            days += 1
        found.append(days * DAY + seconds)
    return found or None
