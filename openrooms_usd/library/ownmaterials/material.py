"""What a material of the user's own says, in neutral form: by tiles, with its pictures in place."""

import hashlib
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Final

from openrooms_usd import atomic, removal, untrusted
from openrooms_usd.errors import InputError
from openrooms_usd.portable import in_order
from openrooms_usd.usd.shading.surfaces import PreviewSurface, Texture
from openrooms_usd.usd.shading.textures import picture_facts

# The licence of a material whose terms are not stated.
UNKNOWN_LICENCE: Final = "unknown"
# Default reflectance of a dielectric at normal incidence: OpenRooms' value.
F0: Final = 0.05


@dataclass(frozen=True)
class OwnMaterial:
    """A material as its files say it.

    Attributes:
        name: For people.
        surface: Its inputs. Textures have absolute files; their coordinates count tiles.
        size: Metres that one tile covers, along s and t.
        licence: The terms of use that lie beside it, or `UNKNOWN_LICENCE`.
        losses: One sentence for each thing that was assumed, approximated or left out.
    """

    name: str
    surface: PreviewSurface
    size: tuple[float, float] = (1.0, 1.0)
    licence: str = UNKNOWN_LICENCE
    losses: tuple[str, ...] = ()

    @property
    def textures(self) -> dict[str, Texture]:
        """Its textured inputs, by the field of `PreviewSurface`."""
        values = {item.name: getattr(self.surface, item.name) for item in fields(self.surface)}
        return {name: value for name, value in values.items() if isinstance(value, Texture)}

    @cached_property
    def pictures(self) -> Mapping[str, str]:
        """A file name that says the content (12 hexadecimal digits and the suffix), by its file.

        Equal pictures have equal names, whatever they are called and wherever they lie.
        """
        files = sorted({texture.file for texture in self.textures.values()})
        return {file: _content_name(Path(file)) for file in files}

    @cached_property
    def identifier(self) -> str:
        """A prim name: the material's, and 8 hexadecimal digits of all that determines it."""
        said = repr((self.in_metres(""), self.size, self.licence))
        word = re.sub(r"\W+", "_", self.name, flags=re.ASCII).strip("_").lower() or "material"
        digest = hashlib.sha256(said.encode()).hexdigest()[:8]
        return f"own_{word}_{digest}"

    def in_metres(self, folder: str, *, across: bool = False) -> PreviewSurface:
        """The surface for texture coordinates in metres.

        Args:
            folder: Where its `pictures` lie, as it shall stand in the layer.
            across: Whether it is turned by 90 degrees counter-clockwise, so that what ran along t
                runs along s.
        """
        placed = {
            name: replace(
                _in_metres(texture, self.size, across),
                file=f"{folder}/{self.pictures[texture.file]}",
            )
            for name, texture in self.textures.items()
        }
        return replace(self.surface, **placed)  # type: ignore[arg-type]


def _content_name(file: Path) -> str:
    with untrusted.opened(file, "picture") as content:
        digest = hashlib.file_digest(content, "sha256").hexdigest()[:12]
    return f"{digest}{file.suffix.lower()}"


def _in_metres(texture: Texture, size: tuple[float, float], across: bool) -> Texture:
    """Scale the coordinates from tiles to metres, and turn them.

    Coordinates are scaled, then turned. Turned by a right angle first, the scales change places:
    ``R(a) S(x, y) R(90) = R(a) R(90) S(y, x)``.
    """
    along_s, along_t = (
        scale / metres for scale, metres in zip(texture.uv_scale, size, strict=True)
    )
    if not across:
        return replace(texture, uv_scale=(along_s, along_t))
    turned = texture.uv_rotation + 90.0
    return replace(texture, uv_scale=(along_t, along_s), uv_rotation=turned)


def publish(material: OwnMaterial, keep: Callable[[str], Path], folder: str = "textures") -> None:
    """Copy the pictures that are not there yet, each whole or not at all.

    Args:
        material: Its `OwnMaterial.pictures` say which, and under which names.
        keep: Gives the path of a file to be, such as `StepContext.keep`.
        folder: What `keep` is asked for stands below it.

    Raises:
        OutputError: A file cannot be written.
    """
    for file, name in material.pictures.items():
        target = keep(f"{folder}/{name}")
        if not target.is_file():
            with atomic.replacing(target) as beside:
                removal.copy_file(Path(file), beside)


# How many numbers each constant has.
_NUMBERS: Final = {"base_color": 3, "roughness": 1, "metallic": 1}


def from_constants(constants: Mapping[str, Any], *, name: str = "constant") -> OwnMaterial:
    """A material of constants.

    Args:
        constants: ``base_color`` (three numbers, scene-linear Rec.709), ``roughness`` (perceptual)
            and ``metallic``, each within 0 and 1; those that are missing keep the defaults of
            `PreviewSurface`. ``normal`` may be none: there is no other constant normal.
        name: For people.

    Raises:
        InputError: There is an unknown key, or a value that is not valid.
    """
    values = {key: _value(name, key, value) for key, value in constants.items() if key != "normal"}
    if constants.get("normal") not in (None, "none"):
        raise InputError(
            "a constant normal has no effect",
            place=f"{name}.normal",
            remedy="omit it, or give a folder with a normal map",
        )
    return OwnMaterial(name, PreviewSurface(**values, f0=F0))


