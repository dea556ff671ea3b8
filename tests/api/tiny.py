"""A room that composes and renders in a moment."""

from typing import Any

ROOM: dict[str, Any] = {
    "room": "office",
    "seed": 3,
    "layout": {
        "polygon": [[0, 0], [4, 0], [4, 3], [0, 3]],
        "openings": [{"kind": "window", "wall": 0}],
    },
    "furniture": {
        "objects": [
            {"category": "chair", "at": [1.5, 0.8], "yaw": "180 deg"},
            {"category": "ceiling_lamp", "at": [2, 1.5]},
        ]
    },
    "materials": {"resolution": 16},
    "cameras": {
        "resolution": [16, 12],
        "views": [
            {"name": "left", "eye": [0.5, 0.5, 1.5], "target": [2, 1.5, 1]},
            {"name": "right", "eye": [3.5, 0.5, 1.5], "target": [2, 1.5, 1]},
        ],
    },
}

# Of every kind.
CHANNELS = "radiance,depth,position,semantic,valid,radiance_i,mask_i,environment"
