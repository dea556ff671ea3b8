"""Files in other units or axes are named, and stand right after ``orusd edit fix-units``."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom

from openrooms_usd.edits.fitting import fit, misfits_of
from openrooms_usd.errors import InputError
from openrooms_usd.rules import validate_stage
from openrooms_usd.usd.places.metrics import SCALE, TURN, find_unit_mismatches
from openrooms_usd.usd.shapes.meshes import read_meshes
from tests.commands import run

# A board of another program: 1.2 m wide, 0.8 m high, 0.2 m deep, standing on its origin, its front
# towards +Z where Y is up, moved 1 m to the right by an operation of its own.
SIZE = {"right": 1.2, "up": 0.8, "front": 0.2}


def write_board(path: Path, metres: float | None, up: str | None) -> None:
    stage = Usd.Stage.CreateNew(str(path))
    if metres:
        UsdGeom.SetStageMetersPerUnit(stage, metres)
    if up:
        UsdGeom.SetStageUpAxis(stage, up)
    unit = 1.0 / (metres or 0.01)
    root = UsdGeom.Xform.Define(stage, "/asset")
    stage.SetDefaultPrim(root.GetPrim())
    root.AddTranslateOp().Set(Gf.Vec3d(unit, 0, 0))
    right, high, front = SIZE["right"] * unit, SIZE["up"] * unit, SIZE["front"] * unit
    corners = [(0, 0, 0), (right, 0, 0), (right, high, 0), (0, high, front)]
    if up == "Z":
        corners = [(x, -z, y) for x, y, z in corners]
    mesh = UsdGeom.Mesh.Define(stage, "/asset/board")
    mesh.CreatePointsAttr(corners)
    mesh.CreateFaceVertexCountsAttr([3, 3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 0, 2, 3])
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateExtentAttr(UsdGeom.PointBased.ComputeExtent(mesh.GetPointsAttr().Get()))
    stage.Save()


def bounds(scene: Path, path: str = "/World/Board") -> np.ndarray:
    """(2, 3) of what is drawn below a prim, metres."""
    stage = Usd.Stage.Open(str(scene))
    stage.Reload()
    points = [m.world_points() for m in read_meshes(stage) if m.path.startswith(path)]
    return np.array([np.concatenate(points).min(axis=0), np.concatenate(points).max(axis=0)])


def said(content: str = "", extra: str = "") -> str:
    arc = f"prepend references = @../props/board.usda@{extra}"
    return f'over "World" {{\n def Xform "Board" ({arc}) {{\n{content}}}\n}}\n'


@pytest.fixture
def board(place):
    """Writes the board, and edits that refer to it."""
    (place.out / "props").mkdir()

    def write(metres: float | None, up: str | None, content: str = "", extra: str = "") -> None:
        write_board(place.out / "props" / "board.usda", metres, up)
        place.write_edits(said(content, extra))

    return write


@pytest.mark.one_in(6)
@pytest.mark.parametrize("metres", [0.01, 0.0254, 1.0])
@pytest.mark.parametrize("up", ["Y", "Z"])
def test_it_stands_as_it_is_meant(
    place, board: Callable[..., None], metres: float, up: str
) -> None:
    board(metres, up)
    fitting = fit(place.out)
    assert bool(fitting.fitted) == ((metres, up) != (1.0, "Z"))
    wanted = [[1.0, -0.2, 0.0], [2.2, 0.0, 0.8]]
    np.testing.assert_allclose(bounds(place.scene), wanted, atol=1e-6)
    assert misfits_of(place.out) == []
    before = place.edits.read_bytes()
    assert fit(place.out).fitted == ()
    assert place.edits.read_bytes() == before


def written(operations: list[tuple[str, str, str]]) -> str:
    order = ", ".join(f'"{name}"' for _, name, _ in operations)
    values = "".join(f"{kind} {name} = {value}\n" for kind, name, value in operations)
    return f"{values}uniform token[] xformOpOrder = [{order}]\n" if operations else ""


PLACED = [
    ("double3", "xformOp:translate", "(2, 3, 0.5)"),
    ("float3", "xformOp:rotateXYZ", "(0, 0, 90)"),
]


@pytest.mark.slow
def test_where_somebody_put_it_stays_in_metres(place, board: Callable[..., None]) -> None:
    """Their order of operations leaves out that of the file, whose name they use themselves."""
    board(0.01, "Y", written(PLACED))
    fit(place.out)
    # Turned by 90 degrees: right is +Y, and the front, which was -Y, is +X.
    wanted = [[2.0, 3.0, 0.5], [2.2, 4.2, 1.3]]
    np.testing.assert_allclose(bounds(place.scene), wanted, atol=1e-6)


SCALED, DOUBLED, GROWN = (
    ("double3", "xformOp:scale", f"({value}, {value}, {value})") for value in (0.01, 0.02, 2)
)
RAISED = ("double", "xformOp:rotateX", "90")
MATRIX = "((0.01, 0, 0, 0), (0, 0, 0.01, 0), (0, -0.01, 0, 0), (4, 2, 0, 1))"


@pytest.mark.one_in(7)
@pytest.mark.parametrize(
    ("operations", "missing"),
    [
        ([], {TURN, SCALE}),
        ([SCALED], {TURN}),
        ([DOUBLED], {TURN}),
        ([GROWN], {TURN, SCALE}),
        ([RAISED], {SCALE}),
        ([RAISED, SCALED], set()),
        ([("matrix4d", "xformOp:transform", MATRIX)], set()),
        ([("double3", "xformOp:scale", "(1, 0, 1)")], set()),
    ],
)
def test_what_is_corrected_already_is_left_alone(
    place, board: Callable[..., None], operations: list[tuple[str, str, str]], missing: set[str]
) -> None:
    board(0.01, "Y", written(operations))
    found = [name for misfit in misfits_of(place.out) for name, _ in misfit.operations]
    assert set(found) == missing
    fit(place.out)
    assert misfits_of(place.out) == []


def test_a_file_that_says_no_units_is_named_and_left(place, board: Callable[..., None]) -> None:
    board(None, None)
    before = place.edits.read_bytes()
    fitting = fit(place.out)
    assert [misfit.path for misfit in fitting.left] == ["/World/Board"]
    assert fitting.fitted == () and place.edits.read_bytes() == before


def test_nor_is_it_named_where_somebody_has_scaled_it(place, board: Callable[..., None]) -> None:
    board(None, None, written([GROWN]))
    assert misfits_of(place.out) == []


@pytest.mark.slow
def test_everybody_says_it(place, board: Callable[..., None], tmp_path: Path) -> None:
    board(0.01, "Y")
    text = "is 100 times too large; it needs xformOp:rotateX:unitsResolve = 90, xformOp:scale"
    (found,) = [f for f in validate_stage(place.scene) if f.code == "units"]
    assert (found.severity, found.place) == ("warning", "/World/Board")
    assert text in found.message and "orusd edit fix-units" in found.remedy
    assert any(text in note and "/World/Board" in note for note in place.compose().notes)
    # It is said before anything is rendered, or is found out to be impossible.
    words = ["render", str(place.scene), "-o", str(tmp_path / "r"), "--renderer", "none"]
    assert text in run(*words).stderr
    asked = run("edit", "fix-units", place.out, "--dry-run")
    assert text in asked.stdout and "would correct 1" in asked.stdout
    done = run("edit", "fix-units", place.out, "--json")
    assert [row["path"] for row in json.loads(done.stdout)["fitted"]] == ["/World/Board"]
    assert place.compose().notes == ()


@pytest.mark.slow
def test_what_else_the_edits_say_stays(place, board: Callable[..., None]) -> None:
    board(0.01, "Y", extra='\n instanceable = true\n customData = { string who = "me" }')
    before = Sdf.Layer.FindOrOpen(str(place.edits)).ExportToString()
    fit(place.out)
    layer = Sdf.Layer.FindOrOpen(str(place.edits))
    layer.Reload()
    spec = layer.GetPrimAtPath("/World/Board")
    for name in (TURN, SCALE, "xformOpOrder"):
        spec.RemoveProperty(spec.attributes[name])
    assert layer.ExportToString() == before


@pytest.mark.slow
def test_a_scan_of_an_iphone_stands_up(place, real: Callable[[str], Path]) -> None:
    """What RoomPlan exports has Y up and is in metres."""
    (place.out / "props").mkdir()
    shutil.copy(real("roomplan_libroom/Room.usdz"), place.out / "props" / "board.usda.usdz")
    place.write_edits(said().replace("board.usda@", "board.usda.usdz@"))
    (misfit,) = misfits_of(place.out)
    assert misfit.operations == ((TURN, 90.0),)
    lying = np.ptp(bounds(place.scene), axis=0)
    fit(place.out)
    x, y, z = lying
    np.testing.assert_allclose(np.ptp(bounds(place.scene), axis=0), [x, z, y], rtol=1e-6)


def test_a_room_without_such_files_is_not_touched(place) -> None:
    before = place.tree()
    assert fit(place.out).fitted == ()
    assert place.tree() == before
    assert find_unit_mismatches(Usd.Stage.Open(str(place.scene))) == []


def test_what_is_no_room_is_refused_and_left_as_it_is(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="orusd compose"):
        fit(tmp_path)
    assert list(tmp_path.iterdir()) == []
