"""Sound point clouds and meshes in every format that the scan importer reads."""

import struct
from pathlib import Path
from typing import Any

import numpy as np

from tests.fuzz.captures import COMPOSED, write_frames
from tests.fuzz.kinds import Kind, planting
from tests.fuzz.models import write_glbs
from tests.scans.laser import write_e57, write_las

Points = np.ndarray


def _points() -> Points:
    """(N, 3) a floor and two walls."""
    x, y = np.meshgrid(np.arange(0, 4, 0.25), np.arange(0, 3, 0.25), indexing="ij")
    floor = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], -1)
    wall = np.column_stack([floor[:, 0], np.zeros(len(floor)), 0.8 * floor[:, 1]])
    return np.concatenate([floor, wall, wall[:, [1, 0, 2]]])


def _room(step: float = 0.06) -> Points:
    """(N, 3) floor, ceiling and walls of 4 x 3 x 2.5 m."""

    def sheet(origin: list[float], u: list[float], v: list[float]) -> Points:
        a, b = (np.arange(0, 1, step / np.linalg.norm(axis)) for axis in (u, v))
        steps = np.stack([g.ravel() for g in np.meshgrid(a, b)], -1)
        return np.asarray(origin) + steps @ np.array([u, v])

    x, y, z = [4.0, 0, 0], [0, 3.0, 0], [0, 0, 2.5]
    sheets = ([0, 0, 0], x, y), (z, x, y), ([0, 0, 0], x, z), (y, x, z)
    return np.concatenate([*(sheet(*s) for s in sheets), sheet([0, 0, 0], y, z), sheet(x, y, z)])


def _ply(folder: Path) -> None:
    points = _points().astype("<f4")
    n = len(points)
    fields = "".join(f"property float {a}\n" for a in "xyz")
    colors = "".join(f"property uchar {a}\n" for a in ("red", "green", "blue"))
    ids = "property ushort label\nproperty int instance\n"
    faces = "element face 2\nproperty list uchar int vertex_indices\n"
    head = f"element vertex {n}\n{fields}{colors}{ids}"
    rows = np.zeros(n, [("p", "<f4", 3), ("c", "u1", 3), ("l", "<u2"), ("i", "<i4")])
    rows["p"], rows["c"], rows["l"], rows["i"] = points, 128, 5, 1
    quads = struct.pack("<B3iB4i", 3, 0, 1, 2, 4, 0, 1, 2, 3)
    (folder / "binary.ply").write_bytes(
        f"ply\nformat binary_little_endian 1.0\n{head}{faces}end_header\n".encode()
        + rows.tobytes()
        + quads
    )
    big = rows.astype([("p", ">f4", 3), ("c", "u1", 3), ("l", ">u2"), ("i", ">i4")])
    (folder / "big.ply").write_bytes(
        f"ply\nformat binary_big_endian 1.0\n{head}end_header\n".encode() + big.tobytes()
    )
    lines = [f"{x:.3f} {y:.3f} {z:.3f} 9 9 9 5 1" for x, y, z in points]
    (folder / "text.ply").write_text(
        f"ply\nformat ascii 1.0\ncomment x\n{head}{faces}end_header\n"
        + "\n".join([*lines, "3 0 1 2", "4 0 1 2 3", ""])
    )


def _pcd_head(n: int, data: str) -> bytes:
    return (
        "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z rgb label\nSIZE 4 4 4 4 4\nTYPE F F F U U\n"
        f"COUNT 1 1 1 1 1\nWIDTH {n}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {n}\nDATA {data}\n"
    ).encode()


def _lzf(data: bytes) -> bytes:
    """Literal runs only."""
    runs = (data[i : i + 32] for i in range(0, len(data), 32))
    return b"".join(bytes([len(run) - 1]) + run for run in runs)


def _pcd(folder: Path) -> None:
    points = _points().astype("<f4")
    n = len(points)
    rows = np.zeros(n, [("p", "<f4", 3), ("c", "<u4"), ("l", "<u4")])
    rows["p"], rows["c"], rows["l"] = points, 0x102030, 5
    (folder / "binary.pcd").write_bytes(_pcd_head(n, "binary") + rows.tobytes())
    lines = "\n".join(f"{x:.3f} {y:.3f} {z:.3f} 1056816 5" for x, y, z in points)
    (folder / "text.pcd").write_bytes(_pcd_head(n, "ascii") + lines.encode() + b"\n")
    columns = points.T.tobytes() + rows["c"].tobytes() + rows["l"].tobytes()
    packed = _lzf(columns)
    (folder / "packed.pcd").write_bytes(
        _pcd_head(n, "binary_compressed") + struct.pack("<II", len(packed), len(columns)) + packed
    )


