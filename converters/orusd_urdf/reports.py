"""What became of every prim of a stage that robots' formats might be expected to keep."""

from collections.abc import Iterable, Iterator
from typing import Final

from pxr import Usd, UsdGeom, UsdLux

from openrooms_usd.exporters import Report
from openrooms_usd.physics.world import World
from orusd_urdf.looks import Loss

_NOTHING: Final = "there is no place for it in a robot's scene"


def export_report(
    stage: Usd.Stage, world: World, notes: Iterable[Loss], *, seen: bool = False
) -> Report:
    """A report of bodies, of what was lost, and of lights and cameras.

    Args:
        stage: The composed stage.
        world: What was read from it.
        notes: (prim, outcome, reason) of everything else.
        seen: Whether lights and cameras were kept.
    """
    report = Report()
    losses = dict.fromkeys([*world.losses, *notes])
    lossy = {path for path, _, _ in losses}
    for body in world.bodies:
        for link in body.links:
            if link.path not in lossy and not link.between:
                report.add(link.path, "translated")
    for path, outcome, reason in losses:
        report.add(path, outcome, reason)  # type: ignore[arg-type]
    for prim in _lights_and_cameras(stage):
        report.add(prim.GetPath(), *(("translated",) if seen else ("skipped", _NOTHING)))
    return report


def _lights_and_cameras(stage: Usd.Stage) -> Iterator[Usd.Prim]:
    for prim in stage.Traverse():
        # A mesh that shines is kept as a mesh.
        light = prim.HasAPI(UsdLux.LightAPI) and not prim.IsA(UsdGeom.Gprim)
        if light or prim.IsA(UsdGeom.Camera):
            yield prim
