"""Where every file of a dataset lies: by channel as released, or merged as most loaders read it."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal, NamedTuple

Layout = Literal["split", "merged"]
LAYOUTS: Final[tuple[Layout, ...]] = ("split", "merged")
SUBSETS: Final = ("train", "val", "test")

SUFFIXES: Final = ("xml", "xml1")
VARIANTS: Final = ("main", "mainDiffMat", "mainDiffLight")
SPLITS: Final = tuple(f"{variant}_{suffix}" for suffix in SUFFIXES for variant in VARIANTS)

# The cameras of all scenes, for versions of rui-indoorinv-data that read one matrix for all.
SHARED_INTRINSICS: Final = Path("scenes") / "intrinsic.txt"
# What is named by its content, so that scenes share it.
SHARED: Final = "BRDFOriginDataset"

_ALL: Final = frozenset(VARIANTS)
_MATERIAL: Final = frozenset({"main", "mainDiffMat"})
_LIGHT: Final = frozenset({"main", "mainDiffLight"})
_MAIN: Final = frozenset({"main"})


def suffix_of(split: str) -> str:
    """The set of views that a split is of: one of `SUFFIXES`."""
    return split.partition("_")[2]


class Kind(NamedTuple):
    """A kind of file: its folder, its suffix, and the variants that are released with it."""

    folder: str
    suffix: str
    variants: frozenset[str]


# Of a frame: ``<name>_<number><suffix>``. docs/reference/openrooms-files.md names what the release
# has not.
FRAME: Final[dict[str, Kind]] = {
    "im": Kind("Image", ".hdr", _ALL),
    "imbaseColor": Kind("Material", ".png", _MATERIAL),
    "imroughness": Kind("Material", ".png", _MATERIAL),
    "immetallic": Kind("Material", ".png", _MATERIAL),
    "imcadmatobj": Kind("Material", ".dat", _MATERIAL),
    "imnormal": Kind("Geometry", ".png", _MATERIAL),
    "imdepth": Kind("Geometry", ".dat", _MAIN),
    "immask": Kind("Mask", ".png", _LIGHT),
    "imfriction": Kind("Friction", ".dat", _MATERIAL),
    "imsemLabel": Kind("SemanticLabel", ".npy", _MAIN),
    "imenv": Kind("SVLighting", ".hdr", _ALL),
    "imsgEnv": Kind("SVSG", ".h5", _ALL),
    "imshading": Kind("Shading", ".hdr", _ALL),
    "imenvDirect": Kind("SVLightingDirect", ".hdr", _LIGHT),
    "imshadingDirect": Kind("ShadingDirect", ".rgbe", _LIGHT),
}
# Of a light in a frame: ``light_<frame>/<name><light><suffix>``.
LIGHT: Final[dict[str, Kind]] = {
    "box": Kind("LightSource", ".dat", _MAIN),
    "mask": Kind("LightSource", ".png", _MAIN),
    "imShadow": Kind("LightSource", ".png", _MAIN),
    "depthShadow": Kind("LightSource", ".npy", _MAIN),
    "imDS": Kind("LightSource", ".rgbe", _LIGHT),
    "imDSNoOcclu": Kind("LightSource", ".rgbe", _LIGHT),
    "imDSNoOccluApprox": Kind("LightSource", ".hdr", _LIGHT),
    "light": Kind("LightSource", ".dat", _LIGHT),
    "lightSrc": Kind("LightSource", ".dat", _LIGHT),
    "lightSrcNoOcclu": Kind("LightSource", ".dat", _LIGHT),
}
# Of all lights in a frame.
VISIBILITY: Final = Kind("LightSource", ".dat", _LIGHT)

# Loaders make paths by replacing these words wherever they stand in them.
_REPLACED: Final = ("im_", "main_", "mask", "hdr")


@dataclass(frozen=True)
class Place:
    """Where the files of a scene go.

    Attributes:
        root: The dataset's folder.
        scene: Such as ``scene0000_00``.
        split: One of `SPLITS`.
        layout: ``split``: a tree for every channel, and what variants share only once; ``merged``:
            all files of a scene in one folder, for every variant.
    """

    root: Path
    scene: str
    split: str
    layout: Layout

    @property
    def variant(self) -> str:
        """Such as ``mainDiffMat``."""
        return self.split.partition("_")[0]

    @property
    def scene_folder(self) -> Path:
        """The folder of the cameras, which the variants of a suffix share."""
        return self.root / "scenes" / suffix_of(self.split) / self.scene

    def folder(self, kind: Kind) -> Path | None:
        """The folder of a kind of file; None where this variant has none of its own."""
        if self.layout == "merged":
            return self.root / self.split / self.scene
        if self.variant not in kind.variants:
            return None
        return self.root / kind.folder / self.split / self.scene

    def frame(self, name: str, number: int) -> Path | None:
        """A file of a frame; None where this variant has none of its own."""
        kind = FRAME[name]
        folder = self.folder(kind)
        return folder and folder / f"{name}_{number}{kind.suffix}"

    def light(self, name: str, number: int, light: int) -> Path | None:
        """A file of a light in a frame; None where this variant has none of its own."""
        kind = LIGHT[name]
        folder = self.folder(kind)
        return folder and folder / f"light_{number}" / f"{name}{light}{kind.suffix}"

    def visibility(self, number: int) -> Path | None:
        """The file that says whether lights are seen; None where this variant has none."""
        folder = self.folder(VISIBILITY)
        return folder and folder / f"light_{number}" / "visibility.dat"


def caution(root: Path) -> str:
    """What in a path will lead the released loaders astray; empty when nothing."""
    words = [word for word in _REPLACED if word in str(root.absolute())]
    if not words:
        return ""
    listed = " and ".join(repr(word) for word in words)
    return f"the path of the dataset holds {listed}, which the released loaders replace in paths"
