"""What the room itself wears: floor, ceiling, each of its walls, and what is fixed to them."""

from functools import partial
from typing import Final

from pxr import Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.description.materials import Look
from openrooms_usd.description.nearest import did_you_mean
from openrooms_usd.errors import DescriptionError
from openrooms_usd.library.assignment.rooms import Place, families_of
from openrooms_usd.library.finishes import UNKNOWN, furniture_families
from openrooms_usd.stages.base import StageContext
from openrooms_usd.stages.choosing import Chooser
from openrooms_usd.stages.swatches import Swatch
from openrooms_usd.usd.layers import is_deactivated
from openrooms_usd.usd.materials import bound_material
from openrooms_usd.usd.semantics import read_label

# The material of each surface, by its path.
Surfaces = dict[str, Swatch]

# Which field of the section says what a surface of the room is made of.
_FIELDS: Final[dict[Place, str]] = {"floor": "floor", "wall": "walls", "ceiling": "ceiling"}
# A painted ceiling whose colour is not described is white, whatever the walls are.
_CEILING: Final = Look(family="paint", color=(0.8, 0.8, 0.785))
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
_TILES: Final = Look(substance="specular_stone")


def shell_surfaces(context: StageContext, chooser: Chooser) -> Surfaces:
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


def check_walls(context: StageContext) -> None:
    """Refuse materials of walls and claddings that are not there.

    Raises:
        DescriptionError: A name is that of no wall or cladding.
    """
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
                raise DescriptionError(
                    f"there is no {what} {name!r}{did_you_mean(name, known)}",
                    place=f"materials.{key}.{name}",
                    remedy=f"there are: {', '.join(known[:30]) or 'none'}",
                )


def _is_mesh(stage: Usd.Stage, path: str) -> bool:
    """Whether it is one surface: a cladding has one for each wall."""
    return bool(stage.GetPrimAtPath(path).IsA(UsdGeom.Gprim))


def _surface(context: StageContext, chooser: Chooser, prim: Usd.Prim, category: str) -> Swatch:
    if category in _FIXED:
        return _fixed(context, chooser, category)
    if category == "cladding":
        return _clad(context, chooser, prim.GetParent().GetName())
    place = next((place for place in _FIELDS if place == category), None)
    if place is None:
        return chooser.finish(UNKNOWN, category)
    field, section = _FIELDS[place], context.room.materials
    look: Look | None = getattr(section, field)
    if place == "ceiling" and (look is None or look == Look(family="paint")):
        look = _CEILING
    key: tuple[str, ...] = (field,)
    if place == "wall" and prim.GetName() in section.accents:
        look, key = section.accents[prim.GetName()], ("accents", prim.GetName())
    if look is None:
        swatch = chooser.surface(place)
    else:
        swatch = chooser.asked(look, partial(families_of, context.room.room, place), *key)
    return swatch.turned if place == "floor" and _is_wide(prim) else swatch


def _fixed(context: StageContext, chooser: Chooser, category: str) -> Swatch:
    """Painted or wooden boards."""
    field, usual = _FIXED[category]
    look: Look | None = getattr(context.room.materials, field)
    if look is None:
        return chooser.finish(usual, field)
    return chooser.asked(look, furniture_families, field)


def _clad(context: StageContext, chooser: Chooser, name: str) -> Swatch:
    """Tiles, unless the description says otherwise."""
    look = context.room.materials.cladding.get(name, _TILES)
    return chooser.asked(look, partial(families_of, context.room.room, "wall"), "cladding", name)


def _is_wide(prim: Usd.Prim) -> bool:
    """Whether boards should run along x: along the longer side of the room."""
    extent = UsdGeom.Boundable(prim).GetExtentAttr().Get()
    return bool(extent) and extent[1][0] - extent[0][0] > extent[1][1] - extent[0][1]
