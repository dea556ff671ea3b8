"""Lightmaps: what a client looks up in them is the picture's diffuse part."""

import builtins
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom

import openrooms_usd as ou
from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.errors import InputError, MissingPackageError, RenderError
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.rendering import RenderRequest
from openrooms_usd.rendering.bake.baking import AtlasLayout, bake_stage
from openrooms_usd.usd.cameras import list_cameras
from tests import small
from tests.mitsuba import lightmap_client as client
from tests.mitsuba.rendering import session_of
from tests.mitsuba.rooms import half_hidden
from tests.small import square

NITS = 1000.0


@pytest.fixture(autouse=True)
def fast(vectorized: str) -> None:
    pytest.importorskip("xatlas", reason="xatlas has no wheel for this Python")


def saved(stage: Usd.Stage, folder: Path) -> Path:
    path = folder / "scene.usda"
    stage.GetRootLayer().Export(str(path))
    return path


def lookup(baked: Path, camera: Any, size: tuple[int, int]) -> tuple[Any, Any]:
    """(H W, 3) lux that a client finds at first hits, and whether these face the camera."""
    found = client.load(baked)
    width, height = size
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    K, world = camera.K, camera.world_from_camera
    rays = np.stack([(x - K[0, 2]) / K[0, 0], (y - K[1, 2]) / K[1, 1], np.ones_like(x)], axis=-1)
    ahead = rays.reshape(-1, 3) @ world[:3, :3].T
    eye = np.broadcast_to(world[:3, 3], ahead.shape)
    caster = RayCaster(
        found.corners.reshape(-1, 3), np.arange(found.corners.size // 3).reshape(-1, 3)
    )
    hit = caster.first_hit(eye, ahead).triangle.astype(np.int64)
    a, b, c = np.moveaxis(found.corners[hit], 1, 0)
    normal = np.cross(b - a, c - a)
    cosine = np.einsum("ij,ij->i", ahead, normal)
    t = np.einsum("ij,ij->i", a - eye, normal) / cosine
    lux = found.irradiance(hit, eye + t[:, None] * ahead)
    return lux, (hit >= 0) & (cosine < 0.0) & np.isfinite(lux).all(axis=1)


def differences(source: Path, baked: Path, camera: str, samples: int) -> tuple[float, Any]:
    """The ratio of the sums, and |client - picture| of each pixel, relative to its light."""
    opened = session_of(Usd.Stage.Open(str(source)))
    size = 28, 21
    needs = ("irradiance", "base_color", "metallic")
    view = opened.render(RenderRequest(camera, needs, *size, samples=samples))
    picture = {
        name: image.pixels.reshape(size[0] * size[1], -1) for name, image in view.images.items()
    }
    albedo = picture["base_color"] * (1.0 - picture["metallic"]) / np.pi
    lux, seen = lookup(baked, view, size)
    shown, there = (
        (albedo * lux).mean(axis=1)[seen],
        (albedo * picture["irradiance"]).mean(axis=1)[seen],
    )
    assert seen.mean() > 0.5
    relative = np.abs(shown - there) / np.maximum(there, 0.1 * there.mean())
    return float(shown.sum() / there.sum()), relative


def test_a_client_sees_the_diffuse_part_of_the_picture(tmp_path: Path) -> None:
    """A room with two lamps and what throws shadows; a picture upside down would fail."""
    source = saved(half_hidden(), tmp_path)
    found = bake_stage(
        source, tmp_path / "out", RenderSettings(samples=96), AtlasLayout(texel_m=0.15)
    )
    ratio, relative = differences(source, tmp_path / "out/baked.usda", "/Camera", 256)
    assert ratio == pytest.approx(1.0, abs=0.02)
    assert relative.mean() < 0.1
    assert np.percentile(relative, 95) < 0.25
    # 2. The sum is the sum.
    (atlas,) = found["atlases"]
    total = client.read(tmp_path / "out" / atlas["irradiance"])
    parts = sum(client.read(tmp_path / "out" / file) for file in atlas["lights"])
    np.testing.assert_allclose(total, parts, rtol=1e-6)
    # 3. The lamps have no texels, and it is said.
    assert {"path": "/Panel", "reason": "it emits light"} in found["left_out"]


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("method", ["cache", pytest.param("reference", marks=pytest.mark.long)])
def test_so_it_is_in_a_furnished_room(method: Any, tmp_path: Path) -> None:
    """The bundled example, through its own camera; what the noise of both leaves is told."""
    source = ou.compose(ou.copy_example(tmp_path / "room"), tmp_path / "out").path
    settings = RenderSettings(samples=64, method=method), AtlasLayout(texel_m=0.1)
    found = bake_stage(source, tmp_path / "lit", *settings)
    assert found["method"] == method
    camera = str(list_cameras(Usd.Stage.Open(str(source)))[0].GetPath())
    ratio, relative = differences(source, tmp_path / "lit/baked.usda", camera, 256)
    assert ratio == pytest.approx(1.0, abs=0.04)
    assert np.median(relative) < 0.2
    assert np.percentile(relative, 95) < 0.7


def test_an_even_sky_gives_pi_times_its_radiance(tmp_path: Path) -> None:
    """To the edges of the chart, whose border a bilinear look-up takes too."""
    room = small.Stage()
    room.quad(
        "/Plate",
        square((0.5, 0.5, 0), 0.5),
        material=room.material("/Black", base_color=(0.0,) * 3),
    )
    room.dome(radiance=NITS)
    bake_stage(
        saved(room.stage, tmp_path), tmp_path / "out", RenderSettings(samples=16), AtlasLayout(0.1)
    )
    plate = client.load(tmp_path / "out/baked.usda")
    points = np.array([[x, y, 0.0] for x in (0.01, 0.5, 0.99) for y in (0.01, 0.3, 0.99)])
    rows = (points[:, 1] > points[:, 0]).astype(np.int64)
    lux = plate.irradiance(rows, points)
    np.testing.assert_allclose(lux, np.pi * NITS, rtol=0.05)
    assert lux.mean() == pytest.approx(np.pi * NITS, rel=0.02)


def _two_of_a_kind(folder: Path) -> Path:
    """Two instances of a box: one under a lamp, the other under a board."""
    asset = small.Stage(path=folder / "asset.usda")
    UsdGeom.Xform.Define(asset.stage, "/Thing")
    asset.box("/Thing/Box", 0.5)
    asset.stage.SetDefaultPrim(asset.stage.GetPrimAtPath("/Thing"))
    asset.stage.Save()
    room = small.Stage(path=folder / "scene.usda")
    for name, x in (("a", -1.0), ("b", 1.0)):
        thing = UsdGeom.Xform.Define(room.stage, f"/World/{name}")
        thing.AddTranslateOp().Set(Gf.Vec3d(x, 0, 0))
        thing.GetPrim().GetReferences().AddReference("./asset.usda")
        thing.GetPrim().SetInstanceable(True)
    room.box("/World/Room", 5.0, inside=True)
    room.quad("/World/Board", square((1, 0, 0.5), 0.5))
    lamp = square((-1, 0, 2), (0.2, 0.2), "-Z")
    room.quad("/World/Lamp", lamp, nits=NITS)
    room.stage.Save()
    return folder / "scene.usda"


def test_instances_have_light_of_their_own_and_stay_instances(tmp_path: Path) -> None:
    source = _two_of_a_kind(tmp_path)
    before = source.read_bytes()
    found = bake_stage(source, tmp_path / "out", RenderSettings(samples=16), AtlasLayout(0.1))
    stage = Usd.Stage.Open(str(tmp_path / "out/baked.usda"))
    a, b = (stage.GetPrimAtPath(f"/World/{name}") for name in "ab")
    assert a.IsInstance() and a.GetPrototype() == b.GetPrototype()
    assert [unit["path"] for unit in found["units"]][:2] == ["/World/a", "/World/b"]
    things = client.load(tmp_path / "out/baked.usda")
    top = np.array([[-0.95, 0.1, 0.25], [1.05, 0.1, 0.25]])
    up = (things.corners[:, :, 2] == 0.25).all(axis=1)
    rows = np.array(
        [np.flatnonzero(up & (things.corners[:, :, 0].mean(axis=1) * x > 0))[0] for x, _, _ in top]
    )
    lit, shaded = things.irradiance(rows, things.corners[rows].mean(axis=1))[:, 0]
    assert lit > 2.0 * shaded > 0.0
    assert source.read_bytes() == before


def test_equal_seeds_give_equal_files(tmp_path: Path) -> None:
    source = _two_of_a_kind(tmp_path)
    for name in ("a", "b"):
        bake_stage(source, tmp_path / name, RenderSettings(samples=2), AtlasLayout(0.2))
    files = sorted(path.relative_to(tmp_path / "a") for path in (tmp_path / "a").rglob("*.*"))
    assert len(files) == 9
    for file in files:
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes(), file


def test_texels_grow_until_they_fit(tmp_path: Path) -> None:
    source = _two_of_a_kind(tmp_path)
    found = bake_stage(
        source, tmp_path / "out", RenderSettings(samples=1), AtlasLayout(0.05, most_texels=8000)
    )
    assert found["texel"]["side_m"] > found["texel"]["asked_m"]
    assert sum(np.prod(atlas["size"]) for atlas in found["atlases"]) <= 8000
    assert json.loads((tmp_path / "out/lightmaps.json").read_text()) == json.loads(
        json.dumps(found)
    )
    with pytest.raises(InputError, match="do not fit"):
        bake_stage(
            source, tmp_path / "none", RenderSettings(samples=1), AtlasLayout(0.05, most_texels=256)
        )


def test_what_makes_no_lightmap_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source = _two_of_a_kind(tmp_path)
    for wrong in ({"texel_m": 0.0}, {"side": 1}, {"most_texels": 1}):
        with pytest.raises(InputError):
            bake_stage(source, tmp_path / "out", RenderSettings(), AtlasLayout(**wrong))
    with pytest.raises(InputError, match="scattered 0 times"):
        bake_stage(source, tmp_path / "out", RenderSettings(bounces=0))
    # What is refused before there is light needs no kernels.
    scalar = RenderSettings(options={"variant": "scalar"})
    with pytest.raises(RenderError, match="scalar"):
        bake_stage(source, tmp_path / "out", scalar, AtlasLayout(0.5))
    with pytest.raises(RenderError, match="cannot compute lightmaps"):
        bake_stage(source, tmp_path / "out", RenderSettings(renderer="preview"))
    nothing = small.Stage()
    nothing.dome()
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="no surface"):
        bake_stage(saved(nothing.stage, tmp_path / "empty"), tmp_path / "out", scalar)
    real = builtins.__import__

    def without(name: str, *rest: Any, **more: Any) -> Any:
        if name == "xatlas":
            raise ImportError("gone")
        return real(name, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(MissingPackageError, match="xatlas") as error:
        bake_stage(source, tmp_path / "out", scalar, AtlasLayout(0.5))
    assert "openrooms-usd[bake]" in str(error.value)
    assert not (tmp_path / "out").exists()


def test_what_is_buried_does_not_darken_what_is_beside_it(tmp_path: Path) -> None:
    """A block stands on a plate under an even sky: of texels below it none is traced."""
    room = small.Stage()
    black = room.material("/Black", base_color=(0.0,) * 3)
    room.quad("/Plate", square((0, 0, 0), 1), material=black)
    room.box("/Block", 0.7, material=black, at=(0, 0, 0.35))
    room.dome(radiance=NITS)
    source = saved(room.stage, tmp_path)
    bake_stage(source, tmp_path / "out", RenderSettings(samples=64), AtlasLayout(0.2))
    plate = client.load(tmp_path / "out/baked.usda")
    # Beside the block half of the sky is left; below it there is none.
    beside = np.array([[0.352, 0.1, 0.0], [0.352, -0.1, 0.0]])
    rows = np.array([0, 0])
    lux = plate.irradiance(rows, beside)[:, 1]
    assert (lux > 0.45 * np.pi * NITS).all()
