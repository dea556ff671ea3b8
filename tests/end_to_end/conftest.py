"""Rooms that were really composed, and pictures of them read back from the files."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO
import pytest
from numpy.typing import NDArray
from pxr import Sdf, Usd, UsdGeom, UsdShade

from openrooms_usd.arrays import Array, Floats, Ints, Mask
from openrooms_usd.composing import compose_room
from openrooms_usd.demo import copy_example
from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.rendering import render_stage
from orusd_mitsuba import variants
from tests.commands import output_of

Show = Callable[..., "Shown"]


@dataclass(frozen=True)
class Shown:
    """A render on disk: channels of every view, and the manifest.

    The arrays are (height, width, components) by view and channel, read without our own reader.
    """

    out: Path

    @cached_property
    def manifest(self) -> dict[str, Any]:
        return json.loads((self.out / "manifest.json").read_text())  # type: ignore[no-any-return]

    def __getitem__(self, view: str) -> dict[str, Floats]:
        return read_exr(self.out / view / "channels.exr")

    @property
    def views(self) -> list[str]:
        return sorted(self.manifest["views"])

    def names(self, view: str, channel: str) -> NDArray[np.str_]:
        """(height, width) what the numbers of a label channel stand for; empty for 0."""
        legend = {0: ""} | {int(k): v for k, v in self.manifest["legend"][channel].items()}
        numbers = self[view][channel][..., 0].astype(int)
        return np.vectorize(legend.__getitem__, otypes=[object])(numbers).astype(str)


def read_exr(path: Path) -> dict[str, Floats]:
    """(height, width, components) by channel."""
    source: Any = OpenImageIO.ImageInput.open(str(path))
    names = source.spec().channelnames
    pixels = source.read_image(OpenImageIO.FLOAT)
    source.close()
    parts: dict[str, list[int]] = {}
    for index in sorted(range(len(names)), key=lambda i: "RGBXYZ".index(names[i][-1])):
        parts.setdefault(names[index].partition(".")[0], []).append(index)
    return {name: pixels[..., indices] for name, indices in parts.items()}


def usable() -> list[str]:
    """The backends that the processor has here; the faster one first, which sets the library."""
    known = "llvm" if variants.diagnose()["llvm"].startswith("works") else "scalar"
    variants.choose(known)
    return list(dict.fromkeys([known, "scalar"]))


@pytest.fixture(params=["llvm", "scalar"])
def variant(request: pytest.FixtureRequest) -> str:
    """Each backend of the processor; one that does not work here is skipped."""
    if request.param == "llvm":
        request.getfixturevalue("vectorized")
    return str(request.param)


@pytest.fixture(scope="session")
def fastest() -> str:
    return usable()[0]


@pytest.fixture(scope="session")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The ``scene.usda`` of the bundled example; read it, and copy its folder to change it."""
    folder = tmp_path_factory.mktemp("demo")
    return compose_room(copy_example(folder / "source"), folder).scene


# Rooms that the generator makes: types that differ in their furniture, each with a seed.
GENERATED = (
    ("bathroom", 11),
    ("bedroom", 12),
    ("classroom", 13),
    ("dining_room", 14),
    ("garage", 15),
    ("kitchen", 16),
    ("library", 17),
    ("living_room", 18),
    ("office", 19),
    ("stairs", 20),
)
ROOMS = (("demo",), *GENERATED)
QUICK = (("bathroom", 11),)
# Those that are looked at for every change; the rest is long.
USUAL = (("demo",), ("kitchen", 16), ("stairs", 20))


# How much lies about in each type; nothing where it is not named.
CLUTTER = {"bedroom": "1", "kitchen": "1", "living_room": "2"}


def described(kind: str, seed: str, folder: Path) -> str:
    """The text of a generated room, with small textures."""
    call = ["generate", "--type", kind, "--seed", seed, "--clutter", CLUTTER.get(kind, "0")]
    output_of(*call, "-o", folder)
    text = (folder / "room.yaml").read_text(encoding="utf-8")
    assert "\nmaterials:\n" in text
    return text.replace("\nmaterials:\n", "\nmaterials:\n  resolution: 64\n")


@pytest.fixture(scope="session")
def generated(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, int], Path]:
    """The ``scene.usda`` of a generated room, composed once."""
    folder = tmp_path_factory.mktemp("rooms")

    def scene(kind: str, seed: int) -> Path:
        out = folder / f"{kind}-{seed}"
        if not (out / "scene.usda").is_file():
            text = described(kind, str(seed), out / "source")
            (out / "source/room.yaml").write_text(text, encoding="utf-8")
            compose_room(out / "source/room.yaml", out, workers=1)
        return out / "scene.usda"

    return scene


