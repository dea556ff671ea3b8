"""MaterialX files: the surface of their material, as a stage that refers to them has it.

The package MaterialX parses a file, works its includes in and brings old versions up to date; what
it then holds is read as a stage's materials are (`usd.mtlxlayers`, `usd.materialreader`).
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import fields, replace
from pathlib import Path
from typing import Any, Final
from xml.etree import ElementTree

import numpy as np
from pxr import Sdf, Tf, Usd, UsdShade

from openrooms_usd import names, untrusted
from openrooms_usd.errors import InputError, MissingPackageError
from openrooms_usd.library.ownmaterials.material import (
    OwnMaterial,
    licence_in,
    proportions,
    tile_size,
)
from openrooms_usd.library.ownmaterials.mtlxtext import included, located, outlines, read_outline
from openrooms_usd.library.ownmaterials.normalmaps import read_relief
from openrooms_usd.usd.shading.materialreader import read_preview_surface
from openrooms_usd.usd.shading.mtlxlayers import MATERIALS, layer_of
from openrooms_usd.usd.shading.surfaces import SHUFFLED, PreviewSurface, Texture

_SURFACES: Final = ("standard_surface", "open_pbr_surface", "gltf_pbr", "UsdPreviewSurface")
# What a surface may say, and a material of rooms does not take.
_LEFT_OUT: Final = {
    "emissive": "emission: left out; describe light sources as lamps",
    "painted": "values from primvars are left out; our meshes have none",
}
# Our meshes have one set of texture coordinates.
_ASSUMED: Final = f"{names.ST} is assumed"
_UNSPACED: Final = "lin_rec709"


def read_materialx(
    path: Path, *, physical_size: float | tuple[float, float] | None = None
) -> OwnMaterial:
    """Read the material of a MaterialX file.

    Args:
        path: The file. What it includes must lie below its folder, and so must its pictures,
            unless they are given by absolute paths.
        physical_size: Metres of one tile: its width, or width and height.

    Raises:
        InputError: It is refused or broken, has no surface that is known, or a picture is missing.
        MissingPackageError: The extra ``materialx`` is not installed.
    """
    # The text of every file is checked before the library sees any.
    for _ in outlines(path):
        pass
    losses: list[str] = []
    with _library(path) as library:
        document = _document(path, library)
        name = _material(path, document, losses)
        root = _tree(document)
    stage = Usd.Stage.Open(_layer(path, root, losses))
    prim = stage.GetPrimAtPath(f"{MATERIALS}/{Tf.MakeValidIdentifier(name)}")
    _check_finite(path, prim)
    read, lost = read_preview_surface(UsdShade.Material(prim))
    said = (loss.removeprefix(f"{prim.GetPath()}/") for loss in lost)
    losses += [loss for loss in said if not loss.endswith(_ASSUMED)]
    _check_pictures(path, losses)
    surface = _fit(read, losses)
    material = OwnMaterial(name, surface, licence=licence_in(path.parent))
    ratio = _ratio(material.textures, losses)
    size = tile_size(physical_size, ratio, _stated_size(prim), path, losses)
    return replace(material, size=size, losses=tuple(dict.fromkeys(losses)))


@contextmanager
def _library(path: Path) -> Iterator[Any]:
    """The package MaterialX; what it stumbles over is the file's fault."""
    try:
        import MaterialX
    except ImportError as error:
        raise MissingPackageError(
            "MaterialX files need the package MaterialX, which is not installed",
            place=path,
            remedy="pip install 'openrooms-usd[materialx]'",
        ) from error
    stumbles = (
        MaterialX.Exception,
        MaterialX.ExceptionParseError,
        MaterialX.ExceptionFoundCycle,
        LookupError,
        TypeError,
        ValueError,
    )
    try:
        yield MaterialX
    except stumbles as error:
        raise _broken(path, str(error)) from error


def _broken(path: Path, reason: str) -> InputError:
    return InputError(
        f"not a readable MaterialX document: {reason}", place=path, remedy="export it again"
    )


def _document(path: Path, library: Any) -> Any:
    options = library.XmlReadOptions()

    def include(into: Any, file: Any, search: Any, nested: Any) -> None:
        text = read_outline(included(path, file.asString())).text
        library.readFromXmlString(into, text, library.FileSearchPath(), nested)

    options.readXIncludeFunction = include
    document = library.createDocument()
    library.readFromXmlString(document, read_outline(path).text, library.FileSearchPath(), options)
    return document


def _tree(element: Any) -> ElementTree.Element:
    """An element and all below it, which the package writes without escapes."""
    said = {name: element.getAttribute(name) for name in element.getAttributeNames()}
    made = ElementTree.Element(element.getCategory(), {**said, "name": element.getName()})
    made.extend(map(_tree, element.getChildren()))
    return made


