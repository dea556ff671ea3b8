"""dataset.yaml: which rooms, seen how often, in which variants, with which ground truth."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Final, Literal, Self, get_args

from pydantic import Field, PrivateAttr, Tag

from openrooms_usd.description.cameras import FieldOfView, Pixels, Range
from openrooms_usd.description.model import (
    CheckedModel,
    FoundMistake,
    Model,
    Number,
    PrimName,
    Switch,
    Whole,
    by_source,
    peek,
    peek_list,
    peek_text,
)
from openrooms_usd.description.rendering import (
    COMPACT,
    Budget,
    Rendering,
    RenderSettings,
    StorageName,
)
from openrooms_usd.description.room import RoomType
from openrooms_usd.description.styles import InteriorStyle
from openrooms_usd.description.units import PositiveLength

# The `sensor` section of dataset.yaml: what a real camera would make of the views.

_Coefficient = Annotated[Number, Field(ge=-10, le=10)]


class Distortion(Model):
    """A lens that bends straight lines, by OpenCV's model."""

    k1: _Coefficient = 0.0
    """Radial, of r^2; negative for barrels."""
    k2: _Coefficient = 0.0
    """Radial, of r^4."""
    p1: _Coefficient = 0.0
    """Tangential, by the vertical."""
    p2: _Coefficient = 0.0
    """Tangential, by the horizontal."""
    k3: _Coefficient = 0.0
    """Radial, of r^6."""


class Noise(Model):
    """A sensor that counts electrons."""

    iso: Annotated[Number, Field(ge=100, le=1e6)] = 400.0
    """Sensitivity; at 100, the least, a white pixel fills its well, at 200 half of it."""
    full_well: Annotated[Number, Field(ge=10, le=1e7)] = 15_000.0
    """Electrons that a pixel holds: photons times quantum efficiency."""
    read_noise: Annotated[Number, Field(ge=0, le=1e4)] = 3.0
    """Standard deviation of read noise, electrons."""
    bits: Annotated[Whole, Field(ge=1, le=16)] = 12
    """Bits per value."""
    black: Annotated[Number, Field(ge=0, le=0.5)] = 1 / 64
    """Black level, as a share of the greatest value: noise below it is kept."""


class DepthCamera(Model):
    """A depth camera that projects a pattern."""

    model: Literal["structured_light"] = "structured_light"
    """Measuring principle."""
    range: Range = (0.5, 5.0)
    """The nearest and the farthest depth that it measures."""
    baseline: PositiveLength = 0.075
    """Distance from the camera to the projector at its right."""
    noise: Annotated[Number, Field(ge=0, le=100)] = 1.0
    """Factor of the measured noise of the first Kinect; 0 for none."""
    steps: Switch = True
    """Whether disparity is quantised."""
    missing: Switch = True
    """Whether depth is missing in shadows of the projector, and on slanted, dark and mirroring
    surfaces."""


class Sensor(CheckedModel):
    """Simulated sensors, written beside the ground truth of every view."""

    distortion: Distortion | None = None
    """Of the lens; by default none."""
    noise: Noise | None = None
    """Of the photograph; by default none."""
    depth: DepthCamera | None = None
    """A depth camera in the place of the view's; by default none."""
    exposure_value: Annotated[Number, Field(ge=-10, le=30)] | None = None
    """EV100 of the photographs; by default the camera's, or fitted to each picture."""
    seed: Whole = Field(default=0, ge=0, lt=2**63)
    """Draws the noise, and nothing else."""

    @classmethod
    def disagreements(cls, given: Any) -> Iterator[FoundMistake]:
        """A sensor that does nothing."""
        if all(peek(given, name) is None for name in ("distortion", "noise", "depth")):
            yield FoundMistake((), "a sensor needs distortion, noise or depth")


Variant = Literal["main", "mainDiffMat", "mainDiffLight", "mainDiffMatLight"]
Split = Literal["train", "val", "test"]
SPLITS: Final[tuple[Split, ...]] = get_args(Split)

_MOST_ROOMS: Final = 10_000_000
# How far shares may be from 1 together: they are written with few digits.
_SHARES_TOLERANCE: Final = 1e-6

_Share = Annotated[Number, Field(ge=0, le=1)]
_Text = Annotated[str, Field(min_length=1)]


class GeneratedRooms(Model):
    """Generated rooms."""

    source: Literal["generate"] = Field(default="generate", alias="from")
    types: tuple[RoomType, ...] = Field(default=get_args(RoomType), min_length=1)
    """The room types, in turn; all of them by default."""
    count: Whole = Field(ge=1, le=_MOST_ROOMS)
    """How many rooms."""
    clutter: Annotated[Whole, Field(ge=0, le=3)] = 2
    """Amount of clutter: 0 none, 1 tidy, 2 lived in, 3 messy."""
    style: InteriorStyle | None = None
    """Style of furniture, materials and colours; drawn for each room by default."""


