"""Mitsuba's XML from plugin descriptions: nested dictionaries, numbers, matrices, file names."""

from pathlib import PurePosixPath
from typing import Any, Final
from xml.etree import ElementTree

import numpy as np

_TAGS: Final = {
    "path": "integrator",
    "perspective": "sensor",
    "thinlens": "sensor",
    "orthographic": "sensor",
    "independent": "sampler",
    "hdrfilm": "film",
    "box": "rfilter",
    "ply": "shape",
    "shapegroup": "shape",
    "instance": "shape",
    "area": "emitter",
    "constant": "emitter",
    "envmap": "emitter",
    "directional": "emitter",
    "diffuse": "bsdf",
    "principled": "bsdf",
    "normalmap": "bsdf",
    "twosided": "bsdf",
    "mask": "bsdf",
    "blendbsdf": "bsdf",
    "principledthin": "bsdf",
    "thindielectric": "bsdf",
    "bitmap": "texture",
}
_VERSION: Final = "3.0.0"


def scene_text(objects: dict[str, Any]) -> str:
    """A whole scene file.

    Args:
        objects: Plugin descriptions by identifier. ``{"ref": identifier}`` refers to another.
    """
    root = ElementTree.Element("scene", version=_VERSION)
    for identifier, description in objects.items():
        element = _plugin(description)
        element.set("id", identifier)
        root.append(element)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode") + "\n"


def _plugin(description: dict[str, Any]) -> ElementTree.Element:
    kind = description["type"]
    element = ElementTree.Element(_TAGS[kind], type=kind)
    for name, value in description.items():
        if name != "type":
            element.append(_property(name, value))
    return element


def _property(name: str, value: Any) -> ElementTree.Element:
    if isinstance(value, dict):
        return _nested(name, value)
    if isinstance(value, np.ndarray):
        transform = ElementTree.Element("transform", name=name)
        ElementTree.SubElement(transform, "matrix", value=_numbers(value))
        return transform
    if isinstance(value, list):
        return ElementTree.Element("vector", name=name, value=_numbers(value))
    tag, text = _scalar(value)
    return ElementTree.Element(tag, name=name, value=text)


def _nested(name: str, value: dict[str, Any]) -> ElementTree.Element:
    if "ref" in value:
        return ElementTree.Element("ref", name=name, id=value["ref"])
    if value["type"] == "rgb":
        return ElementTree.Element("rgb", name=name, value=_numbers(value["value"]))
    element = _plugin(value)
    element.set("name", name)
    return element


def _scalar(value: Any) -> tuple[str, str]:
    if isinstance(value, bool):
        return "boolean", "true" if value else "false"
    if isinstance(value, int):
        return "integer", str(value)
    if isinstance(value, PurePosixPath | str):
        return "string", str(value)
    return "float", repr(float(value))


def _numbers(values: Any) -> str:
    return " ".join(repr(float(value)) for value in np.asarray(values).ravel())
