"""MaterialX files: the surface of their material as a preview surface, as far as it maps."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, Final

from openrooms_usd.errors import InputError, MissingPackageError
from openrooms_usd.library.ownmaterials.licences import licence_in
from openrooms_usd.library.ownmaterials.material import OwnMaterial
from openrooms_usd.library.ownmaterials.mtlxtext import included, outlines, read_outline
from openrooms_usd.library.ownmaterials.normalmaps import read_relief
from openrooms_usd.library.ownmaterials.shadings import SHADINGS, Shading
from openrooms_usd.library.ownmaterials.signals import Constant, Signal, Signals
from openrooms_usd.library.ownmaterials.sizes import proportions, tile_size
from openrooms_usd.usd.surfaces import (
    NORMAL_BIAS,
    NORMAL_SCALE,
    PreviewSurface,
    Texture,
    f0_of,
    ior_of,
)

# Fresnel reflectance that no dielectric exceeds; keeps the index of refraction finite.
_MOST_F0: Final = 0.9


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
    signals = Signals(path.parent, losses)
    with _library(path) as library:
        document = _document(path, library)
        shader, name = _shader(path, document, losses)
        surface = _surface(signals, shader, SHADINGS[shader.getCategory()])
    if signals.images.missing:
        raise InputError(
            f"pictures of the material cannot be used: {'; '.join(signals.images.missing)}",
            place=path,
            remedy="copy them into the folder of the .mtlx, and name them relative to it",
        )
    material = OwnMaterial(name, surface, licence=licence_in(path.parent))
    ratio = _ratio(material.textures, losses)
    size = tile_size(physical_size, ratio, signals.images.size, path, losses)
    return replace(material, size=size, losses=tuple(dict.fromkeys(losses)))


@contextmanager
def _library(path: Path) -> Iterator[Any]:
    """The package MaterialX; what it and the mapping stumble over is the file's fault."""
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
        raise InputError(
            f"not a readable MaterialX document: {error}", place=path, remedy="export it again"
        ) from error


def _document(path: Path, library: Any) -> Any:
    """The document beside the standard's definitions."""
    options = library.XmlReadOptions()

    def include(into: Any, file: Any, search: Any, nested: Any) -> None:
        text = read_outline(included(path, file.asString())).text
        library.readFromXmlString(into, text, library.FileSearchPath(), nested)

    options.readXIncludeFunction = include
    document = library.createDocument()
    library.readFromXmlString(document, read_outline(path).text, library.FileSearchPath(), options)
    document.setDataLibrary(_standard(library))
    return document


@cache
def _standard(library: Any) -> Any:
    """The definitions of the standard's nodes, with their defaults."""
    definitions = library.createDocument()
    folders, search = library.getDefaultDataLibraryFolders(), library.getDefaultDataSearchPath()
    library.loadLibraries(folders, search, definitions)
    return definitions


def _shader(path: Path, document: Any, losses: list[str]) -> tuple[Any, str]:
    """The surface shader of the file's first material, and the material's name."""
    materials = document.getMaterialNodes()
    if len(materials) > 1:
        others = ", ".join(node.getName() for node in materials[1:])
        losses.append(f"only its first material is read, not {others}")
    surfaces = [n for n in document.getNodes() if n.getType() == "surfaceshader"]
    name = path.stem
    if materials:
        name = materials[0].getName()
        if materials[0].getInput("displacementshader") is not None:
            losses.append("displacementshader: left out; surfaces are not displaced")
        socket = materials[0].getInput("surfaceshader")
        connected = socket.getConnectedNode() if socket is not None else None
        surfaces = [connected] if connected is not None else []
    if not surfaces or surfaces[0].getCategory() not in SHADINGS:
        what = f"its surface is {surfaces[0].getCategory()}" if surfaces else "it has no surface"
        raise InputError(
            f"{what}, which cannot be read", place=path, remedy=f"use {', '.join(SHADINGS)}"
        )
    return surfaces[0], name


def _surface(signals: Signals, shader: Any, shading: Shading) -> PreviewSurface:
    values = {name: signals.of(shader, socket) for name, socket in shading.inputs.items()}
    if shading.base_weight:
        weight = signals.of(shader, shading.base_weight)
        values["base_color"] = signals.product("base", values["base_color"], weight)
    values["normal"] = _normal(signals, values["normal"])
    fields = {
        name: converted
        for name, value in values.items()
        if (converted := _converted(name, value)) is not None
    }
    surface = PreviewSurface(**fields, ior=_ior(signals, shader, shading))
    surface = _with_opacity(signals, shader, surface)
    _report_rest(signals, shader, shading)
    return surface


