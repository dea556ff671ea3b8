"""Move a sofa in the edits layer, as a USD editor would: the next compose keeps it.

Run: python examples/03_edit_in_usd.py OUT
"""

import sys
from pathlib import Path

from pxr import Sdf, Usd, UsdGeom

from openrooms_usd import compose_room
from openrooms_usd.demo import copy_example

SOFA = "/World/Furniture/sofa"


def where(scene: Path) -> str:
    stage = Usd.Stage.Open(str(scene))
    position = UsdGeom.Xformable(stage.GetPrimAtPath(SOFA)).ComputeLocalToWorldTransform(0)
    return "({:.2f}, {:.2f})".format(*list(position.ExtractTranslation())[:2])


def main(out: Path) -> None:
    description = copy_example(out / "source")
    scene = compose_room(description, out).scene
    print("the sofa stands at", where(scene))

    stage = Usd.Stage.Open(str(scene))
    stage.SetEditTarget(Sdf.Layer.FindOrOpen(str(out / "layers" / "edits.usda")))
    UsdGeom.XformCommonAPI(stage.GetPrimAtPath(SOFA)).SetTranslate((2.3, 3.8, 0.0))
    stage.GetEditTarget().GetLayer().Save()

    summary = compose_room(description, out)
    print("composed again:", ", ".join(f"{s.stage} {s.state}" for s in summary.stages))
    print("the sofa stands at", where(scene))


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out/example_03"))