class DescribedRooms(Model):
    """Rooms with a room.yaml: written by hand, or imported from captures."""

    source: Literal["descriptions"] = Field(default="descriptions", alias="from")
    files: tuple[_Text, ...] = Field(min_length=1)
    """Their room.yaml, relative to this file."""
    coverage: _Share | None = None
    """The least share of the floor and the walls that a scan must show; by default any."""


class CapturedRooms(Model):
    """Rooms of captures, as `orusd import` describes them."""

    source: Literal["captures"] = Field(default="captures", alias="from")
    files: tuple[_Text, ...] = Field(min_length=1)
    """What the importer reads, relative to this file: files, or folders."""
    importer: _Text = "scan"
    """Its name, as `orusd import --help` lists it."""
    options: dict[str, _Text] = Field(default_factory=dict)
    """Options of the importer; paths are relative to this file."""
    coverage: _Share = 0.6
    """The least share of the floor and the walls that a scan must show; others are left out."""


Rooms = Annotated[
    Annotated[GeneratedRooms, Tag("generate")]
    | Annotated[DescribedRooms, Tag("descriptions")]
    | Annotated[CapturedRooms, Tag("captures")],
    by_source("generate", files="descriptions"),
]


class DatasetViews(CheckedModel):
    """The views of each room."""

    source: Literal["select", "described", "capture", "path"] = Field(
        default="select", alias="from"
    )
    """``select``: the best of many views; ``described``: the first cameras of the room's own;
    ``capture``: photographs of the capture, evenly spread; ``path``: the frames of a walk."""
    count: Whole = Field(default=3, ge=1, le=1000)
    """Number of views per room; for stereo cameras, of pairs."""
    resolution: tuple[Pixels, Pixels] = (640, 480)
    """Width and height in pixels."""
    fov: FieldOfView | None = None
    """Horizontal field of view of all cameras; by default that of the room's cameras."""
    prefer: Literal["photograph", "paper"] = "photograph"
    """How views are selected: see the cameras of room.yaml."""
    projection: Literal["pinhole", "equirectangular"] = "pinhole"
    """``equirectangular``: level panoramas of all directions, twice as wide as high, at the
    positions of the views."""
    replace: Whole = Field(default=5, ge=0, le=1000)
    """How many spare cameras of a room may replace those with rejected views; not for paths."""
    rate: Annotated[Whole, Field(ge=1, le=240)] | None = None
    """Frames per second of a path; 4 by default."""
    stereo: PositiveLength | None = None
    """Stereo baseline: distance to a second camera, at the right of each."""

    @property
    def units(self) -> int:
        """How many views a room has in one variant."""
        return self.count * (2 if self.stereo else 1)

    @classmethod
    def disagreements(cls, given: Any) -> Iterator[FoundMistake]:
        """What only a path has, and what no panorama has."""
        if peek(given, "projection") == "equirectangular":
            size = peek_list(given, "resolution") or [640, 480]
            sides = [side for side in size if isinstance(side, int)]
            if len(sides) == len(size) == 2 and sides[0] != 2 * sides[1]:
                yield FoundMistake(("resolution",), "a panorama must be twice as wide as high")
            if peek(given, "stereo") is not None:
                yield FoundMistake(("stereo",), "stereo is not available for panoramas")
        source = peek_text(given, "from") or peek_text(given, "source")
        if peek(given, "rate") is not None and source != "path":
            yield FoundMistake(("rate",), "only paths have a rate of frames (from: path)")


class Output(Model):
    """A further format in which finished rooms are written."""

    kind: _Text = Field(alias="as")
    """Format: openrooms, nerf, webdataset, hypersim, coco, parquet, or an installed one."""
    layout: Literal["split", "merged"] = "split"
    """For openrooms: a tree for each channel, or one folder, which published loaders read."""
    crowded: Literal["leave-out", "drop", "keep"] = "leave-out"
    """For openrooms: how to treat views with more lights than loaders support."""
    scenes: bool = False
    """For openrooms: whether to write meshes, materials and ``main.xml`` too."""
    taxonomy: Literal["category", "openrooms45", "nyu40", "ade20k", "coco"] = "category"
    """For coco: the taxonomy of the classes."""
    shard_mb: Annotated[Whole, Field(ge=1, le=100_000)] = 256
    """For webdataset: greatest size of a shard, megabytes; a single view may be larger."""
    files: tuple[_Text, ...] = ()
    """For webdataset: the files of each view, such as ``channels.exr``; all channels by default."""


