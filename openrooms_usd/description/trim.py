"""What walls and ceilings wear: skirting, cornice, casings, rails, thresholds, tiles, beams."""

from collections.abc import Iterator
from typing import Annotated, Any, Final, Literal, TypeAlias, get_args

from pydantic import BeforeValidator, Field

from openrooms_usd.description.model import CheckedModel, FoundMistake, Model, PrimName, Whole, peek
from openrooms_usd.description.units import Length, PositiveLength, metres

Profile: TypeAlias = Literal["square", "rounded", "ogee", "torus"]
CornicePiece: TypeAlias = Literal["cove", "stepped", "ogee", "square"]
CeilingKind: TypeAlias = Literal["plain", "beams", "coffers", "grid"]

# Spacing, width and depth of what hangs below each kind of ceiling, metres. A grid is that of
# mineral boards of 600 mm on bars of 24 mm.
CEILINGS: Final[dict[str, tuple[float, float, float]]] = {
    "beams": (1.0, 0.14, 0.16),
    "coffers": (1.2, 0.12, 0.1),
    "grid": (0.6, 0.024, 0.004),
}


class Skirting(Model):
    """Boards along the foot of walls."""

    height: PositiveLength = Field(default=0.08, ge=0.02, le=0.5)
    """Of the board."""
    depth: PositiveLength = Field(default=0.014, ge=0.004, le=0.05)
    """How far it stands out from the wall."""
    profile: Profile = "rounded"
    """Its section."""


class Cornice(Model):
    """Mouldings between walls and ceiling."""

    height: PositiveLength = Field(default=0.08, ge=0.02, le=0.5)
    """How far down the wall it reaches."""
    depth: PositiveLength = Field(default=0.08, ge=0.01, le=0.5)
    """How far along the ceiling it reaches."""
    profile: CornicePiece = "cove"
    """Its section."""


class Casing(Model):
    """Boards on the wall around doors, windows and passages."""

    width: PositiveLength = Field(default=0.07, ge=0.02, le=0.3)
    """Of the boards."""
    depth: PositiveLength = Field(default=0.015, ge=0.004, le=0.05)
    """How far they stand out from the wall."""
    profile: Profile = "square"
    """Their section."""


class PictureRail(Model):
    """A thin moulding all round, high on the walls."""

    at: PositiveLength = Field(default=2.05, ge=1, le=10)
    """Height of its lower edge above the floor."""
    height: PositiveLength = Field(default=0.04, ge=0.01, le=0.2)
    """Of the moulding."""
    depth: PositiveLength = Field(default=0.018, ge=0.004, le=0.05)
    """How far it stands out from the wall."""
    profile: Profile = "torus"
    """Its section."""


class Wainscot(Model):
    """Panelling of the lower part of walls, with a rail on top."""

    height: PositiveLength = Field(default=0.9, ge=0.3, le=2.5)
    """Of the panelling with its rail."""
    depth: PositiveLength = Field(default=0.012, ge=0.004, le=0.05)
    """How far its frames stand out from the wall."""


class Threshold(Model):
    """A strip in doorways where one floor meets another."""

    height: PositiveLength = Field(default=0.004, ge=0.001, le=0.03)
    """Above the floor; below a door's leaf there are 6 mm."""


def _shorthand(model: Any, key: str, profiles: Any = None) -> BeforeValidator:
    """``true`` stands for all defaults, a length for the one key that matters most."""
    values = get_args(profiles) if profiles else ()
    either = f"true, a length, {', '.join(values)}, or" if values else "true, a length or"

    def read(given: Any) -> Any:
        if given is True:
            return {}
        if isinstance(given, str) and given in values:
            return {"profile": given}
        if isinstance(given, (dict, model)):
            return given
        try:
            return {key: metres(given)}
        except ValueError:
            raise ValueError(f"{either} a mapping") from None

    written = model | PositiveLength | Literal[True]
    return BeforeValidator(read, json_schema_input_type=written | profiles if profiles else written)


