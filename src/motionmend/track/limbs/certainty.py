"""How sure a pose is: what is seen of each bone, and a standard deviation for each joint."""

import numpy as np

from ...arrays import Bools, Floats, frozen
from ...bodies.performer import BONES, FIRST, LANDMARK_BONES, LANDMARKS, PARENTS, Performer, Pose, landmarks, twists
from ...kernels import limbs
from ...kernels.bone_systems import spreads
from ...numerics.least_squares import Solution
from ..frame.evidence import STANDARD
from ..terms.view import BONES_MOVED, MOVED_FIRST
from .other_poses import COARSE, Coarse, cast_parts

FIT = 0.08  # m; a rendered pixel this near to what is seen shows its bone
ENOUGH = 4.0  # standard samples of a bone that show it well; see `Evidence.weight`
CLUMP = 25.0  # neighbouring residuals err together: so many of them tell as much as one
SHAPE = 0.006  # m, by which every surface differs from the model's
STRAY = 0.20  # m/s, how fast a joint that is not seen may leave where the prior holds it
DENIED = 0.3  # share of a bone's samples that noise and clothes deny
BARE = 0.31  # share that is denied or unknown of a forearm that is there: outlines are lost, and noise makes holes
LIMB, BODY = 0.4, 0.8  # m, where all of a limb or of the body is denied
UNSHOWN, AT_MOST = 0.8, 0.09  # m, where nothing of a forearm is shown that should be, if it were not at most so much
LINGERS = 0.3  # s, over about which it is not: noise takes an outline's pixels for a frame or two
NOBODYS = 0.3  # share of pixels explained wrongly, above which a pose is in doubt, whatever is usual
REACH = 0.25  # m, about as far as it gets
# m, of joints deep in the trunk: how far beneath their surface they lie differs from person to person.
WITHIN = {"pelvis": 0.012, "chest": 0.010, "neck": 0.010, "l_hip": 0.007, "r_hip": 0.007}
_PARENTS = PARENTS.tolist()
_FOREARMS = [BONES.index(bone) for bone in ("l_forearm", "r_forearm")]  # legs stand out from the rest, arms lie on it
_WITHIN = frozen([WITHIN.get(name, 0.0) for name in LANDMARKS])
_BONE_OF = np.repeat(np.arange(len(BONES)), np.diff(FIRST))  # of each joint coordinate


def shown_and_denied(performer: Performer, pose: Pose, coarse: Coarse, weight: float) -> tuple[Floats, Floats, Floats]:
    """Standard samples of each bone (B,) that are seen where the pose puts them, (B,) not there, and (B,) unknown.

    A sample is denied where nobody is, or the person is farther away, and unknown where nothing is measured; what hides
    behind something is none of them.
    """
    depth, solid = cast_parts(performer, pose, coarse)
    shown, denied, unknown = np.zeros((3, len(BONES)))
    limbs.shown_and_denied(
        coarse.seen, coarse.free, depth, solid, performer.solids.arrays.carriers, FIT, shown, denied, unknown
    )
    standard = weight * COARSE**2
    return shown * standard, denied * standard, unknown * standard


def trust_of(share: Floats) -> tuple[Floats, Bools]:
    """(28,) how well each joint coordinate is shown, 0 to 1, and (16,) which joints are seen.

    A coordinate is shown by its own bone and, less, by those it carries; a joint by its bone or the one before it.
    """
    carried = (share / (share + ENOUGH)).tolist()
    for b in range(len(BONES) - 1, 0, -1):
        carried[_PARENTS[b]] = max(carried[_PARENTS[b]], 0.7 * carried[b])
    own = np.array(carried)
    return own[_BONE_OF], own[LANDMARK_BONES] > 0.2


def bare_of(before: Floats, shown: Floats, denied: Floats, unknown: Floats, elapsed: float) -> Floats:
    """(B,) share of each bone that should be seen and is denied or unknown, a running mean.

    Parameters
    ----------
    before : (B,) as of the frame before; NaN = of none. elapsed : s, since then.
    shown, denied, unknown : (B,) standard samples, see `shown_and_denied`.
    """
    now = (denied + unknown) / (shown + denied + unknown + ENOUGH)
    return np.where(np.isfinite(before), before + (now - before) * (1.0 - np.exp(-elapsed / LINGERS)), now)


def astray(shown: Floats, denied: Floats, bare: Floats, wrong: float, usual: float) -> Floats:
    """(16,) m, how far joints may be from a pose that the frame denies.

    Parameters
    ----------
    shown, denied : (B,) standard samples, see `shown_and_denied`. bare : (B,) of `bare_of`.
    wrong, usual : share of all pixels explained wrongly, now and as a rule (NaN = not known yet).
    """
    share = denied / (shown + denied + ENOUGH)
    lower = LIMB * np.maximum(share - DENIED, 0.0)
    unshown = np.minimum(UNSHOWN * np.maximum(bare[_FOREARMS] - BARE, 0.0), AT_MOST)
    lower[_FOREARMS] = np.maximum(lower[_FOREARMS], unshown)
    base = wrong if not np.isfinite(usual) else usual
    return np.asarray(lower[LANDMARK_BONES] + BODY * max(wrong - min(1.15 * base + 0.01, NOBODYS), 0.0))


def certainty_of(
    performer: Performer, solution: Solution[Pose], hidden: Floats, doubt: Floats, wrong: float
) -> tuple[Floats, Floats]:
    """Covariance (34, 34) of the degrees of freedom, and standard deviations (16,) in m of the joints.

    Parameters
    ----------
    solution : of the frame; its surface cost is in m² per standard sample.
    hidden : (16,) s since each joint was seen.
    doubt : (16,) m, how far other poses of the limb that explain the frame as well have the joint.
    wrong : share of pixels explained wrongly.
    """
    residual = solution.system.costs.get("surface", 0.0) / (2.0 * STANDARD)
    variance = CLUMP * (residual + SHAPE**2) * (1.0 + 4.0 * wrong)
    covariance = solution.covariance(variance)
    std = np.empty(len(LANDMARK_BONES))
    place, moving = landmarks(performer, solution.state), twists(performer, solution.state)
    spreads(covariance, moving, MOVED_FIRST, BONES_MOVED, LANDMARK_BONES, place, std)
    stray = REACH * (1.0 - np.exp(-STRAY * hidden / REACH))
    return covariance, np.sqrt(std**2 + _WITHIN**2 + stray**2 + doubt**2)
