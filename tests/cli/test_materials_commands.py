"""``orusd materials``: the list says what there is, the sheets show it."""

import json
from pathlib import Path

import numpy as np
import OpenImageIO
import pytest

from openrooms_usd.library import textures
from tests.commands import output_of, run

QUICK = ("--variant", "scalar", "--size", "16", "--spp", "1")


def test_the_list_for_people_and_programs() -> None:
    said = json.loads(output_of("materials", "list", "--json"))
    assert {kind: set(names) for kind, names in said.items()} == {
        kind: set(names) for kind, names in textures.FAMILIES.items()
    }
    denim = textures.family_of("denim")
    assert said["fabric"]["denim"] == {
        "size": denim.size,
        "uses": sorted(denim.uses),
        "grain": denim.grain,
        "metallic": 0.0,
    }
    lines = output_of("materials", "list").splitlines()
    assert len(lines) == len(said) + sum(len(names) for names in said.values())


def test_a_small_sheet(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    few = {"leather": ("nappa", "suede"), "metal": ("rusted_iron",)}
    shown = {kind: {name: textures.family_of(name) for name in few[kind]} for kind in few}
    monkeypatch.setattr("openrooms_usd.showroom.materialsheet.FAMILIES", shown)
    words = ["materials", "sheet", *QUICK]
    said = json.loads(output_of(*words, "-o", tmp_path / "a", "--json"))
    assert [Path(file).name for file in said["files"]] == ["leather.png", "metal.png"]
    assert "wrote 1 pictures" in output_of(*words, "-o", tmp_path / "b", "--substance", "metal")
    one, two = (tmp_path / side / "metal.png" for side in "ab")
    assert one.read_bytes() == two.read_bytes()
    picture = np.asarray(OpenImageIO.ImageBuf(str(one)).get_pixels(OpenImageIO.UINT8))
    assert picture[6:22, 6:22].std() > 3.0


def test_what_is_wrong_is_said(tmp_path: Path) -> None:
    result = run("materials", "sheet", "-o", tmp_path, "--substance", "glass")
    assert result.exit_code == 2 and "glass" in result.output
