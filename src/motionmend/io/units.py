"""The unit of length of marker files."""

from collections.abc import Sequence

import numpy as np

from ..arrays import Bools, Floats

_METRES = {
    **dict.fromkeys(("mm", "millimeter", "millimeters", "millimetre", "millimetres"), 0.001),
    **dict.fromkeys(("cm", "centimeter", "centimeters", "centimetre", "centimetres"), 0.01),
    **dict.fromkeys(("m", "meter", "meters", "metre", "metres"), 1.0),
    **dict.fromkeys(("dm", "decimeter", "decimeters", "decimetre", "decimetres"), 0.1),
    **dict.fromkeys(("in", "inch", "inches"), 0.0254),
    **dict.fromkeys(("ft", "foot", "feet"), 0.3048),
}
_LEAST, _MOST = 0.03, 40.0  # m; a finger's markers, and a hall's


def metres_per_unit(stated: Sequence[str], values: Floats, present: Bools, where: str) -> tuple[float, tuple[str, ...]]:
    """Metres in one unit of a file.

    Parameters
    ----------
    stated : what the file says, the first entry counts; may be empty.
    values : (T, M, 3) positions in the file's unit.
    present : (T, M) which of them count.
    where : what states the unit, for the sentence.

    Returns
    -------
    metres : by name; when the name is missing or unknown, the one of m, cm, mm that makes a body of 0.2 m to 4 m.
    guesses : a sentence when it was guessed, or when the stated one makes something no person is.
    """
    unit = stated[0].strip().lower() if stated else ""
    spread = _spread(values, present)
    if unit in _METRES:
        metres = _METRES[unit]
        if not spread or _LEAST <= spread * metres <= _MOST:
            return metres, ()
        return metres, (
            f"{where} is {stated[0].strip()}, which makes the markers spread over {spread * metres:.2g} m: "
            "no person's size, lengths may be wrong",
        )
    name, metres = next(((n, m) for n, m in (("m", 1.0), ("cm", 0.01)) if spread * m <= 4), ("mm", 0.001))
    came = f"is '{stated[0].strip()}'" if unit else "is missing"
    return metres, (f"{where} {came}: took {name}, which makes the markers spread over {spread * metres:.3g} m",)


def _spread(values: Floats, present: Bools) -> float:
    """Median over frames, a thousand or two if there are so many, of the largest extent of what is present, file's
    unit."""
    whole = np.flatnonzero(present.sum(axis=1) > 1)
    if not whole.size:
        return 0.0
    whole = whole[:: 1 + len(whole) // 2000]
    seen = np.where(present[whole, :, None], values[whole], np.nan)
    return float(np.median((np.nanmax(seen, axis=1) - np.nanmin(seen, axis=1)).max(axis=1)))
