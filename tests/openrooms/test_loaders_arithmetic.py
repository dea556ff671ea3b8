"""What the published loaders compute from the files, written again, on what our renderer wrote.

The rendering layer of InverseRenderingOfIndoorScene (diffuse and specular light of hemispheres),
the renderers of windows and of lamps' boxes of IndoorLightEditing, and where hemispheres shine.
"""

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO
import pytest

from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.rendering import render_stage
from openrooms_usd.rendering.datasets import DatasetOptions, write_dataset
from openrooms_usd.rendering.reading import RenderedView, read_render

pytestmark = pytest.mark.slow

SCENE = "scene0000_00"
ROWS, COLUMNS = 12, 16
CHANNELS = tuple(
    (
        "radiance base_color normal_camera roughness metallic depth valid emission_mask diffuse"
        " specular environment environment_direct direct_i unoccluded_i visibility_i mask_i"
        " instance material"
    ).split()
)


@pytest.fixture(scope="module")
def rendered(composed_demo: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("real") / "render"
    render_stage(
        composed_demo,
        folder,
        RenderSettings(
            channels=list(CHANNELS),
            resolution=(64, 48),
            grid=(COLUMNS, ROWS),
            samples=16,
            field_of_view=57.95,
        ),
    )
    return folder


@pytest.fixture(scope="module")
def view(rendered: Path) -> RenderedView:
    return next(iter(read_render(rendered).each()))


@pytest.fixture(scope="module")
def folder(rendered: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("loaders") / "data"
    write_dataset([rendered], root, options=DatasetOptions(layout="merged"))
    return root / "main_xml" / SCENE


def imread(path: Path) -> np.ndarray:
    """As OpenCV reads: blue, green, red."""
    return OpenImageIO.ImageBuf(str(path)).get_pixels()[..., ::-1]


def hemispheres(path: Path, rows: int, columns: int) -> np.ndarray:
    """(rows, columns, 512, 3), as loaders take them: nothing is turned around."""
    grid = imread(path).reshape(rows, 16, columns, 32, 3).transpose(0, 2, 1, 3, 4)
    return grid.reshape(rows, columns, 512, 3)


def picture(path: Path) -> np.ndarray:
    """Red first, from 0 to 1, by areas at the points of the hemispheres."""
    return coarse(imread(path)[..., ::-1])


def coarse(pixels: np.ndarray, rows: int = ROWS, columns: int = COLUMNS) -> np.ndarray:
    height, width = pixels.shape[:2]
    return pixels.reshape(rows, height // rows, columns, width // columns, -1).mean(axis=(1, 3))


def unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9)


def normals_of(folder: Path) -> np.ndarray:
    return unit(picture(folder / "imnormal_1.png") * 2.0 - 1.0)


def ways(normals: np.ndarray, flip: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """(rows, columns, 512, 3) directions of cells in the camera's frame, and (512,) weights."""
    theta = np.repeat((np.arange(16) + 0.5) / 16 * np.pi / 2, 32)
    phi = np.tile(((np.arange(32) + 0.5) / 32 - 0.5) * 2.0 * np.pi, 16)
    up = np.array([0.0, 1.0, 0.0])
    y = unit(up - normals * normals[..., 1:2])
    x = -unit(np.cross(y, normals)) * (-1.0 if flip else 1.0)
    local = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
    found = np.einsum("kn,krcd->rcnd", local, np.stack([x, y, normals]))
    return found, np.sin(theta) * np.pi**2 / 512


def places(folder: Path) -> np.ndarray:
    """(rows, columns, 3) what points of the grid see, right, up, backward."""
    data = (folder / "imdepth_1.dat").read_bytes()
    depth = np.frombuffer(data, "<f4", offset=8).reshape(48, 64)
    x_range = np.tan(np.radians(57.95) / 2.0)
    x = ((np.arange(64) + 0.5) / 64 * 2.0 - 1.0) * x_range
    y = -((np.arange(48) + 0.5) / 48 * 2.0 - 1.0) * x_range * 48 / 64
    x, y = np.meshgrid(x, y)
    return coarse(np.stack([x, y, -np.ones_like(x)], axis=-1) * depth[..., None])


def seen(view: RenderedView) -> np.ndarray:
    """Points whose pixels all show one flat surface that does not shine."""
    normal = view.pixels["normal_camera"]
    even = np.linalg.norm(coarse(normal), axis=-1) > 0.999
    whole = coarse(view.pixels["valid"] * (1.0 - view.pixels["emission_mask"]))[..., 0] == 1.0
    return even & whole


def test_diffuse_light_of_the_rendering_layer(folder: Path, view: RenderedView) -> None:
    normals = normals_of(folder)
    directions, weights = ways(normals)
    light = hemispheres(folder / "imenv_1.hdr", ROWS, COLUMNS)
    cosine = np.clip((directions * normals[:, :, None]).sum(axis=-1), 0.0, 1.0)
    albedo = picture(folder / "imbaseColor_1.png") ** 2.2
    found = albedo / np.pi * np.einsum("rcnk,rcn,n->rck", light, cosine, weights)
    wanted = coarse(view.pixels["diffuse"] * 1.0)
    used = seen(view) & (coarse(view.pixels["metallic"])[..., 0] < 0.05)
    assert used.sum() > 40
    ratio = found[used].sum(axis=0) / wanted[used].sum(axis=0)
    np.testing.assert_allclose(ratio, 1.0, atol=0.1)
    assert relative(found[used], wanted[used]) < 0.25


def test_specular_light_of_the_rendering_layer(folder: Path, view: RenderedView) -> None:
    """Of rough surfaces: cells of hemispheres are too wide for what is smoother."""
    normals, points = normals_of(folder), places(folder)
    directions, weights = ways(normals)
    light = hemispheres(folder / "imenv_1.hdr", ROWS, COLUMNS)
    rough = picture(folder / "imroughness_1.png")[..., :1]
    v = unit(-points)[:, :, None]
    h = unit(directions + v)
    n = normals[:, :, None]
    dots = {
        k: np.clip((a * b).sum(-1), 0, 1)
        for k, a, b in (("nv", n, v), ("nh", n, h), ("nl", n, directions), ("vh", v, h))
    }
    k, alpha2 = (rough + 1.0) ** 2 / 8.0, rough**4
    fresnel = 0.05 + 0.95 * 2.0 ** ((-5.55472 * dots["vh"] - 6.98316) * dots["vh"])
    d = dots["nh"] ** 2 * (alpha2 - 1.0) + 1.0
    g = (dots["nv"] * (1.0 - k) + k) * (dots["nl"] * (1.0 - k) + k)
    brdf = alpha2 * fresnel / np.clip(4.0 * np.pi * d**2 * g, 1e-6, 4.0 * np.pi)
    found = np.einsum("rcnk,rcn,n->rck", light, brdf * dots["nl"], weights)
    wanted = coarse(view.pixels["specular"] * 1.0)
    used = seen(view) & (rough[..., 0] > 0.35)
    used &= coarse(view.pixels["metallic"])[..., 0] < 0.05
    assert used.sum() > 20
    assert found[used].sum() / wanted[used].sum() == pytest.approx(1.0, abs=0.25)


def relative(found: np.ndarray, wanted: np.ndarray) -> float:
    return float(np.abs(found - wanted).sum() / wanted.sum())


def opened(path: Path) -> dict[str, Any]:
    return pickle.loads(path.read_bytes())  # our own


def lights(folder: Path) -> list[tuple[Path, dict[str, Any], dict[str, Any]]]:
    """The mask, box and source of each light."""
    masks = sorted((folder / "light_1").glob("mask*.png"))
    return [
        (
            mask,
            opened(mask.with_name(mask.name.replace("mask", "box").replace("png", "dat"))),
            opened(mask.with_name(mask.name.replace("mask", "lightSrc").replace("png", "dat"))),
        )
        for mask in masks
    ]


def through_window(
    box: dict[str, Any], src: dict[str, Any], points: np.ndarray, normals: np.ndarray
) -> np.ndarray:
    """The renderer of windows: a sharp sun by its directions, what is wide by the rectangle."""
    rng = np.random.default_rng(0)
    x, y = (0.5 * box[f"{axis}Axis"] * box[f"{axis}Len"] for axis in "xy")
    out = unit(-box["zAxis"])
    out = out if out @ box["center"] >= 0.0 else -out
    count, flat, facing = 400, points.reshape(-1, 1, 3), normals.reshape(-1, 1, 3)
    uv = rng.uniform(-1.0, 1.0, (count, 2))
    path = box["center"] + uv[:, :1] * x + uv[:, 1:] * y - flat
    square = (path**2).sum(axis=-1)
    way = path / np.sqrt(square)[..., None]
    way = way * np.where(way @ out < 0.0, -1.0, 1.0)[..., None]
    area = 4.0 * np.linalg.norm(x) * np.linalg.norm(y)
    solid = area * np.abs(way @ out) / square / count
    cosine = np.clip((way * facing).sum(axis=-1), 0.0, 1.0)
    total = np.zeros((len(flat), 3))
    sharp, axis = float(src["lamb"][0]), src["axis"]
    for ending in ("Sky", "Grd", "") if sharp < 8.0 else ("Sky", "Grd"):
        shape = np.exp(src[f"lamb{ending}"] * (way @ src[f"axis{ending}"] - 1.0))
        total += (shape * cosine * solid).sum(axis=1)[:, None] * src[f"intensity{ending}"]
    if sharp < 8.0:
        return total.reshape(points.shape)
    # Sampled by its own density.
    share = 1.0 + np.log(1.0 - (1.0 - np.exp(-2.0 * sharp)) * rng.random(count)) / sharp
    turn, sine = 2.0 * np.pi * rng.random(count), np.sqrt(np.maximum(1.0 - share**2, 0.0))
    side = unit(np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))]))
    other = np.cross(axis, side)
    sampled = share[:, None] * axis + (sine * np.cos(turn))[:, None] * side
    sampled += (sine * np.sin(turn))[:, None] * other
    slope = sampled @ out
    distance = (box["center"] - flat) @ out / np.where(np.abs(slope) < 1e-9, 1e-9, slope)
    offset = flat + distance[..., None] * sampled - box["center"]
    inside = (np.abs(offset @ unit(x)) < np.linalg.norm(x)) & (slope > 0.0) & (distance > 0.0)
    inside &= np.abs(offset @ unit(y)) < np.linalg.norm(y)
    flux = 2.0 * np.pi / sharp * -np.expm1(-2.0 * sharp) / count
    cosine = np.clip((sampled * facing).sum(axis=-1), 0.0, 1.0)
    total += flux * (inside * cosine).sum(axis=1)[:, None] * src["intensity"]
    return total.reshape(points.shape)


