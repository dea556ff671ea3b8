"""The materials stage: the room's surfaces by its section, objects by rules and overrides."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Final

from pxr import Sdf, Usd, UsdGeom, UsdShade

from openrooms_usd import names
from openrooms_usd.description.materials import Look
from openrooms_usd.description.nearest import did_you_mean
from openrooms_usd.description.room import Room
from openrooms_usd.errors import DescriptionError
from openrooms_usd.library.finishes import ACROSS, FINISHES, UNKNOWN, finishes_of
from openrooms_usd.stages.base import StageContext
from openrooms_usd.stages.looks import Dressed, Part, parts_of, publish_look
from openrooms_usd.stages.swatches import TEXTURES, Palette, Swatch, from_finish, from_look
from openrooms_usd.usd.activation import is_deactivated
from openrooms_usd.usd.materials import bound_material
from openrooms_usd.usd.semantics import read_label

ALL: Final = "all"
# Which field of the section says what a surface of the room is made of, and which variant of each
# family suits it there.
_SURFACES: Final[dict[str, tuple[str, dict[str, str]]]] = {
    "floor": ("floor", {"wood": "floor", "paint": "powder", "fabric": "basket"}),
    "wall": ("walls", {"wood": "panel", "paint": "matt", "fabric": "plain"}),
    "ceiling": ("ceiling", {"wood": "panel", "paint": "matt", "fabric": "plain"}),
}
# A ceiling that is not described is white, whatever the walls are.
_CEILING: Final = (0.8, 0.8, 0.785)
# What a family means on furniture.
_FURNITURE: Final = {"wood": "panel", "paint": "satin"}


class MaterialsStage:
    """Writes ``/World/Materials``, and bindings over the room and the furniture."""

    name = "materials"
    reads: tuple[str, ...] = ("layout", "alignment")

    def inputs(self, room: Room, source: Path) -> Iterable[str]:
        """None: everything is generated."""
        return ()

    def author(self, context: StageContext) -> None:
        """Publish the textures and looks that are needed once, and bind them.

        Raises:
            DescriptionError: An override names an object or a part that is not there.
            OutputError: A texture or a look cannot be written.
        """
        _check_names(context)
        palette = Palette(context)
        surfaces = {**_shell(context), **_openings(context)}
        objects = _objects(context)
        worn = (swatch for look in objects.values() for swatch in look.swatches.values())
        palette.publish([*surfaces.values(), *worn])
        _bind_room(context, palette, surfaces)
        _reference_looks(context, palette, objects)


def _children(context: StageContext, path: str) -> list[Usd.Prim]:
    prim = context.stage.GetPrimAtPath(path)
    return list(prim.GetChildren()) if prim else []


def _check_names(context: StageContext) -> None:
    """Refuse overrides of objects that are not there."""
    known = [
        prim.GetName()
        for path in (names.FURNITURE, names.OPENINGS)
        for prim in _children(context, path)
    ]
    for name in context.room.materials.overrides:
        paths = [f"{path}/{name}" for path in (names.FURNITURE, names.OPENINGS)]
        if name in known:
            continue
        if any(is_deactivated(context.stage, path) for path in paths):
            context.notes.append(f"{name}: deactivated, so its override is left out")
        else:
            raise DescriptionError(
                f"there is no object or opening {name!r}{did_you_mean(name, known)}",
                place=f"materials.overrides.{name}",
                remedy=f"there are: {', '.join(known[:30]) or 'none'}",
            )


def _shell(context: StageContext) -> dict[str, Swatch]:
    """The material of floor, ceiling and walls, by prim path."""
    room = context.stage.GetPrimAtPath(names.ROOM)
    found: dict[str, Swatch] = {}
    for prim in Usd.PrimRange(room) if room else ():
        if not prim.IsA(UsdGeom.Gprim) or prim.GetPath().HasPrefix(names.OPENINGS):
            continue
        category = read_label(prim, names.CATEGORY) or ""
        if bound_material(prim) is None:
            found[str(prim.GetPath())] = _surface(context, prim, category)
    return found


def _surface(context: StageContext, prim: Usd.Prim, category: str) -> Swatch:
    if category not in _SURFACES:
        return from_finish(context, UNKNOWN, category)
    field, variants = _SURFACES[category]
    look: Look = getattr(context.room.materials, field)
    if category == "ceiling" and look.family == "paint" and look.color is None:
        look = look.model_copy(update={"color": _CEILING})
    swatch = from_look(context, look, variants, field)
    return swatch.turned if category == "floor" and _is_wide(prim) else swatch


def _is_wide(prim: Usd.Prim) -> bool:
    """Whether boards should run along x: along the longer side of the room."""
    extent = UsdGeom.Boundable(prim).GetExtentAttr().Get()
    return bool(extent) and extent[1][0] - extent[0][0] > extent[1][1] - extent[0][1]


def _openings(context: StageContext) -> dict[str, Swatch]:
    """The material of frames, leaves and handles, by prim path."""
    found: dict[str, Swatch] = {}
    for opening in _children(context, names.OPENINGS):
        dressed = _dressed(context, opening, parts_of(opening))
        base = opening.GetPath()
        found |= {str(base.AppendPath(path)): s for path, s in dressed.swatches.items()}
    return found


def _objects(context: StageContext) -> dict[str, Dressed]:
    """What each object wears, by its path; those that need nothing are left out."""
    known: dict[Sdf.Path, Dressed] = {}
    objects: dict[str, Dressed] = {}
    for root in _children(context, names.FURNITURE):
        own = root.GetName() in context.room.materials.overrides or not root.IsInstance()
        key = root.GetPath() if own else root.GetPrototype().GetPath()
        if key not in known:
            known[key] = _dressed(context, root, parts_of(root))
        if known[key].swatches:
            objects[str(root.GetPath())] = known[key]
    return objects


def _dressed(context: StageContext, root: Usd.Prim, parts: list[Part]) -> Dressed:
    """Overrides where there are some, the rules of the category elsewhere."""
    category = read_label(root, names.CATEGORY) or ""
    overrides = context.room.materials.overrides.get(root.GetName(), {})
    _check_parts(context, root, overrides, parts)
    free = sorted({part.name for part in parts if not part.bound})
    rng = context.rng("materials", "scheme", category, *free)
    finishes = finishes_of(category, free, rng)
    swatches: dict[str, Swatch] = {}
    for part in parts:
        chosen = part.name if part.name in overrides else ALL
        look = overrides.get(chosen)
        # The whole object in wood still has a bulb of glass.
        if look is not None and (chosen != ALL or part.name != names.LIGHT_BULB):
            swatch = from_look(context, look, _FURNITURE, root.GetName(), chosen)
        elif part.bound:
            continue
        else:
            finish = finishes[part.name]
            own = (part.path.rpartition("/")[2],) if FINISHES[finish].each else ()
            swatch = from_finish(context, finish, category, *own)
        swatches[part.path] = swatch.turned if part.name in ACROSS else swatch
    asset = str(root.GetAssetInfo().get("name", "")) or root.GetName()
    forced = frozenset(part.path for part in parts if part.bound)
    return Dressed(asset, category, swatches, forced)


def _check_parts(
    context: StageContext, root: Usd.Prim, overrides: Mapping[str, Look], parts: list[Part]
) -> None:
    """Refuse overrides of parts that an object does not have."""
    name = root.GetName()
    known = sorted({part.name for part in parts} | {ALL})
    for part in overrides:
        if part in known:
            continue
        if is_deactivated(context.stage, str(root.GetPath())):
            context.notes.append(f"{name}: parts are deactivated, so {part} is left out")
        else:
            raise DescriptionError(
                f"{name} has no part {part!r}{did_you_mean(part, known)}",
                place=f"materials.overrides.{name}.{part}",
                remedy=f"it has: {', '.join(known)}",
            )


def _bind_room(context: StageContext, palette: Palette, surfaces: Mapping[str, Swatch]) -> None:
    stage = context.stage
    scope = UsdGeom.Scope.Define(stage, names.MATERIALS).GetPath()
    folder = context.asset(TEXTURES)
    distinct = {palette.name(swatch): swatch for swatch in surfaces.values()}
    materials = {
        name: palette.define(stage, scope.AppendChild(name), swatch, folder)
        for name, swatch in sorted(distinct.items())
    }
    for path, swatch in surfaces.items():
        prim = stage.OverridePrim(path)
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(materials[palette.name(swatch)])


def _reference_looks(
    context: StageContext, palette: Palette, objects: Mapping[str, Dressed]
) -> None:
    """Let each object's root reference its look, above its asset: all in one change."""
    files = {id(look): publish_look(context, palette, look) for look in objects.values()}
    layer = context.stage.GetEditTarget().GetLayer()
    with Sdf.ChangeBlock():
        for path, look in objects.items():
            prim = Sdf.CreatePrimInLayer(layer, path)
            prim.referenceList.Prepend(Sdf.Reference(files[id(look)]))
