"""What a manifest must look like: it is checked whole before any of it is used.

The models say what our readers rely on; what else stands in a manifest is let through. What later
versions added has a default, so that older renders can still be read.
"""

from pathlib import Path, PurePosixPath
from typing import Annotated, Any, Final, Literal

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError
from pydantic_core import ErrorDetails

from openrooms_usd.description.mistakes import shown, written
from openrooms_usd.description.rendering import COMPLETE, REFERENCE, Method, StorageName
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.rotations import is_rotation
from openrooms_usd.rendering.folder import MANIFEST, OPENINGS_FOLDER, load_manifest
from openrooms_usd.rendering.manifest import FORMAT
from openrooms_usd.rendering.scene.lights import Gaussian, LightKind, LightRecord, LobeName
from openrooms_usd.untrusted import is_plain_name

AGAIN: Final = "render again"
# The largest number that a label channel holds exactly.
MOST_LABELS: Final = 2**24

_MOST_SIDE: Final = 2**15
_MOST_PIXELS: Final = 2**27
# How far a matrix may be from orthonormal.
_ORTHONORMAL_TOLERANCE: Final = 1e-3

# Limits that no room reaches, and within which products of a few numbers stay finite.
_Number = Annotated[float, Field(ge=-1e9, le=1e9)]
_Length = Annotated[float, Field(ge=0.0, le=1e9)]
_Light = Annotated[float, Field(ge=-1e30, le=1e30)]
_Factor = Annotated[float, Field(ge=0.0, le=1e30)]
_Count = Annotated[int, Field(ge=0, le=2**63 - 1)]
_Label = Annotated[int, Field(ge=0, le=MOST_LABELS)]
_Row3 = tuple[_Number, _Number, _Number]
_Row4 = tuple[_Number, _Number, _Number, _Number]
_Rows4 = tuple[_Row4, _Row4, _Row4, _Row4]
_Color = tuple[_Light, _Light, _Light]


def _size(size: tuple[int, int]) -> tuple[int, int]:
    if size[0] * size[1] > _MOST_PIXELS:
        raise ValueError(f"expected at most {_MOST_PIXELS:,} pixels")
    return size


def _intrinsics(rows: tuple[_Row3, _Row3, _Row3]) -> tuple[_Row3, _Row3, _Row3]:
    (across, _, _), (tilt, down, _), last = rows
    if min(across, down) < 1e-6 or tilt != 0.0 or last != (0.0, 0.0, 1.0):
        raise ValueError("expected focal lengths above 0 in an upper triangle that ends in 1")
    return rows


def _pose(rows: _Rows4) -> _Rows4:
    if not is_rotation(np.array(rows)[:3, :3], _ORTHONORMAL_TOLERANCE) or rows[3] != (
        0.0,
        0.0,
        0.0,
        1.0,
    ):
        raise ValueError("expected a rotation and a shift")
    return rows


def _frame(rows: _Rows4) -> _Rows4:
    lengths = np.linalg.norm(np.array(rows)[:3, :3], axis=0)
    if np.abs(lengths - 1.0).max() > _ORTHONORMAL_TOLERANCE or rows[3] != (0.0, 0.0, 0.0, 1.0):
        raise ValueError("expected three axes of length 1 and a shift")
    return rows


def _direction(vector: _Row3) -> _Row3:
    if abs(float(np.linalg.norm(vector)) - 1.0) > _ORTHONORMAL_TOLERANCE:
        raise ValueError("expected a vector of length 1")
    return vector


def _plain_name(name: str) -> str:
    if not is_plain_name(name):
        raise ValueError("expected a valid name of a folder")
    return name


def _relative(path: str) -> str:
    parts = path.split("/")
    if len(parts) < 2 or not all(map(is_plain_name, parts)):
        raise ValueError("expected the path of a file in a folder of the render")
    return path


