"""The files that a flattened layer needs, beside it."""

import hashlib
from pathlib import Path, PurePosixPath
from typing import Any, Final

from pxr import Ar, Sdf

from openrooms_usd import atomic
from openrooms_usd.errors import InputError
from openrooms_usd.usd.files import layers
from openrooms_usd.usd.shading.textures import local_file
from orusd_urdf.looks import Loss
from orusd_urdf.naming import Names

_TEXTURES: Final = "textures"
# What a flat file no longer has: the assets that it was made of.
_ASSET_INFO: Final = ("identifier", "payloadAssetDependencies")


def gather_files(layer: Sdf.Layer, folder: Path) -> list[Loss]:
    """Copy what inputs of shaders and lights name to ``textures``, and refer to it relatively.

    Other paths of files lead to where the stage came from, and are left out.

    Args:
        layer: A flattened layer, with absolute paths; it is changed.
        folder: Where it will be saved.

    Returns:
        What could not be copied.
    """
    copies = _Copies(folder)
    for spec in layers.attribute_specs(layer):
        if isinstance(spec.default, Sdf.AssetPath):
            if spec.name.startswith("inputs:"):
                spec.default = copies.relative(spec.default, str(spec.path.GetPrimPath()))
            else:
                spec.default = Sdf.AssetPath(PurePosixPath(spec.default.path).name)
    layer.Traverse(Sdf.Path.absoluteRootPath, lambda path: _forget(layer, path))
    return copies.losses


def _forget(layer: Sdf.Layer, path: Sdf.Path) -> None:
    prim = layer.GetPrimAtPath(path) if path.IsPrimPath() else None
    if prim is None or not prim.HasInfo("assetInfo"):
        return
    kept: dict[str, Any] = {
        name: value for name, value in dict(prim.assetInfo).items() if name not in _ASSET_INFO
    }
    prim.SetInfo("assetInfo", kept)


class _Copies:
    """Files that were copied, each content once."""

    def __init__(self, folder: Path) -> None:
        self.losses: list[Loss] = []
        self._folder = folder
        self._names = Names()
        self._by_source: dict[str, Sdf.AssetPath] = {}
        self._by_content: dict[tuple[str, bytes], Sdf.AssetPath] = {}

    def relative(self, asset: Sdf.AssetPath, prim: str) -> Sdf.AssetPath:
        """Where a file lies now; as it was where there is none."""
        if asset.path and asset.path not in self._by_source:
            try:
                with local_file(asset.path) as file:
                    self._by_source[asset.path] = self._copy(asset.path, file.read_bytes())
            except InputError as error:
                self.losses.append((prim, "approximated", f"{asset.path}: {error.message}"))
                self._by_source[asset.path] = Sdf.AssetPath(PurePosixPath(asset.path).name)
        return self._by_source.get(asset.path, asset)

    def _copy(self, source: str, content: bytes) -> Sdf.AssetPath:
        inner = Ar.SplitPackageRelativePathInner(source)[1] or source
        path = PurePosixPath(inner)
        key = path.suffix.lower(), hashlib.sha256(content).digest()
        if key not in self._by_content:
            name = f"{self._names.unique(path.stem)}{path.suffix.lower()}"
            atomic.write_bytes(self._folder / _TEXTURES / name, content)
            self._by_content[key] = Sdf.AssetPath(f"./{_TEXTURES}/{name}")
        return self._by_content[key]
