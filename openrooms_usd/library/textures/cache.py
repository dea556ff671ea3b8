"""Texture sets that were made before: in the user's cache, by all that determines them.

An entry is a folder named by a digest. Its files appear whole, and all that write them at the same
time write the same; a list of their checksums comes last and tells what was damaged since.
"""

import hashlib
import json
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Final

from openrooms_usd import atomic, unfinished
from openrooms_usd.codedigest import code_digest, library_versions
from openrooms_usd.errors import OutputError
from openrooms_usd.library.pictures import write_png
from openrooms_usd.library.textures.base.family import Color
from openrooms_usd.library.textures.base.maps import TextureSet
from openrooms_usd.library.textures.catalogue import (
    DEFAULT_RESOLUTION,
    family_of,
    make,
    substance_of,
)
from openrooms_usd.usercache import cache_folder

_FOLDER: Final = "textures"
_SUMS: Final = "checksums.json"
# Lists the modules of all substances, of which a material needs one.
_ON_ALL: Final = f"{__package__}.base.expanse"
_CATALOGUE: Final = ("openrooms_usd.library.textures.catalogue",)


@dataclass(frozen=True)
class Material:
    """What determines a texture set.

    Attributes:
        name: Its family.
        number: Which of the family's materials, from 0.
        color: Mean base colour, scene-linear Rec.709; None: its own.
        roughness: Mean perceptual roughness; None: its own.
        resolution: Texels along each side.
        size: Physical length of each side, metres; None: the family's usual size.
    """

    name: str
    number: int
    color: Color | None = None
    roughness: float | None = None
    resolution: int = DEFAULT_RESOLUTION
    size: float | None = None

    @property
    def digest(self) -> str:
        """Sixty-four hexadecimal digits that differ where the files may differ."""
        size = family_of(self.name).size if self.size is None else self.size
        code = code_digest(*self._makers, leaves=_CATALOGUE)
        told = [code, {**asdict(self), "size": size}]
        return _sum(json.dumps(told, sort_keys=True).encode())

    @property
    def entry(self) -> str:
        """The name of its entry in the cache, which other versions of libraries do not share."""
        libraries = library_versions(*self._makers, leaves=_CATALOGUE)
        return _sum(json.dumps([self.digest, *libraries]).encode())

    @property
    def _makers(self) -> tuple[str, ...]:
        """The modules that make it: this one's, that of its substance, and what is done to all."""
        return __name__, f"{__package__}.{substance_of(self.name)}", _ON_ALL


def cached(material: Material, folder: Path, stem: str) -> list[Path]:
    """Have the maps of a material that renderers need in a folder, made only where they must be.

    The same bytes with and without a cache. A cache that cannot be read or written is as none.

    Args:
        material: Which.
        folder: Where the files shall lie; it is made when it is missing.
        stem: How their names begin.

    Returns:
        The files, in the order of `rendered_maps`.

    Raises:
        InputError: There is no such family.
        OutputError: A file cannot be written.
    """
    maps = rendered_maps(material.name)
    files = [map_file(folder, stem, item) for item in maps]
    place = cache_folder(_FOLDER)
    entry = place / material.entry if place else None
    if entry and _copy_entry(entry, maps, files):
        return files
    made = make(**asdict(material))
    write_set(made, folder, stem, maps)
    if entry:
        with suppress(OSError, OutputError):
            _keep(entry, maps, files)
    return files


def _copy_entry(entry: Path, maps: tuple[str, ...], files: list[Path]) -> bool:
    """Copy a whole entry; whether there was one."""
    try:
        sums = json.loads((entry / _SUMS).read_text(encoding="utf-8"))
        found = [(entry / f"{item}.png").read_bytes() for item in maps]
        whole = all(_sum(data) == sums[item] for item, data in zip(maps, found, strict=True))
    except (OSError, ValueError, KeyError, TypeError):
        return False
    if whole:
        for file, data in zip(files, found, strict=True):
            atomic.write_bytes(file, data)
    return whole


def _keep(entry: Path, maps: tuple[str, ...], files: list[Path]) -> None:
    """Add files to the cache, in place of what was damaged there."""
    entry.mkdir(parents=True, exist_ok=True)
    unfinished.sweep(entry)
    found = {item: file.read_bytes() for item, file in zip(maps, files, strict=True)}
    for item, data in found.items():
        atomic.write_bytes(entry / f"{item}.png", data)
    # Last, because it is what makes the entry whole.
    sums = {item: _sum(data) for item, data in found.items()}
    atomic.write_bytes(entry / _SUMS, json.dumps(sums).encode())


def _sum(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


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
