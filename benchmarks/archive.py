"""A recording of a million frames repaired at once: the memory that it takes, and the frames a second."""

from . import memory
from .adaptive import learned
from .metric import Metric
from .timing import Plan

FRAMES = 100_000, 1_000_000


def run(plan: Plan) -> list[Metric]:
    """The adaptive repair of two lengths; whatever the plan, for these are what is asked."""
    model, found = learned(), []
    for frames in FRAMES:
        took = memory.measure_adaptive(frames, model)
        key = f"archive.{frames}"
        found += [*took.info(key), Metric(f"{key}.rate", frames / took.seconds, "frames/s", "info")]
    return found
