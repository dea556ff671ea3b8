"""A small composed room whose edits may be changed."""

import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from pxr import Sdf, Usd

from openrooms_usd.composing import ComposeSummary, compose_room

ROOM = """\
layout:
  openings: [{name: door, kind: door, wall: 0, open: 60}]
furniture:
  objects:
    - {name: sofa, category: sofa, at: [2, 3], yaw: 20}
    - {name: table, category: table, at: [2, 1.5]}
    - {name: chair_a, category: chair, at: [4, 1]}
    - {name: chair_b, category: chair, at: [4, 2]}
    - {name: lamp, category: table_lamp, at: [2, 1.5], on: table}
materials: {resolution: 16}
cameras: {resolution: [16, 12], views: [{name: eye, eye: [1, 1, 1.5], target: [3, 3, 1]}]}
"""


class Place:
    """A composed room in a folder of its own."""

    def __init__(self, folder: Path) -> None:
        self.description = folder / "room.yaml"
        self.out = folder / "out"
        self.scene = self.out / "scene.usda"
        self.edits = self.out / "layers" / "edits.usda"

    def compose(self) -> ComposeSummary:
        return compose_room(self.description, self.out, workers=1)

    def stage(self, path: Path | None = None) -> Usd.Stage:
        stage = Usd.Stage.Open(str(path or self.scene))
        stage.Reload()
        return stage

    @contextmanager
    def saving(self, layer: Path) -> Iterator[Usd.Stage]:
        """The composed stage, edited in one of its layers and saved, as a USD editor does."""
        stage = self.stage()
        stage.SetEditTarget(Sdf.Layer.FindOrOpen(str(layer)))
        yield stage
        stage.GetEditTarget().GetLayer().Save()

    def tree(self) -> dict[str, bytes]:
        files = (path for path in sorted(self.out.rglob("*")) if path.is_file())
        return {path.relative_to(self.out).as_posix(): path.read_bytes() for path in files}

    def write_edits(self, text: str) -> None:
        """Replace what the edits say by USD text."""
        layer = Sdf.Layer.FindOrOpen(str(self.edits))
        head = layer.ExportToString().partition("\n)\n")[0]
        self.edits.write_text(f"{head}\n)\n{text}")


@pytest.fixture(scope="session")
def composed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("edited")
    (folder / "room.yaml").write_text(ROOM)
    Place(folder).compose()
    return folder


@pytest.fixture
def place(composed: Path, tmp_path: Path) -> Place:
    shutil.copytree(composed, tmp_path, dirs_exist_ok=True)
    return Place(tmp_path)


@pytest.fixture
def values() -> Callable[[Usd.Stage], dict[str, object]]:
    """Every value that a stage shows, by property path; instances included."""

    def read(stage: Usd.Stage) -> dict[str, object]:
        found: dict[str, object] = {}
        for prim in Usd.PrimRange(stage.GetPseudoRoot(), Usd.TraverseInstanceProxies()):
            for attribute in prim.GetAuthoredAttributes():
                value = attribute.Get()
                asset = isinstance(value, Sdf.AssetPath)
                found[str(attribute.GetPath())] = value.resolvedPath if asset else value
        return found

    return read
