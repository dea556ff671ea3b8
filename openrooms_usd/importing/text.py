"""The text of a room.yaml for what was captured: short, commented, and to be changed."""

import json
import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, get_args

from openrooms_usd.arrays import Array
from openrooms_usd.capture import NO_OPTIONS, Capture, CapturedModel
from openrooms_usd.description.room import RoomType
from openrooms_usd.description.scanned import CAPTURES
from openrooms_usd.furniture.words import plain

if TYPE_CHECKING:
    from openrooms_usd.steps.alignment.captured import Captured


# About how many cameras a capture with photographs begins with.
_CAMERAS: Final = 5
# What a lamp in the middle of the room needs around it, metres.
_CLEAR: Final = 0.3
# Objects that are known beside the scan are numbered from here: its own instances are fewer.
_FIRST: Final = 100_001
_NYU_LAMP: Final = 35
# Options of plain scans that the description has words for.
_STANDS: Final = ("unit", "up")

_TEMPLATE: Final = """\
# Made from {file} by: orusd import {kind}
# You may change everything; lengths are metres unless they carry a unit (240 cm), angles degrees.
name: {name}
room: {use}  # such as living_room, bedroom, office: `orusd schema` lists them
seed: 0

layout:
{source}
{openings}
furniture:
{source}
{further}
lights:
{lights}

cameras:
{cameras}
"""
_HANGING: Final = """\
  objects:
    # The scan has no lamps: one hangs in the centre of the room.
    - {{name: ceiling_lamp, category: ceiling_lamp, at: [{x:.2f}, {y:.2f}]}}
"""
_DAYLIGHT: Final = """\
  # Light through the openings: lux on level ground under the open sky.
  environment: {from: constant, illuminance: 10000}
  lamps:
    ceiling_lamp: {lumen: 3000, kelvin: 4000}"""
_SCANNED: Final = """\
# Made from {file} by: orusd import {kind}
# You may change everything; lengths are metres unless they carry a unit (240 cm), angles degrees.
name: {name}
room: {use}  # such as living_room, bedroom, office: `orusd schema` lists them
seed: 0

layout:
{source}

furniture:
{furniture}

lights:
  # Light through the openings: lux on level ground under the open sky.
  environment: {{from: constant, illuminance: 10000}}
{lamps}
cameras:
{cameras}
"""
_LAMP: Final = "{name: ceiling_lamp, category: ceiling_lamp, at: [0, 0]}"
_LAMPS: Final = """\
  lamps:
    ceiling_lamp: {lumen: 3000, kelvin: 4000}
"""
_SELECTED: Final = """\
  resolution: [640, 480]
  views:
    # The best of many views along the walls.
    - {from: select, count: 3FOV}
"""
_FRAMES: Final = """\
  # The cameras of the photographs: one in {every} of {count}.
  from: capture
  every: {every}
"""
_OPENINGS: Final = """\
  # Captured: {captured}. Further ones, by the number of their wall (0 to {last}):
  # openings:
  #   - {{kind: window, wall: 0, width: 120 cm, height: 130 cm, sill: 90 cm}}
"""


def _use(capture: Capture) -> str:
    """The type of room that the source's word means: diningRoom is a dining_room."""
    word = plain(capture.use or "")
    return word if word in get_args(RoomType) else "misc"


def describe(
    kind: str, capture: Capture, file: str, options: Mapping[str, str] = NO_OPTIONS
) -> str:
    """The text of a room.yaml for a capture.

    Args:
        kind: The name of the importer.
        capture: What it read, with a floor.
        file: The captured file, relative to the description.
        options: What the importer is asked; paths are relative to the description.
    """
    assert capture.floor is not None
    kinds = [opening.kind for opening in capture.openings]
    captured = ", ".join(f"{kinds.count(k)} {k}" for k in dict.fromkeys(kinds)) or "no openings"
    return _TEMPLATE.format(
        kind=kind,
        name=re.sub(r"\W+", "_", f"room_{Path(file).stem}", flags=re.ASCII),
        file=_quoted(file),
        use=_use(capture),
        source=_section(kind, file, options),
        openings=_OPENINGS.format(captured=captured, last=len(capture.floor) - 1),
        further=_further_of(capture),
        lights=_indented(light_lines(capture)) if tells_lights(capture) else _DAYLIGHT,
        cameras=_cameras(capture),
    )


