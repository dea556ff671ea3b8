"""Tables of points as text, as many programs write them: the same points, and what is not used."""

from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.errors import InputError
from openrooms_usd.scan.points.cloud import Cloud
from orusd_scans.formats.pointtext import read_text
from orusd_scans.plainscan import ScanImporter
from orusd_scans.scanned import Scanned

POINTS = [[1, 2, 3], [4, 5, 6.5], [-7, 8.25, 9]]
RGB = [[255, 0, 10], [1, 2, 3], [90, 80, 70]]
ATTRIBUTES = ("colors", "normals", "label", "instance")


def read(tmp_path: Path, text: str | bytes, name: str = "a.txt") -> Scanned:
    data = text if isinstance(text, bytes) else text.encode()
    (tmp_path / name).write_bytes(data)
    return read_text(tmp_path / name)


def rows(separator: str = " ", *columns: list[list[float]]) -> str:
    """The points with other columns after them, one line each."""
    whole = np.hstack([POINTS, *columns])
    return "".join(separator.join(f"{value:g}" for value in row) + "\n" for row in whole)


def indexed(separator: str) -> str:
    """The points after their numbers, as tables of pandas are saved."""
    lines = rows(separator).splitlines()
    return "".join(f"{number}{separator}{line}\n" for number, line in enumerate(lines))


def given(cloud: Cloud) -> str:
    return " ".join(name for name in ATTRIBUTES if getattr(cloud, name) is not None)


# Text, what it gives beside the points, and words of its notes.
DIALECTS: dict[str, tuple[str | bytes, str, str]] = {
    "blanks": (rows(), "", ""),
    "commas": (rows(","), "", ""),
    "commas and blanks": (rows(", "), "", ""),
    "semicolons": (rows(";"), "", ""),
    "tabs": (rows("\t"), "", ""),
    "mixed": (rows(",", RGB).replace(",255,", " 255;").replace(",1,", "  1;"), "colors", ""),
    "trailing commas": (rows(",").replace("\n", ",\n"), "", ""),
    "trailing tabs": (rows("\t").replace("\n", "\t\r\n"), "", ""),
    "Windows": (rows().replace("\n", "\r\n"), "", ""),
    "old Macintosh": (rows().replace("\n", "\r"), "", ""),
    "UTF-8 mark": ("\ufeff" + rows(), "", ""),
    "UTF-8 mark, names": ("\ufeffx,y,z\r\n" + rows(","), "", ""),
    "UTF-16": (rows().encode("utf-16"), "", ""),
    "UTF-16, big end": (("\ufeffx;y;z\r\n" + rows(";")).encode("utf-16-be"), "", ""),
    "decimal commas": (rows(";").replace(".", ","), "", ""),
    "decimal commas, names": ("X;Y;Z\n" + rows(";").replace(".", ","), "", ""),
    "decimal commas, tabs": (rows("\t").replace(".", ","), "", ""),
    "decimal commas, blanks": (rows().replace(".", ","), "", ""),
    "decimal commas, quotes": (rows(",").replace("6.5", '"6,5"').replace("8.25", '"8,25"'), "", ""),
    "pandas": (",x,y,z\n" + indexed(","), "", "not used: column 1"),
    "quotes": ('"x","y","z"\n' + '"' + rows('","').replace("\n", '"\n"')[:-1], "", ""),
    "comments": ("% made by hand\n% x y z\n# and\n// so\n\n" + rows(), "", ""),
    "comments between": (rows().replace("\n", "\n# so\n\n"), "", ""),
    "free words": ("written by a scanner\n" + rows(), "", ""),
    "CloudCompare": ("//X Y Z R G B\n3\n" + rows(" ", RGB), "colors", ""),
    "CloudCompare, brackets": (
        "//X;Y;Z;Rf;Gf;Bf;Illuminance (PCV);Roughness(0.01)\n3\n"
        + rows(";", [[1, 0, 0]] * 3, [[0.5, 0.1]] * 3),
        "colors",
        "not used: illuminance, roughness",
    ),
    "commas name, blanks part": ("//X,Y,Z\n" + rows(), "", ""),
    "label, instance": ("//X;Y;Z;label;instance\n" + rows(";", [[5, 1]] * 3), "label instance", ""),
    "PTS": ("3\n" + rows(" ", [[-99], [4], [7]], RGB), "colors", "intensity"),
    "PTS, two stations": (
        "1\n" + rows(" ", [[9]] * 3, RGB).replace("\n4", "\n2\n4"),
        "colors",
        "intensity",
    ),
    "PDAL": (
        '"X","Y","Z","Intensity","Red","Green","Blue"\n' + rows(",", [[4]] * 3, RGB),
        "colors",
        "not used: intensity",
    ),
    "a name too few": ("x y z\n" + rows(" ", [[8]] * 3), "", "not used: column 4"),
    "normals": ("X Y Z Nx Ny Nz\n" + rows(" ", [[0, 0, 1]] * 3), "normals", ""),
    "normals by value": (rows(" ", [[0, 0.6, 0.8]] * 3), "normals", ""),
    "colours by value": (rows(" ", RGB), "colors", ""),
    "colour, label": (rows(" ", RGB, [[5], [0], [22]]), "colors label", "blue, label"),
    "colour, object": (
        rows(" ", RGB, [[5], [0], [22]], [[7], [8], [9]]),
        "colors label instance",
        "label, instance",
    ),
    "colour, normal": (rows(" ", RGB, [[0, 1, 0]] * 3), "colors normals", "nz"),
    "intensity": (rows(" ", [[0.5]] * 3), "", "not used: intensity"),
    "five columns": (rows(" ", [[0.5, 7]] * 3), "", "not used: column 4, column 5"),
    "sentences": ("# the points are given as x y z\n# a word x y z\n" + rows(), "", ""),
    "a sentence as wide": ("# the x y z values here\n" + rows(" ", RGB), "colors", ""),
    "a sentence that begins so": ("// x y z of the points\n" + rows(" ", RGB), "colors", ""),
    "names behind a word": ("# columns: x y z r g b\n" + rows(" ", RGB), "colors", ""),
    "names of a survey": ("Easting,Northing,Elevation\n" + rows(","), "", ""),
    "COLMAP": (
        "# 3D point list with one line of data per point:\n"
        "#   POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n"
        "# Number of points: 3, mean track length: 2\n"
        "63390 1 2 3 255 0 10 1.3 16 6542 15 7345\n"
        "63376 4 5 6.5 1 2 3 2.1 16 6519\n"
        "63371 -7 8.25 9 90 80 70 1.7 16 6 14 7 15 4 18 9\n",
        "colors",
        "not used: point3d_id, error",
    ),
}


