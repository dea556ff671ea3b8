"""Reads OpenRooms' ``main.xml``: the dialect of Mitsuba 0.5 that its own renderer takes.

The released files differ from Mitsuba in what this module admits: the root's ``verion``, shape
identifiers that repeat, ``rgb`` without a name, ``microfacet`` with factors, and transforms whose
order counts. The file is a stranger's: every number is looked at, and so is how many there are.
"""

import math
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Final
from xml.etree.ElementTree import Element

import numpy as np

from openrooms_usd.errors import InputError
from openrooms_usd.library.models.plainxml import read_xml
from orusd_openrooms.scenes.records import Bsdf, Color, SceneFile, ShapeRecord, Step

# The released scenes have some fifty shapes and a thousand elements.
_MOST_SHAPES: Final = 10_000
_MOST_ELEMENTS: Final = 300_000
_FARTHEST_M: Final = 1e5
_LARGEST_SCALE: Final = 1e4
_BRIGHTEST: Final = 1e9
_FOV_DEG: Final = (1.0, 170.0)
_MOST_PIXELS: Final = 16_384
_USUAL_SIZE: Final = (640, 480)
_MAPS: Final = ("albedo", "normal", "roughness", "metallic")
# Elements that say how to render, and nothing about the scene.
_RENDERING: Final = ("integrator", "default")


def read_scene(path: Path) -> SceneFile:
    """Read a scene file.

    Args:
        path: ``main.xml``, ``mainDiffMat.xml``, ``mainDiffLight.xml`` or one of ours.

    Raises:
        InputError: It is unreadable, hostile, not such a scene, or holds invalid numbers.
    """
    root = read_xml(path, "scene", "text", _MOST_ELEMENTS)
    if root.tag != "scene":
        raise InputError(
            f"the root element is <{root.tag[:40]}>, not <scene>",
            place=path,
            remedy="give the main.xml of an OpenRooms scene",
        )
    return _Reader(path).scene(root)