def _further_of(capture: Capture) -> str:
    """What follows the captured objects: a lamp where the capture knows of none, and materials."""
    if not tells_lights(capture):
        assert capture.floor is not None
        x, y = _middle(capture.floor)
        return _HANGING.format(x=x, y=y)
    lines = list(material_lines(capture))
    return f"\nmaterials:\n{_indented(lines)}\n" if lines else ""


def describe_scan(
    kind: str, capture: Capture, file: str, options: Mapping[str, str] = NO_OPTIONS
) -> str:
    """The text of a room.yaml for a capture of points, in which the room must be found.

    Args:
        kind: The name of the importer.
        capture: What it read, with points.
        file: The captured file, relative to the description.
        options: What the importer is asked; paths are relative to the description.
    """
    lines = ["from: scan", f"scan: {_quoted(file)}"]
    lines += [] if kind == "scan" else [f"importer: {_quoted(kind)}"]
    lines += _stands(kind, options)
    lines += _options(options if kind != "scan" else _but(options, _STANDS))
    if len(capture.frames) == 1:
        lines += [
            "# A single view shows little of a room, so the rest is guessed.",
            "partial: true",
        ]
    lit = _shows_lamps(capture)
    return _SCANNED.format(
        kind=kind,
        name=re.sub(r"\W+", "_", f"room_{Path(file).stem}", flags=re.ASCII),
        file=_quoted(file),
        use=_use(capture),
        source=_indented(lines),
        furniture=_indented([*_furniture(capture, options), *_further(lit)]),
        lamps="" if lit else _LAMPS,
        cameras=_cameras(capture),
    )


def unlabelled(capture: Capture) -> bool:
    """Whether a capture of points does not say what stands in it."""
    cloud = capture.cloud
    if capture.floor is not None or cloud is None or capture.boxes:
        return False
    told = (cloud.instance, cloud.label)
    return not any(values is not None and values.any() for values in told)


def _shows_lamps(capture: Capture) -> bool:
    """Whether points are labelled as a lamp."""
    cloud = capture.cloud
    return cloud is not None and cloud.label is not None and bool((cloud.label == _NYU_LAMP).any())


def _further(lit: bool) -> Iterator[str]:
    if not lit:
        yield "# The scan shows no lamps: one hangs near its centre, the origin of the room."
        yield f"further: [{_LAMP}]"


def _furniture(capture: Capture, options: Mapping[str, str]) -> Iterator[str]:
    """The section of objects: every one of the scan, or the CADs that were aligned to it."""
    known = [model for model in capture.models if model.file is not None]
    if "models" not in options or not known:
        if unlabelled(capture):
            yield "# The scan has no labels: furniture is found by its shape."
            yield from ("from: scan", "unlabelled: furnish  # or boxes, leave_out")
            return
        yield "# Every labelled instance of the scan; a folder of your own meshes: `cad: FOLDER`."
        yield "from: scan"
        return
    yield from ("from: scan", f"cad: {_quoted(options['models'])}")
    yield "# The CADs that were aligned to the scan. Without these: every labelled instance."
    yield "objects:"
    for number, model in enumerate(known, _FIRST):
        label, cad = _quoted(model.label), _quoted(model.id.partition("_")[2])
        yield f"  - {{instance: {number}, category: {label}, cad: {cad}, pose: {{"
        yield f"      {_pose(capture, model)}}}}}"


def _pose(capture: Capture, model: CapturedModel) -> str:
    """A pose in the scan's own axes, metres."""
    import numpy as np
    from scipy.spatial.transform import Rotation

    from openrooms_usd.steps.layout.scanned import in_metres

    matrix = in_metres(capture.source_from_world) @ model.world_from_model
    scale = np.linalg.norm(matrix[:3, :3], axis=0)
    turn = Rotation.from_matrix(matrix[:3, :3] / scale).as_quat(scalar_first=True)
    parts = {"translation": matrix[:3, 3], "rotation_wxyz": turn, "scale": scale}
    written = (f"{name}: {np.round(values, 6).tolist()}" for name, values in parts.items())
    return ", ".join(written)


