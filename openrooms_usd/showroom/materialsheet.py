"""The library of materials as pictures: a sheet for each substance."""

import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

from openrooms_usd.description.substances import Substance
from openrooms_usd.library.textures import FAMILIES, family_of
from openrooms_usd.progress import Progress, silent
from openrooms_usd.rendering.contract import NO_OPTIONS
from openrooms_usd.rendering.folder import check_writable
from openrooms_usd.rendering.sheet import Tile, write_sheet
from openrooms_usd.showroom.photograph import photograph, photograph_settings
from openrooms_usd.showroom.sheet import DEFAULT_SAMPLES, DEFAULT_SIZE

_COLUMNS: Final = 7
# Texels of a picture's textures for each of its pixels, and at most.
_TEXELS_PER_PIXEL: Final = 4
_MOST_TEXELS: Final = 1024


def draw_material_sheets(
    folder: Path,
    substances: Sequence[Substance] = (),
    *,
    number: int = 0,
    size: int = DEFAULT_SIZE,
    samples: int = DEFAULT_SAMPLES,
    renderer: str = "mitsuba",
    options: Mapping[str, str] = NO_OPTIONS,
    denoise: bool = False,
    progress: Progress = silent,
) -> list[Path]:
    """Render every family on a ball and a floor, and tile the pictures: ``<substance>.png``.

    Equal arguments give equal bytes on the same backend.

    Args:
        folder: Where; it is made when it is missing.
        substances: Which; all where empty.
        number: Which material of each family.
        size: Pixels along each side of a picture.
        samples: Samples a pixel.
        renderer: A registered renderer.
        options: What is asked of the renderer, by the names that it declares.
        denoise: Whether to denoise the pictures.
        progress: Called with each finished family's name and the finished fraction.

    Returns:
        The files.

    Raises:
        MissingPackageError: The denoiser is asked for and not installed.
        OutputError: A file cannot be written.
        RenderError: The renderer cannot do it.
    """
    from openrooms_usd.rendering.opening import check_settings, open_for_rendering
    from openrooms_usd.showroom.balls import Sample, ball_camera, build_balls

    settings = photograph_settings(renderer, options, denoise=denoise, samples=samples, size=size)
    check_settings(settings)
    check_writable(folder)
    chosen = list(dict.fromkeys(substances)) or list(FAMILIES)
    total, done, files = sum(len(FAMILIES[kind]) for kind in chosen), 0, []
    texels = min(_MOST_TEXELS, _TEXELS_PER_PIXEL * size)
    for kind in chosen:
        tiles: list[Tile] = []
        with tempfile.TemporaryDirectory(prefix="orusd-") as scratch:
            shown = [Sample(name, number) for name in FAMILIES[kind]]
            stage = build_balls(shown, texels, Path(scratch))
            opened = open_for_rendering(stage, settings)
            for sample in shown:
                picture = photograph(opened, ball_camera(sample))
                tiles.append((_caption(sample.name), picture))
                done += 1
                progress(sample.name, done / total)
        rows = [tiles[i : i + _COLUMNS] for i in range(0, len(tiles), _COLUMNS)]
        files.append(folder / f"{kind}.png")
        write_sheet(files[-1], rows, below=True)
    return files


def _caption(name: str) -> str:
    family = family_of(name)
    return f"{name.replace('_', ' ')}\n{family.size:g} m"
