"""What each object wears: overrides, then what people noted, then its own, then the tables."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.description.materials import MaterialChoice
from openrooms_usd.description.mistakes import Steps
from openrooms_usd.description.substances import Substance
from openrooms_usd.draws import generator
from openrooms_usd.library import textures
from openrooms_usd.library.styles.assignment.annotations import Annotation, read_annotation
from openrooms_usd.library.styles.assignment.rooms import Place, surface_of
from openrooms_usd.library.styles.assignment.weights import Weights, drawn
from openrooms_usd.library.styles.ensembles import Ensemble, ensemble_of
from openrooms_usd.library.styles.finishes import (
    FINISHES,
    GENERIC,
    Finish,
    finishes_of,
    furniture_families,
    suite_of,
)
from openrooms_usd.library.styles.interiors import INTERIORS
from openrooms_usd.spelling import did_you_mean
from openrooms_usd.steps.base import StepContext
from openrooms_usd.steps.materials.looks import ObjectSurface, PartMaterials, parts_of
from openrooms_usd.steps.materials.palette import Swatch
from openrooms_usd.usd.files.layers import is_deactivated
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
Rule = Callable[["Chooser", ObjectSurface], Swatch | None]
# The families of a substance that suit a place, with weights.
Suited = Callable[[Substance], Weights]
# Materials of each family that rooms draw from: few enough that rooms share their textures.
NUMBERS_PER_FAMILY: Final = 64
# Ratio of the probabilities of successive variants of a finish in a room.
_RARER_FACTOR: Final = 0.5
_COLOR_DECIMALS: Final = 3


@dataclass(frozen=True)
class Chooser:
    """Draws the materials of one look.

    Attributes:
        context: The seed, and what the description says.
        look: Which look; each draws its own.
    """

    context: StepContext
    look: int = 0

    @cached_property
    def ensemble(self) -> Ensemble | None:
        """What the room has in common in this look, where it has a style."""
        style = self.context.room.style
        return ensemble_of(INTERIORS[style], self.rng("ensemble")) if style else None

    def finishes(self, category: str, kinds: Sequence[str], suite: str = "") -> dict[str, str]:
        """The finish of each kind of part of an object; a suite of them draws one scheme."""
        rng, shared = (
            self.rng("scheme", *((suite,) if suite else (category, *kinds))),
            self.ensemble,
        )
        if shared is None:
            return finishes_of(category, kinds, rng)
        return finishes_of(category, kinds, rng, shared.interior.finishes, shared.metal)

    def rng(self, *key: str) -> np.random.Generator:
        """A generator of this look for a key."""
        look = (f"look_{self.look}",) if self.look else ()
        return self.context.rng("materials", *look, *key)

    def finish(self, name: str, *key: str) -> Swatch:
        """The swatch of a finish: one of the few that the room has of it.

        Args:
            name: A key of `FINISHES`.
            key: Names what it is for; the same key gives the same swatch.
        """
        shared = self.ensemble
        finish = shared.finish(name) if shared else FINISHES[name]
        lot = shared.lot(name) if shared else name
        variant = self._choice(finish, lot, key)
        number, rng = str(variant), self.rng("finish", lot, str(variant))
        if shared:
            family, color = shared.family(name, variant, rng), shared.color(name, variant, rng)
        else:
            family = drawn(rng, finish.families) if finish.families else None
            color = finish.colors[int(rng.integers(len(finish.colors)))] if finish.colors else None
        roughness = round(float(rng.uniform(*finish.roughness)), 3) if finish.roughness else None
        swatch = Swatch(
            finish.substance,
            family,
            int(rng.integers(NUMBERS_PER_FAMILY)) if family else 0,
            name,
            color,
            roughness,
            finish.metallic,
            transmission=finish.transmission,
            pane=finish.pane,
        )
        return self._scaled(swatch, name, number)

    def _choice(self, finish: Finish, name: str, key: tuple[str, ...]) -> int:
        rng = self.rng("choice", name, *key)
        if finish.each:
            return int(rng.integers(finish.choices))
        weights = {f"{i:03d}": _RARER_FACTOR**i for i in range(finish.choices)}
        return int(drawn(rng, weights))

    def asked(self, look: MaterialChoice, suited: Suited, *key: str) -> Swatch:
        """The swatch of a look that the description asks for.

        Args:
            look: The look.
            suited: Which families of a substance suit, where the look leaves the family open.
            key: Names what it is for; the same key gives the same swatch.
        """
        if look.is_constant:
            metal = look.metallic is not None and look.metallic >= 0.5
            substance = look.substance or ("metal" if metal else "paint")
            return Swatch(
                substance, None, 0, "constant", look.color, look.roughness, look.metallic or 0.0
            )
        rng = self.rng("look", *key)
        if look.file is not None:
            own = Swatch(look.substance or "paint", size=look.size, file=look.file)
            return self._scaled(own, *key)
        family = _family(look, suited, rng)
        number = int(rng.integers(NUMBERS_PER_FAMILY))
        swatch = Swatch(
            textures.substance_of(family),
            family,
            number if look.number is None else look.number,
            "",
            look.color,
            look.roughness,
            size=look.size or self.context.room.materials.texture_size,
        )
        return self._scaled(swatch, *key)

    def surface(self, place: Place) -> Swatch:
        """What floor or walls of a room of this type usually have."""
        rng, room, color = self.rng("surface", place), self.context.room.room, None
        if self.ensemble:
            family, substance, color = self.ensemble.surface(room, place, rng)
        else:
            family, substance = surface_of(room, place, rng)
        swatch = Swatch(substance, family, int(rng.integers(NUMBERS_PER_FAMILY)), color=color)
        sized = replace(swatch, size=self.context.room.materials.texture_size)
        return self._scaled(sized, place)

    def _scaled(self, swatch: Swatch, *key: str) -> Swatch:
        """The swatch with its factors, where the description asks for some."""
        scale, rng = self.context.room.materials.scale, self.rng("scale", *key)
        red, green, blue = (
            round(float(rng.uniform(*scale.color)), _COLOR_DECIMALS) for _ in range(3)
        )
        wear = round(float(rng.uniform(*scale.roughness)), _COLOR_DECIMALS)
        return replace(swatch, tint=(red, green, blue), wear=wear)


def _family(look: MaterialChoice, suited: Suited, rng: np.random.Generator) -> str:
    """The family that a look names, or one of the substance that it names."""
    substance = look.substance or next((s for s in textures.FAMILIES if s == look.family), None)
    return drawn(rng, suited(substance)) if substance else str(look.family)


@dataclass(frozen=True)
class MaterialAssigner:
    """Dresses objects and openings in all looks of a room.

    Attributes:
        context: The step's context.
        choosers: One for each look.
        annotations: What people noted, by the name of an object or a category.
    """

    context: StepContext
    choosers: tuple[Chooser, ...]
    annotations: Mapping[str, Annotation]

    def objects(self, roots: Iterable[Usd.Prim]) -> dict[str, PartMaterials]:
        """What each object wears, by its path; those that need nothing are left out."""
        known: dict[tuple[Sdf.Path, int], PartMaterials] = {}
        objects: dict[str, PartMaterials] = {}
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

    def dressed(self, root: Usd.Prim, piece: int = 0) -> PartMaterials:
        """What one object wears in each look.

        Args:
            root: The object.
            piece: Which of its repeats: each is cut from elsewhere.
        """
        name, category = root.GetName(), read_label(root, names.CATEGORY) or ""
        parts, overrides = parts_of(root), self.context.room.materials.overrides.get(name, {})
        annotation = self.annotations.get(name) or self.annotations.get(category) or Annotation()
        free = [part for part in parts if not part.bound]
        asset = str(root.GetAssetInfo().get("name", "")) or name
        outfit = _Assignment(name, category, overrides, annotation, f"{asset}/{piece}")
        forced = frozenset(part.path for part in parts if part.bound)
        looks = tuple(outfit.worn(chooser, parts, free) for chooser in self.choosers)
        return PartMaterials(asset, category, looks, forced)


@dataclass(frozen=True)
class _Assignment:
    """All that says what an object is made of."""

    name: str
    category: str
    overrides: Mapping[str, MaterialChoice]
    annotation: Annotation
    piece: str

    def worn(
        self, chooser: Chooser, parts: list[ObjectSurface], free: list[ObjectSurface]
    ) -> dict[str, Swatch]:
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

    def _overridden(self, chooser: Chooser, part: ObjectSurface) -> Swatch | None:
        """The override for the part, for its kind, or for all."""
        named = next((name for name in part.handles if name in self.overrides), ALL)
        look = self.overrides.get(named)
        # The whole object in wood still has a bulb of glass.
        if look is None or (named == ALL and part.kind == names.LIGHT_BULB):
            return None
        return chooser.asked(look, furniture_families, "overrides", self.name, named)

    def _annotated(self, chooser: Chooser, part: ObjectSurface) -> Swatch | None:
        if self.annotation.is_lamp(part.name):
            return chooser.finish(_LAMP, self.category)
        noted = self.annotation.substances(part.name)
        if not noted:
            return None
        rng = chooser.rng("annotation", self.category, part.name)
        substance: Substance = noted[int(rng.integers(len(noted)))]
        return chooser.finish(GENERIC[substance], self.category)

    def _usual(self, chooser: Chooser, part: ObjectSurface, finish: str, suite: str) -> Swatch:
        own = part.handles[:1] if FINISHES[finish].each else ()
        return chooser.finish(finish, suite or self.category, *own)


def read_annotations(context: StepContext) -> dict[str, Annotation]:
    """The annotations that the description names, without those of models marked as bad.

    Raises:
        InputError: A file is missing, or is not an annotation.
    """
    found: dict[str, Annotation] = {}
    for name, file in context.room.materials.annotations.items():
        annotation = read_annotation(context.input(file))
        if annotation.bad:
            context.notes.append(
                f"{file}: it marks the model as bad, so {name} gets default materials"
            )
        else:
            found[name] = annotation
    return found


def unknown_names(context: StepContext, roots: Sequence[Usd.Prim]) -> Iterator[tuple[Steps, str]]:
    """Overrides and annotations of objects that are not there, and of parts that they do not have.

    Args:
        context: The step's.
        roots: All objects and openings.

    Yields:
        The path in the description, and what is wrong there.
    """
    section, objects = context.room.materials, {root.GetName(): root for root in roots}
    kinds = {read_label(root, names.CATEGORY) or "" for root in roots}
    for key, given, valid in (
        ("overrides", section.overrides, {*objects}),
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
                said = f"there is no object or opening {name!r}{did_you_mean(name, valid)}"
                there = ", ".join(list(objects)[:30]) or "none"
                yield ("materials", key, name), f"{said}; there are: {there}"
    for name, parts in section.overrides.items():
        if name in objects:
            yield from _unknown_parts(context, objects[name], parts)


def _unknown_parts(
    context: StepContext, root: Usd.Prim, overrides: Mapping[str, MaterialChoice]
) -> Iterator[tuple[Steps, str]]:
    name, parts = root.GetName(), parts_of(root)
    known = sorted({part.name for part in parts} | {ALL})
    handles = {handle for part in parts for handle in part.handles}
    for part in overrides:
        if part in handles or part == ALL:
            continue
        if is_deactivated(context.stage, str(root.GetPath())):
            context.notes.append(f"{name}: parts are deactivated, so {part} is left out")
        else:
            said = f"{name} has no part {part!r}{did_you_mean(part, known)}"
            there = ", ".join(known[:30])
            yield ("materials", "overrides", name, part), f"{said}; it has: {there}"