def _converted(name: str, signal: Signal) -> Any:
    """A signal as the field of `PreviewSurface` wants it; None keeps the field's default."""
    if signal is None:
        return None
    is_number = isinstance(getattr(PreviewSurface, name), float)
    if isinstance(signal, Texture):
        single = is_number and signal.channel == "rgb"
        return replace(signal, channel="r") if single else signal
    if is_number:
        return sum(signal[:3]) / len(signal[:3])
    return signal[:3] if len(signal) >= 3 else signal[:1] * 3


def _normal(signals: Signals, signal: Signal) -> Signal:
    """A normal map that is one, unpacked."""
    if not isinstance(signal, Texture):
        return None
    relief = read_relief(signal.file, "up")
    if isinstance(relief, str):
        signals.losses.append(f"{Path(signal.file).name}: left out; {relief}")
        return None
    packed = (signal.scale, signal.bias) == (Texture.scale, Texture.bias)
    if packed and relief.scale == NORMAL_SCALE:
        signals.losses.append(f"{Path(signal.file).name}: a normal map without normalmap; added")
        signal = replace(signal, scale=NORMAL_SCALE, bias=NORMAL_BIAS)
    return replace(signal, color_space="raw")


def _ior(signals: Signals, shader: Any, shading: Shading) -> float:
    """The index of refraction; a weight of the reflection lowers it."""
    (ior,) = _number(signals, shader, shading.ior, PreviewSurface.ior)
    if not shading.specular_weight:
        return ior
    (weight,) = _number(signals, shader, shading.specular_weight, 1.0)
    if weight == 1.0:
        return ior
    signals.losses.append(f"{shading.specular_weight}: its {weight:g} goes into the ior")
    return ior_of(min(max(weight, 0.0) * f0_of(ior), _MOST_F0))


def _number(signals: Signals, shader: Any, name: str, default: float) -> Constant:
    """A number that only a constant may drive, as a tuple of one."""
    signal = signals.of(shader, name)
    if isinstance(signal, Texture):
        signals.losses.append(f"{name}: its texture is taken as {default:g}")
    return signal[:1] if isinstance(signal, tuple) else (default,)


def _with_opacity(signals: Signals, shader: Any, surface: PreviewSurface) -> PreviewSurface:
    """What the shader means by opacity: a mask, a part that is absent, or a clear body."""
    kind = shader.getCategory()
    if kind == "UsdPreviewSurface":
        (mode,) = _number(signals, shader, "opacityMode", 0.0)
        (threshold,) = _number(signals, shader, "opacityThreshold", 0.0)
        presence = signals.constant(shader, "opacityMode", "") == "presence" or mode == 1.0
        return replace(
            surface,
            opacity_threshold=threshold,
            opacity_mode="presence" if presence else "transparent",
        )
    if kind != "gltf_pbr":
        return replace(
            surface, opacity_mode="presence" if surface.opacity != 1.0 else "transparent"
        )
    (mode,) = _number(signals, shader, "alpha_mode", 0.0)
    (cutoff,) = _number(signals, shader, "alpha_cutoff", 0.5)
    if mode == 0.0:
        return replace(surface, opacity=1.0)
    return replace(surface, opacity_threshold=cutoff if mode == 1.0 else 0.0)


def _report_rest(signals: Signals, shader: Any, shading: Shading) -> None:
    """Name the inputs that say something and have no place."""
    known = {*shading.inputs.values(), shading.base_weight, shading.ior, shading.specular_weight}
    for socket in shader.getInputs():
        name = socket.getName()
        if name in known | shading.harmless or not _says_something(signals, shader, name):
            continue
        group = next((w for g, w in shading.groups.items() if name.startswith(g)), name)
        if group == name or _says_something(signals, shader, group):
            signals.losses.append(f"{name}: left out")


def _says_something(signals: Signals, shader: Any, name: str) -> bool:
    """Whether an input differs from the shader's default."""
    socket = shader.getInput(name)
    if socket is None:
        return False
    definition = shader.getNodeDef()
    default = definition.getActiveInput(name) if definition is not None else None
    connected = socket.getConnectedNode() is not None or socket.getConnectedOutput() is not None
    return connected or default is None or socket.getValue() != default.getValue()


def _ratio(textures: dict[str, Texture], losses: list[str]) -> float:
    """Height by width of a tile: the pictures', unless the file itself places them unevenly."""
    common = proportions(textures, losses)
    even = all(texture.uv_scale[0] == texture.uv_scale[1] for texture in textures.values())
    return common if even else 1.0
