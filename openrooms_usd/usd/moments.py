"""A stage at one moment: what varies over time is held there, for every reader of the stage.

Values are written as defaults into layers below the session layer, which are stronger than all of
the stage's own, so that its files stay as they are and readers need not know the time.
"""

import math
from collections.abc import Iterator
from typing import Any, Final

import numpy as np
from pxr import Gf, Sdf, Tf, Usd, UsdGeom, UsdSkel, Vt

from openrooms_usd.errors import InputError
from openrooms_usd.usd.arrays import array_of, number_of
from openrooms_usd.usd.places.frames import TIME
from openrooms_usd.usd.rendersettings import is_set
from openrooms_usd.usd.shapes.traversal import has_whole_rows

# Prototypes of point instancers may be mere overs or classes.
_PRIMS: Final = Usd.PrimIsActive & Usd.PrimIsLoaded

_CLIPS: Final = "clips"

# What moves between its samples by what it has beside them.
_DRIVERS: Final = {
    "points": ("velocities",),
    "positions": ("velocities",),
    "orientations": ("angularVelocities",),
    "orientationsf": ("angularVelocities",),
}


def freeze_time(stage: Usd.Stage, time_code: float | None = None) -> dict[str, str]:
    """Hold what moves at one time, and put skinned meshes into their pose at that time.

    Between samples values are USD's own: linear or held as the stage says, by velocities where
    points and instances have them, through value clips. Instances with something inside that moves
    become prims of their own. A stage without time samples and skeletons stays as it is.

    Args:
        stage: An opened stage; its files stay as they are.
        time_code: When, in the stage's time codes; None for the first sample of everything.

    Returns:
        What is lost, by prim path: motion blur, and skinning that does not fit its skeleton.

    Raises:
        InputError: The time is not a finite number.
    """
    if time_code is not None and not math.isfinite(time_code):
        raise InputError(f"{time_code} is not a time code", remedy="give a number, such as 12")
    blurred = _blurred(stage, time_code)
    if time_code is None and not any(prim.IsA(UsdSkel.Root) for prim in _everything(stage)):
        return blurred
    when = TIME if time_code is None else Usd.TimeCode(time_code)
    posed, held = (Sdf.Layer.CreateAnonymous(f"{name}.usda") for name in ("posed", "held"))
    session = stage.GetSessionLayer()
    # The first is the strongest: poses are made of what is held.
    for layer in (held, posed):
        session.subLayerPaths.insert(0, layer.identifier)
    _expand(stage, held, anything=time_code is not None)
    # By default everything else can still be read at its times, such as the paths of cameras.
    concerned = [p for p in _prims(stage) if time_code is not None or _poses(p)]
    values = [one for prim in concerned for one in _animated_values(prim, when)]
    with Sdf.ChangeBlock():
        for attribute, value in values:
            _write(held, attribute, value)
    return {**blurred, **skin(stage, posed)}


def _prims(stage: Usd.Stage) -> Iterator[Usd.Prim]:
    return iter(Usd.PrimRange.Stage(stage, _PRIMS))


def _everything(stage: Usd.Stage) -> Iterator[Usd.Prim]:
    """All prims of a stage, of prototypes once."""
    yield from _prims(stage)
    for prototype in stage.GetPrototypes():
        yield from Usd.PrimRange(prototype, _PRIMS)


def _poses(prim: Usd.Prim) -> bool:
    """Whether a prim takes part in skinning."""
    return any(one.IsA(UsdSkel.Root) for one in (prim, *_above(prim))) or any(
        prim.IsA(kind) for kind in (UsdSkel.Skeleton, UsdSkel.Animation, UsdSkel.BlendShape)
    )


# Instances.


def _expand(stage: Usd.Stage, layer: Sdf.Layer, *, anything: bool) -> None:
    """Make instances prims of their own where inside something is skinned, or moves at all."""
    proxies, known = Usd.TraverseInstanceProxies(_PRIMS), set[Sdf.Path]()
    while True:
        moving = {
            prototype.GetPath()
            for prototype in stage.GetPrototypes()
            if any(
                has_skin(prim) or (anything and any(_moving(prim)))
                for prim in Usd.PrimRange(prototype, proxies)
            )
        }
        found = {
            prim.GetPath()
            for prim in _prims(stage)
            if prim.IsInstance() and prim.GetPrototype().GetPath() in moving
        } - known
        if not found:
            return
        known |= found
        with Sdf.ChangeBlock():
            for path in sorted(found):
                Sdf.CreatePrimInLayer(layer, path).instanceable = False


