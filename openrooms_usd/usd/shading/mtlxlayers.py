"""Files of MaterialX that a stage refers to: each becomes a layer in memory, as USD's plugin does.

The plugin, UsdMtlx, is part of OpenUSD and not of its package for Python, where a reference to a
``.mtlx`` is an error. The layers here have what materials need, under the paths that UsdMtlx gives
them: ``/MaterialX/Materials/NAME`` with its shaders and node graphs below it. Looks, variant sets
and definitions of nodes are left out.
"""

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path, PurePosixPath
from typing import Any, Final
from xml.etree import ElementTree

from pxr import Ar, Gf, Sdf, Tf, Usd, UsdShade

from openrooms_usd import untrusted
from openrooms_usd.errors import InputError
from openrooms_usd.usd.files.diagnostics import UNREADABLE
from openrooms_usd.usd.shading.mtlxversions import upgrade

_SUFFIX: Final = ".mtlx"
_ROOT: Final = "/MaterialX"
MATERIALS: Final = f"{_ROOT}/Materials"
"""Below it stand the materials of a file."""

_MOST_BYTES: Final = 16 << 20
_MOST_NESTED: Final = 8
_MOST_INCLUDES: Final = 64
_ENTITIES: Final = re.compile(rb"<!\s*(DOCTYPE|ENTITY)", re.IGNORECASE)
# MaterialX knows no other prefix, and hardly any file declares it.
_PREFIXED, _INCLUDE = b"xi:include", "include"
# What a material takes, and the output of ours that it becomes.
_OUTPUTS: Final = {
    "surfaceshader": UsdShade.Tokens.surface,
    "displacementshader": UsdShade.Tokens.displacement,
    "volumeshader": UsdShade.Tokens.volume,
}
# What an included document becomes.
_GROUP: Final = "included"
_Types = Sdf.ValueTypeNames
_TYPES: Final = {
    "float": _Types.Float,
    "integer": _Types.Int,
    "boolean": _Types.Bool,
    "string": _Types.String,
    "filename": _Types.Asset,
    "color3": _Types.Color3f,
    "color4": _Types.Color4f,
    "vector2": _Types.Float2,
    "vector3": _Types.Float3,
    "vector4": _Types.Float4,
}
_VECTORS: Final = {2: Gf.Vec2f, 3: Gf.Vec3f, 4: Gf.Vec4f}
_METRES: Final = {
    "nanometer": 1e-9,
    "micron": 1e-6,
    "millimeter": 1e-3,
    "centimeter": 1e-2,
    "inch": 0.0254,
    "foot": 0.3048,
    "yard": 0.9144,
    "kilometer": 1e3,
    "mile": 1609.344,
}


def read_mtlx_layers(stage: Usd.Stage) -> None:
    """Let a stage find the materials of the MaterialX files that it refers to.

    Its layers then name layers in memory in their place, until they are read anew; their files stay
    as they are, and cannot be saved meanwhile. A file that cannot be read stays the composition
    error that it is.

    Args:
        stage: An opened stage.
    """
    made: dict[str, Sdf.Layer | None] = {}
    for layer in stage.GetUsedLayers():
        for path in layer.GetCompositionAssetDependencies():
            if not path.lower().rstrip("]").endswith(_SUFFIX):
                continue
            file = str(Ar.GetResolver().Resolve(Sdf.ComputeAssetPathRelativeToLayer(layer, path)))
            if file and file not in made:
                made[file] = _layer_of(file)
            if found := made.get(file):
                layer.SetPermissionToSave(False)
                layer.UpdateCompositionAssetDependency(path, found.identifier)


def _layer_of(file: str) -> Sdf.Layer | None:
    try:
        return layer_of(_elements(file), file)
    except (InputError, ElementTree.ParseError, ValueError, *UNREADABLE):
        return None


def layer_of(
    root: ElementTree.Element, file: str, beside: Callable[[str], str | None] | None = None
) -> Sdf.Layer:
    """A document as a layer in memory, its materials below `MATERIALS`.

    Args:
        root: The document, with what it includes in place.
        file: Where it is from.
        beside: The path of a file that it names, None where there is none for it; by default as USD
            finds it from ``file``.
    """
    upgrade(root)
    return _Document(root, file, beside or partial(_beside, file)).layer()


# The text.


