"""Strips of pictures: what was seen, moment by moment."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from openrooms_usd import claims
from openrooms_usd.rendering.contract import View
from openrooms_usd.rendering.denoise import DENOISED
from openrooms_usd.rendering.previews import preview
from openrooms_usd.rendering.sheet import Tile, tiles, write_sheet
from openrooms_usd.simulation.robot_cameras import RGB


def row(
    caption: str, views: Mapping[str, View], channels: Mapping[str, Sequence[str]]
) -> list[Tile]:
    """One moment.

    Args:
        caption: What it is.
        views: By the camera's name.
        channels: Which channels of each view to show; of the radiance the denoised version, where
            there is one.
    """
    found: list[Tile] = []
    for camera, names in channels.items():
        images = views[camera].images
        for name in names:
            shown = DENOISED if name == RGB and DENOISED in images else name
            picture = preview(shown, images[shown].pixels)
            found += tiles(f"{caption}  {camera}", {shown: picture})
    return found


def write_strip(path: Path, rows: Sequence[Sequence[Tile]]) -> None:
    """Write moments below each other as a PNG.

    Raises:
        OutputError: It cannot be written, or is there and not ours.
    """
    with claims.output(path):
        write_sheet(path, rows)
