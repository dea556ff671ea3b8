"""The catalogue as one picture."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Final

from openrooms_usd import claims
from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.progress import Counted, Progress, silent
from openrooms_usd.rendering.contract import NO_OPTIONS
from openrooms_usd.rendering.folder import check_writable
from openrooms_usd.rendering.sheet import Tile, write_sheet
from openrooms_usd.scratch import scratch_folder
from openrooms_usd.showroom.exhibits import Exhibit
from openrooms_usd.showroom.photograph import photograph, photograph_settings

DEFAULT_SIZE: Final = 160
DEFAULT_SAMPLES: Final = 64
# Many lights share the samples of the lamps' studio.
_LAMP_SAMPLES: Final = 3
_COLUMNS: Final = 10


def draw_sheet(
    path: Path,
    exhibits: Sequence[Exhibit],
    *,
    seed: int = 0,
    size: int = DEFAULT_SIZE,
    samples: int = DEFAULT_SAMPLES,
    renderer: str = "mitsuba",
    options: Mapping[str, str] = NO_OPTIONS,
    denoise: bool = False,
    widest: int | None = None,
    progress: Progress = silent,
) -> None:
    """Render every exhibit in the studio and tile the pictures, in the order given.

    Equal arguments give equal bytes on the same backend.

    Args:
        path: The PNG file; it appears whole or not at all.
        exhibits: What is shown.
        seed: Draws details, looks and noise.
        size: Pixels along each side of a picture.
        samples: Samples a pixel.
        renderer: A registered renderer.
        options: What is asked of the renderer, by the names that it declares.
        denoise: Whether to denoise the pictures.
        widest: A sheet of more pixels in a row is reduced to so many.
        progress: Called with each finished exhibit's name and the finished fraction.

    Raises:
        MissingPackageError: The denoiser is asked for and not installed.
        OutputError: The file cannot be written.
        RenderError: The renderer cannot do it.
    """
    from openrooms_usd.rendering.opening import check_settings

    settings = photograph_settings(
        renderer, options, denoise=denoise, samples=samples, size=size, seed=seed
    )
    check_settings(settings)
    check_writable(path.parent)
    claims.check_output(path)
    tiles: dict[str, Tile] = {}
    # Lamps have a studio of their own: each light that is not seen costs samples of those that are.
    for lamps in (False, True):
        hall = [item for item in exhibits if item.emits == lamps]
        for item, tile in _hall(hall, settings):
            tiles[item.name] = tile
            progress(Counted(item.name, len(tiles), len(exhibits)), len(tiles) / len(exhibits))
    ordered = [tiles[item.name] for item in exhibits]
    rows = [ordered[i : i + _COLUMNS] for i in range(0, len(ordered), _COLUMNS)]
    with claims.output(path):
        write_sheet(path, rows, below=True, widest=widest)


def _hall(exhibits: Sequence[Exhibit], settings: RenderSettings) -> Iterator[tuple[Exhibit, Tile]]:
    """Captions and pictures of some exhibits that stand in one studio."""
    from openrooms_usd.rendering.opening import open_for_rendering
    from openrooms_usd.showroom.studio import build, camera_of, triangles_of

    if not exhibits:
        return
    with scratch_folder() as folder:
        stage = build(exhibits, settings.seed, folder)
        opened = open_for_rendering(stage, settings)
        for item in exhibits:
            picture = photograph(opened, camera_of(item), _LAMP_SAMPLES if item.emits else 1)
            yield item, (_caption(item, triangles_of(stage, item)), picture)


def _caption(item: Exhibit, triangles: int) -> str:
    sides = " x ".join(f"{100.0 * side:.0f}" for side in item.size)
    title = item.category.replace("_", " ")
    return f"{title}\n{item.style}\n{sides} cm, {triangles:,} tri."
