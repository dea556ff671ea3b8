"""Every field of room.yaml makes a difference, or says that it makes none."""

from typing import Any, Final

Data = dict[str, Any]

# A room with one of everything that can be described by hand.
BASE: Final[Data] = {
    "room": "office",
    "seed": 1,
    "layout": {
        "polygon": [[0, 0], [5, 0], [5, 4], [0, 4]],
        "partitions": [{"name": "screen", "line": [[3.5, 0], [3.5, 1.5]]}],
        "openings": [
            {"kind": "door", "wall": 0, "at": 1.0, "open": 30},
            {"kind": "window", "wall": 1},
            {"kind": "opening", "wall": 3, "at": 1.0},
        ],
        "trim": dict.fromkeys(
            ("skirting", "cornice", "casing", "picture_rail", "wainscot", "threshold"), True
        ),
        "ceiling": {"kind": "beams"},
        "cladding": [{"name": "tiles", "walls": [2], "span": [1, 2], "top": 2.0}],
    },
    "alignment": {
        "objects": [
            {"name": "desk", "category": "desk", "at": [1, 3], "style": "framed"},
            {"name": "lamp", "category": "table_lamp", "at": [1, 3], "on": "desk"},
            {"name": "tv", "category": "television", "at": [4.5, 3]},
            {"name": "own", "category": "box", "at": [3, 3], "file": "own.obj"},
            {
                "name": "unit",
                "category": "kitchen_cabinet",
                "at": [2, 2],
                "style": "doors",
                "fronts": "slab",
            },
        ]
    },
    "materials": {
        "resolution": 16,
        "floor": {"family": "oak_planks", "number": 1},
        "walls": {"substance": "paint"},
        "ceiling": {"color": [0.5, 0.5, 0.5]},
        "overrides": {"desk": {"all": {"color": [0.2, 0.3, 0.4]}}},
    },
    "lights": {
        "environment": {"from": "constant"},
        "lamps": {"lamp": {"lumen": 400}},
        "screens": {"tv": {"nits": 150}},
    },
    "cameras": {"resolution": [16, 12], "views": [{"eye": [1, 1, 1.5], "target": [3, 3, 1]}]},
    "physics": {"objects": {"desk": {}}},
}
OBJ: Final = "v 0 0 0\nv 1 0 0\nv 1 2 0\nv 0 2 0\nv 0.5 0.5 3\n" + "".join(
    f"f {face}\n" for face in ("4 3 2 1", "1 2 5", "2 3 5", "3 4 5", "4 1 5")
)
SKY: Final[Data] = {"latitude": 50, "longitude": 10, "date": "2026-06-21", "time": "12:00"}
_OUTSIDE: Final[Data] = {"scene": "garden", "near": False}

# By model and field: where it stands, another value, and what else there is for it to matter.
CHANGES: Final[dict[str, tuple[str, Any]]] = {
    "polygon.polygon": ("layout.polygon", [[0, 0], [5, 0], [5, 4.5], [0, 4]]),
    "polygon.height": ("layout.height", 2.9),
    "polygon.wall_thickness": ("layout.wall_thickness", 0.3),
    "Partition.line": ("layout.partitions.0.line", [[3.4, 0], [3.4, 1.5]]),
}
