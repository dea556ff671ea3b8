"""What things are made of, chosen by people: materials and bindings in the edits.

Materials lie in ``/World/Looks``, their textures in ``layers/edits/textures``; each part that was
meant is bound to one of them. An instance cannot be edited inside, so an object with an edited part
stops being an instance. The steps leave alone what the edits bind.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Final

from pxr import Sdf, Usd, UsdGeom, UsdShade

from openrooms_usd import names
from openrooms_usd.description.materials import MaterialChoice
from openrooms_usd.description.room import Room, room_of
from openrooms_usd.edits.editing import editing
from openrooms_usd.edits.targets import Scope, object_of, parts_meant
from openrooms_usd.library.styles.assignment.rooms import Place, families_of
from openrooms_usd.library.styles.finishes import furniture_families
from openrooms_usd.steps.base import StepContext
from openrooms_usd.steps.materials.dressing import Chooser
from openrooms_usd.steps.materials.looks import define_all
from openrooms_usd.steps.materials.palette import TEXTURES, Palette
from openrooms_usd.usd.semantics import read_label
from openrooms_usd.usd.shading.binding import bind, open_instances

# Where the materials of edits are.
LOOKS: Final = f"{names.WORLD}/Looks"

_BINDING: Final = str(UsdShade.Tokens.materialBinding)
_API: Final = "MaterialBindingAPI"
# Of which surfaces of the shell a substance alone says which families suit.
_PLACES: Final[dict[str, Place]] = {"floor": "floor", "wall": "wall", "ceiling": "ceiling"}


@dataclass(frozen=True)
class Assigned:
    """What came of it.

    Attributes:
        material: The material's prim; empty where parts got their own materials back.
        parts: The parts that have it.
    """

    material: str
    parts: tuple[str, ...]


def look_of(said: Mapping[str, Any] | str) -> MaterialChoice:
    """A look as a room.yaml has it.

    Raises:
        DescriptionError: It is not valid; the message is that of compose.
    """
    look = room_of({"materials": {"floor": said}}).materials.floor
    assert look is not None, "it was given"
    return look


def assign(
    scene: Path, path: str, scope: Scope, look: MaterialChoice, base: Path | None = None
) -> Assigned:
    """Let parts of a composed room be made of something.

    Args:
        scene: The ``scene.usda`` of the room.
        path: The part that is pointed at.
        scope: How much is meant.
        look: What it shall be made of; what it leaves open is drawn.
        base: Where the names of files in the look begin; None for the scene's folder.

    Raises:
        InputError: There is no such part or material, or this is not a composed room.
        OutputError: The edits or a texture cannot be written.
        StageError: The room would not compose.
    """
    with editing(scene) as stage:
        parts = parts_meant(stage, path, scope)
        context = context_of(stage, scene, base)
        swatch = Chooser(context).asked(look, _suited(stage, path), "edits", path)
        palette = Palette(context)
        palette.publish([swatch])
        UsdGeom.Scope.Define(stage, LOOKS)
        folder = f"./{names.EDITS}/{TEXTURES}"
        made = define_all(stage, Sdf.Path(LOOKS), palette, [swatch], folder)[swatch]
        open_instances(stage, parts)
        for part in parts:
            bind(stage.OverridePrim(part), made)
        _forget_unused(stage.GetEditTarget().GetLayer())
    return Assigned(str(made.GetPath()), tuple(map(str, parts)))


def unassign(scene: Path, path: str, scope: Scope) -> Assigned:
    """Let parts be made of what the steps gave them again.

    Raises:
        InputError: There is no such part, or this is not a composed room.
        OutputError: The edits cannot be written.
        StageError: The room would not compose.
    """
    with editing(scene) as stage:
        layer = stage.GetEditTarget().GetLayer()
        parts = parts_meant(stage, path, scope)
        freed = [part for part in parts if _remove_binding(layer, part)]
        roots = [object_of(stage.GetPrimAtPath(part)).GetPath() for part in freed]
        for root in dict.fromkeys(roots):
            _closed(layer, root)
        _forget_unused(layer)
    return Assigned("", tuple(map(str, freed)))


def context_of(stage: Usd.Stage, scene: Path, base: Path | None = None) -> StepContext:
    """A context like that of a stage, whose files go to ``layers/edits``."""
    seed = _seed(stage)
    room = room_of({"seed": seed})
    folder = scene.parent / names.LAYERS / names.EDITS
    return StepContext(room, base or scene.parent, stage, folder)


def _seed(stage: Usd.Stage) -> int:
    """What the room was drawn from, as compose has noted it; 0 where it has not."""
    world = stage.GetPrimAtPath(names.WORLD)
    said = [
        list(found.Get() or ())
        for found in (world.GetAuthoredAttributes() if world else ())
        if found.GetName().endswith(":inputs")
    ]
    pairs = [dict(zip(row[::2], row[1::2], strict=False)) for row in said]
    return next((int(row["seed"]) for row in pairs if str(row.get("seed", "")).isdecimal()), 0)


def _suited(stage: Usd.Stage, path: str) -> Any:
    category = read_label(stage.GetPrimAtPath(path), names.CATEGORY) or ""
    if category in _PLACES:
        return partial(families_of, Room().room, _PLACES[category])
    return furniture_families


def _remove_binding(layer: Sdf.Layer, part: Sdf.Path) -> bool:
    """Take a binding to one of our materials away; whether there was one."""
    spec = layer.GetPrimAtPath(part)
    bound = spec.relationships.get(_BINDING) if spec else None
    if not bound or not any(_is_ours(path) for path in bound.targetPathList.explicitItems):
        return False
    spec.RemoveProperty(bound)
    said = spec.GetInfo("apiSchemas")
    said.prependedItems = [name for name in said.prependedItems if name != _API]
    spec.SetInfo("apiSchemas", said)
    if not said.prependedItems:
        spec.ClearInfo("apiSchemas")
    return True


def _closed(layer: Sdf.Layer, root: Sdf.Path) -> None:
    """Let an object in which nothing is edited any more be as it was."""
    spec = layer.GetPrimAtPath(root)
    _prune_below(spec)
    if not spec.nameChildren and spec.HasInfo("instanceable") and not spec.instanceable:
        if spec.specifier == Sdf.SpecifierDef:
            spec.instanceable = True
        else:
            spec.ClearInfo("instanceable")
    _prune(spec)


def _prune_below(spec: Sdf.PrimSpec) -> None:
    """Remove what is empty below."""
    for child in list(spec.nameChildren):
        _prune_below(child)
        if not child.nameChildren and not _says(child):
            del spec.nameChildren[child.name]


def _prune(spec: Sdf.PrimSpec | None) -> None:
    """Remove a prim that says nothing, and what is empty above it then."""
    while spec and not spec.nameChildren and not _says(spec):
        above, holder = spec.nameParent, spec.layer
        held = above.nameChildren if above else holder.rootPrims
        del held[spec.name]
        spec = above


def _says(spec: Sdf.PrimSpec) -> bool:
    keys = set(spec.ListInfoKeys()) - {"specifier"}
    return bool(spec.properties or keys or spec.specifier != Sdf.SpecifierOver)


def _is_ours(path: Sdf.Path) -> bool:
    return str(path.GetParentPath()) == LOOKS


def _forget_unused(layer: Sdf.Layer) -> None:
    """Remove materials that nothing is bound to any more; what others put there stays."""
    looks = layer.GetPrimAtPath(LOOKS)
    if not looks:
        return
    bound: set[Sdf.Path] = set()

    def note(path: Sdf.Path) -> None:
        spec = layer.GetObjectAtPath(path)
        if isinstance(spec, Sdf.RelationshipSpec) and spec.name == _BINDING:
            bound.update(spec.targetPathList.explicitItems)

    layer.Traverse(Sdf.Path.absoluteRootPath, note)
    for material in list(looks.nameChildren):
        if material.path not in bound and names.MATERIAL_CATEGORY in material.attributes:
            del looks.nameChildren[material.name]
    if not looks.nameChildren:
        above = looks.nameParent
        del above.nameChildren[looks.name]
        _prune(above)