def test_the_window_renderer_gives_what_falls_in(folder: Path, view: RenderedView) -> None:
    points, normals = places(folder), normals_of(folder)
    used, tried = seen(view), 0
    for mask, box, src in lights(folder):
        if not box["isWindow"]:
            continue
        tried += 1
        found = through_window(box["box3D"], src, points, normals)[used]
        number = mask.stem.removeprefix("mask")
        assert np.isfinite(found).all() and found.max() > 0.0
        approximate = imread(mask.with_name(f"imDSNoOccluApprox{number}.hdr"))[..., ::-1][used]
        assert relative(found, approximate) < 0.1
        true = imread(mask.with_name(f"imDSNoOcclu{number}.rgbe"))[..., ::-1][used]
        assert relative(found, true) < 0.4
    assert tried


def test_the_box_renderer_gives_what_lamps_bring(folder: Path, view: RenderedView) -> None:
    """Six faces that shine alike: more or less what a lamp of that radiance and size is."""
    rng = np.random.default_rng(1)
    points, normals = places(folder), normals_of(folder)
    used, tried = seen(view), 0
    for mask, box, src in lights(folder):
        if box["isWindow"] or not src["intensity"].any():
            continue
        tried += 1
        three = box["box3D"]
        edges = [three[f"{axis}Axis"] * three[f"{axis}Len"] for axis in "xyz"]
        total = np.zeros(points.shape)
        for axis in range(3):
            x, y = edges[(axis + 1) % 3], edges[(axis + 2) % 3]
            for side in (1.0, -1.0):
                face, out = three["center"] + 0.5 * side * edges[axis], side * unit(edges[axis])
                for u, v in rng.uniform(-0.5, 0.5, (64, 2)):
                    path = face + u * x + v * y - points
                    square = (path**2).sum(axis=-1)
                    way = path / np.sqrt(square)[..., None]
                    cosine = np.clip((way * normals).sum(axis=-1), 0.0, 1.0)
                    facing = np.clip(-way @ out, 0.0, 1.0)
                    area = np.linalg.norm(x) * np.linalg.norm(y) / 64.0
                    total += (area * cosine * facing / square)[..., None] * src["intensity"]
        number = mask.stem.removeprefix("mask")
        true = imread(mask.with_name(f"imDSNoOcclu{number}.rgbe"))[..., ::-1]
        lit = used & (true.sum(axis=-1) > 0.0)
        ratio = total[lit].sum() / true[lit].sum()
        assert 0.5 < ratio < 2.5, (number, ratio)
    assert tried


