"""A segmentation in a file beside a scan: words, classes and numbers, and what is refused."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from openrooms_usd.errors import InputError
from openrooms_usd.importing import import_capture
from orusd_scans.plainscan import ScanImporter

COUNT = 600


@pytest.fixture
def scan(tmp_path: Path) -> Path:
    """Two cubes of points 2 m apart, as a PLY file."""
    rng = np.random.default_rng(3)
    points = rng.uniform(0, 0.3, (COUNT, 3))
    points[COUNT // 2 :, 0] += 2.0
    rows = "\n".join(" ".join(f"{value:.5f}" for value in row) for row in points)
    head = f"ply\nformat ascii 1.0\nelement vertex {COUNT}\n"
    head += "".join(f"property float {axis}\n" for axis in "xyz")
    path = tmp_path / "scan.ply"
    path.write_text(f"{head}end_header\n{rows}\n")
    return path


def saved(path: Path, **arrays: NDArray[np.generic]) -> Path:
    np.savez_compressed(path, **arrays)  # type: ignore[arg-type]
    return path


def read(scan: Path, segments: Path):  # type: ignore[no-untyped-def]
    cloud = ScanImporter().read(scan, {"segments": str(segments), "unit": "m"}).cloud
    assert cloud is not None
    return cloud


def test_words_alone_make_a_thing_of_each_connected_part(scan: Path, tmp_path: Path) -> None:
    words = np.array(["Guitar"] * COUNT)
    for cloud in (
        read(scan, saved(tmp_path / "words.npz", label=words)),
        read(scan, saved(tmp_path / "bytes.npz", label=words.astype("S"))),
    ):
        assert cloud.words == {1: ("guitar",), 2: ("guitar",)}
        assert cloud.instance.tolist() == [1] * (COUNT // 2) + [2] * (COUNT // 2)
    np.save(tmp_path / "words.npy", words)
    assert read(scan, tmp_path / "words.npy").words == {1: ("guitar",), 2: ("guitar",)}


def test_numbers_are_classes_and_things(scan: Path, tmp_path: Path) -> None:
    instance = np.repeat([4, 0], COUNT // 2)
    label = np.repeat([7, 2], COUNT // 2)
    np.save(tmp_path / "both.npy", np.column_stack([label, instance]))
    for path in (
        saved(tmp_path / "both.npz", label=label.astype("f4"), instance=instance),
        tmp_path / "both.npy",
    ):
        cloud = read(scan, path)
        assert cloud.instance.tolist() == instance.tolist()
        assert cloud.label.tolist() == label.tolist()
    np.save(tmp_path / "things.npy", instance - 1)
    alone = read(scan, tmp_path / "things.npy")
    assert alone.label is None
    assert alone.instance.tolist() == np.repeat([3, 0], COUNT // 2).tolist()


@pytest.mark.parametrize(
    ("name", "arrays", "message"),
    [
        (
            "s.npz",
            {"label": np.zeros(5, "i4")},
            "'label' has 5 values, the scan's file has 600 points",
        ),
        ("s.npz", {"instance": np.zeros((COUNT, 3), "i4")}, "has the shape 600 x 3"),
        ("s.npz", {"instance": np.full(COUNT, 0.5)}, "'instance' has fractions"),
        ("s.npz", {"instance": np.array(["a"] * COUNT)}, "'instance' holds words"),
        ("s.npz", {"instance": np.full(COUNT, 1 << 30)}, "beyond 16,777,216"),
        ("s.npz", {"label": np.full(COUNT, b"\xff")}, "a label is no text"),
        ("s.npz", {"masks": np.zeros(COUNT)}, "no array label or instance"),
        ("s.npz", {"label": np.array([{}] * COUNT)}, "no numbers or words but object"),
        ("s.csv", {}, "files that end in '.csv' are no segments"),
    ],
)
def test_what_does_not_fit_is_refused_with_the_remedy(
    scan: Path, tmp_path: Path, name: str, arrays: dict[str, NDArray[np.generic]], message: str
) -> None:
    path = tmp_path / name
    if arrays:
        saved(path, **arrays)
    else:
        path.write_text("1\n")
    with pytest.raises(InputError) as caught:
        read(scan, path)
    assert message in str(caught.value)
    assert caught.value.remedy


@pytest.mark.usefixtures("any_scan_will_do")
def test_the_file_comes_with_the_room(scan: Path, tmp_path: Path) -> None:
    segments = saved(tmp_path / "mine.npz", label=np.array(["sofa"] * COUNT))
    made = import_capture("scan", scan, tmp_path / "room", {"segments": str(segments), "unit": "m"})
    assert (tmp_path / "room" / "segments.npz").read_bytes() == segments.read_bytes()
    assert made.room.layout.asked["segments"] == "segments.npz"  # type: ignore[union-attr]
    assert not any("nothing says what stands" in note for note in made.notes)


@pytest.mark.usefixtures("any_scan_will_do")
def test_a_scan_that_says_nothing_is_told_so(scan: Path, tmp_path: Path) -> None:
    made = import_capture("scan", scan, tmp_path / "room", {"unit": "m"})
    assert any("nothing says what stands in the scan" in note for note in made.notes)
    assert "unlabelled: furnish" in made.file.read_text()