@pytest.fixture(scope="session")
def with_physics(demo: Path, tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """The ``scene.usda`` of the example, or of a room such as ``kitchen-16``, with bodies."""
    folder = tmp_path_factory.mktemp("bodies")

    def scene(name: str) -> Path:
        out = folder / name
        if name == "demo":
            return demo
        if not (out / "scene.usda").is_file():
            kind, seed = name.split("-")
            text = described(kind, seed, out / "source")
            (out / "source/room.yaml").write_text(f"{text}physics: {{}}\n", encoding="utf-8")
            compose_room(out / "source/room.yaml", out, workers=1)
        return out / "scene.usda"

    return scene


def marked(room: tuple[str] | tuple[str, int]) -> Any:
    """A room with its worker; the smallest alone is quick."""
    name = "-".join(map(str, room))
    marks = [pytest.mark.xdist_group(name)]
    if room not in QUICK:
        marks.append(pytest.mark.slow if room in USUAL else pytest.mark.long)
    return pytest.param(room, id=name, marks=marks)


@pytest.fixture(scope="session", params=map(marked, ROOMS))
def room(request: pytest.FixtureRequest, generated: Callable[[str, int], Path]) -> Path:
    """The ``scene.usda`` of the bundled example and of each generated room."""
    if request.param == ("demo",):
        return request.getfixturevalue("demo")  # type: ignore[no-any-return]
    return generated(*request.param)


@pytest.fixture
def show(tmp_path: Path) -> Show:
    """Render a stage, 32 by 24 pixels and 2 samples unless it says otherwise, and read it back."""
    return shower(tmp_path)


def shower(folder: Path) -> Show:
    """Renders into a folder."""

    def render(stage: Path, name: str = "render", **how: Any) -> Shown:
        defaults: dict[str, Any] = {"resolution": (32, 24), "samples": 2}
        cameras = how.pop("cameras", ())
        settings = RenderSettings(**(defaults | how))
        render_stage(stage, folder / name, settings, cameras=cameras)
        return Shown(folder / name)

    return render


@pytest.fixture(scope="module")
def show_once(tmp_path_factory: pytest.TempPathFactory) -> Show:
    """The same for pictures that several tests of a module read."""
    return shower(tmp_path_factory.mktemp("shown"))


@pytest.fixture
def opened() -> type[Shown]:
    """Reads a render that lies in a folder."""
    return Shown


@pytest.fixture(scope="session")
def cast() -> Callable[..., "Seen"]:
    return ray_cast


@dataclass(frozen=True)
class Seen:
    """What the centres of pixels see, by plain USD and numpy; arrays are (height, width, ...)."""

    position: Array
    distance: Array
    depth: Array
    normal: Array
    st: Array
    prims: NDArray[Any]
    """The mesh that is hit, or None."""

    @property
    def hit(self) -> Mask:
        return np.isfinite(self.distance)


def is_pane(prim: Usd.Prim) -> bool:
    """Whether geometry and labels look through it."""
    material = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
    pane = material.GetPrim().GetAttribute("openrooms:material:pane") if material else None
    return bool(pane) and pane.HasAuthoredValue()


def ray_cast(stage: Usd.Stage, camera: str, width: int, height: int) -> Seen:
    """Every ray against every triangle of every mesh whose box it meets (Moller, Trumbore 1997)."""
    frustum = UsdGeom.Camera(stage.GetPrimAtPath(camera)).GetCamera(0).frustum
    across = (np.arange(width) + 0.5) / width * 2 - 1
    down = 1 - (np.arange(height) + 0.5) / height * 2
    rays = [frustum.ComputePickRay((x, y)).direction for y in down for x in across]
    directions, eye = np.array(rays), np.array(frustum.position)
    count = len(directions)
    nearest = np.full(count, np.inf)
    normal, st, prims = np.zeros((count, 3)), np.zeros((count, 2)), np.full(count, None)
    cache = UsdGeom.XformCache()
    for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
        image = UsdGeom.Imageable(prim)
        if not prim.IsA(UsdGeom.Mesh) or image.ComputeVisibility() == "invisible":
            continue
        if image.ComputePurpose() in ("guide", "proxy") or is_pane(prim):
            continue
        corners, coordinates = triangles(UsdGeom.Mesh(prim), cache)
        low, high = corners.min(axis=(0, 1)) - 1e-6, corners.max(axis=(0, 1)) + 1e-6
        with np.errstate(divide="ignore"):
            sides = np.stack([(low - eye) / directions, (high - eye) / directions])
        near, far = sides.min(axis=0).max(axis=1), sides.max(axis=0).min(axis=1)
        tried = np.flatnonzero((near <= far) & (far > 0))
        for rows in np.array_split(tried, len(tried) * len(corners) // 500_000 + 1):
            t, triangle, weights = meet(corners, eye, directions[rows])
            better = t < nearest[rows]
            rows, triangle, weights = rows[better], triangle[better], weights[better]
            nearest[rows] = t[better]
            a, b, c = np.moveaxis(corners[triangle], 1, 0)
            n = np.cross(b - a, c - a)
            normal[rows] = n / np.linalg.norm(n, axis=1, keepdims=True)
            st[rows] = np.einsum("ri,rij->rj", weights, coordinates[triangle])
            prims[rows] = prim
    away = np.einsum("ij,ij->i", normal, directions) > 0
    normal[away] *= -1
    forward = np.array(frustum.ComputeViewDirection())
    shape = height, width
    with np.errstate(invalid="ignore"):
        position = eye + nearest[:, None] * directions
    return Seen(
        position.reshape(*shape, 3),
        nearest.reshape(shape),
        (nearest * (directions @ forward)).reshape(shape),
        normal.reshape(*shape, 3),
        st.reshape(*shape, 2),
        prims.reshape(shape),
    )


def triangles(mesh: UsdGeom.Mesh, cache: UsdGeom.XformCache) -> tuple[Array, Array]:
    """(T, 3, 3) world corners and (T, 3, 2) st of a mesh: each face as a fan."""
    matrix = np.array(cache.GetLocalToWorldTransform(mesh.GetPrim()))
    points = np.array(mesh.GetPointsAttr().Get(), dtype=np.float64)
    world = points @ matrix[:3, :3] + matrix[3, :3]
    counts = np.array(mesh.GetFaceVertexCountsAttr().Get())
    starts = np.cumsum(counts) - counts
    fan = [
        (start, start + i, start + i + 1)
        for start, count in zip(starts, counts, strict=True)
        for i in range(1, count - 1)
    ]
    indices = np.array(mesh.GetFaceVertexIndicesAttr().Get())
    primvar = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st")
    assert primvar.GetInterpolation() == "faceVarying"
    return world[indices[np.array(fan)]], np.array(primvar.ComputeFlattened())[np.array(fan)]


def meet(corners: Array, eye: Array, directions: Array) -> tuple[Array, Ints, Array]:
    """Distance, triangle and barycentric coordinates of each ray's first hit."""
    a, b, c = np.moveaxis(corners, 1, 0)
    p = np.cross(directions[:, None], (c - a)[None])
    q = np.cross(eye - a, b - a)
    with np.errstate(all="ignore"):
        across = np.einsum("tj,rtj->rt", b - a, p)
        # A ray along a triangle's plane does not meet it.
        inverse = 1 / np.where(across == 0, np.inf, across)
        u = np.einsum("tj,rtj->rt", eye - a, p) * inverse
        v = directions @ q.T * inverse
        t = np.einsum("tj,tj->t", c - a, q) * inverse
        inside = (u >= -1e-9) & (v >= -1e-9) & (u + v <= 1 + 1e-9) & (t > 1e-6)
    t = np.where(inside, t, np.inf)
    first = t.argmin(axis=1)
    rows = np.arange(len(directions))
    weights = np.stack([1 - u - v, u, v], axis=2)[rows, first]
    return t[rows, first], first, weights


@pytest.fixture
def paint() -> Callable[..., None]:
    """Bind a new constant material to a prim, in a layer of its own file."""

    def bind(stage: Usd.Stage, layer: Path, target: str, **inputs: Any) -> None:
        stage.SetEditTarget(Sdf.Layer.FindOrOpen(str(layer)))
        material = UsdShade.Material.Define(stage, "/World/Materials/by_hand")
        shader = UsdShade.Shader.Define(stage, "/World/Materials/by_hand/Surface")
        shader.CreateIdAttr("UsdPreviewSurface")
        for name, value in inputs.items():
            kind = Sdf.ValueTypeNames.Float if isinstance(value, float) else "color3f"
            kind = Sdf.ValueTypeNames.Color3f if kind == "color3f" else kind
            shader.CreateInput(name, kind).Set(value)
        material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
        UsdShade.MaterialBindingAPI.Apply(stage.GetPrimAtPath(target)).Bind(material)
        stage.GetEditTarget().GetLayer().Save()

    return bind
