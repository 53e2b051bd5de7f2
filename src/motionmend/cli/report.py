"""`motionmend report`: a page that plays recordings."""

import json
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from ..errors import FileError, MotionMendError, UsageError, counted
from .drawable import failed, read_drawable
from .options import AsJson, Debug, Files, Force, Rate, SkeletonFile
from .output import exit_code
from .speech import json_line, say

if TYPE_CHECKING:
    from ..bodies.motion import Markers, Motion, Repaired


def report(
    *files: Files,
    out: Annotated[Path, Parameter(name=["-o", "--out"], help="The page to write; ends in .html.")],
    fps: Rate = None,
    skeleton: SkeletonFile = None,
    as_json: AsJson = False,
    force: Force = False,
    debug: Debug = False,
) -> int:
    """Write one self-contained page that plays the recordings over each other, with curves and a scrubber.

    With depth folders (or UTD-MHAD *_depth.mat) among FILES the joints of the tables are also drawn over the images:
    as the camera saw them, with the edges in depth, and from the side. Where a NAME.mend.json stands beside a
    recording, what it says of the repair is shown. Lengths are in metres, angles in degrees.
    """
    from ..report import html_report
    from .report_pictures import pictures_of

    if out.suffix.lower() != ".html":
        raise UsageError(f"-o: a page's name ends in .html, came {out}")
    depth = [file for file in files if _is_depth(file)]
    rest = [file for file in files if file not in depth]
    if out.exists() and not force:
        raise FileError(f"{out} is there already: --force overwrites it")
    tell = partial(failed, debug=debug, as_json=as_json)
    read = partial(read_drawable, rest, fps, skeleton, debug=debug, as_json=as_json)
    drawn, failures, refused = read() if rest or not depth else ([], [], [])
    shown: list[tuple[str, Motion | Markers]] = []
    sources: list[Path] = []
    facts: dict[str, str] = {}
    repaired: Repaired[Any] | None = None  # of several the last, for the page has one line of samples' origins
    for one in drawn:
        try:
            said, done = _said_beside(one.path, one.recording)
        except FileError as error:
            failures.append(tell(one.path, error))
            continue
        facts |= said
        repaired = done or repaired
        shown.append((one.name, one.recording))
        sources.append(one.path)
    tables = {one.name: one.joints for one in drawn if one.joints is not None}
    pictures: list[tuple[str, bytes]] = []
    pictured: list[Path] = []
    for path in depth:
        try:
            found, damaged = pictures_of(path, tables)
            pictures += found
            pictured.append(path)
            for warning in damaged:
                say(f"warning ({path}): {warning}")
        except MotionMendError as error:
            failures.append(tell(path, error))
    if depth and not rest:
        named = ", ".join(map(str, depth))
        raise FileError(f"{out} not written: {named} holds images alone: give the file tracked from them too (.csv)")
    if not shown:  # of each of them it was told why
        why = f"{out} not written: none of the recordings given can be shown"
        for source in pictured if as_json else ():
            print(json_line({"input": source, "error": why}))
        say(f"motionmend: {why}")
        return exit_code(failures, refused)
    out.parent.mkdir(parents=True, exist_ok=True)
    html_report(out, shown, repaired=repaired, facts=facts, pictures=pictures)
    for source in (*sources, *pictured) if as_json else ():
        print(json_line({"input": source, "output": out}))
    say(f"{counted(len(shown), 'recording')}: {out}")
    return exit_code(failures, refused)


def _is_depth(path: Path) -> bool:
    from ..io.depth import looks_like_depth_folder
    from ..io.sensor import kind_of

    if path.suffix.lower() == ".mat" and path.is_file():
        return kind_of(path) == "depth"
    return looks_like_depth_folder(path)


def _said_beside(path: Path, recording: "Motion | Markers") -> "tuple[dict[str, str], Repaired[Any] | None]":
    """What NAME.mend.json says about a recording: lines for the page, and what became of every sample."""
    from .provenance import repaired_from

    stem = path.with_suffix("")
    for beside in (stem.with_name(stem.name + ".mend.json"), path.with_name(path.name + ".mend.json")):
        if beside.is_file():
            break
    else:
        return {}, None
    try:
        said = json.loads(beside.read_text("utf-8-sig"))
        if said["output"] != path.name:  # of a recording of the same name in another format
            return {}, None
        counted_up = dict(said.get("counts", {}))
        moved = counted_up.pop("moved_cm", None)
        counts = ", ".join(f"{count} {name.replace('_', ' ')}" for name, count in counted_up.items())
        counts += "" if moved is None else f", moved by {moved} cm"
        model, done = said.get("model"), repaired_from(said, recording)
        made = "made" if "steps" in said else "tracked" if "lost" in said else "repaired" if done else "corrected"
        told = {} if done else {f"warning {n}": str(line) for n, line in enumerate(said["warnings"], start=1)}
        facts = {
            f"{made} from": str(said["input"]),
            **({"method": str(said["method"])} if said["method"] and not done else {}),
            **({"samples": counts} if counts else {}),
            **({"model": f"{model['file']}, SHA-256 {model['sha256']}"} if model else {}),
            **told,
        }
        return {f"{path.name}: {name}": line for name, line in facts.items()}, done
    except (OSError, ValueError, KeyError, TypeError, IndexError) as error:
        raise FileError(
            f"{beside}: a .mend.json as `motionmend denoise` writes it was wanted ({error!r}): move it away"
        ) from None
