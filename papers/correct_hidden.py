"""Section 4.4 in kind: joints the sensor guesses, and knowing which they are

Limbs of real recordings fail on purpose for a third of a second to three seconds: drawn to the trunk with 3 to 8 cm of
shaking, or taken for the other side's. Once with tracking states, once without, and live.
"""

from collections import defaultdict
from pathlib import Path

from sklearn.metrics import roc_auc_score

from motionmend.evaluate.sensor_failures import fail

from .common import Findings, Table
from .correct_common import ABOUT, away, kinect_in, left_out, means

RIVALS = ("one-euro", "savgol", "kalman", "constant", "ridge", "gp", "exemplar")
LIVE = {"live": 0, "live, 0.1 s ahead": 3}
EVERY = 4


def run(mocap: Path, pictures: Path) -> Findings:
    """Error on joints that fail and on those that do not, and how well reliability tells them apart."""
    del pictures
    bad: dict[str, list[float]] = defaultdict(list)
    honest: dict[str, list[float]] = defaultdict(list)
    whole: dict[str, list[float]] = defaultdict(list)
    told: dict[str, list[float]] = defaultdict(list)
    failing: dict[str, list[bool]] = defaultdict(list)
    for seed, (model, one) in enumerate(left_out(kinect_in(mocap))[::EVERY]):
        truth = one.pair.truth
        for states in (True, False):
            failed = fail(one.pair.sensor, seed=seed, states=states)
            kind = "with states" if states else "without states"
            found = model.correct(failed.postures)
            methods = {"default, " + kind: found.positions}
            if states:
                methods["raw"] = failed.postures.positions
                methods |= {name: model.correct(failed.postures, method=name).positions for name in RIVALS}
                methods |= {name: model.correct(failed.postures, look_ahead=n).positions for name, n in LIVE.items()}
            for name, positions in methods.items():
                bad[name].append(away(truth, positions, failed.affected))
                honest[name].append(away(truth, positions, ~failed.affected))
                whole[name].append(away(truth, positions))
            there = failed.postures.present
            told[kind] += (1.0 - found.reliability[there]).tolist()
            failing[kind] += failed.affected[there].tolist()
    affected, others, overall = means(bad), means(honest), means(whole)
    best = min(RIVALS, key=lambda name: affected[name])
    best_honest = min(others[name] for name in RIVALS)
    values = {
        "raw": affected["raw"],
        "best": affected[best],
        "with_states": affected["default, with states"],
        "without_states": affected["default, without states"],
        "honest": others["default, with states"],
        "honest_of_best": others["default, with states"] / best_honest,
        "of_raw": affected["default, with states"] / affected["raw"],
        "of_best": affected["default, with states"] / affected[best],
        "of_raw_without": affected["default, without states"] / affected["raw"],
        "of_best_without": affected["default, without states"] / affected[best],
        "live": affected["live"],
        "ahead": affected["live, 0.1 s ahead"],
        "live_honest": others["live"],
        "ahead_honest": others["live, 0.1 s ahead"],
        "ahead_of_live": affected["live, 0.1 s ahead"] / affected["live"],
        "ahead_all": overall["live, 0.1 s ahead"] / overall["live"],
        "auc": float(roc_auc_score(failing["with states"], told["with states"])),
        "auc_without": float(roc_auc_score(failing["without states"], told["without states"])),
    }
    rows = tuple((name, f"{affected[name]:.1f}", f"{others[name]:.2f}") for name in sorted(affected, key=affected.get))
    table = Table("Mean joint error, cm", ("method", "joints that fail", "the others"), rows)
    return Findings(values, (ABOUT, f"The best rival on joints that fail is `{best}`."), (table,))
