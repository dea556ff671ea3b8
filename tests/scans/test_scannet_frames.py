"""ScanNet's poses: from an exported folder and from a .sens file, with lost ones left out."""

import struct
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.errors import InputError
from orusd_scans.scannet.frames import read_scannet_frames
from tests.scans.damage import cuts_are_refused

K = np.array([[1170.5, 0, 647.25, 0], [0, 1170.5, 483.5, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
SIZE = (1296, 968)


def poses() -> list[np.ndarray]:
    found = []
    for i in range(5):
        M = np.eye(4)
        c, s = np.cos(0.3 * i), np.sin(0.3 * i)
        M[:3, :3] = [[c, 0, s], [s, 0, -c], [0, 1, 0]]
        M[:3, 3] = [i, 2.0, 1.5]
        found.append(M)
    found[2][:] = -np.inf
    return found


def export(folder: Path) -> Path:
    for name in ("pose", "intrinsic", "color"):
        (folder / name).mkdir(parents=True)
    np.savetxt(folder / "intrinsic/intrinsic_color.txt", K)
    for i, pose in enumerate(poses()):
        np.savetxt(folder / f"pose/{i}.txt", pose)
    (folder / f"{folder.name}.txt").write_text(
        "colorHeight = 968\ncolorWidth = 1296\nsceneType = x\n"
    )
    return folder


def sens(path: Path, version: int = 4, count: int | None = None, blob: int = 1000) -> Path:
    name = b"StructureSensor"
    out = [struct.pack("<IQ", version, len(name)), name]
    out += [K.astype("<f4").tobytes(), *[np.eye(4, dtype="<f4").tobytes()] * 3]
    out.append(struct.pack("<2i4If", 2, 1, *SIZE, 640, 480, 1000.0))
    out.append(struct.pack("<Q", len(poses()) if count is None else count))
    for i, pose in enumerate(poses()):
        out.append(pose.astype("<f4").tobytes())
        out.append(struct.pack("<4Q", i, i, blob, 7) + b"\xff" * 1007)
    path.write_bytes(b"".join(out))
    return path


def check(frames: tuple, tolerance: float) -> None:
    assert [frame.id for frame in frames] == ["0", "1", "3", "4"]
    for frame in frames:
        expected = poses()[int(frame.id)]
        assert frame.world_from_camera == pytest.approx(expected, abs=tolerance)
        assert frame.resolution == SIZE
        # ScanNet counts from the centre of the first pixel.
        assert frame.K[:2, 2] == pytest.approx([647.75, 484.0], abs=1e-3)
        assert frame.K[0, 0] == pytest.approx(1170.5)


def test_an_exported_folder(tmp_path: Path) -> None:
    folder, notes = export(tmp_path / "scene0000_00"), list[str]()
    check(read_scannet_frames(folder, notes), 1e-9)
    assert notes == ["1 of 5 frames have no pose: they were left out"]


def test_pictures_give_their_names_and_their_size(tmp_path: Path) -> None:
    import OpenImageIO

    folder = export(tmp_path / "scene0000_00")
    (folder / "scene0000_00.txt").unlink()
    image = OpenImageIO.ImageBuf(OpenImageIO.ImageSpec(64, 48, 3, "uint8"))
    for i in (0, 10):
        image.write(str(folder / f"color/{i}.jpg"))
    frames = read_scannet_frames(folder, [])
    assert frames[0].resolution == (64, 48)
    assert [frame.picture for frame in frames] == ["color/0.jpg", None, None, None]


def test_a_sens_file_and_the_folder_that_holds_it(tmp_path: Path) -> None:
    notes: list[str] = []
    check(read_scannet_frames(sens(tmp_path / "scene0000_00.sens"), notes), 1e-6)
    check(read_scannet_frames(tmp_path, []), 1e-6)
    assert notes == ["1 of 5 frames have no pose: they were left out"]


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"version": 5}, "its version is 5, not 4"),
        ({"count": 6}, "it ends too early"),
        ({"count": 2**60}, "frames"),
        ({"blob": 2**50}, "a length in it is wrong"),
    ],
)
def test_a_sens_file_that_lies_is_refused(tmp_path: Path, more: dict, said: str) -> None:
    with pytest.raises(InputError, match=said):
        read_scannet_frames(sens(tmp_path / "bad.sens", **more), [])


def test_every_cut_of_a_sens_file_is_refused(tmp_path: Path) -> None:
    whole = sens(tmp_path / "whole.sens")
    lengths = (0, 3, 11, 40, 282, 300, 400, whole.stat().st_size - 1)
    cuts_are_refused(lambda path: read_scannet_frames(path, []), whole, lengths)


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("pose/1.txt", "1 2 3", "no 4 x 4 matrix"),
        ("pose/1.txt", "1 0 0 0 0 1 0 0 0 0 -1 0 0 0 0 1", "left-handed"),
        ("pose/1.txt", "2 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1", "scales or shears"),
        ("pose/1.txt", "1 0 0 0 0 1 0 0 0 0 1 0 5 6 7 1", "translation is in the last row"),
        ("intrinsic/intrinsic_color.txt", "0 " * 16, "intrinsics"),
        ("scene0000_00.txt", "sceneType = x", "size of the colour pictures"),
    ],
)
def test_nonsense_in_a_folder_is_refused(tmp_path, name, text, said) -> None:
    folder = export(tmp_path / "scene0000_00")
    (folder / name).write_text(text)
    with pytest.raises(InputError, match=said):
        read_scannet_frames(folder, [])


def test_names_with_zeros_before_and_other_digits_are_read(tmp_path: Path) -> None:
    folder = export(tmp_path / "scene0000_00")
    for path in folder.glob("pose/*.txt"):
        path.rename(path.with_name(f"{int(path.stem):06d}.txt"))
    (folder / "pose/\u00b2.txt").write_text("a superscript is no number")
    check(read_scannet_frames(folder, []), 1e-9)


def test_what_holds_no_frames_is_refused(tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / "none.sens", tmp_path / "frames.txt"):
        with pytest.raises(InputError):
            read_scannet_frames(path, [])
