"""Spoils stages: odd values, wrong types, targets that lead nowhere or back, absurd counts."""

import math
from collections.abc import Callable
from random import Random
from typing import Any

from pxr import Sdf, Tf, Usd, Vt

from tests.anystage.stages import random_stage

ODD_NUMBERS = (
    0.0,
    -0.0,
    -1.0,
    1.0,
    math.nan,
    math.inf,
    -math.inf,
    1e300,
    -1e300,
    1e-310,
    3e38,
    1e-45,
)
ODD_INTEGERS = (0, -1, 1, 2, 7, 1000, 2**31 - 1, -(2**31))
WORDS = ("", "none", "vertex", "nonsense", "constant", "uniform", "faceVarying", "leftHanded", "X")
TYPES = (
    "Mesh",
    "Cube",
    "Sphere",
    "BasisCurves",
    "NurbsCurves",
    "HermiteCurves",
    "NurbsPatch",
    "Points",
    "TetMesh",
    "PointInstancer",
    "Xform",
    "Scope",
    "Camera",
    "SphereLight",
    "DomeLight_1",
    "PortalLight",
    "GeometryLight",
    "PluginLight",
    "Material",
    "Shader",
    "GeomSubset",
    "SkelRoot",
    "Skeleton",
    "SkelAnimation",
    "Volume",
    "RenderSettings",
    "Plane",
    "Nonsense",
    "",
)
VALUES = (
    "float",
    "int",
    "string",
    "token",
    "asset",
    "point3f[]",
    "int[]",
    "float[]",
    "color3f",
    "texCoord2f[]",
    "matrix4d",
    "bool",
    "double",
    "quatf[]",
    "token[]",
    "half3[]",
    "opaque",
)
# Schemas that change what a prim is.
APPLIED = (
    "MeshLightAPI",
    "LightAPI",
    "MaterialBindingAPI",
    "SkelBindingAPI",
    "ShapingAPI",
    "CollectionAPI:lightLink",
    "ShadowAPI",
    "Nonsense",
)

Spoiler = Callable[[Usd.Stage, Random], None]


def broken_stage(seed: int) -> Usd.Stage:
    """A stage that was sound, with one to five things spoilt; the same for the same seed."""
    rng = Random(f"broken {seed}")
    stage = random_stage(seed)
    for _ in range(rng.randint(1, 5)):
        spoil(stage, rng)
    return stage


def spoil(stage: Usd.Stage, rng: Random) -> None:
    """Spoil one thing of a stage; what USD does not let happen does not."""
    try:
        rng.choice(_SPOILERS)(stage, rng)
    except (Tf.ErrorException, TypeError, ValueError, OverflowError, RuntimeError, IndexError):
        return


def _prim(stage: Usd.Stage, rng: Random) -> Sdf.PrimSpec:
    layer = stage.GetRootLayer()
    paths: list[Sdf.Path] = []
    layer.Traverse(Sdf.Path.absoluteRootPath, paths.append)
    return layer.GetPrimAtPath(rng.choice([one for one in paths if one.IsPrimPath()]))


def _attribute(stage: Usd.Stage, rng: Random) -> Sdf.AttributeSpec:
    layer = stage.GetRootLayer()
    paths: list[Sdf.Path] = []
    layer.Traverse(Sdf.Path.absoluteRootPath, paths.append)
    found = [layer.GetAttributeAtPath(one) for one in paths if one.IsPropertyPath()]
    return rng.choice([one for one in found if one])


def odd(value: Any, rng: Random) -> Any:
    """A value of the same type that nobody expects."""
    match value:
        case bool():
            return not value
        case int():
            return rng.choice(ODD_INTEGERS)
        case float():
            return rng.choice(ODD_NUMBERS)
        case str():
            return rng.choice(WORDS)
        case Sdf.AssetPath():
            return Sdf.AssetPath(rng.choice(("", "none.png", "<UDIM>.png", "/dev/zero", "a\n.png")))
    if hasattr(value, "__setitem__") and hasattr(value, "__len__") and len(value):
        return _odd_array(value, rng)
    return value


def _odd_array(value: Any, rng: Random) -> Any:
    found = type(value)(value)
    is_array = type(value).__module__ == Vt.__name__
    roll = rng.random()
    if is_array and roll < 0.25:
        return type(value)(list(value)[: rng.randrange(len(value))])
    if is_array and roll < 0.4:
        return type(value)(list(value) * rng.randint(2, 3))
    at = rng.randrange(len(value))
    found[at] = odd(found[at], rng)
    return found


def _value(stage: Usd.Stage, rng: Random) -> None:
    spec = _attribute(stage, rng)
    spec.default = odd(spec.default, rng)


def _schema_value(stage: Usd.Stage, rng: Random) -> None:
    """An attribute that a schema has and nobody wrote."""
    prim = stage.GetPrimAtPath(_prim(stage, rng).path)
    attribute = rng.choice(prim.GetAttributes())
    value = attribute.Get()
    if value is None or (hasattr(value, "__len__") and not len(value)):
        value = attribute.GetTypeName().defaultValue
        value = type(value)([0, 1, 2, 3]) if attribute.GetTypeName().isArray else value
    attribute.Set(odd(value, rng))


