"""PLY files by other writers and damaged in every way, and meshes as clouds."""

import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh

from openrooms_usd.errors import InputError
from openrooms_usd.scan.points.cloud import Cloud
from orusd_scans.formats.ply import read_ply
from orusd_scans.scanned import OTHER_CLASSES
from orusd_scans.surfaces import as_cloud
from tests.scans.damage import cuts_are_refused, hits_are_told

VERTICES = np.array([[0, 0, 0], [1, 0, 0], [1, 2, 0], [0, 2, 3.5]], float)
FACES = np.array([[0, 1, 2], [0, 2, 3]])
HEAD = (
    "ply\nformat {form} 1.0\ncomment made by hand\nelement camera 1\nproperty float view\n"
    "element vertex 4\nproperty double x\nproperty double y\nproperty double z\n"
    "property uchar red\nproperty uchar green\nproperty uchar blue\n"
    "property ushort label\nproperty int instance\n"
    "element face {faces}\nproperty uchar flags\nproperty list uchar int vertex_indices\n"
    "end_header\n"
)
ROWS = [(*VERTICES[i], 10 * i, 20, 255, i + 1, 7 - i) for i in range(4)]


def written(path: Path, form: str, polygons: list[list[int]]) -> Path:
    """A file with elements before the points, and faces of any length."""
    out = HEAD.format(form=form, faces=len(polygons)).encode()
    if form == "ascii":
        lines = ["1.5", *(" ".join(f"{v:g}" for v in row) for row in ROWS)]
        lines += [f"0 {len(p)} {' '.join(map(str, p))}" for p in polygons]
        path.write_bytes(out + "\n".join(lines).encode() + b"\n")
        return path
    order = "<" if "little" in form else ">"
    out += struct.pack(order + "f", 1.5)
    out += b"".join(struct.pack(order + "3d3BHi", *row) for row in ROWS)
    out += b"".join(struct.pack(f"{order}BB{len(p)}i", 0, len(p), *p) for p in polygons)
    path.write_bytes(out)
    return path


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_an_empty_list_of_faces_is_no_surface(tmp_path: Path, form: str) -> None:
    # As MeshLab writes point clouds.
    scanned = read_ply(written(tmp_path / "a.ply", form, []))
    assert scanned.faces is None
    assert (scanned.cloud.points == VERTICES).all()


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize("polygons", [[[0, 1, 2], [0, 2, 3]], [[0, 1, 2, 3], [0, 1, 3]]])
def test_all_forms_give_the_same(tmp_path: Path, form: str, polygons: list[list[int]]) -> None:
    scanned = read_ply(written(tmp_path / "a.ply", form, polygons))
    cloud = scanned.cloud
    assert (cloud.points == VERTICES).all()
    assert cloud.colors.tolist() == [[10 * i, 20, 255] for i in range(4)]
    assert cloud.label.tolist() == [1, 2, 3, 4]
    assert cloud.instance.tolist() == [7, 6, 5, 4]
    fans = {tuple(sorted(face)) for face in scanned.faces.tolist()}
    triangles = (
        {(0, 1, 2), (0, 2, 3)} if len(polygons[0]) == 3 else {(0, 1, 2), (0, 2, 3), (0, 1, 3)}
    )
    assert fans == triangles


FORMS = ("ascii", "binary_little_endian", "binary_big_endian")


def made(path: Path, form: str, *elements: tuple[str, list[str], list[list[object]]]) -> Path:
    """A file of elements: name, properties ``type name``, rows; a list in a row is one of PLY."""
    lines, body = ["ply", f"format {form} 1.0"], b""
    codes = {"uchar": "B", "int": "i", "uint": "I", "float": "f"}
    for name, properties, values in elements:
        lines.append(f"element {name} {len(values)}")
        kinds = [text.rpartition(" ")[0] for text in properties]
        lines += [f"property {text}" for text in properties]
        for row in values:
            flat: list[tuple[str, object]] = []
            for kind, value in zip(kinds, row, strict=True):
                if isinstance(value, list):
                    _, length, item = kind.split()
                    flat += [(codes[length], len(value)), *((codes[item], one) for one in value)]
                else:
                    flat.append((codes[kind], value))
            numbers = [number for _, number in flat]
            if form == "ascii":
                body += " ".join(map(str, numbers)).encode() + b"\n"
            else:
                order = "<" if "little" in form else ">"
                body += struct.pack(order + "".join(code for code, _ in flat), *numbers)
    path.write_bytes("\n".join([*lines, "end_header", ""]).encode() + body)
    return path


