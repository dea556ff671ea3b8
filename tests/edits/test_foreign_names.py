"""Sublayers whose names no file system takes are somebody else's, as any other."""

from pathlib import Path

import pytest
from pxr import Sdf

from openrooms_usd.edits.foreign import foreign_to, real_path


@pytest.mark.parametrize("name", ["x\\0y", "a" * 300, "b/" * 2100, "circle.usda"])
def test_a_name_that_leads_nowhere_is_foreign(name: str, tmp_path: Path) -> None:
    (tmp_path / "circle.usda").symlink_to("circle.usda")
    layer = Sdf.Layer.CreateNew(str(tmp_path / "scene.usda"))
    layer.subLayerPaths.append(name.replace("\\0", "\0"))
    assert len(foreign_to(layer, tmp_path).sublayers) == 1


def test_where_a_path_leads(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to("a")
    assert real_path(str(tmp_path / "link")) == str(tmp_path.resolve() / "a")
    assert real_path("x\0y") == ""