def _elements(file: str, depth: int = 0) -> ElementTree.Element:
    """The document, with what it includes in place."""
    data = _bytes(file)
    if _ENTITIES.search(data) or len(data) > _MOST_BYTES:
        raise ValueError("entities are not allowed in materials")
    root = ElementTree.fromstring(data.lstrip().replace(_PREFIXED, _INCLUDE.encode()))
    for place, element in enumerate(list(root)):
        if element.tag == _INCLUDE and depth < _MOST_NESTED:
            if len(root.findall(_INCLUDE)) > _MOST_INCLUDES:
                raise ValueError("it includes too many files")
            inner = _elements(_beside(file, element.get("href", "")), depth + 1)
            group = ElementTree.Element(_GROUP, _inherited(inner))
            group.extend(list(inner))
            root[place] = group
    return root


def _bytes(file: str) -> bytes:
    if not Ar.IsPackageRelativePath(file):
        return untrusted.read_bytes(Path(file), "text")
    asset = Ar.GetResolver().OpenAsset(Ar.ResolvedPath(file))
    return bytes(asset.GetBuffer()) if asset else b""


def _beside(file: str, name: str) -> str:
    """A file that another one names, by its whole path, also within a package."""
    outer, inner = Ar.SplitPackageRelativePathOuter(file)
    if not inner:
        return str(Ar.GetResolver().CreateIdentifier(name, Ar.ResolvedPath(file)))
    if PurePosixPath(name).is_absolute():
        return name
    return str(Ar.JoinPackageRelativePath([outer, str(PurePosixPath(inner).parent / name)]))


def _inherited(element: ElementTree.Element) -> dict[str, str]:
    """What holds for all that is in an element, too."""
    inherited = ("colorspace", "fileprefix")
    return {key: element.attrib[key] for key in inherited if key in element.attrib}


# The layer.


@dataclass(frozen=True)
class _Placed:
    """An element, with what it inherits.

    Attributes:
        element: It.
        space: The colour space of its colours and pictures.
        prefix: What precedes its files.
    """

    element: ElementTree.Element
    space: str = ""
    prefix: str = ""

    @property
    def name(self) -> str:
        return str(Tf.MakeValidIdentifier(self.element.get("name", "")))

    def children(self, *tags: str) -> Iterator["_Placed"]:
        for element in self.element:
            found = _Placed(
                element,
                element.get("colorspace", self.space),
                self.prefix + element.get("fileprefix", ""),
            )
            if element.tag == _GROUP:
                yield from found.children(*tags)
            elif not tags or element.tag in tags:
                yield found


