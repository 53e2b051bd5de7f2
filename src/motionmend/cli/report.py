"""`motionmend report`: a page that plays recordings."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from ..batch import Failure
from ..errors import FileError, MotionMendError, UsageError
from .inputs import gather
from .options import Debug, Files, Force, Rate, SkeletonFile
from .output import exit_code, say, tell_failure, tell_guesses

if TYPE_CHECKING:
    from ..bodies.motion import Markers, Motion
    from ..bodies.postures import Postures


def report(
    *files: Files,
    out: Annotated[Path, Parameter(name=["-o", "--out"], help="The page to write; ends in .html.")],
    fps: Rate = None,
    skeleton: SkeletonFile = None,
    force: Force = False,
    debug: Debug = False,
) -> int:
    """Write one self-contained page that plays the recordings over each other, with curves and a scrubber.

    With depth folders (or UTD-MHAD *_depth.mat) among FILES the joints of the tables are also drawn over the images:
    as the camera saw them, with the edges in depth, and from the side. Where a NAME.mend.json stands beside a
    recording, what it says of the repair is shown. Lengths are in metres, angles in degrees.
    """
    from ..io import READABLE
    from ..io.sensor import SENSOR_ENDINGS
    from ..report import html_report
    from .report_pictures import pictures_of

    if out.suffix.lower() != ".html":
        raise UsageError(f"-o: a page's name ends in .html, came {out}")
    depth = [file for file in files if _is_depth(file)]
    rest = [file for file in files if file not in depth]
    inputs, refused = gather(rest, (*READABLE, *SENSOR_ENDINGS), meant=meant) if rest or not depth else ([], [])
    if out.exists() and not force:
        raise FileError(f"{out} is there already: --force overwrites it")
    shown: list[tuple[str, Motion | Markers]] = []
    facts: dict[str, str] = {}
    guesses: dict[str, list[Path]] = {}
    tables: dict[str, Postures] = {}
    failures = []
    for refusal in refused:
        tell_failure(refusal.path, Failure("FileError", refusal.reason, ""), as_json=False, debug=debug)
    for one in inputs:
        try:
            recording, joints = drawable(one.path, fps, skeleton)
            if joints is not None:
                tables[str(one.place)] = joints
            facts |= _facts_beside(one.path)
        except MotionMendError as error:
            failures.append(Failure(type(error).__name__, str(error), ""))
            tell_failure(one.path, failures[-1], as_json=False, debug=debug)
            continue
        shown.append((str(one.place), recording))
        for guess in recording.guesses:
            guesses.setdefault(guess, []).append(one.path)
    pictures: list[tuple[str, bytes]] = []
    for path in depth:
        try:
            pictures += pictures_of(path, tables)
        except MotionMendError as error:
            failures.append(Failure(type(error).__name__, str(error), ""))
            tell_failure(path, failures[-1], as_json=False, debug=debug)
    if not shown:
        raise FileError(f"{out} not written: none of the recordings given can be shown")
    out.parent.mkdir(parents=True, exist_ok=True)
    html_report(out, shown, facts=facts, pictures=pictures)
    tell_guesses(guesses)
    say(f"{len(shown)} recording{'s'[: len(shown) != 1]}: {out}")
    return exit_code(failures, refused)


def _is_depth(path: Path) -> bool:
    from ..io.depth import looks_like_depth_folder
    from ..io.sensor import kind_of

    if path.suffix.lower() == ".mat" and path.is_file():
        return kind_of(path) == "depth"
    return looks_like_depth_folder(path)


def drawable(path: Path, fps: float | None, skeleton: Path | None) -> "tuple[Motion | Markers, Postures | None]":
    """A recording as it can be drawn: joints of a sensor as markers at an even rate, and as they are."""
    from ..bodies.motion import Markers
    from ..io import read
    from ..io.sensor import read_postures
    from ..io.sensor_source import USUAL_FPS
    from ..io.vertical import up_of
    from .compare_joints import holds_joints

    if not holds_joints(path):
        return read(path, fps=fps, skeleton=skeleton), None
    postures = read_postures(path, fps=fps)
    rate = postures.fps if postures.frames > 1 and postures.fps > 0 else USUAL_FPS
    up, _ = up_of(postures.names, postures.positions)
    return Markers(postures.names, postures.positions, rate, up=up, guesses=postures.guesses), postures


def meant(path: Path) -> bool:
    """Whether a file found in a folder can be drawn."""
    from ..io import READABLE, looks_meant
    from ..io.sensor import looks_like_sensor

    return (path.suffix.lower() in READABLE and looks_meant(path)) or looks_like_sensor(path)


def _facts_beside(path: Path) -> dict[str, str]:
    """What NAME.mend.json says about a recording's repair, as lines for the page; empty when there is none."""
    stem = path.with_suffix("")
    for beside in (stem.with_name(stem.name + ".mend.json"), path.with_name(path.name + ".mend.json")):
        if beside.is_file():
            break
    else:
        return {}
    try:
        said = json.loads(beside.read_text("utf-8"))
        if said["output"] != path.name:  # of a recording of the same name in another format
            return {}
        counts = ", ".join(f"{count} {name.replace('_', ' ')}" for name, count in said["counts"].items())
        model = said["model"]
        return {
            f"{path.name}: repaired from": str(said["input"]),
            f"{path.name}: method": str(said["method"]),
            f"{path.name}: samples": counts,
            **({f"{path.name}: model": f"{model['file']}, SHA-256 {model['sha256']}"} if model else {}),
            **{f"{path.name}: warning {n}": str(line) for n, line in enumerate(said["warnings"], start=1)},
        }
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise FileError(
            f"{beside}: a .mend.json as `motionmend denoise` writes it was wanted ({error!r}): move it away"
        ) from None