# Values.


def _moving(prim: Usd.Prim) -> Iterator[Usd.Attribute]:
    """The attributes of a prim that may have another value at another time."""
    # Clips may have values of what no layer has.
    clipped = any(
        above.HasAuthoredMetadata(_CLIPS) for above in (prim, *_above(prim)) if above.IsValid()
    )
    found = prim.GetAttributes() if clipped else prim.GetAuthoredAttributes()
    for attribute in found:
        if attribute.ValueMightBeTimeVarying() or _is_driven(attribute):
            yield attribute


def _above(prim: Usd.Prim) -> Iterator[Usd.Prim]:
    while (prim := prim.GetParent()).IsValid() and not prim.IsPseudoRoot():
        yield prim


def _is_driven(attribute: Usd.Attribute) -> bool:
    """Whether velocities move it away from its samples, even from a single one."""
    names = _DRIVERS.get(attribute.GetName(), ())
    if not names or not attribute.GetNumTimeSamples():
        return False
    return any(attribute.GetPrim().GetAttribute(name).HasValue() for name in names)


def _animated_values(prim: Usd.Prim, when: Usd.TimeCode) -> Iterator[tuple[Usd.Attribute, Any]]:
    """(attribute, value) of what moves of a prim."""
    moving = list(_moving(prim))
    driven = {attribute.GetName() for attribute in moving if _is_driven(attribute)}
    for attribute in moving:
        yield attribute, _portable(attribute, attribute.Get(when), when)
    if not driven or when.IsEarliestTime():
        return
    # Later rows take the place of those above.
    if prim.IsA(UsdGeom.PointInstancer):
        yield from _instances(UsdGeom.PointInstancer(prim), driven, when)
    elif prim.IsA(UsdGeom.PointBased):
        shape = UsdGeom.PointBased(prim)
        points = shape.ComputePointsAtTime(when, when)
        yield shape.GetPointsAttr(), points


def _instances(
    instancer: UsdGeom.PointInstancer, driven: set[str], when: Usd.TimeCode
) -> Iterator[tuple[Usd.Attribute, Any]]:
    """Where instances are by their velocities."""
    count = len(array_of(instancer.GetProtoIndicesAttr().Get(when), np.int64))
    if not has_whole_rows(instancer, count, when):
        return  # the reader of the instancer reports what is wrong
    try:
        placed = instancer.ComputeInstanceTransformsAtTime(
            when, when, UsdGeom.PointInstancer.ExcludeProtoXform, UsdGeom.PointInstancer.IgnoreMask
        )
    except Tf.ErrorException:
        return
    matrices = np.asarray(placed or [], dtype=np.float64).reshape(-1, 4, 4)
    if "positions" in driven:
        positions = matrices[:, 3, :3].astype(np.float32)
        yield instancer.GetPositionsAttr(), Vt.Vec3fArray.FromNumpy(positions)
    if driven & {"orientations", "orientationsf"}:
        # Rows are a rotation's times the instance's own scale.
        scales = np.asarray(instancer.GetScalesAttr().Get(when) or [], dtype=np.float64)
        turns = matrices[:, :3, :3].copy()
        if scales.shape == (len(turns), 3) and (scales != 0.0).all():
            turns /= scales[:, :, None]
        quaternions = [Gf.Matrix3d(turn).ExtractRotation().GetQuat() for turn in turns]
        # It counts before the other, which has half the digits.
        yield instancer.GetOrientationsfAttr(), Vt.QuatfArray([*map(Gf.Quatf, quaternions)])


def _portable(attribute: Usd.Attribute, value: Any, when: Usd.TimeCode) -> Any:
    """The value for a layer that lies in no folder: files by their whole path."""
    if isinstance(value, Sdf.AssetPath):
        return Sdf.AssetPath(_whole(attribute, value, when))
    if isinstance(value, Sdf.AssetPathArray):
        return Sdf.AssetPathArray([Sdf.AssetPath(_whole(attribute, a, when)) for a in value])
    return value


def _whole(attribute: Usd.Attribute, asset: Sdf.AssetPath, when: Usd.TimeCode) -> str:
    stack = attribute.GetPropertyStack(when)
    if asset.resolvedPath or not asset.path or not stack:
        return str(asset.resolvedPath or asset.path)
    return str(Sdf.ComputeAssetPathRelativeToLayer(stack[0].layer, asset.path))


