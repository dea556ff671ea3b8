"""Published assets: their structure, validity, determinism, and that they appear whole."""

import hashlib
from pathlib import Path

import numpy as np
import pytest
import usd_validation_nvidia as nvidia
from pxr import Usd, UsdGeom, UsdShade, UsdValidation

from openrooms_usd.errors import OutputError
from openrooms_usd.furniture import CATEGORIES, Furniture, category, make
from openrooms_usd.geometry.mesh import joined
from openrooms_usd.geometry.solids import box
from openrooms_usd.library.assets import Asset, Model, publish
from openrooms_usd.usd.semantics import read_label
from openrooms_usd.usd.shading.materials import PreviewSurface, Texture, bound_material
from openrooms_usd.usd.shapes.meshes import read_meshes

ENGINE = nvidia.ValidationEngine()


def _model(furniture: Furniture) -> Model:
    return Model(furniture.parts, joints=furniture.joints)


def _furniture(name: str, style: str, seed: int = 0) -> Asset:
    size = category(name).styles[style].size or category(name).size
    key = (*size, style, seed)
    return Asset(name, key, lambda: _model(make(name, size, style, np.random.default_rng(seed))))


def _digests(folder: Path) -> dict[str, str]:
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def test_structure(tmp_path: Path) -> None:
    asset = _furniture("floor_lamp", "drum")
    relative = publish(tmp_path, asset)
    assert relative == f"{asset.name}/{asset.name}.usda"
    assert asset.name.startswith("floor_lamp_")
    assert len(asset.name) == len("floor_lamp_") + 8
    stage = Usd.Stage.Open(str(tmp_path / relative))
    root = stage.GetDefaultPrim()
    assert root.GetName() == "FloorLamp"
    assert Usd.ModelAPI(root).GetKind() == "component"
    assert Usd.ModelAPI(root).GetAssetName() == asset.name
    assert read_label(root, "category") == "floor_lamp"
    assert read_label(root, "openrooms45") == "lamp"
    shared = stage.GetPrimAtPath("/__class__/FloorLamp")
    assert shared.IsAbstract()
    assert shared.GetTypeName() == "Xform"
    bulb = stage.GetPrimAtPath("/FloorLamp/Geometry/light_bulb")
    assert read_label(bulb, "part") == "light_bulb"
    # Everything heavy stays behind the payload.
    stage.Unload()
    assert list(root.GetAllChildren()) == []
    hint = UsdGeom.ModelAPI(root).GetExtentsHint()
    np.testing.assert_allclose(hint, [(-0.21, -0.21, 0), (0.21, 0.21, 1.55)], atol=1e-6)


def test_instances_of_a_part_share_its_label(tmp_path: Path) -> None:
    stage = Usd.Stage.Open(str(tmp_path / publish(tmp_path, _furniture("chair", "slat"))))
    geometry = stage.GetPrimAtPath("/Chair/Geometry")
    legs = [prim for prim in geometry.GetChildren() if prim.GetName().startswith("leg_")]
    assert [prim.GetName() for prim in legs] == ["leg_0", "leg_1", "leg_2", "leg_3"]
    assert {read_label(prim, "part") for prim in legs} == {"leg"}


@pytest.mark.one_in(8, rest="long")
@pytest.mark.parametrize("name", [(n, s) for n, spec in CATEGORIES.items() for s in spec.styles])
def test_every_style_passes_the_validators(tmp_path: Path, name: tuple[str, str]) -> None:
    stage = Usd.Stage.Open(str(tmp_path / publish(tmp_path, _furniture(*name))))
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    core = UsdValidation.ValidationContext(validators).Validate(stage)
    assert [error.GetMessage() for error in core] == []
    bad = (nvidia.IssueSeverity.ERROR, nvidia.IssueSeverity.FAILURE)
    issues = ENGINE.validate(stage).issues()
    assert [str(issue) for issue in issues if issue.severity in bad] == []


def test_geometry_survives_the_way_to_disk(tmp_path: Path) -> None:
    asset = _furniture("table", "trestle")
    whole = joined(list(asset.build().parts.values()))
    reading = read_meshes(Usd.Stage.Open(str(tmp_path / publish(tmp_path, asset))))
    volume = 0.0
    for placed in reading:
        a, b, c = np.moveaxis(placed.world_points()[placed.mesh.triangles], 1, 0)
        volume += np.einsum("ij,ij->", a, np.cross(b, c)) / 6
    assert volume == pytest.approx(whole.volume(), rel=1e-5)


def test_equal_bytes_in_every_run(tmp_path: Path) -> None:
    for run in ("first", "second"):
        publish(tmp_path / run, _furniture("sofa", "modern"))
    assert _digests(tmp_path / "first") == _digests(tmp_path / "second")


def test_the_name_follows_from_what_determines_the_content() -> None:
    assert _furniture("chair", "slat").name == _furniture("chair", "slat").name
    assert _furniture("chair", "slat").name != _furniture("chair", "slat", seed=1).name
    assert _furniture("chair", "slat").name != _furniture("chair", "sled").name


def test_what_is_there_is_not_built_again(tmp_path: Path) -> None:
    publish(tmp_path, _furniture("chair", "slat"))

    def fail() -> Model:
        raise AssertionError("built again")

    known = _furniture("chair", "slat")
    publish(tmp_path, Asset(known.category, known.key, fail))


def test_nothing_is_left_of_what_fails(tmp_path: Path) -> None:
    part = box((1, 1, 1))
    missing = PreviewSurface(base_color=Texture(str(tmp_path / "missing.png")))
    asset = Asset("chair", (), lambda: Model({"seat": part}, surfaces={"seat": missing}))
    with pytest.raises(Exception, match="no such file"):
        publish(tmp_path / "assets", asset)
    assert list(tmp_path.iterdir()) == []


def test_an_unwritable_folder_is_an_output_error(tmp_path: Path) -> None:
    (tmp_path / "assets").write_text("a file where the folder shall be")
    with pytest.raises(OutputError):
        publish(tmp_path / "assets", _furniture("chair", "slat"))


def test_foreign_surfaces_are_bound_inside_and_their_pictures_copied(tmp_path: Path) -> None:
    picture = tmp_path / "wood.PNG"
    picture.write_bytes(b"not looked at")
    textured = PreviewSurface(base_color=Texture(str(picture), color_space="sRGB"))
    plain = PreviewSurface(base_color=(0.5, 0.1, 0.1))
    parts = {"seat": box((1, 1, 1)), "back": box((1, 1, 1)), "leg": box((1, 1, 1))}
    surfaces = {"seat": textured, "back": plain, "leg": plain}
    asset = Asset("chair", (), lambda: Model(parts, {"seat": "Sitz 1"}, surfaces))
    stage = Usd.Stage.Open(str(tmp_path / publish(tmp_path, asset)))
    materials = stage.GetPrimAtPath("/Chair/Materials").GetChildren()
    assert len(materials) == 2
    seat, back, leg = (
        stage.GetPrimAtPath(f"/Chair/Geometry/{name}") for name in ("seat", "back", "leg")
    )
    assert seat.GetDisplayName() == "Sitz 1"
    assert bound_material(back).GetPath() == bound_material(leg).GetPath()
    shader = UsdShade.Shader(bound_material(seat).GetPrim().GetChild("base_color_texture"))
    file = shader.GetInput("file").Get()
    assert file.path.startswith("./textures/")
    assert file.path.endswith(".png")
    assert Path(file.resolvedPath).read_bytes() == b"not looked at"
