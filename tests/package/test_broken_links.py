"""Links that lead nowhere, where the layers and assets of a room should be."""

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from openrooms_usd.errors import OrusdError
from openrooms_usd.package import flatten, package
from openrooms_usd.usd.diagnostics import quiet


@pytest.mark.parametrize("target", ["edits.usda", "nowhere", "/dev/zero"])
@pytest.mark.parametrize(("write", "ending"), [(package, "usdz"), (flatten, "usdc")])
def test_a_layer_that_is_a_broken_link_is_refused_at_most(
    write: Callable[[Path, Path], object],
    ending: str,
    target: str,
    composed_demo: Path,
    tmp_path: Path,
) -> None:
    shutil.copytree(composed_demo.parent, tmp_path / "room")
    edits = tmp_path / "room/layers/edits.usda"
    edits.unlink()
    edits.symlink_to(target)
    made = tmp_path / f"made.{ending}"
    try:
        with quiet():
            write(tmp_path / "room/scene.usda", made)
    except OrusdError as error:
        assert "edits" in str(error)
        assert not made.exists()
