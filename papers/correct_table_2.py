"""Table 2 in kind: one mixed database against one for each movement"""

from collections import defaultdict
from itertools import chain
from pathlib import Path

from .common import Findings, Table
from .correct_common import ABOUT, MOVEMENTS, away, episodes, folds, kinect_in, learned, means


def run(mocap: Path, pictures: Path) -> Findings:
    """Error of the mixed corrector and of correctors that know only the movement at hand."""
    del pictures
    kinect = kinect_in(mocap)
    mixed: dict[str, list[float]] = defaultdict(list)
    alone: dict[str, list[float]] = defaultdict(list)
    for people in folds(episodes(kinect)):
        for one in episodes(kinect):
            if one.person not in people:
                continue
            for errors, model in (
                (mixed, learned(kinect, people)),
                (alone, learned(kinect, people, one.movement)),
            ):
                errors[one.movement].append(away(one.pair.truth, model.correct(one.pair.sensor).positions))
    of_mixed, of_alone = means(mixed), means(alone)
    total = means({"mixed": list(chain(*mixed.values())), "alone": list(chain(*alone.values()))})
    rows = tuple((MOVEMENTS[m], f"{of_mixed[m]:.2f}", f"{of_alone[m]:.2f}") for m in sorted(of_mixed))
    return Findings(
        {"mixed": total["mixed"], "alone": total["alone"], "ratio": total["mixed"] / total["alone"]},
        (ABOUT,),
        (Table("Mean joint error, cm", ("movement", "mixed database", "this movement alone"), rows),),
    )
