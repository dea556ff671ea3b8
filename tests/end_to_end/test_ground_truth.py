"""Ground truth of the example and of generated rooms against a ray cast of the raw USD."""

from pathlib import Path

import numpy as np
import OpenImageIO
import pytest
from pxr import Usd, UsdShade

from openrooms_usd.arrays import Array

WIDTH, HEIGHT = 40, 30


@pytest.fixture(scope="module")
def shown(room: Path, show_once, fastest: str):
    exact = ["depth", "distance", "position", "normal_geometric", "valid"]
    labels = ["instance", "semantic", "part", "material"]
    channels = [*exact, *labels, "base_color", "roughness", "metallic"]
    size = (WIDTH, HEIGHT)
    name = room.parent.name
    return show_once(room, name, channels=channels, resolution=size, options={"variant": fastest})


@pytest.fixture(scope="module")
def seen(room: Path, shown, cast):
    stage = Usd.Stage.Open(str(room))
    views = shown.manifest["views"]
    return stage, {v: cast(stage, views[v]["camera"], WIDTH, HEIGHT) for v in views}


def label(prim: Usd.Prim, taxonomy: str) -> tuple[str, str]:
    """The nearest label at or above a prim, and the path of the prim that carries it."""
    while not prim.GetAttribute(f"semantics:labels:{taxonomy}"):
        prim = prim.GetParent()
    return prim.GetAttribute(f"semantics:labels:{taxonomy}").Get()[0], str(prim.GetPath())


@pytest.mark.slow
def test_geometry_and_labels_are_those_of_the_prims(shown, seen) -> None:
    stage, casts = seen
    assert stage.GetPrototypes(), "instances must be read too"
    for view, ours in casts.items():
        theirs = shown[view]
        hit = ours.hit
        assert 0.6 < hit.mean() <= 1.0
        assert np.array_equal(theirs["valid"][..., 0] == 1, hit)
        # A ray through an edge may meet either side of it: where both meet the same prim, ...
        paths = np.vectorize(lambda prim: str(prim.GetPath()) if prim else "")(ours.prims)
        same = hit & (shown.names(view, "part") == paths)
        assert (same == hit).mean() > 0.998
        # ... the numbers agree to float precision (0.5 um in 4 m); the light of a screen that is on
        # stands 0.6 mm before it, and farther along a slanting ray.
        screens = np.vectorize(lambda prim: prim.GetName().startswith("screen"))(ours.prims[same])
        close = np.where(screens, 2e-3, 2e-6)
        for name, expected in (
            ("position", ours.position),
            ("distance", ours.distance[..., None]),
            ("depth", ours.depth[..., None]),
        ):
            off = np.abs(theirs[name][same] - expected[same]).max(axis=1)
            assert (off < close).all(), name
        turned = np.abs(theirs["normal_geometric"][same] - ours.normal[same]).max(axis=1) > 1e-3
        assert turned.mean() < 0.004, "other triangles of one mesh, along their edges"
        for y, x in np.argwhere(same):
            prim = ours.prims[y, x]
            category, owner = label(prim, "category")
            number = str(int(theirs["instance"][y, x, 0]))
            assert shown.manifest["legend"]["instance"][number] == owner
            assert shown.manifest["legend"]["category"][number] == category
        semantic = np.vectorize(lambda prim: label(prim, "openrooms45")[0] if prim else "")
        assert (shown.names(view, "semantic") == semantic(ours.prims))[same].all()

        def bound(prim: Usd.Prim | None) -> str:
            found = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0] if prim else None
            return str(found.GetPath()) if found else ""

        worn = shown.names(view, "material") == np.vectorize(bound)(ours.prims)
        assert worn[same][~screens].all(), "lights wear no material"


@pytest.mark.slow
def test_depth_is_planar_and_back_projects_to_position(shown) -> None:
    for name, view in shown.manifest["views"].items():
        image = shown[name]
        K, pose = np.array(view["K"]), np.array(view["world_from_camera"])
        x, y = np.meshgrid(np.arange(WIDTH) + 0.5, np.arange(HEIGHT) + 0.5)
        rays = np.stack([x, y, np.ones_like(x)], axis=2) @ np.linalg.inv(K).T
        lengths = np.linalg.norm(rays, axis=2, keepdims=True)
        assert lengths.max() > 1.1, "planar and Euclidean must differ"
        assert np.allclose(image["distance"], image["depth"] * lengths, rtol=1e-6)
        points = image["depth"] * rays @ pose[:3, :3].T + pose[:3, 3]
        valid = image["valid"][..., 0] == 1
        assert np.abs((points - image["position"])[valid]).max() < 3e-6