_Name = Annotated[str, AfterValidator(_plain_name)]
_File = Annotated[str, AfterValidator(_relative)]
_Side = Annotated[int, Field(ge=1, le=_MOST_SIDE)]
_Pose = Annotated[_Rows4, AfterValidator(_pose)]
_Frame = Annotated[_Rows4, AfterValidator(_frame)]


class _Part(BaseModel):
    # What stands there must be of its type: no text is taken for a number.
    model_config = ConfigDict(strict=True, frozen=True, extra="allow", allow_inf_nan=False)


class GaussianEntry(_Part):
    """`openrooms_usd.rendering.scene.lights.Gaussian` as it is written."""

    name: LobeName
    amplitude: _Color
    axis: Annotated[_Row3, AfterValidator(_direction)]
    sharpness: _Length


class LightEntry(_Part):
    """`openrooms_usd.rendering.manifest.LightRecord` as it is written."""

    number: _Count
    name: str
    path: str = ""
    kind: LightKind
    on: bool
    world_from_box: _Frame
    size: tuple[_Length, _Length, _Length]
    radiance: _Color
    lumen: _Light = 0.0
    kelvin: _Length | None = None
    instance: _Label = 0
    gaussians: tuple[GaussianEntry, ...] = ()
    fit_error: _Factor | None = None
    environment: _File | None = None

    def record(self) -> LightRecord:
        """The record that was written, without its picture."""
        known = {name: getattr(self, name) for name in LightEntry.model_fields}
        gaussians = (
            Gaussian(row.name, np.array(row.amplitude), np.array(row.axis), row.sharpness)
            for row in self.gaussians
        )
        arrays = {name: np.array(known[name]) for name in ("world_from_box", "size", "radiance")}
        return LightRecord(**known | arrays | {"gaussians": tuple(gaussians), "environment": None})


class SeenLight(_Part):
    """A light as one camera has it."""

    number: _Count
    camera_from_box: _Frame | None = None
    opengl_from_box: _Frame | None = None
    box2d_projected: Annotated[tuple[_Number, ...], Field(max_length=4)] = ()
    box2d: Annotated[tuple[_Number, ...], Field(max_length=4)] | None = None


class BiasEntry(_Part):
    """`openrooms_usd.rendering.bias.Bias` as it is written."""

    total: _Light
    total_error: _Factor
    worst_tenth: _Light | None = None
    worst_tenth_error: _Factor | None = None
    pixels: _Count


class StoredEntry(_Part):
    """`openrooms_usd.rendering.storage.Way` as it is written."""

    file: _File | None = None
    sample: str = ""
    scale: Annotated[float, Field(ge=1e-37, le=1e37)] = 1.0
    bound: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0
    sources: tuple[str, ...] = ()


class ChannelEntry(_Part):
    """What one view has of one channel."""

    samples: _Count | None = None
    bias: BiasEntry | None = None
    estimated_error: _Factor | None = None
    estimated_robust_error: _Factor | None = None
    nonfinite_pixels: _Count = 0
    preview: _File | None = None
    preview_shows: str = ""
    stored: StoredEntry | None = None


class DenoisedEntry(_Part):
    """`openrooms_usd.rendering.channel_plan.EnergyChange` as it is written."""

    bias: _Number | None = None
    standard_error: _Factor | None = None
    blocks_beyond: _Factor | None = None
    stored: StoredEntry | None = None


class FitsEntry(_Part):
    """The fits of a view's environment maps."""

    files: dict[str, _File] = {}


class ViewEntry(_Part):
    """A finished view."""

    resolution: Annotated[tuple[_Side, _Side], AfterValidator(_size)]
    K: Annotated[tuple[_Row3, _Row3, _Row3], AfterValidator(_intrinsics)]
    world_from_camera: _Pose
    camera: str | None = None
    projection: Literal["pinhole", "equirectangular", "orthographic"] = "pinhole"
    exposure: _Factor | None = None
    photograph: dict[str, str] | None = None
    lights: tuple[SeenLight, ...] = ()
    files: dict[str, _File] | None = None
    channels: dict[str, ChannelEntry] = {}
    denoised: dict[str, DenoisedEntry] = {}
    traced: _Factor | None = None
    fits: FitsEntry | None = None

    def paths(self) -> list[str]:
        """The files that it names, all of them."""
        previews = [row.preview for row in self.channels.values() if row.preview]
        fits = self.fits.files if self.fits else {}
        ways = [row.stored for row in self.channels.values()]
        ways += [row.stored for row in self.denoised.values()]
        kept = [way.file for way in ways if way and way.file]
        return [*(self.files or {}).values(), *fits.values(), *previews, *kept]


