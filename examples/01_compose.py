"""A room in a few lines: describe it, compose it, look at what became of it.

Run: python examples/01_compose.py OUT
"""

import sys
from pathlib import Path

import openrooms_usd as ou

ROOM = {
    "room": "office",
    "seed": 3,
    "layout": {
        "polygon": [[0, 0], ["420 cm", 0], ["420 cm", "300 cm"], [0, "300 cm"]],
        "openings": [
            {"kind": "window", "wall": 0},
            {"kind": "door", "wall": 2, "at": "90 cm", "open": "70 deg"},
        ],
    },
    "alignment": {
        "objects": [
            {"category": "table", "at": [2.1, 0.7], "size": ["160 cm", "80 cm", "74 cm"]},
            {"category": "chair", "at": [2.1, 1.5]},
            {"category": "ceiling_lamp", "at": [2.1, 1.5]},
        ]
    },
}


def main(out: Path) -> None:
    scene = ou.compose(ROOM, out)
    for stage in scene.stages:
        print(f"{stage.stage:<10} {stage.state}")
    print(f"{len(ou.validate(scene))} findings in {scene.path.name}")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out/example_01"))
