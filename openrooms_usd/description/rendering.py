"""How pictures are made: every option of a render, once, with its default, limits and help.

The options of the commands that render, the sections ``budget`` and ``rendering`` of dataset.yaml,
the keyword arguments in Python and the table in the docs are made of these fields. A new option is
a field here, and the code that heeds it.
"""

from collections.abc import Iterable, Iterator, Mapping
from math import inf
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal, NamedTuple, Self, get_args

from pydantic import Field, ValidationError

from openrooms_usd.description.mistakes import shown
from openrooms_usd.description.model import (
    MISTAKE,
    CheckedModel,
    FoundMistake,
    Model,
    Number,
    Switch,
    Whole,
    peek,
)
from openrooms_usd.errors import InputError
from openrooms_usd.spelling import did_you_mean

Method = Literal["cache", "reference"]
METHODS: Final[tuple[Method, ...]] = get_args(Method)
CACHE: Final = "cache"
REFERENCE: Final = "reference"

ToneName = Literal["photograph", "film", "srgb"]
PHOTOGRAPH: Final = "photograph"

StorageName = Literal["complete", "compact"]
COMPLETE: Final = "complete"
COMPACT: Final = "compact"

DEFAULT_SAMPLES: Final = 64
DEFAULT_BOUNCES: Final = 7
DEFAULT_GRID: Final = (160, 120)

USUAL: Final = "usual"  # stands for the channels that need not be asked for
ALL: Final = "all"  # stands for all channels that can be had

_MOST_PIXELS: Final = 2**27
# Kinds of mistakes that pydantic finds.
_OPEN: Final = ("greater_than", "less_than")
_EXPECTED: Final = {
    "int_type": "a whole number",
    "float_type": "a number",
    "bool_type": "true or false",
}
_STOPS: Final = ("samples", "error", "seconds")


class Option(NamedTuple):
    """How an option is written, where its field's name and type do not say it.

    Attributes:
        flag: On the command line; by default the field's name.
        unit: Of its number.
    """

    flag: str | None = None
    unit: str | None = None


_Name = Annotated[str, Field(min_length=1)]
_Side = Annotated[Whole, Field(ge=1, le=2**15)]
_Cells = Annotated[Whole, Field(ge=1, le=2**11)]


class Budget(CheckedModel):
    """When a view is good enough: one of the three."""

    samples: Annotated[Whole, Field(ge=1, le=2**20), Option("--spp")] | None = None
    """Samples per pixel; 64 if neither an error nor a time is given."""
    error: Annotated[Number, Field(ge=1e-9, le=1e3), Option("--target-error")] | None = None
    """Stop at this estimated robust error of the radiance."""
    seconds: (
        Annotated[Number, Field(ge=1e-3, le=1e7), Option("--max-seconds", "seconds")] | None
    ) = None
    """Stop each view after about this time; two runs do different amounts of work in it."""

    @classmethod
    def disagreements(cls, given: Any) -> Iterator[FoundMistake]:
        """More than one of them."""
        has = [name for name in _STOPS if peek(given, name) is not None]
        for name in has[1:]:
            yield FoundMistake((name,), f"only one of these is allowed; {has[0]} is already given")


class Rendering(Model):
    """How light is computed, and what is written of it."""

    renderer: _Name = "mitsuba"
    """mitsuba, preview (quick, without light), or another installed one."""
    options: dict[str, str] = Field(default_factory=dict)
    """Options of the renderer, by name, such as the variant of Mitsuba."""
    method: Method | None = None
    """How light is computed: reference follows every path to its end, without bias; cache computes
    smooth light once for the room. By default the faster one."""
    bounces: Annotated[Whole, Field(ge=0, le=1024)] = DEFAULT_BOUNCES
    """At most this many scatterings on the way from a light to the camera."""
    grid: tuple[_Cells, _Cells] = DEFAULT_GRID
    """Columns and rows of hemispheres, for the channels of environment."""
    error_maps: Switch = False
    """Write the estimated standard error of every pixel too."""
    denoise: Switch = False
    """Write a denoised radiance beside the raw one (extra denoise)."""
    denoise_light: Switch = False
    """Write denoised versions of every channel of light that supports it, too."""
    tone: ToneName = PHOTOGRAPH
    """Tone mapping of PNGs: photograph as a camera does, film by the curve alone, srgb by the
    encoding alone. EXRs are never tone mapped."""
    f_stop: Annotated[Number, Field(ge=0.5, le=128)] | None = None
    """Depth of field: F-number of a lens on a film 36 mm wide, such as 2.8, focused by the camera
    or else on the picture's centre. Ground truth stays that of a pinhole."""
    default_light: Switch = True
    """Whether a stage without any light gets a default one, even and from above, or stays dark."""
    texture_side: Annotated[Whole, Field(ge=1, le=2**16), Option(unit="pixels")] | None = None
    """The longest side of textures: longer ones are halved until they fit. By default 4096, or less
    where all together would take more than 2 GB."""


