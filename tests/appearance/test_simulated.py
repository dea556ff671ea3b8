"""A furnished room photographed by another renderer, with the truth of every part and camera."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.appearance.driver import write_appearance
from openrooms_usd.colorimetry import luminance
from openrooms_usd.composing import compose_room

KIT = "photographs/simulated/dev/room_1_simple"


@pytest.mark.slow
def test_a_furnished_room_is_found(real: Callable[[str], Path], tmp_path: Path) -> None:
    kit = real(KIT)
    stage = compose_room(kit / "room.yaml", tmp_path / "out").scene
    report = write_appearance(stage, kit / "frames.json", tmp_path / "looks.usda")
    shown = [part for part in report["parts"] if part["places"]]
    told = {part["path"]: np.array(part["base_color"]) for part in shown}
    parts = json.loads((kit / "truth/materials.json").read_text())["parts"].values()
    known = {path: np.array(part["base_color"]) for part in parts for path in part["paths"]}
    both = sorted(told.keys() & known.keys())
    assert len(both) > 30
    found, true = (np.array([some[path] for path in both]) for some in (told, known))
    found = found * np.median(luminance(true) / luminance(found))
    assert np.abs(found - true).mean() <= 0.03
    taken = json.loads((kit / "truth/photographs.json").read_text())["photographs"]
    exposure = {one["id"]: one["exposure_per_nit"] for one in taken}
    stops = np.log2([one["exposure"] / exposure[one["id"]] for one in report["photographs"]])
    assert np.abs(stops - np.median(stops)).max() <= 0.1