class _Document:
    """Makes the layer of one document."""

    def __init__(
        self, root: ElementTree.Element, file: str, beside: Callable[[str], str | None]
    ) -> None:
        top = _Placed(root, root.get("colorspace", ""), root.get("fileprefix", ""))
        self._top = {one.name: one for one in top.children()}
        self._beside = beside
        self._layer = Sdf.Layer.CreateAnonymous(f"{PurePosixPath(file).stem}.usda")

    def layer(self) -> Sdf.Layer:
        layer = self._layer
        Sdf.CreatePrimInLayer(layer, _ROOT).specifier = Sdf.SpecifierDef
        layer.defaultPrim = _ROOT[1:]
        Sdf.CreatePrimInLayer(layer, MATERIALS).specifier = Sdf.SpecifierDef
        for name, one in self._top.items():
            if one.element.tag == "surfacematerial":
                self._material(Sdf.Path(MATERIALS).AppendChild(name), one)
        return layer

    def _material(self, path: Sdf.Path, one: _Placed) -> None:
        self._prim(path, "Material")
        for socket in one.children("input"):
            token = _OUTPUTS.get(socket.element.get("name", ""))
            if token and (source := self._source(path, socket)):
                output = self._attribute(path, f"outputs:mtlx:{token}", _Types.Token)
                output.connectionPathList.explicitItems = [source]

    def _prim(self, path: Sdf.Path, kind: str) -> None:
        spec = Sdf.CreatePrimInLayer(self._layer, path)
        spec.specifier, spec.typeName = Sdf.SpecifierDef, kind

    def _attribute(self, path: Sdf.Path, name: str, kind: Sdf.ValueTypeName) -> Sdf.AttributeSpec:
        found = self._layer.GetAttributeAtPath(path.AppendProperty(name))
        return found or Sdf.AttributeSpec(self._layer.GetPrimAtPath(path), name, kind)

    def _node(self, path: Sdf.Path, one: _Placed, scope: Sdf.Path) -> None:
        """A node or node graph; what drives it stands beside it in ``scope``."""
        if self._layer.GetPrimAtPath(path):
            return
        if one.element.tag == "nodegraph":
            self._graph(path, one, scope)
            return
        self._shader(path, one)
        self._inputs(path, one, scope)

    def _shader(self, path: Sdf.Path, one: _Placed) -> None:
        self._prim(path, "Shader")
        made_by = one.element.get("nodedef") or f"ND_{one.element.tag}_{one.element.get('type')}"
        prim = self._layer.GetPrimAtPath(path)
        said = Sdf.AttributeSpec(prim, "info:id", _Types.Token, Sdf.VariabilityUniform)
        said.default = made_by

    def _graph(self, path: Sdf.Path, one: _Placed, scope: Sdf.Path) -> None:
        self._prim(path, "NodeGraph")
        self._inputs(path, one, scope)
        outputs = list(one.children("output"))
        nodes = [node for node in one.children() if node.element.tag not in ("input", "output")]
        for node in nodes:
            self._shader(path.AppendChild(node.name), node)
        for node in nodes:
            self._inputs(path.AppendChild(node.name), node, path)
        for node in outputs:
            if source := self._source(path, node):
                output = self._attribute(path, f"outputs:{node.name}", _kind(node))
                output.connectionPathList.explicitItems = [source]

    def _inputs(self, path: Sdf.Path, one: _Placed, scope: Sdf.Path) -> None:
        for socket in one.children("input"):
            value, kind = socket.element.get("value"), _kind(socket)
            made = self._attribute(path, f"inputs:{socket.name}", kind)
            if source := self._source(scope, socket):
                made.connectionPathList.explicitItems = [source]
            elif value is not None and (found := self._value(socket, kind, value)) is not None:
                made.default = found
                if socket.space and kind in (_Types.Color3f, _Types.Color4f, _Types.Asset):
                    made.colorSpace = self._space_of(one, socket)

    def _space_of(self, one: _Placed, socket: _Placed) -> str:
        """A picture that is not a colour has none, unless it says so itself."""
        is_file = socket.element.get("type") == "filename"
        if is_file and not one.element.get("type", "").startswith("color"):
            return socket.element.get("colorspace", "")
        return socket.space

    def _source(self, scope: Sdf.Path, socket: _Placed) -> Sdf.Path | None:
        """The attribute that drives an input or output."""
        said = socket.element
        if interface := said.get("interfacename"):
            return scope.AppendProperty(f"inputs:{Tf.MakeValidIdentifier(interface)}")
        driver = said.get("nodegraph") or said.get("nodename")
        if not driver:
            return None
        name = str(Tf.MakeValidIdentifier(driver))
        # Within a node graph names are of what stands beside; elsewhere of the whole document.
        is_inside = self._layer.GetPrimAtPath(scope).typeName == "NodeGraph"
        if not is_inside:
            if name not in self._top:
                return None
            scope = _owner(scope)
            self._node(scope.AppendChild(name), self._top[name], scope)
        source = scope.AppendChild(name)
        if not self._layer.GetPrimAtPath(source):
            return None
        output = f"outputs:{Tf.MakeValidIdentifier(said.get('output') or 'out')}"
        return self._attribute(source, output, _kind(socket)).path

    def _value(self, socket: _Placed, kind: Sdf.ValueTypeName, text: str) -> Any:
        if kind == _Types.Asset:
            found = self._beside(socket.prefix + text)
            return None if found is None else Sdf.AssetPath(found)
        if kind == _Types.String:
            return text
        if kind == _Types.Bool:
            return text.strip().lower() == "true"
        try:
            numbers = [float(part) for part in re.split(r"[\s,]+", text.strip()) if part]
        except ValueError:
            return None
        unit = _METRES.get(socket.element.get("unit", ""), 1.0)
        numbers = [unit * number for number in numbers]
        if kind == _Types.Int:
            return int(numbers[0]) if numbers else None
        if kind == _Types.Float:
            return numbers[0] if numbers else None
        many = getattr(kind.defaultValue, "dimension", 0)
        return _VECTORS[many](*numbers) if len(numbers) == many else None


def _owner(path: Sdf.Path) -> Sdf.Path:
    """The material that a prim stands in."""
    return Sdf.Path(MATERIALS).AppendChild(path.GetPrefixes()[2].name)


def _kind(socket: _Placed) -> Sdf.ValueTypeName:
    return _TYPES.get(socket.element.get("type", ""), _Types.Token)
