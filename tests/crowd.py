"""A stage of instances: of one prototype, by both ways of USD."""

import numpy as np
from pxr import Gf, UsdGeom, UsdShade, Vt

from openrooms_usd.usd.shading.surfaces import Texture
from tests import small


def crowd(picture: str) -> small.Stage:
    """Boxes of one prototype, with a painted lid and a tetrahedron on it, by both ways of USD.

    Some are mirrored, stretched and sheared; the prototype lies far from its own origin.
    """
    made = small.Stage()
    paper = made.material("/M/paper", base_color=Texture(picture, color_space="sRGB"))
    red = made.material("/M/red", base_color=(0.7, 0.1, 0.1))
    made.quad("/floor", [(-3, -3, 0), (3, -3, 0), (3, 3, 0), (-3, 3, 0)])
    stage = made.stage
    stage.CreateClassPrim("/Protos")
    UsdGeom.Xform.Define(stage, "/Protos/a").AddTranslateOp().Set(Gf.Vec3d(-2000, 0, 0.3))
    st = [(0, 0), (1, 0), (1, 1), (0, 1)] * 6
    points = [(2000 + x, y, z) for z in (-0.3, 0.3) for y in (-0.3, 0.3) for x in (-0.3, 0.3)]
    faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    box = made.mesh("/Protos/a/box", points, faces, st=st, material=paper)
    lid = UsdGeom.Subset.CreateGeomSubset(box, "lid", "face", Vt.IntArray([1]), "materialBind")
    made.bind(lid.GetPrim(), red)
    UsdShade.MaterialBindingAPI.Apply(lid.GetPrim())
    tip = made.mesh(
        "/Protos/a/tip",
        [(1999.8, 0, 0.3), (2000.2, 0, 0.3), (2000, 0.2, 0.3), (2000, 0.1, 0.8)],
        [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
    )
    tip.CreateNormalsAttr([(-1, -1, 0), (1, -1, 0), (0, 1, 0), (0, 0, 1)])
    tip.SetNormalsInterpolation("vertex")
    UsdGeom.Xform.Define(stage, "/World")
    for number in range(5):
        prim = stage.DefinePrim(f"/World/i{number}", "Xform")
        prim.SetInstanceable(True)
        prim.GetReferences().AddInternalReference("/Protos/a")
        matrix = np.eye(4)
        matrix[0, 0] = (-1) ** number * (0.8 + 0.1 * number)
        matrix[2, 0] = 0.2 * number
        matrix[3, :3] = 1.2 * (number - 2), 0.8, 0.3
        xform = UsdGeom.Xformable(prim)
        # The translation of the reference itself comes first, for points.
        before = xform.GetOrderedXformOps()
        place = xform.AddTransformOp(opSuffix="place")
        place.Set(Gf.Matrix4d(matrix.tolist()))
        xform.SetXformOpOrder([place, *before])
    points = UsdGeom.PointInstancer.Define(stage, "/World/points")
    proto = stage.DefinePrim("/World/points/proto", "Xform")
    proto.GetReferences().AddInternalReference("/Protos/a")
    points.CreatePrototypesRel().SetTargets([proto.GetPath()])
    points.CreateProtoIndicesAttr([0, 0, 0])
    points.CreatePositionsAttr([(0.5, -1.2, 0), (1.4, -1.5, 0), (2.4, -0.9, 0)])
    points.CreateScalesAttr([(0.7, 0.7, 0.7), (-0.8, 0.6, 0.6), (0.5, 0.5, 1.2)])
    made.camera((0.3, -6.5, 3.5), (0, 0, 0.3))
    made.dome(radiance=1.0)
    return made