def _write(layer: Sdf.Layer, attribute: Usd.Attribute, value: Any) -> None:
    owner = Sdf.CreatePrimInLayer(layer, attribute.GetPrimPath())
    spec = layer.GetAttributeAtPath(attribute.GetPath()) or Sdf.AttributeSpec(
        owner, attribute.GetName(), attribute.GetTypeName(), attribute.GetVariability()
    )
    spec.default = Sdf.ValueBlock() if value is None else value


# Motion blur.


def _blurred(stage: Usd.Stage, time_code: float | None) -> dict[str, str]:
    """Cameras whose shutter is open while something moves, with what is lost."""
    opened = {
        str(prim.GetPath()): span
        for prim in _everything(stage)
        if prim.IsA(UsdGeom.Camera)
        and (span := _shutter(UsdGeom.Camera(prim), time_code))
        and not is_set(stage, str(prim.GetPath()), "disableMotionBlur", "instantaneousShutter")
    }
    if not opened:
        return {}
    moving = [attribute for prim in _everything(stage) for attribute in _moving(prim)]
    times = [at for one in moving for at in one.GetTimeSamplesInInterval(_ANY_TIME)[:1]]
    frame = time_code if time_code is not None else min(times, default=0.0)
    lost = {}
    for path, (opens, closes) in opened.items():
        many = sum(_changes(one, frame + opens, frame + closes) for one in moving)
        if many:
            lost[path] = (
                f"motion blur is left out: its shutter is open from {opens:g} to {closes:g} "
                f"around the frame, while {many} values change"
            )
    return lost


_ANY_TIME: Final = Gf.Interval.GetFullInterval()


def _shutter(camera: UsdGeom.Camera, time_code: float | None) -> tuple[float, float] | None:
    """When a camera's shutter opens and closes, time codes from the frame; None for an instant."""
    when = TIME if time_code is None else Usd.TimeCode(time_code)
    opens, closes = (
        number_of(attribute.Get(when)) or 0.0
        for attribute in (camera.GetShutterOpenAttr(), camera.GetShutterCloseAttr())
    )
    return (opens, closes) if opens < closes else None


def _changes(attribute: Usd.Attribute, begin: float, end: float) -> bool:
    return bool(attribute.Get(begin) != attribute.Get(end))


# What makes a prim follow joints or blend shapes.
_INFLUENCES: Final = ("primvars:skel:jointIndices", "skel:blendShapes")
# What is written of a mesh, or of what is skinned as a whole.
_MOVED: Final = ("points", "xformOpOrder")


def has_skin(prim: Usd.Prim) -> bool:
    """Whether a prim moves with a skeleton, or holds what does."""
    return prim.IsA(UsdSkel.Root) or is_skinned(prim)


def is_skinned(prim: Usd.Prim) -> bool:
    """Whether a prim has influences of joints or blend shapes."""
    return any(prim.GetAttribute(name).HasAuthoredValue() for name in _INFLUENCES)


def skin(stage: Usd.Stage, layer: Sdf.Layer) -> dict[str, str]:
    """Write the posed points of all skinned meshes of a stage that holds still.

    USD's own: linear blend or dual quaternion skinning as each mesh says, blend shapes with
    in-betweens first. Meshes outside a ``SkelRoot`` are not skinned, which is USD's rule.

    Args:
        stage: A stage without instances that have something skinned inside.
        layer: One of its layers that receives the points; roots become ``Xform`` there.

    Returns:
        By prim path, why it stays in its rest pose.
    """
    lost: dict[str, str] = {}
    for root in [prim for prim in stage.TraverseAll() if prim.IsA(UsdSkel.Root)]:
        skinned = [prim for prim in Usd.PrimRange(root) if is_skinned(prim)]
        reason = "its joints or weights do not fit its skeleton"
        try:
            with Usd.EditContext(stage, layer):
                UsdSkel.BakeSkinning(UsdSkel.Root(root), Gf.Interval.GetFullInterval())
        except Tf.ErrorException as error:
            reason = str(error.args[0].commentary)
        for prim in skinned:
            if not _is_posed(prim, layer):
                lost[str(prim.GetPath())] = (
                    f"skinning is left out, drawn in its rest pose: {reason}"
                )
    return lost


def _is_posed(prim: Usd.Prim, layer: Sdf.Layer) -> bool:
    """Whether a layer moves a prim or its points."""
    specs = (layer.GetAttributeAtPath(prim.GetPath().AppendProperty(name)) for name in _MOVED)
    return any(spec is not None and spec.HasDefaultValue() for spec in specs)
