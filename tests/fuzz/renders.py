"""Sound finished renders, the commands that read them, and folders that a render shall replace."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from openrooms_usd.description.rendering import RenderSettings
from tests.fuzz.kinds import Kind

_CHANNELS = """
radiance base_color normal_camera depth roughness metallic semantic semantic_nyu40 instance
material part emission_mask valid irradiance irradiance_direct radiance_i direct_i unoccluded_i
visibility_i mask_i environment
"""
_SCENE = """\
#usda 1.0
(
    defaultPrim = "World"
    metersPerUnit = 1
    upAxis = "Z"
)

def Xform "World"
{
    def Xform "Furniture"
    {
        def Cube "desk"
        {
            double size = 1
        }
    }

    def Camera "view_0"
    {
    }

    def Camera "view_1"
    {
    }
}
"""


def _render(scene: Path, out: Path, *, views: tuple[str, ...] = ("view_0",)) -> None:
    """As the program itself writes it, with a renderer that gives known numbers."""
    from openrooms_usd.rendering import render_stage
    from tests.fuzz.fakes import FAKE, install

    install()
    scene.write_text(_SCENE)
    render_stage(
        scene,
        out,
        RenderSettings(
            channels=_CHANNELS.split(), resolution=(8, 6), grid=(2, 1), samples=1, renderer=FAKE
        ),
        cameras=views,
    )


def plant_finished(folder: Path) -> None:
    """A finished render, and the scene that it shows."""
    (folder / "in").mkdir()
    _render(folder / "in/scene.usda", folder / "in/render")


def _plant_earlier(folder: Path) -> None:
    """A folder that was rendered into before, in which somebody keeps files of their own."""
    (folder / "in").mkdir()
    _render(folder / "in/scene.usda", folder / "out", views=("view_0", "view_1"))
    (folder / "out/keep.txt").write_text("somebody's own\n")
    (folder / "out/keep").mkdir()
    (folder / "out/keep/channels.exr").write_bytes(b"somebody's own")


_LEADING_AWAY = """
.. . / ../beside ../beside/view keep a/b view_0/../keep view_1/ con ..\\beside manifest.json
keep.txt
"""
_NAMES = (*_LEADING_AWAY.split(), "", "x\0y", "\ud800", "a" * 300, "\u202e")


def _plant_named(folder: Path) -> None:
    """As before, and the manifest lists views whose names lead elsewhere."""
    _plant_earlier(folder)
    path = folder / "out/manifest.json"
    manifest = json.loads(path.read_text())
    manifest["views"] |= dict.fromkeys(_NAMES, manifest["views"]["view_1"])
    path.write_text(json.dumps(manifest))


def _plant_linked(folder: Path) -> None:
    """As before, and folders of views are links to somebody else's."""
    _plant_earlier(folder)
    for name in ("view_0", "view_1"):
        shutil.rmtree(folder / "out" / name)
        (folder / "out" / name).symlink_to("../beside/view")


def _plant_dataset(folder: Path) -> None:
    from openrooms_usd.rendering.datasets import DatasetOptions
    from openrooms_usd.rendering.reading import read_render
    from orusd_openrooms import OpenRoomsDataset

    (folder / "made").mkdir()
    _render(folder / "made/scene.usda", folder / "made/render")
    OpenRoomsDataset().write([read_render(folder / "made/render")], folder / "in", DatasetOptions())


def _released(folder: Path) -> object:
    """Read every file of a dataset by the reader of its kind; the first refusal ends it."""
    from orusd_openrooms import readers

    by_start = {
        "im_": readers.read_light,
        "imbaseColor": readers.read_base_color,
        "imroughness": readers.read_roughness,
        "imnormal": readers.read_normal,
        "immask": readers.read_mask,
        "imdepth": readers.read_depth,
        "imcadmatobj": readers.read_parts,
        "imsemLabel": readers.read_labels,
        "imenv": readers.read_environments,
        "imsgEnv": readers.read_lobes,
        "cam": readers.read_cameras,
    }
    for path in sorted((folder / "in").rglob("*")):
        if path.name.startswith("box") and path.suffix == ".dat":
            readers.read_light_box(path)
        starts = [start for start in by_start if path.name.startswith(start)]
        if starts and not path.is_dir():
            reader: Callable[[Path], Any] = by_start[starts[-1]]
            reader(path)
    return None


def _pickled(folder: Path) -> object:
    from openrooms_usd.unpickling import read_pickled

    return read_pickled(folder / "in/a.pkl"), read_pickled(folder / "in/b.pkl")


def _plant_pickles(folder: Path) -> None:
    import pickle

    (folder / "in").mkdir()
    value = {
        "isWindow": False,
        "box3D": {"center": np.zeros(3), "size": [1.0, 2, 3]},
        "n": np.float32(1),
        "t": ("a", None, 2**70, -1.5),
        "m": np.eye(3, dtype="f4"),
    }
    (folder / "in/a.pkl").write_bytes(pickle.dumps(value, 2))
    (folder / "in/b.pkl").write_bytes(pickle.dumps(value, 0))


_VIEW = "{in}/render/view_0"
_AGAIN = "render {in}/scene.usda -o {out} --renderer fake --spp 1 --channels radiance,instance"
KINDS = (
    Kind(
        "render.finished",
        plant_finished,
        (
            (2, "labels {in}/render -o {out}/coco.json"),
            (1, "labels {in}/render -o {out}/coco.json --taxonomy openrooms45"),
            (2, "labels {in}/render -o {out}/b.json --format boxes --stage {in}/scene.usda"),
            (2, f"relight {_VIEW} -o {{out}} --light lamp=0.5"),
            (1, f"relight {_VIEW} -o {{out}} --temperature lamp=5000"),
            (2, "dataset write {in}/render -o {out}"),
        ),
        ("in/render/**/*.json", "in/render/**/*.exr", "in/render/**/*.npy"),
        share=8,
    ),
    Kind(
        "render.manifest",
        plant_finished,
        (
            (1, "labels {in}/render -o {out}/coco.json"),
            (1, "labels {in}/render -o {out}/b.json --format boxes --stage {in}/scene.usda"),
            (1, f"relight {_VIEW} -o {{out}} --light lamp=off --light elsewhere=2"),
            (1, "dataset write {in}/render -o {out} --dataset-layout merged"),
        ),
        ("in/render/manifest.json",),
        share=8,
    ),
    Kind(
        "render.again",
        _plant_earlier,
        ((3, _AGAIN),),
        ("out/manifest.json", "out/manifest.json", "out/timing.json", "out/*/*.exr"),
        share=4,
    ),
    Kind("render.names", _plant_named, ((1, _AGAIN),), ("out/manifest.json",), share=3),
    Kind("render.linked", _plant_linked, ((1, _AGAIN),), ("out/manifest.json",), hostile=True),
    Kind("render.dataset", _plant_dataset, ((1, _released),), share=4),
    Kind("pickle", _plant_pickles, ((1, _pickled),), share=4),
)
