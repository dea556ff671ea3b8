"""Move a table, paint a sofa, add a vase: opinions in the edits, which the next compose keeps.

Run: python examples/03_edit.py OUT
"""

import sys
from pathlib import Path

import openrooms_usd as ou


def show(scene: ou.Scene, *names: str) -> None:
    for name in names:
        thing = scene.objects[name]
        x, y, z = thing.pose[:3, 3]
        print(f"{thing.category} at ({x:.2f}, {y:.2f}, {z:.2f})")


def main(out: Path) -> None:
    scene = ou.compose(ou.copy_example(out / "source"), out)
    show(scene, "side_table", "table_lamp")

    with scene.editing():  # saved together at the end of the block, or not at all
        scene.objects["side_table"].move(0.1, -0.3).turn(15)
        scene.objects["sofa"].set_color((0.05, 0.1, 0.3), roughness=0.9)
        vase = scene.add("vase", at=(4.45, 1.75), on="dining_table")

    # The lamp stands on the table, and follows it when the room is composed again.
    changed = scene.recompose()
    print("composed again:", ", ".join(f"{row.stage} {row.state}" for row in changed.stages))
    show(scene, "side_table", "table_lamp", vase.name)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out/example_03"))
