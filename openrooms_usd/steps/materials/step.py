"""The materials step: the room's surfaces by their section, objects by tables and overrides.

With several looks, everything is bound inside the variants of a set ``look``: those of the shell
and the openings on ``/World/Room``, those of each object in the look layer that its root refers to.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Final

from pxr import Sdf, Usd, UsdGeom, UsdShade

from openrooms_usd import names
from openrooms_usd.description.materials import MaterialChoice
from openrooms_usd.description.mistakes import FieldsError, Steps
from openrooms_usd.description.room import Room
from openrooms_usd.library.ownmaterials import files_of as material_files
from openrooms_usd.library.styles.assignment.annotations import files_of as annotation_files
from openrooms_usd.library.styles.assignment.rooms import Place, families_of
from openrooms_usd.library.styles.finishes import UNKNOWN, furniture_families
from openrooms_usd.portable import relative_text
from openrooms_usd.spelling import did_you_mean
from openrooms_usd.steps.base import StepContext
from openrooms_usd.steps.materials.dressing import (
    Chooser,
    MaterialAssigner,
    read_annotations,
    unknown_names,
)
from openrooms_usd.steps.materials.looks import (
    VARIANT_SET,
    PartMaterials,
    define_all,
    publish_look,
    variant,
)
from openrooms_usd.steps.materials.palette import TEXTURES, Palette, Swatch
from openrooms_usd.usd.files.layers import is_deactivated
from openrooms_usd.usd.semantics import read_label
from openrooms_usd.usd.shading.materials import bound_material

_BINDING_API: Final = "MaterialBindingAPI"
# The material of each surface, by its path.
Surfaces = dict[str, Swatch]
# Which field of the section says what a surface of the room is made of.
_FIELDS: Final[dict[Place, str]] = {"floor": "floor", "wall": "walls", "ceiling": "ceiling"}
# A painted ceiling whose colour is not described is white, whatever the walls are.
_CEILING: Final = MaterialChoice(family="paint", color=(0.8, 0.8, 0.785))
# What is fixed to walls and ceilings: the field that says its material, and its usual finish.
_FIXED: Final[dict[str, tuple[str, str]]] = {
    "skirting": ("trim", "white"),
    "cornice": ("trim", "white"),
    "picture_rail": ("trim", "white"),
    "wainscot": ("trim", "white"),
    "beam": ("beams", "wood"),
    "ceiling_grid": ("beams", "white"),
    "door": ("trim", "white"),
    "ceiling_lamp": ("trim", "white"),
}
# What stands in hallways.
_THINGS: Final = frozenset({"picture", "rug"})
_TILES: Final = MaterialChoice(substance="specular_stone")


class MaterialsStep:
    """Writes ``/World/Materials``, and bindings over the room and the furniture."""

    name = "materials"
    reads: tuple[str, ...] = ("layout", "alignment")

    def inputs(self, room: Room, source: Path) -> Iterable[str]:
        """The user's own materials and annotations.

        Raises:
            InputError: There is no such material.
        """
        section = room.materials
        overrides = [look for parts in section.overrides.values() for look in parts.values()]
        looks = [*section.surfaces, *overrides]
        own = {look.file for look in looks if look is not None and look.file is not None}
        files = [file for name in sorted(own) for file in material_files(source / name)]
        files += [f for n in section.annotations.values() for f in annotation_files(source / n)]
        return sorted({relative_text(file, source) for file in files})

    def author(self, context: StepContext) -> None:
        """Publish the textures and looks that are needed once, and bind them.

        Raises:
            DescriptionError: An override names an object or a part that is not there.
            InputError: A material of the user's own, or an annotation, cannot be read.
            OutputError: A texture or a look cannot be written.
        """
        furniture, openings = (
            _children(context, path) for path in (names.FURNITURE, names.OPENINGS)
        )
        wrong = [*unknown_names(context, [*furniture, *openings]), *unknown_walls(context)]
        if wrong:
            raise FieldsError(*wrong)
        choosers = tuple(Chooser(context, look) for look in range(context.room.materials.looks))
        dresser = MaterialAssigner(context, choosers, read_annotations(context))

        opened = _openings(dresser, openings)
        shells = [shell_surfaces(context, chooser) for chooser in choosers]
        surfaces = [shell | more for shell, more in zip(shells, opened, strict=True)]
        objects = dresser.objects(furniture)
        palette = Palette(context)
        palette.publish(_all_swatches(surfaces, objects.values()))
        _bind_room(context, palette, surfaces)
        _reference_looks(context, palette, objects)


def _children(context: StepContext, path: str) -> list[Usd.Prim]:
    prim = context.stage.GetPrimAtPath(path)
    return list(prim.GetChildren()) if prim else []


def _all_swatches(surfaces: Sequence[Surfaces], objects: Iterable[PartMaterials]) -> list[Swatch]:
    worn = [look for dressed in objects for look in dressed.looks]
    return [swatch for look in (*surfaces, *worn) for swatch in look.values()]


def _openings(dresser: MaterialAssigner, openings: Iterable[Usd.Prim]) -> list[Surfaces]:
    """The material of frames, leaves and handles in each look."""
    found: list[Surfaces] = [{} for _ in dresser.choosers]
    for opening in openings:
        for surfaces, worn in zip(found, dresser.dressed(opening).looks, strict=True):
            base = opening.GetPath()
            surfaces |= {str(base.AppendPath(path)): swatch for path, swatch in worn.items()}
    return found


def _bind_room(context: StepContext, palette: Palette, looks: Sequence[Surfaces]) -> None:
    """Bind the shell and the openings, in variants of the room where there are several looks."""
    stage = context.stage
    scope = UsdGeom.Scope.Define(stage, names.MATERIALS).GetPath()
    swatches = [swatch for look in looks for swatch in look.values()]
    materials = define_all(stage, scope, palette, swatches, context.asset(TEXTURES))
    layer, several = stage.GetEditTarget().GetLayer(), len(looks) > 1
    prims = _family(stage, [path for look in looks for path in look]) if several else []
    with Sdf.ChangeBlock():
        for number, surfaces in enumerate(looks):
            room = _variant(layer, number) if several else Sdf.Path(names.ROOM)
            for path in prims:
                Sdf.CreatePrimInLayer(layer, path.ReplacePrefix(names.ROOM, room))
            for path, swatch in surfaces.items():
                target = materials[swatch].GetPath()
                _bind(layer, Sdf.Path(path).ReplacePrefix(names.ROOM, room), target)
        if several:
            _select(layer, names.ROOM, context.room.materials.look)


def _family(stage: Usd.Stage, paths: Iterable[str]) -> list[Sdf.Path]:
    """Some prims of the room with all that stand beside them or their parents, in their order.

    What is said in a variant is weaker than what any layer says outside: prims named there alone
    would come before the others, and those who number prims would number them otherwise.
    """
    parents = {prefix.GetParentPath() for path in paths for prefix in Sdf.Path(path).GetPrefixes()}
    room = stage.GetPrimAtPath(names.ROOM)
    inner = (prim.GetPath() for prim in Usd.PrimRange(room)) if room else ()
    return [path for path in inner if path != names.ROOM and path.GetParentPath() in parents]


def _variant(layer: Sdf.Layer, look: int) -> Sdf.Path:
    """Where the opinions of one look of the room go."""
    Sdf.CreateVariantInLayer(layer, names.ROOM, VARIANT_SET, variant(look))
    return Sdf.Path(names.ROOM).AppendVariantSelection(VARIANT_SET, variant(look))


def _bind(layer: Sdf.Layer, path: Sdf.Path, material: Sdf.Path) -> None:
    """What `UsdShade.MaterialBindingAPI` writes, whichever look the edits have chosen.

    An edit target inside a variant has no name for materials outside of it.
    """
    prim = Sdf.CreatePrimInLayer(layer, path)
    schemas = Sdf.TokenListOp()
    schemas.prependedItems = [_BINDING_API]
    prim.SetInfo("apiSchemas", schemas)
    binding = Sdf.RelationshipSpec(prim, UsdShade.Tokens.materialBinding, custom=False)
    binding.targetPathList.explicitItems = [material]


def _select(layer: Sdf.Layer, path: str, look: int) -> None:
    prim = Sdf.CreatePrimInLayer(layer, path)
    prim.variantSelections[VARIANT_SET] = variant(look)


def _reference_looks(
    context: StepContext, palette: Palette, objects: Mapping[str, PartMaterials]
) -> None:
    """Let each object's root reference its look, above its asset: all in one change."""
    files = {id(look): publish_look(context, palette, look) for look in objects.values()}
    layer, section = context.stage.GetEditTarget().GetLayer(), context.room.materials
    with Sdf.ChangeBlock():
        for path, look in objects.items():
            prim = Sdf.CreatePrimInLayer(layer, path)
            prim.referenceList.Prepend(Sdf.Reference(files[id(look)]))
            if section.looks > 1:
                _select(layer, path, section.look)


