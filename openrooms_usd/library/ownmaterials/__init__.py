"""The user's own materials: folders of maps, MaterialX files and constants, read into one form.

`read_material` chooses the reader by what lies at the path. What a file says and we cannot is never
lost in silence: `OwnMaterial.losses` has a sentence for it.

- `folders`: maps in a folder; `normalmaps`: what these hold;
- `materialx`, `mtlxtext`: MaterialX;
- `material`: the one form of all, its size and licence, and that of numbers alone.
"""

from pathlib import Path

from openrooms_usd.errors import InputError
from openrooms_usd.library.ownmaterials.folders import files_in, map_of, read_folder
from openrooms_usd.library.ownmaterials.material import OwnMaterial, from_constants, publish
from openrooms_usd.untrusted import check_path

__all__ = [
    "OwnMaterial",
    "files_of",
    "from_constants",
    "map_of",
    "publish",
    "read_folder",
    "read_material",
]

MATERIALX = ".mtlx"


def read_material(
    path: Path, *, physical_size: float | tuple[float, float] | None = None
) -> OwnMaterial:
    """Read a material of the user's own.

    Args:
        path: A folder of maps, or a MaterialX file.
        physical_size: Metres that the pictures cover: their width (the height follows from their
            proportions), or width and height. None: what the file states, else 1 m, as a loss.

    Raises:
        InputError: There is nothing, nothing that can be read, or a map's file is missing.
        MissingPackageError: It is a MaterialX file and the extra ``materialx`` is not installed.
    """
    if _is_materialx(path):
        from openrooms_usd.library.ownmaterials.materialx import read_materialx

        return read_materialx(path, physical_size=physical_size)
    return read_folder(path, physical_size=physical_size)


def files_of(path: Path) -> list[Path]:
    """The files that `read_material` reads, as far as they exist; sorted.

    Raises:
        InputError: There is nothing that can be read.
    """
    if _is_materialx(path):
        from openrooms_usd.library.ownmaterials.mtlxtext import files_named

        return files_named(path)
    return files_in(path)


def _is_materialx(path: Path) -> bool:
    check_path(path)
    if path.is_dir():
        return False
    if path.suffix.lower() == MATERIALX and path.is_file():
        return True
    raise InputError(
        "no folder of maps and no MaterialX file" if path.exists() else "no such file or folder",
        place=path,
        remedy="give a folder with maps such as Wood_Color.jpg and Wood_Roughness.jpg, or a .mtlx",
    )
