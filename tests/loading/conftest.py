"""Small real renders: all that transforms change, and the same camera finer."""

import importlib
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from benchmarks.scenes import SMALL_ROOM
from openrooms_usd.loading.opening import open_source
from openrooms_usd.loading.sample import Sample
from tests.commands import output_of

CHANNELS = tuple(
    (
        "radiance irradiance depth distance position normal normal_geometric normal_camera"
        " base_color semantic instance valid radiance_i direct_i unoccluded_i visibility_i mask_i"
        " environment"
    ).split()
)
EXACT = ("depth", "distance", "position", "normal_geometric", "instance")


def render(scene: Path, out: Path, size: tuple[int, int], channels: str, *words: str) -> Path:
    camera = words or ("--renderer", "preview")
    asked = ("--resolution", f"{size[0]}x{size[1]}", "--channels", channels, "--spp", 2)
    output_of("render", scene, "-o", out, *asked, *camera)
    return out


@pytest.fixture(scope="session")
def rendered(
    vectorized: str, composed_demo: Path, tmp_path_factory: pytest.TempPathFactory
) -> Path:
    """One camera of the small room with 48x36 pixels, 12x9 hemispheres and all lights."""
    out = tmp_path_factory.mktemp("loading") / "render"
    words = ("--grid", "12x9", "--camera", "view_0")
    return render(composed_demo, out, (48, 36), ",".join(CHANNELS), *words)


@pytest.fixture(scope="session")
def sample(rendered: Path) -> Sample:
    return open_source(rendered).read(0, CHANNELS)


@pytest.fixture(scope="session")
def finer(composed_demo: Path, tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Sample]:
    """The exact channels of the same camera, with any number of pixels."""

    def of(width: int, height: int) -> Sample:
        out = tmp_path_factory.mktemp("finer") / "render"
        words = ("--renderer", "preview", "--camera", "view_0")
        render(composed_demo, out, (width, height), ",".join(EXACT), *words)
        return open_source(out).read(0, EXACT)

    return of


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(7)


DATASET = """\
name: small
seed: 5
rooms:
  - files: [one/room.yaml, two/room.yaml]
views: {count: 2, resolution: [24, 18]}
variants: [main, mainDiffMat]
channels: [radiance, depth, position, base_color, instance, valid]
budget: {samples: 2}
rendering: {renderer: preview}
storage: complete
splits: {train: 0.5, val: 0.5, test: 0.0}
"""


@pytest.fixture(scope="session")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two rooms, two variants, two views, as `orusd dataset run` leaves them."""
    folder = tmp_path_factory.mktemp("dataset")
    for name in ("one", "two"):
        (folder / name).mkdir()
        (folder / name / "room.yaml").write_text(
            SMALL_ROOM.replace("seed: 3", f"seed: {len(name)}")
        )
    (folder / "dataset.yaml").write_text(DATASET)
    output_of("dataset", "run", folder / "dataset.yaml", "-o", folder / "out")
    return folder / "out"


@pytest.fixture(scope="session")
def torch(torch_packages: str) -> ModuleType:
    """PyTorch in this process, and in those that read."""
    if torch_packages not in sys.path:
        sys.path.append(torch_packages)  # behind our own packages
    return importlib.import_module("torch")