def shell_surfaces(context: StepContext, chooser: Chooser) -> Surfaces:
    """The material of floor, ceiling, walls and what is fixed to them, in one look."""
    room = context.stage.GetPrimAtPath(names.ROOM)
    found: Surfaces = {}
    for prim in Usd.PrimRange(room) if room else ():
        if not prim.IsA(UsdGeom.Gprim) or prim.GetPath().HasPrefix(names.OPENINGS):
            continue
        category = read_label(prim, names.CATEGORY) or ""
        if bound_material(prim) is not None:
            continue
        if category in _THINGS:
            found[str(prim.GetPath())] = _thing(chooser, prim, category)
        else:
            found[str(prim.GetPath())] = _surface(context, chooser, prim, category)
    return found


def _thing(chooser: Chooser, prim: Usd.Prim, category: str) -> Swatch:
    """What a part of a thing in a hallway is made of."""
    thing = prim.GetParent()
    kinds = sorted({read_label(part, names.PART) or "" for part in thing.GetChildren()})
    kind, key = read_label(prim, names.PART) or "", str(thing.GetPath())
    finish = chooser.finishes(category, kinds, key)[kind]
    return chooser.finish(finish, "beyond", key, kind)


def unknown_walls(context: StepContext) -> Iterator[tuple[Steps, str]]:
    """Materials of walls and claddings that are not there: the path, and what is wrong there."""
    section = context.room.materials
    for key, given, scope in (
        ("accents", section.accents, names.WALLS),
        ("cladding", section.cladding, names.TRIM),
    ):
        group = context.stage.GetPrimAtPath(scope)
        known = [prim.GetName() for prim in group.GetChildren()] if group else []
        if key == "cladding":
            known = [name for name in known if not _is_mesh(context.stage, f"{scope}/{name}")]
        for name in given:
            if name not in known and not is_deactivated(context.stage, f"{scope}/{name}"):
                what = "wall" if key == "accents" else "cladding"
                said = f"there is no {what} {name!r}{did_you_mean(name, known)}"
                there = ", ".join(known[:30]) or "none"
                yield ("materials", key, name), f"{said}; there are: {there}"


