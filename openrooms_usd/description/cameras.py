"""The ``cameras`` section: from where the room is seen."""

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, Tag

from openrooms_usd.description.model import (
    CheckedModel,
    FoundMistake,
    Model,
    Number,
    PrimName,
    Whole,
    by_source,
    peek,
    peek_list,
    peek_text,
)
from openrooms_usd.description.naming import repeated_names
from openrooms_usd.description.units import Angle, Length, PositiveLength

Point3 = Annotated[tuple[Length, Length, Length], Field(description="x, y and z, metres")]
FieldOfView = Annotated[Angle, Field(gt=1, lt=170)]
Coefficient = Annotated[Number, Field(ge=-1, le=1)]
Row = tuple[Coefficient, Coefficient, Coefficient, Annotated[Number, Field(ge=-1000, le=1000)]]

# How far the rows of a rotation may be from unit length and right angles: rounding in text.
_ROUNDING = 1e-3


def _rotation(matrix: tuple[Row, Row, Row]) -> tuple[Row, Row, Row]:
    """Refuse a matrix that mirrors, scales or shears."""
    a, b, c = (row[:3] for row in matrix)
    products = [sum(x * y for x, y in zip(p, q, strict=True)) for p in (a, b, c) for q in (a, b, c)]
    wanted = (1, 0, 0, 0, 1, 0, 0, 0, 1)
    off = max(abs(found - want) for found, want in zip(products, wanted, strict=True))
    volume = sum(a[i] * (b[i - 2] * c[i - 1] - b[i - 1] * c[i - 2]) for i in range(3))
    if off > _ROUNDING or volume < 0:
        raise ValueError("a matrix whose first three columns are a rotation (no scale, no mirror)")
    return matrix


def _ordered(bounds: tuple[float, float]) -> tuple[float, float]:
    if bounds[0] > bounds[1]:
        raise ValueError("the smaller bound first")
    return bounds


Range = Annotated[tuple[PositiveLength, PositiveLength], AfterValidator(_ordered)]


class Exposed(Model):
    """What every camera has."""

    exposure_value: Number | None = Field(default=None, ge=-10, le=30)
    """EV100 of the previews (data is never exposed); by default fitted to each picture."""


class Viewed(Exposed, CheckedModel):
    """A camera whose lens is described."""

    fov: FieldOfView = 60.0
    """Horizontal field of view."""
    f_stop: Annotated[Number, Field(ge=0.5, le=128)] | None = None
    """F-number of a lens on film 36 mm wide, for depth of field; by default all is sharp."""
    focus: Literal["subject"] | PositiveLength | None = None
    """Focus distance along the optical axis, or ``subject``: the main object of the picture, or
    else its centre. By default the target, if there is one."""

    @classmethod
    def disagreements(cls, given: Any) -> Iterator[FoundMistake]:
        """A focus of a camera without a lens."""
        if peek(given, "focus") is not None and peek(given, "f_stop") is None:
            yield FoundMistake(
                ("focus",), "focus has no effect without f_stop; give f_stop, or omit focus"
            )


class LookAtCamera(Viewed):
    """A camera at one point that looks at another."""

    source: Literal["look_at"] = Field(default="look_at", alias="from")
    name: PrimName | None = None
    """Its prim name; by default a number."""
    eye: Point3
    """Position of the camera."""
    target: Point3
    """The point that it looks at."""

    @classmethod
    def disagreements(cls, given: Any) -> Iterator[FoundMistake]:
        """A camera that looks nowhere."""
        yield from super().disagreements(given)
        eye = peek(given, "eye")
        if eye is not None and eye == peek(given, "target"):
            yield FoundMistake(("target",), "eye and target are the same point")


class PoseCamera(Viewed):
    """A camera by its rotation and position."""

    source: Literal["pose"] = Field(default="pose", alias="from")
    name: PrimName | None = None
    """Its prim name; by default a number."""
    world_from_camera: Annotated[tuple[Row, Row, Row], AfterValidator(_rotation)]
    """Rows of the 3x4 matrix that takes points of the OpenCV camera frame (x right, y down,
    z forward) to the world, metres."""


class SelectedCameras(Viewed):
    """The best of many views into the room."""

    source: Literal["select"] = Field(alias="from")
    name: PrimName = "view"
    """Prefix of the cameras' names."""
    count: Whole = Field(default=3, ge=1, le=1000)
    """How many to keep."""
    spare: Whole = Field(default=0, ge=0, le=1000)
    """How many spare cameras, named ``spare_0`` and so on, to replace rejected views."""
    prefer: Literal["photograph", "paper"] = "photograph"
    """``photograph``: level views from corners, doorways and walls that show the room's main
    things whole; ``paper``: tilted views along the walls, scored as in the OpenRooms paper."""
    height: Range | None = None
    """Range of heights above the floor; by default 1.2 to 1.6 m, as in the paper 1.4 to 1.8 m."""
    distance: Range = (0.3, 1.5)
    """Range of distances from the wall, for views outside corners and doorways."""


class FrameCameras(Exposed):
    """The cameras of the capture's photographs, so that each view stands for one of them."""

    source: Literal["capture"] = Field(alias="from")
    name: PrimName = "frame"
    """Prefix of the cameras' names; the frame's identifier follows."""
    every: Whole = Field(default=1, ge=1)
    """Use every n-th frame, starting with the first one."""
    plates: bool = False
    """Copy the photographs into the scene, as back plates of their cameras (`BackPlateAPI`)."""


View = Annotated[
    Annotated[LookAtCamera, Tag("look_at")]
    | Annotated[PoseCamera, Tag("pose")]
    | Annotated[SelectedCameras, Tag("select")]
    | Annotated[FrameCameras, Tag("capture")],
    by_source("look_at", world_from_camera="pose"),
]

Pixels = Annotated[Whole, Field(ge=1, le=16_384)]


class Cameras(CheckedModel):
    """The cameras and the size of their pictures."""

    source: Literal["views"] = Field(default="views", alias="from")
    resolution: tuple[Pixels, Pixels] = (640, 480)
    """Width and height in pixels."""
    views: tuple[View, ...] = (SelectedCameras.model_validate({"from": "select"}),)
    """Cameras, and rules that select further ones."""

    @classmethod
    def disagreements(cls, given: Any) -> Iterator[FoundMistake]:
        """Names that repeat."""
        names = [peek_text(view, "name") for view in peek_list(given, "views")]
        yield from repeated_names(names, "views", "camera")


class CapturedCameras(FrameCameras):
    """The cameras of the capture's photographs and nothing else."""

    resolution: tuple[Pixels, Pixels] | None = None
    """Width and height in pixels; by default those of the photographs."""

    @property
    def views(self) -> tuple[View, ...]:
        """This as the only view."""
        return (self,)


AnyCameras = Annotated[
    Annotated[Cameras, Tag("views")] | Annotated[CapturedCameras, Tag("capture")],
    by_source("views"),
]
