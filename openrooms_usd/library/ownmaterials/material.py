"""What a material of the user's own says, in neutral form: by tiles, with its pictures in place."""

import hashlib
import re
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Final

from openrooms_usd import untrusted
from openrooms_usd.usd.surfaces import PreviewSurface, Texture

# What stands where nobody has said under which terms a material may be used.
UNKNOWN_LICENCE: Final = "unknown"
# What a dielectric reflects at normal incidence where nobody has said: OpenRooms' value.
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