class RenderSettings(Budget, Rendering):
    """All settings of a render.

    Raises:
        InputError: A name is unknown, a number is outside its limits, or samples, error and seconds
            contradict each other.
    """

    channels: tuple[_Name, ...] | None = None
    """Names as `orusd channels` lists them; usual, the default: those without +; all: every one."""
    resolution: tuple[_Side, _Side] | None = None
    """Width and height in pixels; by default those of the stage."""
    field_of_view: Annotated[Number, Field(gt=0, lt=180), Option("--fov", "degrees")] | None = None
    """Horizontal field of view of all cameras; by default each camera's own."""
    seed: Annotated[Whole, Field(ge=0, le=2**31 - 1)] = 0
    """Seed of all random numbers."""
    storage: StorageName = COMPLETE
    """How files hold channels: compact is about seven times smaller, light within a stated relative
    error (docs/reference/storage.md)."""
    time_code: Annotated[Number, Field(ge=-1e12, le=1e12)] | None = None
    """Time code of an animated stage; by default the first sample of everything."""

    if not TYPE_CHECKING:  # Type checkers see an argument for each field.

        def __init__(self, **given: Any) -> None:
            """Check what is given."""
            try:
                super().__init__(**{name: _plain(name, value) for name, value in given.items()})
            except ValidationError as error:
                raise _refusal(error) from None
            _check_size(self.resolution)

    @property
    def samples_or_default(self) -> int | None:
        """Samples a pixel; None where an error or a time says when a view is good enough."""
        if self.error is None and self.seconds is None:
            return self.samples or DEFAULT_SAMPLES
        return None

    def replace(self, **changes: Any) -> Self:
        """The same settings with other values.

        Args:
            **changes: By the names of the fields.

        Raises:
            InputError: As where settings are made.
        """
        return type(self)(**{name: getattr(self, name) for name in self.model_fields_set} | changes)


def flag_of(name: str) -> str:
    """How an option is written on the command line."""
    return option_of(name).flag or f"--{name.replace('_', '-')}"


def option_of(name: str) -> Option:
    """What the field of a name says besides its type."""
    return next(_options(RenderSettings.model_fields[name]), Option())


def limits_of(name: str) -> tuple[float, float] | None:
    """The least and the largest value of a field, of a size of a side; None without any."""
    rows = list(_bounds(RenderSettings.model_fields[name]))
    low = next((value for row in rows if (value := _either(row, "ge", "gt")) is not None), None)
    high = next((value for row in rows if (value := _either(row, "le", "lt")) is not None), None)
    return None if low is None or high is None else (low, high)


def _options(field: Any) -> Iterator[Option]:
    """The `Option` of a field or of a part of its union."""
    yield from (one for one in field.metadata if isinstance(one, Option))
    for part in get_args(field.annotation):
        yield from (one for one in getattr(part, "__metadata__", ()) if isinstance(one, Option))


def _plain(name: str, value: Any) -> Any:
    """Python's own numbers for numpy's, tuples for lists, one name for a list of it."""
    if name == "channels" and isinstance(value, str):
        return tuple(part.strip() for part in value.split(",") if part.strip())
    if name == "channels" and isinstance(value, Iterable):
        return tuple(value)
    if name == "options":
        return dict(value or {})
    if isinstance(value, list | tuple):
        return tuple(_plain("", part) for part in value)
    return value.item() if hasattr(value, "item") and hasattr(value, "dtype") else value


def _check_size(size: tuple[int, int] | None) -> None:
    if size and size[0] * size[1] > _MOST_PIXELS:
        raise InputError(
            f"{size[0]}x{size[1]} is more than {_MOST_PIXELS:,} pixels", place="resolution"
        )


def _refusal(error: ValidationError) -> InputError:
    """The first mistake, as users see it."""
    row = error.errors(include_url=False)[0]
    name = next((str(step) for step in row["loc"] if isinstance(step, str)), "")
    if row["type"] == "extra_forbidden":
        known = RenderSettings.model_fields
        return InputError(
            f"there is no setting {name!r}{did_you_mean(name, known)}",
            remedy=f"there are: {', '.join(known)}",
        )
    return InputError(_text(name, row), place=_place(name, row["loc"]), remedy=_remedy(row))


def _text(name: str, row: Mapping[str, Any]) -> str:
    """What is wrong with a value, in one sentence."""
    found, kind = row["input"], row["type"]
    if kind == MISTAKE:
        return str(row["msg"])
    if kind == "literal_error":
        return f"there is no {name} {found!r}"
    if kind in ("greater_than_equal", "less_than_equal", "finite_number", *_OPEN):
        low, high = limits_of(name) or (-inf, inf)
        if kind in _OPEN:
            return f"must be above {low:,} and below {high:,}, got {found}"
        return f"must be between {low:,} and {high:,}, got {found}"
    expected = {
        "int_type": "a whole number",
        "float_type": "a number",
        "bool_type": "true or false",
    }
    if kind in expected:
        return f"{found!r} is not {expected[kind]}"
    if name in ("resolution", "grid"):
        return f"{shown(found)} is not two whole numbers, such as (640, 480)"
    return f"{shown(found)} is not allowed: {row['msg']}"


def _either(row: Any, *names: str) -> float | None:
    return next((found for name in names if (found := getattr(row, name, None)) is not None), None)


def _bounds(field: Any) -> Iterator[Any]:
    """The limits that a field or the parts of its type have."""
    for one in getattr(field, "metadata", getattr(field, "__metadata__", ())):
        yield one
        yield from getattr(one, "metadata", ())
    annotation = getattr(field, "annotation", field)
    for part in get_args(annotation):
        yield from _bounds(part)


def _place(name: str, loc: tuple[int | str, ...]) -> str:
    """The option, by its name in Python and on the command line; of a size which side."""
    side = next((step for step in loc if isinstance(step, int)), None)
    if side is not None and name in ("resolution", "grid"):
        whose = "" if name == "resolution" else "grid's "
        return whose + ("width", "height")[side]
    flag = flag_of(name) if name in RenderSettings.model_fields else ""
    plain = name.replace("_", " ")
    return f"{plain} ({flag})" if flag else plain


def _remedy(row: Mapping[str, Any]) -> str | None:
    if row["type"] != "literal_error":
        return None
    return f"one of: {row['ctx']['expected'].replace(chr(39), '').replace(' or ', ', ')}"
