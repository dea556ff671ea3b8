"""Rooms of a style: parts match across objects."""

from pathlib import Path

import numpy as np
import pytest
from pxr import Usd

from openrooms_usd import names
from openrooms_usd.description.room import Room
from openrooms_usd.library.styles.interiors import INTERIORS
from openrooms_usd.usd.shading.materialreader import read_preview_surface
from openrooms_usd.usd.shading.materials import Texture, bound_material
from tests.steps.dressed import compose

CATEGORIES = ("table", "chair", "cabinet", "desk", "bookshelf", "side_table", "floor_lamp", "sofa")


def room(style: str | None, seed: int) -> Room:
    objects = [
        {"name": name, "category": name, "at": [1 + 1.6 * (i % 4), 1 + 2 * (i // 4)]}
        for i, name in enumerate(CATEGORIES)
    ]
    shell = {"polygon": [[0, 0], [8, 0], [8, 5], [0, 5]]}
    materials = {"resolution": 16}
    return Room.model_validate(
        {"seed": seed, "layout": shell, "furniture": {"objects": objects}, "materials": materials}
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


def chairs(style: str, seed: int) -> Room:
    objects = [
        {"name": f"chair_{i}", "category": "chair", "at": [1 + i, 2], "style": "slat"}
        for i in range(6)
    ]
    return Room.model_validate(
        {
            "seed": seed,
            "style": style,
            "layout": {"polygon": [[0, 0], [8, 0], [8, 5], [0, 5]]},
            "furniture": {"objects": objects},
            "materials": {"resolution": 16},
        }
    )


def test_repeats_are_of_a_few_pieces_of_the_same_wood(tmp_path: Path) -> None:
    stage = compose(tmp_path, chairs("rustic", 3))
    things = stage.GetPrimAtPath(names.FURNITURE).GetChildren()
    assert all(thing.IsInstance() for thing in things)
    assert 2 <= len({thing.GetPrototype().GetPath() for thing in things}) <= 3
    places, files, scales = set(), set(), set()
    for thing in things:
        for prim in Usd.PrimRange(thing, Usd.TraverseInstanceProxies()):
            if prim.GetName().startswith("leg"):
                surface, _ = read_preview_surface(bound_material(prim))
                color = surface.base_color
                assert isinstance(color, Texture)
                places.add(color.uv_translation)
                files.add(Path(color.file).name)
                scales.add(color.scale)
                normal = surface.normal
                assert isinstance(normal, Texture)
                assert normal.uv_translation == color.uv_translation
    assert len(files) == 1 and len(places) == len(scales) >= 2
    factors = np.array([scale[:3] for scale in scales])
    assert factors.min() > 0.9 and factors.max() < 1.1 and np.ptp(factors, axis=0).min() > 0.002


def test_equal_seeds_give_equal_bytes(tmp_path: Path) -> None:
    for name in ("a", "b"):
        compose(tmp_path / name, chairs("industrial", 5))
    files = {
        name: {
            str(file.relative_to(tmp_path / name)): file.read_bytes()
            for file in sorted((tmp_path / name).rglob("*"))
            if file.is_file()
        }
        for name in ("a", "b")
    }
    assert files["a"] == files["b"]
