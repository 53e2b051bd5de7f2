"""Left and right taken for each other: found by what goes on, put right when sure, refused when not (section 6).

A sensor that confuses the sides of a body, as when a person turns around, makes the trunk face the other way within one
frame, or moves two limbs to each other's place. No person does that. Both the posture as given and the one with sides
changed back are compared with what is expected from the frames before. That tells that sides have changed, not which of
the two was right; confusions do not last, and a body tells its sides.
"""

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from ..arrays import Bools, Floats, Ints
from ..kernels import sighting as kernel
from ..kernels.following import STRANGER
from ..numerics import factors as process
from ..numerics.factors import Factors
from .anatomy import Anatomy
from .normalise import Standard, bone_lengths
from .reliability import FAILING_SECONDS

MEMORY = 0.5  # s; after a longer break the trunk may face anywhere
SHAKY = 0.01  # m, of a coordinate; noise that can turn a line a hand long
REVISED = 3.0  # log-odds at which it was before that sides were confused
BONE_SPREAD = 0.2  # deviation of the logarithm of a bone's length among people and sensors, their size taken out
BODY = 2.0  # squared z-score of a coordinate up to which a posture may be a body's
BENT = 0.05  # m, by which a knee lies before the line from hip to ankle; a straight one less, errors included
TILTS = Rotation.from_euler("xz", [[0, 0], [25, 0], [-25, 0], [0, 25], [0, -25]], degrees=True).as_matrix()
FARTHEST = 9.0  # squared z-score beyond which a joint's place or a bone's length says nothing more


def trunk_turned(
    positions: Floats, last: Floats, before: Floats, seconds: float, body: Anatomy, shaking: float
) -> Bools:
    """(P,) which left-right pairs of the trunk face against where it faced a moment ago.

    Parameters
    ----------
    positions, last : (J, 3) m, upright, of this frame and the one before, NaN = missing.
    before : (2,) horizontal direction from right to left; zero = not known.
    seconds : since somebody was seen.
    shaking : m, deviation of a coordinate by which all joints shake; where they do, a pair has to be turned about as a
        whole, for noise turns the line between two that are near to one another.
    """
    if seconds > MEMORY:
        return np.zeros(len(body.across), dtype=np.bool_)
    last = last if shaking > SHAKY else np.full(last.shape, np.nan)
    return np.asarray(kernel.turned_around(positions, before, body.across, last))


def changed(positions: Any, pairs: Ints) -> Any:
    """(J, ...) with the members of the pairs (N, 2) in each other's place."""
    other = np.array(positions)
    other[pairs[:, 0]], other[pairs[:, 1]] = positions[pairs[:, 1]], positions[pairs[:, 0]]
    return other


def gone_along(rows: Floats, last: Floats, sides: Bools, body: Anatomy) -> Bools:
    """(J,) joints of limbs that changed places together with a trunk that did: those that are nearer to where the other
    was a frame ago; `sides` (J,) as otherwise told where that is not known.

    Parameters
    ----------
    rows, last : (J, 3) m, where the sensor has limbs now, and where they were.
    """
    stayed = np.sqrt(((rows - last) ** 2).sum(axis=1))
    went = np.sqrt(((rows - last[body.mirror]) ** 2).sum(axis=1))
    closer = (stayed + stayed[body.mirror]) - (went + went[body.mirror])
    loose = np.isfinite(closer) & ~np.isin(np.arange(len(rows)), body.across)
    return np.where(loose, closer > 0.0, sides)


def confused_until_now(
    factors: Factors, usual: Standard, body: Anatomy, posture: Floats, pairs: Ints, seconds: float
) -> bool:
    """Whether limbs that have changed places were confused before and are right now, rather than the other way round.

    Parameters
    ----------
    usual : the standard body.
    posture : (J, 3) as given now, in standard form, NaN = missing.
    pairs : (N, 2) joints that have changed places.
    seconds : for which they were where they were.
    """
    other = changed(posture, pairs)
    joints = pairs.ravel()
    _, cov = process.expected(factors, process.start(factors))
    variance = (np.trace(cov, axis1=1, axis2=2) / 3.0 + factors.noise + STRANGER**2)[joints]
    far = [((one[joints] - factors.mean[joints]) ** 2).sum(axis=1) / variance for one in (posture, other)]
    lengths = [bone_lengths(one[None], body)[0] for one in (posture, other)]
    off = [(np.log(np.maximum(one, 1e-6) / usual.lengths) / BONE_SPREAD) ** 2 for one in lengths]
    now, before = (
        np.nansum(np.minimum(a, FARTHEST)) + np.nansum(np.minimum(b, FARTHEST)) for a, b in zip(far, off, strict=True)
    )
    return bool(0.5 * (before - now) - seconds / FAILING_SECONDS > REVISED)


def confused_limbs(factors: Factors, usual: Standard, body: Anatomy, postures: Floats, least: float = REVISED) -> Bools:
    """(J,) joints of limbs that hang on the wrong side, by how joints lie to one another.

    Of what may be confused of a limb, from each joint outward, the likeliest is taken.

    Parameters
    ----------
    usual : the standard body.
    postures : (T, J, 3) in standard form, NaN = missing; what half of them say counts.
    least : log-odds.
    """
    confused = np.zeros(len(body.names), dtype=np.bool_)
    parts = [pairs for limb in body.limbs for pairs in limb]
    others = np.repeat(postures[None], len(parts), axis=0)
    for other, pairs in zip(others, parts, strict=True):
        other[:, pairs.ravel()] = postures[:, pairs[:, ::-1].ravel()]
    odds = iter(_likelier(factors, usual, body, postures, others).tolist())
    for limb in body.limbs:
        most, pairs = max(((next(odds), pairs) for pairs in limb), key=lambda one: one[0])
        if most > least:
            confused[pairs.ravel()] = True
    return confused


