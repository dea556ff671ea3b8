"""Texture sets as files: a picture for each map."""

from pathlib import Path
from typing import Final

from openrooms_usd.library.pictures import write_png
from openrooms_usd.library.textures.base.maps import TextureSet
from openrooms_usd.library.textures.catalogue import family_of

# The pictures of a set, by the name of their field.
MAPS: Final = ("albedo", "normal", "roughness", "metallic", "height")


def rendered_maps(name: str) -> tuple[str, ...]:
    """The maps of a family that a renderer needs: not the height, nor a metalness that is even.

    Raises:
        InputError: There is no such family.
    """
    uneven = family_of(name).metallic is None
    return ("albedo", "normal", "roughness", "metallic") if uneven else MAPS[:3]


def map_file(folder: Path, stem: str, item: str) -> Path:
    """Where a map of a set lies: ``<stem>_<map>.png``."""
    return folder / f"{stem}_{item}.png"


def write_set(
    textures: TextureSet, folder: Path, stem: str, maps: tuple[str, ...] = MAPS
) -> list[Path]:
    """Write a set as ``<stem>_albedo.png`` and so on.

    Args:
        textures: The set.
        folder: Where; it is made when it is missing.
        stem: How the files' names begin.
        maps: Which maps, of `MAPS`. The height's file says in its description what its black and
            white mean.

    Returns:
        The files, in the order of ``maps``.

    Raises:
        OutputError: A file cannot be written.
    """
    files = [map_file(folder, stem, item) for item in maps]
    low, high = textures.height_range
    meaning = {"height": f"height: black {low:.4e} m, white {high:.4e} m"}
    for item, file in zip(maps, files, strict=True):
        pixels = getattr(textures, item)
        is_color = item == "albedo"
        write_png(file, pixels, is_color=is_color, description=meaning.get(item, ""))
    return files
