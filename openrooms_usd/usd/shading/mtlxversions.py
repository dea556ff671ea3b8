"""Documents of older versions of MaterialX in the words of today.

As MaterialX 1.39 itself does when it reads them. ``channels`` of an input or output become a node
that picks them (up to 1.38). ``material`` with its ``shaderref`` becomes a shader and a material
that uses it, ``parameter`` an input (up to 1.37).
"""

from collections.abc import Iterator
from typing import Final
from xml.etree import ElementTree

_Element = ElementTree.Element

# What says where an input comes from.
_SOURCE: Final[tuple[str, ...]] = ("nodename", "nodegraph", "interfacename", "output")
_BINDINGS: Final = ("bindinput", "bindparam")
_OLD_GRAPH: Final = "opgraph"


def upgrade(root: _Element) -> None:
    """Rewrite a document in place.

    Args:
        root: The document, with what it includes in place.
    """
    for element in root.iter("parameter"):
        element.tag = "input"
    for scope in list(root.iter()):
        _take_materials(scope)
    for scope in list(root.iter()):
        _pick_channels(scope)


def _take_materials(scope: _Element) -> None:
    """Shaders that stand in a material stand beside it from then on."""
    for place, material in enumerate(list(scope)):
        if material.tag != "material" or material.find("shaderref") is None:
            continue
        name = material.get("name", "")
        made = ElementTree.Element("surfacematerial", {"name": name, "type": "material"})
        for reference in material.findall("shaderref"):
            shader = _shader(reference, f"{name}__{reference.get('name', '')}")
            scope.append(shader)
            kind = shader.get("type", "")
            socket = {"name": kind, "type": kind, "nodename": shader.get("name", "")}
            ElementTree.SubElement(made, "input", socket)
        scope[place] = made


def _shader(reference: _Element, name: str) -> _Element:
    node = reference.get("node") or _node_of(reference.get("nodedef", ""))
    kind = "displacementshader" if node == "displacement" else "surfaceshader"
    said = {key: reference.attrib[key] for key in ("nodedef",) if key in reference.attrib}
    shader = ElementTree.Element(node or "node", {"name": name, "type": kind, **said})
    for binding in (one for one in reference if one.tag in _BINDINGS):
        socket = ElementTree.SubElement(shader, "input", binding.attrib)
        if _OLD_GRAPH in socket.attrib:
            socket.set("nodegraph", socket.attrib.pop(_OLD_GRAPH))
    return shader


def _node_of(definition: str) -> str:
    """``standard_surface`` of ``ND_standard_surface_surfaceshader``."""
    return definition.removeprefix("ND_").removesuffix("_surfaceshader")


def _pick_channels(scope: _Element) -> None:
    """A node that picks channels stands before each socket that says which it takes."""
    names = {element.get("name", "") for element in scope}
    for socket in list(_sockets(scope)):
        channels = socket.attrib.pop("channels", "")
        if not channels or not any(key in socket.attrib for key in _SOURCE):
            continue
        name = "channels"
        while name in names:
            name += "_"
        names.add(name)
        kind = socket.get("type", "")
        made = ElementTree.SubElement(scope, "swizzle", {"name": name, "type": kind})
        moved = [key for key in _SOURCE if key in socket.attrib]
        source: dict[str, str] = {key: socket.attrib.pop(key) for key in moved}
        ElementTree.SubElement(made, "input", {"name": "in", "type": "color4", **source})
        picked = {"name": "channels", "type": "string", "value": channels}
        ElementTree.SubElement(made, "input", picked)
        socket.set("nodename", name)


def _sockets(scope: _Element) -> Iterator[_Element]:
    """The outputs of a scope, and the inputs of its nodes."""
    for element in scope:
        if element.tag == "output":
            yield element
        yield from element.findall("input")
