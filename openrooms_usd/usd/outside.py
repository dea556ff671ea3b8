"""Files outside a scene's folder: they go into nothing that is passed on, unless asked for.

A layer may name any file of the machine that it is opened on. Users who package a scene of others
would pass those files on without knowing. The folder of the scene is the folder of its root layer;
what lies inside is decided after following all links.
"""

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from pxr import Ar, Sdf, Usd, UsdUtils

from openrooms_usd.errors import StageError
from openrooms_usd.usd.files.diagnostics import reading

# More names than this say no more.
_MAX_NAMED_FILES: Final = 5
_LAYERS: Final = (".usda", ".usdc", ".usd")

COPY_OR_TAKE_OUT: Final = "copy them into the folder and refer to them there, or remove them"
_REMEDY: Final = (
    "copy them into the folder and refer to them there, remove them, or give --include-outside "
    "if you may pass them on"
)


@dataclass(frozen=True, order=True)
class Outside:
    """A file that a scene needs and that lies outside its folder.

    Attributes:
        file: Where it lies, all links followed.
        layer: The layer that refers to it, relative to the scene's folder where it lies there.
        path: What that layer says.
    """

    file: str
    layer: str
    path: str

    def __str__(self) -> str:
        said = f" (as {self.path})" if self.path != self.file else ""
        return f"{self.layer} refers to {self.file}{said}"


def files_outside(stage: Usd.Stage, beside: Sequence[Path] = ()) -> list[Outside]:
    """The files outside a scene's folder that it needs, unselected variants included.

    Those that the scene's own layers name come first.

    Args:
        stage: The scene.
        beside: Other folders that its files may lie in.

    Raises:
        InputError: A file of the scene cannot be read.
    """
    root = Path(stage.GetRootLayer().realPath)
    homes = [folder.resolve() for folder in (root.parent, *beside)]
    found: set[Outside] = set()

    def note(layer: Sdf.Layer, info: UsdUtils.DependencyInfo) -> UsdUtils.DependencyInfo:
        for path in {info.assetPath, *info.dependencies}:
            file = _leads_to(layer, path)
            is_inside = file and any(file.is_relative_to(home) for home in homes)
            if file and file != root.resolve() and not is_inside:
                name = Path(layer.realPath).as_posix().removeprefix(f"{root.parent.as_posix()}/")
                found.add(Outside(str(file), name, path))
        return info

    with reading(root):
        UsdUtils.ComputeAllDependencies(str(root), note)
    return sorted(found, key=lambda row: (Path(row.layer).is_absolute(), row))


def refuse_outside(
    stage: Usd.Stage,
    what: str,
    concerns: Callable[[Outside], bool] = lambda found: True,
    *,
    beside: Sequence[Path] = (),
    remedy: str = _REMEDY,
) -> None:
    """Refuse to pass on files from outside a scene's folder.

    Args:
        stage: The scene.
        what: Where they would go, for the message.
        concerns: Which of them would go there.
        beside: Other folders that its files may lie in.
        remedy: What to do about it, for the message.

    Raises:
        InputError: A file of the scene cannot be read.
        StageError: There are some.
    """
    found = [row for row in files_outside(stage, beside) if concerns(row)]
    if not found:
        return
    root = stage.GetRootLayer().realPath
    homes = dict.fromkeys(str(folder.resolve()) for folder in (Path(root).parent, *beside))
    rows = "".join(f"\n  {row}" for row in found[:_MAX_NAMED_FILES])
    more = f"\n  and {len(found) - _MAX_NAMED_FILES} more" if len(found) > _MAX_NAMED_FILES else ""
    raise StageError(
        f"files outside {' and '.join(homes)} would go into {what}:{rows}{more}",
        place=root,
        remedy=remedy,
    )


def is_picture(found: Outside) -> bool:
    """Whether a file is copied as it is: layers are read, and what is in them is written anew."""
    return Path(found.file).suffix.lower() not in _LAYERS


def is_sublayer_of(stage: Usd.Stage) -> Callable[[Outside], bool]:
    """Whether a file is a layer that becomes one with the root layer when that is flattened."""
    stack = {str(Path(layer.realPath).resolve()) for layer in stage.GetLayerStack(False)}
    return lambda found: found.file in stack


def _leads_to(layer: Sdf.Layer, path: str) -> Path | None:
    """The file that an asset path leads to; a package where it leads inside of one."""
    if not path:
        return None
    resolved = str(Ar.GetResolver().Resolve(Sdf.ComputeAssetPathRelativeToLayer(layer, path)))
    outer = Ar.SplitPackageRelativePathOuter(resolved)[0]
    # Of links in a circle, `Path.resolve` would raise.
    return Path(os.path.realpath(outer)) if outer else None
