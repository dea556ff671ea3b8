"""What finished renders show: how many things, which classes, how far away, how they are turned."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.render.reading import RenderedView, read_render

# The channels that are measured.
MEASURED: Final = ("depth", "normal_geometric", "instance", "semantic_nyu40")
# An object counts as seen from this share of the picture on.
_LEAST_SEEN_SHARE: Final = 0.0002
# A surface is level, or upright, up to this tilt.
_LEVEL_COSINE: Final = 0.94


def geometry(view: RenderedView) -> dict[str, float]:
    """Measure the geometry of a view.

    Returns:
        By name: `mean depth, m`, `log depth deviation` (natural logarithm), shares of pixels that
        look `up`, `down` or `sideways`, `objects seen`, `camera height, m`, `camera pitch, deg`.
    """
    pixels = view.pixels
    depth = pixels["depth"][..., 0]
    hit = depth > 0.0
    up = pixels["normal_geometric"][..., 2][hit]
    numbers, counts = np.unique(view.labels("instance"), return_counts=True)
    seen = (counts >= _LEAST_SEEN_SHARE * depth.size) & (numbers != 0)
    pose = view.world_from_camera
    return {
        "mean depth, m": float(depth[hit].mean()),
        "log depth deviation": float(np.log(depth[hit]).std()),
        "looks up": float((up > _LEVEL_COSINE).mean()),
        "looks down": float((up < -_LEVEL_COSINE).mean()),
        "looks sideways": float((np.abs(up) < np.sqrt(1.0 - _LEVEL_COSINE**2)).mean()),
        "objects seen": float(seen.sum()),
        "camera height, m": float(pose[2, 3]),
        "camera pitch, deg": float(np.degrees(np.arcsin(np.clip(pose[2, 2], -1.0, 1.0)))),
    }


def class_shares(views: Sequence[tuple[RenderedView, dict[int, str]]]) -> dict[str, float]:
    """Shares of all labelled pixels by class of NYU40, per cent."""
    totals: dict[str, int] = {}
    for view, legend in views:
        numbers, counts = np.unique(view.labels("semantic_nyu40"), return_counts=True)
        for number, count in zip(numbers.tolist(), counts.tolist(), strict=True):
            if number:
                name = legend.get(number, str(number))
                totals[name] = totals.get(name, 0) + count
    whole = max(1, sum(totals.values()))
    return {name: 100.0 * count / whole for name, count in totals.items()}


def total_variation(shares: dict[str, float], others: dict[str, float]) -> float:
    """Half of the sum of differences between two sets of percentages: 0 equal, 1 disjoint."""
    names = sorted(shares.keys() | others.keys())
    ours, theirs = sum(shares.values()), sum(others.values())
    gaps = [shares.get(name, 0.0) / ours - others.get(name, 0.0) / theirs for name in names]
    return float(0.5 * np.abs(gaps).sum())


def rendered(folder: Path) -> Iterator[tuple[RenderedView, dict[int, str]]]:
    """The views of all renders below a folder, with the names of NYU40's numbers."""
    for manifest in sorted(folder.glob("**/manifest.json")):
        scene = read_render(manifest.parent)
        if set(MEASURED) <= set(scene.manifest.channels):
            for view in scene.each():
                yield view, scene.legend("semantic_nyu40")


def pictures(folder: Path) -> list[Path]:
    """Denoised pictures of renders below a folder, or, where there are none, all photographs."""
    found = sorted(folder.glob("**/denoised.png"))
    return found or sorted(p for p in folder.rglob("*") if p.suffix.lower() in (".jpg", ".jpeg"))


def read(path: Path, width: int) -> NDArray[np.uint8]:
    """(H, W, 3) a picture in sRGB, made smaller to a width where it is larger."""
    import OpenImageIO

    picture = OpenImageIO.ImageBuf(str(path))
    if picture.spec().width > width:
        height = round(picture.spec().height * width / picture.spec().width)
        # By areas, as a sensor of larger pixels sees it: other filters sharpen.
        picture = OpenImageIO.ImageBufAlgo.resize(
            picture, "box", 0.0, OpenImageIO.ROI(0, width, 0, height, 0, 1, 0, 3)
        )
    pixels: NDArray[Any] = np.asarray(picture.get_pixels(OpenImageIO.UINT8))
    return np.asarray(pixels[..., :3], np.uint8)
