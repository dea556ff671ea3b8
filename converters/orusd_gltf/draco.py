"""Vertices and triangles packed by Draco: a tenth of their size, with losses."""

from typing import Final

import numpy as np

from openrooms_usd.errors import MissingPackageError
from orusd_gltf.document import Document, Object, described
from orusd_gltf.geometry import Vertices

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
            "compression=draco needs the package DracoPy",
            remedy="pip install openrooms-usd[draco]",
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