class Shares(CheckedModel):
    """Shares of the rooms for each split; a room is in one split, with all its views."""

    train: _Share = 0.8
    """For training."""
    val: _Share = 0.1
    """For validation."""
    test: _Share = 0.1
    """For tests."""

    @classmethod
    def disagreements(cls, given: Any) -> Iterator[FoundMistake]:
        """Shares that do not add up to 1."""
        found = [peek(given, name) for name in cls.model_fields]
        usual = [info.default for info in cls.model_fields.values()]
        shares = [u if share is None else share for share, u in zip(found, usual, strict=True)]
        if all(isinstance(share, (int, float)) for share in shares):
            total = math.fsum(shares)
            if abs(total - 1.0) > _SHARES_TOLERANCE:
                yield FoundMistake((), f"train, val and test must add up to 1, got {total:g}")


class Dataset(CheckedModel):
    """A dataset, as dataset.yaml describes it."""

    name: PrimName = "dataset"
    """Its name, for people."""
    seed: Whole = Field(default=0, ge=0, lt=2**63)
    """Seed of all random choices."""
    rooms: tuple[Rooms, ...] = Field(min_length=1)
    """Where the rooms come from."""
    views: DatasetViews = Field(default_factory=DatasetViews)
    """The views of each room."""
    variants: tuple[Variant, ...] = Field(default=("main",), min_length=1)
    """What each room is rendered as: ``main``, with other materials (``mainDiffMat``), other lights
    (``mainDiffLight``) or both (``mainDiffMatLight``)."""
    channels: tuple[_Text, ...] = Field(default=("usual",), min_length=1)
    """Names as of `orusd render --channels`: usual, all, or those of `orusd channels`."""
    budget: Budget = Field(default_factory=Budget)
    """When a view stops."""
    rendering: Rendering = Field(default_factory=Rendering)
    """Settings of the renderer."""
    sensor: Sensor | None = None
    """Simulated sensor, written beside the ground truth; by default none."""
    storage: StorageName = COMPACT
    """How the files of views hold channels: ``compact`` is about seven times smaller: light within
    a stated relative error, everything else lossless (docs/reference/storage.md)."""
    outputs: tuple[Output, ...] = ()
    """Forms in which finished rooms are written besides EXR and manifest."""
    splits: Shares = Field(default_factory=Shares)
    """Shares of the rooms for training, validation and tests."""
    retries: Whole = Field(default=1, ge=0, le=100)
    """How often a view that fails is tried again."""

    _folder: Path = PrivateAttr(default_factory=Path)

    @property
    def folder(self) -> Path:
        """Where the names of files in it begin."""
        return self._folder

    def located(self, folder: Path) -> Self:
        """The same dataset, whose names of files begin in a folder."""
        found = self.model_copy()
        found._folder = folder
        return found

    def settings(self, seed: int = 0) -> RenderSettings:
        """The render settings of each view.

        Args:
            seed: Fixes every random number.
        """
        parts = self.budget, self.rendering
        given = {name: getattr(part, name) for part in parts for name in type(part).model_fields}
        return RenderSettings(
            **given,
            channels=self.channels,
            resolution=self.views.resolution,
            field_of_view=self.views.fov,
            seed=seed,
            storage=self.storage,
        )

    @property
    def has_flow(self) -> bool:
        """Whether views are frames of a path, which have the optical flow to the next one."""
        return self.views.source == "path" and self.views.projection == "pinhole"

    @classmethod
    def disagreements(cls, given: Any) -> Iterator[FoundMistake]:
        """Names given twice, what needs pinhole cameras, and photographs without a capture."""
        views = peek(given, "views")
        if "capture" in (peek(views, "from"), peek(views, "source")):
            for index, row in enumerate(peek_list(given, "rooms")):
                if peek(row, "files") is None:
                    text = "generated rooms have no photographs (views: from: capture)"
                    yield FoundMistake(("rooms", index), text)
        if peek(views, "projection") == "equirectangular":
            for name in ("sensor", "outputs"):
                if peek(given, name):
                    yield FoundMistake(
                        (name,), "panoramas do not support it: it needs pinhole cameras"
                    )
        variants = peek_list(given, "variants")
        kinds = [peek(row, "as") or peek(row, "kind") for row in peek_list(given, "outputs")]
        for where, names in (("variants", variants), ("outputs", kinds)):
            for index, name in enumerate(names):
                if name is not None and name in names[:index]:
                    yield FoundMistake((where, index), f"{name} is given twice")
