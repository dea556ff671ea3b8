"""A room in a few lines: describe it, compose it, look at what became of it.

Run: python examples/01_compose.py OUT
"""

import sys
from pathlib import Path

import openrooms_usd as ou


def main(out: Path) -> None:
    room = ou.new_room("office", width="420 cm", depth="300 cm", seed=3)
    room.add_window(wall=0)
    room.add_door(wall=2, at="90 cm", open="70 deg")
    room.add("table", at=(2.1, 0.7), size=("160 cm", "80 cm", "74 cm"))
    room.add("chair", at=(2.1, 1.5))
    room.add("ceiling_lamp", at=(2.1, 1.5))

    scene = room.compose(out)
    for stage in scene.stages:
        print(f"{stage.stage:<10} {stage.state}")
    print(f"{len(ou.validate(scene))} findings in {scene.path.name}")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out/example_01"))