def _is_mesh(stage: Usd.Stage, path: str) -> bool:
    """Whether it is one surface: a cladding has one for each wall."""
    return bool(stage.GetPrimAtPath(path).IsA(UsdGeom.Gprim))


def _surface(context: StepContext, chooser: Chooser, prim: Usd.Prim, category: str) -> Swatch:
    if category in _FIXED:
        return _fixed(context, chooser, category)
    if category == "cladding":
        return _clad(context, chooser, prim.GetParent().GetName())
    place = next((place for place in _FIELDS if place == category), None)
    if place is None:
        return chooser.finish(UNKNOWN, category)
    field, section = _FIELDS[place], context.room.materials
    look: MaterialChoice | None = getattr(section, field)
    if place == "ceiling" and (look is None or look == MaterialChoice(family="paint")):
        look = _CEILING
    key: tuple[str, ...] = (field,)
    if place == "wall" and prim.GetName() in section.accents:
        look, key = section.accents[prim.GetName()], ("accents", prim.GetName())
    if look is None:
        swatch = chooser.surface(place)
    else:
        swatch = chooser.asked(look, partial(families_of, context.room.room, place), *key)
    return swatch.turned if place == "floor" and _is_wide(prim) else swatch


def _fixed(context: StepContext, chooser: Chooser, category: str) -> Swatch:
    """Painted or wooden boards."""
    field, usual = _FIXED[category]
    look: MaterialChoice | None = getattr(context.room.materials, field)
    if look is None:
        return chooser.finish(usual, field)
    return chooser.asked(look, furniture_families, field)


def _clad(context: StepContext, chooser: Chooser, name: str) -> Swatch:
    """Tiles, unless the description says otherwise."""
    look = context.room.materials.cladding.get(name, _TILES)
    return chooser.asked(look, partial(families_of, context.room.room, "wall"), "cladding", name)


def _is_wide(prim: Usd.Prim) -> bool:
    """Whether boards should run along x: along the longer side of the room."""
    extent = UsdGeom.Boundable(prim).GetExtentAttr().Get()
    return bool(extent) and extent[1][0] - extent[0][0] > extent[1][1] - extent[0][1]
