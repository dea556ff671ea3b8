"""Subdivision surfaces lie where those of another program lie, which has Pixar's OpenSubdiv."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom, Vt
from scipy.spatial import KDTree

from openrooms_usd.arrays import Array
from openrooms_usd.usd.shapes.meshes import read_meshes
from openrooms_usd.usd.shapes.subdivided import LEVELS
from tests.blender.conftest import Blender

pytestmark = pytest.mark.slow

# Blender's words for interpolateBoundary and faceVaryingLinearInterpolation.
BOUNDARIES = {"ALL": "edgeOnly", "PRESERVE_CORNERS": "edgeAndCorner"}
SEAMS = {
    "NONE": "all",
    "SMOOTH_ALL": "none",
    "PRESERVE_CORNERS": "cornersOnly",
    "PRESERVE_CORNERS_AND_JUNCTIONS": "cornersPlus1",
    "PRESERVE_CORNERS_JUNCTIONS_AND_CONCAVE": "cornersPlus2",
    "PRESERVE_BOUNDARIES": "boundaries",
}
USUAL = "PRESERVE_CORNERS_AND_JUNCTIONS"
RANDOM = np.random.default_rng(1)

BOX = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], float)
SIDES = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]
HILLS = np.array([[i, j, 0.3 * RANDOM.normal()] for j in range(4) for i in range(4)])
FIELDS = [
    [4 * j + i, 4 * j + i + 1, 4 * j + i + 5, 4 * j + i + 4] for j in range(3) for i in range(3)
]
PYRAMID = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [0, 0, 1]], float)
SLOPES = [[0, 3, 2, 1], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]


def cage(
    points: Array,
    faces: list[list[int]],
    *,
    creases: Any = (),
    corners: Any = (),
    boundary: str = "ALL",
    uv: str = USUAL,
    seam: float | None = None,
) -> dict[str, Any]:
    """A control cage; with ``seam`` texture coordinates jump at that x, else at every corner."""
    indices = [index for face in faces for index in face]
    st = RANDOM.uniform(size=(len(indices), 2))
    if seam is not None:
        beyond = np.repeat(
            [points[face].mean(axis=0)[0] > seam for face in faces], [len(face) for face in faces]
        )
        at = points[indices]
        st = np.stack([at[:, 0] + 5.0 * beyond, at[:, 1] + 0.2 * at[:, 2]], axis=1)
    # Blender holds single precision.
    return {
        "points": points.astype(np.float32).tolist(),
        "counts": [len(face) for face in faces],
        "indices": indices,
        "creases": creases,
        "corners": corners,
        "boundary": boundary,
        "uv": uv,
        "st": st.astype(np.float32).tolist(),
    }


CAGES = [
    cage(BOX, SIDES),
    cage(BOX, SIDES, creases=[(0, 1, 10.0), (1, 3, 10.0), (3, 2, 10.0), (2, 0, 10.0)]),
    cage(BOX, SIDES, creases=[(0, 1, 2.5), (1, 3, 1.5), (4, 5, 0.4)]),
    cage(BOX, SIDES, corners=[(0, 10.0), (3, 1.3)]),
    cage(PYRAMID, SLOPES),
    cage(HILLS, FIELDS, boundary="PRESERVE_CORNERS", seam=9.0),
    *(cage(HILLS, FIELDS, uv=uv, seam=1.9) for uv in SEAMS),
]


def test_points_and_seams_are_those_of_opensubdiv(blender: Blender, tmp_path: Path) -> None:
    stage = Usd.Stage.CreateNew(str(tmp_path / "scene.usda"))
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    for number, one in enumerate(CAGES):
        define(stage, f"/cage_{number}", one)
    stage.GetRootLayer().Save()
    theirs = blender("subdivided", tmp_path / "scene.usda", cages=CAGES, levels=LEVELS)
    for one, their, placed in zip(CAGES, theirs, read_meshes(stage), strict=True):
        mesh = placed.mesh
        corners = mesh.points[mesh.triangles]
        ours = np.concatenate([corners, mesh.uvs["st"]], axis=2).reshape(-1, 5)
        expected = np.hstack([their["points"], their["st"]])
        # It nears a smooth corner of a boundary in six steps only, and is 8e-5 from it.
        there = np.abs(KDTree(expected).query(ours)[0]).max()
        back = np.abs(KDTree(ours).query(expected)[0]).max()
        exact = one["points"] != HILLS.astype(np.float32).tolist() or one["boundary"] != "ALL"
        assert max(there, back) < (2e-6 if exact else 2e-4), one


def define(stage: Usd.Stage, path: str, one: dict[str, Any]) -> None:
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(np.array(one["points"], np.float32)))
    mesh.CreateFaceVertexCountsAttr(one["counts"])
    mesh.CreateFaceVertexIndicesAttr(one["indices"])
    mesh.CreateCreaseIndicesAttr([i for row in one["creases"] for i in row[:2]])
    mesh.CreateCreaseLengthsAttr([2] * len(one["creases"]))
    mesh.CreateCreaseSharpnessesAttr([row[2] for row in one["creases"]])
    mesh.CreateCornerIndicesAttr([row[0] for row in one["corners"]])
    mesh.CreateCornerSharpnessesAttr([row[1] for row in one["corners"]])
    mesh.CreateInterpolateBoundaryAttr(BOUNDARIES[one["boundary"]])
    mesh.CreateFaceVaryingLinearInterpolationAttr(SEAMS[one["uv"]])
    kind = Sdf.ValueTypeNames.TexCoord2fArray
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", kind, "faceVarying")
    st.Set(Vt.Vec2fArray.FromNumpy(np.array(one["st"], np.float32)))