@pytest.mark.parametrize("name", DIALECTS)
def test_dialects(tmp_path: Path, name: str) -> None:
    text, gives, told = DIALECTS[name]
    scanned = read(tmp_path, text)
    assert scanned.cloud.points.tolist() == POINTS
    assert given(scanned.cloud) == gives
    assert told in " ".join(scanned.notes)
    assert told or not scanned.notes
    if "colors" in gives and "brackets" not in name:
        assert scanned.cloud.colors.tolist() == RGB


@pytest.mark.parametrize(
    ("names", "unit"),
    [
        ("X [m],Y [m],Z [m]", "m"),
        ("x(mm),y(mm),z(mm)", "mm"),
        ("X_cm,Y_cm,Z_cm", "cm"),
        ('"X (feet)","Y (feet)","Z (feet)"', "ft"),
        ("x [m],y [m],z [mm]", None),
        ("x [0],y [1],z [2]", None),
    ],
)
@pytest.mark.parametrize("separator", [",", ";", "\t", " "])
def test_units_in_names(tmp_path: Path, names: str, unit: str | None, separator: str) -> None:
    scanned = read(tmp_path, names.replace(",", separator) + "\n" + rows(separator))
    assert scanned.cloud.points.tolist() == POINTS
    assert scanned.unit == unit