def _text(folder: Path) -> None:
    points = _points()
    rows = [f"{x:.3f} {y:.3f} {z:.3f}" for x, y, z in points]
    (folder / "a.xyz").write_text("\n".join(rows) + "\n")
    (folder / "a.asc").write_text("\n".join(f"{row} 9 9 9" for row in rows) + "\n")
    (folder / "a.txt").write_text("# x y z r g b\n" + "\n".join(f"{r} 1 2 3" for r in rows) + "\n")
    (folder / "a.pts").write_text(
        f"{len(rows)}\n" + "\n".join(f"{row} 100 1 2 3" for row in rows) + "\n"
    )
    (folder / "a.csv").write_text(
        "x,y,z,label,instance\n" + "\n".join(r.replace(" ", ",") + ",5,1" for r in rows) + "\n"
    )


def _npz(folder: Path) -> None:
    points = _points()
    n = len(points)
    np.savez(folder / "a.npz", points=points, colors=np.full((n, 3), 99, np.uint8))
    np.savez(
        folder / "b.npz",
        points=points.astype("f4"),
        instance=np.ones(n, np.int32),
        label=np.full(n, 5, np.int16),
        normals=np.tile([0, 0, 1.0], (n, 1)),
    )


def _meshes(folder: Path) -> None:
    import trimesh

    box = trimesh.creation.box((1.0, 2.0, 3.0))
    for ending in ("stl", "off", "obj"):
        made: Any = box.export(file_type=ending)
        (folder / f"a.{ending}").write_bytes(made.encode() if isinstance(made, str) else made)
    (folder / "text.stl").write_text(box.export(file_type="stl_ascii"))
    (folder / "b.obj").write_text(
        "o a\nv 0 0 0 1 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n"
        "f 1/1/1 2/1/1 3/1/1 4/1/1\nf -1 -2 -3\nl 1 2\np 1\n"
    )


def _las(folder: Path) -> None:
    for ending in ("las", "laz"):
        red = np.arange(len(_points())) * 37
        write_las(folder / f"a.{ending}", _points() + np.array([4e5, 5e6, 0]), red=red)


def _e57(folder: Path) -> None:
    write_e57(folder / "a.e57", _points()[::4], translation=[1.0, 2, 3])


def _reading(*files: str) -> tuple[tuple[int, str], ...]:
    return tuple((1, f"import scan {{in}}/{file} -o {{out}}") for file in files)


def _whole(folder: Path) -> None:
    _ply(folder)
    write_frames(folder / "frames.json")
    np.savez(folder / "room.npz", points=_room())
    sections = "layout: {from: scan, scan: room.npz}\nfurniture: {from: scan}\n"
    (folder / "room.yaml").write_text(COMPOSED.format(sections))


KINDS = (
    Kind("points.ply", planting(_ply), _reading("binary.ply", "big.ply", "text.ply"), share=4),
    Kind("points.pcd", planting(_pcd), _reading("binary.pcd", "text.pcd", "packed.pcd"), share=4),
    Kind(
        "points.text",
        planting(_text),
        _reading("a.xyz", "a.asc", "a.txt", "a.pts", "a.csv"),
        share=4,
    ),
    Kind("points.npz", planting(_npz), _reading("a.npz", "b.npz"), share=4),
    Kind(
        "points.mesh",
        planting(_meshes),
        _reading("a.stl", "text.stl", "a.off", "a.obj", "b.obj"),
        share=4,
    ),
    Kind(
        "points.glb",
        planting(write_glbs),
        _reading("plain.glb", "textured.glb", "basisu.glb"),
        ("in/*.glb",),
        share=3,
    ),
    Kind(
        "points.draco", planting(write_glbs), _reading("draco.glb"), ("in/draco.glb",), ("DracoPy",)
    ),
    Kind("points.las", planting(_las), _reading("a.las"), ("in/a.las",), ("laspy",)),
    Kind("points.laz", planting(_las), _reading("a.laz"), ("in/a.laz",), ("laspy", "lazrs")),
    Kind("points.e57", planting(_e57), _reading("a.e57"), needs=("pye57",), share=3),
    Kind(
        "points.frames",
        planting(_whole),
        ((1, "import scan {in}/text.ply -o {out} --frames {in}/frames.json"),),
        ("in/frames.json",),
    ),
    Kind(
        "points.composed",
        planting(_whole),
        ((9, "import scan {in}/room.npz -o {out}"), (1, "compose {in}/room.yaml -o {out}")),
        ("in/room.npz",),
        share=1,
    ),
)
