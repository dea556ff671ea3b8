"""What pages tell of a stage's prims, as plain data."""

from collections import Counter
from pathlib import Path
from typing import Any, Final

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdShade

from openrooms_usd import names
from openrooms_usd.errors import InputError, StageError
from openrooms_usd.furniture import CATEGORIES
from openrooms_usd.usd.cameras import PINHOLE, list_cameras, photograph, read_camera
from openrooms_usd.usd.places.frames import TIME, local_to_world, world_from_stage
from openrooms_usd.usd.semantics import read_label
from openrooms_usd.usd.shading import physics
from openrooms_usd.usd.shading.materials import bound_material

# What has no place in a room.
_NOWHERE: Final = (UsdShade.Material, UsdShade.NodeGraph, UsdShade.Shader, UsdPhysics.Scene)
# Of opinions that are shown as text.
_MOST_VALUES: Final = 16
_MOST_LETTERS: Final = 120
# Cosine of the angle between two axes above which they are one.
_SAME_AXIS_COS: Final = 0.9999
# Width of the picture of a camera's numbers, which are all fractions of it.
_WIDTH_PX: Final = 1000


def prims_of(stage: Usd.Stage) -> list[dict[str, Any]]:
    """What is known of each prim that stands in the room, parents before children.

    ``layers`` counts the properties that each layer has an opinion on.
    """
    home = Path(stage.GetRootLayer().realPath).parent
    walk = iter(stage.Traverse(Usd.TraverseInstanceProxies()))
    found = []
    for prim in walk:
        if any(prim.IsA(kind) for kind in _NOWHERE) or _is_guide(prim):
            walk.PruneChildren()
        else:
            found.append(_prim_record(prim, home))
    return found


def shell_of(prims: list[dict[str, Any]]) -> list[str]:
    """The paths of walls, the ceiling and what is in them."""
    return [prim["path"] for prim in prims if prim.get("category") in names.SHELL]


def hung_of(prims: list[dict[str, Any]]) -> list[str]:
    """The paths of furniture that hangs on walls."""
    hung = {name for name, record in CATEGORIES.items() if record.support == "wall"}
    return [
        prim["path"]
        for prim in prims
        if prim.get("category") in hung and prim["path"].startswith(f"{names.FURNITURE}/")
    ]


def _is_guide(prim: Usd.Prim) -> bool:
    purpose = UsdGeom.Imageable(prim).GetPurposeAttr()
    return bool(purpose) and purpose.Get() in (UsdGeom.Tokens.guide, UsdGeom.Tokens.proxy)


def _prim_record(prim: Usd.Prim, home: Path) -> dict[str, Any]:
    material = bound_material(prim) if prim.IsA(UsdGeom.Gprim) else None
    known = physics.read(material.GetPrim()) if material else None
    said = {
        "path": str(prim.GetPath()),
        "type": str(prim.GetTypeName()),
        "kind": str(Usd.ModelAPI(prim).GetKind()),
        "category": _own_label(prim, names.CATEGORY),
        "part": _own_label(prim, names.PART),
        "material": str(material.GetPath()) if material else None,
        "friction": known.dynamic_friction if known else None,
        "mass": _mass(prim),
        "source": _source(prim),
        "layers": _layers(prim, home),
    }
    return {name: value for name, value in said.items() if value}


def _own_label(prim: Usd.Prim, taxonomy: str) -> str | None:
    has = f"SemanticsLabelsAPI:{taxonomy}" in prim.GetAppliedSchemas()
    return read_label(prim, taxonomy) if has else None


def _mass(prim: Usd.Prim) -> float | None:
    """Kilograms; None if unknown."""
    if not prim.HasAPI(UsdPhysics.MassAPI):
        return None
    mass = UsdPhysics.MassAPI(prim).GetMassAttr().Get()
    return float(mass) if mass and np.isfinite(mass) and mass > 0 else None


def _source(prim: Usd.Prim) -> str | None:
    """Its capture: a file, and its name there."""
    said = [prim.GetAttribute(name) for name in (names.SOURCE_FILE, names.SOURCE_ID)]
    return " ".join(str(one.Get()) for one in said if one and one.HasAuthoredValue()) or None


def _layers(prim: Usd.Prim, home: Path) -> dict[str, int]:
    counts: Counter[str] = Counter()
    for spec in prim.GetPrimStack():
        counts[_layer_name(spec.layer, home)] += len(spec.properties)
    return dict(counts)


