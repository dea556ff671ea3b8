"""What records must look like: an invalid one is ignored, and its view is rendered again.

The models say what readers rely on; what else stands in a record is let through.
"""

import json
import os
from pathlib import Path
from typing import Annotated, Any, Final

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from openrooms_usd.errors import InputError
from openrooms_usd.untrusted import read_text

Record = dict[str, Any]

_Count = Annotated[int, Field(ge=0, le=2**63 - 1)]
_Rows = list[list[float]]


class _Part(BaseModel):
    model_config = ConfigDict(strict=True, frozen=True, extra="allow", allow_inf_nan=False)


class FileEntry(_Part):
    """A file of a render."""

    sha256: str
    bytes: _Count


class ChannelEntry(_Part):
    """How good a channel is."""

    estimated_robust_error: float | None


class ViewEntry(_Part):
    """What the manifest says of a view."""

    resolution: list[int]
    K: _Rows
    world_from_camera: _Rows
    channels: dict[str, ChannelEntry]


class Quality(_Part):
    """What a look at a view found."""

    measures: dict[str, float | int]
    faults: list[str]


class Rejection(_Part):
    """A camera that was left out."""

    camera: str
    world_from_camera: _Rows
    faults: list[str]


class ViewRecord(_Part):
    """A finished view."""

    key: str
    unit: str
    room: str
    variant: str
    split: str
    source: dict[str, Any]
    entry: ViewEntry
    told: list[dict[str, str]]
    quality: Quality
    rejected: list[Rejection]
    pixels: dict[str, _Count]
    materials: dict[str, _Count] = {}
    depth: list[_Count] = []
    files: dict[str, FileEntry]


class ReportEntry(_Part):
    """What became of every prim."""

    approximated: _Count
    losses: list[dict[str, str]]


class LightEntry(_Part):
    """A light of a scene."""

    kind: str
    on: bool
    lumen: float
    kelvin: float | None = None


class SceneEntry(_Part):
    """What the manifest says of all views."""

    generator: str = ""
    renderer: dict[str, str] = {}
    method: str = ""
    stop: dict[str, float] = {}
    bounces: int | None = None
    legend: dict[str, dict[str, str]] = {}
    lights: list[LightEntry] = []


class SceneRecord(_Part):
    """What the views of a job share."""

    key: str
    type: str = ""
    entry: SceneEntry
    report: ReportEntry
    licences: list[str]
    files: dict[str, FileEntry]


class FailureRecord(_Part):
    """Why a view could not be made."""

    key: str
    code: str
    reason: str
    attempts: _Count


class TimingRecord(_Part):
    """How long a view took, seconds."""

    key: str
    compose: float = 0.0
    translation: float = 0.0
    render: float = 0.0
    output: float = 0.0
    threads: _Count = 1
    channels: dict[str, float] = {}


LEFT_OUT: Final = "left_out"
"""The code of failures of rooms that were left out on purpose: they are not tried again."""

SCENE: Final = "scene"
"""The name of the record of what the views of a job share."""


def read_record(path: Path, key: str, model: type[_Part]) -> Record | None:
    """A record; None where there is none, it is damaged, or it is of another plan.

    Args:
        path: The file.
        key: That of its job.
        model: What it must look like.
    """
    if not os.path.lexists(path):
        return None
    try:
        found = json.loads(read_text(path, "json"))
        model.model_validate(found)
    except (InputError, ValidationError, ValueError, RecursionError):
        return None
    return dict(found) if found["key"] == key else None
