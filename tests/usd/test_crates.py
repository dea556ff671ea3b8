"""What a binary USD file announces is weighed before USD takes memory for it."""

import io
import struct
from pathlib import Path

import pytest
from pxr import Usd, UsdGeom, Vt

from openrooms_usd.errors import InputError
from openrooms_usd.usd.crate_reader import check_crate


def crate(path: Path, points: int) -> bytes:
    """A mesh of equal points, which pack as well as anything."""
    stage = Usd.Stage.CreateNew(str(path))
    for name in ("A", "B" * 3000):
        mesh = UsdGeom.Mesh.Define(stage, f"/{name}")
        mesh.CreatePointsAttr(Vt.Vec3fArray(points))
        mesh.CreateFaceVertexIndicesAttr(Vt.IntArray(points))
    for number in range(points):
        stage.DefinePrim(f"/P/P{number}", "Xform").SetDocumentation("same")
    stage.Save()
    return path.read_bytes()


def check(data: bytes) -> None:
    check_crate(io.BytesIO(data), len(data), "a.usdc")


@pytest.mark.one_in(9)
@pytest.mark.parametrize("points", [0, 1, 5000])
def test_what_usd_writes_passes(tmp_path: Path, points: int) -> None:
    check(crate(tmp_path / "a.usdc", points))


@pytest.mark.parametrize("name", ["TOKENS", "STRINGS", "FIELDS", "FIELDSETS", "PATHS", "SPECS"])
def test_what_no_section_can_hold_is_refused(tmp_path: Path, name: str) -> None:
    data = bytearray(crate(tmp_path / "a.usdc", 2))
    entry = data.rindex(name.encode().ljust(16, b"\0"))
    (start,) = struct.unpack_from("<q", data, entry + 16)
    struct.pack_into("<Q", data, start, 1 << 30)
    with pytest.raises(InputError, match=f"section {name} announces 1,073,741,824 entries"):
        check(bytes(data))
    struct.pack_into("<q", data, entry + 16, len(data))
    with pytest.raises(InputError, match="outside the file"):
        check(bytes(data))


@pytest.mark.parametrize("length", [8, 20, 60])
def test_what_is_cut_off_is_refused(tmp_path: Path, length: int) -> None:
    data = crate(tmp_path / "a.usdc", 2)
    with pytest.raises(InputError, match="not a readable USD file"):
        check(data[:length])
    check(b"#usda 1.0\n")