PLACES = ["float x", "float y", "float z"]
SIX = [[float(i % 2), float(i // 2), 0.0] for i in range(6)]


@pytest.mark.parametrize("form", FORMS)
def test_lists_of_vertices_are_passed_over_and_named(tmp_path: Path, form: str) -> None:
    # As openMVS writes them; values stand before, between and after the lists.
    kinds = ["float x", "list uchar uint views", "float y", "list uchar float weights", "float z"]
    rows = [
        [x, [7] * (i % 3), y, [0.5] * ((i + 1) % 3), z, 10 * i] for i, (x, y, z) in enumerate(SIX)
    ]
    vertices = ("vertex", [*kinds, "uchar red"], rows)
    faces = ("face", ["list uchar int vertex_index"], [[[0, 1, 3, 2]], [[2, 3, 5]]])
    scanned = read_ply(made(tmp_path / "a.ply", form, vertices, faces))
    assert scanned.cloud.points.tolist() == SIX
    assert sorted(map(sorted, scanned.faces.tolist())) == [[0, 1, 3], [0, 2, 3], [2, 3, 5]]
    assert scanned.notes == ("columns that are not used: red, views, weights",)


# One strip over all vertices, and what two with a restart between leave.
STRIP = [[0, 1, 2], [2, 1, 3], [2, 3, 4], [4, 3, 5]]


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(
    ("element", "kind", "lists", "triangles"),
    [
        ("tristrips", "int vertex_indices", [[0, 1, 2, 3, 4, 5]], STRIP),
        ("tristrips", "int vertex_index", [[0, 1, 2, 3, -1, 2, 3, 4, 5]], STRIP),
        ("tristrips", "uint vertex_indices", [[0, 1, 2, 3, 4294967295, 2, 3, 4]], STRIP[:3]),
        ("strip", "int vertex_indices", [[0, 1, 2, 3, -1], [2, 3, 4, 5]], STRIP),
        ("tristrips", "int vertex_indices", [[-1, 0, 1, 2, 2, 3, -1, -1, 4, 5]], [[0, 1, 2]]),
        ("trilist", "int vertex_indices", [[0, 1, 2, 2, 1, 3]], STRIP[:2]),
        ("trilist", "int vertex_index", [[*STRIP[0], *STRIP[1]], [*STRIP[2], *STRIP[3]]], STRIP),
        ("triangles", "int vertex_index", [[0, 1, 2], [2, 1, 3]], STRIP[:2]),
        ("polygon", "int Vertex_Indices", [[0, 1, 2], [2, 1, 3]], STRIP[:2]),
    ],
)
def test_strips_and_lists_of_triangles(
    tmp_path: Path,
    form: str,
    element: str,
    kind: str,
    lists: list[list[int]],
    triangles: list[list[int]],
) -> None:
    vertices = ("vertex", PLACES, [list(row) for row in SIX])
    faces = (element, [f"list int {kind}"], [[corners] for corners in lists])
    scanned = read_ply(made(tmp_path / "a.ply", form, vertices, faces))
    # All look the way of the first: along +Z.
    turned = {tuple(np.roll(face, -int(np.argmin(face)))) for face in scanned.faces}
    assert turned == {tuple(np.roll(face, -int(np.argmin(face)))) for face in triangles}
    assert scanned.notes == ()


def test_what_makes_no_surface_is_told(tmp_path: Path) -> None:
    elements = (
        ("vertex", PLACES, [list(row) for row in SIX]),
        ("edge", ["int vertex1", "int vertex2"], [[0, 1], [1, 2]]),
        ("polyline", ["list uchar int vertex_indices"], [[[0, 1, 2]]]),
    )
    scanned = read_ply(made(tmp_path / "a.ply", "ascii", *elements))
    assert scanned.faces is None
    assert scanned.notes == ("elements that are not used: 2 edge, 1 polyline",)


def test_a_damaged_line_costs_a_vertex_or_a_face(tmp_path: Path) -> None:
    vertices = ("vertex", PLACES, [list(row) for row in SIX])
    faces = ("face", ["list uchar int vertex_index"], [[face] for face in STRIP])
    file = made(tmp_path / "a.ply", "ascii", vertices, faces)
    lines = file.read_text().split("\n")
    lines[9], lines[-2] = "1.#QNAN 0 0", "3 4 3"
    lines[10] = "0 1\x10 0"
    file.write_text("\n".join(lines))
    scanned = read_ply(file)
    assert np.isnan(scanned.cloud.points).any(axis=1).tolist() == [True] * 2 + [False] * 4
    assert len(scanned.faces) == 3
    assert "line 11, '0 1\\x10 0'" in scanned.notes[0]
    assert "line 19, '3 4 3'" in scanned.notes[1]


@pytest.mark.parametrize("face", [[0, 1, 9], [0, 1, -1], [0, 1.5, 2]])
@pytest.mark.parametrize("form", ["ascii", "binary_little_endian"])
def test_a_face_that_leads_nowhere_costs_itself(
    tmp_path: Path, form: str, face: list[float]
) -> None:
    vertices = ("vertex", PLACES, [list(row) for row in SIX])
    faces = ("face", ["list uchar float vertex_index"], [[face], *([corners] for corners in STRIP)])
    scanned = read_ply(made(tmp_path / "a.ply", form, vertices, faces))
    assert scanned.faces.tolist() == STRIP
    assert "1 of 5 triangles refer to a vertex that is not there" in scanned.notes[0]


@pytest.mark.parametrize("encoding", ["ascii", "binary"])
def test_what_trimesh_writes(tmp_path: Path, encoding: str) -> None:
    mesh = trimesh.Trimesh(VERTICES, FACES, process=False)
    mesh.visual.vertex_colors = np.arange(16, dtype="u1").reshape(4, 4)
    (tmp_path / "t.ply").write_bytes(trimesh.exchange.ply.export_ply(mesh, encoding=encoding))
    scanned = read_ply(tmp_path / "t.ply")
    assert scanned.cloud.points == pytest.approx(VERTICES, abs=1e-6)
    assert (scanned.faces == FACES).all()
    assert (scanned.cloud.colors == mesh.visual.vertex_colors[:, :3]).all()


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian"])
@pytest.mark.parametrize("polygons", [[[0, 1, 2], [0, 2, 3]], [[0, 1, 2, 3], [0, 1, 3]]])
def test_every_cut_is_refused(tmp_path: Path, form: str, polygons: list[list[int]]) -> None:
    whole = written(tmp_path / "whole.ply", form, polygons)
    size = whole.stat().st_size
    cuts_are_refused(read_ply, whole, [*range(0, size - 3, 7), size - 3])


def test_no_byte_that_changes_ends_in_a_traceback(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    for form in ("ascii", "binary_big_endian"):
        whole = written(tmp_path / "whole.ply", form, [[0, 1, 2, 3], [0, 1, 3]])
        hits_are_told(read_ply, whole, rng, 150)


def head(*lines: str) -> bytes:
    return "\n".join(["ply", "format ascii 1.0", *lines, "end_header", ""]).encode()


XYZ = ("property float x", "property float y", "property float z")
SURE = "property float confidence"


def test_blank_lines_count_as_lines(tmp_path: Path) -> None:
    text = head(
        "element vertex 3", *XYZ, SURE, "element face 3", "property list uchar int vertex_index"
    )
    text += b"\n0 0 0 0.5\n\n1 0 0 x\n0 1 0 1\n\n3 0 1 2\n\n3 0 x 2\n3 0 2 1\n"
    (tmp_path / "a.ply").write_bytes(text)
    scanned = read_ply(tmp_path / "a.ply")
    assert [note[note.index("line ") :] for note in scanned.notes] == [
        "line 14, '1 0 0 x'",
        "line 19, '3 0 x 2'",
    ]
    # A damaged line costs no other its confidence.
    assert scanned.cloud.confidence.tolist() == [0.5, 0.0, 1.0]


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"", "empty"),
        (b"PK\x03\x04 not this", "not a PLY file"),
        (b"ply\n" + b"comment long\n" * 9000, "header does not end"),
        (b"ply\n" + b"x" * 200_000, "header does not end"),
        (head("element vertex 1", *XYZ).replace(b"format", b"formt"), "not PLY"),
        (head("element vertex 99999999999", *XYZ), "not a number of elements"),
        (head("element vertex -3", *XYZ), "not a number of elements"),
        (head("element vertex 100000000", *XYZ) + b"0 0 0\n", "ends too early"),
        (
            head("element vertex 2", *XYZ) + b"0 0 0\n0 zero 0\n",
            "not a row of 3 numbers: the first is line 9",
        ),
        (head("element vertex 2", *XYZ) + b"0 0 0\n", "ends too early"),
        (head("element vertex 2", *XYZ) + b"0 0 0 0\n0 0 0 0\n", "not a row of 3 numbers"),
        (head("element vertex 0", *XYZ), "no points"),
        (head("element vertex 1", *XYZ[:2]) + b"0 0\n", "no coordinates"),
        (head(*XYZ), "before the first element"),
        (head("element vertex 1", *XYZ, XYZ[0]) + b"0 0 0 0\n", "repeats the property"),
        (head("element face 0", "property list uchar int vertex_indices"), "no vertices"),
        (head("element vertex 1", *XYZ, "property float label") + b"0 0 0 1.5\n", "whole numbers"),
        (
            head("element vertex 3", *XYZ, "element face 1", "property list uchar int vertex_index")
            + b"0 0 0\n1 0 0\n0 1 0\n3 0 1 9\n",
            "a vertex that is not there",
        ),
    ],
)
def test_nonsense_is_refused(tmp_path: Path, data: bytes, said: str) -> None:
    (tmp_path / "bad.ply").write_bytes(data)
    with pytest.raises(InputError, match=said) as caught:
        read_ply(tmp_path / "bad.ply")
    assert "bad.ply" in str(caught.value)


def test_an_absurd_count_takes_no_memory(tmp_path: Path) -> None:
    for form in ("binary_little_endian", "ascii"):
        lines = f"ply\nformat {form} 1.0\nelement vertex 199999999\n" + "\n".join(XYZ)
        (tmp_path / "b.ply").write_bytes(lines.encode() + b"\nend_header\n" + bytes(1000))
        with pytest.raises(InputError, match="ends too early"):
            read_ply(tmp_path / "b.ply")


def test_labels_that_are_unknown_mean_none(tmp_path: Path) -> None:
    text = head("element vertex 3", *XYZ, "property float label")
    (tmp_path / "l.ply").write_bytes(text + b"0 0 0 nan\n0 0 0 -1\n0 0 0 41\n")
    scanned = read_ply(tmp_path / "l.ply")
    assert scanned.cloud.label.tolist() == [0, 0, 41]
    assert scanned.notes == (f"1 points have labels beyond 40: {OTHER_CLASSES}",)


def test_colours_of_other_types(tmp_path: Path) -> None:
    for kind, row in (("float", "0.5 1 0"), ("ushort", "32896 65535 0"), ("uchar", "128 255 0")):
        rgb = [f"property {kind} {c}" for c in ("red", "green", "blue")]
        (tmp_path / "c.ply").write_bytes(
            head("element vertex 1", *XYZ, *rgb) + f"0 0 0 {row}\n".encode()
        )
        assert read_ply(tmp_path / "c.ply").cloud.colors.tolist() == [[128, 255, 0]]


CORNERS = np.array([[0.0, 0, 0], [2, 0, 0], [0, 3, 0]])


def triangle() -> Cloud:
    return Cloud(CORNERS, label=np.array([1, 2, 3], "i4"), colors=np.eye(3, dtype="u1"))


def test_a_triangle_is_covered_evenly() -> None:
    cloud, notes = as_cloud(triangle(), np.array([[0, 1, 2]]), 0.01)
    samples = cloud.points[3:]
    assert notes == ()
    assert len(samples) == pytest.approx(3.0 / 0.01**2, abs=1)
    assert samples.mean(axis=0) == pytest.approx(CORNERS.mean(axis=0), abs=0.02)
    # Second moments of a uniform triangle about a corner: a^2 / 6 along each leg.
    assert (samples[:, :2] ** 2).mean(axis=0) == pytest.approx([4 / 6, 9 / 6], rel=0.02)
    assert (samples[:, 0] / 2 + samples[:, 1] / 3 <= 1 + 1e-12).all()
    assert (cloud.normals == [0, 0, 1]).all()


def test_samples_are_of_their_nearest_corner() -> None:
    cloud, _ = as_cloud(triangle(), np.array([[0, 1, 2]]), 0.05)
    # Nearest in the triangle's own coordinates, which is a third of its area each.
    assert np.bincount(cloud.label)[1:] / len(cloud) == pytest.approx([1 / 3] * 3, abs=0.05)
    assert (cloud.colors[np.arange(len(cloud)), cloud.label - 1] == 1).all()


def test_a_dense_mesh_stays_nearly_as_it_is() -> None:
    x, y = np.meshgrid(np.arange(50) * 0.01, np.arange(50) * 0.01, indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], -1)
    at = np.arange(2500).reshape(50, 50)
    a, b, c, d = at[:-1, :-1].ravel(), at[1:, :-1].ravel(), at[1:, 1:].ravel(), at[:-1, 1:].ravel()
    faces = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)])
    cloud, _ = as_cloud(Cloud(points), faces, 0.02)
    assert len(cloud) - 2500 == pytest.approx(0.49**2 / 0.02**2, rel=0.15)
    assert cloud.normals[:, 2] == pytest.approx(np.ones(len(cloud)))


def test_an_endless_plane_is_sampled_with_larger_steps() -> None:
    cloud, notes = as_cloud(Cloud(100 * CORNERS), np.array([[0, 1, 2]]), 0.01)
    assert len(cloud) == pytest.approx(2_000_000, rel=0.01)
    assert "12.2 cm apart" in notes[0]


def test_broken_corners_and_lines_give_no_samples() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [np.nan, 1, 0], [1e300, 0, 0]])
    faces = np.array([[0, 1, 2], [0, 1, 3], [0, 1, 4], [0, 0, 0]])
    cloud, _ = as_cloud(Cloud(points), faces)
    assert len(cloud) == len(points)
