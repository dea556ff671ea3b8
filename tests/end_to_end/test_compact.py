"""A render in compact storage serves all that a complete one serves."""

import json
from pathlib import Path

import numpy as np
import OpenImageIO
import pytest

from tests.commands import output_of

pytestmark = pytest.mark.slow

STORAGES = ("complete", "compact")
# Of pictures and of what is made of them; hemispheres are noisy at so few samples, and lose more.
MEAN_ERROR = {"im": 0.04, "imenv": 0.15}


def picture(path: Path) -> np.ndarray:
    """As the file has it, without our own reader."""
    return np.asarray(OpenImageIO.ImageBuf(str(path)).get_pixels(), np.float64)


@pytest.fixture(scope="module")
def home(vectorized: str, demo: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("storage")
    for storage in ("complete", "compact"):
        output_of(
            "render",
            demo,
            "-o",
            folder / storage,
            *"--camera dining --resolution 40x32 --grid 10x8 --spp 8 --channels all".split(),
            *"--variant llvm --storage".split(),
            storage,
        )
    return folder


def test_the_manifests_agree_but_for_the_files(home: Path) -> None:
    one, other = (json.loads((home / s / "manifest.json").read_text()) for s in STORAGES)
    assert (one.pop("storage"), other.pop("storage")) == STORAGES
    assert one.pop("views").keys() == other.pop("views").keys()
    assert one == other


def test_relit_pictures_agree(home: Path, tmp_path: Path) -> None:
    light = json.loads((home / "compact/manifest.json").read_text())["lights"][0]["name"]
    relit = []
    for storage in STORAGES:
        output_of("relight", home / storage, "-o", tmp_path / storage, "--light", f"{light}=0.5")
        relit.append(picture(tmp_path / storage / "radiance.exr"))
    assert np.abs(relit[1] - relit[0]).mean() < MEAN_ERROR["im"] * relit[0].mean()


def test_annotations_are_the_same(home: Path, tmp_path: Path) -> None:
    found = []
    for storage in STORAGES:
        output_of("labels", home / storage, "-o", tmp_path / f"{storage}.json")
        found.append(json.loads((tmp_path / f"{storage}.json").read_text()))
    assert found[0] == found[1] and found[0]["annotations"]


@pytest.mark.parametrize("kind", ["openrooms", "nerf"])
def test_foreign_forms_have_the_same_files(home: Path, kind: str, tmp_path: Path) -> None:
    for storage in STORAGES:
        output_of("dataset", "write", home / storage, "-o", tmp_path / storage, "--format", kind)
    trees = [
        {p.relative_to(tmp_path / s): p for p in (tmp_path / s).rglob("*") if p.is_file()}
        for s in STORAGES
    ]
    assert trees[0].keys() == trees[1].keys()
    exact = [path for path in trees[0] if path.suffix in (".npy", ".dat") and "im" in path.name]
    for path in exact:
        assert trees[0][path].read_bytes() == trees[1][path].read_bytes(), path
    for path in trees[0]:
        if path.suffix in (".hdr", ".rgbe"):
            one, other = (picture(tree[path]) for tree in trees)
            allowed = MEAN_ERROR["imenv" if path.name.startswith("imenv") else "im"]
            assert np.abs(one - other).mean() <= allowed * one.mean() + 1e-6, path