class _Reader:
    """Reads elements of one file, whose place it names in errors."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.notes: list[str] = []

    def scene(self, root: Element) -> SceneFile:
        kinds = Counter(child.tag for child in root)
        if kinds["shape"] > _MOST_SHAPES:
            raise self.error("", f"{kinds['shape']:,} shapes; at most {_MOST_SHAPES:,} are read")
        bsdfs: dict[str, Bsdf] = {}
        for element in root.findall("bsdf"):
            bsdf = self.bsdf(element)
            if bsdf.id in bsdfs:
                raise self.error(f"bsdf {bsdf.id!r}", "it is defined twice")
            bsdfs[bsdf.id] = bsdf
        shapes = [self.shape(number, one) for number, one in enumerate(root.findall("shape"))]
        shapes = [shape for shape in shapes if shape.file]
        if not shapes:
            raise self.error("", "it has no shapes")
        self.check_refs(shapes, bsdfs)
        fov, resolution = self.sensor(root)
        file, scale = self.environment(root.findall("emitter"))
        for tag in sorted(set(kinds) - {"bsdf", "shape", "sensor", "emitter", *_RENDERING}):
            self.notes.append(f"<{tag[:40]}> is not supported and left out")
        return SceneFile(bsdfs, tuple(shapes), fov, resolution, file, scale, tuple(self.notes))

    def bsdf(self, element: Element) -> Bsdf:
        name = element.get("id") or ""
        where = f"bsdf {name[:80]!r}"
        if not name:
            raise self.error("bsdf", "it has no id")
        if element.get("type") != "microfacet":
            self.notes.append(
                f"{where} is {str(element.get('type'))[:40]!r}, not microfacet: grey stands for it"
            )
            return Bsdf(name, albedo=(0.5, 0.5, 0.5), roughness=1.0)
        maps = {
            str(one.get("name")): self.filename(one, where)
            for one in element.findall("texture")
            if one.get("name") in _MAPS
        }
        usual = Bsdf(name)
        return Bsdf(
            name,
            maps,
            albedo=self.color(element, "albedo", where, usual.albedo),
            albedo_scale=self.color(element, "albedoScale", where, usual.albedo_scale),
            roughness=self.number(element, "roughness", where, usual.roughness),
            roughness_scale=self.number(element, "roughnessScale", where, usual.roughness_scale),
            metallic=min(1.0, self.number(element, "metallic", where, usual.metallic)),
            f0=min(0.99, self.number(element, "fresnel", where, usual.f0)),
            uv_scale=self.number(element, "uvScale", where, usual.uv_scale),
        )

    def shape(self, number: int, element: Element) -> ShapeRecord:
        name = element.get("id") or ""
        where = f"shape {number} {name[:80]!r}"
        if element.get("type") != "obj":
            self.notes.append(f"{where} is {str(element.get('type'))[:40]!r}, not obj: left out")
            return ShapeRecord(number, name, "")
        transforms = element.findall("transform")
        if len(transforms) > 1:
            raise self.error(where, "it has more than one transform")
        steps = tuple(self.step(one, where) for transform in transforms for one in transform)
        refs = tuple(ref.get("id") or "" for ref in element.findall("ref"))
        emitters = element.findall("emitter")
        radiance = None
        if emitters:
            if len(emitters) > 1 or emitters[0].get("type") != "area":
                raise self.error(where, "it emits, but not as one area light")
            # The released files give this colour no name; Mitsuba calls it radiance.
            rgb = [one for one in emitters[0].findall("rgb") if one.get("name", "radiance")]
            if len(rgb) != 1 or rgb[0].get("name", "radiance") != "radiance":
                raise self.error(where, "its emitter has no radiance")
            radiance = self.triple(rgb[0].get("value"), where, 0.0, _BRIGHTEST)
        return ShapeRecord(number, name, self.filename(element, where), steps, refs, radiance)

    def step(self, element: Element, where: str) -> Step:
        get = element.get
        if element.tag == "scale":
            same = get("value")
            words = (same or "").split()
            each = [get(axis, "1") for axis in "xyz"]
            texts = words * 3 if len(words) == 1 else words or each
            x, y, z = self.values(texts, where, -_LARGEST_SCALE, _LARGEST_SCALE)
            if min(x, y, z) <= 0.0:
                raise self.error(where, f"a scale of {min(x, y, z):g}: factors must be positive")
            return Step.scale(x, y, z)
        x, y, z = self.values([get(a, "0") for a in "xyz"], where, -_FARTHEST_M, _FARTHEST_M)
        if element.tag == "translate":
            return Step.translate(x, y, z)
        if element.tag == "rotate":
            (angle,) = self.values([get("angle", "0")], where, -_FARTHEST_M, _FARTHEST_M)
            axis = np.array([x, y, z])
            if not np.linalg.norm(axis) > 1e-6:
                raise self.error(where, "it turns about an axis without length")
            return Step.rotate(angle, axis)
        raise self.error(where, f"<{element.tag[:40]}> is not scale, rotate or translate")

    def sensor(self, root: Element) -> tuple[float | None, tuple[int, int]]:
        sensors = root.findall("sensor")
        if not sensors:
            return None, _USUAL_SIZE
        sensor, where = sensors[0], "sensor"
        fov = self.number(sensor, "fov", where, 0.0)
        if not _FOV_DEG[0] < fov < _FOV_DEG[1]:
            raise self.error(where, f"a field of view of {fov:g} degrees")
        film = sensor.find("film")
        width, height = _USUAL_SIZE
        if film is not None:
            sizes = {one.get("name"): one.get("value") for one in film.findall("integer")}
            texts = [sizes.get("width") or str(width), sizes.get("height") or str(height)]
            width, height = (int(n) for n in self.values(texts, where, 1, _MOST_PIXELS))
        axes = {one.get("name"): one.get("value") for one in sensor.findall("string")}
        if axes.get("fovAxis", "x") == "y":
            half = math.tan(math.radians(fov) / 2.0) * width / height
            fov = math.degrees(2.0 * math.atan(half))
        return fov, (width, height)

    def environment(self, emitters: list[Element]) -> tuple[str | None, float]:
        maps = [one for one in emitters if one.get("type") == "envmap"]
        for other in emitters:
            if other not in maps:
                self.notes.append(f"an emitter {str(other.get('type'))[:40]!r} is left out")
        if not maps:
            return None, 0.0
        if len(maps) > 1:
            self.notes.append("of several environment maps the first counts, as in the renderer")
        where = "environment map"
        return self.filename(maps[0], where), self.number(maps[0], "scale", where, 1.0)

    def check_refs(self, shapes: Iterable[ShapeRecord], bsdfs: dict[str, Bsdf]) -> None:
        """The renderer refuses materials that are not there."""
        for shape in shapes:
            unknown = next((ref for ref in shape.refs if ref not in bsdfs), None)
            if unknown is not None:
                where = f"shape {shape.number} {shape.id[:80]!r}"
                raise self.error(where, f"there is no bsdf {unknown[:80]!r}")

    def filename(self, element: Element, where: str) -> str:
        texts = {one.get("name"): one.get("value") for one in element.findall("string")}
        name = texts.get("filename")
        if not name:
            raise self.error(where, "it has no filename")
        return name

    def color(self, element: Element, name: str, where: str, usual: Color) -> Color:
        found = [one for one in element.findall("rgb") if one.get("name") == name]
        return self.triple(found[0].get("value"), where, 0.0, _BRIGHTEST) if found else usual

    def number(self, element: Element, name: str, where: str, usual: float) -> float:
        found = [one for one in element.findall("float") if one.get("name") == name]
        if not found:
            return usual
        return self.values([found[0].get("value") or ""], where, 0.0, _BRIGHTEST)[0]

    def triple(self, text: str | None, where: str, least: float, most: float) -> Color:
        words = (text or "").replace(",", " ").split()
        words = words * 3 if len(words) == 1 else words
        if len(words) != 3:
            raise self.error(
                where, f"{(text or '')[:40]!r} is not a colour: three numbers are needed"
            )
        x, y, z = self.values(words, where, least, most)
        return x, y, z

    def values(self, texts: Iterable[str], where: str, least: float, most: float) -> list[float]:
        """Numbers, each finite and between two bounds."""
        found = []
        for text in texts:
            try:
                number = float(text)
            except ValueError:
                raise self.error(where, f"{text[:40]!r} is not a number") from None
            if not least <= number <= most:
                raise self.error(where, f"{text[:40]} is not between {least:g} and {most:g}")
            found.append(number)
        if len(found) not in (1, 2, 3):
            raise self.error(where, f"{len(found)} numbers where three belong")
        return found

    def error(self, where: str, reason: str) -> InputError:
        place = f"{self.path}: {where}" if where else str(self.path)
        return InputError(reason, place=place, remedy="use the file of the release, or correct it")
