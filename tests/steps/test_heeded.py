"""Every field of room.yaml makes a difference, or it is said that it makes none."""

import copy
import json
import re
import shutil
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from typing import Any, Final, get_args

import pytest
from pxr import Sdf
from pydantic import BaseModel

from openrooms_usd import names
from openrooms_usd.composing import compose_room
from openrooms_usd.description import room_of
from openrooms_usd.description.room import Room
from openrooms_usd.errors import DescriptionError

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
    "furniture": {
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
GARDEN: Final[Data] = {"scene": "garden", "near": False}
POSE: Final[Data] = {"world_from_camera": [[1, 0, 0, 2], [0, 0, 1, 1], [0, -1, 0, 1.5]]}
SELECT: Final[Data] = {"from": "select", "count": 4}
Patch = tuple[str, Any]
SECTIONS: Final = tuple(map(names.section_of, names.STEPS))
W, A, M, E, C, P = (
    "layout.openings.",
    "furniture.objects.",
    "materials.",
    "lights.environment.",
    "cameras.views.0.",
    "physics.",
)
T, L = "layout.trim.", "lights.lamps.lamp."

# By section: what the room has besides, and other values by where they stand.
CHANGES: Final[list[tuple[str, list[Patch], list[Patch]]]] = [
    ("layout", [], [
        ("layout.polygon", [[0, 0], [5, 0], [5, 4.5], [0, 4]]), ("layout.height", 2.9),
        ("layout.wall_thickness", 0.3), ("room", "bedroom"),
        ("layout.partitions.0.line", [[3.4, 0], [3.4, 1.5]]),
        ("layout.partitions.0.thickness", 0.2), ("layout.partitions.0.height", 1.5),
        ("layout.partitions.0.height", 5.0), ("layout.partitions.0.name", "other"),
        (W + "0.kind", "opening"), (W + "0.name", "other"), (W + "0.wall", 2), (W + "0.at", 1.2),
        (W + "0.width", 1.0), (W + "0.height", 2.2), (W + "0.sill", 0.1), (W + "0.open", 60),
        (W + "0.hinge", "right"), (W + "0.swing", "out"), (W + "0.style", "flush"),
        (W + "0.beyond", "hallway"), (W + "1.open", 30), (W + "1.hinge", "right"),
        (W + "1.swing", "out"), (W + "1.style", "grid"), (W + "1.beyond", "hallway"),
        (W + "2.open", 30), (W + "2.hinge", "right"), (W + "2.swing", "out"), (W + "2.sill", 0.3),
        (W + "1", {"kind": "window", "partition": "screen", "width": 0.6}),
        (W + "1.partition", "screen"),
        *[(T + kind, None) for kind in BASE["layout"]["trim"]],
        *[(T + kind + ".height", 0.15) for kind in ("skirting", "cornice", "picture_rail")],
        *[(T + kind + ".depth", 0.03) for kind in BASE["layout"]["trim"] if kind != "threshold"],
        *[(T + kind + ".profile", "ogee") for kind in ("skirting", "cornice", "casing")],
        (T + "picture_rail.profile", "ogee"), (T + "picture_rail.at", 1.8),
        (T + "wainscot.height", 1.1), (T + "casing.width", 0.1), (T + "threshold.height", 0.01),
        ("layout.ceiling.kind", "grid"), ("layout.ceiling.spacing", 0.7),
        ("layout.ceiling.width", 0.2), ("layout.ceiling.depth", 0.2), ("layout.ceiling.along", "x"),
        ("layout.cladding.0.name", "other"), ("layout.cladding.0.walls", [1]),
        ("layout.cladding.0.span", [1, 2.5]), ("layout.cladding.0.bottom", 0.3),
        ("layout.cladding.0.top", 1.5), ("layout.cladding.0.depth", 0.02),
    ]),
    ("furniture", [], [
        ("seed", 2), (A + "0.name", "other"), (A + "0.category", "table"), (A + "0.at", [1.1, 3]),
        (A + "0.yaw", 20), (A + "0.tilt", [5, 0]), (A + "0.size", [1.5, 0.8, 0.74]),
        (A + "0.style", "writing"), (A + "1.relative_to", "desk"), (A + "1.on", "floor"),
        (A + "3.name", "x"), (A + "3.category", "chair"), (A + "3.at", [3, 2]), (A + "3.yaw", 9),
        (A + "3.tilt", [5, 0]), (A + "3.on", "ceiling"), (A + "3.relative_to", "desk"),
        (A + "3.size", [1, 1, 1]), (A + "3.up", "Z"), (A + "3.front", "+X"), (A + "3.unit", 0.5),
        (A + "3.file", "other.obj"), (A + "4.fronts", "shaker"), (A + "4.cutouts", [[0, 0, 1, 1]]),
    ]),
    ("furniture", [(A + "0.on", "wall")], [(A + "0.yaw", 30), (A + "0.tilt", [5, 0])]),
    ("materials", [], [
        ("style", "rustic"), (M + "floor", None), (M + "walls", None), (M + "ceiling", None),
        (M + "floor.family", "oak_parquet"), (M + "floor.number", 2),
        (M + "floor.color", [0.1, 0.2, 0.3]), (M + "floor.roughness", 0.9), (M + "floor.size", 0.5),
        (M + "floor", {"file": "tiles"}), (M + "walls.substance", "wood"), (M + "walls.number", 3),
        (M + "ceiling.roughness", 0.2), (M + "ceiling.metallic", 0.7), (M + "ceiling.number", 3),
        (M + "ceiling.size", 1.0), (M + "trim", "wood"), (M + "beams", "oak_planks"),
        (M + "accents", {"wall_1": "wood"}), (M + "cladding", {"tiles": "wood"}),
        (M + "overrides", {}), (M + "annotations", {"tv": "notes.txt"}),
        (M + "scale", {"color": [0.5, 0.6]}), (M + "scale.color", [0.5, 0.6]),
        (M + "scale.roughness", [0.5, 0.6]), (M + "looks", 2), (M + "texture_size", 3.0),
        (M + "resolution", 32),
    ]),
    ("materials", [(M + "looks", 2)], [(M + "look", 1)]),
    ("lights", [], [
        (E + "color", [1, 0.5, 0.2]), (E + "illuminance", 50), (L + "lumen", 30),
        (L + "kelvin", 4000), (L + "color", [1, 0, 0]), (L + "profile", "spot"), (L + "on", False),
        ("lights.lamps.lamp", {"radiance": [1, 2, 3]}), ("lights.screens.tv.nits", 20),
        ("lights.screens.tv.on", False), ("lights.screens.tv.shows", "desktop"),
    ]),
    ("lights", [(L + "profile", "spot")], [(L + "beam", 50)]),
    ("lights", [("lights.lamps.lamp", {"radiance": [1, 2, 3]})], [(L + "radiance", [3, 2, 1])]),
    ("lights", [("lights.environment", SKY)], [
        (E + "latitude", 40), (E + "longitude", 20), (E + "date", "2026-01-01"),
        (E + "time", "09:00"), (E + "utc_offset", 1), (E + "turbidity", 6), (E + "overcast", True),
        (E + "ground", [0.5, 0.5, 0.5]), (E + "north", 90), (E + "illuminance", 500),
    ]),
    ("lights", [("lights.environment", GARDEN)], [
        (E + "scene", "city"), (E + "storey", 3), (E + "facing", 0), (E + "clouds", 0.9),
        (E + "near", True), (E + "seed", 4), (E + "latitude", 40), (E + "longitude", 20),
        (E + "date", "2026-01-01"), (E + "time", "09:00"), (E + "utc_offset", 1),
        (E + "turbidity", 6), (E + "overcast", True), (E + "ground", [0.5, 0.5, 0.5]),
        (E + "north", 90), (E + "illuminance", 500),
    ]),
    ("cameras", [], [
        (C + "fov", 70), (C + "f_stop", 2.8), (C + "focus", 2.0), (C + "exposure_value", 5.0),
        (C + "name", "x"), (C + "eye", [2, 1, 1.5]), (C + "target", [2, 2, 1]),
        ("cameras.resolution", [32, 12]),
    ]),
    ("cameras", [(C + "f_stop", 2.8)], [(C + "focus", 2.0), (C + "focus", "subject")]),
    ("cameras", [("cameras.views.0", POSE)], [
        (C + "name", "v"), (C + "fov", 70), (C + "f_stop", 2.8), (C + "focus", 2.0),
        (C + "exposure_value", 4.0),
        (C + "world_from_camera", [[1, 0, 0, 3], [0, 0, 1, 1], [0, -1, 0, 1.5]]),
    ]),
    ("cameras", [("cameras.views.0", SELECT)], [
        (C + "name", "v"), (C + "count", 3), (C + "spare", 1), (C + "prefer", "paper"),
        (C + "height", [1.0, 1.1]), (C + "distance", [0.5, 0.6]), (C + "fov", 70),
        (C + "f_stop", 2.8), (C + "focus", "subject"), (C + "exposure_value", 4.0),
    ]),
    ("physics", [], [
        ("physics", None), (P + "shapes", "box"), (P + "tolerance", 0.05), (P + "gravity", 1.6),
        (P + "objects.desk.body", "fixed"), (P + "objects.desk.mass", 99.0),
        (P + "objects.desk.shapes", "box"), (P + "objects.desk.friction", 0.9),
    ]),
]  # fmt: skip


def put(data: Data, path: str, value: Any) -> None:
    """Set a value of a description by the steps to it."""
    *steps, last = path.split(".")
    inner: Any = data
    for step in steps:
        if isinstance(inner, list):
            inner = inner[int(step)]
            continue
        if inner.get(step) in (None, True):
            inner[step] = {}
        inner = inner[step]
    inner[int(last) if isinstance(inner, list) else last] = value


def written(out: Path, section: str) -> tuple[str, set[str]]:
    """What the step of a section wrote, but for what it was written from."""
    step = names.STEPS[SECTIONS.index(section)]
    layer = Sdf.Layer.OpenAsAnonymous(str(out / "layers" / f"{step}.usda"))
    layer.customLayerData = {}
    text = re.sub(r'"fingerprint", "[0-9a-f]+", "seed", "\d+"', "", layer.ExportToString())
    return text, {path.name for path in (out / "layers" / step).rglob("*") if path.is_file()}


@cache
def below(text: str, section: str, source: Path) -> Path:
    """A folder with all layers below that of a section of a room."""
    out = Path(mkdtemp(dir=source))
    for name in SECTIONS[: SECTIONS.index(section)]:
        compose_room(room_of(json.loads(text)), out, only=name, base=source)
    return out


def composed(data: Data, section: str, source: Path) -> tuple[tuple[str, set[str]], list[str]]:
    """What the step of a section writes for a room, and what it notes."""
    weaker = SECTIONS[: SECTIONS.index(section)]
    kept = {key: data[key] for key in ("room", "seed", "style", *weaker) if key in data}
    out = Path(mkdtemp(dir=source)) / "out"
    room = room_of(data)
    shutil.copytree(below(json.dumps(kept), section, source), out)
    made = compose_room(room, out, only=section, base=source)
    return written(out, section), [note for row in made.stages for note in row.notes]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("section", "besides", "changes"),
    CHANGES,
    ids=[f"{s}-{i}" for i, (s, _, _) in enumerate(CHANGES)],
)
def test_what_a_field_says_is_heeded_or_answered(
    section: str, besides: list[Patch], changes: list[Patch], tmp_path: Path
) -> None:
    for name in ("own.obj", "other.obj"):
        (tmp_path / name).write_text(OBJ.replace("0.5 0.5 3", f"0.5 0.5 {len(name)}"))
    base = copy.deepcopy(BASE)
    for path, value in besides:
        put(base, path, value)
    usual, said = composed(base, section, tmp_path)
    silent = []
    for path, value in changes:
        data = copy.deepcopy(base)
        put(data, path, value)
        try:
            found, notes = composed(data, section, tmp_path)
        except DescriptionError:
            continue  # refused: that is an answer
        if found == usual and notes == said:
            silent.append((path, value))
    assert silent == []


