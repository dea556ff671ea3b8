"""The materials stage: the room's surfaces by their section, objects by tables and overrides.

With several looks, everything is bound inside the variants of a set ``look``: those of the shell
and the openings on ``/World/Room``, those of each object in the look layer that its root refers to.
"""

from collections.abc import Iterable, Mapping, Sequence
from os.path import relpath
from pathlib import Path
from typing import Final

from pxr import Sdf, Usd, UsdGeom, UsdShade

from openrooms_usd import names
from openrooms_usd.description.room import Room
from openrooms_usd.library.assignment.annotations import files_of as annotation_files
from openrooms_usd.library.ownmaterials import files_of as material_files
from openrooms_usd.stages.base import StageContext
from openrooms_usd.stages.choosing import Chooser
from openrooms_usd.stages.dressing import Dresser, check_names, read_annotations
from openrooms_usd.stages.looks import (
    VARIANT_SET,
    Dressed,
    define_all,
    publish_look,
    variant,
)
from openrooms_usd.stages.palette import TEXTURES, Palette
from openrooms_usd.stages.surfaces import Surfaces, check_walls, shell_surfaces
from openrooms_usd.stages.swatches import Swatch
from openrooms_usd.usd.semantics import read_label

_BINDING_API: Final = "MaterialBindingAPI"


class MaterialsStage:
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
        return sorted({Path(relpath(file, source)).as_posix() for file in files})

    def author(self, context: StageContext) -> None:
        """Publish the textures and looks that are needed once, and bind them.

        Raises:
            DescriptionError: An override names an object or a part that is not there.
            InputError: A material of the user's own, or an annotation, cannot be read.
            OutputError: A texture or a look cannot be written.
        """
        furniture, openings = (
            _children(context, path) for path in (names.FURNITURE, names.OPENINGS)
        )
        categories = {read_label(prim, names.CATEGORY) or "" for prim in (*furniture, *openings)}
        check_names(context, [prim.GetName() for prim in (*furniture, *openings)], categories)
        choosers = tuple(Chooser(context, look) for look in range(context.room.materials.looks))
        dresser = Dresser(context, choosers, read_annotations(context))

        opened = _openings(dresser, openings)
        check_walls(context)
        shells = [shell_surfaces(context, chooser) for chooser in choosers]
        surfaces = [shell | more for shell, more in zip(shells, opened, strict=True)]
        objects = dresser.objects(furniture)
        palette = Palette(context)
        palette.publish(_all_swatches(surfaces, objects.values()))
        _bind_room(context, palette, surfaces)
        _reference_looks(context, palette, objects)


def _children(context: StageContext, path: str) -> list[Usd.Prim]:
    prim = context.stage.GetPrimAtPath(path)
    return list(prim.GetChildren()) if prim else []


def _all_swatches(surfaces: Sequence[Surfaces], objects: Iterable[Dressed]) -> list[Swatch]:
    worn = [look for dressed in objects for look in dressed.looks]
    return [swatch for look in (*surfaces, *worn) for swatch in look.values()]


def _openings(dresser: Dresser, openings: Iterable[Usd.Prim]) -> list[Surfaces]:
    """The material of frames, leaves and handles in each look."""
    found: list[Surfaces] = [{} for _ in dresser.choosers]
    for opening in openings:
        for surfaces, worn in zip(found, dresser.dressed(opening).looks, strict=True):
            base = opening.GetPath()
            surfaces |= {str(base.AppendPath(path)): swatch for path, swatch in worn.items()}
    return found


def _bind_room(context: StageContext, palette: Palette, looks: Sequence[Surfaces]) -> None:
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
    context: StageContext, palette: Palette, objects: Mapping[str, Dressed]
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
