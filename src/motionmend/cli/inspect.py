"""`motionmend inspect`: what is in a file."""

import os
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import counted
from .compare_joints import SENSORS, TEXTS
from .inputs import Input, Refusal, ending, gather, place_among
from .options import WORKING, AsJson, Files, Rate, SkeletonFile, Working
from .output import Done, work

if TYPE_CHECKING:
    from ..bodies.motion import Markers, Motion
    from ..bodies.skeleton import Skeleton
    from .findings import Jump

SHOWN_FRAMES = 8  # frames of a jump listed for people; JSON has them all


def inspect(
    *files: Files,
    fps: Rate = None,
    skeleton: SkeletonFile = None,
    as_json: AsJson = False,
    working: Working = WORKING,
) -> int:
    """Say what files hold: kind, channels, rate, gaps, jumps, units, and what to distrust.

    Recordings, depth folders, joints as sensors and trackers report them, skeletons (.asf) and models (.mend).
    Lengths are in metres, angles in degrees, times in seconds; frames are counted from 0.
    """
    given = [working.reachable(file) for file in files]
    inputs, refused = _inputs(given)
    task = partial(look, fps=fps, skeleton=skeleton and working.reachable(skeleton))
    return work(task, inputs, name=_path, working=working, as_json=as_json, refused=refused, given=given)


def _inputs(given: list[Path]) -> tuple[list[Input], list[Refusal]]:
    """Files as they are named, and depth folders as one input each, also those found in a folder."""
    from ..io import READABLE, looks_meant
    from ..io.depth import looks_like_depth_folder

    def inside(path: Path) -> bool:
        return any(looks_like_depth_folder(folder) for folder in path.parents)

    depth = [path for path in given if looks_like_depth_folder(path)]
    rest = [path for path in given if path not in depth]
    inputs = [Input(path, Path(path.resolve().name)) for path in depth]
    if not rest and inputs:
        return inputs, []
    nested = [
        Input(one, one)
        for folder in rest
        if os.path.isdir(folder)
        for one in sorted({file.parent for file in folder.rglob("camera.json")})
    ]
    files = {*READABLE, ".asf", ".mend", *SENSORS}
    found, refused = gather(rest, files, meant=lambda path: inside(path) or _meant(path, looks_meant))
    refused = [refusal for refusal in refused if not any(refusal.path in one.path.parents for one in nested)]
    every = [*inputs, *nested, *(one for one in found if not inside(one.path))]
    return sorted(every, key=lambda one: place_among(one.path, given)), refused


def _meant(path: Path, looks_meant: Callable[[Path], bool]) -> bool:
    """Whether a file found in a folder is to be looked at: reports of our own commands are not."""
    from ..io.sensor import looks_like_sensor

    if ending(path) in SENSORS:
        return _is_clip(path) or looks_like_sensor(path)
    return looks_meant(path) or (ending(path) in TEXTS and looks_like_sensor(path))


def _is_clip(path: Path) -> bool:
    """Whether a .mat has a clip of depth that can be read by itself; other depth in a .mat goes with more files."""
    from ..io.utdmhad import variables_of

    return ending(path) == ".mat" and "d_depth" in variables_of(path)


def _is_depth(path: Path) -> bool:
    from ..io.sensor import kind_of

    return ending(path) == ".mat" and kind_of(path) == "depth"


def _is_truth(path: Path) -> bool:
    """Whether a text is what an optical system recorded beside a sensor."""
    from ..io.sensor import kind_of

    return ending(path) == ".txt" and path.is_file() and kind_of(path) in ("uiprmd markers", "keraal bodies")


def look(item: Input, *, fps: float | None, skeleton: Path | None) -> Done:
    """Facts about one file."""
    from .compare_joints import holds_joints
    from .inspect_camera import depth_facts, joint_facts

    kind = ending(item.path)
    if item.path.is_dir() or (kind == ".mat" and _is_depth(item.path)):
        facts = depth_facts(item.path)
        return Done(facts, _table(facts), guesses=facts["guesses"])
    if kind in SENSORS or holds_joints(item.path) or _is_truth(item.path):
        facts = joint_facts(item.path, fps)
        return Done(facts, _table(facts), guesses=facts["guesses"])
    if kind == ".asf":
        return _skeleton(item.path)
    if kind == ".mend":
        return _model(item.path)
    return _recording(item.path, fps, skeleton)


