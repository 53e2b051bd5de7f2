"""What a pipeline's TOML file says: the models and options of each step."""

import tomllib
from pathlib import Path
from typing import Annotated, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, StrictBool, ValidationError, field_validator

from ..errors import FileError, UsageError

NO_DENOISE = "none"
_PLACES = {"tracker": "track", "corrector": "correct", "denoiser": "denoise"}  # kinds of models and their sections

_Number: TypeAlias = Annotated[float, Field(strict=True, allow_inf_nan=False)]  # TOML has numbers: a text is none


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, protected_namespaces=())


class TrackSection(_Section):
    """Options of `motionmend track`; `start` is the pose of frame 0 of one take."""

    model: Path | None = None
    skeleton: Path | None = None
    start: Path | None = None
    body: Path | None = None
    preset: str = "default"
    terms: tuple[str, ...] | None = None

    @field_validator("terms", mode="before")
    @classmethod
    def _as_on_the_command_line(cls, value: object) -> object:
        """A list, or the same in one text with commas."""
        return tuple(term.strip() for term in value.split(",")) if isinstance(value, str) else value


class CorrectSection(_Section):
    """Options of `motionmend correct`."""

    model: Path | None = None
    method: str = "default"
    online: StrictBool = False


class DenoiseSection(_Section):
    """Options of `motionmend denoise`; method "none" leaves the step out."""

    model: Path | None = None
    method: str = "adaptive"
    robust: str = "welsch"
    max_std: _Number | None = Field(default=None, ge=0)  # degrees for joint angles, m for joints and markers
    lag: _Number | None = Field(default=None, ge=0)  # s
    footskate: StrictBool = False


class PipelineConfig(_Section):
    """All of a pipeline.

    `fps` is the rate in Hz of files that carry none, `format` what is written of depth and of sensors' skeletons.
    """

    fps: _Number | None = Field(default=None, gt=0)
    format: Literal["csv", "bvh", "amc"] | None = None
    track: TrackSection = TrackSection()
    correct: CorrectSection = CorrectSection()
    denoise: DenoiseSection = DenoiseSection()


def read_config(path: Path) -> PipelineConfig:
    """The configuration in a TOML file; paths in it are relative to the file.

    Raises
    ------
    UsageError : no such file, not TOML, an entry that is not known, or a value that cannot be.
    """
    try:
        found = tomllib.loads(path.read_text("utf-8-sig"))
    except OSError as error:
        raise UsageError(f"--config {path}: cannot be read: {error.strerror or error}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise UsageError(f"{path}: TOML was wanted, this is none: {error}") from None
    try:
        config = PipelineConfig.model_validate(found)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        raise UsageError(f"{path}: {where}: {_reason(first['loc'], first['type'], first['msg'])}") from None
    return _located(config, path.parent)


def _reason(where: tuple[int | str, ...], kind: str, message: str) -> str:
    if kind == "model_type":
        return f"a section was wanted: [{where[0]}] in a line of its own, and its entries below"
    if kind != "extra_forbidden":
        return message
    sections: dict[str, type[_Section]] = {"track": TrackSection, "correct": CorrectSection, "denoise": DenoiseSection}
    if len(where) > 1:
        return f"no such entry; [{where[0]}] takes {', '.join(sections[str(where[0])].model_fields)}"
    return f"no such entry; there are {', '.join(PipelineConfig.model_fields)}, the last three being sections"


def _located(config: PipelineConfig, folder: Path) -> PipelineConfig:
    """The same with paths as this process finds them."""
    sections: dict[str, _Section] = {}
    for name in ("track", "correct", "denoise"):
        section = getattr(config, name)
        paths = {key: folder / value for key, value in section if isinstance(value, Path)}
        sections[name] = section.model_copy(update=paths)
    return config.model_copy(update=sections)


def with_models(config: PipelineConfig, models: tuple[Path, ...]) -> PipelineConfig:
    """The configuration with models put in by what each is; one given here goes before the file's.

    Raises
    ------
    FileError : no model.
    UsageError : two of one kind.
    """
    from ..io.model import load_model

    seen: set[str] = set()
    for path in models:
        kind = load_model(path).kind
        if kind not in _PLACES:
            raise FileError(f"{path}: one of {', '.join(_PLACES)} was wanted, came {kind!r}: update motionmend")
        if kind in seen:
            raise UsageError(f"-m: one {kind} was wanted, came two")
        seen.add(kind)
        section = getattr(config, _PLACES[kind])
        config = config.model_copy(update={_PLACES[kind]: section.model_copy(update={"model": path})})
    return config


def put_aside(config: PipelineConfig, used: PipelineConfig) -> tuple[str, ...]:
    """A line about each model of a configuration in whose place another is `used`."""
    pairs = [(getattr(used, section).model, getattr(config, section).model) for section in _PLACES.values()]
    return tuple(f"{new} is used (-m), not {old} of --config" for new, old in pairs if old is not None and new != old)