def _another_type(stage: Usd.Stage, rng: Random) -> None:
    """The attribute is declared as something else, with a value of that type."""
    old = _attribute(stage, rng)
    owner, name = old.owner, old.name
    kind = Sdf.ValueTypeNames.Find(rng.choice(VALUES))
    owner.RemoveProperty(old)
    made = Sdf.AttributeSpec(owner, name, kind)
    if kind.defaultValue is not None:
        value = kind.defaultValue
        made.default = type(value)(rng.randint(0, 5)) if kind.isArray else odd(value, rng)


def _samples(stage: Usd.Stage, rng: Random) -> None:
    spec = _attribute(stage, rng)
    for time in rng.choice(((0.0,), (0.0, 1.0), (-5.0, 1e9), (math.inf, 0.0))):
        stage.GetRootLayer().SetTimeSample(spec.path, time, odd(spec.default, rng))
    if rng.random() < 0.5:
        spec.ClearDefaultValue()


def _targets(stage: Usd.Stage, rng: Random) -> None:
    """Relationships to nothing, to the prim itself, what is above it, or anything."""
    prim = stage.GetPrimAtPath(_prim(stage, rng).path)
    found = prim.GetRelationships() or [prim.CreateRelationship("prototypes")]
    own = prim.GetPath()
    to = (
        own,
        own.GetParentPath(),
        Sdf.Path("/nowhere"),
        _prim(stage, rng).path,
        own.AppendProperty("material:binding"),
        Sdf.Path("/"),
        found[0].GetPath(),
    )
    rng.choice(found).SetTargets(rng.sample(to, rng.randint(0, 3)))


def _connections(stage: Usd.Stage, rng: Random) -> None:
    """Networks in circles, or to nothing."""
    one, other = _attribute(stage, rng), _attribute(stage, rng)
    to = rng.choice((one.path, other.path, Sdf.Path("/no.where"), one.path.GetPrimPath()))
    stage.GetAttributeAtPath(one.path).SetConnections([to])
    stage.GetAttributeAtPath(other.path).SetConnections([one.path])


def _kind(stage: Usd.Stage, rng: Random) -> None:
    _prim(stage, rng).typeName = rng.choice(TYPES)


def _schemas(stage: Usd.Stage, rng: Random) -> None:
    stage.GetPrimAtPath(_prim(stage, rng).path).AddAppliedSchema(rng.choice(APPLIED))


def _arcs(stage: Usd.Stage, rng: Random) -> None:
    """References and inherits to missing files, to nothing, in circles."""
    spec, other = _prim(stage, rng), _prim(stage, rng)
    to = rng.choice((spec.path, other.path, Sdf.Path("/nowhere"), spec.path.GetParentPath()))
    match rng.randint(0, 3):
        case 0:
            spec.referenceList.Prepend(Sdf.Reference(rng.choice(("", "missing.usda")), to))
        case 1:
            spec.inheritPathList.Prepend(to)
        case 2:
            spec.payloadList.Prepend(Sdf.Payload("", to))
        case _:
            spec.specializesList.Prepend(to)
    if rng.random() < 0.5:
        spec.instanceable = True


def _metadata(stage: Usd.Stage, rng: Random) -> None:
    root = stage.GetRootLayer().pseudoRoot
    match rng.randint(0, 2):
        case 0:
            root.SetInfo("metersPerUnit", rng.choice(ODD_NUMBERS))
        case 1:
            root.SetInfo("upAxis", rng.choice(("X", "", "y", "nonsense")))
        case _:
            root.SetInfo("defaultPrim", "nothing")


def _operations(stage: Usd.Stage, rng: Random) -> None:
    prim = stage.GetPrimAtPath(_prim(stage, rng).path)
    order = prim.CreateAttribute("xformOpOrder", Sdf.ValueTypeNames.TokenArray)
    names = [
        *(order.Get() or []),
        "xformOp:nonsense",
        "!resetXformStack!",
        "xformOp:translate",
        "!invert!xformOp:scale",
        "",
        "xformOp:transform",
    ]
    order.Set(rng.choices(names, k=rng.randint(0, 4)))


def _words(stage: Usd.Stage, rng: Random) -> None:
    """Metadata of primvars."""
    spec = _attribute(stage, rng)
    spec.SetInfo("interpolation", rng.choice(WORDS))
    spec.SetInfo("elementSize", rng.choice((0, -1, 2, 10**6)))


_SPOILERS: tuple[Spoiler, ...] = (
    _value,
    _value,
    _value,
    _schema_value,
    _schema_value,
    _another_type,
    _another_type,
    _samples,
    _targets,
    _targets,
    _connections,
    _kind,
    _schemas,
    _arcs,
    _metadata,
    _operations,
    _words,
)
