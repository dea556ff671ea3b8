"""The example and two generated rooms through every exporter: nothing is lost in silence.

What is drawn, shines or looks is told of in each report, itself or by what it is a part of.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import pytest
from pxr import Usd, UsdGeom, UsdLux

from openrooms_usd import adapters
from openrooms_usd.exporters import Report, convert_stage

ROOMS: Final = ("demo", "bedroom-12", "kitchen-1")
# By name: the exporter, what it writes, and what it is asked for.
EXITS: Final[dict[str, tuple[str, str, dict[str, str]]]] = {
    "mitsuba": ("mitsuba", "scene", {}),
    "gltf": ("gltf", "room.glb", {}),
    "openrooms-xml": ("openrooms-xml", "scene", {}),
    "usdphysics": ("usdphysics", "room", {}),
    "urdf": ("urdf", "room", {}),
    "mjcf": ("mjcf", "room", {}),
    "default": ("usdz", "room.usdz", {"profile": "default"}),
    "exchange": ("usdz", "room.usdz", {"profile": "exchange"}),
    "arkit": ("usdz", "room.usdz", {"profile": "arkit"}),
}
# What moves and collides is theirs, whatever it looks like.
OF_BODIES: Final = ("usdphysics", "urdf", "mjcf")

pytestmark = pytest.mark.slow


def drawn(stage: Usd.Stage) -> list[str]:
    """Meshes, instances of models, lights and cameras that a renderer takes."""
    found = []
    for prim in stage.Traverse():
        looks = prim.IsInstance() or prim.IsA(UsdGeom.Gprim) or prim.IsA(UsdGeom.Camera)
        if not (looks or prim.HasAPI(UsdLux.LightAPI)):
            continue
        image = UsdGeom.Imageable(prim)
        if image.ComputeVisibility() != UsdGeom.Tokens.invisible and (
            image.ComputePurpose() in (UsdGeom.Tokens.default_, UsdGeom.Tokens.render)
        ):
            found.append(str(prim.GetPath()))
    return found


def untold(paths: list[str], report: Report) -> list[str]:
    """Those of which no row tells: of them, of what they are a part of, or of a part of them."""
    told = {prim for prim, _, _ in report.rows}
    above = {str(parent) for prim in told for parent in _parents(prim)}
    return [p for p in paths if p not in above and told.isdisjoint({p, *_parents(p)})]


def _parents(path: str) -> list[str]:
    # Not the room as a whole: to tell of that tells of nothing.
    parts = path.strip("/").split("/")
    return ["/" + "/".join(parts[:count]) for count in range(3, len(parts))]


def marked(name: str) -> Any:
    """A room with its worker; all but the example are long."""
    long = [] if name == "demo" else [pytest.mark.long]
    return pytest.param(name, marks=[pytest.mark.xdist_group(name), *long])


@pytest.fixture(params=map(marked, ROOMS))
def room(request: pytest.FixtureRequest, with_physics: Callable[[str], Path]) -> Path:
    return with_physics(request.param)


@pytest.mark.parametrize("name", EXITS)
def test_a_room_leaves_by_every_exit(name: str, room: Path, tmp_path: Path) -> None:
    kind, target, options = EXITS[name]
    stage = Usd.Stage.Open(str(room))
    report = convert_stage(room, tmp_path / target, to=kind, options=options)
    assert (tmp_path / target).exists()
    assert all(reason for _, _, reason in report.losses())
    paths = drawn(stage)
    assert len(paths) > 20
    if kind in OF_BODIES:
        paths = [path for path in paths if path.startswith("/World/Furniture/")]
    assert untold(paths, report) == []


def test_every_exporter_is_an_exit() -> None:
    assert set(adapters.available(adapters.EXPORTERS)) == {kind for kind, _, _ in EXITS.values()}


def test_a_row_that_is_missing_is_seen() -> None:
    report = Report([("/World/Furniture/chair_0", "translated", "")])
    paths = ["/World/Furniture/chair_0/Seat", "/World/Furniture/chair_1/Seat"]
    assert untold(paths, report) == ["/World/Furniture/chair_1/Seat"]
