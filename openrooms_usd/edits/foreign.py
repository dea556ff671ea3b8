"""What another program wrote into ``scene.usda``, which belongs to compose."""

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from pxr import Ar, Sdf

from openrooms_usd import atomic, names
from openrooms_usd.errors import StageError
from openrooms_usd.usd.files import preflight
from openrooms_usd.usd.files.diagnostics import UNREADABLE
from openrooms_usd.usd.files.layers import apply_metadata, prim_specs

# How a layer's own fields are called that hold its structure and no metadata.
_STRUCTURE = ("subLayers", "subLayerOffsets", "primChildren", "rootPrims")


@dataclass(frozen=True)
class Foreign:
    """What a root layer holds beside what compose writes.

    Attributes:
        prims: The prims that it speaks about, parents of others left out.
        sublayers: Layers that compose does not stack, as absolute paths, strongest first.
        metadata: Names of metadata that differ.
    """

    prims: tuple[str, ...] = ()
    sublayers: tuple[str, ...] = ()
    metadata: tuple[str, ...] = ()

    def __bool__(self) -> bool:
        return bool(self.prims or self.sublayers or self.metadata)

    def __str__(self) -> str:
        prims = f"{len(self.prims)} prims ({self.prims[0]} ...)" if self.prims else ""
        layers = f"{len(self.sublayers)} sublayers" if self.sublayers else ""
        return ", ".join(filter(None, (prims, layers, ", ".join(self.metadata))))


def own_layers(out: Path) -> tuple[Path, ...]:
    """All layers that compose may stack, strongest first."""
    # Of links in a circle, `Path.resolve` would raise.
    real = Path(os.path.realpath(out))
    return tuple(real / names.LAYERS / f"{name}.usda" for name in names.STACK)


def anchored(layer: Sdf.Layer, path: str) -> str:
    """An asset path of a layer as one that holds everywhere."""
    return str(Ar.GetResolver().CreateIdentifier(path, layer.resolvedPath)) if path else path


def foreign_to(layer: Sdf.Layer, out: Path) -> Foreign:
    """What a layer holds beside what compose writes into the root layer of ``out``."""
    ours = {str(path) for path in own_layers(out)}
    sublayers = (anchored(layer, path) for path in layer.subLayerPaths)
    return Foreign(
        tuple(str(spec.path) for spec in prim_specs(layer) if not spec.nameChildren),
        tuple(path for path in sublayers if real_path(path) not in ours),
        tuple(_metadata(layer)),
    )


def real_path(path: str) -> str:
    """Where a path leads, all links followed; empty for a name that no file can have."""
    return "" if "\0" in path else os.path.realpath(path)


def _metadata(layer: Sdf.Layer) -> Iterator[str]:
    expected = Sdf.Layer.CreateAnonymous(".usda")
    apply_metadata(expected)
    expected.pseudoRoot.SetInfo("renderSettingsPrimPath", names.RENDER_SETTINGS)
    wanted, found = expected.pseudoRoot, layer.pseudoRoot
    for key in sorted(set(found.ListInfoKeys()) - set(_STRUCTURE)):
        known = wanted.GetInfo(key) if wanted.HasInfo(key) else None
        value = found.GetInfo(key)
        if key == "customLayerData":
            # The records of our stages arrive here when their layers are merged.
            value = {name: entry for name, entry in value.items() if name != names.NAMESPACE}
        if value != known:
            yield key


def refuse_foreign(scene: Path) -> None:
    """Refuse to write over a root layer that another program saved something into.

    Raises:
        InputError: It, or a layer beside it, is not fit to be opened (`usd.preflight`).
        OutputError: It is not a layer, and not ours.
        StageError: It holds more than compose writes.
    """
    for path in (scene.parent / names.LAYERS, scene, *own_layers(scene.parent)):
        if path.is_symlink():
            raise StageError(
                "this is a symbolic link, and compose does not write through links",
                place=path,
                remedy="replace it by its target",
            )
    for path in (scene, *own_layers(scene.parent)):
        if path.exists():
            preflight.check_file(path)
    try:
        layer = Sdf.Layer.OpenAsAnonymous(str(scene)) if scene.is_file() else None
    except UNREADABLE:
        # A file that is not a layer holds no opinions, but may belong to a user.
        atomic.check_free([scene])
        return
    foreign = layer and foreign_to(_read_again(scene, layer), scene.parent)
    if foreign:
        raise StageError(
            f"another program has saved into this file, which compose overwrites: {foreign}",
            place=scene,
            remedy=f"orusd edit import-changes {scene} moves the changes into "
            f"{names.LAYERS}/{names.EDITS}.usda; or remove the file, and compose writes it "
            "again",
        )


def _read_again(scene: Path, layer: Sdf.Layer) -> Sdf.Layer:
    """The layer itself where its paths matter: an anonymous one has no place to start from."""
    if not layer.subLayerPaths:
        return layer
    known = Sdf.Layer.FindOrOpen(str(scene))
    known.Reload()
    return known
