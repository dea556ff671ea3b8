"""Move a sofa in the edits layer, as a USD editor would: the next compose keeps it.

Run: python examples/03_edit_in_usd.py OUT
"""

import sys
from pathlib import Path

from pxr import UsdGeom

import openrooms_usd as ou

SOFA = "/World/Furniture/sofa"


def where(scene: ou.Scene) -> str:
    stage = scene.stage()
    position = UsdGeom.Xformable(stage.GetPrimAtPath(SOFA)).ComputeLocalToWorldTransform(0)
    return "({:.2f}, {:.2f})".format(*list(position.ExtractTranslation())[:2])


def main(out: Path) -> None:
    description = ou.copy_example(out / "source")
    scene = ou.compose(description, out)
    print("the sofa stands at", where(scene))

    with scene.editing() as stage:
        UsdGeom.XformCommonAPI(stage.GetPrimAtPath(SOFA)).SetTranslate((2.3, 3.8, 0.0))

    scene = ou.compose(description, out)
    print("composed again:", ", ".join(f"{s.stage} {s.state}" for s in scene.stages))
    print("the sofa stands at", where(scene))


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out/example_03"))
