"""What the scripts on correction share: UI-PRMD's pairs, people left out, errors."""

import csv
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from motionmend.arrays import Bools, Floats
from motionmend.bodies.postures import Postures
from motionmend.correct.classic import Samples
from motionmend.correct.corrector import Corrector, CorrectorModel, Pair
from motionmend.correct.learning import lessons, offset_samples
from motionmend.correct.pairs import match, strange
from motionmend.errors import FileError
from motionmend.io.sensor import read_postures
from motionmend.io.truth import read_truth

MOVEMENTS = {
    "m01": "deep squat",
    "m02": "hurdle step",
    "m03": "inline lunge",
    "m04": "side lunge",
    "m05": "sit to stand",
    "m06": "straight leg raise",
    "m07": "shoulder abduction",
    "m08": "shoulder extension",
    "m09": "internal and external rotation",
    "m10": "shoulder scaption",
}
SKIPPED = 120  # mm off by the notes' rough fit: "skip" (kinect/FORMATS.md, section 1)
ABOUT = (
    "UI-PRMD: Kinect v2 and Vicon recordings of the same movements. The truth is brought to the sensor's frame by one rigid "
    "fit per episode, computed on the raw sensor and used for all methods; the truth are markers on the skin. Two people "
    "are left out at a time and corrected by what the others teach."
)


@dataclass(frozen=True, eq=False)
class Episode:
    """One movement of one person, seen by both systems.

    `doubted`: the data's own notes would have it skipped. It is learned from and corrected all the same, and judged apart.
    """

    movement: str
    person: str
    pair: Pair
    doubted: bool


@cache
def episodes(kinect: Path) -> tuple[Episode, ...]:
    """All pairs that belong together, by movement, person and repetition."""
    folder = kinect / "uiprmd"
    files = sorted((folder / "Kinect" / "Positions").glob("*_positions.txt.gz"))
    if not files:
        raise FileError(f"{folder} was to hold pairs of recordings, there are none: give the folder that has them")
    matched = [match(read_postures(one), read_truth(folder / "Vicon" / "Positions" / one.name)) for one in files]
    doubted = _doubted(kinect)
    return tuple(
        Episode(*file.name.split("_")[:2], one.pair, file.relative_to(kinect).as_posix() in doubted)
        for file, one, why in zip(files, matched, strange(matched), strict=True)
        if not why
    )


def _doubted(kinect: Path) -> frozenset[str]:
    """Files of UI-PRMD that the notes beside the data say to skip."""
    with (kinect / "index.csv").open(newline="") as table:
        said = {row["file"]: re.search(r"rough rigid err (\d+)mm", row["notes"]) for row in csv.DictReader(table)}
    return frozenset(file for file, error in said.items() if error is not None and int(error[1]) > SKIPPED)


def folds(all_episodes: Sequence[Episode], together: int = 2) -> list[tuple[str, ...]]:
    """People, two at a time or so many."""
    people = sorted({one.person for one in all_episodes})
    return [tuple(people[k : k + together]) for k in range(0, len(people), together)]


@cache
def learned(kinect: Path, without: tuple[str, ...], movement: str = "") -> CorrectorModel:
    """A corrector learned from everybody else, of one movement or of all."""
    taught = [one for one in episodes(kinect) if one.person not in without and one.movement.startswith(movement)]
    return Corrector().fit([one.pair for one in taught])


def left_out(kinect: Path, together: int = 2) -> list[tuple[CorrectorModel, Episode]]:
    """Every episode with the corrector that has not seen its person, nor those left out together with it."""
    found = []
    for people in folds(episodes(kinect), together):
        model = learned(kinect, people)
        found += [(model, one) for one in episodes(kinect) if one.person in people]
    return found


def samples_of(model: CorrectorModel, pairs: Sequence[Pair]) -> Samples:
    """Postures of these pairs and their offsets from the truth, in standard form, as the model's methods see them."""
    taught, _ = lessons(pairs, model.watcher.body)
    return Samples(*offset_samples(taught))


def away(truth: Postures, other: Floats, where: Bools | None = None) -> float:
    """Mean distance from the truth in cm over joints that have one; `where` (T, J) picks samples, NaN if none."""
    chosen = truth.present if where is None else truth.present & where
    return float(100.0 * np.linalg.norm(other - truth.positions, axis=2)[chosen].mean()) if chosen.any() else np.nan


def means(errors: Mapping[str, Sequence[float]]) -> dict[str, float]:
    """The mean of each list, NaN left out."""
    return {name: float(np.nanmean(values)) for name, values in errors.items()}


def kinect_in(mocap: Path) -> Path:
    """The folder of depth sensors' recordings beside that of motion capture."""
    return mocap.parent / "kinect"