def _section(kind: str, file: str, options: Mapping[str, str]) -> str:
    """The first lines of a section that comes from the capture."""
    known = kind in CAPTURES
    lines = [f"from: {kind}"] if known else ["from: capture", f"importer: {_quoted(kind)}"]
    return _indented([*lines, f"file: {_quoted(file)}", *_options(options)])


def _options(options: Mapping[str, str]) -> Iterator[str]:
    if options:
        pairs = (f"{_quoted(name)}: {_quoted(value)}" for name, value in options.items())
        yield f"options: {{{', '.join(pairs)}}}"


def _stands(kind: str, options: Mapping[str, str]) -> Iterator[str]:
    """How a plain scan stands, in words of the description."""
    if kind == "scan" and (unit := options.get("unit")):
        yield f"unit: {unit}"
    if kind == "scan" and (up := options.get("up")):
        axis = {"x": "1, 0, 0", "y": "0, 1, 0", "z": "0, 0, 1"}.get(up.lower())
        yield f"up: [{axis or ', '.join(up.split(','))}]"


def _but(options: Mapping[str, str], names: Iterable[str]) -> dict[str, str]:
    return {name: value for name, value in options.items() if name not in names}


def _indented(lines: Iterable[str]) -> str:
    return "\n".join(f"  {line}" for line in lines)


def _quoted(text: str) -> str:
    """A JSON string, which is a YAML string."""
    return json.dumps(text, ensure_ascii=False)


def _cameras(capture: Capture) -> str:
    count = len(capture.frames)
    if not count:
        fov = "" if capture.fov is None else f", fov: {capture.fov:g}"
        return _SELECTED.replace("FOV", fov).rstrip("\n")
    # Those of a finished scene were chosen already.
    every = 1 if tells_lights(capture) else max(1, count // _CAMERAS)
    return _FRAMES.format(count=count, every=every).rstrip("\n")


def _middle(floor: "Array") -> tuple[float, float]:
    """The centroid of a floor, or where it is widest if the centroid is not well inside."""
    import shapely

    polygon = shapely.Polygon(floor)
    centroid = polygon.centroid
    if polygon.contains(centroid) and polygon.exterior.distance(centroid) > _CLEAR:
        return centroid.x, centroid.y
    widest = shapely.maximum_inscribed_circle(polygon, tolerance=0.01)
    x, y = shapely.get_coordinates(widest)[0]
    return float(x), float(y)


# Lights, materials and cameras that a capture knows itself, as sections of the description.


def tells_lights(capture: Capture) -> bool:
    """Whether a capture knows what shines, so that no lamp need be invented."""
    return capture.environment is not None


def light_lines(capture: Capture) -> Iterator[str]:
    """The section ``lights``: what shines in, and what each lamp emits."""
    assert capture.environment is not None
    yield f"environment: {_flow(capture.environment)}"
    found = _objects(capture)
    # What stands for a lamp may be none: a box has no bulb.
    lamps = [
        model
        for model in capture.models
        if model.radiance is not None and (model.file or _emits(found[model.id].category))
    ]
    if lamps:
        yield "# Nits of each primary."
        yield "lamps:"
    for model in lamps:
        yield f"  {found[model.id].name}: {_flow({'radiance': list(model.radiance or ())})}"


def material_lines(capture: Capture) -> Iterator[str]:
    """The section ``materials``: the shell, and parts whose file does not say what they are."""
    for part, look in capture.shell.items():
        yield f"{part}: {_flow(look)}"
    found = _objects(capture)
    dressed = [model for model in capture.models if model.looks]
    if dressed:
        yield "overrides:"
    for model in dressed:
        yield f"  {found[model.id].name}: {_flow(model.looks)}"


def _objects(capture: Capture) -> "dict[str, Captured]":
    """The objects of a capture as they will be placed, by their identifiers in it."""
    # What places objects needs USD, which takes a moment to import.
    from openrooms_usd.steps.alignment.aligned import with_boxes
    from openrooms_usd.steps.alignment.captured import captured_objects

    return {one.box.id: one for one in captured_objects(with_boxes(capture), 0.0, (), [])}


def _emits(name: str) -> bool:
    from openrooms_usd.furniture import category

    return category(name).emits


def _flow(value: Mapping[str, Any]) -> str:
    """JSON, which is YAML."""
    return json.dumps(value, ensure_ascii=False, allow_nan=False)
