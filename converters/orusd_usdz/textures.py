"""The textures of a plain layer: files of few formats in one folder."""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from openrooms_usd import atomic, imagefile, untrusted
from openrooms_usd.colorimetry import srgb_from_linear
from openrooms_usd.errors import InputError
from openrooms_usd.usd import udim
from openrooms_usd.usd.surfaces import Texture
from openrooms_usd.usd.textures import local_file, read_texture

FOLDER = "textures"


@dataclass
class Textures:
    """Copies pictures into a folder beside the layer, each once.

    Attributes:
        home: The folder of the layer.
        endings: The formats that stay as they are; all else is written as PNG of 8 bits.
        losses: What was lost of each picture, in words.
    """

    home: Path
    endings: tuple[str, ...]
    losses: dict[str, str] = field(default_factory=dict)
    _places: dict[tuple[str, bool], str] = field(default_factory=dict)
    _taken: set[str] = field(default_factory=set)

    def placed(self, texture: Texture, *, is_color: bool) -> Texture:
        """A texture as it stands in the layer.

        Args:
            texture: With the path of its file.
            is_color: Whether it is a colour, which is encoded where 8 bits have to do.
        """
        encode = is_color and texture.color_space == "raw" and not self._stays(texture.file)
        key = texture.file, encode
        if key not in self._places:
            self._places[key] = self._write(texture.file, encode)
        space = "sRGB" if encode else texture.color_space
        return replace(texture, file=self._places[key], color_space=space)

    def _stays(self, file: str) -> bool:
        return Path(file.rstrip("]")).suffix.lower() in self.endings and not udim.is_udim(file)

    def _write(self, file: str, encode: bool) -> str:
        stem, ending = Path(file.rstrip("]")).stem, Path(file.rstrip("]")).suffix.lower()
        try:
            if self._stays(file):
                with local_file(file) as local:
                    data = untrusted.read_bytes(local, "picture")
                place = self._name(stem, ending)
                atomic.write_bytes(self.home / place, data)
                return place
            pixels = read_texture(file)
        except InputError as error:
            self.losses[file] = f"{file}: {error.message}; left out"
            return ""
        self.losses[file] = f"{file}: it is a PNG of 8 bits now"
        values = srgb_from_linear(np.clip(pixels, 0.0, 1.0)) if encode else pixels
        codes = np.round(np.clip(np.nan_to_num(values), 0.0, 1.0) * 255.0).astype(np.uint8)
        place = self._name(stem, ".png")
        with atomic.replacing(self.home / place) as beside:
            imagefile.write(beside, codes, "uint8", {"DateTime": "", "oiio:UnassociatedAlpha": 1})
        return place

    def _name(self, stem: str, ending: str) -> str:
        plain = "".join(c if c.isascii() and (c.isalnum() or c in "-_") else "_" for c in stem)
        name, number = f"{plain}{ending}", 1
        while name.lower() in self._taken:
            number += 1
            name = f"{plain}_{number}{ending}"
        self._taken.add(name.lower())
        return f"{FOLDER}/{name}"
