"""The folder of layers, the flattened layer and the package give the same pictures."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd

from openrooms_usd.channels import WRITTEN
from openrooms_usd.composing import compose_room


@pytest.mark.slow
def test_layered_flattened_and_packaged_are_one_picture(
    composed_demo: Path, tmp_path: Path, show, variant: str
) -> None:
    room = tmp_path / "room"
    shutil.copytree(composed_demo.parents[1], room)
    summary = compose_room(room / "room.yaml", room / "out", flatten=True, usdz=True)
    assert summary.unchanged, "what is up to date is not made again elsewhere"
    flat, packed = summary.files
    assert (flat.suffix, packed.suffix) == (".usdc", ".usdz")
    # The package stands alone, far from the folder that it was made from.
    alone = tmp_path / "alone"
    alone.mkdir()
    packed = packed.replace(alone / "room.usdz")
    # And so does the flattened scene without the layers' texts.
    for text in (summary.scene, *summary.scene.parent.glob("layers/*.usda")):
        shutil.move(text, alone)
    how = {"resolution": (48, 36), "options": {"variant": variant}}
    flattened = show(flat, "flattened", **how)
    packaged = show(packed, "packaged", **how)
    layered = show(composed_demo, "layered", **how)

    assert len(layered.views) == 3
    for view in layered.views:
        image = layered[view]
        assert set(image) == set(WRITTEN)
        assert image["radiance"].max() > 0 and len(np.unique(image["part"])) > 5
        assert len(np.unique(image["base_color"])) > 50, "textures are seen"
        for name in WRITTEN:
            assert np.array_equal(flattened[view][name], image[name]), (view, name)
            assert np.array_equal(packaged[view][name], image[name]), (view, name)
    for other in (flattened, packaged):
        assert {k: v for k, v in other.manifest.items() if k != "stage"} == {
            k: v for k, v in layered.manifest.items() if k != "stage"
        }


def first_camera(scene: Path) -> list[str]:
    stage = Usd.Stage.Open(str(scene))
    return [str(stage.GetPrimAtPath("/World/Cameras").GetChildren()[0].GetPath())]


@pytest.mark.slow
@pytest.mark.one_in(2, rest="long")
def test_every_room_is_the_same_in_one_file(room: Path, tmp_path: Path, show, fastest) -> None:
    home = tmp_path / "room"
    shutil.copytree(room.parent, home)
    summary = compose_room(home / "source" / "room.yaml", home, flatten=True, usdz=True)
    assert summary.unchanged
    how = {
        "resolution": (32, 24),
        "options": {"variant": fastest},
        "cameras": first_camera(summary.scene),
    }
    layered = show(summary.scene, "layered", **how)
    others = [show(file, file.suffix[1:], **how) for file in summary.files]
    for view in layered.views:
        for other in others:
            for name in WRITTEN:
                assert np.array_equal(other[view][name], layered[view][name]), (view, name)
