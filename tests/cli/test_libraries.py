"""``orusd library``: the list says what can be built, the sheet shows it and nothing else."""

import json
from pathlib import Path

import numpy as np
import OpenImageIO
import pytest

from openrooms_usd.errors import InputError, OutputError
from openrooms_usd.furniture import CATEGORIES
from openrooms_usd.rendering.sheet import write_sheet
from openrooms_usd.showroom import exhibits
from tests.commands import output_of

QUICK = ("--variant", "scalar", "--size", "24", "--spp", "1")


def pixels(path: Path) -> np.ndarray:
    return np.asarray(OpenImageIO.ImageBuf(str(path)).get_pixels(OpenImageIO.UINT8))


def test_the_list_for_people_and_programs() -> None:
    said = json.loads(output_of("library", "list", "--json"))
    assert list(said) == sorted(CATEGORIES)
    assert all(row["styles"] == list(CATEGORIES[name].styles) for name, row in said.items())
    rows = [line.split()[0] for line in output_of("library", "list").splitlines()]
    assert rows == list(said)


def test_what_is_shown() -> None:
    assert [item.category for item in exhibits()] == sorted(CATEGORIES)
    every = exhibits(["table", "chair", "chair"], every_style=True)
    expected = [(name, style) for name in ("chair", "table") for style in CATEGORIES[name].styles]
    assert [(item.category, item.style) for item in every] == expected
    assert len({item.name for item in exhibits(every_style=True)}) == sum(
        len(spec.styles) for spec in CATEGORIES.values()
    )


@pytest.mark.slow
def test_a_small_sheet(tmp_path: Path) -> None:
    words = ["library", "sheet", "--category", "ceiling_lamp", "--category", "table"]
    words += ["--all", *QUICK]
    names = ("ceiling_lamp", "table")
    first, second = tmp_path / "first.png", tmp_path / "second.png"
    said = json.loads(output_of(*words, "-o", first, "--json"))
    shown = [tuple(row) for row in said["shown"]]
    assert shown == [(name, style) for name in names for style in CATEGORIES[name].styles]
    assert f"{len(shown)} objects" in output_of(*words, "-o", second)
    assert first.read_bytes() == second.read_bytes()
    # Pictures side by side with gaps of 6; lamps are rendered last and yet stand first.
    cells = {row: pixels(first)[6:30, 6 + 30 * i : 30 + 30 * i] for i, row in enumerate(shown[:10])}
    assert all(cell.std() > 2 for cell in cells.values())
    middle = {row: cell[8:16, 8:16].mean() for row, cell in cells.items()}
    assert max(middle, key=middle.__getitem__) == ("ceiling_lamp", "globe")
    pictures = {path.name for path in tmp_path.glob("[!.]*")}
    assert pictures == {"first.png", "second.png"}


def test_the_caption_is_below(tmp_path: Path) -> None:
    grey = np.full((20, 90, 3), 200, np.uint8)
    for below in (False, True):
        write_sheet(tmp_path / "sheet.png", [[("one\ntwo\nthree", grey)]], below=below)
        sheet = pixels(tmp_path / "sheet.png")
        top = int(np.argmax((sheet[:, 8:90] == 200).all(axis=(1, 2))))
        assert (sheet[top : top + 20, 6:96] == 200).all()
        assert (top < 10) == below


def test_a_wide_sheet_is_reduced(tmp_path: Path) -> None:
    grey = np.full((40, 90, 3), 200, np.uint8)
    sizes = {}
    for widest in (None, 99, 1000):
        write_sheet(tmp_path / "sheet.png", [[("one", grey), ("two", grey)]], widest=widest)
        sizes[widest] = pixels(tmp_path / "sheet.png").shape
    high, wide, _ = sizes[None]
    assert wide == 198 and sizes[1000] == sizes[None]
    assert sizes[99] == (round(high / 2), 99, 3)


def test_refusals(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match="did you mean 'chair'"):
        output_of("library", "sheet", "-o", tmp_path / "x.png", "--category", "chiar")
    (tmp_path / "file").write_text("")
    # Before anything is composed or rendered.
    monkeypatch.delattr("openrooms_usd.showroom.studio.build")
    with pytest.raises(OutputError):
        output_of(
            "library", "sheet", "-o", tmp_path / "file" / "x.png", "--category", "box", *QUICK
        )
    assert {path.name for path in tmp_path.iterdir()} == {"file"}
