"""A scene file as text, as the release has it: what old loaders take for granted stays so."""

from collections.abc import Iterable
from typing import Final
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from orusd_openrooms.scenes.records import Bsdf, SceneFile, Shape, Step

_DECIMALS: Final = 6
# A turn's axis needs more: an error counts as often as a point is away from it.
_TURN_DECIMALS: Final = 9
_SAMPLES: Final = 1024
_MAPS: Final = ("albedo", "normal", "roughness", "metallic")


def scene_text(file: SceneFile) -> str:
    """The text of a scene file."""
    # Misspelt in the release; loaders look for this spelling to mend it.
    root = Element("scene", verion="0.5.0")
    SubElement(root, "integrator", type="path")
    for bsdf in file.bsdfs.values():
        root.append(_bsdf(bsdf))
    for shape in file.shapes:
        root.append(_shape(shape))
    root.append(_sensor(file))
    emitter = SubElement(root, "emitter", type="envmap")
    SubElement(emitter, "string", name="filename", value=file.environment or "")
    SubElement(emitter, "float", name="scale", value=f"{file.environment_scale:.8f}")
    ElementTree.indent(root, " " * 4)
    return f'<?xml version="1.0" ?>\n{ElementTree.tostring(root, encoding="unicode")}\n'


def _bsdf(bsdf: Bsdf) -> Element:
    """A material; the renderer refuses names that it does not know, so usual values are left out.

    Maps and constants exclude each other.
    """
    element = Element("bsdf", id=bsdf.id, type="microfacet")
    if bsdf.maps:
        _float(element, "uvScale", bsdf.uv_scale)
    for kind in _MAPS:
        if kind in bsdf.maps:
            texture = SubElement(element, "texture", name=kind, type="bitmap")
            SubElement(texture, "string", name="filename", value=bsdf.maps[kind])
    if "albedo" not in bsdf.maps:
        SubElement(element, "rgb", name="albedo", value=_numbers(bsdf.albedo))
    SubElement(element, "rgb", name="albedoScale", value=_numbers(bsdf.albedo_scale))
    if "roughness" not in bsdf.maps:
        _float(element, "roughness", bsdf.roughness)
    _float(element, "roughnessScale", bsdf.roughness_scale)
    if "metallic" not in bsdf.maps and bsdf.metallic:
        _float(element, "metallic", bsdf.metallic)
    if bsdf.f0 != Bsdf("").f0:
        _float(element, "fresnel", bsdf.f0)
    return element


def _shape(shape: Shape) -> Element:
    element = Element("shape", id=shape.id, type="obj")
    SubElement(element, "string", name="filename", value=shape.file)
    if shape.radiance is not None:
        emitter = SubElement(element, "emitter", type="area")
        SubElement(emitter, "rgb", value=_numbers(shape.radiance))
    transform = SubElement(element, "transform", name="toWorld")
    transform.extend(_step(step) for step in shape.steps)
    for ref in shape.refs:
        SubElement(element, "ref", id=ref, name="bsdf")
    return element


def _step(step: Step) -> Element:
    element: Element = Element(str(step.kind))
    values = step.values
    decimals = _DECIMALS
    if step.kind == "rotate":
        element.set("angle", f"{values[0]:.{_TURN_DECIMALS}f}")
        values, decimals = values[1:], _TURN_DECIMALS
    for axis, value in zip("xyz", values, strict=True):
        element.set(axis, f"{value + 0.0:.{decimals}f}")
    return element


def _sensor(file: SceneFile) -> Element:
    sensor = Element("sensor", type="perspective")
    _float(sensor, "fov", file.fov or 0.0)
    SubElement(sensor, "string", name="fovAxis", value="x")
    film = SubElement(sensor, "film", type="hdrfilm")
    for name, value in zip(("width", "height"), file.resolution, strict=True):
        SubElement(film, "integer", name=name, value=str(value))
    sampler = SubElement(sensor, "sampler", type="adaptive")
    SubElement(sampler, "integer", name="sampleCount", value=str(_SAMPLES))
    return sensor


def _float(element: Element, name: str, value: float) -> None:
    SubElement(element, "float", name=name, value=f"{value:.{_DECIMALS}f}")


def _numbers(values: Iterable[float]) -> str:
    return " ".join(f"{value:.{_DECIMALS}f}" for value in values)
