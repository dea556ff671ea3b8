"""A real phone capture goes the whole way by the command line."""

import json
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd

from openrooms_usd.channels import WRITTEN
from tests.commands import output_of


@pytest.mark.slow
def test_a_capture_becomes_pictures(tmp_path: Path, fastest: str, cast, opened, real) -> None:
    source = real("roomplan_libroom/Room.json")
    room, out, pictures = (tmp_path / name for name in ("room", "out", "pictures"))
    output_of("import", "roomplan", source, "-o", room)
    output_of("compose", room / "room.yaml", "-o", out)
    # Its table was captured 7 cm beyond a wall, and is moved inside.
    assert json.loads(output_of("validate", "--json", out / "scene.usda"))["findings"] == []
    said = output_of(
        "render",
        out / "scene.usda",
        "-o",
        pictures,
        *"--resolution 32x24 --spp 2 --variant".split(),
        fastest,
        "--json",
    )
    manifest = json.loads((pictures / "manifest.json").read_text())
    assert json.loads(said)["manifest"] == manifest
    assert set(manifest["channels"]) == set(WRITTEN)
    assert manifest["report"]["approximated"] == 0
    captured = json.loads(source.read_text())
    categories = list(manifest["legend"]["category"].values())
    assert categories.count("wall") == len(captured["floors"][0]["polygonCorners"]) == 7
    furniture = [name for name in manifest["legend"]["instance"].values() if "Furniture" in name]
    assert len(furniture) >= len(captured["objects"]) == 3

    shown, stage = opened(pictures), Usd.Stage.Open(str(out / "scene.usda"))
    for view, entry in manifest["views"].items():
        image = shown[view]
        assert set(image) == set(WRITTEN)
        assert all(np.isfinite(pixels).all() for pixels in image.values())
        assert np.median(image["radiance"]) > 0
        seen = cast(stage, entry["camera"], 32, 24)
        assert np.array_equal(image["valid"][..., 0] == 1, seen.hit)
        near = np.abs(image["distance"][..., 0] - seen.distance) < 1e-4
        assert near[seen.hit].mean() > 0.998
