"""What the description says about materials, and what is drawn where it says nothing."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom, UsdPhysics

from openrooms_usd import names
from openrooms_usd.description.room import Room
from openrooms_usd.errors import DescriptionError, InputError
from openrooms_usd.library.friction import physics_of
from openrooms_usd.library.pictures import write_png
from openrooms_usd.steps.materials.step import MaterialsStep
from openrooms_usd.usd.shading import physics
from openrooms_usd.usd.shading.materialreader import read_preview_surface as read
from openrooms_usd.usd.shading.materials import PreviewSurface, Texture, bound_material
from openrooms_usd.usd.shading.textures import read_texture
from tests.steps.dressed import compose

THING = f"{names.FURNITURE}/thing/Geometry"


def room(source: str = "", **materials: object) -> Room:
    thing = {"name": "thing", "category": "chair", "at": [2, 2]}
    more = {"from": "file", "file": source} if source else {"style": "slat"}
    return Room.model_validate(
        {
            "room": "bathroom",
            "furniture": {"objects": [thing | more]},
            "materials": {"resolution": 16, **materials},
        }
    )


def material(stage: Usd.Stage, path: str) -> Usd.Prim:
    found = bound_material(stage.GetPrimAtPath(path))
    assert found is not None
    return found.GetPrim()


def surface(stage: Usd.Stage, path: str) -> PreviewSurface:
    found = bound_material(stage.GetPrimAtPath(path))
    assert found is not None
    shown, losses = read(found)
    assert losses == ()
    return shown


def said(stage: Usd.Stage, path: str, name: str) -> object:
    return material(stage, path).GetAttribute(f"openrooms:material:{name}").Get()


def parts(stage: Usd.Stage) -> Iterator[Usd.Prim]:
    root = stage.GetPrimAtPath(THING)
    prims = Usd.PrimRange(root, Usd.TraverseInstanceProxies())
    return (prim for prim in prims if prim.IsA(UsdGeom.Gprim))


def test_a_room_has_what_its_type_usually_has(tmp_path: Path) -> None:
    stage = compose(tmp_path, room())
    assert said(stage, names.FLOOR, "category") in ("specular_stone", "rough_stone")
    ceiling = surface(stage, names.CEILING).base_color
    assert isinstance(ceiling, Texture) and read_texture(ceiling.file).mean() > 0.85
    assert said(stage, names.CEILING, "category") == "paint"


@pytest.mark.slow
def test_one_material_can_be_named_and_is_the_same_everywhere(tmp_path: Path) -> None:
    terrazzo = {"family": "terrazzo", "number": 5, "size": "2 m"}
    stage = compose(
        tmp_path, room(floor=terrazzo, walls=terrazzo, overrides={"thing": {"all": terrazzo}})
    )
    paths = [names.FLOOR, f"{names.WALLS}/wall_0", *(str(p.GetPath()) for p in parts(stage))]
    files = {getattr(surface(stage, path).base_color, "file", None) for path in paths}
    assert len(files) == 1 and "terrazzo_5_" in str(files.pop())
    for path in paths:
        assert said(stage, path, "family") == "terrazzo" and said(stage, path, "number") == 5
        assert said(stage, path, "category") == "specular_stone"
        np.testing.assert_allclose(said(stage, path, "size"), 2.0)


def test_constants_have_no_textures_but_friction(tmp_path: Path) -> None:
    gold = {"color": [1.0, 0.7, 0.3], "roughness": 0.1, "metallic": 1.0}
    mat = {"color": [0.1, 0.1, 0.1], "metallic": 0.0, "substance": "rubber"}
    stage = compose(tmp_path, room(floor=mat, overrides={"thing": {"leg": gold}}))
    leg = next(str(p.GetPath()) for p in parts(stage) if p.GetName().startswith("leg"))
    shown = surface(stage, leg)
    assert shown.base_color == pytest.approx((1.0, 0.7, 0.3)) and shown.metallic == 1.0
    assert shown.roughness == pytest.approx(0.1) and shown.f0 == pytest.approx(0.05)
    assert said(stage, leg, "category") == "metal" and said(stage, leg, "family") is None
    assert said(stage, names.FLOOR, "category") == "rubber"
    expected = physics_of("rubber", (0.1, 0.1, 0.1), 0.5)
    found = physics.read(material(stage, names.FLOOR))
    assert found is not None
    assert found.static_friction == pytest.approx(expected.static_friction)
    assert found.friction_spread == pytest.approx(expected.friction_spread)
    assert material(stage, leg).HasAPI(UsdPhysics.MaterialAPI)


def test_friction_goes_by_the_means_of_the_textures(tmp_path: Path) -> None:
    stage = compose(tmp_path, room(floor={"family": "oak_planks", "number": 3}))
    shown, found = surface(stage, names.FLOOR), physics.read(material(stage, names.FLOOR))
    assert isinstance(shown.base_color, Texture) and isinstance(shown.roughness, Texture)
    encoded = read_texture(shown.base_color.file).astype(float)
    linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    red, green, blue = linear.mean(axis=(0, 1))
    expected = physics_of("wood", (red, green, blue), read_texture(shown.roughness.file).mean())
    assert found is not None
    for name in ("static_friction", "dynamic_friction", "restitution", "density"):
        assert getattr(found, name) == pytest.approx(getattr(expected, name), abs=1e-6)


def test_scales_stay_within_their_range_and_below_one(tmp_path: Path) -> None:
    plain = compose(tmp_path / "plain", room())
    scale = {"color": [0.7, 1.3], "roughness": [0.8, 1.2]}
    scaled = compose(tmp_path / "scaled", room(scale=scale))
    factors = []
    for path in (names.FLOOR, names.CEILING, f"{names.WALLS}/wall_0"):
        before, after = surface(plain, path), surface(scaled, path)
        for shown, limits in (("base_color", (0.7, 1.3)), ("roughness", (0.8, 1.2))):
            old, new = getattr(before, shown), getattr(after, shown)
            assert old.file.rpartition("/")[2] == new.file.rpartition("/")[2]
            assert all(limits[0] <= f <= limits[1] for f in new.scale[:3])
            top = read_texture(new.file).max(axis=(0, 1)).astype(float)
            if shown == "base_color":
                top = ((top + 0.055) / 1.055) ** 2.4
            assert np.all(top * new.scale[: len(top)] <= 1.0 + 1e-5)
            factors.append(new.scale[:3])
    assert len(set(factors)) == len(factors)
    # Where the range leads beyond 1, the brightest and the roughest texel are at 1.
    wild = compose(tmp_path / "wild", room(scale={"color": [3, 4], "roughness": [3, 4]}))
    ceiling = surface(wild, names.CEILING)
    for shown, gamma in ((ceiling.base_color, 2.4), (ceiling.roughness, 1.0)):
        assert isinstance(shown, Texture)
        top = read_texture(shown.file).max(axis=(0, 1)).astype(float)
        top = ((top + 0.055) / 1.055) ** gamma if gamma > 1 else top
        np.testing.assert_allclose(top * shown.scale[: len(top)], 1.0, rtol=1e-5)


@pytest.fixture
def split_chair(tmp_path: Path) -> Path:
    """A foreign chair in 300 pieces, as exporters split them."""
    lines, count = [], 0
    for i in range(300):
        name = f"part{i}" if i < 3 else f"leg_{i}" if i < 100 else f"piece_{i:03d}"
        x, z = (i % 20) * 0.02, (i // 20) * 0.05
        corners = [(x, z, 0), (x + 0.01, z, 0), (x, z + 0.03, 0.4)]
        lines += [f"o {name}", *(f"v {a} {b} {c}" for a, b, c in corners)]
        lines.append(f"f {count + 1} {count + 2} {count + 3}")
        count += 3
    (tmp_path / "chair.obj").write_text("\n".join(lines), encoding="utf-8")
    return tmp_path


@pytest.mark.slow
def test_parts_of_one_kind_share_a_material(split_chair: Path) -> None:
    stage = compose(split_chair, room("chair.obj", overrides={"thing": {"leg": "metal"}}))
    by_kind: dict[str, set[str]] = {}
    for prim in parts(stage):
        kind = prim.GetName().rstrip("0123456789_")
        by_kind.setdefault(kind, set()).add(material(stage, str(prim.GetPath())).GetName())
    assert set(by_kind) == {"part", "leg", "piece"}
    assert all(len(found) == 1 for found in by_kind.values())
    # An override of one part beats that of its kind.
    overrides = {"thing": {"leg": "metal", "leg_7": "wood"}}
    stage = compose(split_chair, room("chair.obj", overrides=overrides))
    assert said(stage, f"{THING}/leg_7", "category") == "wood"
    assert said(stage, f"{THING}/leg_8", "category") == "metal"


@pytest.mark.slow
def test_annotations_say_what_numbered_parts_are(split_chair: Path) -> None:
    (split_chair / "ann.txt").write_text("# 3\n0 6\n1 8 8\n2 9\n", encoding="utf-8")
    given = {"annotations": {"thing": "ann.txt"}, "overrides": {"thing": {"part1": "leather"}}}
    described = room("chair.obj", **given)
    assert list(MaterialsStep().inputs(described, split_chair)) == ["ann.txt"]
    stage = compose(split_chair, described)
    assert said(stage, f"{THING}/part0", "category") == "metal"
    assert said(stage, f"{THING}/part1", "category") == "leather"
    assert material(stage, f"{THING}/part2").GetName().startswith("bulb_")
    (split_chair / "ann.txt").write_text("! bad", encoding="utf-8")
    stage = compose(split_chair, room("chair.obj", annotations={"chair": "ann.txt"}))
    assert said(stage, f"{THING}/part0", "category") == said(
        stage, f"{THING}/piece_299", "category"
    )


def test_the_users_own_textures(tmp_path: Path) -> None:
    folder = tmp_path / "slate"
    folder.mkdir()
    pixels = np.full((8, 8, 3), 128, np.uint8)
    write_png(folder / "slate_Color.png", pixels, is_color=True)
    write_png(folder / "slate_Roughness.png", pixels[..., 0] // 2, is_color=False)
    own = {"file": "slate", "size": "50 cm", "substance": "rough_stone"}
    described = room(floor=own)
    assert list(MaterialsStep().inputs(described, tmp_path)) == [
        "slate/slate_Color.png",
        "slate/slate_Roughness.png",
    ]
    stage = compose(tmp_path, described)
    shown = surface(stage, names.FLOOR)
    assert isinstance(shown.base_color, Texture)
    assert shown.base_color.uv_scale == pytest.approx((2.0, 2.0))
    assert Path(shown.base_color.file).is_relative_to(tmp_path / names.LAYERS)
    assert said(stage, names.FLOOR, "category") == "rough_stone"
    assert shown.f0 == pytest.approx(0.05)


def test_what_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError):
        compose(tmp_path, room(floor={"file": "nowhere"}))
    with pytest.raises(DescriptionError, match="no object or opening 'thin'"):
        compose(tmp_path, room(annotations={"thin": "ann.txt"}))
    assert Sdf.Layer.FindOrOpen(str(tmp_path / names.LAYERS / "materials.usda")) is None
