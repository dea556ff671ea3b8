"""A glTF asset while it is made: JSON objects that refer to each other by number, and one buffer.

What is equal is kept once: bytes, accessors, pictures, samplers and textures.
"""

import hashlib
import json
import struct
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.errors import MissingPackageError, OutputError
from orusd_gltf.geometry import Vertices

Object = dict[str, Any]

# Numbers of OpenGL.
_COMPONENTS: Final = {"float32": 5126, "uint32": 5125, "uint16": 5123}
VERTICES: Final = 34962
INDICES: Final = 34963

_MAGIC: Final = b"glTF"
_VERSION: Final = 2
# A GLB file states its length in 32 bits.
_MOST_BYTES: Final = 2**32 - 1


@dataclass
class Document:
    """Gathers what a GLB file holds; `objects` are the arrays of its JSON by their names."""

    objects: dict[str, list[Object]] = field(default_factory=dict)
    roots: list[int] = field(default_factory=list)
    _used: dict[str, bool] = field(default_factory=dict)
    _known: dict[str, int] = field(default_factory=dict)
    _buffer: bytearray = field(default_factory=bytearray)

    def add(self, kind: str, item: Object) -> int:
        """Add an object to an array of the JSON, such as ``nodes``, and return its number."""
        array = self.objects.setdefault(kind, [])
        array.append(item)
        return len(array) - 1

    def shared(self, kind: str, item: Object) -> int:
        """The same where an equal object that was shared before counts as this one."""
        key = kind + json.dumps(item, sort_keys=True)
        if key not in self._known:
            self._known[key] = self.add(kind, item)
        return self._known[key]

    def use(self, extension: str, *, required: bool = False) -> None:
        """Say that an extension is used, and whether the file means nothing without it."""
        self._used[extension] = self._used.get(extension, False) or required

    def view(self, data: bytes, target: int | None = None) -> int:
        """The number of the buffer view that holds these bytes."""
        key = f"bytes {target} {hashlib.sha256(data).hexdigest()}"
        if key not in self._known:
            self._buffer += bytes(-len(self._buffer) % 4)
            item: Object = {"buffer": 0, "byteOffset": len(self._buffer), "byteLength": len(data)}
            self._buffer += data
            self._known[key] = self.add(
                "bufferViews", item | ({"target": target} if target else {})
            )
        return self._known[key]

    def accessor(self, values: NDArray[Any], target: int | None = None) -> int:
        """The number of the accessor that holds an array.

        Args:
            values: (N,) or (N, 2 to 4), float32, uint32 or uint16.
            target: `VERTICES` or `INDICES`, where it is one of these.
        """
        view = {"bufferView": self.view(values.tobytes(), target)}
        return self.shared("accessors", view | described(values))

    def texture(self, data: bytes, mime: str, sampler: Object) -> int:
        """The number of the texture that shows an encoded picture."""
        image = self.shared("images", {"bufferView": self.view(data), "mimeType": mime})
        item: Object = {"sampler": self.shared("samplers", sampler)}
        if mime == "image/webp":
            self.use("EXT_texture_webp", required=True)
            item["extensions"] = {"EXT_texture_webp": {"source": image}}
        else:
            item["source"] = image
        return self.shared("textures", item)

    def glb(self) -> bytes:
        """The whole file; the same objects give the same bytes.

        Raises:
            OutputError: It is larger than the format allows.
        """
        text: Object = {"asset": {"version": "2.0", "generator": "openrooms_usd"}}
        used = sorted(self._used)
        required = [name for name in used if self._used[name]]
        text |= {"extensionsUsed": used} if used else {}
        text |= {"extensionsRequired": required} if required else {}
        text |= {"scene": 0, "scenes": [{"name": "Scene", "nodes": self.roots}]}
        if not self.roots:
            text["scenes"] = [{"name": "Scene"}]
        lights = self.objects.pop("lights", None)
        if lights:
            text["extensions"] = {"KHR_lights_punctual": {"lights": lights}}
        text |= {name: self.objects[name] for name in sorted(self.objects)}
        chunks = []
        if self._buffer:
            text["buffers"] = [{"byteLength": len(self._buffer)}]
            chunks = [_chunk(b"BIN\0", bytes(self._buffer), b"\0")]
        said = json.dumps(text, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
        body = _chunk(b"JSON", said.encode(), b" ") + b"".join(chunks)
        if len(body) + 12 > _MOST_BYTES:
            raise OutputError(
                "a GLB file cannot be larger than 4 GiB",
                remedy="use smaller textures, or export parts of the stage",
            )
        return struct.pack("<4sII", _MAGIC, _VERSION, len(body) + 12) + body


def described(values: NDArray[Any]) -> Object:
    """What an accessor says of an array; positions and the like with their bounds."""
    kind = "SCALAR" if values.ndim == 1 else f"VEC{values.shape[1]}"
    item: Object = {
        "componentType": _COMPONENTS[str(values.dtype)],
        "count": len(values),
        "type": kind,
    }
    if kind == "VEC3" and len(values):
        item |= {"min": values.min(axis=0).tolist(), "max": values.max(axis=0).tolist()}
    return item


def _chunk(kind: bytes, data: bytes, padding: bytes) -> bytes:
    data += padding * (-len(data) % 4)
    return struct.pack("<I4s", len(data), kind) + data


def number(value: float) -> float:
    """A number as it stands in the JSON: nine digits are all that single precision holds."""
    return float(f"{value:.9g}") + 0.0


def numbers(values: Any) -> list[float]:
    """Several of them."""
    return [number(float(value)) for value in np.asarray(values).ravel()]


EXTENSION: Final = "KHR_draco_mesh_compression"

# Bits of each coordinate: of a wall of 8 m half a millimetre.
_POSITION_BITS: Final = 14
_NORMAL_BITS: Final = 10
# Coordinates of tiled textures run over many tiles.
_TEXTURE_BITS: Final = 16
_LEVEL: Final = 7
# Numbers of what Draco has no name for.
_FURTHER: Final = 100
# Draco's kinds of attributes.
_KINDS: Final = {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 3}


def packed_primitive(document: Document, found: Vertices) -> Object:
    """A primitive's attributes and indices, whose data only Draco's readers can take.

    Tangents are left out: readers make their own.

    Raises:
        MissingPackageError: DracoPy is not installed.
    """
    try:
        import DracoPy
    except ImportError as error:
        raise MissingPackageError(
            "compression=draco needs the package DracoPy", remedy="pip install openrooms-usd[draco]"
        ) from error
    given = {name: values for name, values in found.attributes.items() if name != "TANGENT"}
    further = {
        _FURTHER + number: given[name]
        for number, name in enumerate(name for name in given if name not in _KINDS)
    }
    texture = given.get("TEXCOORD_0")
    data = DracoPy.encode(
        given["POSITION"],
        found.indices.reshape(-1, 3).astype(np.uint32),
        quantization_bits=_POSITION_BITS,
        compression_level=_LEVEL,
        normals=given["NORMAL"].astype(np.float64),
        normal_quantization_bits=_NORMAL_BITS,
        tex_coord=None if texture is None else texture.astype(np.float64),
        tex_coord_quantization_bits=None if texture is None else _TEXTURE_BITS,
        generic_attributes=further or None,
    )
    # What readers will find: Draco may cut vertices apart, and moves them a little.
    read = DracoPy.decode(data)
    numbers = {item["attribute_type"]: item for item in read.attributes}
    named = {name: numbers[kind] for name, kind in _KINDS.items() if name in given}
    others = [name for name in given if name not in _KINDS]
    for name, item in zip(others, sorted(further), strict=True):
        named[name] = read.get_attribute_by_unique_id(item)
    attributes: Object = {}
    for name, item in named.items():
        values = np.asarray(item["data"], dtype=np.float32)
        attributes[name] = document.shared("accessors", described(values))
    indices = np.asarray(read.faces, dtype=np.uint32).ravel()
    document.use(EXTENSION, required=True)
    ids = {name: int(item["unique_id"]) for name, item in named.items()}
    said = {"bufferView": document.view(bytes(data)), "attributes": ids}
    return {
        "attributes": attributes,
        "indices": document.shared("accessors", described(indices)),
        "extensions": {EXTENSION: said},
    }