def _recording(path: Path, fps: float | None, skeleton: Path | None) -> Done:
    import numpy as np

    from ..bodies.motion import Motion
    from ..io import read
    from .findings import FAST_MARKER, jumps, labels, leaps, listed, missing_shares, suspicions
    from .provenance import numbering

    recording = read(path, fps=fps, skeleton=skeleton)
    moving = isinstance(recording, Motion)
    times = np.arange(recording.frames) / recording.fps
    jumped = (
        jumps(recording)
        if isinstance(recording, Motion)
        else leaps(recording.names, recording.positions, times, FAST_MARKER)
    )
    share = 1.0 - float(recording.present.mean()) if recording.present.size else 0.0
    facts: dict[str, Any] = {
        "input": path,
        "kind": "motion" if moving else "markers",
        "format": ending(path).removeprefix("."),
        "fps": recording.fps,
        "frames": recording.frames,
        **numbering(recording),
        "duration": recording.frames / recording.fps,
        "units": {"length": "m", "angle": "deg", "duration": "s", **_file_unit(recording)},
        "channels" if moving else "markers": labels(recording.channels),
        **({"joints": recording.skeleton.names} if isinstance(recording, Motion) else {}),
        "up": recording.skeleton.up if isinstance(recording, Motion) else recording.up,
        "share_missing": share,
        "missing": missing_shares(recording),
        "jumps": listed(jumped),
        "suspicious": [{"name": s.name, "what": s.what, "detail": s.detail} for s in suspicions(recording)],
        "warnings": [*recording.warnings, *_warnings(recording.frames, share, jumped if moving else ())],
        "guesses": recording.guesses,
    }
    return Done(facts, _table(facts), guesses=recording.guesses)


def _warnings(frames: int, share_missing: float, jumped: "Sequence[Jump]") -> list[str]:
    """What will matter to whoever works on the recording."""
    said = []
    if frames < 2:
        said.append(f"{counted(frames, 'frame')}: nothing moves in it")
    if share_missing > 0.5:
        said.append(f"{100 * share_missing:.0f} % of all samples are missing")
    turned = sum(sum(jump.wraps) for jump in jumped)
    flipped = sum(len(jump.frames) for jump in jumped) - turned
    if turned:
        said.append(f"{turned} jumps by a full turn: an angle went past 180 degrees and came out at -180")
    if flipped:
        said.append(f"{flipped} jumps above 60 degrees that are no full turn: Euler flips or outliers")
    return said


def _file_unit(recording: "Motion | Markers") -> dict[str, float]:
    """The file's own unit of length in metres, where its reader keeps it."""
    source = recording.source
    metres = getattr(getattr(source, "asf", source), "metres", None)
    return {} if metres is None else {"file_length_in_m": float(metres)}


def _skeleton(path: Path) -> Done:
    from ..io.asf import read_asf, skeleton_of

    asf = read_asf(path)
    body = skeleton_of(asf)
    facts = {
        "input": path,
        "kind": "skeleton",
        "format": "asf",
        "bones": len(asf.bones),
        "dofs": len(body.dof_names),
        "joints": body.names,
        "channels": body.dof_names,
        "limits": _limits(body),
        "units": {
            "length": "m",
            "angle": "deg",
            "file_length_in_m": asf.metres,
            "file_angle": "deg" if asf.degrees else "rad",
        },
        "up": body.up,
        "warnings": [],
        "guesses": asf.guesses,
    }
    return Done(facts, _table(facts), guesses=asf.guesses)


def _limits(body: "Skeleton") -> dict[str, list[float] | None]:
    """Lower and upper limit of each channel in degrees and metres, None where there is none."""
    import numpy as np

    from ..bodies.skeleton import ROTATION

    scale = np.where(body.dof_kind == ROTATION, np.degrees(1.0), 1.0)
    bounds = body.limits * scale[:, None]
    return {name: bounds[d].tolist() if np.isfinite(bounds[d]).any() else None for d, name in enumerate(body.dof_names)}


def _model(path: Path) -> Done:
    from ..io.model import load_model
    from ..models import restore

    stored = load_model(path)
    model = restore(stored, path)
    common = {"input": path, "kind": "model", "format": "mend", "model": stored.kind, "sha256": stored.sha256}
    if stored.kind == "tracker":
        facts = {
            **common,
            "poses": len(model.database),
            "detector": model.detector is not None,
            "units": {},
            "warnings": [],
            "guesses": [],
        }
        return Done(facts, _table(facts))
    if stored.kind != "denoiser":
        known = {name: getattr(model, name) for name in ("pairs", "frames") if isinstance(getattr(model, name, 0), int)}
        names = getattr(model, "names", None)
        joints = {} if names is None else {"joints": tuple(names)}
        facts = {**common, **known, **joints, "units": {}, "warnings": getattr(model, "notes", ()), "guesses": []}
        return Done(facts, _table(facts))
    facts = {
        **common,
        "learned_from": "joint angles" if model.layout.kind == "motion" else model.layout.kind,
        "model_fps": model.settings.fps,
        "window": model.settings.window,
        "energy": model.settings.energy,
        "bases": model.bases.count,
        "clips": model.clips,
        "frames": model.frames,
        "channels": model.layout.names,
        "units": {"model_fps": "Hz", "window": "frames at model_fps", "energy": "share of the variance kept"},
        "warnings": model.notes,
        "guesses": [],
    }
    return Done(facts, _table(facts))


