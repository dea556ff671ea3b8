"""Copying the pictures of a user's material, so that a layer stands without the user's files."""

from collections.abc import Callable
from pathlib import Path

from openrooms_usd import atomic, removal
from openrooms_usd.library.ownmaterials.material import OwnMaterial


def publish(material: OwnMaterial, keep: Callable[[str], Path], folder: str = "textures") -> None:
    """Copy the pictures that are not there yet, each whole or not at all.

    Args:
        material: Its `OwnMaterial.pictures` say which, and under which names.
        keep: Gives the path of a file to be, such as `StageContext.keep`.
        folder: What `keep` is asked for stands below it.

    Raises:
        OutputError: A file cannot be written.
    """
    for file, name in material.pictures.items():
        target = keep(f"{folder}/{name}")
        if not target.is_file():
            with atomic.replacing(target) as beside:
                removal.copy_file(Path(file), beside)
