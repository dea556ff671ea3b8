"""Where a dataset's files lie on this machine: by the folder they have in every copy of it."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Final, Literal

from openrooms_usd import untrusted
from openrooms_usd.errors import InputError

Folder = Literal["uv_mapped", "layoutMesh", "BRDFOriginDataset", "EnvDataset"]

# Options that name a folder of the dataset where it does not lie in the root.
OPTIONS: Final[dict[Folder, str]] = {
    "uv_mapped": "models",
    "layoutMesh": "layouts",
    "BRDFOriginDataset": "materials",
    "EnvDataset": "environments",
}
# Scenes lie some folders below what they name: ../../../../../uv_mapped.
_LEVELS: Final = 6


@dataclass(frozen=True)
class Named:
    """A file as a scene names it.

    Attributes:
        folder: Which folder of the dataset it lies in.
        path: Its path there, with forward slashes.
    """

    folder: Folder
    path: str

    @property
    def parts(self) -> tuple[str, ...]:
        """The names on the way."""
        return PurePosixPath(self.path).parts


def named(text: str, place: str) -> Named:
    """What a path in a scene file means, wherever its author's disk had it.

    Args:
        text: Such as ``../../../../../uv_mapped/door/7/alignedNew.obj``.
        place: Who names it, for messages.

    Raises:
        InputError: It does not lie in a folder of the dataset, or leaves it.
    """
    parts = text.replace("\\", "/").split("/")
    at = next((i for i, part in enumerate(parts) if part in OPTIONS), None)
    rest = parts[at + 1 :] if at is not None else []
    if at is None or not rest or any(not untrusted.is_plain_name(part) for part in rest):
        raise InputError(
            f"{text[:120]!r} is not a path into {', '.join(OPTIONS)}",
            place=place,
            remedy="files of a scene lie in these folders of the dataset; correct the path",
        )
    folder: Folder = next(name for name in OPTIONS if name == parts[at])
    return Named(folder, "/".join(rest))


class Roots:
    """The folders in which files are looked for, and those that were not found.

    Attributes:
        folders: Those of each part of the dataset, in the order in which they are searched.
    """

    def __init__(self, source: Path, options: Mapping[str, str]) -> None:
        """The folders that options name, or else those above the scene.

        Args:
            source: The scene file.
            options: ``root`` and those of `OPTIONS`.

        Raises:
            InputError: An option names a folder that is not there.
        """
        for name in ("root", *OPTIONS.values()):
            if name in options and not Path(options[name]).is_dir():
                raise InputError(f"--{name} is not a folder", place=options[name])
        above = [] if "root" in options else [*source.absolute().parents][:_LEVELS]
        whole = [Path(options["root"])] if "root" in options else above
        self.folders: dict[Folder, list[Path]] = {
            folder: [Path(options[option])] if option in options else [w / folder for w in whole]
            for folder, option in OPTIONS.items()
        }

    def find(self, name: Named) -> Path | None:
        """The file; None where no folder has it.

        Raises:
            InputError: A link takes it out of its folder.
        """
        for folder in self.folders[name.folder]:
            if (folder / name.path).is_file():
                return untrusted.inside(folder, name.path)
        return None
