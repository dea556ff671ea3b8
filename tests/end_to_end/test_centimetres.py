"""A room in centimetres with Y up gives the pixels of the room in metres with Z up."""

from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

from openrooms_usd.channels import CHANNELS, DEFAULT

# Row vectors: (x, y, z) in metres with Z up stands at (x, z, -y) in metres with Y up.
Y_UP = Gf.Matrix4d(1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1)
CENTIMETRES = Y_UP * Gf.Matrix4d().SetScale(100.0)


def declare(layer: Sdf.Layer) -> Usd.Stage:
    stage = Usd.Stage.Open(layer)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    return stage


def under_a_transform(scene: Path, target: Path) -> None:
    """The scene as it is, below a root that is turned and scaled."""
    stage = declare(Sdf.Layer.CreateNew(str(target)))
    world = UsdGeom.Xform.Define(stage, "/World")
    world.GetPrim().GetReferences().AddReference(str(scene), "/World")
    world.MakeMatrixXform().Set(CENTIMETRES)
    stage.SetDefaultPrim(world.GetPrim())
    stage.Save()


LENGTHS = set(
    (
        "focalLength horizontalAperture verticalAperture horizontalApertureOffset "
        "verticalApertureOffset focusDistance inputs:width inputs:height inputs:radius"
    ).split()
)


def rewritten(scene: Path, target: Path) -> None:
    """The flattened scene with every point, length, normal and transform in its new frame."""
    flat = Usd.Stage.Open(str(scene)).Flatten(addSourceFileComment=False)
    flat.Export(str(target))
    stage = declare(Sdf.Layer.FindOrOpen(str(target)))
    for prim in Usd.PrimRange.AllPrims(stage.GetPseudoRoot()):
        for attribute in prim.GetAuthoredAttributes():
            name, value = attribute.GetName(), attribute.Get()
            if name == "points":
                attribute.Set(transformed(value, CENTIMETRES))
            elif name == "normals":
                attribute.Set(transformed(value, Y_UP))
            elif name in ("extent", "extentsHint"):
                box = np.array(transformed(value, CENTIMETRES)).reshape(-1, 2, 3)
                ends = np.stack([box.min(axis=1), box.max(axis=1)], axis=1)
                attribute.Set(Vt.Vec3fArray.FromNumpy(ends.reshape(-1, 3)))
            elif name in LENGTHS:
                attribute.Set(100.0 * value)
            elif name == "clippingRange":
                attribute.Set(value * 100.0)
        place = UsdGeom.Xformable(prim)
        if place and place.GetOrderedXformOps():
            # Cameras and lights keep their own axes, and their lengths are counted in LENGTHS.
            own = prim.GetTypeName() in ("Camera", "DomeLight", "PortalLight")
            before = Gf.Matrix4d().SetScale(0.01) if own else CENTIMETRES.GetInverse()
            matrix = before * place.GetLocalTransformation() * CENTIMETRES
            place.ClearXformOpOrder()
            place.MakeMatrixXform().Set(matrix)
    stage.Save()


def transformed(vectors: Vt.Vec3fArray, matrix: Gf.Matrix4d) -> Vt.Vec3fArray:
    rows = np.array(vectors, dtype=np.float64) @ np.array(matrix)[:3, :3]
    return Vt.Vec3fArray.FromNumpy(rows.astype(np.float32))


@pytest.mark.slow
@pytest.mark.one_in(2, rest="long")
@pytest.mark.parametrize("convert", [under_a_transform, rewritten])
def test_the_same_room_in_another_frame(convert, demo: Path, tmp_path: Path, show, fastest) -> None:
    compare(convert, demo, tmp_path, show, fastest)


@pytest.mark.slow
@pytest.mark.one_in(2, rest="long")
def test_every_room_in_another_frame(room: Path, tmp_path: Path, show, fastest) -> None:
    stage = Usd.Stage.Open(str(room))
    first = str(stage.GetPrimAtPath("/World/Cameras").GetChildren()[0].GetPath())
    compare(under_a_transform, room, tmp_path, show, fastest, [first])


def compare(convert, scene: Path, tmp_path: Path, show, fastest, cameras=()) -> None:
    other = tmp_path / "centimetres.usda"
    convert(scene, other)
    stage = Usd.Stage.Open(str(other))
    assert stage.GetPrototypes()
    bounds = UsdGeom.BBoxCache(0, ["default"])
    tops = [
        bounds.ComputeWorldBound(opened.GetPrimAtPath("/World/Room/Ceiling")).ComputeAlignedRange()
        for opened in (Usd.Stage.Open(str(scene)), stage)
    ]
    assert tops[1].GetMin()[1] == pytest.approx(100.0 * tops[0].GetMin()[2])
    how = {
        "options": {"variant": fastest},
        "resolution": (48, 36),
        "samples": 8,
        "cameras": cameras,
    }
    a, b = show(scene, "metres", **how), show(other, "centimetres", **how)
    assert a.views == b.views
    for view in a.views:
        ours, theirs = a[view], b[view]
        same = (ours["valid"] == theirs["valid"])[..., 0]
        for name in ("part", "instance", "material", "semantic"):
            same &= a.names(view, name) == b.names(view, name)
        assert same.mean() > 0.998, "all but rays that pass an edge"
        for name in DEFAULT:
            channel = CHANNELS[name]
            difference = np.abs(ours[name] - theirs[name])[same]
            if channel.unit == "m":
                # Points are rounded anew; a ray that grazes a surface magnifies that.
                assert np.quantile(difference, 0.999) < 3e-6, name
                assert difference.max() < 1e-4, name
            elif channel.kind in ("geometry", "material"):
                # Where a picture or a normal changes at once, rounding may choose the other side.
                assert np.quantile(difference, 0.998) < 1e-3, name
        bright = [image["radiance"] for image in (ours, theirs)]
        near = np.isclose(*bright, rtol=1e-2, atol=1e-3).all(axis=2)
        # Equal seeds follow equal paths where points are the same. Where they are rounded anew, one
        # of a long path's many directions goes to the other side of an edge.
        if convert is under_a_transform:
            assert near[same].mean() > 0.99
        assert bright[0].mean() == pytest.approx(bright[1].mean(), rel=0.05)
    if convert is under_a_transform:
        return
    # Short paths have no time to part, however points are rounded.
    short = how | {"bounces": 1, "channels": ["radiance"]}
    a, b = show(scene, "metres, short", **short), show(other, "centimetres, short", **short)
    for view in a.views:
        ours, theirs = a[view]["radiance"], b[view]["radiance"]
        assert np.isclose(ours, theirs, rtol=1e-2, atol=1e-3).all(axis=2).mean() > 0.99
        assert ours.mean() == pytest.approx(theirs.mean(), rel=1e-3)