class DefinitionEntry(_Part):
    """A row of the table of channels."""

    components: tuple[str, ...] = ()
    unit: str = ""
    scope: str = "view"
    meaning: str = ""


def _own_files(views: dict[str, ViewEntry]) -> dict[str, ViewEntry]:
    for name, view in views.items():
        for path in view.paths():
            if PurePosixPath(path).parts[0] != name:
                raise ValueError(f"the view {name!r} names {path!r}, which is not in its folder")
    return views


def _apart(lights: tuple[LightEntry, ...]) -> tuple[LightEntry, ...]:
    for what in ("number", "name"):
        if len({getattr(light, what) for light in lights}) < len(lights):
            raise ValueError(f"two lights have the same {what}")
    for light in lights:
        if light.environment and not light.environment.startswith(f"{OPENINGS_FOLDER}/"):
            raise ValueError(f"{light.environment!r} is not in the folder {OPENINGS_FOLDER}")
    return lights


class Manifest(_Part):
    """What a finished render says of itself."""

    format: Annotated[int, Field(ge=1, le=FORMAT)] = FORMAT
    generator: str = ""
    stage: str | None = None
    renderer: dict[str, str] = {}
    seed: _Count | None = None
    bounces: _Count | None = None
    method: Method = REFERENCE
    storage: StorageName = COMPLETE
    stop: dict[str, _Length] = {}
    conventions: dict[str, str] = {}
    channels: dict[str, DefinitionEntry] = {}
    lights: Annotated[tuple[LightEntry, ...], AfterValidator(_apart)] = ()
    legend: dict[str, dict[_Label, str]] = {}
    views: Annotated[dict[_Name, ViewEntry], AfterValidator(_own_files)]
    report: dict[str, Any] = {}


def read_manifest(folder: Path) -> Manifest:
    """The manifest of a finished render, checked whole.

    Args:
        folder: What ``orusd render`` wrote.

    Raises:
        InputError: It is missing, is not the manifest of a render, or something in it is wrong.
    """
    path = folder / MANIFEST
    text, found = load_manifest(folder)
    version = found.get("format", FORMAT)
    if isinstance(version, int) and version > FORMAT:
        raise InputError(
            f"this manifest has format {_shown(version)}, written by a newer version; this "
            f"version reads {FORMAT}",
            place=path,
            remedy="update openrooms_usd, or render again with this version",
        )
    try:
        # Of the text, since strict models take lists for tuples there alone.
        return Manifest.model_validate_json(text)
    except ValidationError as error:
        raise _refusal(path, error.errors(include_url=False)) from error


def _refusal(path: Path, rows: list[ErrorDetails]) -> InputError:
    first, more = rows[0], len(rows) - 1
    steps = tuple(step for step in first["loc"] if step != "[key]")
    text = first["msg"].removeprefix("Value error, ").replace("Input should be", "expected")
    if first["type"] == "too_long":
        text = f"expected at most {first['ctx']['max_length']} entries"
    said = (
        "it is missing" if first["type"] == "missing" else f"{text}, found {_shown(first['input'])}"
    )
    return InputError(
        said + (f"; {more:,} more mistakes" if more else ""),
        place=f"{path}: {written(steps)}" if steps else path,
        remedy=AGAIN,
    )


def _shown(value: Any) -> str:
    try:
        return shown(value)
    except ValueError:
        return "a number with too many digits"