def opinions_of(stage: Usd.Stage, path: str) -> list[dict[str, Any]]:
    """What each layer says of a prim, the strongest first: the layer, and its properties.

    ``properties`` are pairs of a name and its value in words; long arrays by their length.

    Raises:
        InputError: There is no such prim.
    """
    prim = stage.GetPrimAtPath(path) if Sdf.Path.IsValidPathString(path) else None
    if not prim:
        raise InputError("the stage has no such prim", place=path, remedy="choose one of the tree")
    home = Path(stage.GetRootLayer().realPath).parent
    return [
        {
            "layer": _layer_name(spec.layer, home),
            "properties": [[found.name, _in_words(found)] for found in spec.properties],
        }
        for spec in prim.GetPrimStack()
    ]


def _in_words(spec: Sdf.PropertySpec) -> str:
    if isinstance(spec, Sdf.RelationshipSpec):
        return " ".join(str(path) for path in spec.targetPathList.GetAddedOrExplicitItems())
    value = spec.default
    if hasattr(value, "__len__") and not isinstance(value, str) and len(value) > _MOST_VALUES:
        return f"{len(value)} values"
    text = str(value)
    return text if len(text) <= _MOST_LETTERS else f"{text[:_MOST_LETTERS]} ..."


def _layer_name(layer: Sdf.Layer, home: Path) -> str:
    """A layer by its path from the stage's folder, or its name where it lies elsewhere."""
    if not layer.realPath:
        return "in memory"
    path = Path(layer.realPath)
    return path.relative_to(home).as_posix() if path.is_relative_to(home) else path.name


def joints_of(stage: Usd.Stage) -> list[dict[str, Any]]:
    """Doors and drawers: parts that turn about or slide along an axis, and how far they are open.

    ``world_from_prim`` is (4, 4), metres and Z up; ``axis`` is in the prim's frame; limits are
    degrees or metres from how it is built.
    """
    cache, turn = UsdGeom.XformCache(TIME), world_from_stage(stage)
    found = []
    for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
        kind = prim.GetAttribute(names.JOINT_TYPE)
        if not kind or kind.Get() not in ("hinge", "rail"):
            continue
        numbers = (names.JOINT_AXIS, names.JOINT_LOWER, names.JOINT_UPPER)
        axis, lower, upper = (prim.GetAttribute(name).Get() for name in numbers)
        if axis is None or lower is None or upper is None:
            continue
        world = turn @ local_to_world(prim, cache)
        found.append(
            {
                "path": str(prim.GetPath()),
                "type": str(kind.Get()),
                "axis": [float(value) for value in axis],
                "lower": float(lower),
                "upper": float(upper),
                "now": _opened(prim, axis) if kind.Get() == "hinge" else 0.0,
                "world_from_prim": world.tolist(),
            }
        )
    return found


def _opened(prim: Usd.Prim, axis: Gf.Vec3f) -> float:
    """By how many degrees it is turned about its axis; 0 where it is turned about another one."""
    turn = UsdGeom.Xformable(prim).GetLocalTransformation(TIME).ExtractRotation()
    along = Gf.Dot(Gf.Vec3d(turn.GetAxis()), Gf.Vec3d(axis).GetNormalized())
    return float(turn.GetAngle() * along) if abs(along) > _SAME_AXIS_COS else 0.0


def cameras_of(stage: Usd.Stage) -> list[dict[str, Any]]:
    """The perspective cameras: poses (OpenCV, metres, Z up), and lenses in parts of the width."""
    found = []
    for prim in list_cameras(stage):
        usual = UsdGeom.Camera(prim)
        across, high = (
            usual.GetHorizontalApertureAttr().Get(TIME),
            usual.GetVerticalApertureAttr().Get(TIME),
        )
        aspect = across / high if across and high and across > 0 and high > 0 else 4.0 / 3.0
        height = max(round(_WIDTH_PX / aspect), 1)
        try:
            camera = read_camera(prim, _WIDTH_PX, height)
        except StageError:
            continue
        if camera.projection != PINHOLE:
            continue
        K = camera.K / _WIDTH_PX
        taken = photograph(prim)
        found.append(
            {
                "path": str(prim.GetPath()),
                "name": prim.GetName(),
                "aspect": aspect,
                "world_from_camera": camera.world_from_camera.tolist(),
                "focal": float(K[0, 0]),
                "right": float(K[0, 2]) - 0.5,
                "down": float(K[1, 2]) - 0.5 * height / _WIDTH_PX,
                "exposure": camera.exposure,
                "photograph": taken["id"] if taken else None,
            }
        )
    return found


def looks_of(stage: Usd.Stage) -> list[dict[str, Any]]:
    """Objects of which there are several looks: the variants, and which one is shown."""
    found = []
    for prim in stage.Traverse():
        if names.LOOK not in prim.GetVariantSets().GetNames():
            continue
        variants = prim.GetVariantSet(names.LOOK)
        found.append(
            {
                "path": str(prim.GetPath()),
                "looks": list(variants.GetVariantNames()),
                "chosen": variants.GetVariantSelection(),
            }
        )
    return found