def _value(name: str, key: str, given: Any) -> Any:
    count = _NUMBERS.get(key)
    if count is None:
        raise InputError(
            f"a material has no {key!r}", place=name, remedy=f"use {', '.join(_NUMBERS)}"
        )
    numbers = [given] if isinstance(given, int | float) else list(given or ())
    fits = len(numbers) == count and all(
        isinstance(n, int | float) and math.isfinite(n) and 0.0 <= n <= 1.0 for n in numbers
    )
    if not fits:
        wanted = "three numbers" if count == 3 else "a number"
        raise InputError(
            f"{given!r} is not {wanted} within 0 and 1",
            place=f"{name}.{key}",
            remedy="colours are scene-linear: 0.18 is a middle grey",
        )
    return float(numbers[0]) if count == 1 else tuple(map(float, numbers))


# Default: the usual width of scanned materials, metres.
ASSUMED_WIDTH_M: Final = 1.0
# The sides that a texture can sensibly have, metres: a weave under a lens, a field from the air.
SMALLEST, LARGEST = 1e-4, 1e4
# Pictures of one material whose proportions differ by more are stretched, which is said.
_EQUAL_PROPORTION: Final = 0.01


def tile_size(
    given: float | tuple[float, float] | None,
    ratio: float,
    stated: tuple[float, float] | None,
    place: Path,
    losses: list[str],
) -> tuple[float, float]:
    """Width and height of a tile in metres.

    Args:
        given: What the user says: the width, or both sides.
        ratio: Height of the pictures by their width.
        stated: What the files say.
        place: The material, for errors.
        losses: Receives what was assumed.

    Raises:
        InputError: It is not a valid size.
    """
    if given is None and stated is None:
        losses.append(f"its size is not stated; {ASSUMED_WIDTH_M:g} m wide is assumed")
    size = given or stated or ASSUMED_WIDTH_M
    width, height = (size, size * ratio) if isinstance(size, int | float) else size
    if not all(math.isfinite(side) and SMALLEST <= side <= LARGEST for side in (width, height)):
        raise InputError(
            f"a tile cannot have {width:g} by {height:g} m",
            place=place,
            remedy=f"give the metres that the pictures cover, {SMALLEST:g} to {LARGEST:g}",
        )
    return float(width), float(height)


def proportions(textures: Mapping[str, Texture], losses: list[str]) -> float:
    """Height of the pictures by their width; those that differ from the base colour are named.

    Raises:
        InputError: A picture cannot be read.
    """
    ratios: dict[str, float] = {}
    for texture in textures.values():
        facts = picture_facts(texture.file)
        # One texel is a constant, of any proportions.
        if (facts.width, facts.height) != (1, 1):
            ratios[texture.file] = facts.height / facts.width
    common = next(iter(ratios.values()), 1.0)
    losses.extend(
        f"{Path(file).name}: its proportions differ from the others'; it is stretched"
        for file, ratio in ratios.items()
        if abs(ratio - common) > _EQUAL_PROPORTION * common
    )
    return common


_FILES: Final = re.compile(r"(licen[cs]e|copying|copyright)([._-].*)?", re.IGNORECASE)
_MOST_BYTES: Final = 65_536
_MOST_LETTERS: Final = 120
_SPDX: Final = re.compile(r"SPDX-License-Identifier:\s*(\S[^\r\n]*)")
# What the usual texts say near their beginning, as SPDX names them; the stricter ones first.
_KNOWN: Final = (
    (r"CC0|creative commons zero|public domain dedication", "CC0-1.0"),
    (r"CC[ -]BY-NC-SA|attribution-noncommercial-sharealike", "CC-BY-NC-SA"),
    (r"CC[ -]BY-NC-ND|attribution-noncommercial-noderiv", "CC-BY-NC-ND"),
    (r"CC[ -]BY-NC|attribution-noncommercial", "CC-BY-NC"),
    (r"CC[ -]BY-SA|attribution-sharealike", "CC-BY-SA"),
    (r"CC[ -]BY|creative commons attribution", "CC-BY"),
    (r"apache license,?\s+version 2\.0|apache-2\.0", "Apache-2.0"),
    (r"\bMIT license\b", "MIT"),
)
_VERSIONED: Final = re.compile(r"CC-BY.*")
_VERSION: Final = re.compile(r"\b([234]\.0)\b")


def licence_files(folder: Path) -> list[Path]:
    """The files of a folder that state a licence; sorted."""
    return in_order(p for p in folder.iterdir() if p.is_file() and _FILES.fullmatch(p.name))


def licence_in(folder: Path) -> str:
    """The licence that a folder states: an SPDX name, the first line of its text, or unknown.

    Raises:
        InputError: The file that states it cannot be read.
    """
    for file in licence_files(folder):
        with untrusted.opened(file, "text", remedy="check its permissions") as content:
            text = untrusted.decoded(content.read(_MOST_BYTES))
        if licence := _name(text):
            return licence
    return UNKNOWN_LICENCE


def _name(text: str) -> str:
    stated = _SPDX.search(text)
    if stated:
        return stated[1].strip()[:_MOST_LETTERS]
    for pattern, name in _KNOWN:
        if re.search(pattern, text[:2000], re.IGNORECASE):
            version = _VERSION.search(text[:2000]) if _VERSIONED.fullmatch(name) else None
            return f"{name}-{version[1]}" if version else name
    lines = (re.sub(r"[\x00-\x1f\x7f]", " ", line).strip() for line in text.splitlines())
    return next((line for line in lines if line), "")[:_MOST_LETTERS]
