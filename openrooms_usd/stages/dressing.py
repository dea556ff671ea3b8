"""What each object wears: overrides, then what people noted, then its own, then the tables."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Final

from pxr import Sdf, Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.description.materials import Look
from openrooms_usd.description.nearest import did_you_mean
from openrooms_usd.description.substances import Substance
from openrooms_usd.draws import generator
from openrooms_usd.errors import DescriptionError
from openrooms_usd.library.assignment.annotations import Annotation, read_annotation
from openrooms_usd.library.finishes import (
    FINISHES,
    GENERIC,
    furniture_families,
    suite_of,
)
from openrooms_usd.stages.base import StageContext
from openrooms_usd.stages.choosing import Chooser
from openrooms_usd.stages.looks import Dressed, Part, parts_of
from openrooms_usd.stages.swatches import Swatch
from openrooms_usd.usd.layers import is_deactivated
from openrooms_usd.usd.semantics import read_label

ALL: Final = "all"
# Repeats of an object are of so many pieces of their materials, if they are as large, metres.
_PIECES: Final = 3
_SMALL_M: Final = 0.3
# How much lighter and warmer one piece is than another, at most, as shares: boards differ, and
# lots of cloth hardly do.
_SHIFTS: Final[Mapping[Substance, tuple[float, float]]] = {
    "wood": (0.06, 0.02),
    "leather": (0.05, 0.015),
    "fabric": (0.02, 0.006),
    "specular_stone": (0.02, 0.004),
    "rough_stone": (0.04, 0.01),
}
# What an annotated lamp is made of.
_LAMP: Final = "bulb"

# Returns the material of one part of an object in a look; None where the part keeps its own.
Rule = Callable[[Chooser, Part], Swatch | None]


@dataclass(frozen=True)
class Dresser:
    """Dresses objects and openings in all looks of a room.

    Attributes:
        context: The stage's context.
        choosers: One for each look.
        annotations: What people noted, by the name of an object or a category.
    """

    context: StageContext
    choosers: tuple[Chooser, ...]
    annotations: Mapping[str, Annotation]

    def objects(self, roots: Iterable[Usd.Prim]) -> dict[str, Dressed]:
        """What each object wears, by its path; those that need nothing are left out."""
        known: dict[tuple[Sdf.Path, int], Dressed] = {}
        objects: dict[str, Dressed] = {}
        for root in roots:
            own = self._is_named(root.GetName()) or not root.IsInstance()
            piece = 0 if own else self._piece(root)
            key = (root.GetPath() if own else root.GetPrototype().GetPath(), piece)
            if key not in known:
                known[key] = self.dressed(root, piece)
            if known[key].looks[0]:
                objects[str(root.GetPath())] = known[key]
        return objects

    def _is_named(self, name: str) -> bool:
        return name in self.context.room.materials.overrides or name in self.annotations

    def _piece(self, root: Usd.Prim) -> int:
        """Which of its few pieces an instance is; small things, and rooms of no style, have one."""
        if not self.context.room.style:
            return 0
        extent = UsdGeom.ModelAPI(root).GetExtentsHint()
        if not extent or max(b - a for a, b in zip(*extent[:2], strict=True)) < _SMALL_M:
            return 0
        return int(self.context.rng("materials", "piece", root.GetName()).integers(_PIECES))

    def dressed(self, root: Usd.Prim, piece: int = 0) -> Dressed:
        """What one object wears in each look.

        Args:
            root: The object.
            piece: Which of its repeats: each is cut from elsewhere.
        """
        name, category = root.GetName(), read_label(root, names.CATEGORY) or ""
        parts, overrides = parts_of(root), self.context.room.materials.overrides.get(name, {})
        _check_parts(self.context, root, overrides, parts)
        annotation = self.annotations.get(name) or self.annotations.get(category) or Annotation()
        free = [part for part in parts if not part.bound]
        asset = str(root.GetAssetInfo().get("name", "")) or name
        outfit = _Outfit(name, category, overrides, annotation, f"{asset}/{piece}")
        forced = frozenset(part.path for part in parts if part.bound)
        looks = tuple(outfit.worn(chooser, parts, free) for chooser in self.choosers)
        return Dressed(asset, category, looks, forced)


@dataclass(frozen=True)
class _Outfit:
    """All that says what an object is made of."""

    name: str
    category: str
    overrides: Mapping[str, Look]
    annotation: Annotation
    piece: str

    def worn(self, chooser: Chooser, parts: list[Part], free: list[Part]) -> dict[str, Swatch]:
        """The material of each part in one look, by its path; what keeps its own is left out."""
        kinds = sorted({part.kind for part in free})
        suite = suite_of(self.category, kinds)
        finishes = chooser.finishes(self.category, kinds, suite)
        worn: dict[str, Swatch] = {}
        for part in parts:
            swatch = self._overridden(chooser, part) or self._annotated(chooser, part)
            if swatch is None and not part.bound:
                swatch = self._usual(chooser, part, finishes[part.kind], suite)
                swatch = self._cut(swatch, suite) if chooser.ensemble else swatch
            if swatch is not None:
                worn[part.path] = swatch
        return worn

    def _cut(self, swatch: Swatch, suite: str) -> Swatch:
        """The material as this piece has it; what is made to match keeps its colour."""
        rng = generator(0, "piece", self.piece, swatch.family or "")
        s, t = (round(float(value), 3) for value in rng.random(2))
        value, hue = rng.uniform(-1.0, 1.0, 2) * _SHIFTS.get(swatch.substance, (0.0, 0.0))
        warm = 0.0 if suite else float(hue)
        light = 1.0 if suite else 1.0 + float(value)
        return swatch.cut((s, t), (light * (1.0 + warm), light, light * (1.0 - warm)))

    def _overridden(self, chooser: Chooser, part: Part) -> Swatch | None:
        """The override for the part, for its kind, or for all."""
        named = next((name for name in part.handles if name in self.overrides), ALL)
        look = self.overrides.get(named)
        # The whole object in wood still has a bulb of glass.
        if look is None or (named == ALL and part.kind == names.LIGHT_BULB):
            return None
        return chooser.asked(look, furniture_families, "overrides", self.name, named)

    def _annotated(self, chooser: Chooser, part: Part) -> Swatch | None:
        if self.annotation.is_lamp(part.name):
            return chooser.finish(_LAMP, self.category)
        noted = self.annotation.substances(part.name)
        if not noted:
            return None
        rng = chooser.rng("annotation", self.category, part.name)
        substance: Substance = noted[int(rng.integers(len(noted)))]
        return chooser.finish(GENERIC[substance], self.category)

    def _usual(self, chooser: Chooser, part: Part, finish: str, suite: str) -> Swatch:
        own = part.handles[:1] if FINISHES[finish].each else ()
        return chooser.finish(finish, suite or self.category, *own)


def read_annotations(context: StageContext) -> dict[str, Annotation]:
    """The annotations that the description names, without those of models marked as bad.

    Raises:
        InputError: A file is missing, or is no annotation.
    """
    found: dict[str, Annotation] = {}
    for name, file in context.room.materials.annotations.items():
        annotation = read_annotation(context.input(file))
        if annotation.bad:
            context.notes.append(f"{file}: it calls the model bad, so {name} is left to the tables")
        else:
            found[name] = annotation
    return found


def check_names(context: StageContext, known: Iterable[str], categories: Iterable[str]) -> None:
    """Refuse overrides and annotations of objects that are not there."""
    section, objects, kinds = context.room.materials, list(known), set(categories)
    for key, given, valid in (
        ("overrides", section.overrides, set(objects)),
        ("annotations", section.annotations, {*objects, *kinds}),
    ):
        for name in given:
            paths = [f"{path}/{name}" for path in (names.FURNITURE, names.OPENINGS)]
            if name in valid:
                continue
            if any(is_deactivated(context.stage, path) for path in paths):
                word = key.removesuffix("s")
                context.notes.append(f"{name}: deactivated, so its {word} is left out")
            else:
                raise DescriptionError(
                    f"there is no object or opening {name!r}{did_you_mean(name, valid)}",
                    place=f"materials.{key}.{name}",
                    remedy=f"there are: {', '.join(objects[:30]) or 'none'}",
                )


def _check_parts(
    context: StageContext, root: Usd.Prim, overrides: Mapping[str, Look], parts: list[Part]
) -> None:
    """Refuse overrides of parts that an object does not have."""
    name = root.GetName()
    known = sorted({part.name for part in parts} | {ALL})
    handles = {handle for part in parts for handle in part.handles}
    for part in overrides:
        if part in handles or part == ALL:
            continue
        if is_deactivated(context.stage, str(root.GetPath())):
            context.notes.append(f"{name}: parts are deactivated, so {part} is left out")
        else:
            raise DescriptionError(
                f"{name} has no part {part!r}{did_you_mean(part, known)}",
                place=f"materials.overrides.{name}.{part}",
                remedy=f"it has: {', '.join(known[:30])}",
            )
