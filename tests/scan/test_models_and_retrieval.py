"""CADs from folders, points on their outside, symmetries, and which of them is alike."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from openrooms_usd.errors import InputError
from openrooms_usd.library.models.cads import cad_files, folder_cads, merged
from openrooms_usd.scan.models.cad import UPRIGHT, CadModel
from openrooms_usd.scan.registration.alignment import symmetry_of
from openrooms_usd.scan.registration.evidence import Evidence
from openrooms_usd.scan.registration.hints import Box
from openrooms_usd.scan.registration.selection import ranked
from tests.scan.alignment_cases import CABINET, CHAIR, SOFA, TABLE, Block, cad, mesh


def write_obj(path: Path, blocks: tuple[Block, ...]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    vertices, faces = mesh(blocks)
    lines = [f"v {x} {y} {z}" for x, y, z in vertices]
    lines += [f"f {a} {b} {c}" for a, b, c in faces + 1]
    path.write_text("\n".join(lines) + "\n")


def test_a_folder_gives_cads_with_what_its_index_says(tmp_path: Path) -> None:
    write_obj(tmp_path / "chair_a.obj", CHAIR)
    write_obj(tmp_path / "sofas" / "long.obj", SOFA)
    index = {"chair_a": {"category": "chair", "symmetry": "none", "up": "Z"}, "long.obj": "sofa"}
    (tmp_path / "index.json").write_text(json.dumps(index))
    chair, sofa = cad_files(tmp_path, (".obj",))
    assert (chair.id, chair.category, chair.symmetry, chair.up) == ("chair_a", "chair", "none", "Z")
    assert (sofa.id, sofa.category, sofa.symmetry, sofa.up) == ("long", "sofa", None, None)
    assert [one.path.name for one in (chair, sofa)] == ["chair_a.obj", "long.obj"]
    assert cad_files(tmp_path, (".ply",)) == ()


def test_files_of_one_name_are_told_apart_by_their_folders(tmp_path: Path) -> None:
    for name in ("03/1a", "03/2b", "04/3c"):
        write_obj(tmp_path / name / "models" / "model_normalized.obj", CHAIR)
    assert [file.id for file in cad_files(tmp_path, (".obj",))] == ["1a", "2b", "3c"]


@pytest.mark.parametrize("symmetry", ["C2", 2, "__SYM_ROTATE_UP_2"])
def test_symmetries_are_spelt_in_several_ways(tmp_path: Path, symmetry: object) -> None:
    write_obj(tmp_path / "a.obj", TABLE)
    (tmp_path / "index.json").write_text(json.dumps({"a": {"symmetry": symmetry}}))
    assert cad_files(tmp_path, (".obj",))[0].symmetry == "2"


@pytest.mark.parametrize(
    ("name", "text", "says"),
    [
        ("index.json", "{", "index"),
        ("index.json", "[]", "not an object"),
        ("index.json", '{"a": 3}', "neither"),
        ("index.json", '{"a": {"symmetry": "7"}}', "symmetry"),
    ],
)
def test_what_cannot_be_read_is_said(tmp_path: Path, name: str, text: str, says: str) -> None:
    write_obj(tmp_path / "a.obj", CHAIR)
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=says):
        cad_files(tmp_path, (".obj",))


def test_a_missing_folder_is_said(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such folder"):
        cad_files(tmp_path / "none", (".obj",))


def test_points_lie_on_what_can_be_seen_and_look_outward() -> None:
    shell = CABINET[0]
    inner = ((-0.3, -0.1, 0.1), (0.3, 0.1, 0.8))
    surface = cad("cabinet", (shell, inner)).surface
    low, high = np.array(shell)
    depth = np.minimum(surface.points - low, high - surface.points).min(axis=1)
    assert np.abs(depth).max() < 1e-9
    outward = np.einsum("ij,ij->i", surface.normals, surface.points - 0.5 * (low + high))
    assert outward.min() > 0.0
    assert not surface.two_sided.any()
    area = 2.0 * (0.8 * 0.44 + 0.8 * 0.9 + 0.44 * 0.9)
    assert surface.spacing**2 * len(surface.points) == pytest.approx(area, rel=0.05)


def test_how_faces_are_wound_does_not_matter() -> None:
    model = cad("cabinet", CABINET)
    turned = CadModel("cabinet", "cabinet", model.vertices, model.faces[:, ::-1])
    outward = turned.surface.points - model.extent.mean(axis=0)
    assert np.einsum("ij,ij->i", turned.surface.normals, outward).min() > 0.0


def test_a_sheet_is_seen_from_both_sides() -> None:
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]])
    sheet = CadModel("sheet", "sheet", corners, np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32))
    assert sheet.surface.two_sided.all()


STOOL = (
    ((-0.2, -0.2, 0.4), (0.2, 0.2, 0.44)),
    ((-0.2, -0.2, 0.0), (-0.15, -0.15, 0.4)),
    ((0.15, 0.15, 0.0), (0.2, 0.2, 0.4)),
    ((-0.2, 0.15, 0.0), (-0.15, 0.2, 0.4)),
    ((0.15, -0.2, 0.0), (0.2, -0.15, 0.4)),
)


def drum(corners: int) -> CadModel:
    """A prism over a regular polygon, with a lid."""
    angle = 2.0 * np.pi * np.arange(corners) / corners
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    vertices = np.concatenate([np.c_[ring, np.zeros(corners)], np.c_[ring, np.ones(corners)]])
    i = np.arange(corners)
    j = (i + 1) % corners
    sides = np.concatenate([np.c_[i, j, j + corners], np.c_[i, j + corners, i + corners]])
    lid = np.c_[np.full(corners - 2, corners), i[1:-1] + corners, i[2:] + corners]
    return CadModel("drum", "drum", vertices, np.concatenate([sides, lid]).astype(np.int32))


@pytest.mark.parametrize(
    ("model", "symmetry"),
    [
        (cad("chair", CHAIR), "none"),
        (cad("sofa", SOFA), "none"),
        (cad("table", TABLE), "2"),
        (cad("stool", STOOL), "4"),
        (drum(4), "4"),
        (drum(48), "inf"),
    ],
)
def test_symmetries_are_found_from_the_mesh(model: CadModel, symmetry: str) -> None:
    assert symmetry_of(model, UPRIGHT["Z"]) == symmetry


@pytest.mark.parametrize("up", ["X", "Y", "Z"])
def test_upright_turns_keep_the_hand_and_lift_their_axis(up: str) -> None:
    turn = UPRIGHT[up]  # type: ignore[index]
    assert np.linalg.det(turn) == pytest.approx(1.0)
    assert turn @ np.eye(3)["XYZ".index(up)] == pytest.approx([0.0, 0.0, 1.0])


@pytest.mark.parametrize("heading", [0.0, 0.7, 2.9])
def test_the_cad_itself_is_the_most_similar(heading: float) -> None:
    models = [
        cad("chair", CHAIR),
        cad("sofa", SOFA),
        cad("table", TABLE),
        cad("cabinet", CABINET),
        cad("chair_low", CHAIR, scale=np.array([1.0, 1.0, 1.8])),
    ]
    turn = Rotation.from_euler("z", heading)
    for row, model in enumerate(models):
        middle = model.extent.mean(axis=0)
        box = Box(
            turn.apply(middle) + np.array([3.0, 1.0, 0.0]),
            np.ptp(model.extent, axis=0),
            turn.as_quat(scalar_first=True),
        )
        points = turn.apply(model.surface.points) + np.array([3.0, 1.0, 0.0])
        order = ranked(models, [UPRIGHT["Z"]] * len(models), Evidence(points, 0.02), box)
        assert order[0] == row


def test_shapenet_folders_are_read(real: Callable[[str], Path]) -> None:
    found = folder_cads(real("scan2cad_scene0470_00/Assets/shapenet-sample"))
    assert len(found) == 6
    assert {len(one.id) for one in found} >= {32, 31}
    for one in found:
        assert np.linalg.norm(np.ptp(merged(one.model(), np.eye(4))[0], axis=0)) == pytest.approx(
            1.0, abs=0.01
        )