class Trim(Model):
    """Mouldings along walls and around openings; an omitted key means none of its kind."""

    skirting: Annotated[Skirting, _shorthand(Skirting, "height", Profile)] | None = None
    """Boards along the foot of walls: a mapping, a height, a profile, or `true`."""
    cornice: Annotated[Cornice, _shorthand(Cornice, "height", CornicePiece)] | None = None
    """Mouldings below the ceiling: likewise."""
    casing: Annotated[Casing, _shorthand(Casing, "width", Profile)] | None = None
    """Boards around openings: a mapping, a width, a profile, or `true`."""
    picture_rail: Annotated[PictureRail, _shorthand(PictureRail, "at", Profile)] | None = None
    """A moulding high on the walls: a mapping, its height above the floor, or `true`."""
    wainscot: Annotated[Wainscot, _shorthand(Wainscot, "height")] | None = None
    """Panelling of the lower walls: a mapping, a height, or `true`."""
    threshold: Annotated[Threshold, _shorthand(Threshold, "height")] | None = None
    """Strips in doorways: a mapping, a height, or `true`."""


class Ceiling(CheckedModel):
    """Beams, coffers or a grid below the ceiling."""

    kind: CeilingKind = "plain"
    """Nothing, beams, beams that cross, or the bars of a suspended ceiling."""
    spacing: PositiveLength | None = Field(default=None, ge=0.1, le=10)
    """Greatest distance between the centres of two beams."""
    width: PositiveLength | None = Field(default=None, ge=0.005, le=1)
    """Of a beam."""
    depth: PositiveLength | None = Field(default=None, ge=0.001, le=1)
    """How far it reaches down."""
    along: Literal["x", "y"] | None = None
    """Direction of the beams; by default across the longer side of the room."""

    @classmethod
    def disagreements(cls, given: Any) -> Iterator[FoundMistake]:
        """Sizes of what is not there, and beams without a gap between them."""
        kind = peek(given, "kind") or "plain"
        for key in ("spacing", "width", "depth", "along"):
            if kind == "plain" and peek(given, key) is not None:
                yield FoundMistake((key,), f"{key} has no effect with a plain ceiling")
        spacing, width = peek(given, "spacing"), peek(given, "width")
        known = isinstance(spacing, (int, float)) and isinstance(width, (int, float))
        if known and width >= spacing:
            yield FoundMistake(
                ("width",), "the beams are as wide as their spacing: there is no gap"
            )

    @property
    def sizes(self) -> tuple[float, float, float]:
        """Spacing, width and depth, metres."""
        spacing, width, depth = CEILINGS[self.kind]
        return self.spacing or spacing, self.width or width, self.depth or depth


class Cladding(CheckedModel):
    """Tiles or boards on a part of the walls."""

    name: PrimName | None = None
    """Its name in `materials`; by default cladding and a number, such as cladding_0."""
    walls: tuple[Annotated[Whole, Field(ge=0)], ...] | None = Field(default=None, min_length=1)
    """The numbers of the walls; by default all of them."""
    span: tuple[Length, Length] | None = None
    """Start and end along the wall, from the wall's start; by default all of it."""
    bottom: Length = Field(default=0.0, ge=0)
    """Height of the lower edge above the floor."""
    top: PositiveLength | None = None
    """Height of the upper edge above the floor; by default the ceiling."""
    depth: PositiveLength = Field(default=0.008, ge=0.002, le=0.1)
    """How far it stands out from the wall."""

    @classmethod
    def disagreements(cls, given: Any) -> Iterator[FoundMistake]:
        """A span that several walls share, and edges the wrong way round."""
        walls, span = peek(given, "walls"), peek(given, "span")
        if span is not None and (not isinstance(walls, (list, tuple)) or len(walls) != 1):
            yield FoundMistake(("span",), "a span is along one wall: give walls with one number")
        for key, ends in (("span", span), ("top", (peek(given, "bottom"), peek(given, "top")))):
            if not isinstance(ends, (list, tuple)) or len(ends) != 2:
                continue
            if all(isinstance(e, (int, float)) for e in ends) and ends[0] >= ends[1]:
                yield FoundMistake((key,), "its end must lie behind its start")


def _kind(given: Any) -> Any:
    return {"kind": given} if isinstance(given, str) else given


AnyCeiling = Annotated[
    Ceiling, BeforeValidator(_kind, json_schema_input_type=Ceiling | CeilingKind)
]