def towards(box: dict[str, Any], points: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """(rows, columns, N) whether ways from points meet a box, a little enlarged."""
    turn = np.stack([box[f"{axis}Axis"] for axis in "xyz"])
    half = 0.5 * np.array([box[f"{axis}Len"] for axis in "xyz"]) + 0.02
    start = ((points - box["center"]) @ turn.T)[:, :, None]
    way = directions @ turn.T
    way = np.where(np.abs(way) < 1e-9, 1e-9, way)
    near, far = (-half - start) / way, (half - start) / way
    enter, leave = np.minimum(near, far).max(axis=-1), np.maximum(near, far).min(axis=-1)
    return (leave > np.maximum(enter, 0.0)) & (leave > 0.0)


def test_hemispheres_are_brightest_where_the_lights_are(folder: Path, view: RenderedView) -> None:
    """The brightest cell of a point looks at a light's box; mirrored it looks elsewhere."""
    normals, points = normals_of(folder), places(folder)
    light = hemispheres(folder / "imenv_1.hdr", ROWS, COLUMNS).sum(axis=-1)
    brightest, shares = light.argmax(axis=-1)[..., None], []
    for flip in (False, True):
        directions, _ = ways(normals, flip)
        expected = np.zeros(light.shape, bool)
        for _, box, _ in lights(folder):
            # Cells are wide: their neighbours in the grid may look past the edge.
            hit = towards(box["box3D"], points, directions).reshape(ROWS, COLUMNS, 16, 32)
            near = [np.roll(hit, (a, b), (2, 3)) for a in (-1, 0, 1) for b in (-1, 0, 1)]
            expected |= np.logical_or.reduce(near).reshape(expected.shape)
        shares.append(float(np.take_along_axis(expected, brightest, -1)[seen(view)].mean()))
    assert shares[0] > 0.8 and shares[1] < 0.5, shares
