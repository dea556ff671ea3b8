"""What of an exchange file arrives in Blender: every mesh, place, material, light and camera.

Each is compared with the stage as we read it, of the example and of a generated room.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.usd.cameras import FLIP, read_camera
from openrooms_usd.usd.light.lights import DomeLight, MeshLight, read_lights
from openrooms_usd.usd.shading.materialreader import read_preview_surface
from openrooms_usd.usd.shading.materials import bound_material, bound_subsets
from openrooms_usd.usd.shading.surfaces import Texture
from orusd_usdz import UsdzExporter
from tests.blender.conftest import Blender

pytestmark = pytest.mark.slow

PLACE_M: Final = 1e-4
NUMBER: Final = 1e-4


@dataclass(frozen=True)
class Drawn:
    """A mesh that is drawn, in the room or in Blender.

    Attributes:
        unit: The piece of furniture that it is part of, empty for what belongs to the room itself.
        shape: What it is called.
        materials: The materials that it wears, sorted.
        vertices: How many it has.
        low: Corner of the box around it in the world, metres.
        high: The other corner.
    """

    unit: str
    shape: str
    materials: tuple[str, ...]
    vertices: int
    low: tuple[float, ...]
    high: tuple[float, ...]

    @property
    def key(self) -> tuple[Any, ...]:
        return self.unit, self.shape, self.materials, self.vertices

    def is_at(self, other: "Drawn") -> bool:
        off = np.array([self.low, self.high]) - np.array([other.low, other.high])
        return bool(np.abs(off).max() < PLACE_M)


def drawn_by(stage: Usd.Stage) -> list[Drawn]:
    cache = UsdGeom.XformCache()
    found = []
    for prim in Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies()):
        shown = UsdGeom.Imageable(prim)
        if not prim.IsA(UsdGeom.Mesh) or shown.ComputePurpose() != UsdGeom.Tokens.default_:
            continue
        matrix = np.array(cache.GetLocalToWorldTransform(prim))
        points = np.array(UsdGeom.Mesh(prim).GetPointsAttr().Get())
        places = points @ matrix[:3, :3] + matrix[3, :3]
        worn = {material.GetPrim().GetName() for material in worn_by(prim)}
        path = str(prim.GetPath())
        inside = path.startswith(f"{names.FURNITURE}/")
        unit = path.removeprefix(f"{names.FURNITURE}/").split("/")[0] if inside else ""
        corners = (tuple(map(float, axis)) for axis in (places.min(axis=0), places.max(axis=0)))
        found.append(Drawn(unit, prim.GetName(), tuple(sorted(worn)), len(points), *corners))
    return found


def worn_by(prim: Usd.Prim) -> Iterator[Any]:
    """The materials of a mesh, or of the parts that its faces fall into."""
    parts = bound_subsets(prim)
    counts = UsdGeom.Mesh(prim).GetFaceVertexCountsAttr().Get()
    if sum(len(faces) for faces, _ in parts) < len(counts) and (whole := bound_material(prim)):
        yield whole
    yield from (material for _, material in parts)


def drawn_in_blender(meshes: list[dict[str, Any]]) -> list[Drawn]:
    found = []
    for mesh in meshes:
        path = [plain(name) for name in mesh["path"]]
        unit = path[path.index("Furniture") + 1] if "Furniture" in path else ""
        worn = tuple(sorted({plain(name) for name in mesh["materials"]}))
        corners = (tuple(mesh[name]) for name in ("low", "high"))
        found.append(Drawn(unit, path[-1], worn, mesh["vertices"], *corners))
    return found


def plain(name: str) -> str:
    """A name without the number that Blender puts behind the second of its kind."""
    return re.sub(r"\.\d{3,}$", "", name)


def unmatched(ours: list[Drawn], theirs: list[Drawn]) -> tuple[list[Drawn], list[Drawn]]:
    """What only one of both has; each of ours takes one of theirs that is the same."""
    left, alone = list(theirs), []
    for mesh in ours:
        same = next((x for x in left if x.key == mesh.key and x.is_at(mesh)), None)
        alone.append(mesh) if same is None else left.remove(same)
    return alone, left


def looks_of(stage: Usd.Stage) -> dict[str, list[list[Any]]]:
    """By name of a material: base colour, roughness and metallic of those that are called so."""
    prims = Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies())
    worn = {x.GetPath(): x for prim in prims if prim.IsA(UsdGeom.Mesh) for x in worn_by(prim)}
    looks: dict[str, list[list[Any]]] = {}
    for path, material in worn.items():
        surface = read_preview_surface(material)[0]
        inputs = (surface.base_color, surface.roughness, surface.metallic)
        looks.setdefault(path.name, []).append([picture_or_number(x) for x in inputs])
    return looks


def picture_or_number(value: Any) -> Any:
    return Path(value.file.rstrip("]")).name if isinstance(value, Texture) else value


def is_same(ours: list[Any], theirs: list[Any]) -> bool:
    """Whether inputs are linked to the same pictures, and have the same numbers."""
    pairs = list(zip(ours, theirs, strict=True))
    if any(isinstance(a, str) or isinstance(b, str) for a, b in pairs if a != b):
        return False
    return all(np.allclose(a, b, atol=NUMBER) for a, b in pairs if a != b)


@pytest.fixture(scope="session", params=["example", "bedroom"])
def arrival(
    request: pytest.FixtureRequest, blender: Blender, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Usd.Stage, dict[str, Any]]:
    """A room, and what Blender has of its exchange file."""
    out = request.getfixturevalue(request.param)
    stage = Usd.Stage.Open(str(out / "scene.usda"))
    file = tmp_path_factory.mktemp("exchange") / "room.usdz"
    UsdzExporter().convert(stage, file, {"profile": "exchange"})
    return stage, blender("seen", file) | blender("arrived", file)


def test_every_mesh_is_where_it_was_and_wears_what_it_wore(arrival: Any) -> None:
    """Counts, names, vertices, boxes in the world and materials of each, repeats too."""
    stage, found = arrival
    ours, theirs = drawn_by(stage), drawn_in_blender(found["drawn"])
    assert len(ours) == len(theirs) > 80
    assert unmatched(ours, theirs) == ([], [])


def test_furniture_has_its_frame(arrival: Any) -> None:
    stage, found = arrival
    cache, compared = UsdGeom.XformCache(), 0
    for prim in stage.GetPrimAtPath(names.FURNITURE).GetChildren():
        # Instances inside of a copy of a room are named anew; these stand in the scene itself.
        if prim.GetName() not in found["places"]:
            continue
        theirs = np.array(found["places"][prim.GetName()])
        ours = np.array(cache.GetLocalToWorldTransform(prim)).T
        np.testing.assert_allclose(theirs, ours, atol=PLACE_M, err_msg=prim.GetName())
        compared += 1
    assert compared >= 9


def test_materials_have_their_numbers_and_pictures(arrival: Any) -> None:
    stage, found = arrival
    looks = looks_of(stage)
    theirs: dict[str, list[list[Any]]] = {}
    for look in found["materials"]:
        values = [look.get(name) for name in ("Base Color", "Roughness", "Metallic")]
        theirs.setdefault(plain(look["name"]), []).append(values)
    assert set(looks) <= set(theirs) and len(looks) > 10
    for name, ours in looks.items():
        for look in ours:
            assert any(is_same(look, other) for other in theirs[name]), (name, look, theirs[name])


def test_lamps_glow_and_no_portal_is_a_lamp(arrival: Any) -> None:
    stage, found = arrival
    lights = read_lights(stage)
    lamps = [light for light in lights if isinstance(light, MeshLight)]
    assert len(lights) == len(lamps) + 1 and any(isinstance(light, DomeLight) for light in lights)
    assert found["lamps"] == {}
    glow = sorted(found["glow"].values())
    lit = [light.radiance.tolist() for light in lamps if light.radiance.any()]
    np.testing.assert_allclose(glow, sorted(lit), rtol=1e-5)


def test_cameras_see_the_same(arrival: Any) -> None:
    stage, found = arrival
    cameras = [prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Camera)]
    assert {prim.GetName() for prim in cameras} == set(found["cameras"])
    for prim in cameras:
        theirs, ours = found["cameras"][prim.GetName()], read_camera(prim, 640, 480)
        np.testing.assert_allclose(theirs["matrix"], ours.world_from_camera @ FLIP, atol=1e-5)
        degrees = np.degrees(2 * np.arctan(320 / ours.K[0, 0]))
        assert theirs["fov"] == pytest.approx(degrees, rel=1e-5)
