"""OBJ files by other programs: a square of two triangles, however it is written."""

import re
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.errors import InputError
from openrooms_usd.library.models.wavefront import read_obj as read_model_obj
from orusd_scans.formats.obj import read_obj
from orusd_scans.scanned import Scanned
from tests.scans.damage import hits_are_told

POINTS = [[0, 0, 0.5], [1, 0, 0.5], [1, 1, 0.5], [0, 1, 0.5]]
V = "".join(f"v {x} {y} {z}\n" for x, y, z in POINTS)
F = "f 1 2 3\nf 1 3 4\n"
SQUARE = V + F
COLORED = V.replace(".5\n", ".5 1 0 0.5\n") + F
# Text, and words of the notes.
DIALECTS: dict[str, tuple[str | bytes, str]] = {
    "plain": (SQUARE, ""),
    "UTF-8 mark": ("\ufeff" + SQUARE, ""),
    "Windows": (SQUARE.replace("\n", "\r\n"), ""),
    "tabs": (SQUARE.replace(" ", "\t"), ""),
    "indented": ("  " + SQUARE.replace("\n", " \n  "), ""),
    "a quad": (V + "f 1 2 3 4\n", ""),
    "continued lines": (V.replace(" 0.5", " \\\n0.5", 1) + "f 1 2 \\\r\n3 4\n", ""),
    "counted back": (V + "f -4 -3 -2\nf -4 -2 -1\n", ""),
    "counted back before the last": (
        "".join(V.splitlines(keepends=True)[:3]) + "f -3 -2 -1\nv 0 1 0.5\nf -4 -2 -1\n",
        "",
    ),
    "counted from 0": (V + "f 0 1 2\nf 0 2 3\n", "from 0"),
    "counted from 0, with textures": (V + "f 0/0/0 1/1/0 2/2/0\nf 0 2//1 3/1\n", "from 0"),
    "counted from 0, continued": (V + "f 0 \\\n1 2 # 3\nf 0 \\\n2 \\\n3\n", "from 0"),
    "comments behind": (V.replace("5\n", "5 # a b c\n") + "f 1 2 3 # 4\nf 1 3 4# so\n", ""),
    "a comment that ends in a backslash": ("# c:\\room\\\n" + SQUARE, ""),
    "UTF-16": (SQUARE.encode("utf-16"), ""),
    "mixed entries": (V + "vn 0 0 1\nvt 0 0\nf 1/1/1 2//1 3/1\nf 1 3 4\n", ""),
    "decimal commas": (SQUARE.replace(".", ","), "decimal commas"),
    "commas between": (SQUARE.replace("v 0 1 0.5", "v 0, 1, 0.5"), "decimal commas"),
    "a weight": (V.replace(".5\n", ".5 1.0\n") + F, ""),
    "colours": (COLORED, ""),
    "colours as bytes": (COLORED.replace("1 0 0.5\n", "255 0 128\n"), ""),
    "materials and groups": ("mtllib a.mtl\no a\n" + V + "usemtl b\ng c\ns off\n" + F, ""),
    "lines and points": (V + "p 1\nl 1 2\n" + F, ""),
    "what is none of OBJ": (V + "hello you\n42\n" + F, "2 lines are not OBJ: the first is line 5"),
}


def saved(tmp_path: Path, text: str | bytes) -> Path:
    (tmp_path / "a.obj").write_bytes(text if isinstance(text, bytes) else text.encode())
    return tmp_path / "a.obj"


def read(tmp_path: Path, text: str | bytes) -> Scanned:
    return read_obj(saved(tmp_path, text))


@pytest.mark.parametrize("name", DIALECTS)
def test_dialects(tmp_path: Path, name: str) -> None:
    text, told = DIALECTS[name]
    scanned = read(tmp_path, text)
    assert scanned.cloud.points.tolist() == POINTS
    assert scanned.faces.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert re.search(told, " ".join(scanned.notes))
    assert told or not scanned.notes
    assert (scanned.cloud.colors is not None) == ("colours" in name)
    if scanned.cloud.colors is not None:
        assert scanned.cloud.colors.tolist() == [[255, 0, 128]] * 4


# Pictures' and normals' numbers of these lead nowhere, which a model needs and a scan does not.
@pytest.mark.parametrize("name", sorted(DIALECTS.keys() - {"counted from 0, with textures"}))
def test_models_are_read_alike(tmp_path: Path, name: str) -> None:
    reading = read_model_obj(saved(tmp_path, DIALECTS[name][0]))
    assert sum(len(piece.mesh.counts) for piece in reading.pieces) in (1, 2)
    assert reading.pieces[0].mesh.points.tolist() == POINTS


def test_points_alone_are_a_cloud(tmp_path: Path) -> None:
    scanned = read(tmp_path, V)
    assert scanned.faces is None
    assert scanned.cloud.points.tolist() == POINTS


def test_damaged_lines_cost_themselves_alone(tmp_path: Path) -> None:
    scanned = read(tmp_path, V.replace("v 1 1", "v 1 1\x10") + F + "f 1 x 3\nf 1 2 4\n")
    assert np.isnan(scanned.cloud.points).any(axis=1).tolist() == [False, False, True, False]
    assert scanned.faces.tolist() == [[0, 1, 2], [0, 2, 3], [0, 1, 3]]
    assert "the first is line 3" in scanned.notes[0]
    assert "1 of 4 faces are damaged" in scanned.notes[1]


@pytest.mark.parametrize(
    ("face", "said"),
    [
        ("1 2 3 x", "1 of 3 faces are damaged, and left out"),
        ("1 2 3.5 4", "1 of 3 faces are damaged, and left out"),
        ("1 2 9", "1 of 3 triangles refer to a vertex that is not there, and are left out"),
        ("1 2 -9", "1 of 3 triangles refer to a vertex that is not there, and are left out"),
    ],
)
def test_a_damaged_face_costs_itself_alone(tmp_path: Path, face: str, said: str) -> None:
    scanned = read(tmp_path, f"{SQUARE}f {face}\n")
    assert scanned.faces.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert scanned.notes == (said,)


def test_a_vertex_without_a_colour_is_grey(tmp_path: Path) -> None:
    scanned = read(tmp_path, COLORED.replace(".5 1 0 0.5\n", ".5\n", 1))
    assert scanned.cloud.points.tolist() == POINTS
    assert scanned.cloud.colors.tolist() == [[128] * 3, *[[255, 0, 128]] * 3]


def test_words_after_a_vertex_cost_nothing(tmp_path: Path) -> None:
    scanned = read(tmp_path, V.replace(".5\n", ".5 so\n") + "v 1 x 2\n" + F)
    assert scanned.cloud.points[:4].tolist() == POINTS
    assert "1 of 5 lines" in scanned.notes[0]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (V + "f 0 1 2\nf 2 3 4\n", "faces name vertex 0, and vertex 4 of 4"),
        (V + "f 1 2 5\n", "a vertex that is not there"),
        (V + "f -1 -2 -9\n", "a vertex that is not there"),
        ("f 1 2 3\n", "no vertices"),
        ("v 1 x 2\nv 2 y 3\n", "not a row of 3 numbers: the first is line 1"),
    ],
)
def test_what_cannot_be_read_is_told(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        read(tmp_path, text)


def test_no_byte_that_changes_ends_in_a_traceback(tmp_path: Path) -> None:
    (tmp_path / "whole.obj").write_text(COLORED + "f 0 -2 1/2/3\n")
    hits_are_told(read_obj, tmp_path / "whole.obj", np.random.default_rng(0), 150)
