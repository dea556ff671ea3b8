"""Which frames an OpenRooms dataset has, released or ours, and where their files lie."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from openrooms_usd.loading.files import Files
from openrooms_usd.untrusted import read_text
from orusd_openrooms.layout import FRAME, LAYOUTS, SPLITS, SUBSETS, Layout, Place, suffix_of

IMAGE: Final = "im"
"""The kind of file that every frame has."""


@dataclass(frozen=True, slots=True)
class Frame:
    """A frame of a scene.

    Attributes:
        scene: Such as ``scene0000_00``.
        split: One of `SPLITS`.
        number: As its files are numbered.
        row: Of ``cam.txt``.
        layout: How the files lie.
        subset: ``train``, ``val``, ``test``, or empty.
    """

    scene: str
    split: str
    number: int
    row: int
    layout: Layout
    subset: str

    def files(self, name: str) -> tuple[str, ...]:
        """Where a kind of file may lie, below the root: the first that is there counts.

        What is not released with a variant is that of ``main``, unless somebody wrote it.
        """
        splits = [self.split]
        if self.split.partition("_")[0] not in FRAME[name].variants:
            splits.append(f"main_{suffix_of(self.split)}")
        paths = [self._place(split).frame(name, self.number) for split in splits]
        return tuple(path.as_posix() for path in paths if path)

    @property
    def cameras(self) -> str:
        """The folder of its cameras, below the root."""
        return self._place(self.split).scene_folder.as_posix()

    def _place(self, split: str) -> Place:
        return Place(Path(), self.scene, split, self.layout)


def listed(files: Files) -> Iterator[Frame]:
    """All frames of a dataset; one is where its picture is.

    Raises:
        InputError: It cannot be listed.
    """
    subsets = {scene: subset for subset in SUBSETS for scene in _scenes(files, f"{subset}.txt")}
    for layout in LAYOUTS:
        for split in SPLITS:
            pictures = FRAME[IMAGE].folder
            top = f"{pictures}/{split}" if layout == "split" else split
            for scene in files.names(top):
                numbers = sorted(
                    int(words[1])
                    for name in files.names(f"{top}/{scene}")
                    if (words := Path(name).stem.split("_"))[0] == IMAGE
                    and name.endswith(FRAME[IMAGE].suffix)
                    and len(words) == 2
                    and words[1].isdecimal()
                )
                # Released frames count from 1, those that others rendered again from 0.
                first = 0 if 0 in numbers else 1
                for number in numbers:
                    subset = subsets.get(scene, "")
                    yield Frame(scene, split, number, number - first, layout, subset)


def _scenes(files: Files, name: str) -> list[str]:
    if name not in files.names(""):
        return []
    with files.local({name: ""}) as root:
        return read_text(root / name, "table").split()