# What a capture, a scan, a file of others or the generator fills, and what is for people alone.
FILLED: Final = re.compile(r"(RoomPlan|Scan2Cad|Boxes|Scan|Imported|Captured|Generated)[A-Z]\w*")
ELSEWHERE: Final = {"FrameCameras", "ScannedObject", "ScannedPose", "ScannedBox", "FileEnvironment"}
OTHERWISE: Final = {
    "MaterialChoice.file",
    "Room.name",
    "Room.clutter",
    "Cameras.views",
    "Materials.overrides",
}


def models(kind: Any, seen: set[type[BaseModel]]) -> None:
    """All models that a type is made of."""
    if isinstance(kind, type) and issubclass(kind, BaseModel) and kind not in seen:
        seen.add(kind)
        for info in kind.model_fields.values():
            for inner in (info.annotation, *info.metadata):
                models(inner, seen)
    for part in get_args(kind):
        models(part, seen)


def touched() -> Iterator[str]:
    """The fields that the changes say something of, by their models."""
    for _, besides, changes in CHANGES:
        base = copy.deepcopy(BASE)
        for path, value in besides:
            put(base, path, value)
        room = room_of(base)
        for path, _ in changes:
            *steps, last = path.split(".")
            inner: Any = room
            for step in steps:
                if isinstance(inner, BaseModel):
                    inner = getattr(inner, step)
                else:
                    inner = inner[int(step) if isinstance(inner, tuple) else step]
            if isinstance(inner, BaseModel):
                yield f"{type(inner).__name__}.{last}"


def test_every_field_is_changed_once() -> None:
    """A new field of a description needs a row in `CHANGES`."""
    seen: set[type[BaseModel]] = set()
    models(Room, seen)
    inner = {
        f"{kind.__name__}.{name}"
        for kind in seen
        if not FILLED.fullmatch(kind.__name__) and kind.__name__ not in ELSEWHERE
        for name, info in kind.model_fields.items()
        if name != "source" and not _holds_models(info.annotation)
    }
    assert sorted(inner - {*touched()} - OTHERWISE) == []


def _holds_models(kind: Any) -> bool:
    held: set[type[BaseModel]] = set()
    models(kind, held)
    return bool(held)