def _material(path: Path, document: Any, losses: list[str]) -> str:
    """The name of the file's first material; a surface without one is given one."""
    materials = document.getMaterialNodes()
    if len(materials) > 1:
        others = ", ".join(node.getName() for node in materials[1:])
        losses.append(f"only its first material is used, not {others}")
    surfaces = [n for n in document.getNodes() if n.getType() == "surfaceshader"]
    if materials:
        socket = materials[0].getInput("surfaceshader")
        connected = socket.getConnectedNode() if socket is not None else None
        surfaces = [connected] if connected is not None else []
    if not surfaces or surfaces[0].getCategory() not in _SURFACES:
        what = f"its surface is {surfaces[0].getCategory()}" if surfaces else "it has no surface"
        raise InputError(
            f"{what}, which cannot be read", place=path, remedy=f"use {', '.join(_SURFACES)}"
        )
    if materials:
        return str(materials[0].getName())
    name = document.createValidChildName(path.stem)
    document.addMaterialNode(name, surfaces[0])
    return str(name)


def _layer(path: Path, root: ElementTree.Element, losses: list[str]) -> Sdf.Layer:
    """The document as a layer; its pictures lie in the file's folder, or are absolute."""

    def beside(name: str) -> str | None:
        if "<" in name or "{" in name:
            losses.append(f"{name}: tiles and frames are not read; left out")
            return None
        target = located(name, path.parent)
        if target is None:
            raise InputError(
                "pictures of the material cannot be used: "
                f"it names {name[:200]}, which lies outside the material's folder",
                place=path,
                remedy="copy its pictures into the folder of the .mtlx",
            )
        if target.is_file():
            untrusted.checked(target, "picture")
        return str(target.absolute())

    if not root.get("colorspace"):
        root.set("colorspace", _UNSPACED)
        losses.append("pictures and colours without a colour space are read as linear Rec.709")
    return layer_of(root, str(path), beside)


def _check_finite(path: Path, prim: Usd.Prim) -> None:
    for shader in Usd.PrimRange(prim):
        for attribute in shader.GetAuthoredAttributes():
            value = attribute.Get()
            numbers = isinstance(value, float | int) or hasattr(value, "dimension")
            if numbers and not np.isfinite(value).all():
                raise _broken(path, f"{attribute.GetBaseName()}: {value} is not finite")


def _check_pictures(path: Path, losses: list[str]) -> None:
    missing = [loss for loss in losses if loss.endswith((" is missing", ".file: names no file"))]
    if missing and not any("tiles and frames" in loss for loss in losses):
        raise InputError(
            f"pictures of the material cannot be used: {'; '.join(missing)}",
            place=path,
            remedy="copy them into the folder of the .mtlx, and name them relative to it",
        )


def _fit(surface: PreviewSurface, losses: list[str]) -> PreviewSurface:
    """The surface without what a material of rooms does not take, its normal map looked at."""
    for name, loss in _LEFT_OUT.items():
        if getattr(surface, name) != getattr(PreviewSurface, name):
            losses.append(loss)
            surface = replace(surface, **{name: getattr(PreviewSurface, name)})
    given = (getattr(surface, item.name) for item in fields(surface))
    losses += [SHUFFLED for value in given if isinstance(value, Texture) and value.is_shuffled]
    if not isinstance(surface.normal, Texture):
        return surface
    relief = read_relief(surface.normal.file, "up")
    if isinstance(relief, str):
        losses.append(f"{Path(surface.normal.file).name}: left out; {relief}")
        return replace(surface, normal=PreviewSurface.normal)
    return surface


def _stated_size(prim: Usd.Prim) -> tuple[float, float] | None:
    """Metres of one tile, where an image says how large it or its tile is in the world."""
    found = None
    for node in Usd.PrimRange(prim):
        shader = UsdShade.Shader(node)
        if shader and str(shader.GetShaderId() or "").startswith("ND_tiledimage"):
            image, tile = (
                socket.Get() if (socket := shader.GetInput(f"realworld{what}size")) else None
                for what in ("image", "tile")
            )
            if image is not None or tile is not None:
                found = (1.0, 1.0) if tile is None else (float(tile[0]), float(tile[1]))
    return found


def _ratio(textures: dict[str, Texture], losses: list[str]) -> float:
    """Height by width of a tile: the pictures', unless the file itself places them unevenly."""
    common = proportions(textures, losses)
    even = all(texture.uv_scale[0] == texture.uv_scale[1] for texture in textures.values())
    return common if even else 1.0