def _table(facts: dict[str, Any]) -> str:
    """The facts as lines for people: short ones as `name  value`, long ones summed up."""
    rows = [("file", str(facts["input"])), ("kind", f"{facts['kind']} (.{facts['format']})")]
    plain = (
        "model",
        "sensor",
        "learned_from",
        "pairs",
        "bones",
        "dofs",
        "model_fps",
        "window",
        "energy",
        "bases",
        "clips",
        "poses",
        "detector",
    )
    rows += [
        (name.replace("_", " "), _number(facts[name]))
        for name in plain
        if isinstance(facts.get(name), str | int | float)
    ]
    if facts.get("fps"):
        rows.append(("rate", f"{facts['fps']:g} Hz"))
    if "frames" in facts:
        duration = f" ({facts['duration']:.2f} s)" if "duration" in facts else ""
        rows.append(("frames", f"{facts['frames']}{duration}"))
    if "camera" in facts:
        camera = facts["camera"]
        span = " to ".join(f"{value:.3g}" for value in facts["depth_range"] or ()) or "nothing at any"
        rows.append(("camera", f"{camera['width']} x {camera['height']}, fx {camera['fx']:g}, fy {camera['fy']:g}"))
        rows.append(("depth", f"{span} m, {'with' if facts['color'] else 'no'} colour"))
    for name in ("joints", "channels", "markers"):
        if name in facts:
            rows.append((name, f"{len(facts[name])}: {', '.join(facts[name])}"))
    units = facts["units"].items()
    rows.append(("units", ", ".join(f"{name.replace('_', ' ')} {_number(unit)}" for name, unit in units)))
    rows = [(name, value) for name, value in rows if value]
    if "share_missing" in facts:
        rows += _gaps(facts)
        rows += _sensed(facts)
        rows += _jumps(facts["jumps"]) if facts["kind"] == "motion" else []
        rows += _suspicions(facts["suspicious"])
    rows += [("warning", warning) for warning in facts["warnings"]]
    width = max(len(name) for name, _ in rows)
    return "\n".join(f"{name:<{width}}  {value}" for name, value in rows)


def _gaps(facts: dict[str, Any]) -> list[tuple[str, str]]:
    from .findings import percent

    worst = sorted(((share, name) for name, share in facts["missing"].items() if share > 0), reverse=True)
    return [
        ("missing", percent(facts["share_missing"])),
        *(("", f"{name}: {percent(share)}") for share, name in worst),
    ]


def _sensed(facts: dict[str, Any]) -> list[tuple[str, str]]:
    """What only joints have: states, bones, sides."""
    from .findings import percent

    rows = []
    if facts.get("share_inferred") is not None:
        lost = percent(facts["share_not_tracked"])
        rows.append(("states", f"{percent(facts['share_inferred'])} inferred, {lost} not tracked"))
    if facts.get("bone_variation") is not None:
        worst = max(facts["bones"], key=lambda name: facts["bones"][name]["variation"])
        most = percent(facts["bones"][worst]["variation"])
        rows.append(("bone lengths", f"vary by {percent(facts['bone_variation'])} (median), to {worst} by {most}"))
    if facts.get("swaps"):
        frames = ", ".join(str(frame) for frame in facts["swaps"][:SHOWN_FRAMES])
        more = f" and {len(facts['swaps']) - SHOWN_FRAMES} more" if len(facts["swaps"]) > SHOWN_FRAMES else ""
        rows.append(("swaps", f"left and right change places at frame {frames}{more}"))
    return rows


def _jumps(found: list[dict[str, Any]]) -> list[tuple[str, str]]:
    rows = []
    for channel in dict.fromkeys(jump["channel"] for jump in found):
        own = [jump for jump in found if jump["channel"] == channel]
        turns = sum(jump["wrap"] for jump in own)
        frames = ", ".join(str(jump["frame"]) for jump in own[:SHOWN_FRAMES])
        more = f" and {len(own) - SHOWN_FRAMES} more" if len(own) > SHOWN_FRAMES else ""
        rows.append(("jumps", f"{channel}: {len(own)}, {turns} of them full turns, at frame {frames}{more}"))
    return rows or [("jumps", "none above 60 degrees")]


def _suspicions(found: list[dict[str, str]]) -> list[tuple[str, str]]:
    """One line for each kind of suspicion."""
    kinds = dict.fromkeys(one["what"] for one in found)
    return [
        (kind, "; ".join(f"{one['name']} {one['detail']}" for one in found if one["what"] == kind)) for kind in kinds
    ]


def _number(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _path(item: Input) -> Path:
    return item.path