def test_a_unit_in_the_names_is_that_of_the_room(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    points = rng.random((500, 3)) * [5000, 4000, 2600]
    np.savetxt(tmp_path / "a.csv", points, "%.0f", ",", header="x [mm],y [mm],z [mm]", comments="")
    capture = ScanImporter().read(tmp_path / "a.csv")
    assert np.ptp(capture.cloud.points, axis=0) == pytest.approx([5, 4, 2.6], rel=0.02)


LINES = rows(" ", RGB).splitlines() * 3


@pytest.mark.parametrize(
    "damaged",
    [
        "1 2 3 4 5",
        "1 2 3 4 5 6 7",
        "1 2 3 103.0\x100000 4 5",
        "1 2 3\x00 4 5 6",
        "1 2 x 4 5 6",
        "1_0 2 3 4 5 6",
        '1 2 3 4 5 "',
        "1 2 3 4 5 6 # more",
        "\x1a",
        "a",
    ],
)
def test_a_damaged_line_is_left_out_and_its_number_told(tmp_path: Path, damaged: str) -> None:
    text = "\n".join(["# made", *LINES[:4], damaged, *LINES[4:]])
    scanned = read(tmp_path, text)
    assert len(scanned.cloud) == 9
    assert "left out 1 of 10 lines" in scanned.notes[0]
    assert "the first is line 6" in scanned.notes[0]


def test_a_first_line_may_be_the_damaged_one(tmp_path: Path) -> None:
    scanned = read(tmp_path, "\n".join(["1-1 2.x 3 4 5 6", *LINES]))
    assert len(scanned.cloud) == 9
    assert "the first is line 1" in scanned.notes[0]


def test_a_last_line_that_is_cut(tmp_path: Path) -> None:
    scanned = read(tmp_path, "\n".join([*LINES[:4], "4.5 5"]))
    assert len(scanned.cloud) == 4
    assert "line 5, '4.5 5'" in scanned.notes[0]


@pytest.mark.parametrize("word", ["-1.#IND00", "1.#QNAN", "1.#INF", "nan", "-nan(ind)", "NULL"])
def test_what_writers_print_for_no_number(tmp_path: Path, word: str) -> None:
    scanned = read(tmp_path, rows() + f"{word} 2 3\n")
    assert np.isnan(scanned.cloud.points[3, 0]) or word == "1.#INF"
    assert len(scanned.cloud) == 4
    colored = read(tmp_path, rows(" ", RGB) + f"1 2 3 {word} 2 3\n")
    assert colored.cloud.colors.tolist() == [*RGB, [128] * 3]
    assert "1 colours are not numbers" in colored.notes[0]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            "1 2 3\n" * 2 + "so\n" * 2,
            "2 of 4 lines are not a row of 3 numbers: the first is line 3",
        ),
        ("1 2\n3 4\n", "no line is a row of three numbers"),
        ("nan nan nan\n", "no line is a row of three numbers"),
        ("a,b,c\n1,2,3\n", "its columns are named a, b, c: x, y and z are missing"),
        ("x y z r g b\n1 2 3\n", "6 columns are named, but lines have 3"),
        ("X,Y,Z\n1,5,2,5,3,5\n", "lines have 6 between commas"),
    ],
)
def test_the_true_cause_is_told(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(InputError, match=said) as caught:
        read(tmp_path, text)
    assert "scan again" not in caught.value.remedy


def test_stations_of_ptx_stand_where_their_matrix_says(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    text, expected, origins = "", [], []
    for angle in (0.3, 2.0):
        c, s = np.cos(angle), np.sin(angle)
        turn, place = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]]), rng.random(3)
        points, colors = rng.random((6, 3)), rng.integers(0, 256, (6, 3))
        axes = [place, *turn.T, *np.column_stack([np.vstack([turn.T, place]), [0, 0, 0, 1]])]
        rows = [*np.column_stack([points, np.full(6, 0.5), colors]), [0, 0, 0, 0.5, 0, 0, 0]]
        text += "7\n1\n" + "".join(" ".join(f"{v:.9f}" for v in row) + "\n" for row in axes + rows)
        expected.append(points @ turn.T + place)
        origins.append(place)
    for name in ("a.ptx", "a.txt"):
        scanned = read(tmp_path, text, name)
        assert scanned.cloud.points == pytest.approx(np.concatenate(expected), abs=1e-8)
        assert scanned.cloud.sensor_origins == pytest.approx(np.array(origins), abs=1e-8)
        assert given(scanned.cloud) == "colors"
    with pytest.raises(InputError, match="ends too early"):
        read(tmp_path, text[:-150])
    with pytest.raises(InputError, match="no station of a PTX file begins at line 35"):
        read(tmp_path, text + "1 2 3\n")


STATION = "2\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("0 0 1 0\n", "0 0 nan 0\n", "the matrix from line 7 on is not of numbers"),
        ("0 0 1 0\n", "0 0 x 0\n", "the matrix from line 7 on is not of numbers"),
        ("2\n1\n", f"{'9' * 5000}\n1\n", "is not a number of directions"),
        ("2\n1\n", "99999999\n99999\n", "is not a number of points"),
    ],
)
def test_nonsense_in_the_head_of_a_station_is_refused(
    tmp_path: Path, old: str, new: str, said: str
) -> None:
    text = STATION.replace(old, new, 1) + "1 2 3 0.5\n4 5 6 0.5\n"
    with pytest.raises(InputError, match=said):
        read(tmp_path, text, "a.ptx")


def test_a_station_without_colours_leaves_those_of_others(tmp_path: Path) -> None:
    colored = STATION + "1 2 3 0.5 9 8 255\n4 5 6 0.5 7 6 5\n"
    scanned = read(tmp_path, STATION + "1 2 3 0.5\n4 5 6 0.5\n" + colored, "a.ptx")
    assert scanned.cloud.colors.tolist() == [[128] * 3] * 2 + [[9, 8, 255], [7, 6, 5]]
    assert "2 colours are not numbers: these points are grey" in scanned.notes


def test_a_long_table_is_read_in_pieces(tmp_path: Path) -> None:
    points = np.arange(300_000).reshape(-1, 3)
    lines = [f"{x} {y} {z}" for x, y, z in points]
    lines[70_000] = "here it is damaged"
    scanned = read(tmp_path, "\n".join(lines))
    assert (scanned.cloud.points == np.delete(points, 70_000, axis=0)).all()
    assert "the first is line 70001" in scanned.notes[0]
