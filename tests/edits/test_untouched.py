"""No command but ``edit import-changes`` and ``fix-units`` writes the layer of the edits."""

from typing import Any

import pytest
from pxr import Sdf, UsdGeom

from tests.commands import output_of

EMPTY = """\
#usda 1.0
(
    customLayerData = {
        string creator = "openrooms_usd"
    }
    defaultPrim = "World"
    kilogramsPerUnit = 1
    metersPerUnit = 1
    upAxis = "Z"
)

"""


@pytest.mark.slow
def test_bytes_and_time_stay_over_all_commands(place: Any) -> None:
    assert place.edits.read_text() == EMPTY
    with place.saving(place.edits) as stage:
        sofa = stage.GetPrimAtPath("/World/Furniture/sofa")
        UsdGeom.XformCommonAPI(sofa).SetTranslate((1.0, 3.0, 0.0))
    # Comments and spaces are a person's too.
    place.edits.write_text(place.edits.read_text() + "\n# mine\n\n")
    before = place.edits.read_bytes(), place.edits.stat().st_mtime_ns
    compose = ("compose", place.description, "-o", place.out)
    for words in (
        compose,
        (*compose, "--flatten", "--usdz"),
        (*compose, "--only", "furniture"),
        ("validate", place.scene),
        ("edit", "orphans", place.out),
        ("edit", "fix-units", place.out),
        ("edit", "import-changes", place.scene),
        ("render", place.scene, "-o", place.out / "pictures", "--spp", 1),
    ):
        output_of(*words)
        assert (place.edits.read_bytes(), place.edits.stat().st_mtime_ns) == before, words
    place.description.write_text("seed: 9\n" + place.description.read_text())
    output_of(*compose)
    assert (place.edits.read_bytes(), place.edits.stat().st_mtime_ns) == before
    layer = Sdf.Layer.OpenAsAnonymous(str(place.scene))
    assert layer.subLayerPaths[0] == "./layers/edits.usda"
