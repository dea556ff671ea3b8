"""Rooms of a style: parts match across objects."""

from pathlib import Path

import pytest
from pxr import Usd

from openrooms_usd import names
from openrooms_usd.description.room import Room
from openrooms_usd.library.interiors import INTERIORS
from openrooms_usd.usd.materials import bound_material
from tests.stages.dressed import compose

CATEGORIES = ("table", "chair", "cabinet", "desk", "bookshelf", "side_table", "floor_lamp", "sofa")


def room(style: str | None, seed: int) -> Room:
    objects = [
        {"name": name, "category": name, "at": [1 + 1.6 * (i % 4), 1 + 2 * (i // 4)]}
        for i, name in enumerate(CATEGORIES)
    ]
    shell = {"polygon": [[0, 0], [8, 0], [8, 5], [0, 5]]}
    materials = {"resolution": 16}
    return Room.model_validate(
        {"seed": seed, "layout": shell, "alignment": {"objects": objects}, "materials": materials}
        | ({"style": style} if style else {})
    )


def families(stage: Usd.Stage, substance: str) -> dict[tuple[str, str], set[str]]:
    """The objects that have a family of a substance, by the family and its colour in the name."""
    found: dict[tuple[str, str], set[str]] = {}
    for thing in stage.GetPrimAtPath(names.FURNITURE).GetChildren():
        for prim in Usd.PrimRange(thing, Usd.TraverseInstanceProxies()):
            material = bound_material(prim)
            if material is None:
                continue
            said = material.GetPrim().GetAttribute
            if said(names.MATERIAL_CATEGORY).Get() == substance:
                family = said(names.MATERIAL_FAMILY).Get() or ""
                number = str(said(names.MATERIAL_NUMBER).Get())
                found.setdefault((family, number), set()).add(thing.GetName())
    return found


@pytest.mark.parametrize("style", ["mid_century", "industrial"])
def test_parts_match_across_objects(style: str, tmp_path: Path) -> None:
    stage = compose(tmp_path, room(style, 4))
    woods = families(stage, "wood")
    woods = {key: things for key, things in woods.items() if key[0]}
    allowed = {wood for pair in INTERIORS[style].woods for wood in pair}  # type: ignore[index]
    assert {family for family, _ in woods} <= allowed and len(woods) <= 2
    assert max(len(things) for things in woods.values()) >= 3
    metals = {family for family, _ in families(stage, "metal")}
    assert len(metals) <= 2