def faces_away(factors: Factors, usual: Standard, body: Anatomy, postures: Floats, least: float = REVISED) -> bool:
    """Whether all sides are exchanged, as when a back is taken for a front; parameters as of `confused_limbs`.

    Never where knees bend or toes point ahead as given, of one leg or of both: a body that faced the other way would
    have them backwards, however little the posture is like learned ones. Where no leg says anything trunk and arms have
    to say as much as in one frame, however many there are: who leans or holds the arms back does so in all of them.
    """
    if knees_ahead(postures, body) > BENT or toes_ahead(postures, body) > 0.0:
        return False
    if not _legs_tell(postures, body):
        least = max(least, REVISED)
    return bool(_likelier(factors, usual, body, postures, about_turn(postures, body)[None])[0] > least)


def _legs_tell(postures: Floats, body: Anatomy) -> bool:
    """Whether a whole leg, or a foot with its ankle, is seen in some of the postures (T, J, 3)."""
    there = np.asarray(np.isfinite(postures).all(axis=2))
    return bool(there[:, body.legs].all(axis=2).any() or there[:, body.feet].all(axis=2).any())


def knees_ahead(postures: Floats, body: Anatomy) -> float:
    """m, in the median of postures (T, J, 3) in standard form, by which the knee that does most, of legs that are seen,
    lies before the line from its hip to its ankle, below 0 behind it; 0 without legs."""
    hip, knee, ankle = np.moveaxis(postures[:, body.legs], 2, 0)
    along = ankle - hip
    with np.errstate(invalid="ignore", divide="ignore"):
        share = ((knee - hip) * along).sum(axis=2) / (along**2).sum(axis=2)
    ahead = (knee - hip - share[..., None] * along)[..., 2]
    ahead = ahead[np.isfinite(ahead).any(axis=1)]
    if ahead.size == 0:
        return 0.0
    most = np.take_along_axis(ahead, np.nanargmax(np.abs(ahead), axis=1)[:, None], axis=1)
    return float(np.median(most))


def toes_ahead(postures: Floats, body: Anatomy) -> float:
    """m, in the median of postures (T, J, 3) in standard form, by which feet that are seen lie before their ankles in
    the mean, below 0 behind them; 0 without feet."""
    ankle, foot = np.moveaxis(postures[:, body.feet, 2], 2, 0)
    ahead = foot - ankle
    ahead = ahead[np.isfinite(ahead).any(axis=1)]
    return float(np.median(np.nanmean(ahead, axis=1))) if ahead.size else 0.0


def about_turn(postures: Floats, body: Anatomy) -> Floats:
    """Postures (T, J, 3) in standard form with all sides exchanged, and so facing the other way."""
    return np.asarray(postures[:, body.mirror] * np.array([-1.0, 1.0, -1.0]))


def _likelier(factors: Factors, usual: Standard, body: Anatomy, postures: Floats, others: Floats) -> Floats:
    """(N,) log-odds, in the median of postures (T, J, 3), that each of N others (N, T, J, 3) is right; 0 where those
    are no body's.

    Given postures count as they are seen by the tilted sensor that explains them best: seen from below, legs are as
    strange as if they were exchanged.
    """
    aslant = (postures @ TILTS[:, None]).reshape(-1, *postures.shape[1:])
    every = np.concatenate((aslant, others.reshape(-1, *postures.shape[1:])))
    strange, count = _strangeness(factors, usual, body, every)
    strange, count = strange.reshape(-1, len(postures)), count[: len(postures)]
    as_given, exchanged, seen = strange[: len(TILTS)].min(axis=0), strange[len(TILTS) :], count > 0.0
    told = 0.5 * np.where(exchanged < BODY * count, as_given - exchanged, 0.0)
    return np.median(told[:, seen], axis=1) if seen.any() else np.zeros(len(others))


def _strangeness(factors: Factors, usual: Standard, body: Anatomy, postures: Floats) -> tuple[Floats, Floats]:
    """(T,) squared distances of postures (T, J, 3) from the factors' mean under their covariance, and how many
    coordinates were seen."""
    there = np.asarray(np.isfinite(postures).all(axis=2))
    less = np.where((there & body.trunk)[..., None], postures - usual.trunk, 0.0).sum(axis=1)
    centre = less / np.maximum((there & body.trunk).sum(axis=1), 1)[:, None]
    apart = np.where(there[..., None], postures - centre[:, None] - factors.mean, 0.0)
    weight = there / (factors.noise + STRANGER**2)
    loadings = factors.loadings
    precision = np.einsum("tj,jdk,jdl->tkl", weight, loadings, loadings) + np.eye(factors.count)
    pull = np.einsum("tj,jdk,tjd->tk", weight, loadings, apart)
    explained = (pull * np.linalg.solve(precision, pull[..., None])[..., 0]).sum(axis=1)
    return np.asarray((weight[..., None] * apart**2).sum(axis=(1, 2)) - explained), 3.0 * there.sum(axis=1)