def source(shader: UsdShade.Shader, name: str) -> UsdShade.Shader | None:
    """The shader that an input is connected to."""
    given = shader.GetInput(name)
    found = given.GetConnectedSources()[0] if given else ()
    return UsdShade.Shader(found[0].source.GetPrim()) if found else None


def value(shader: UsdShade.Shader, name: str, fallback: object) -> object:
    given = shader.GetInput(name)
    return fallback if not given or given.Get() is None else given.Get()


def looked_up(texture: UsdShade.Shader, st: Array) -> Array:
    """Bilinear values of a repeating texture, decoded, with t upwards, at (R, 2) st."""
    placed = source(texture, "st")
    assert placed is not None
    if placed.GetIdAttr().Get() == "UsdTransform2d":
        turn = np.radians(value(placed, "rotation", 0.0))
        cos, sin = np.cos(turn), np.sin(turn)
        scaled = st * np.array(value(placed, "scale", (1, 1)))
        st = scaled @ np.array([[cos, sin], [-sin, cos]])
        st = st + np.array(value(placed, "translation", (0, 0)))
        placed = source(placed, "in")
        assert placed is not None
    assert value(placed, "varname", "") == "st"
    file = texture.GetInput("file").Get().resolvedPath
    image = OpenImageIO.ImageBuf(file).get_pixels(OpenImageIO.FLOAT).astype(np.float64)
    if value(texture, "sourceColorSpace", "auto") == "sRGB":
        image = np.where(image <= 0.04045, image / 12.92, ((image + 0.055) / 1.055) ** 2.4)
    height, width = image.shape[:2]
    x, y = st[:, 0] * width - 0.5, (1 - st[:, 1]) * height - 0.5
    left, top = np.floor(x).astype(int), np.floor(y).astype(int)
    total = np.zeros((len(st), image.shape[2]))
    for i, j in ((0, 0), (0, 1), (1, 0), (1, 1)):
        weight = np.abs(1 - i - (x - left)) * np.abs(1 - j - (y - top))
        total += weight[:, None] * image[(top + j) % height, (left + i) % width]
    factors, offsets = value(texture, "scale", (1,) * 4), value(texture, "bias", (0,) * 4)
    channels = total.shape[1]
    return total * np.array(factors)[:channels] + np.array(offsets)[:channels]


@pytest.mark.slow
def test_materials_are_those_of_their_textures(shown, seen) -> None:
    textured = constant = 0
    for view, ours in seen[1].items():
        image, materials = shown[view], shown.names(view, "material")
        for path in set(materials.ravel()) - {""}:
            here = (materials == path) & ours.hit
            # Only where both see the same prim: its path decides what the material is.
            here &= np.vectorize(lambda p: str(p.GetPath()) if p else "")(ours.prims) == (
                shown.names(view, "part")
            )
            material = UsdShade.Material(seen[0].GetPrimAtPath(path))
            surface = material.ComputeSurfaceSource()[0]
            for channel, name, fallback in (
                ("base_color", "diffuseColor", (0.18, 0.18, 0.18)),
                ("roughness", "roughness", 0.5),
                ("metallic", "metallic", 0.0),
            ):
                texture, found = source(surface, name), image[channel][here]
                if texture is None:
                    expected = np.array(value(surface, name, fallback))
                    assert np.allclose(found, expected, rtol=1e-3), (path, name)
                    constant += len(found)
                    continue
                expected = looked_up(texture, ours.st[here])[:, : found.shape[1]]
                # Half precision, and texels so fine that a micrometre tells.
                assert np.quantile(np.abs(found - expected), 0.98, axis=0).max() < 2e-3, (
                    path,
                    name,
                )
                textured += len(found)
    assert textured > 1000 and constant > 100
